//! Cubics by their Bernstein coefficients: values (de Casteljau's algorithm), restriction to a part of a segment (polar
//! form), and bounds on one fold angle over that part.

use foldpath_core::{Curve, HalfAngle};

use super::chebyshev::{RADII, Radius};

/// Returns the value at `s` of the cubic with Bernstein coefficients `b`.
///
/// Each of the three levels of de Casteljau's algorithm errs by one rounding of the larger coefficient and two of the
/// difference of two coefficients.
pub(super) fn value(b: &[f64; 4], s: f64) -> f64 {
    blossom(b, [s, s, s])
}

/// Returns the polar form (blossom) of the cubic: affine in each argument, and the cubic where all arguments are equal.
fn blossom([a, b, c, d]: &[f64; 4], s: [f64; 3]) -> f64 {
    let mix = |a: f64, b: f64, s: f64| a + (b - a) * s;
    let (ab, bc, cd) = (mix(*a, *b, s[0]), mix(*b, *c, s[0]), mix(*c, *d, s[0]));
    let (abc, bcd) = (mix(ab, bc, s[1]), mix(bc, cd, s[1]));
    mix(abc, bcd, s[2])
}

/// Returns the Bernstein coefficients of the cubic over the part `from..to` of the segment.
pub(crate) fn restrict(b: &[f64; 4], [from, to]: [f64; 2]) -> [f64; 4] {
    let ways = [
        [from, from, from],
        [from, from, to],
        [from, to, to],
        [to, to, to],
    ];
    ways.map(|s| blossom(b, s))
}

/// Returns the largest absolute coefficient and the largest difference of neighbours; infinite if one is not finite.
pub(super) fn sizes(b: &[f64; 4]) -> [f64; 2] {
    let finite = b.iter().all(|b| b.is_finite());
    let size = b.iter().fold(0.0, |most: f64, b| most.max(b.abs()));
    let steps = b.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let sizes = [size, steps.fold(0.0, f64::max)];
    sizes.map(|size| if finite { size } else { f64::INFINITY })
}

/// Returns the Chebyshev coefficients over the interval that the Bernstein coefficients refer to.
fn chebyshev([a, b, c, d]: &[f64; 4]) -> [f64; 4] {
    let first = 3.0 * (b - a);
    let second = 3.0 * ((c - b) - (b - a));
    let third = (d - c) - 2.0 * (c - b) + (b - a);
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
