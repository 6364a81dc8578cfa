//! Sparse normal equations: a sparse Cholesky factorisation behind core's trait, for sheets whose every crease is an
//! unknown.
//!
//! The places of the entries of JᵀJ and the elimination order are found once, by
//! [`GramStructure`]; all else is arithmetic. The matrix is assembled from the rows of J only when it is factorised.

use std::sync::{Arc, OnceLock};

use foldpath_core::least_squares::{Accumulate, Gradient, NormalEquations};
use foldpath_core::{LoopsView, Spoke, StarsView};
use foldpath_linear::cholesky::Factor;
use foldpath_linear::gram::GramStructure;
use nalgebra::Vector3;

use crate::progress::Watch;
use crate::util::csr::{Csr, group_by_key};

/// Fraction of its lower bound below which a diagonal entry of the inverse has lost too much to rounding.
const MIN_DIAGONAL_RATIO: f64 = 0.5;

/// JᵀJ as the lower triangle of a matrix in compressed sparse columns, with its Cholesky factor.
pub struct SparseNormalEquations<'a> {
    structure: Arc<Structure>,
    values: Vec<f64>,
    gradient: Vec<f64>,
    /// The columns of each block of rows, as last accumulated.
    jacobian: Csr<Vector3<f64>>,
    /// `true` if `values` are made of the present columns.
    assembled: bool,
    /// Unknowns fixed since the factor was made, each with the unknown's column of the inverse at that time.
    fixed: Vec<(usize, Vec<f64>)>,
    /// Memory of columns that are no longer needed.
    spare: Vec<Vec<f64>>,
    factor: Factor,
    /// Once it is over, there are no factors any more.
    watch: Watch<'a>,
}

/// Sparse structure of the equations of some stars and loops, which does not depend on the angles.
pub(crate) struct Structure {
    /// JᵀJ, with a block for each star, then each loop.
    gram: GramStructure,
    /// Number of stars.
    stars: usize,
    /// For each star, then each loop, the unknowns of its spokes.
    unknowns: Csr<u32>,
    /// For each unknown, the blocks of rows that have it, once they were asked for.
    touching: OnceLock<Csr<u32>>,
}

impl<'a> SparseNormalEquations<'a> {
    /// Finds the sparse structure and the elimination order. Returns `None` if there are too many entries to number them
    /// in 31 bits.
    #[must_use]
    pub fn new(stars: StarsView<'_, f64>, loops: LoopsView<'_, f64>) -> Option<Self> {
        let structure = Structure::new(stars, loops)?;
        Some(Self::of(Arc::new(structure), Watch::default()))
    }

    /// Makes equations of this structure.
    pub(crate) fn of(structure: Arc<Structure>, watch: Watch<'a>) -> Self {
        let gram = &structure.gram;
        Self {
            values: vec![0.0; gram.entries],
            gradient: vec![0.0; gram.diagonal.len()],
            jacobian: Csr::default(),
            assembled: false,
            fixed: Vec::new(),
            spare: Vec::new(),
            factor: Factor::new(&gram.symbolic),
            structure,
            watch,
        }
    }
}

impl Structure {
    /// Finds the sparse structure and the elimination order. Returns `None` if there are too many entries to number them
    /// in 31 bits.
    pub(crate) fn new(stars: StarsView<'_, f64>, loops: LoopsView<'_, f64>) -> Option<Self> {
        let cycles = stars.iter().map(|star| star.spokes);
        let cycles = cycles.chain(loops.iter().map(|l| l.spokes));
        let unknowns = cycles.map(|spokes| spokes.iter().map(|spoke| spoke.group.0));
        let unknowns: Csr<u32> = unknowns.collect();
        Some(Self {
            gram: GramStructure::new(stars.unknowns(), &unknowns)?,
            stars: stars.len(),
            unknowns,
            touching: OnceLock::new(),
        })
    }

    /// Returns the unknowns of the columns of a block of rows.
    fn of_block(&self, block: usize) -> &[u32] {
        &self.unknowns[self.number(block)]
    }

    /// Returns the number of the star or loop that a block of rows belongs to; a loop has two blocks.
    fn number(&self, block: usize) -> usize {
        let past = block.saturating_sub(self.stars);
        block - past + past / 2
    }

