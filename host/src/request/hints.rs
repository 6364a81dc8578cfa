//! Hints on common mistakes: angles in radians, edges that are no hinges.

use core::f64::consts::PI;

use crate::pattern::{CreasePattern, EdgeId};
use crate::planner::CLOSED;
use crate::symmetry::closure_of;

/// Largest distance from π at which the largest goal angle, read as degrees, seems to be half a turn in radians.
const SAME_ANGLE: f64 = 1e-3;
/// Largest closure residual of a goal that was given in rounded radians.
const NEARLY_CLOSED: f64 = 1e-3;

/// Returns a hint if the goal angles, which are taken as degrees and do not close, seem to be radians. `closure` is the
/// residual with which the goal closes, if it is known.
#[must_use]
pub fn radians_hint(pattern: &CreasePattern, closure: Option<f64>) -> Option<String> {
    let goals = pattern
        .creases()
        .iter()
        .map(|&edge| pattern.edge(edge).goal);
    let goals: Vec<Option<f64>> = goals.collect();
    let largest = goals
        .iter()
        .flatten()
        .fold(0.0, |most: f64, goal| most.max(goal.to_degrees().abs()));
    let closed = closure.is_none_or(|closure| closure <= CLOSED);
    if closed || largest <= 0.0 || largest > PI + SAME_ANGLE {
        return None;
    }
    let meant: Vec<Option<f64>> = goals.iter().map(|goal| goal.map(f64::to_degrees)).collect();
    let closes = closure_of(pattern, &meant).is_some_and(|closure| closure <= NEARLY_CLOSED);
    (closes || (largest - PI).abs() <= SAME_ANGLE).then(|| {
        format!(
            "no goal angle is beyond {largest:.4} degrees, and they do not close: if they are radians, convert them, \
             as edges_foldAngle is in degrees"
        )
    })
}

/// Names the hinge nearest to an edge that is no hinge, in words. If the pattern has no such edge, names its first
/// hinge.
pub(super) fn nearest_hinge(pattern: &CreasePattern, edge: usize) -> Option<String> {
    let middle = |edge: EdgeId| {
        let [a, b] = pattern
            .edge(edge)
            .ends
            .map(|end| pattern.vertices()[end.index()]);
        (a + b) / 2.0
    };
    let known = edge < pattern.edges().len();
    let here = known.then(|| middle(EdgeId::new(edge)));
    let hinges = pattern
        .creases()
        .iter()
        .filter(|hinge| pattern.edge(**hinge).letter.sign().abs() > 0.0);
    let far = |hinge: &EdgeId| match here {
        Some(here) => (middle(*hinge) - here).norm(),
        None => 0.0,
    };
    let nearest = hinges.min_by(|a, b| far(a).total_cmp(&far(b)))?;
    let letter = pattern.edge(*nearest).letter.code();
    let edge = format!("edge {} ({letter})", nearest.index());
    Some(if known {
        format!("the nearest hinge is {edge}")
    } else {
        format!("{edge} is a hinge")
    })
}
