//! Bounds on a segment, from the Bernstein coefficients of its curves: how fast does a group turn, how far, and does a
//! vertex stay closed, everywhere on the segment?
//!
//! # Half angles
//!
//! A [`Curve::HalfAngle`](crate::Curve) is a pair of cubics (c, n) proportional to (cos ρ/2, sin ρ/2). Its speed is a
//! ratio of polynomials, ρ' = 2 (c n' - n c')/(c² + n²), and so is the tangent |v|/w of half the misclosure of a vertex
//! whose quaternion product is (w, v). If all coefficients of a denominator are above 0, the ratio is a rational Bézier
//! curve: it stays within the range of the ratios of the coefficients ([Farin2002](crate#references), chapter 13). If
//! these ratios are too large, the segment is halved, and both halves are judged again. A ratio of coefficients
//! differs from values of the curve by a multiple of the squared length of the part.
//!
//! The coefficients are *scaled*: each is multiplied by its binomial coefficient. A product of polynomials is then the
//! convolution of their coefficients, and ratios of coefficients are as before.
//!
//! # Fold angles
//!
//! If the fold angles themselves are cubics, the closure residual r of a vertex is not a polynomial. Over a part of the
//! segment, with parameter u from 0 to 1, it is at most max |r''''| / 384 away from the cubic that has its values and
//! derivatives at both ends, and that cubic stays within the hull of its Bernstein coefficients. The residual is twice the
//! vector part of a product of unit quaternions exp(ρ/2 · axis). With A, B and C the sums over the spokes of the largest
//! first, second and third derivative of ρ/2, the norm of the product's fourth derivative is at most that of
//! exp(A u + B u²/2 + C u³/6) at 0, which is A⁴ + 6 A² B + 3 B² + 4 A C.

use nalgebra::Vector3;

use crate::bernstein::{differences, restrict};
use crate::closure::{derivative, positive};
use crate::curve::half_angle;
use crate::{Curve, Rotation, Scalar, StarView};

/// Number of halvings after which a part of a segment is no longer halved: 32 parts at most.
const MAX_HALVINGS: u32 = 5;
/// Largest number of spokes of a star whose closure is bounded.
const MAX_SPOKES: usize = 16;
/// Part by which a bound may be above a limit that the values at nine places keep. Without it, a motion at its limit
/// would be halved for ever.
const SLACK_RATIO: f64 = 1.0 / 16.0;
/// Angle (radians) by which a bound may be outside the limits of a group. Commanded angles are clamped to the limits.
const RANGE_SLACK_RAD: f64 = 1e-3;

/// Part number `index` of 2^`halvings` equal parts of a segment, counted from 0. The default is the whole segment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Part {
    index: u32,
    halvings: u32,
}

/// Verdict on a condition behind a part of a segment.
pub(crate) enum Judged {
    /// It holds on the whole segment.
    Everywhere,
    /// It is not known to hold on the smallest part.
    Not,
    /// It has to be judged on this part next.
    Next(Part),
}

impl Part {
    /// Returns where the part begins and ends on the segment, which goes from 0 to 1.
    fn ends<T: Scalar>(self) -> [T; 2] {
        let length = T::one() / T::whole(1 << self.halvings);
        let from = T::whole(self.index) * length;
        [from, from + length]
    }

    /// Returns what follows if the condition `holds` on this part, behind parts on which it holds. A part on which it does
    /// not is halved, at most [`MAX_HALVINGS`] times.
    fn judged(self, holds: bool) -> Judged {
        let Self {
            mut index,
            mut halvings,
        } = self;
        if holds {
            index += 1;
            while halvings > 0 && index.is_multiple_of(2) {
                (index, halvings) = (index / 2, halvings - 1);
            }
            if halvings == 0 {
                return Judged::Everywhere;
            }
        } else if halvings == MAX_HALVINGS {
            return Judged::Not;
        } else {
            (index, halvings) = (2 * index, halvings + 1);
        }
        Judged::Next(Self { index, halvings })
    }
}

