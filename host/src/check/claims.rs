//! Compares what a file claims of the whole motion with what is measured: largest speed and acceleration of a hinge, and
//! at knots the distance of faces; and the bound within which it says that it was planned.

use super::clearance::knot_clearances;
use super::finding::{Failure, RateLimit, Undecided};
use super::{Measured, MergedGroups, Verdict};
use crate::collision::SearchedSheet;
use crate::folding::Rigidity;
use crate::motion::Motion;

/// Number of equal parts of a segment at whose ends speeds are measured.
const SPEED_PARTS: u8 = 64;
/// Ratio of a measured speed or acceleration to a claim above which the claim is false: peaks between samples are not
/// seen.
const RATE_RATIO: f64 = 1.001;
/// Difference of the speeds of a hinge before and after a knot up to which they are equal, as a fraction of the largest
/// speed.
const SAME_RATE_RATIO: f64 = 1e-6;
/// Relative error of a claim that rounding explains.
const ROUNDING_RATIO: f64 = 1e-6;

/// Largest speed (radians per second) and acceleration (radians per second squared) of a hinge, between knots and at
/// them. The acceleration is `None` if a hinge changes its speed at once, as at the start of a motion that does not begin
/// at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates {
    /// Largest speed.
    pub speed: f64,
    /// Largest acceleration.
    pub acceleration: Option<f64>,
}

impl Rates {
    /// Measures the rates of a motion at 65 places of each segment. Cost: O(segments · groups).
    pub(super) fn of(path: &Motion, motion: &MergedGroups) -> Self {
        let (mut speed, mut acceleration) = (0.0_f64, 0.0_f64);
        let (mut before, mut jump) = (vec![0.0; motion.leaders.len()], 0.0_f64);
        for (pair, curves) in path.knots.windows(2).zip(&motion.segments) {
            let span = pair[1].time - pair[0].time;
            for (before, curve) in before.iter_mut().zip(curves) {
                for part in 0..=SPEED_PARTS {
                    let s = f64::from(part) / f64::from(SPEED_PARTS);
                    let [first, second] = curve.derivatives(s);
                    let rate = first / span;
                    speed = speed.max(rate.abs());
                    acceleration = acceleration.max((second / (span * span)).abs());
                    if part == 0 {
                        jump = jump.max((rate - *before).abs());
                    }
                    *before = rate;
                }
            }
        }
        for before in before {
            jump = jump.max(before.abs());
        }
        Self {
            speed,
            acceleration: (jump <= SAME_RATE_RATIO * speed).then_some(acceleration),
        }
    }
}

/// Returns the claims on speed and acceleration that are false.
pub(super) fn false_rates(path: &Motion, rates: Rates) -> Vec<Failure> {
    let acceleration = rates.acceleration.unwrap_or(f64::INFINITY);
    let claims = [
        (RateLimit::Speed, path.max_speed, rates.speed),
        (RateLimit::Acceleration, path.max_acceleration, acceleration),
    ];
    let claims = claims
        .into_iter()
        .filter_map(|(limit, claim, found)| Some((limit, claim?, found)));
    let wrong = claims.filter(|(_, claimed, found)| *found > RATE_RATIO * claimed);
    let failures = wrong.map(|(limit, claimed, found)| Failure::FalseRate {
        limit,
        claimed,
        found,
    });
    failures.collect()
}

/// Judges the claims on distances at knots: returns those that are false, and those of which nothing is known.
pub(super) fn judge_clearances(
    path: &Motion,
    (motion, sheet): (&MergedGroups, &SearchedSheet<'_>),
    measured: &[Measured],
) -> (Vec<Failure>, Vec<Undecided>) {
    let (mut wrong, mut unknown) = (Vec::new(), Vec::new());
    let mut claims = path.knots.iter().map(|knot| knot.claims.clearance);
    if claims.all(|claim| claim.is_none()) {
        return (wrong, unknown);
    }
    let found = knot_clearances(path, (motion, sheet), measured);
    for (knot, (data, found)) in path.knots.iter().zip(found).enumerate() {
        let Some(claimed) = data.claims.clearance else {
            continue;
        };
        match found {
            None => unknown.push(Undecided::Clearance { knot, claimed }),
            Some(found) if claimed <= found * (1.0 + ROUNDING_RATIO) => {}
            Some(found) => wrong.push(Failure::FalseClearance {
                knot,
                claimed,
                found,
            }),
        }
    }
    (wrong, unknown)
}

/// Returns the claim that the motion was planned within a bound, if errors were found that are larger.
pub(super) fn false_bound(path: &Motion, verdict: &Verdict) -> Option<Failure> {
    let answer = path.answer.as_ref().filter(|answer| answer.is_planned())?;
    let Rigidity {
        deformation, gap, ..
    } = verdict.rigidity();
    let errors = [deformation, gap, verdict.closure()];
    let found = errors.into_iter().fold(0.0, f64::max);
    (found > answer.bound * (1.0 + ROUNDING_RATIO)).then_some(Failure::FalseBound {
        claimed: answer.bound,
        found,
    })
}
