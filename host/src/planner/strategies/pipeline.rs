//! The stages from a route to a plan under one error model: reduced path, knots, certified motion, swept motion, plan.

use super::arrival::judge_arrival;
use super::plates::judge_plates;
use crate::collision::Crossing;
use crate::pattern::CreasePattern;
use crate::planner::following::judge::Judge;
use crate::planner::following::legs::straight;
use crate::planner::following::reduction::{CLOSED, Reduction, SAME_RAD};
use crate::planner::following::route::{End, Route};
use crate::planner::lifting::certified_motion::Lifting;
use crate::planner::lifting::lifted::Lifted;
use crate::planner::lifting::swept_motion::FIRST_BOUND_FRACTION;
use crate::planner::lifting::whole_sheet::lift;
use crate::planner::plan::{Arrival, CrossingSearch, Outcome, Plan, ReducedProblem};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{FirstSteps, HingeAtLimit, Note, Reason, Stop, TimeoutAt};
use crate::planner::vectors::{largest, max_norm, way_to};
use crate::progress::Stage;
use crate::symmetry::closure_of;

/// Largest turn of a crease in the step that shows which vertex stands in the way, radians.
const PROBE_RAD: f64 = 0.1;
/// Largest difference between goal angles of one crease group that count as the same, radians.
const SAME_GOAL_RAD: f64 = 1e-2;

/// Leads along a route as far as that goes. The motion between knots is certified for `bound_fraction` of the bound at
/// first. Returns `true` with the plan if faces cross on it although the route reaches the goal, or if it ends before the
/// goal: folding in phases may lead on.
pub(crate) fn follow(
    problem: &PlanningProblem<'_>,
    route: &Route<'_>,
    bound_fraction: f64,
) -> (Plan, bool) {
    let mut arrival = Arrival::default();
    if let Some(last) = route.waypoints.last() {
        arrival.error = route.reduction.distance(&last.angles, problem.goal);
    }
    let has_way = !route.waypoints.is_empty();
    let mut is_obstructed = false;
    let lifted = match route.end {
        End::Reached if has_way => {
            arrival.goal_closure = problem.stage(Stage::Symmetry, || goal_closure(problem, route));
            let moved = moved_goal(problem, arrival);
            let mut lifted = lift_route(problem, route, arrival.goal_closure, bound_fraction);
            is_obstructed = matches!(lifted.outcome, Outcome::Crossing(_) | Outcome::Partial);
            lifted.notes.splice(0..0, moved);
            lifted
        }
        End::Stopped(Stop::Timeout) => out_of_time(problem, route),
        End::Stopped(stop) if has_way => {
            let mut lifted = lift_route(problem, route, 0.0, bound_fraction);
            end_before_goal(problem, route, stop, &mut lifted);
            is_obstructed = lifted.outcome == Outcome::Partial;
            lifted
        }
        _ => without_route(problem, route),
    };
    let mut plan = plan_of(problem, route, &route.reduction, arrival, lifted);
    if problem.plates.is_some() && plan.outcome == Outcome::Planned {
        judge_plates(problem, &mut plan);
        is_obstructed |= plan.outcome != Outcome::Planned;
    }
    (plan, is_obstructed)
}

/// Makes the plan of what was found on a route under the crease groups of `reduction`.
fn plan_of(
    problem: &PlanningProblem<'_>,
    route: &Route<'_>,
    reduction: &Reduction<'_>,
    mut arrival: Arrival,
    mut lifted: Lifted,
) -> Plan {
    arrival.flat_creases = judge_arrival(problem, &reduction.groups, &mut lifted);
    arrival.error = lifted.goal_error.unwrap_or(arrival.error);
    let notes = route.notes.iter().cloned();
    let notes = notes.chain(rough_groups(&route.reduction));
    let memberships = reduction.groups.memberships();
    Plan {
        outcome: lifted.outcome,
        reason: lifted.reason,
        reached: lifted.reached,
        motion: (lifted.knots).into_motion(problem.pattern.clone(), memberships, problem.options),
        max_bend: 0.0,
        reduced: ReducedProblem {
            groups: reduction.groups.len(),
            essential_vertices: reduction.essential.vertices().len(),
            waypoints: lifted.waypoints,
            amplification: reduction.amplification,
            closure_tolerance: reduction.closure_tolerance(problem.options),
        },
        errors: lifted.errors,
        certificate: lifted.certificate,
        arrival,
        effort: route.effort,
        crossings: CrossingSearch {
            contact_tolerance: problem.contact,
            ..lifted.crossings
        },
        orders: Vec::new(),
        notes: notes.chain(lifted.notes).collect(),
        undecided: lifted.undecided,
        attempts: Vec::new(),
        thickness: None,
        max_thickness: None,
    }
}