/// Coefficients of the cubics c and n of one group on a segment.
type Pair<T> = [[T; 4]; 2];

// The functions here are not inlined, nor are they unrolled over arrays of known length: they are rarely called, and
// would otherwise double the acceptance of a setpoint in an image.
#[inline(never)]
fn part_of<T: Scalar>(cubic: &[T; 4], part: [T; 2]) -> [T; 4] {
    restrict(cubic, part)
}

/// Returns the largest factor by which a bound may be above its limit.
pub(crate) fn slack<T: Scalar>() -> T {
    T::one() + T::lit(SLACK_RATIO)
}

/// Returns `true` if |ρ'| (radians by s) is at most `speed` everywhere, within [`slack`] and `noise`. Cost: about 100
/// multiplications for each of at most 63 parts, of which an ordinary segment has one to three.
#[inline(never)]
pub(crate) fn turns_slowly<T: Scalar>(pair: Pair<T>, speed: T, noise: T) -> bool {
    everywhere(&mut |part: [T; 2]| {
        let [cos, sin] = pair.map(|cubic| part_of(&cubic, part));
        let [from, to] = part;
        let most = speed * slack() * (to - from) + noise;
        let (c, n) = (scaled(cos), scaled(sin));
        let (dc, dn) = (slope(cos), slope(sin));
        // c n' - n c', of degree 5, and of degree 6 after multiplication by (1 - s) + s.
        let mut turn = [T::zero(); 6];
        multiply(&c, &dn, T::one(), &mut turn);
        multiply(&n, &dc, -T::one(), &mut turn);
        let (mut raised, mut square) = ([T::zero(); 7], [T::zero(); 7]);
        multiply(&turn, &[T::one(); 2], T::one(), &mut raised);
        multiply(&c, &c, T::one(), &mut square);
        multiply(&n, &n, T::one(), &mut square);
        let mut ratios = raised.iter().zip(&square);
        ratios.all(|(turn, square)| {
            let sound = *square > T::zero() && square.is_finite();
            sound && T::TWO * turn.abs() <= most * *square
        })
    })
}

/// Returns `true` if the fold angle is everywhere from `lower` to `upper` (radians), within a thousandth of a radian. An
/// angle beyond half a turn is never within limits here.
#[inline(never)]
pub(crate) fn stays_within<T: Scalar>(pair: Pair<T>, lower: T, upper: T) -> bool {
    let slack = T::lit(RANGE_SLACK_RAD);
    // Half angles between two limits of at most a quarter turn are a convex cone, so that coefficients in the cone bound
    // the curve.
    let low = half_angle((lower - slack).max(-T::PI));
    let high = half_angle((upper + slack).min(T::PI));
    everywhere(&mut |part: [T; 2]| {
        let [cos, sin] = pair.map(|cubic| part_of(&cubic, part));
        cos.iter().zip(&sin).all(|(c, n)| {
            let noise = T::lit(8.0) * T::EPSILON * (c.abs() + n.abs());
            let above = *n * low.cos - *c * low.sin >= -noise;
            above && *n * high.cos - *c * high.sin <= noise
        })
    })
}

/// Judges whether the closure residual of a star is at most `bound` on a part of a segment, within [`slack`] and rounding.
///
/// `curve` returns the curve of a group. A star of more than [`MAX_SPOKES`] spokes is not bounded. Cost: for half angles about
/// 100 multiplications by the squared number of spokes, and for fold angles about 100, two sines and two cosines by the
/// number of spokes. A star takes at most 63 parts.
#[inline(never)]
pub(crate) fn stays_closed<T: Scalar>(
    star: StarView<'_, T>,
    curve: &impl Fn(usize) -> Option<Curve<T>>,
    bound: T,
    part: Part,
) -> Judged {
    let ends = part.ends();
    let first = star.spokes.first().map(|spoke| spoke.group.index());
    let holds = match first.and_then(curve) {
        _ if star.spokes.len() > MAX_SPOKES => return Judged::Not,
        None => star.spokes.is_empty(),
        Some(Curve::Angle(_)) => angles_close(star, curve, bound, ends),
        Some(Curve::HalfAngle { .. }) => half_angles_close(star, curve, bound, ends),
    };
    part.judged(holds)
}

