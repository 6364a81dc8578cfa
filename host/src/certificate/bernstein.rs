//! Cubics by their Bernstein coefficients, and what these say of one fold angle over a part of a segment.

use foldpath_core::{Curve, HalfAngle};

use super::chebyshev::{RADII, Radius};

/// The cubic with Bernstein coefficients `b` at `s`.
///
/// Each of the three levels of de Casteljau's algorithm errs by a rounding of the larger coefficient
/// and two of their difference.
pub(super) fn value(b: &[f64; 4], s: f64) -> f64 {
    blossom(b, [s, s, s])
}

/// The polar form of the cubic: affine in each argument, the cubic where all three are the same.
fn blossom([a, b, c, d]: &[f64; 4], s: [f64; 3]) -> f64 {
    let mix = |a: f64, b: f64, s: f64| a + (b - a) * s;
    let (ab, bc, cd) = (mix(*a, *b, s[0]), mix(*b, *c, s[0]), mix(*c, *d, s[0]));
    let (abc, bcd) = (mix(ab, bc, s[1]), mix(bc, cd, s[1]));
    mix(abc, bcd, s[2])
}

/// Bernstein coefficients over a part of the segment.
pub(crate) fn restrict(b: &[f64; 4], [from, to]: [f64; 2]) -> [f64; 4] {
    let ways = [
        [from, from, from],
        [from, from, to],
        [from, to, to],
        [to, to, to],
    ];
    ways.map(|s| blossom(b, s))
}

/// Largest coefficient, and largest difference of neighbours; infinite if one is no number.
pub(super) fn sizes(b: &[f64; 4]) -> [f64; 2] {
    let finite = b.iter().all(|b| b.is_finite());
    let size = b.iter().fold(0.0, |most: f64, b| most.max(b.abs()));
    let steps = b.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let sizes = [size, steps.fold(0.0, f64::max)];
    sizes.map(|size| if finite { size } else { f64::INFINITY })
}

/// Chebyshev coefficients over the interval that the Bernstein coefficients refer to.
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

/// What is known of one fold angle over a part of a segment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// No |c + n i| is less; 1 where the curve is of the angle itself.
    pub(super) least: f64,
    /// Bound on the error of [`sample`](Self::sample): of the unit quaternion of a fold.
    pub(super) rounding: f64,
    /// For each Bernstein ellipse a bound on the logarithm of the norm of the fold's quaternion, over
    /// `least`, for complex parameters in it.
    pub(super) growth: [f64; RADII],
}

impl Piece {
    /// Of `curve` over a part of the segment. `least` is not above 0 where nothing is known.
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

    /// Half angle at `s`, and |c + n i| over `least`.
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

/// What a few sums of coefficients of this size lose by rounding.
pub(super) fn lost(size: f64) -> f64 {
    16.0 * f64::EPSILON * size
}

/// A lower bound on |c + n i|: of all control points in the direction half way from the first to the last.
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
