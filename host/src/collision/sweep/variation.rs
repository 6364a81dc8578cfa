//! Bounds the variation of fold angles along a motion.
//!
//! The total variation of a curve bounds its change between two places, whatever the curve does in between. A
//! curve is subdivided where the Bernstein coefficients of its derivative do not all have one sign, until they
//! do. Parts for which some subdivisions do not suffice are bounded by their greatest rate.

use core::f64::consts::PI;

use foldpath_core::Curve;
use foldpath_core::bernstein::{differences, halves, max_coefficient, max_difference, restrict};

use crate::collision::narrow::planes::Change;
use crate::collision::tolerances::{MAX_BISECTIONS, MAX_COEFFICIENT, MAX_SUBDIVISIONS};

/// A part of a segment from `start` on.
#[derive(Clone, Copy, Debug)]
struct Part {
    start: f64,
    /// Variation of the segment up to `start`, radians.
    before: f64,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Monotone from this angle on, radians.
    Monotone(f64),
    /// With a rate of at most this, radians per segment.
    Rate(f64),
}

/// The variation of one fold angle over one segment, or a little more than that.
#[derive(Clone, Debug)]
pub(super) struct Variation {
    pub(super) curve: Curve<f64>,
    parts: Vec<Part>,
}

impl Variation {
    pub(super) fn new(curve: Curve<f64>) -> Self {
        let mut variation = Self {
            curve,
            parts: Vec::with_capacity(1),
        };
        variation.add(&Rates::of(&curve), [0.0, 1.0], 0.0, MAX_SUBDIVISIONS);
        variation
    }

    /// Returns `true` if the coefficients of the curve are finite, and so small that their squares are finite too.
    pub(super) fn is_finite(&self) -> bool {
        let finite = |b: &[f64; 4]| b.iter().all(|b| b.abs() <= MAX_COEFFICIENT);
        match &self.curve {
            Curve::Angle(angle) => finite(angle),
            Curve::HalfAngle { cos, sin } => finite(cos) && finite(sin),
        }
    }

    /// Returns `true` if the coefficients of the curve are those of one angle.
    #[allow(clippy::float_cmp, reason = "one angle, without rounding")]
    pub(super) fn rests(&self) -> bool {
        match &self.curve {
            Curve::Angle(angle) => angle.iter().all(|b| *b == angle[0]),
            Curve::HalfAngle { cos, sin } => {
                let mut pairs = cos.iter().zip(sin);
                pairs.all(|(c, n)| c * sin[0] == n * cos[0] && c * cos[0] + n * sin[0] > 0.0)
            }
        }
    }

    /// Returns the first place found at which the angle exceeds half a turn by more than `slack` radians.
    pub(super) fn overturned(&self, slack: f64) -> Option<f64> {
        self.overturned_in(&Rates::of(&self.curve), [0.0, 1.0], slack, MAX_BISECTIONS)
    }

    fn overturned_in(
        &self,
        rates: &Rates,
        [start, end]: [f64; 2],
        slack: f64,
        halvings: u32,
    ) -> Option<f64> {
        if rates.stays_within(slack) {
            return None;
        }
        let middle = (start + end) / 2.0;
        if halvings == 0 {
            return (self.curve.angle(end).abs() > PI + slack).then_some(end);
        }
        let [left, right] = rates.halves();
        self.overturned_in(&left, [start, middle], slack, halvings - 1)
            .or_else(|| self.overturned_in(&right, [middle, end], slack, halvings - 1))
    }

    /// Returns the change of the angle from `s` to `end`.
    pub(super) fn change(&self, s: f64, end: f64) -> Change {
        Change {
            by: self.curve.angle(end) - self.curve.angle(s),
            off: self.bulge(s, end),
        }
    }

    /// Returns an upper bound of the distance of the angle from the straight line from `s` to `end`, radians.
    pub(super) fn bulge(&self, s: f64, end: f64) -> f64 {
        Rates::of(&self.curve).between(s, end).bulge()
    }

