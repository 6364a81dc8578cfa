//! One pass through all stages under one error model: goal, reduction, reduced path, knots, certified motion, swept
//! motion, plan.

use super::arrival::judge_arrival;
use crate::collision::Crossing;
use crate::pattern::{CreasePattern, EdgeId};
use crate::planner::following::judge::Judge;
use crate::planner::following::reduction::{CLOSED, Reduction, SAME_RAD};
use crate::planner::following::route::{End, Route, straight};
use crate::planner::following::route_selection::{SelectedRoute, select_route};
use crate::planner::knots::Knot;
use crate::planner::lifting::certified_motion::CandidatePath;
use crate::planner::lifting::whole_sheet::{FIRST_BOUND_FRACTION, ended_unjudged, lift};
use crate::planner::plan::{Failure, Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{Note, Reason, Stop, TimeoutAt};
use crate::planner::vectors::{largest, max_norm, way_to};
use crate::symmetry::closure_of;
use crate::util::clock::Instant;

/// Largest turn of a crease in the step that shows which vertex stands in the way, radians.
const PROBE_RAD: f64 = 0.1;
/// Largest difference between goal angles of one crease group that count as the same, radians.
const SAME_GOAL_RAD: f64 = 1e-2;

/// Result of one pass.
pub(crate) struct Pass<'a> {
    pub(crate) plan: Plan,
    /// The route that was found.
    pub(crate) route: Route<'a>,
    /// Part of the work that made the plan.
    pub(crate) ending: Ending,
}

/// Way in which a pass ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    /// The plan follows the route, or there is none to follow.
    Route,
    /// The plan follows the route, but faces cross on it although it reaches the goal, or it ends before the goal:
    /// folding in sequence may lead on.
    Obstructed,
    /// The plan leaves the route, and takes the sheet straight to the goal.
    StraightDeforming,
}

/// Runs all stages. The motion between knots is certified for `bound_fraction` of the bound at first. Returns `None` if
/// the error model changes nothing of this sheet, or allows no path.
pub(crate) fn run<'a>(problem: &PlanningProblem<'a>, bound_fraction: f64) -> Option<Pass<'a>> {
    let mut pass = run_stages(problem, bound_fraction)?;
    judge_arrival(problem, &mut pass.plan);
    Some(pass)
}

fn run_stages<'a>(problem: &PlanningProblem<'a>, bound_fraction: f64) -> Option<Pass<'a>> {
    let SelectedRoute {
        mut route,
        symmetric,
        asked_closure,
    } = select_route(problem)?;
    let mut plan = Plan {
        iterations: route.work.iterations,
        evaluations: route.work.evaluations,
        notes: core::mem::take(&mut route.notes),
        is_random: route.is_random,
        ..Plan::default()
    };
    plan.times.symmetry = route.symmetry;
    plan.times.solve = route.following;
    describe(problem, &route.reduction, &mut plan);
    if let Some(last) = route.waypoints.last() {
        plan.goal_error = route.reduction.distance(&last.angles, problem.goal);
    }
    let pass = |plan, route, ending| {
        Some(Pass {
            plan,
            route,
            ending,
        })
    };
    let stop = match route.end {
        End::Reached if !route.waypoints.is_empty() => None,
        End::Stopped(Stop::Timeout) if route.waypoints.is_empty() => {
            let at = if route.goal.is_some() {
                TimeoutAt::Following
            } else {
                TimeoutAt::ClosingGoal
            };
            return pass(plan.ended(Failure::out_of_time(at)), route, Ending::Route);
        }
        End::Stopped(Stop::Timeout) => {
            plan.reached = route.reached;
            let failure = Failure::out_of_time(TimeoutAt::Following);
            let plan = ended_unjudged(problem, &route.waypoints, plan, failure);
            return pass(plan, route, Ending::Route);
        }
        end => {
            let reduction = symmetric.as_ref().unwrap_or(&route.reduction);
            if let Some(plan) = deform(problem, reduction, &plan) {
                return pass(plan, route, Ending::StraightDeforming);
            }
            match end {
                End::Stopped(stop) if !route.waypoints.is_empty() => Some(stop),
                _ => {
                    let plan = without_route(problem, &route, plan);
                    return pass(plan, route, Ending::Route);
                }
            }
        }
    };
    if stop.is_none() {
        note_moved_goal(problem, &route, asked_closure, &mut plan);
    }
    let (plan, ending) = along_route(problem, &route, stop, plan, bound_fraction);
    pass(plan, route, ending)
}

