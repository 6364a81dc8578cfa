//! Bounds on one fold angle over a part of a segment, from the Bernstein coefficients of its curve.

use foldpath_core::bernstein::{differences, max_coefficient, max_difference, restrict, value};
use foldpath_core::{Curve, HalfAngle};

use super::chebyshev::{RADII, Radius};

/// Returns the largest absolute coefficient and the largest difference of neighbours; infinite if one is not finite.
pub(super) fn sizes(b: &[f64; 4]) -> [f64; 2] {
    let finite = b.iter().all(|b| b.is_finite());
    let sizes = [max_coefficient(b), max_difference(b)];
    sizes.map(|size| if finite { size } else { f64::INFINITY })
}

/// Returns the Chebyshev coefficients over the interval that the Bernstein coefficients refer to.
fn chebyshev(b: &[f64; 4]) -> [f64; 4] {
    let (a, [p, q, r]) = (b[0], differences(b));
    let first = 3.0 * p;
    let second = 3.0 * (q - p);
    let third = r - 2.0 * q + p;
    [
        a + first / 2.0 + 0.375 * second + 0.3125 * third,
        (first + second) / 2.0 + 0.46875 * third,
        second / 8.0 + 0.1875 * third,
        third / 32.0,
    ]
}

/// Bounds on one fold angle over a part of a segment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// Lower bound on |c + n i|; 1 if the curve is of the angle itself.
    pub(super) least: f64,
    /// Bound on the error of [`sample`](Self::sample): the error of the unit quaternion of a fold.
    pub(super) rounding: f64,
    /// For each Bernstein ellipse, a bound on the logarithm of the norm of the fold's quaternion, over `least`, for
    /// complex parameters in the ellipse.
    pub(super) growth: [f64; RADII],
}

impl Piece {
    /// Bounds `curve` over a part of the segment. `least` is not above 0 if nothing can be bounded.
    pub(super) fn new(curve: &Curve<f64>, part: [f64; 2], radii: &[Radius; RADII]) -> Self {
        match curve {
            Curve::Angle(angle) => {
                let [size, step] = sizes(angle);
                // |Im T_k| on an ellipse is at most (ρ^k - ρ^-k) / 2.
                let [_, moduli @ ..] =
                    chebyshev(&restrict(angle, part)).map(|a| a.abs() + lost(size));
                let growth = |radius: &Radius| {
                    let terms = moduli.iter().zip(radius.sinh);
                    terms.map(|(a, sinh)| a * sinh).sum::<f64>() / 2.0
                };
                Self {
                    least: 1.0,
                    rounding: (0.75 * size + 1.5 * step + 1.0) * f64::EPSILON,
                    growth: radii.each_ref().map(growth),
                }
            }
            Curve::HalfAngle { cos, sin } => {
                let ([c, c_step], [n, n_step]) = (sizes(cos), sizes(sin));
                let (size, step) = (c.hypot(n), c_step.hypot(n_step));
                let (cos, sin) = (restrict(cos, part), restrict(sin, part));
                let least = least(&cos, &sin) - lost(size);
                // The norm of c + n u is the larger |c ± n i|; |T_k| is at most (ρ^k + ρ^-k) / 2.
                let (cos, sin) = (chebyshev(&cos), chebyshev(&sin));
                let modulus = |k: usize| (cos[k].hypot(sin[k]) + lost(size)) / least;
                let moduli = [0, 1, 2, 3].map(modulus);
                let growth = |radius: &Radius| {
                    let terms = moduli[1..].iter().zip(radius.cosh);
                    (moduli[0] + terms.map(|(a, cosh)| a * cosh).sum::<f64>()).ln()
                };
                Self {
                    least,
                    rounding: ((1.5 * size + 3.0 * step) / least + 2.0) * f64::EPSILON,
                    growth: radii.each_ref().map(growth),
                }
            }
        }
    }

    /// Returns the half angle at `s`, and |c + n i| over `least`.
    pub(super) fn sample(&self, curve: &Curve<f64>, s: f64) -> (HalfAngle<f64>, f64) {
        match curve {
            Curve::Angle(angle) => (HalfAngle::of(value(angle, s)), 1.0),
            Curve::HalfAngle { cos, sin } => {
                let (cos, sin) = (value(cos, s), value(sin, s));
                let size = (cos * cos + sin * sin).sqrt();
                let half = HalfAngle {
                    cos: cos / size,
                    sin: sin / size,
                };
                (half, size / self.least)
            }
        }
    }
}

/// Returns a bound on the rounding error of a few sums of coefficients of this size.
pub(super) fn lost(size: f64) -> f64 {
    16.0 * f64::EPSILON * size
}

/// Returns a lower bound on |c + n i|: the least component of a control point along the direction half way between the
/// first and the last control point.
pub(super) fn least(cos: &[f64; 4], sin: &[f64; 4]) -> f64 {
    let unit = |k: usize| {
        let size = cos[k].hypot(sin[k]);
        [cos[k] / size, sin[k] / size]
    };
    let (from, to) = (unit(0), unit(3));
    let middle = [from[0] + to[0], from[1] + to[1]];
    let size = middle[0].hypot(middle[1]);
    let along = cos
        .iter()
        .zip(sin)
        .map(|(c, n)| (c * middle[0] + n * middle[1]) / size);
    along.fold(f64::INFINITY, |least, d| {
        if d < least || d.is_nan() { d } else { least }
    })
}
