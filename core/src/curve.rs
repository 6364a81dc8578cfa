//! The motion of one fold angle between two knots: a cubic in Bernstein form.
//!
//! The cubic is either the fold angle itself, or the pair (c, n) proportional to (cos ρ/2, sin ρ/2), the *homogeneous
//! half angle*. With homogeneous half angles the closure of a vertex is a polynomial of the path parameter, because
//! each factor of its quaternion product is one, and half a turn is no pole. Flat-foldable degree-4 vertices move with
//! constant ratios of the tangents of their half angles, so that one such segment is their whole motion, without error.

use serde::{Deserialize, Serialize};

use crate::bernstein::{hermite, jet, value};
use crate::{HalfAngle, Scalar};

/// Kind of motion between two knots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Interpolation {
    /// Linear in the fold angle.
    Linear,
    /// Cubic Hermite in the fold angle, with the rates of the knots.
    #[default]
    Hermite,
    /// Cubic Hermite in tan ρ/2, with the rates that follow from those of the knots. Angles have to be below half a
    /// turn.
    HalfAngle,
    /// Cubic Hermite in w (cos ρ/2, sin ρ/2), with weights w above 0 at the knots and their rates.
    Homogeneous,
}

impl Interpolation {
    /// All kinds, each at the position of its number in files.
    pub(crate) const ALL: [Self; 4] = [
        Self::Linear,
        Self::Hermite,
        Self::HalfAngle,
        Self::Homogeneous,
    ];

    /// Returns the numbers stored for a group in a knot: angle and rate, and if there are weights, the weight and its
    /// rate.
    #[must_use]
    pub fn width(self) -> usize {
        match self {
            Self::Homogeneous => 4,
            _ => 2,
        }
    }
}

/// One group at one knot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node<T> {
    /// Fold angle ρ, radians.
    pub angle: T,
    /// Rate of the fold angle, radians per unit of the parameter.
    pub rate: T,
    /// Weight of the homogeneous half angle and its rate; only [`Interpolation::Homogeneous`] reads them.
    pub weight: [T; 2],
}

/// Defect of a [`Node`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flaw {
    /// The angle or the rate is infinite or NaN.
    NotFinite,
    /// The angle is half a turn, where tan ρ/2 is infinite.
    HalfTurn,
    /// The weight is not a finite number above 0, or its rate is not finite.
    Weight,
}

impl<T: Scalar> Node<T> {
    /// Returns the first defect that makes the node unfit for curves of this kind. Weights are checked for every kind.
    pub(crate) fn flaw(&self, kind: Interpolation) -> Option<Flaw> {
        let [weight, grow] = self.weight;
        if !(self.angle.is_finite() && self.rate.is_finite()) {
            Some(Flaw::NotFinite)
        } else if kind == Interpolation::HalfAngle && self.angle.abs() >= T::PI {
            Some(Flaw::HalfTurn)
        } else if !(weight > T::zero() && weight.is_finite() && grow.is_finite()) {
            Some(Flaw::Weight)
        } else {
            None
        }
    }
}

/// The motion of one fold angle over a segment with parameter s from 0 to 1: one or two cubics in Bernstein
/// coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curve<T> {
    /// Fold angle, radians.
    Angle([T; 4]),
    /// Two numbers proportional to cosine and sine of half the fold angle. With valid weights `cos` is nowhere
    /// negative, and the two are nowhere both 0.
    HalfAngle {
        /// Proportional to cos ρ/2.
        cos: [T; 4],
        /// Proportional to sin ρ/2.
        sin: [T; 4],
    },
}

