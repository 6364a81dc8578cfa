//! The report's folding matrices as 4x4 products, written without foldpath's code: closure round vertices at their
//! positions, its derivatives, and faces placed along another spanning tree than that of [`Sheet::fold`].

use nalgebra::{Matrix3, Matrix4, Vector2, Vector3};

use crate::{Sheet, worst};

/// Returns A B(α) of the report: a translation within the sheet after a rotation about its normal.
fn frame(place: Vector2<f64>, [cos, sin]: [f64; 2]) -> Matrix4<f64> {
    Matrix4::new(
        cos, -sin, 0.0, place.x, //
        sin, cos, 0.0, place.y, //
        0.0, 0.0, 1.0, 0.0, //
        0.0, 0.0, 0.0, 1.0,
    )
}

/// Returns C(ρ), a rotation about the x axis, from the cosine and sine of ρ.
fn about_x(cos: f64, sin: f64) -> Matrix4<f64> {
    Matrix4::new(
        1.0, 0.0, 0.0, 0.0, //
        0.0, cos, -sin, 0.0, //
        0.0, sin, cos, 0.0, //
        0.0, 0.0, 0.0, 1.0,
    )
}

/// A crease as a line of the flat sheet.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// A point of the line.
    pub place: Vector2<f64>,
    /// Unit direction of the line.
    pub direction: [f64; 2],
}

impl Line {
    /// Returns χ = A B(α) C(ρ) B⁻¹ A⁻¹ for ρ = `angle`, radians.
    #[must_use]
    pub fn turned(&self, angle: f64) -> Matrix4<f64> {
        self.conjugated(about_x(angle.cos(), angle.sin()))
    }

    /// Returns dχ/dρ.
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

/// Returns L, the product of the folding matrices of these creases, in order.
#[must_use]
pub fn product(turns: impl Iterator<Item = (Line, f64)>) -> Matrix4<f64> {
    turns.fold(Matrix4::identity(), |l, (line, angle)| {
        l * line.turned(angle)
    })
}

/// Returns the rotation part of a rigid motion.
#[must_use]
pub fn rotation(l: &Matrix4<f64>) -> Matrix3<f64> {
    l.fixed_view::<3, 3>(0, 0).into_owned()
}

/// Returns ‖L − I‖ / √2 of the rotation part, which is the closure residual.
#[must_use]
pub fn residual(l: &Matrix4<f64>) -> f64 {
    (rotation(l) - Matrix3::identity()).norm() / core::f64::consts::SQRT_2
}

/// Returns the axis of a rotation times the sine of its angle.
#[must_use]
pub fn skew(m: &Matrix3<f64>) -> Vector3<f64> {
    Vector3::new(
        m[(2, 1)] - m[(1, 2)],
        m[(0, 2)] - m[(2, 0)],
        m[(1, 0)] - m[(0, 1)],
    ) / 2.0
}

impl Sheet {
    /// Returns the line of an edge, directed away from one of its vertices.
    fn line(&self, edge: usize, from: usize) -> Line {
        let [a, b] = self.edges[edge];
        let way = (self.flat[a + b - from] - self.flat[from]).xy().normalize();
        Line {
            place: self.flat[from].xy(),
            direction: [way.x, way.y],
        }
    }

    /// Returns the largest closure residual of an interior vertex by 4x4 matrices, and the largest distance by which L
    /// moves the vertex, over the median edge.
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

    /// Returns the positions of the vertices by 4x4 matrices. Faces are placed depth first from the last face, then
    /// moved to where face `root` stays. Paths from face to face hardly ever agree with those of [`Sheet::fold`].
    ///
    /// # Panics
    /// If the sheet is not connected.
    #[must_use]
    pub fn positions_by_matrices(&self, root: usize, angles: &[f64]) -> Vec<Vector3<f64>> {
        let mut beyond = vec![Vec::new(); self.faces.len()];
        for (edge, sides) in self.sides.iter().enumerate() {
            if let [Some(left), Some(right)] = *sides {
                let [a, b] = self.edges[edge];
                // On the way from the left face to the right one, the axis runs from the second end of the edge to the
                // first.
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
        let first = motions[root].expect("one sheet");
        // Inverts a rigid motion.
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
