//! Closed goals by Newton's method on the closure of a drawing. Uses rotation matrices and none of foldpath's solvers.

use foldpath::pattern::{Drawing, Letter};
use nalgebra::{DMatrix, DVector, Rotation3, Vector3};

use crate::worst;

/// Closure residual to which goals are solved: a few roundings of a product of ten rotations.
const CLOSED: f64 = 1e-13;
/// Largest number of steps of Newton's method. Near a solution each step squares the error.
const STEPS: usize = 60;
/// Largest step, radians, so that a start far from a solution does not go round in full turns.
const LONGEST: f64 = 0.3;
/// Damping added to the diagonal of JJᵀ, over its largest entry. JJᵀ is singular if all creases of a vertex lie in one
/// line.
const DAMPING: f64 = 1e-10;

/// The stars of a drawing's inner vertices.
pub struct Closure {
    creases: usize,
    /// For each inner vertex its edges counter-clockwise, with their directions away from the vertex.
    stars: Vec<Vec<(usize, Vector3<f64>)>>,
}

impl Closure {
    /// Collects the stars of a drawing. A vertex without a boundary edge is an inner one.
    #[must_use]
    pub fn of(drawing: &Drawing) -> Self {
        let mut stars = vec![Vec::new(); drawing.vertices.len()];
        let mut inner = vec![true; drawing.vertices.len()];
        for (index, edge) in drawing.edges.iter().enumerate() {
            let [a, b] = edge.ends;
            let way = (drawing.vertices[b] - drawing.vertices[a])
                .normalize()
                .push(0.0);
            stars[a].push((index, way));
            stars[b].push((index, -way));
            if edge.letter == Letter::Boundary {
                (inner[a], inner[b]) = (false, false);
            }
        }
        for star in &mut stars {
            star.sort_by(|(_, a), (_, b)| a.y.atan2(a.x).total_cmp(&b.y.atan2(b.x)));
        }
        let inner = stars
            .into_iter()
            .zip(inner)
            .filter(|(star, inner)| *inner && !star.is_empty());
        Self {
            creases: drawing.edges.len(),
            stars: inner.map(|(star, _)| star).collect(),
        }
    }

    /// Returns the rotation vectors, radians, of the products round the inner vertices, at these fold angles of the
    /// edges.
    fn residuals(&self, angles: &[f64]) -> Vec<Vector3<f64>> {
        let turn = |l, &(edge, way): &(usize, Vector3<f64>)| l * Rotation3::new(way * angles[edge]);
        let left = |star: &Vec<_>| rotation_vector(&star.iter().fold(Rotation3::identity(), turn));
        self.stars.iter().map(left).collect()
    }

    /// Returns the largest rotation that remains round an inner vertex, radians.
    #[must_use]
    pub fn error(&self, angles: &[f64]) -> f64 {
        worst(self.residuals(angles).iter().map(Vector3::norm))
    }

    /// Returns the closed configuration that Newton's method finds from `start` (fold angles of the edges, radians), by
    /// steps of least length. `None` if it finds none.
    #[must_use]
    pub fn solve(&self, start: &[f64]) -> Option<Vec<f64>> {
        let mut angles = start.to_vec();
        let mut best = (f64::INFINITY, angles.clone());
        for _ in 0..STEPS {
            let residuals = self.residuals(&angles);
            let error = worst(residuals.iter().map(Vector3::norm));
            // A closed configuration is improved further as long as the error shrinks.
            if error < best.0 {
                best = (error, angles.clone());
            } else if best.0 <= CLOSED {
                break;
            }
            let j = self.jacobian(&angles);
            let mut normal = &j * j.transpose();
            let damping = DAMPING * normal.diagonal().max();
            for k in 0..normal.nrows() {
                normal[(k, k)] += damping;
            }
            let r = DVector::from_iterator(
                3 * residuals.len(),
                residuals.iter().flat_map(|r| [r.x, r.y, r.z]),
            );
            let step = j.transpose() * normal.cholesky()?.solve(&r);
            let scale = (LONGEST / step.amax()).min(1.0);
            for (angle, step) in angles.iter_mut().zip(step.iter()) {
                *angle -= scale * step;
            }
        }
        (best.0 <= CLOSED).then_some(best.1)
    }

    /// Returns the axes of the creases, each rotated by the creases before it. They are the derivative of the residuals
    /// if these are small.
    fn jacobian(&self, angles: &[f64]) -> DMatrix<f64> {
        let mut j = DMatrix::zeros(3 * self.stars.len(), self.creases);
        for (row, star) in self.stars.iter().enumerate() {
            let mut before = Rotation3::identity();
            for &(edge, way) in star {
                let axis = before * way;
                for k in 0..3 {
                    j[(3 * row + k, edge)] += axis[k];
                }
                before *= Rotation3::new(way * angles[edge]);
            }
        }
        j
    }
}

/// Returns axis times angle, radians. Takes the arc tangent of the skew part over the trace, because the trace alone
/// loses angles below 1e-8.
fn rotation_vector(l: &Rotation3<f64>) -> Vector3<f64> {
    let m = l.matrix();
    let skew = Vector3::new(
        m[(2, 1)] - m[(1, 2)],
        m[(0, 2)] - m[(2, 0)],
        m[(1, 0)] - m[(0, 1)],
    ) / 2.0;
    let (sine, cosine) = (skew.norm(), (m.trace() - 1.0) / 2.0);
    let axis = if sine > 0.0 {
        skew / sine
    } else {
        Vector3::x()
    };
    axis * sine.atan2(cosine)
}