impl<T: Scalar> Curve<T> {
    /// Creates the segment between two knots that are `span` units of the parameter apart.
    #[must_use]
    pub fn between(kind: Interpolation, span: T, from: Node<T>, to: Node<T>) -> Self {
        // Each end is a value and its rate.
        let cubic = |[p, m]: [T; 2], [q, n]: [T; 2]| hermite([p, q], [m * span, n * span]);
        match kind {
            Interpolation::Linear => {
                let slope = to.angle - from.angle;
                Self::Angle(hermite([from.angle, to.angle], [slope, slope]))
            }
            Interpolation::Hermite => {
                Self::Angle(cubic([from.angle, from.rate], [to.angle, to.rate]))
            }
            Interpolation::HalfAngle => Self::HalfAngle {
                cos: [T::one(); 4],
                sin: cubic(tangent(from.angle, from.rate), tangent(to.angle, to.rate)),
            },
            Interpolation::Homogeneous => {
                let [[cos, sin], [to_cos, to_sin]] = [from, to].map(homogeneous);
                Self::HalfAngle {
                    cos: cubic(cos, to_cos),
                    sin: cubic(sin, to_sin),
                }
            }
        }
    }

    /// Returns the fold angle (radians) at `s`.
    #[must_use]
    pub fn angle(&self, s: T) -> T {
        match self {
            Self::Angle(angle) => value(angle, s),
            Self::HalfAngle { cos, sin } => T::TWO * value(sin, s).atan2(value(cos, s)),
        }
    }

    /// Returns the first and second derivative of the fold angle by s (radians) at `s`.
    #[must_use]
    pub fn derivatives(&self, s: T) -> [T; 2] {
        match self {
            Self::Angle(angle) => {
                let [_, first, second] = jet(angle, s);
                [first, second]
            }
            Self::HalfAngle { cos, sin } => {
                let ([c, c1, c2], [n, n1, n2]) = (jet(cos, s), jet(sin, s));
                let square = c * c + n * n;
                let turn = (c * n1 - n * c1) / square;
                let grow = (c * c1 + n * n1) / square;
                [
                    T::TWO * turn,
                    T::TWO * ((c * n2 - n * c2) / square - T::TWO * turn * grow),
                ]
            }
        }
    }

    /// Returns angle, rate and weight at `s` of a segment that is `span` units of the parameter long. A knot there cuts the
    /// segment in two without a change of the motion.
    #[must_use]
    pub fn node(&self, s: T, span: T) -> Node<T> {
        let weight = match self {
            Self::Angle(_) => [T::one(), T::zero()],
            Self::HalfAngle { cos, sin } => {
                let ([c, c1, _], [n, n1, _]) = (jet(cos, s), jet(sin, s));
                let weight = (c * c + n * n).sqrt();
                [weight, (c * c1 + n * n1) / (weight * span)]
            }
        };
        Node {
            angle: self.angle(s),
            rate: self.derivatives(s)[0] / span,
            weight,
        }
    }

    /// Returns cosine and sine of half the fold angle at `s`.
    #[must_use]
    pub fn half_angle(&self, s: T) -> HalfAngle<T> {
        match self {
            Self::Angle(angle) => half_angle(value(angle, s)),
            Self::HalfAngle { cos, sin } => {
                let (cos, sin) = (value(cos, s), value(sin, s));
                let scale = T::one() / (cos * cos + sin * sin).sqrt();
                HalfAngle {
                    cos: cos * scale,
                    sin: sin * scale,
                }
            }
        }
    }
}

/// Returns cosine and sine of half a fold angle, radians.
// Not inlined, so that an image has sine and cosine fewer times.
#[inline(never)]
pub(crate) fn half_angle<T: Scalar>(angle: T) -> HalfAngle<T> {
    HalfAngle::of(angle)
}

/// Returns the tangent of half an angle and the rate of that tangent.
#[inline(never)]
fn tangent<T: Scalar>(angle: T, rate: T) -> [T; 2] {
    let HalfAngle { cos, sin } = half_angle(angle);
    let tangent = sin / cos;
    [tangent, rate * T::HALF * (T::one() + tangent * tangent)]
}

/// Returns value and rate of c, then of n, of a homogeneous half angle.
#[inline(never)]
fn homogeneous<T: Scalar>(node: Node<T>) -> [[T; 2]; 2] {
    let HalfAngle { cos, sin } = half_angle(node.angle);
    let ([weight, grow], turn) = (node.weight, node.rate * T::HALF);
    [
        [weight * cos, grow * cos - weight * turn * sin],
        [weight * sin, grow * sin + weight * turn * cos],
    ]
}