    /// Returns an upper bound of the absolute third derivative of the angle from `s` to `end`, radians per cubed segment.
    pub(super) fn third_derivative(&self, s: f64, end: f64) -> f64 {
        let third = Rates::of(&self.curve).between(s, end).third_derivative();
        if third.is_nan() {
            return f64::INFINITY;
        }
        third / (end - s).powi(3)
    }

    /// Adds the parts of a stretch, and returns the variation up to its end.
    fn add(&mut self, rates: &Rates, [start, end]: [f64; 2], before: f64, cuts: u32) -> f64 {
        let [from, to] = [start, end].map(|s| self.curve.angle(s));
        let (kind, varied) = if rates.monotone() {
            (Kind::Monotone(from), (to - from).abs())
        } else if cuts == 0 {
            let rate = rates.greatest() / (end - start);
            (Kind::Rate(rate), rates.greatest())
        } else {
            let middle = (start + end) / 2.0;
            let [left, right] = rates.halves();
            let before = self.add(&left, [start, middle], before, cuts - 1);
            return self.add(&right, [middle, end], before, cuts - 1);
        };
        self.parts.push(Part {
            start,
            before,
            kind,
        });
        before + varied
    }

    /// Returns the variation from the beginning of the segment to `s`, radians. The difference between two
    /// places is never less than the change of the angle between them.
    pub(super) fn until(&self, s: f64) -> f64 {
        let after = self.parts.partition_point(|part| part.start <= s);
        let Some(part) = self.parts.get(after.saturating_sub(1)) else {
            return f64::INFINITY;
        };
        part.before
            + match part.kind {
                Kind::Monotone(from) => (self.curve.angle(s) - from).abs(),
                Kind::Rate(rate) => rate * (s - part.start),
            }
    }
}

/// Bernstein coefficients of a curve over a stretch, from which its rate per length of the stretch is bounded:
/// those of the angle, or of cosine and sine of the half angle.
#[derive(Clone, Copy, Debug)]
enum Rates {
    Angle([f64; 4]),
    HalfAngle([[f64; 4]; 2]),
}

impl Rates {
    fn of(curve: &Curve<f64>) -> Self {
        match curve {
            Curve::Angle(angle) => Self::Angle(*angle),
            Curve::HalfAngle { cos, sin } => Self::HalfAngle([*cos, *sin]),
        }
    }

    fn halves(&self) -> [Self; 2] {
        match self {
            Self::Angle(angle) => halves(angle).map(Self::Angle),
            Self::HalfAngle([cos, sin]) => {
                let ([c0, c1], [n0, n1]) = (halves(cos), halves(sin));
                [Self::HalfAngle([c0, n0]), Self::HalfAngle([c1, n1])]
            }
        }
    }

    /// Returns `true` if the coefficients prove that the angle exceeds half a turn by no more than `slack` radians.
    fn stays_within(&self, slack: f64) -> bool {
        match self {
            Self::Angle(angle) => max_coefficient(angle) <= PI + slack,
            // Past half a turn the cosine is below 0, and its ratio to the sine is the tangent of half the
            // excess.
            Self::HalfAngle([cos, sin]) => {
                let lowest = cos.iter().copied().fold(f64::INFINITY, f64::min);
                let sides = [*sin, sin.map(|n| -n)];
                let least = sides.map(|n| n.into_iter().fold(f64::INFINITY, f64::min));
                lowest >= 0.0 || -lowest <= slack / 2.0 * least[0].max(least[1])
            }
        }
    }

    fn between(&self, s: f64, end: f64) -> Self {
        match self {
            Self::Angle(angle) => Self::Angle(restrict(angle, [s, end])),
            Self::HalfAngle(parts) => Self::HalfAngle(parts.map(|part| restrict(&part, [s, end]))),
        }
    }

    /// Returns an upper bound of the distance of the angle from the straight line between its ends.
    fn bulge(&self) -> f64 {
        match self {
            Self::Angle([a, b, c, d]) => {
                let third = (d - a) / 3.0;
                (b - a - third).abs().max((d - c - third).abs())
            }
            Self::HalfAngle(_) => self.curvature() / 8.0,
        }
    }

