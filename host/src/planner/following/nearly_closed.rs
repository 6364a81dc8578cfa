//! A way on which the sheet nearly closes, for sheets whose coordinates are rounded: no configuration of theirs but flat
//! need close exactly, and the exact motions of a sheet that is off by its last digits may end anywhere.
//!
//! One hinge leads from its goal angle back to flat. At each of its angles the others are moved to the least residual near
//! by. The leading hinge keeps its angle, as flat, where everything closes, would draw the sheet to itself.

use super::follow::Waypoint;
use super::reduction::Reduction;
use super::search::polyline;
use crate::planner::PlanOptions;
use crate::planner::vectors::max_difference;

/// Turn of the leading hinge from one configuration to the next, as a fraction of the largest step: the way between two is
/// that of the chords of their neighbours.
const STEP_RATIO: f64 = 0.25;
/// Fold angle beyond which the tangent of half the angle says little of the next configuration, radians.
const BLUNT_RAD: f64 = 3.1;

/// Leads from flat to the group angles `goal` by way of configurations whose closure residual is at most `within`. The last
/// one is the goal itself. Returns `None` if the way ends.
pub(super) fn nearly_closed(
    reduction: &Reduction<'_>,
    goal: &[f64],
    options: &PlanOptions,
    within: f64,
) -> Option<Vec<Waypoint>> {
    let sizes = goal.iter().map(|angle| angle.abs()).enumerate();
    let (lead, size) = sizes.max_by(|a, b| a.1.total_cmp(&b.1))?;
    if reduction.closure_of_sheet(goal) > within {
        return None;
    }
    let mut solver = reduction.solver(options, within);
    let limits = reduction.orthant(&goal.iter().map(|angle| angle.signum()).collect::<Vec<_>>());
    let steps = (size / (STEP_RATIO * options.max_step)).ceil().max(2.0);
    let mut knots = vec![goal.to_vec()];
    let mut left = steps - 1.0;
    while left > 0.0 {
        let here = &knots[knots.len() - 1];
        let led = goal[lead] * (left / steps);
        let predicted = nearer_flat(here, lead, led);
        let mut next = predicted.clone();
        solver.limits.clone_from(&limits);
        solver.limits[lead] = (led, led);
        solver.close(&mut next);
        let is_near = max_difference(&next, &predicted) <= options.max_step;
        if !is_near || reduction.closure_of_sheet(&next) > within || solver.is_late() {
            return None;
        }
        knots.push(next);
        left -= 1.0;
    }
    knots.push(vec![0.0; goal.len()]);
    knots.reverse();
    Some(polyline(&knots))
}

/// Returns a prediction of the configuration in which the hinge `lead` has the angle `led`, radians: the tangents of half
/// the angles keep their ratio, as they do at vertices of four creases that fold flat.
fn nearer_flat(angles: &[f64], lead: usize, led: f64) -> Vec<f64> {
    let tangent = |angle: f64| (angle / 2.0).tan();
    let from = angles[lead];
    let is_blunt = from.abs() > BLUNT_RAD;
    let angle = |&angle: &f64| {
        if is_blunt || angle.abs() > BLUNT_RAD {
            angle * (led / from)
        } else {
            2.0 * (tangent(angle) * (tangent(led) / tangent(from))).atan()
        }
    };
    let mut next: Vec<f64> = angles.iter().map(angle).collect();
    next[lead] = led;
    next
}
