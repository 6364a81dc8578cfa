//! Chooses the crease groups and the route on them: symmetry is a shortcut, and a path that is not found with it is
//! looked for without it.

use super::follow::Waypoint;
use super::reduction::{CLOSED, EXPECTED_AMPLIFICATION, Reduction, SAME_RAD};
use super::route::{End, Route};
use crate::planner::Symmetry;
use crate::planner::plan::Effort;
use crate::planner::problem::{ErrorModel, PlanningProblem};
use crate::planner::reason::{GroupsDropped, Note};
use crate::progress::Stage;
use crate::symmetry::{CreaseGroups, closure_of};

/// Fraction of the goal by which a path has to lead farther than another one to be preferred to it, although it has
/// less symmetry or moved coordinates.
pub(crate) const FARTHER_RATIO: f64 = 0.01;

/// Finds the route that leads farthest. Its notes, times and work are those of all routes that were tried. Returns `None`
/// if the error model changes nothing of this sheet, or allows no path.
pub(crate) fn select_route<'a>(problem: &PlanningProblem<'a>) -> Option<Route<'a>> {
    match problem.errors {
        ErrorModel::Exact => among_groups(problem),
        ErrorModel::Measured => on_measured_stars(problem),
        ErrorModel::Snapped { coarse, .. } => on_snapped_stars(problem, coarse),
    }
}

/// Finds the route that leads farthest on any of the proposed crease groups, and without any.
fn among_groups<'a>(problem: &PlanningProblem<'a>) -> Option<Route<'a>> {
    let (pattern, goal) = (problem.pattern, problem.goal);
    let (proposals, asked_closure) = problem.stage(Stage::Symmetry, || {
        let proposals = proposals(problem);
        let is_needed = !proposals.is_empty();
        let closure = is_needed.then(|| closure_of(pattern, &goal.fold_angles));
        (proposals, closure.flatten())
    });
    let exact = asked_closure.is_some_and(|closure| closure <= CLOSED);
    let mut effort = Effort::default();
    let mut notes = Vec::new();
    let mut best: Option<Route<'_>> = None;
    let mut symmetric: Option<Reduction<'_>> = None;
    let without = core::iter::once_with(|| (CreaseGroups::trivial(pattern), false));
    for (groups, exactly) in proposals.into_iter().chain(without) {
        // A goal far away is not what was asked for: with every crease free, one may be nearer. If the goal closes as
        // asked, with every crease on its own, a goal beside it is not what was asked for either.
        let reach = if exact && !groups.is_trivial() {
            SAME_RAD
        } else {
            goal.reach
        };
        let reduction = problem.stage(Stage::Symmetry, || Reduction::of(problem, groups));
        let route = Route::find(problem, reduction, reach, exactly);
        effort += route.effort;
        let dropped = match best.take() {
            Some(before) if before.rank() + FARTHER_RATIO >= route.rank() => {
                best = Some(before);
                None
            }
            before => {
                best = Some(route);
                before
            }
        };
        if let Some(dropped) = dropped.filter(|dropped| !dropped.exactly) {
            notes.push(Note::GroupsDropped {
                groups: dropped.reduction.groups.len(),
                why: match dropped.end {
                    End::NotClosed { .. } => GroupsDropped::GoalNotClosed,
                    _ => GroupsDropped::FoldsFarther,
                },
            });
            symmetric = Some(dropped.reduction);
        }
        if best.as_ref().is_some_and(Route::is_complete) {
            break;
        }
    }
    let mut route = best?;
    notes.append(&mut route.notes);
    effort.is_random = route.effort.is_random;
    Some(Route {
        notes,
        effort,
        symmetric,
        asked_closure,
        ..route
    })
}

/// Finds the route that leads farthest among the crease groups, if the goal closes as well as that needs; then, if that does
/// not arrive, one on which the sheet nearly closes.
fn on_measured_stars<'a>(problem: &PlanningProblem<'a>) -> Option<Route<'a>> {
    let goal = problem.goal;
    let off = closure_of(problem.pattern, &goal.fold_angles)?;
    let is_near = off <= problem.options.bound / EXPECTED_AMPLIFICATION;
    let exact = is_near.then(|| among_groups(problem)).flatten();
    let arrives = |route: &Route<'_>| match (route.end, route.waypoints.last()) {
        (End::Reached, Some(last)) => {
            route.reduction.distance(&last.angles, goal) <= problem.options.goal_tolerance
        }
        _ => false,
    };
    if exact.as_ref().is_some_and(arrives) || problem.is_late() {
        return exact;
    }
    Route::nearly_closed(problem).or(exact)
}

/// Finds the route of every crease on its own, with stars that are taken to fold flat exactly where they nearly do.
/// Returns `None` if no star changes, or the sheet as it is does not close as well along the route as the bound needs.
fn on_snapped_stars<'a>(problem: &PlanningProblem<'a>, coarse: bool) -> Option<Route<'a>> {
    let PlanningProblem {
        pattern,
        goal,
        options,
        ..
    } = *problem;
    let (reduction, turned) = problem.stage(Stage::Symmetry, || {
        let reduction = Reduction::of(problem, CreaseGroups::trivial(pattern));
        reduction.snapped(pattern, goal, options, coarse)
    })?;
    let mut route = Route::find(problem, reduction, goal.reach, false);
    let reduction = &route.reduction;
    let open = |waypoint: &Waypoint| reduction.closure_of_sheet(&waypoint.angles);
    let closes = |waypoint| open(waypoint) <= reduction.closure_tolerance(options);
    if route.waypoints.is_empty() || !route.waypoints.iter().all(closes) {
        return None;
    }
    route.notes.push(Note::Snapped { turned });
    Some(route)
}

/// Returns crease groups to try one after the other, each with `true` if the goal has to close exactly under them. Groups
/// of a finer symmetry fold the sheet more exactly, if they fold it at all.
fn proposals(problem: &PlanningProblem<'_>) -> Vec<(CreaseGroups, bool)> {
    let pattern = problem.pattern;
    let mut found = Vec::new();
    if problem.options.symmetry == Symmetry::Auto {
        let groups = CreaseGroups::find_until(pattern, problem.watch);
        let fine = groups.is_rough().then(|| CreaseGroups::find_exact(pattern));
        found.extend(fine.clone().map(|fine| (fine, true)));
        // A symmetry that exchanges mountain and valley may hold for the drawing and not for its motion.
        let parted = groups.parted_by_sign();
        let is_finer = parted.len() > groups.len();
        found.push((groups, false));
        found.extend(fine.map(|fine| (fine, false)));
        found.extend(is_finer.then_some((parted, false)));
    }
    found.retain(|(groups, _)| !groups.is_trivial());
    found
}