/// Returns a note if the sheet has the symmetry of its crease groups only nearly.
fn rough_groups(reduction: &Reduction<'_>) -> Option<Note> {
    let groups = &reduction.groups;
    groups.is_rough().then(|| Note::RoughGroups {
        groups: groups.len(),
        tolerance: groups.tolerance(),
    })
}

/// Ends a plan as time ran out before the goal: it goes along the route as far as that was found.
fn out_of_time(problem: &PlanningProblem<'_>, route: &Route<'_>) -> Lifted {
    let mut lifted = Lifted {
        reached: route.reached,
        ..Lifted::default()
    };
    let at = if route.goal.is_none() && route.waypoints.is_empty() {
        TimeoutAt::ClosingGoal
    } else {
        TimeoutAt::Following
    };
    lifted.end_unjudged(&route.waypoints, problem.options.max_speed, at);
    lifted
}

/// Lifts a route to the whole sheet, to a goal with this closure residual.
fn lift_route(
    problem: &PlanningProblem<'_>,
    route: &Route<'_>,
    goal_closure: f64,
    bound_fraction: f64,
) -> Lifted {
    let ends_earlier = goal_closure > CLOSED && !problem.errors.is_snapped();
    let (reduction, closure_tolerance) = (&route.reduction, route.closure_tolerance);
    let lifting = Lifting {
        reached: route.reached,
        open_goal: ends_earlier.then_some(goal_closure),
        ..Lifting::new(problem, reduction, &route.waypoints, closure_tolerance)
    };
    lift(&lifting, bound_fraction)
}

/// Stores in a motion along a route that ends before the goal why the route does, and whether faces cross at the goal.
fn end_before_goal(
    problem: &PlanningProblem<'_>,
    route: &Route<'_>,
    stop: Stop,
    lifted: &mut Lifted,
) {
    if lifted.outcome == Outcome::Planned {
        lifted.outcome = Outcome::Partial;
        lifted.reason = Some(path_stops(problem, route, stop));
    }
    // The goal crosses, however much of the path is proved.
    if lifted.outcome == Outcome::Partial
        && let Some(crossing) = goal_crossing(problem, route)
    {
        lifted.outcome = Outcome::Crossing(crossing);
        let goal_crosses = |reason| Reason::GoalCrosses {
            faces: crossing.faces,
            path: Box::new(reason),
        };
        lifted.reason = lifted.reason.take().map(goal_crosses);
    }
}

/// Returns how far the goal as asked is from closing. Free hinges take the angles at which the sheet closes.
fn goal_closure(problem: &PlanningProblem<'_>, route: &Route<'_>) -> f64 {
    let closure = route.asked_closure.or_else(|| {
        let angles = route.reduction.groups.expand(route.last());
        let asked = problem.goal.fold_angles.iter().zip(angles);
        let angles: Vec<_> = asked.map(|(asked, free)| asked.or(Some(free))).collect();
        closure_of(problem.pattern, &angles)
    });
    closure.unwrap_or(0.0)
}

/// Returns a note of how far the goal was moved, if it was.
fn moved_goal(problem: &PlanningProblem<'_>, arrival: Arrival) -> Option<Note> {
    let moved = !problem.errors.is_snapped() || arrival.error > SAME_RAD;
    (arrival.goal_closure > CLOSED && moved).then(|| Note::GoalMoved {
        goal: problem.goal.source.clone(),
        residual: arrival.goal_closure,
        moved: arrival.error,
    })
}