    /// Returns an upper bound of the absolute second derivative of the angle.
    fn curvature(&self) -> f64 {
        match self {
            Self::Angle(angle) => 2.0 * max_difference(&derivative(angle)),
            // The second derivative is 2 (N/q)' with N the numerator and q = c² + n².
            Self::HalfAngle(parts) => {
                let Some(([n, n1, _], [_, q1, _], least)) = self.quotient(parts) else {
                    return f64::INFINITY;
                };
                2.0 * (n1 + n * q1 / least) / least
            }
        }
    }

    /// Returns an upper bound of the absolute third derivative of the angle.
    fn third_derivative(&self) -> f64 {
        match self {
            Self::Angle([a, b, c, d]) => 6.0 * (d - 3.0 * c + 3.0 * b - a).abs(),
            // The third derivative is 2 (N/q)''.
            Self::HalfAngle(parts) => {
                let Some(([n, n1, n2], [_, q1, q2], least)) = self.quotient(parts) else {
                    return f64::INFINITY;
                };
                2.0 * (n2 + (2.0 * n1 * q1 + n * q2 + 2.0 * n * q1 * q1 / least) / least) / least
            }
        }
    }

    /// Returns bounds on the absolute values of the numerator and of q = c² + n², each with its first and second derivative, and
    /// a lower bound of q; `None` if none above 0 is known.
    fn quotient(&self, [cos, sin]: &[[f64; 4]; 2]) -> Option<([f64; 3], [f64; 3], f64)> {
        let (c, n) = (square(cos), square(sin));
        let squares: [f64; 7] = core::array::from_fn(|k| c[k] + n[k]);
        let least = squares.iter().copied().fold(f64::INFINITY, f64::min);
        (least > 0.0).then(|| (jet(&self.numerator()), jet(&squares), least))
    }

    /// Returns coefficients proportional to the rate: ρ' for an angle, c n' - n c' for a half angle.
    fn numerator(&self) -> [f64; 6] {
        match self {
            Self::Angle(angle) => {
                let [a, b, c] = derivative(angle);
                [a, a, b, b, c, c]
            }
            Self::HalfAngle([cos, sin]) => {
                let (with_cos, with_sin) = (
                    product(cos, &derivative(sin)),
                    product(sin, &derivative(cos)),
                );
                core::array::from_fn(|k| with_cos[k] - with_sin[k])
            }
        }
    }

    fn monotone(&self) -> bool {
        let numerator = self.numerator();
        numerator.iter().all(|&b| b >= 0.0) || numerator.iter().all(|&b| b <= 0.0)
    }

    /// Returns an upper bound of the absolute rate.
    fn greatest(&self) -> f64 {
        let most = max_coefficient(&self.numerator());
        match self {
            Self::Angle(_) => most,
            Self::HalfAngle([cos, sin]) => {
                let (c, n) = (square(cos), square(sin));
                let least = c.iter().zip(&n).map(|(c, n)| c + n);
                let least = least.fold(f64::INFINITY, f64::min);
                if least > 0.0 {
                    2.0 * most / least
                } else {
                    f64::INFINITY
                }
            }
        }
    }
}

/// Returns bounds on the absolute value of a polynomial and of its first and second derivative.
#[allow(clippy::cast_precision_loss, reason = "a degree")]
fn jet<const N: usize>(b: &[f64; N]) -> [f64; 3] {
    let degree = (N - 1) as f64;
    let differences: Vec<f64> = b.windows(2).map(|pair| pair[1] - pair[0]).collect();
    [
        max_coefficient(b),
        degree * max_difference(b),
        degree * (degree - 1.0) * max_difference(&differences),
    ]
}

/// Returns the coefficients of the derivative of a cubic.
fn derivative(b: &[f64; 4]) -> [f64; 3] {
    differences(b).map(|difference| 3.0 * difference)
}

/// Returns the coefficients of a cubic times a quadratic.
fn product(a: &[f64; 4], b: &[f64; 3]) -> [f64; 6] {
    let (cubic, quadratic) = ([1.0, 3.0, 3.0, 1.0], [1.0, 2.0, 1.0]);
    let quintic = [1.0, 5.0, 10.0, 10.0, 5.0, 1.0];
    let mut product = [0.0; 6];
    for (i, a) in a.iter().enumerate() {
        for (j, b) in b.iter().enumerate() {
            product[i + j] += cubic[i] * quadratic[j] / quintic[i + j] * a * b;
        }
    }
    product
}

