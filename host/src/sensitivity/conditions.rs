//! The closure conditions of the whole sheet, linearised at a configuration: their Jacobians by fold angles (J) and by the
//! vertices of the pattern (K), as sparse blocks of three rows.

use foldpath_core::{HalfAngle, Spoke, closure, hole, plane_angle};
use foldpath_linear::cholesky::Factor;
use foldpath_linear::gram::GramStructure;
use nalgebra::{DMatrix, Vector2, Vector3};

use crate::pattern::{CreasePattern, EdgeId, VertexId};
use crate::symmetry::ReducedStars;
use crate::util::csr::Csr;

/// Sparse blocks of three rows: for each block its columns, each with the number of its unknown.
pub(super) type Blocks = Csr<(u32, Vector3<f64>)>;

/// Damping of the normal equations over their largest diagonal entry: far below the square of any singular value that counts
/// as regular, and above the rounding of the factor.
const DAMPING_RATIO: f64 = 1e-12;
/// Largest number of corrections of a least-squares solution.
const MAX_CORRECTIONS: usize = 12;
/// Relative size of a correction that ends them.
const CORRECTED_RATIO: f64 = 1e-14;

/// Number of right sides that are solved for at once.
const COLUMNS: usize = 4;

/// The closure conditions of a sheet in which every crease turns by itself. Made once for each sheet.
pub struct Conditions<'a> {
    pub(super) pattern: &'a CreasePattern,
    stars: ReducedStars,
    /// JᵀJ, with a block for each star, then two for each loop.
    gram: GramStructure,
    /// For each star and each loop, the edge of each spoke, and the vertex from which the spoke is directed.
    spokes: Csr<(EdgeId, VertexId)>,
}

/// The conditions at a configuration.
pub(super) struct Linearised {
    /// Residuals of the blocks.
    pub(super) residuals: Vec<Vector3<f64>>,
    /// J: columns by fold angles, per radian.
    pub(super) by_angle: Blocks,
    /// K: columns by the coordinates of the pattern's vertices, 2 v for x of vertex v and 2 v + 1 for y.
    pub(super) by_vertex: Blocks,
}

/// JᵀJ with a small damping, factorised.
pub(super) struct NormalFactor<'c> {
    gram: &'c GramStructure,
    factor: Factor,
}

impl<'a> Conditions<'a> {
    /// Finds the conditions of a sheet. Returns `None` if it has too many creases to number their products.
    #[must_use]
    pub fn new(pattern: &'a CreasePattern) -> Option<Self> {
        let stars = ReducedStars::of_creases(pattern);
        let start = |spoke: &Spoke<f64>| {
            let edge = pattern.creases()[spoke.group.index()];
            let ends = pattern.edge(edge).ends;
            let forwards = Vector2::from(spoke.direction).dot(&pattern.direction(edge, ends[0]));
            (edge, ends[usize::from(forwards < 0.0)])
        };
        let of_stars = stars.view();
        let of_loops = stars.loops();
        let cycles = of_stars.iter().map(|star| star.spokes);
        let cycles = cycles.chain(of_loops.iter().map(|cycle| cycle.spokes));
        let spokes = cycles.map(|cycle| cycle.iter().map(start).collect::<Vec<_>>());
        let spokes: Csr<_> = spokes.collect();
        let groups = |spokes: &[Spoke<f64>]| spokes.iter().map(|s| s.group.0).collect::<Vec<_>>();
        let blocks = of_stars.iter().map(|star| groups(star.spokes));
        let doubled = of_loops
            .iter()
            .flat_map(|cycle| [groups(cycle.spokes), groups(cycle.spokes)]);
        let blocks: Csr<u32> = blocks.chain(doubled).collect();
        let gram = GramStructure::new(pattern.creases().len(), &blocks)?;
        Some(Self {
            pattern,
            gram,
            spokes,
            stars,
        })
    }