/// Returns the crossing of faces at the goal itself, if there is one.
fn goal_crossing(problem: &PlanningProblem<'_>, route: &Route<'_>) -> Option<Crossing> {
    let goal = route.goal.as_ref()?;
    Judge::new(problem, &route.reduction, problem.options.collision).crossing_at(goal)
}

/// Ends a plan that has no route to follow.
fn without_route(problem: &PlanningProblem<'_>, route: &Route<'_>) -> Lifted {
    let mut lifted = Lifted::default();
    if problem.is_late() {
        lifted.end_late(TimeoutAt::ClosingGoal);
        return lifted;
    }
    let End::NotClosed { phase, nearest } = route.end else {
        return lifted;
    };
    lifted.goal_error = nearest.or_else(|| Some(largest(&problem.goal.fold_angles)));
    let goal = problem.goal.via.get(phase).unwrap_or(problem.goal);
    let asked = goal
        .fold_angles
        .iter()
        .map(|angle| Some(angle.unwrap_or(0.0)));
    let asked = route.reduction.groups.reduce(&asked.collect::<Vec<_>>());
    let asked: Vec<f64> = asked.into_iter().flatten().collect();
    let worst = route.reduction.worst(problem.pattern, &asked);
    let reason = Reason::GoalNotClosed {
        goal: goal.source.clone(),
        nearest,
        worst: worst.filter(|worst| worst.residual > CLOSED),
    };
    lifted.end(Outcome::GoalNotClosed, reason);
    lifted
}

/// Returns the reason why the route ends before the goal.
fn path_stops(problem: &PlanningProblem<'_>, route: &Route<'_>, stop: Stop) -> Reason {
    let reduction = &route.reduction;
    let limited = match stop {
        Stop::Limit(unknown) => hinge_at_limit(problem.pattern, reduction, unknown, route.last()),
        _ => None,
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
        at_flat: (route.waypoints.len() < 2).then(FirstSteps::default),
        limited,
        worst,
    }
}

/// Returns the hinges of a group that is at its limit at these group angles.
fn hinge_at_limit(
    pattern: &CreasePattern,
    reduction: &Reduction<'_>,
    group: usize,
    angles: &[f64],
) -> Option<HingeAtLimit> {
    let memberships = reduction.groups.memberships().iter();
    let pairs = memberships.zip(pattern.creases());
    let mut members = pairs.filter(|(membership, _)| membership.group.index() == group);
    let (first, &edge) = members.next()?;
    Some(HingeAtLimit {
        // The sum turns -0 into 0.
        angle: first.apply(*angles.get(group)?) + 0.0,
        edges: [edge]
            .into_iter()
            .chain(members.map(|(_, &edge)| edge))
            .collect(),
    })
}

/// Plans a path on which the sheet deforms within the bound, as it does not fold rigidly along a route.
///
/// The essential crease pattern is taken straight to the goal. If it keeps the bound, the path is lifted to the whole
/// sheet: either the whole sheet keeps the bound too, or it is not rigidly foldable this way (Prop. 5.1 of the report).
/// Returns `None` if the essential pattern already breaks the bound, or the goal does not have the symmetry of the
/// crease groups.
pub(crate) fn deform(problem: &PlanningProblem<'_>, route: &Route<'_>) -> Option<Plan> {
    let options = problem.options;
    let reduction = route.symmetric.as_ref().unwrap_or(&route.reduction);
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
    if !judge.keeps_essentially(options.bound, waypoints.iter().map(|w| w.angles.as_slice())) {
        return None;
    }
    let lifting = Lifting::new(problem, reduction, &waypoints, options.bound);
    let mut lifted = lift(&lifting, FIRST_BOUND_FRACTION);
    let notes = rough_groups(reduction).into_iter();
    lifted.notes.splice(0..0, notes.chain([Note::Deforming]));
    let arrival = Arrival {
        error,
        ..Arrival::default()
    };
    Some(plan_of(problem, route, reduction, arrival, lifted))
}