/// Lifts the route to the whole sheet, as far as it leads; `stop` tells why it ends before the goal, if it does.
fn along_route(
    problem: &PlanningProblem<'_>,
    route: &Route<'_>,
    stop: Option<Stop>,
    plan: Plan,
    bound_fraction: f64,
) -> (Plan, Ending) {
    // Outcome if the motion along the route keeps the bound and is free of crossings.
    let (outcome, reason) = match stop {
        None => (Outcome::Planned, None),
        Some(stop) => {
            let crossing = goal_crossing(problem, route);
            let outcome = crossing.map_or(Outcome::Partial, Outcome::Crossing);
            (outcome, Some(path_stops(problem, route, stop)))
        }
    };
    let candidate = CandidatePath {
        waypoints: &route.waypoints,
        closure_tolerance: route.closure_tolerance,
        reached: route.reached,
        retreats: plan.goal_closure > CLOSED && !problem.errors.is_snapped(),
        bound_fraction,
        before: None,
    };
    let mut plan = lift(problem, &route.reduction, &candidate, plan);
    let crossed = matches!(plan.outcome, Outcome::Crossing(_));
    match plan.outcome {
        Outcome::Planned => (plan.outcome, plan.reason) = (outcome, reason),
        // The goal crosses, however much of the path is proved.
        Outcome::Partial if matches!(outcome, Outcome::Crossing(_)) => plan.outcome = outcome,
        _ => {}
    }
    let obstructed = crossed && outcome == Outcome::Planned || plan.outcome == Outcome::Partial;
    if !crossed && let Outcome::Crossing(Crossing { faces, .. }) = plan.outcome {
        let goal_crosses = |reason| Reason::GoalCrosses {
            faces,
            path: Box::new(reason),
        };
        plan.reason = plan.reason.map(goal_crosses);
    }
    let ending = if obstructed {
        Ending::Obstructed
    } else {
        Ending::Route
    };
    (plan, ending)
}

/// Stores the sizes and tolerances of the reduced problem in the plan.
fn describe(problem: &PlanningProblem<'_>, reduction: &Reduction<'_>, plan: &mut Plan) {
    let groups = &reduction.groups;
    if groups.is_rough() {
        plan.notes.push(Note::RoughGroups {
            groups: groups.len(),
            tolerance: groups.tolerance(),
        });
    }
    plan.amplification = reduction.amplification;
    plan.essential_tolerance = reduction.closure_tolerance(problem.options);
    plan.groups = groups.len();
    plan.essential_vertices = reduction.essential.vertices().len();
    plan.unknowns = groups.len();
    plan.path.memberships = groups.memberships().to_vec();
}

/// Stores in the plan how far the goal was from closing, with a note of how far it was moved, if it was.
fn note_moved_goal(
    problem: &PlanningProblem<'_>,
    route: &Route<'_>,
    asked_closure: Option<f64>,
    plan: &mut Plan,
) {
    let start = Instant::now();
    let goal = problem.goal;
    let closure = asked_closure.or_else(|| {
        let angles = route.reduction.groups.expand(route.last());
        let asked = goal.fold_angles.iter().zip(angles);
        // Free hinges take the angles at which the sheet closes.
        let angles: Vec<_> = asked.map(|(asked, free)| asked.or(Some(free))).collect();
        closure_of(problem.pattern, &angles)
    });
    plan.goal_closure = closure.unwrap_or(0.0);
    plan.times.symmetry += start.elapsed();
    let moved = !problem.errors.is_snapped() || plan.goal_error > SAME_RAD;
    if plan.goal_closure > CLOSED && moved {
        plan.notes.push(Note::GoalMoved {
            goal: goal.source.clone(),
            residual: plan.goal_closure,
            moved: plan.goal_error,
        });
    }
}

/// Returns the crossing of faces at the goal itself, if there is one.
fn goal_crossing(problem: &PlanningProblem<'_>, route: &Route<'_>) -> Option<Crossing> {
    let mut goal = Knot::at(route.goal.clone()?);
    Judge::new(problem, &route.reduction, problem.options.collision).judge(&mut goal)
}