    /// Returns the sheet.
    #[must_use]
    pub fn pattern(&self) -> &'a CreasePattern {
        self.pattern
    }

    /// Returns for each star, then for each loop, the edge of each spoke in order, with the vertex from which the spoke is
    /// directed.
    pub(super) fn spokes(&self) -> &Csr<(EdgeId, VertexId)> {
        &self.spokes
    }

    /// Returns the stars and loops.
    pub(super) fn stars(&self) -> &ReducedStars {
        &self.stars
    }

    /// Returns K at fold angles (radians, one for each crease): for each vertex that has a condition, then two for each hole,
    /// three rows, whose entries have the number of a coordinate: 2 v for x of vertex v of the pattern, 2 v + 1 for y. The order
    /// is that of [`ReducedStars::of_creases`]. `None` if there are too few angles.
    #[must_use]
    pub fn by_vertices(&self, angles: &[f64]) -> Option<Csr<(u32, Vector3<f64>)>> {
        Some(self.at(angles)?.by_vertex)
    }

    /// Linearises the conditions at fold angles (radians, one for each crease). `None` if there are too few angles.
    pub(super) fn at(&self, angles: &[f64]) -> Option<Linearised> {
        let mut half = vec![HalfAngle::default(); angles.len()];
        closure::half_angles(angles, &mut half);
        let mut found = Linearised {
            residuals: Vec::new(),
            by_angle: Csr::default(),
            by_vertex: Csr::default(),
        };
        let unknown = |spoke: &Spoke<f64>| spoke.group.0;
        let mut spokes = self.spokes.iter();
        for star in self.stars.view().iter() {
            let mut columns = vec![Vector3::zeros(); star.spokes.len()];
            let residual = closure::residual_and_jacobian(star, &half, &mut columns)?;
            found.residuals.push(residual);
            let unknowns = star.spokes.iter().map(unknown);
            found.by_angle.push(unknowns.zip(columns.iter().copied()));
            plane_angle::star_columns(star, &half, &mut columns)?;
            let turned = spokes.next()?.iter().zip(columns);
            let columns = turned
                .flat_map(|(&(edge, from), column)| turning(self.pattern, edge, from, column));
            found.by_vertex.push(columns);
        }
        for (cycle, &number) in self.stars.loops().iter().zip(self.stars.holes()) {
            let count = cycle.spokes.len();
            let mut columns = vec![Vector3::zeros(); 2 * count];
            let [turned, moved] = hole::residuals_and_jacobian(cycle, &half, &mut columns)?;
            found.residuals.extend([turned, moved]);
            for part in columns.chunks(count) {
                let unknowns = cycle.spokes.iter().map(unknown);
                found.by_angle.push(unknowns.zip(part.iter().copied()));
            }
            let mut columns = vec![plane_angle::LoopColumn::default(); count];
            plane_angle::loop_columns(cycle, &half, &mut columns)?;
            let (_, size) = self.pattern.hole_frame(number);
            let edges = spokes.next()?;
            let turns = edges
                .iter()
                .zip(&columns)
                .flat_map(|(&(edge, from), column)| turning(self.pattern, edge, from, column.turn));
            found.by_vertex.push(turns);
            let passed = self.pattern.holes()[number].iter();
            let passed = passed.filter(|passage| self.pattern.edge(passage.edge).crease.is_some());
            let shifts = edges.iter().zip(&columns).zip(passed).flat_map(
                |((&(edge, from), column), passage)| {
                    let moves = turning(self.pattern, edge, from, column.turn_moves);
                    let along = self.pattern.direction(edge, from);
                    let left = Vector2::new(-along.y, along.x) / size;
                    let shift = by_coordinates(passage.at, left, column.shift);
                    moves.into_iter().chain(shift)
                },
            );
            found.by_vertex.push(shifts.collect::<Vec<_>>());
        }
        Some(found)
    }

    /// Factorises JᵀJ. `None` if it holds no numbers.
    pub(super) fn factorise(&self, by_angle: &Blocks) -> Option<NormalFactor<'_>> {
        let mut values = vec![0.0; self.gram.entries];
        for (block, columns) in by_angle.iter().enumerate() {
            let product = |a: &(u32, Vector3<f64>), b: &(u32, Vector3<f64>)| a.1.dot(&b.1);
            self.gram.add(block, columns, product, &mut values);
        }
        let damping = DAMPING_RATIO * self.gram.max_diagonal(&values).max(1.0);
        let mut factor = Factor::new(&self.gram.symbolic);
        let symbolic = &self.gram.symbolic;
        let made = symbolic.factorise(&values, damping, &mut factor, &|| false);
        made.then_some(NormalFactor {
            gram: &self.gram,
            factor,
        })
    }
}

