//! Checks of a setpoint before a controller follows it: is it valid, within limits, and closed?
//!
//! A setpoint and the segment that leads to it are checked once, when they arrive. Angles, rates and accelerations are
//! checked at nine places of the segment. For cubics of the angle they are also checked where they are largest, which
//! makes the check exact. For half angles, angles and rates are also bounded between these places. Closure is checked
//! at the setpoint, and bounded on the whole segment.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::bernstein::differences;
use crate::curve::Flaw;
use crate::numbers::Numbers;
use crate::segment_bounds::{self, Judged, Part};
use crate::{Curve, GroupLimits, Interpolation, Node, Scalar, StarsView, closure};

/// Number of intervals between the checked places of a segment.
const CHECKED_INTERVALS: u32 = 8;
/// Rounding error by which a curve's value and derivatives may miss a limit, in precisions (ε) of the largest number that
/// goes into the curve. The second derivative sums six products of four numbers.
const CURVE_EPSILONS: f64 = 24.0;
/// Rounding error that a commanded angle adds to a closure residual, in precisions (ε).
const CLOSURE_EPSILONS: f64 = 16.0;

/// Description of the sheet, as far as a controller knows it.
#[derive(Clone, Copy, Debug)]
pub struct SheetView<'a, T> {
    /// Kind of motion between setpoints.
    pub interpolation: Interpolation,
    /// Limits of each group.
    pub limits: &'a [GroupLimits<T>],
    /// The essential vertices, with the groups as unknowns.
    pub stars: StarsView<'a, T>,
    /// Largest closure residual of a commanded configuration (dimensionless): the value that the host has certified,
    /// plus rounding.
    pub closure: T,
}

/// One knot of a path as sent to a controller, of at most `GROUPS` groups.
#[derive(Clone, Debug, PartialEq)]
pub struct Setpoint<T, const GROUPS: usize> {
    /// Number of the knot in its path.
    pub number: u32,
    /// Seconds since the knot before. They do not count at the first setpoint that is followed.
    pub span: T,
    /// `true` if the path ends here.
    pub last: bool,
    /// Angle, rate and weight of each group; weight 1 with rate 0 if the interpolation has no weights.
    pub nodes: Vec<Node<T>, GROUPS>,
}

/// Reason why a setpoint is not followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "Numbers")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// Nothing is being followed: there is no sheet, or the motion is done or has failed.
    State,
    /// The queue is full.
    Full,
    /// The setpoint is not the next one. The next one would have this number, unless the path has ended.
    Sequence(u32),
    /// The setpoint does not have one angle for each group.
    Groups,
    /// The span, or a number of this group, is infinite or NaN.
    NotFinite(u16),
    /// This group is at half a turn, where its interpolation has a pole.
    HalfTurn(u16),
    /// The weight of this group is not above 0.
    Weight(u16),
    /// The setpoint is not later than the one before.
    Order,
    /// The angle of this group passes its limits, at the setpoint or on the segment.
    Range(u16),
    /// This group exceeds its speed on the segment.
    Speed(u16),
    /// This group exceeds its acceleration on the segment.
    Acceleration(u16),
    /// This essential vertex does not close at the setpoint.
    Open(u16),
    /// This essential vertex does not close everywhere on the segment.
    OpenBetween(u16),
}

impl From<Refusal> for Numbers {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::State => Self::variant(0),
            Refusal::Full => Self::variant(1),
            Refusal::Sequence(next) => Self::of(2, next),
            Refusal::Groups => Self::variant(3),
            Refusal::NotFinite(group) => Self::of(4, group),
            Refusal::HalfTurn(group) => Self::of(5, group),
            Refusal::Weight(group) => Self::of(6, group),
            Refusal::Order => Self::variant(7),
            Refusal::Range(group) => Self::of(8, group),
            Refusal::Speed(group) => Self::of(9, group),
            Refusal::Acceleration(group) => Self::of(10, group),
            Refusal::Open(star) => Self::of(11, star),
            Refusal::OpenBetween(star) => Self::of(12, star),
        }
    }
}