/// Returns `true` if the closure residual of a star of half angles is at most `bound` on a part, as far as its coefficients
/// tell.
fn half_angles_close<T: Scalar>(
    star: StarView<'_, T>,
    curve: &impl Fn(usize) -> Option<Curve<T>>,
    bound: T,
    ends: [T; 2],
) -> bool {
    let (mut noise, mut most) = (T::zero(), T::TWO);
    for _ in star.spokes {
        noise += T::lit(4.0) * T::EPSILON;
        // On a short part each factor |c| + |n| is at most √2 times the length of (c, n).
        most *= T::TWO.sqrt();
    }
    // Quaternions (w, x, y, z) and the sum of the sizes of all terms of each, from which rounding follows.
    let mut product = [[T::zero(); 5]; 3 * MAX_SPOKES + 1];
    if let Some(first) = product.first_mut() {
        *first = [T::one(), T::zero(), T::zero(), T::zero(), T::one()];
    }
    let mut length = 1;
    for spoke in star.spokes {
        let Some(Curve::HalfAngle { cos, sin }) = curve(spoke.group.index()) else {
            return false;
        };
        length += 3;
        let pair = [cos, sin].map(|cubic| scaled(part_of(&cubic, ends)));
        across(&mut product, length, pair, spoke.axis());
    }
    let sign = match product.first() {
        Some([w, ..]) if *w < T::zero() => -T::one(),
        _ => T::one(),
    };
    product.iter().take(length).all(|[w, x, y, z, size]| {
        let w = *w * sign;
        let off = T::TWO * (*x * *x + *y * *y + *z * *z).sqrt();
        let allowed = bound * slack() * w + noise * *size;
        w > T::zero() && size.is_finite() && *size <= most * w && off <= allowed
    })
}

/// Returns `true` if the closure residual of a star of fold angles is at most `bound` on a part, as far as its values and
/// derivatives at both ends tell.
#[inline(never)]
fn angles_close<T: Scalar>(
    star: StarView<'_, T>,
    curve: &impl Fn(usize) -> Option<Curve<T>>,
    bound: T,
    ends: [T; 2],
) -> bool {
    let three = T::TWO + T::one();
    let mut residuals = [Along::new(), Along::new()];
    // Sums of the largest derivatives of half the angles: first, second and third.
    let [mut turn, mut bend, mut jerk] = [T::zero(); 3];
    let mut noise = T::zero();
    for spoke in star.spokes {
        let Some(Curve::Angle(angle)) = curve(spoke.group.index()) else {
            return false;
        };
        let cubic = part_of(&angle, ends);
        let [first, middle, last] = differences(&cubic);
        let [grow, fall] = [middle - first, last - middle];
        turn += first.abs().max(middle.abs()).max(last.abs()) * three * T::HALF;
        bend += grow.abs().max(fall.abs()) * three;
        jerk += (fall - grow).abs() * three;
        noise += T::lit(4.0) * T::EPSILON;
        let [begin, .., end] = cubic;
        let axis = spoke.axis();
        for (along, (angle, slope)) in residuals.iter_mut().zip([(begin, first), (end, last)]) {
            along.cross(angle, three * slope, axis);
        }
    }
    let square = turn * turn;
    let fourth = square * square
        + (T::TWO * bend * square + bend * bend) * three
        + T::lit(4.0) * turn * jerk;
    let allowed = bound * slack() + noise - T::TWO * fourth / T::lit(384.0);
    let [from, to] = residuals.map(|along| along.jet());
    let coefficients = [
        from[0],
        from[0] + from[1] / three,
        to[0] - to[1] / three,
        to[0],
    ];
    // So that the product stays on the side of the identity where the residual is counted from. Comparisons are false for a
    // NaN.
    turn <= T::HALF && coefficients.iter().all(|r| r.dot(r).sqrt() <= allowed)
}

