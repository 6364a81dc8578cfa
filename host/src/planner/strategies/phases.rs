//! Folding in phases where something is in the way if all creases turn at once.

use super::rows::Context;
use super::stops::is_free;
use crate::planner::following::judge::Judge;
use crate::planner::following::reduction::{Reduction, snapping_angle};
use crate::planner::following::route::{End, Route};
use crate::planner::plan::{Attempt, Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{Reason, TimeoutAt};
use crate::planner::{GoalKind, Search};
use crate::symmetry::{CreaseGroups, ReducedStars};
use crate::util::clock::Instant;

/// Looks for a plan in phases to the goal of a route, given as fold angles in radians, and lists the attempt. If `find`
/// finds none, the reason is `none`. Returns `None` if there is none, or no phases lead to this goal.
pub(crate) fn try_phases(
    context: &Context<'_>,
    attempts: &mut Vec<Attempt>,
    none: Reason,
    find: impl FnOnce(&[f64]) -> Option<Plan>,
) -> Option<Plan> {
    let problem = context.problem;
    let goal = goal_of_phases(problem, context.route?)?;
    let start = Instant::now();
    let found = find(&goal);
    let (outcome, reason) = match &found {
        Some(_) => (Outcome::Planned, None),
        None if problem.is_late() => (
            Outcome::Timeout,
            Some(Reason::OutOfTime(TimeoutAt::LookingForOtherWays)),
        ),
        None => (Outcome::Partial, Some(none)),
    };
    attempts.push(Attempt {
        strategy: context.row.strategy,
        outcome,
        reason,
        seconds: start.elapsed().as_secs_f64(),
    });
    found
}

/// Returns the fold angles (radians) to which creases may be folded one after the other, if they may be: the goal of
/// `route`, if that closes as it is or its errors are snapped, and no faces cross there.
fn goal_of_phases(problem: &PlanningProblem<'_>, route: &Route<'_>) -> Option<Vec<f64>> {
    let fits = problem.goal.via.is_empty()
        && problem.goal.kind != GoalKind::Driven
        && problem.options.search == Search::Auto;
    let end = match route.end {
        End::Reached => Some(route.last()),
        _ => route.goal.as_deref(),
    };
    let closes = || problem.errors.is_snapped() || closing_angle(problem, route).is_none();
    let end = end.filter(|_| fits && closes())?;
    let goal = route.reduction.groups.expand(end);
    let reduction = Reduction::of(problem, CreaseGroups::trivial(problem.pattern));
    let mut judge = Judge::new(problem, &reduction, problem.options.collision);
    let closure_tolerance = reduction.closure_tolerance(problem.options);
    is_free(&mut judge, &reduction.groups, &goal, closure_tolerance).then_some(goal)
}

/// Returns the angle (radians) by which creases are off, if the goal closes but for rounding; so do the goal's parts
/// then.
fn closing_angle(problem: &PlanningProblem<'_>, route: &Route<'_>) -> Option<f64> {
    let stars = ReducedStars::of_creases(problem.pattern);
    let most = route.reduction.closure_tolerance(problem.options);
    snapping_angle(&stars, &problem.goal.fold_angles, most, false)
}