impl core::fmt::Display for Refusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::State => write!(f, "nothing is being followed"),
            Self::Full => write!(f, "the queue is full"),
            Self::Sequence(next) => write!(f, "expected setpoint {next}"),
            Self::Groups => write!(f, "expected an angle for each group"),
            Self::NotFinite(group) => write!(f, "group {group}: expected finite numbers"),
            Self::HalfTurn(group) => write!(f, "group {group}: expected less than half a turn"),
            Self::Weight(group) => write!(f, "group {group}: expected a weight above 0"),
            Self::Order => write!(f, "expected a later time than before"),
            Self::Range(group) => write!(f, "group {group}: beyond its limits"),
            Self::Speed(group) => write!(f, "group {group}: too fast"),
            Self::Acceleration(group) => write!(f, "group {group}: accelerated too much"),
            Self::Open(star) => write!(f, "essential vertex {star} does not close"),
            Self::OpenBetween(star) => {
                write!(
                    f,
                    "essential vertex {star} does not close between setpoints"
                )
            }
        }
    }
}

impl core::error::Error for Refusal {}

/// Essential vertex and part of a segment whose closure is bounded next.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Progress {
    star: u16,
    part: Part,
}

/// Checks `next` as the setpoint behind `before`, if there is one: all but its number and the bounds on closure.
pub(crate) fn check_places<T: Scalar, const GROUPS: usize>(
    sheet: &SheetView<'_, T>,
    before: Option<&Setpoint<T, GROUPS>>,
    next: &Setpoint<T, GROUPS>,
) -> Result<(), Refusal> {
    if next.nodes.len() != sheet.limits.len() || sheet.stars.unknowns() != sheet.limits.len() {
        return Err(Refusal::Groups);
    }
    if !next.span.is_finite() {
        return Err(Refusal::NotFinite(0));
    }
    if before.is_some() && next.span <= T::zero() {
        return Err(Refusal::Order);
    }
    let mut angles = [T::zero(); GROUPS];
    for ((group, angle), (node, limits)) in groups(angles.iter_mut()).zip(pairs(next, sheet)) {
        match node.flaw(sheet.interpolation) {
            Some(Flaw::NotFinite) => return Err(Refusal::NotFinite(group)),
            Some(Flaw::HalfTurn) => return Err(Refusal::HalfTurn(group)),
            Some(Flaw::Weight) => return Err(Refusal::Weight(group)),
            None if !limits.allow(node.angle) => return Err(Refusal::Range(group)),
            None => *angle = node.angle,
        }
    }
    let open = |(_, star): &(u16, _)| !closure::closes_at(*star, &angles, sheet.closure);
    if let Some((star, _)) = groups(sheet.stars.iter()).find(open) {
        return Err(Refusal::Open(star));
    }
    let Some(before) = before else {
        return Ok(());
    };
    let span = next.span;
    let ways = before.nodes.iter().zip(pairs(next, sheet));
    for (group, (from, (to, limits))) in groups(ways) {
        let curve = Curve::between(sheet.interpolation, span, *from, *to);
        // Linear segments do not use the rates of the knots.
        let lines = sheet.interpolation == Interpolation::Linear;
        let rate = if lines {
            T::zero()
        } else {
            from.rate.abs().max(to.rate.abs())
        };
        let size = T::one() + from.angle.abs().max(to.angle.abs()) + span * rate;
        keeps(group, &curve, span, size, limits)?;
    }
    Ok(())
}

/// Goes on to check that the essential vertices stay closed on a segment, by at most `parts` parts of it. Returns `true` if
/// nothing is left to check.
pub(crate) fn check_bounds<T: Scalar, const GROUPS: usize>(
    sheet: &SheetView<'_, T>,
    before: Option<&Setpoint<T, GROUPS>>,
    next: &Setpoint<T, GROUPS>,
    progress: &mut Progress,
    parts: u32,
) -> Result<bool, Refusal> {
    let Some(before) = before else {
        return Ok(true);
    };
    let curve = |group: usize| {
        let (from, to) = (before.nodes.get(group)?, next.nodes.get(group)?);
        Some(Curve::between(sheet.interpolation, next.span, *from, *to))
    };
    go_on(sheet.stars, &curve, sheet.closure, progress, parts)
}

/// Goes on to check that the stars stay closed on a segment, by at most `parts` parts of it. Returns `true` if nothing is
/// left to check.
fn go_on<T: Scalar>(
    stars: StarsView<'_, T>,
    curve: &impl Fn(usize) -> Option<Curve<T>>,
    closure: T,
    progress: &mut Progress,
    parts: u32,
) -> Result<bool, Refusal> {
    for _ in 0..parts {
        let Some(star) = stars.get(progress.star.into()) else {
            return Ok(true);
        };
        match segment_bounds::stays_closed(star, curve, closure, progress.part) {
            Judged::Everywhere => {
                progress.star = progress.star.saturating_add(1);
                progress.part = Part::default();
            }
            Judged::Not => return Err(Refusal::OpenBetween(progress.star)),
            Judged::Next(part) => progress.part = part,
        }
    }
    Ok(stars.get(progress.star.into()).is_none())
}