    /// Returns, for each unknown, the blocks of rows that have it, once for each of its columns in the block.
    fn touching(&self) -> &Csr<u32> {
        self.touching.get_or_init(|| {
            let loops = self.unknowns.len() - self.stars;
            let blocks = (0..self.stars + 2 * loops).zip(0..);
            let pairs = blocks.flat_map(|(block, number)| {
                let unknowns = self.of_block(block).iter();
                unknowns.map(move |&unknown| (unknown as usize, number))
            });
            group_by_key(self.gram.diagonal.len(), pairs)
        })
    }
}

impl SparseNormalEquations<'_> {
    /// Assembles JᵀJ from the columns, unless it is assembled.
    fn assemble(&mut self) {
        if core::mem::replace(&mut self.assembled, true) {
            return;
        }
        self.values.fill(0.0);
        for (block, columns) in self.jacobian.iter().enumerate() {
            let number = self.structure.number(block);
            let gram = &self.structure.gram;
            gram.add(number, columns, Vector3::dot, &mut self.values);
        }
    }
}

impl Accumulate<f64> for SparseNormalEquations<'_> {
    fn clear(&mut self) {
        self.gradient.fill(0.0);
        self.jacobian.clear();
        self.assembled = false;
    }

    fn add(
        &mut self,
        star: usize,
        spokes: &[Spoke<f64>],
        columns: &[Vector3<f64>],
        residual: &Vector3<f64>,
    ) {
        self.jacobian.push(columns.iter().copied());
        Gradient(&mut self.gradient).add(star, spokes, columns, residual);
    }
}