/// The product of a star's folds up to a spoke, at one place of a segment.
struct Along<T> {
    product: Rotation<T>,
    /// Sum of the axes passed, as the product turns them, each times the rate of its angle.
    spin: Vector3<T>,
}

impl<T: Scalar> Along<T> {
    fn new() -> Self {
        Self {
            product: Rotation::identity(),
            spin: Vector3::zeros(),
        }
    }

    // Not inlined, nor is `jet`, so that an image has them once.
    /// Folds about the next axis by an angle (radians) that changes at this rate.
    #[inline(never)]
    fn cross(&mut self, angle: T, rate: T, axis: [T; 2]) {
        self.spin += self.product.rotate_in_sheet(axis) * rate;
        self.product = self.product.across_crease(half_angle(angle), axis);
    }

    /// Returns the closure residual and its derivative, if the star ends here.
    #[inline(never)]
    fn jet(&self) -> [Vector3<T>; 2] {
        let product = positive(self.product);
        [product.v * T::TWO, derivative(product, &self.spin)]
    }
}

/// Multiplies the first `length - 3` quaternions by a fold about the axis (x, y, 0), in place; the product has `length`.
#[inline(never)]
fn across<T: Scalar>(
    product: &mut [[T; 5]],
    length: usize,
    [cos, sin]: [[T; 4]; 2],
    [x, y]: [T; 2],
) {
    for k in (0..length).rev() {
        let mut sum = [T::zero(); 5];
        for (i, (c, n)) in cos.iter().zip(&sin).enumerate() {
            let before = k.checked_sub(i).and_then(|before| product.get(before));
            let Some(&[w, a, b, d, size]) = before else {
                break;
            };
            let terms = [
                w * *c - (a * x + b * y) * *n,
                a * *c + (w * x - d * y) * *n,
                b * *c + (w * y + d * x) * *n,
                d * *c + (a * y - b * x) * *n,
                size * (c.abs() + n.abs()),
            ];
            for (sum, term) in sum.iter_mut().zip(terms) {
                *sum += term;
            }
        }
        if let Some(place) = product.get_mut(k) {
            *place = sum;
        }
    }
}

/// Returns `true` if `holds` is true for parts `[from, to]` that cover the segment.
// Not generic over the condition, so that an image has the loop once.
#[inline(never)]
fn everywhere<T: Scalar>(holds: &mut dyn FnMut([T; 2]) -> bool) -> bool {
    let mut part = Part::default();
    loop {
        match part.judged(holds(part.ends())) {
            Judged::Everywhere => return true,
            Judged::Not => return false,
            Judged::Next(next) => part = next,
        }
    }
}

/// Returns the scaled coefficients of a cubic.
fn scaled<T: Scalar>([a, b, c, d]: [T; 4]) -> [T; 4] {
    let three = T::TWO + T::one();
    [a, three * b, three * c, d]
}

/// Returns the scaled coefficients of the derivative of a cubic.
fn slope<T: Scalar>(cubic: [T; 4]) -> [T; 3] {
    let three = T::TWO + T::one();
    let [a, b, c] = differences(&cubic);
    [three * a, three * T::TWO * b, three * c]
}

/// Adds the product of two polynomials in scaled coefficients, times `factor`, to `sum`.
#[inline(never)]
fn multiply<T: Scalar>(a: &[T], b: &[T], factor: T, sum: &mut [T]) {
    for (i, a) in a.iter().enumerate() {
        for (b, sum) in b.iter().zip(sum.iter_mut().skip(i)) {
            *sum += *a * *b * factor;
        }
    }
}