/// Returns the largest closure residual of a vertex with this number of spokes at commanded angles of a path, whose
/// setpoints are closed within `closure`: bounds and the rounding of commands add to that.
pub fn most_commanded<T: Scalar>(closure: T, spokes: usize) -> T {
    let mut most = closure * segment_bounds::slack();
    for _ in 0..spokes {
        most += T::lit(CLOSURE_EPSILONS) * T::EPSILON;
    }
    most
}

/// Checks that all essential vertices stay closed on a segment, as a controller does before it takes a setpoint. `curve`
/// returns the curve of a group.
///
/// # Errors
/// [`Refusal::OpenBetween`] for the first vertex whose residual is not known to be at most `closure`, a sixteenth and
/// rounding.
pub fn stay_closed<T: Scalar>(
    stars: StarsView<'_, T>,
    curve: impl Fn(usize) -> Option<Curve<T>>,
    closure: T,
) -> Result<(), Refusal> {
    let mut progress = Progress::default();
    while !go_on(stars, &curve, closure, &mut progress, u32::MAX)? {}
    Ok(())
}

/// Pairs each item with the number of its group (or star).
fn groups<I: Iterator>(items: I) -> impl Iterator<Item = (u16, I::Item)> {
    (0..=u16::MAX).zip(items)
}

/// Pairs the groups of a setpoint with their limits.
fn pairs<'a, T: Scalar, const GROUPS: usize>(
    setpoint: &'a Setpoint<T, GROUPS>,
    sheet: &SheetView<'a, T>,
) -> impl Iterator<Item = (&'a Node<T>, &'a GroupLimits<T>)> {
    setpoint.nodes.iter().zip(sheet.limits)
}

/// Checks the limits of a group on a segment of `span` seconds; `size` is the size of the numbers that go into its
/// curve.
fn keeps<T: Scalar>(
    group: u16,
    curve: &Curve<T>,
    span: T,
    size: T,
    limits: &GroupLimits<T>,
) -> Result<(), Refusal> {
    let noise = T::EPSILON * T::lit(CURVE_EPSILONS) * size;
    let slow = limits.speed * span + noise;
    let gentle = limits.acceleration * span * span + noise;
    let keeps = |s: T| {
        let angle = curve.angle(s);
        let [rate, bend] = curve.derivatives(s).map(T::abs);
        let within = limits.lower - noise <= angle && angle <= limits.upper + noise;
        let kept = |kept: bool, refusal| if kept { Ok(()) } else { Err(refusal) };
        kept(within, Refusal::Range(group))?;
        kept(rate <= slow, Refusal::Speed(group))?;
        kept(bend <= gentle, Refusal::Acceleration(group))
    };
    let step = T::one() / T::whole(CHECKED_INTERVALS);
    let extremes = extremes(curve);
    // One loop over all places, so that an image has the check once.
    for place in 0..=CHECKED_INTERVALS + 3 {
        let extreme = place.checked_sub(CHECKED_INTERVALS + 1);
        let extreme = extreme.and_then(|k| extremes.get(k as usize));
        keeps(extreme.copied().unwrap_or(T::whole(place) * step))?;
    }
    let Curve::HalfAngle { cos, sin } = *curve else {
        return Ok(());
    };
    let pair = [cos, sin];
    if !segment_bounds::stays_within(pair, limits.lower, limits.upper) {
        return Err(Refusal::Range(group));
    }
    let speed = limits.speed * span;
    if speed.is_finite() && !segment_bounds::turns_slowly(pair, speed, noise) {
        return Err(Refusal::Speed(group));
    }
    Ok(())
}

/// Returns the parameters within a segment at which a cubic of the angle turns back (two) and at which its rate is
/// largest; 0 stands for none.
#[inline(never)]
fn extremes<T: Scalar>(curve: &Curve<T>) -> [T; 3] {
    let Curve::Angle(angle) = curve else {
        return [T::zero(); 3];
    };
    // The rate is three times the quadratic A s² + 2 B s + C. Its zero without cancellation is computed first; the
    // other one follows from their product C/A.
    let [p, q, r] = differences(angle);
    let (bend, slope) = (p - T::TWO * q + r, q - p);
    let root = (slope * slope - bend * p).sqrt();
    let sum = if slope < T::zero() {
        root - slope
    } else {
        -root - slope
    };
    [sum / bend, p / sum, -slope / bend].map(|s| {
        let inside = s > T::zero() && s < T::one();
        if inside { s } else { T::zero() }
    })
}