impl NormalEquations<f64> for SparseNormalEquations<'_> {
    const KEEPS_ROWS: bool = true;

    fn clear_residuals(&mut self) {
        self.gradient.fill(0.0);
    }

    fn add_residual(&mut self, block: usize, spokes: &[Spoke<f64>], residual: &Vector3<f64>) {
        Gradient(&mut self.gradient).add(block, spokes, &self.jacobian[block], residual);
    }

    fn unknowns(&self) -> usize {
        self.gradient.len()
    }

    fn gradient(&self) -> &[f64] {
        &self.gradient
    }

    fn max_diagonal(&mut self) -> f64 {
        self.assemble();
        self.structure.gram.max_diagonal(&self.values)
    }

    fn fix_unknown(&mut self, unknown: usize, by: f64) -> f64 {
        self.assembled = false;
        let mut growth = self.gradient[unknown] * by;
        for &block in &self.structure.touching()[unknown] {
            let unknowns = self.structure.of_block(block as usize);
            let columns = &mut self.jacobian[block as usize];
            let mut change = Vector3::zeros();
            for (column, &k) in columns.iter_mut().zip(unknowns) {
                if k as usize == unknown {
                    change += core::mem::take(column) * by;
                }
            }
            for (column, &k) in columns.iter().zip(unknowns) {
                self.gradient[k as usize] += column.dot(&change);
            }
            growth += 0.5 * change.norm_squared();
        }
        self.gradient[unknown] = 0.0;
        growth
    }

    fn fix_in_factor(&mut self, unknown: usize) -> bool {
        let mut column = self.spare.pop().unwrap_or_default();
        column.clear();
        column.resize(self.gradient.len(), 0.0);
        column[unknown] = 1.0;
        self.solve(&mut column);
        // A diagonal entry of the inverse of a positive definite matrix is at least the inverse of the matrix's entry.
        // If it is less, it is rounding.
        let diagonal = self.values[self.structure.gram.diagonal[unknown] as usize];
        let sound = column[unknown] * diagonal >= MIN_DIAGONAL_RATIO;
        self.fixed.push((unknown, column));
        sound
    }

    fn factorise(&mut self, damping: f64) -> bool {
        self.assemble();
        let columns = self.fixed.drain(..).map(|(_, column)| column);
        self.spare.extend(columns);
        let symbolic = &self.structure.gram.symbolic;
        let watch = self.watch;
        symbolic.factorise(&self.values, damping, &mut self.factor, &|| watch.is_over())
    }

    fn solve(&mut self, right_side: &mut [f64]) {
        let symbolic = &self.structure.gram.symbolic;
        symbolic.solve(&mut self.factor, right_side);
        // Schur complement: each fixed unknown is taken out of the solution along its column of the inverse.
        for (unknown, column) in &self.fixed {
            let part = right_side[*unknown] / column[*unknown];
            for (entry, &column) in right_side.iter_mut().zip(column) {
                *entry -= part * column;
            }
            right_side[*unknown] = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use foldpath_core::least_squares::ClosureProblem;
    use foldpath_core::{DenseNormalEquations, HalfAngle};
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::generate::Waterbomb;
    use crate::pattern::{CreasePattern, Letter};
    use crate::symmetry::{CreaseGroups, ReducedStars};

    /// Returns `n` angles of up to six times the step.
    fn angles(n: usize, step: f64) -> Vec<f64> {
        let angle = |k| f64::from(u8::try_from(k % 7).unwrap()) * step;
        (0..n).map(angle).collect()
    }

    fn with_problem<R>(
        reduced: &ReducedStars,
        run: impl FnOnce(&mut ClosureProblem<'_, f64>) -> R,
    ) -> R {
        let (stars, loops) = (reduced.view(), reduced.loops());
        let mut half = vec![HalfAngle::default(); stars.unknowns()];
        let mut columns = vec![Vector3::zeros(); ClosureProblem::columns(stars, loops)];
        let problem = ClosureProblem::with_loops(stars, loops, &mut half, &mut columns);
        run(&mut problem.unwrap())
    }

    /// Returns the gradient, and the solution after one unknown is held, of either kind of equations.
    fn results(equations: &mut impl NormalEquations<f64>, reduced: &ReducedStars) -> Vec<f64> {
        let n = equations.unknowns();
        with_problem(reduced, |problem| {
            problem.linearise(&angles(n, 0.3), equations)
        })
        .unwrap();
        let mut results = equations.gradient().to_vec();
        results.push(equations.max_diagonal());
        results.push(equations.fix_unknown(n / 2, 0.3));
        results.extend_from_slice(equations.gradient());
        let mut solution = vec![1.0; n];
        assert!(equations.factorise(0.1));
        equations.solve(&mut solution);
        results.extend(solution);
        // Damping is not left in the matrix.
        assert!(equations.factorise(0.2) && equations.factorise(0.1));
        let mut again = vec![1.0; n];
        equations.solve(&mut again);
        results.extend(again);
        results
    }

    /// Makes a sheet with a hole. With symmetry, spokes of a star share unknowns; without, most unknowns are far apart.
    fn cut_waterbomb() -> [ReducedStars; 2] {
        let waterbomb = Waterbomb {
            rows: 4,
            columns: 6,
            fold: 0.5,
        };
        let mut drawing = waterbomb.drawing().unwrap();
        let whole = CreasePattern::new(drawing.clone()).unwrap();
        // A cut through the vertex in the middle, which is a hole.
        let star = &whole.stars()[whole.vertices().len() / 2];
        for edge in [star[0], star[2]] {
            drawing.edges[edge.index()].letter = Letter::Cut;
        }
        let pattern = CreasePattern::new(drawing).unwrap();
        assert_eq!(pattern.holes().len(), 1);
        let groups = [
            CreaseGroups::find(&pattern),
            CreaseGroups::trivial(&pattern),
        ];
        groups.map(|groups| ReducedStars::all(&pattern, &groups))
    }

    #[test]
    fn sparse_equations_are_the_dense_ones() {
        for stars in cut_waterbomb() {
            let n = stars.view().unknowns();
            let mut memory = vec![0.0; DenseNormalEquations::<f64>::memory(n)];
            let mut dense = DenseNormalEquations::new(n, &mut memory).unwrap();
            let mut sparse = SparseNormalEquations::new(stars.view(), stars.loops()).unwrap();
            let [dense, sparse] = [results(&mut dense, &stars), results(&mut sparse, &stars)];
            for (k, (dense, sparse)) in dense.iter().zip(&sparse).enumerate() {
                assert!(
                    (dense - sparse).abs() <= 1e-12,
                    "{n} unknowns, {k}: {dense} {sparse}"
                );
            }
        }
    }

    /// The Jacobian, each block of rows below the one before.
    struct Rows(DMatrix<f64>);

    impl Accumulate<f64> for Rows {
        fn clear(&mut self) {
            *self = Self(DMatrix::zeros(0, self.0.ncols()));
        }

        fn add(
            &mut self,
            _star: usize,
            spokes: &[Spoke<f64>],
            columns: &[Vector3<f64>],
            _residual: &Vector3<f64>,
        ) {
            let row = self.0.nrows();
            let rows = core::mem::take(&mut self.0);
            self.0 = rows.insert_rows(row, 3, 0.0);
            for (spoke, column) in spokes.iter().zip(columns) {
                let mut place = self.0.fixed_view_mut::<3, 1>(row, spoke.group.index());
                place += column;
            }
        }
    }

    #[test]
    fn old_rows_take_new_residuals() {
        for reduced in cut_waterbomb() {
            let mut sparse = SparseNormalEquations::new(reduced.view(), reduced.loops()).unwrap();
            let n = sparse.unknowns();
            let [before, after] = [0.3, 0.1].map(|step| angles(n, step));
            let mut rows = Rows(DMatrix::zeros(0, n));
            let mut residuals = Vec::new();
            with_problem(&reduced, |problem| {
                problem.linearise(&before, &mut rows).unwrap();
                problem.linearise(&before, &mut sparse).unwrap();
                let cost = problem.each_residual(&after, |_, r| residuals.extend(r.iter()));
                assert_eq!(problem.update_residuals(&after, &mut sparse), cost);
            });
            let expected = rows.0.tr_mul(&DVector::from_vec(residuals));
            let same = |a: &[f64], b: &DVector<f64>| {
                let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
                assert!(a.len() == b.len() && apart.fold(0.0, f64::max) <= 1e-13);
            };
            same(sparse.gradient(), &expected);
            // The step for the residual at `after`, with the factor of the rows at `before`.
            assert!(sparse.factorise(0.1));
            let mut step = vec![0.0; n];
            sparse.step(&mut step);
            let damped = rows.0.tr_mul(&rows.0) + DMatrix::identity(n, n) * 0.1;
            same(&step, &damped.cholesky().unwrap().solve(&-expected));
        }
    }

    /// Fixes unknowns that are far apart, and all but one of a star, which the closure of that star couples.
    #[test]
    fn a_factor_with_fixed_unknowns_is_that_of_the_others() {
        for reduced in cut_waterbomb() {
            let mut sparse = SparseNormalEquations::new(reduced.view(), reduced.loops()).unwrap();
            let n = sparse.unknowns();
            let star = sparse.structure.of_block(0).iter().skip(1);
            let star = star.map(|&k| k as usize).collect();
            for mut held in [vec![0, n / 2, n - 1], star] {
                held.sort_unstable();
                held.dedup();
                for damping in [1e-1, 1e-4, 1e-8, 1e-12] {
                    with_problem(&reduced, |problem| {
                        problem.linearise(&angles(n, 0.3), &mut sparse)
                    })
                    .unwrap();
                    assert!(sparse.factorise(damping));
                    for &unknown in &held {
                        sparse.fix_unknown(unknown, 0.1);
                        assert!(sparse.fix_in_factor(unknown));
                    }
                    let [mut fixed, mut anew] = [vec![0.0; n], vec![0.0; n]];
                    sparse.step(&mut fixed);
                    // Nothing is left of an unknown that was taken out.
                    assert!(!sparse.fix_in_factor(held[0]));
                    assert!(sparse.factorise(damping));
                    sparse.step(&mut anew);
                    let size = anew
                        .iter()
                        .fold(0.0, |most: f64, step| most.max(step.abs()));
                    for (k, (fixed, anew)) in fixed.iter().zip(&anew).enumerate() {
                        let apart = (fixed - anew).abs() / size;
                        assert!(
                            apart <= 1e-13 + 1e-15 / damping,
                            "{n} {held:?} {damping} {k}: {apart:e}"
                        );
                        assert!(*fixed == 0.0 || !held.contains(&k));
                    }
                }
            }
        }
    }
}
