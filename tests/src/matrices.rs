//! The report's folding matrices as 4x4 products, written out and without foldpath's: closure round
//! vertices with places, its derivatives, and faces laid along another tree than [`Sheet::fold`]'s.

use nalgebra::{Matrix3, Matrix4, Vector2, Vector3};

use crate::{Sheet, worst};

/// A move within the plane of the sheet and a turn about its normal: A B(α) of the report.
fn frame(place: Vector2<f64>, [cos, sin]: [f64; 2]) -> Matrix4<f64> {
    Matrix4::new(
        cos, -sin, 0.0, place.x, //
        sin, cos, 0.0, place.y, //
        0.0, 0.0, 1.0, 0.0, //
        0.0, 0.0, 0.0, 1.0,
    )
}

/// C(ρ), about the x axis, of the angle's cosine and sine.
fn about_x(cos: f64, sin: f64) -> Matrix4<f64> {
    Matrix4::new(
        1.0, 0.0, 0.0, 0.0, //
        0.0, cos, -sin, 0.0, //
        0.0, sin, cos, 0.0, //
        0.0, 0.0, 0.0, 1.0,
    )
}

/// A crease as a line of the flat sheet: a place on it and its unit direction.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// A place on it.
    pub place: Vector2<f64>,
    /// Its unit direction.
    pub direction: [f64; 2],
}

impl Line {
    /// χ = A B(α) C(ρ) B⁻¹ A⁻¹ of a turn by `angle`, radians.
    #[must_use]
    pub fn turned(&self, angle: f64) -> Matrix4<f64> {
        self.conjugated(about_x(angle.cos(), angle.sin()))
    }

    /// dχ/dρ.
    #[must_use]
    pub fn turning(&self, angle: f64) -> Matrix4<f64> {
        let mut c = about_x(-angle.sin(), angle.cos());
        (c[(0, 0)], c[(3, 3)]) = (0.0, 0.0);
        self.conjugated(c)
    }

    fn conjugated(&self, c: Matrix4<f64>) -> Matrix4<f64> {
        let [cos, sin] = self.direction;
        let back = frame(Vector2::zeros(), [cos, -sin]) * frame(-self.place, [1.0, 0.0]);
        frame(self.place, self.direction) * c * back
    }
}

/// L: the product of the folding matrices of these creases, in order.
#[must_use]
pub fn product(turns: impl Iterator<Item = (Line, f64)>) -> Matrix4<f64> {
    turns.fold(Matrix4::identity(), |l, (line, angle)| {
        l * line.turned(angle)
    })
}

/// The rotation of a motion.
#[must_use]
pub fn rotation(l: &Matrix4<f64>) -> Matrix3<f64> {
    l.fixed_view::<3, 3>(0, 0).into_owned()
}

/// ‖L − I‖ / √2 of its rotation, the closure residual.
#[must_use]
pub fn residual(l: &Matrix4<f64>) -> f64 {
    (rotation(l) - Matrix3::identity()).norm() / core::f64::consts::SQRT_2
}

/// Its axis times the sine of its angle.
#[must_use]
pub fn skew(m: &Matrix3<f64>) -> Vector3<f64> {
    Vector3::new(
        m[(2, 1)] - m[(1, 2)],
        m[(0, 2)] - m[(2, 0)],
        m[(1, 0)] - m[(0, 1)],
    ) / 2.0
}

impl Sheet {
    /// The crease on an edge, seen from a vertex.
    fn line(&self, edge: usize, from: usize) -> Line {
        let [a, b] = self.edges[edge];
        let way = (self.flat[a + b - from] - self.flat[from]).xy().normalize();
        Line {
            place: self.flat[from].xy(),
            direction: [way.x, way.y],
        }
    }

    /// Largest closure residual of an interior vertex by 4x4 matrices, and largest distance by which they
    /// move the vertex, over the median edge.
    #[must_use]
    pub fn closure_by_matrices(&self, stars: &[(usize, Vec<usize>)], angles: &[f64]) -> [f64; 2] {
        let left = |(vertex, star): &(usize, Vec<usize>)| {
            let turns = star.iter().map(|&e| (self.line(e, *vertex), angles[e]));
            let l = product(turns);
            let place = self.flat[*vertex];
            let moved = (l * place.push(1.0)).xyz() - place;
            [residual(&l), moved.norm() / self.median_edge()]
        };
        let left: Vec<[f64; 2]> = stars.iter().map(left).collect();
        [0, 1].map(|k| worst(left.iter().map(|of_star| of_star[k])))
    }

    /// Positions of the vertices by 4x4 matrices, laid depth first from the last face inwards and moved to where
    /// face 0 stays: no way from face to face is that of [`Sheet::fold`] but by chance.
    ///
    /// # Panics
    /// If the sheet is in more than one part.
    #[must_use]
    pub fn positions_by_matrices(&self, angles: &[f64]) -> Vec<Vector3<f64>> {
        let mut beyond = vec![Vec::new(); self.faces.len()];
        for (edge, sides) in self.sides.iter().enumerate() {
            if let [Some(left), Some(right)] = *sides {
                let [a, b] = self.edges[edge];
                // From left to right the crease is crossed with its first end on the left hand.
                beyond[left].push((right, self.line(edge, b), angles[edge]));
                beyond[right].push((left, self.line(edge, a), angles[edge]));
            }
        }
        let mut motions: Vec<Option<Matrix4<f64>>> = vec![None; self.faces.len()];
        let mut open = vec![(self.faces.len() - 1, Matrix4::identity())];
        while let Some((face, motion)) = open.pop() {
            if motions[face].is_some() {
                continue;
            }
            motions[face] = Some(motion);
            for &(other, line, angle) in &beyond[face] {
                open.push((other, motion * line.turned(angle)));
            }
        }
        let first = motions[0].expect("one sheet");
        // The inverse of a rigid motion.
        let turn = rotation(&first).transpose();
        let shift = first.fixed_view::<3, 1>(0, 3).into_owned();
        let mut positions = vec![None; self.flat.len()];
        for (face, motion) in self.faces.iter().zip(&motions) {
            let motion = motion.expect("one sheet");
            for &vertex in face {
                let placed = (motion * self.flat[vertex].push(1.0)).xyz();
                positions[vertex].get_or_insert(turn * (placed - shift));
            }
        }
        let flat = self.flat.iter();
        let placed = positions.into_iter().zip(flat);
        placed
            .map(|(placed, flat)| placed.unwrap_or(*flat))
            .collect()
    }
}