impl NormalFactor<'_> {
    /// Replaces a right side by the solution of the damped equations.
    pub(super) fn solve(&mut self, right_side: &mut [f64]) {
        self.gram.symbolic.solve(&mut self.factor, right_side);
    }

    /// Replaces right sides, the columns of a matrix, by the solutions of the damped equations, a few of them at once.
    pub(super) fn solve_columns(&mut self, right_sides: &mut DMatrix<f64>) {
        let mut some = vec![[0.0; COLUMNS]; right_sides.nrows()];
        for first in (0..right_sides.ncols()).step_by(COLUMNS) {
            let count = COLUMNS.min(right_sides.ncols() - first);
            let mut columns = right_sides.columns_mut(first, count);
            for (row, numbers) in some.iter_mut().enumerate() {
                (0..count).for_each(|column| numbers[column] = columns[(row, column)]);
            }
            self.gram.symbolic.solve_many(&mut self.factor, &mut some);
            for (row, numbers) in some.iter().enumerate() {
                (0..count).for_each(|column| columns[(row, column)] = numbers[column]);
            }
        }
    }

    /// Returns x orthogonal to the null space with JᵀJ x = `right_side`, of which the part in the null space is left out.
    ///
    /// Damped solutions are corrected until the damping has no effect (iterated Tikhonov regularisation).
    pub(super) fn pseudo_solve(
        &mut self,
        by_angle: &Blocks,
        right_side: &[f64],
        project: impl Fn(&mut [f64]),
    ) -> Vec<f64> {
        let mut x = vec![0.0; right_side.len()];
        for _ in 0..MAX_CORRECTIONS {
            let product = transposed(by_angle, &times(by_angle, &x), x.len());
            let left = right_side.iter().zip(product);
            let mut correction: Vec<f64> = left.map(|(b, product)| b - product).collect();
            project(&mut correction);
            self.solve(&mut correction);
            project(&mut correction);
            x.iter_mut().zip(&correction).for_each(|(x, c)| *x += c);
            if length(&correction) <= CORRECTED_RATIO * length(&x) {
                break;
            }
        }
        x
    }
}

/// Returns the columns by the coordinates of the ends of an edge, of which the one by the edge's plane angle is given.
fn turning(
    pattern: &CreasePattern,
    edge: EdgeId,
    from: VertexId,
    column: Vector3<f64>,
) -> Vec<(u32, Vector3<f64>)> {
    let turns = plane_angle_by_ends(pattern, edge, from);
    let columns = turns.into_iter();
    columns
        .flat_map(|(vertex, by)| by_coordinates(vertex, by, column))
        .collect()
}

/// Returns the gradient of the plane angle of an edge by each of its ends, radians per unit of length. The angle is that of the
/// direction from the vertex `from`; it changes alike from the other end.
pub(super) fn plane_angle_by_ends(
    pattern: &CreasePattern,
    edge: EdgeId,
    from: VertexId,
) -> [(VertexId, Vector2<f64>); 2] {
    let ends = pattern.edge(edge).ends;
    let along = pattern.direction(edge, from);
    let by = Vector2::new(-along.y, along.x) / pattern.length(ends);
    [(from, -by), (pattern.edge(edge).other_end(from), by)]
}

/// Returns the columns by both coordinates of a vertex of what has this column and this gradient by the vertex.
fn by_coordinates(
    vertex: VertexId,
    by: Vector2<f64>,
    column: Vector3<f64>,
) -> [(u32, Vector3<f64>); 2] {
    [
        (2 * vertex.0, column * by.x),
        (2 * vertex.0 + 1, column * by.y),
    ]
}

/// Returns the product of a sparse matrix and a vector.
pub(super) fn times(blocks: &Blocks, x: &[f64]) -> Vec<Vector3<f64>> {
    let rows = blocks.iter().map(|columns| {
        let terms = columns.iter();
        terms.fold(Vector3::zeros(), |sum, (unknown, column)| {
            sum + column * x[*unknown as usize]
        })
    });
    rows.collect()
}

/// Returns the norm of the product of a sparse matrix and a vector if no terms cancelled.
pub(super) fn magnitude(blocks: &Blocks, x: &[f64]) -> f64 {
    let rows = blocks.iter().map(|columns| {
        let terms = columns.iter();
        let terms = terms.map(|(unknown, column)| column.norm() * x[*unknown as usize].abs());
        terms.sum::<f64>().powi(2)
    });
    rows.sum::<f64>().sqrt()
}

/// Returns the product of the transpose of a sparse matrix of `n` columns and a vector.
pub(super) fn transposed(blocks: &Blocks, y: &[Vector3<f64>], n: usize) -> Vec<f64> {
    let mut product = vec![0.0; n];
    for (columns, y) in blocks.iter().zip(y) {
        for (unknown, column) in columns {
            product[*unknown as usize] += column.dot(y);
        }
    }
    product
}

/// Returns the Euclidean norm.
pub(super) fn length(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}