/// Returns the coefficients of the square of a cubic.
fn square(a: &[f64; 4]) -> [f64; 7] {
    let cubic = [1.0, 3.0, 3.0, 1.0];
    let sextic = [1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0];
    let mut square = [0.0; 7];
    for i in 0..4 {
        for j in 0..4 {
            square[i + j] += cubic[i] * cubic[j] / sextic[i + j] * a[i] * a[j];
        }
    }
    square
}

#[cfg(test)]
mod tests {
    use super::*;
    use foldpath_core::{Interpolation, Node};

    /// A hinge that rests has a numerator of 0, but the sum of squares is not known to be above 0.
    #[test]
    fn no_bound_is_known_where_cosine_and_sine_may_vanish() {
        let curve = Curve::HalfAngle {
            cos: [1.0, -1.0, -1.0, 1.0],
            sin: [0.0; 4],
        };
        let variation = Variation::new(curve);
        assert!(variation.bulge(0.0, 1.0).is_infinite());
        assert!(variation.third_derivative(0.0, 1.0).is_infinite());
    }

    #[test]
    fn no_two_samples_differ_by_more_than_the_variation_between_them() {
        let curves = [
            Curve::Angle([0.0, 1.0, -1.0, 0.3]),
            Curve::Angle([0.1, 0.2, 0.4, 0.4]),
            Curve::HalfAngle {
                cos: [1.0, 0.4, 0.3, 0.2],
                sin: [0.0, 1.2, -0.6, 0.7],
            },
            Curve::between(
                Interpolation::Homogeneous,
                1.0,
                Node {
                    angle: 0.0,
                    rate: 2.0,
                    weight: [1.0, -1.0],
                },
                Node {
                    angle: core::f64::consts::PI,
                    rate: 1.0,
                    weight: [0.5, 0.0],
                },
            ),
        ];
        for curve in curves {
            let variation = Variation::new(curve);
            let (mut sum, mut angle) = (0.0, curve.angle(0.0));
            for k in 1..=1000 {
                let [s0, s] = [k - 1, k].map(|k| f64::from(k) / 1000.0);
                let step = (curve.angle(s) - angle).abs();
                let bound = variation.until(s) - variation.until(s0);
                assert!(step <= bound + 1e-14, "{curve:?} at {s}: {step} > {bound}");
                (sum, angle) = (sum + step, curve.angle(s));
            }
            let mut most = [0.0_f64; 2];
            for k in (0..1000).step_by(10) {
                let [s, end] = [k, k + 10].map(|k| f64::from(k) / 1000.0);
                let Change { by, off } = variation.change(s, end);
                for part in 1..10 {
                    let part = f64::from(part) / 10.0;
                    let line = curve.angle(s) + part * by;
                    let bulge = (curve.angle(s + part * (end - s)) - line).abs();
                    assert!(bulge <= off + 1e-14, "{curve:?} at {s}: {bulge} > {off}");
                }
                assert!(off < 2e-2, "{curve:?} at {s}: {off}");
                let third = variation.third_derivative(s, end);
                for part in 0..10 {
                    let at = s + f64::from(part) * (end - s) / 10.0;
                    let ends = [at, at + (end - s) / 10.0];
                    let [before, after] = ends.map(|s| curve.derivatives(s)[1]);
                    let mean = 10.0 * (after - before).abs() / (end - s);
                    assert!(mean <= third + 1e-6, "{curve:?} at {s}: {mean} > {third}");
                    most = [most[0].max(mean), most[1].max(third)];
                }
            }
            assert!(most[1] <= 5.0 * most[0] + 1e-6, "{curve:?}: {most:?}");
            // The bound is not much larger: the parts that are not monotone are short.
            assert!(variation.until(1.0) < 1.02 * sum, "{curve:?}");
        }
    }
}