/// Ends a plan that has no route to follow.
fn without_route(problem: &PlanningProblem<'_>, route: &Route<'_>, mut plan: Plan) -> Plan {
    if problem.is_late() {
        return plan.ended(Failure::out_of_time(TimeoutAt::ClosingGoal));
    }
    let End::NotClosed { phase, nearest } = route.end else {
        return plan;
    };
    plan.goal_error = nearest.unwrap_or_else(|| largest(&problem.goal.fold_angles));
    let goal = problem.goal.via.get(phase).unwrap_or(problem.goal);
    let asked = goal
        .fold_angles
        .iter()
        .map(|angle| Some(angle.unwrap_or(0.0)));
    let asked = route.reduction.groups.reduce(&asked.collect::<Vec<_>>());
    let asked: Vec<f64> = asked.into_iter().flatten().collect();
    let worst = route.reduction.worst(problem.pattern, &asked);
    plan.ended(Failure {
        outcome: Outcome::GoalNotClosed,
        reason: Reason::GoalNotClosed {
            goal: goal.source.clone(),
            nearest,
            worst: worst.filter(|worst| worst.residual > CLOSED),
        },
        kept: 1.0,
    })
}

/// Returns the reason why the route ends before the goal.
fn path_stops(problem: &PlanningProblem<'_>, route: &Route<'_>, stop: Stop) -> Reason {
    let reduction = &route.reduction;
    let limited = match stop {
        Stop::Limit(unknown) => members(problem.pattern, reduction, unknown),
        _ => Vec::new(),
    };
    let worst = match stop {
        Stop::Limit(_) => None,
        _ => {
            // The vertex that stands in the way is the one that a small step straight to the goal would tear most.
            let last = route.last();
            let asked = reduction.groups.reduce(&problem.goal.fold_angles);
            let mut ahead = way_to(&asked, last);
            let far = max_norm(&ahead);
            for (step, at) in ahead.iter_mut().zip(last) {
                *step = at + *step * (PROBE_RAD / far.max(PROBE_RAD));
            }
            reduction.worst(problem.pattern, &ahead)
        }
    };
    Reason::PathStops {
        reached: route.reached,
        stop,
        at_flat: route.waypoints.len() < 2,
        limited,
        worst,
    }
}

/// Returns the edges of the creases of a group.
fn members(pattern: &CreasePattern, reduction: &Reduction<'_>, group: usize) -> Vec<EdgeId> {
    let memberships = reduction.groups.memberships().iter();
    let pairs = memberships.zip(pattern.creases());
    let members = pairs.filter(|(membership, _)| membership.group.index() == group);
    members.map(|(_, &edge)| edge).collect()
}

/// Plans a path on which the sheet deforms within the bound, as it does not fold rigidly. `plan` is the plan so far.
///
/// The essential crease pattern is taken straight to the goal. If it keeps the bound, the path is lifted to the whole
/// sheet: either the whole sheet keeps the bound too, or it is not rigidly foldable this way (Prop. 5.1 of the report).
/// Returns `None` if the essential pattern already breaks the bound, or the goal does not have the symmetry of the
/// crease groups.
fn deform(problem: &PlanningProblem<'_>, reduction: &Reduction<'_>, plan: &Plan) -> Option<Plan> {
    let options = problem.options;
    let asked = reduction.groups.reduce(&problem.goal.fold_angles);
    let goal: Vec<f64> = asked.into_iter().collect::<Option<_>>()?;
    let error = reduction.distance(&goal, problem.goal);
    if reduction.groups.is_trivial()
        || error > SAME_GOAL_RAD
        || !problem.goal.via.is_empty()
        || !reduction.allows(problem.goal)
    {
        return None;
    }
    let waypoints = straight(reduction, &goal, options);
    let judge = Judge::new(problem, reduction, false);
    let (essential, _) = judge.essential(waypoints.iter().map(|w| w.angles.as_slice()));
    if !(essential.deformation <= options.bound && essential.gap <= options.bound) {
        return None;
    }
    let mut plan = plan.clone();
    describe(problem, reduction, &mut plan);
    plan.goal_error = error;
    plan.notes.push(Note::Deforming);
    let candidate = CandidatePath {
        waypoints: &waypoints,
        closure_tolerance: options.bound,
        reached: 1.0,
        retreats: false,
        bound_fraction: FIRST_BOUND_FRACTION,
        before: None,
    };
    Some(lift(problem, reduction, &candidate, plan))
}
