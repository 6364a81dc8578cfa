//! Checks the turns of hinges between knots: none may turn against its assignment (letter), or beyond half a
//! turn.

use foldpath_core::Curve;

use super::finding::{Failure, Moment, WrongTurn};
use super::{MergedGroups, SAME_ANGLE};
use crate::pattern::CreasePattern;

/// Returns the first hinge that turns the wrong way between two knots.
pub(super) fn wrong_turn(pattern: &CreasePattern, motion: &MergedGroups) -> Option<Failure> {
    let segments = motion.segments.iter().enumerate();
    let mut curves = segments.flat_map(|(segment, curves)| {
        let leaders = curves.iter().zip(&motion.leaders);
        leaders.map(move |(curve, &edge)| (segment, curve, edge))
    });
    curves.find_map(|(segment, curve, edge)| {
        let letter = pattern.edge(edge).letter;
        extremes(curve).into_iter().find_map(|s| {
            let value = curve.angle(s);
            let wrong = if value * letter.sign() < -SAME_ANGLE {
                WrongTurn::AgainstLetter
            } else if value.abs() > core::f64::consts::PI + SAME_ANGLE {
                WrongTurn::BeyondHalfTurn
            } else if value.is_nan() {
                WrongTurn::NotANumber
            } else {
                return None;
            };
            let at = Moment::Between { segment, s };
            Some(Failure::Turns {
                at,
                edge,
                letter,
                wrong,
                value,
            })
        })
    })
}

/// Returns the places in the segment at which the fold angle can be farthest from 0 on either side, except for
/// rounding of the second order: the turning points of cubics. For a homogeneous half angle (c, n) these are
/// the cubics c and n: n changes its sign with the angle, and c at half a turn.
fn extremes(curve: &Curve<f64>) -> Vec<f64> {
    let cubics = match curve {
        Curve::Angle(angle) => [Some(angle), None],
        Curve::HalfAngle { cos, sin } => [Some(cos), Some(sin)],
    };
    let turns = cubics.into_iter().flatten().flat_map(turning_points);
    turns.chain([0.0, 1.0]).collect()
}

/// Returns the zeros between 0 and 1 of the derivative of a cubic with these Bernstein coefficients.
fn turning_points([a, b, c, d]: &[f64; 4]) -> impl Iterator<Item = f64> + use<> {
    // The derivative over 3 is x (1 - s)² + 2 y s (1 - s) + z s².
    let (x, y, z) = (b - a, c - b, d - c);
    let (second, first) = (x - 2.0 * y + z, y - x);
    let root = (first * first - second * x).max(0.0).sqrt();
    // Zeros of second s² + 2 first s + x, without cancellation.
    let sum = -(first + root.copysign(first));
    let zeros = [sum / second, x / sum];
    zeros.into_iter().filter(|s| *s > 0.0 && *s < 1.0)
}
