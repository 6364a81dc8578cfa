//! Searches over stops: a motion is led by way of other and other configurations, until one is free of crossings. The
//! searches differ in the stops that they propose, and in what they learn from a motion that leads nowhere.

use fixedbitset::FixedBitSet;

use super::pipeline::follow;
use super::rows::Context;
use crate::pattern::{CreasePattern, FaceId};
use crate::planner::following::judge::Judge;
use crate::planner::following::reduction::{CLOSED, Reduction, snapping_angle};
use crate::planner::following::route::{End, Route};
use crate::planner::following::route_selection::select_route;
use crate::planner::plan::{Attempt, Effort, Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{Reason, TimeoutAt};
use crate::planner::{Goal, GoalKind, Search};
use crate::symmetry::{CreaseGroups, ReducedStars};
use crate::util::clock::Instant;

/// Looks for a plan in phases to the goal of a route, given as fold angles in radians, and lists the attempt. If `find`
/// finds none, the reason is `none`. Returns `None` if there is none, or no phases lead to this goal.
pub(crate) fn try_phases(
    context: &Context<'_>,
    attempts: &mut Vec<Attempt>,
    none: Reason,
    find: impl FnOnce(&PlanningProblem<'_>, &[f64]) -> Option<Plan>,
) -> Option<Plan> {
    let goal = goal_of_phases(context.problem, context.route?)?;
    let completed = completed(context.problem.goal, &goal);
    let problem = &PlanningProblem {
        goal: &completed,
        ..*context.problem
    };
    let start = Instant::now();
    let found = find(problem, &goal);
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

/// Returns a goal in which free creases have these angles (radians), so that they may be folded in a phase of their own.
fn completed(goal: &Goal, angles: &[f64]) -> Goal {
    let asked = goal.fold_angles.iter().zip(angles);
    Goal {
        fold_angles: asked.map(|(asked, &angle)| asked.or(Some(angle))).collect(),
        kind: match goal.kind {
            GoalKind::Driven => GoalKind::Configuration,
            kind => kind,
        },
        guide: None,
        ..goal.clone()
    }
}

/// Returns the fold angles (radians) to which creases may be folded one after the other, if they may be: the goal of
/// `route`, if that closes as it is or its errors are snapped, and no faces cross there.
fn goal_of_phases(problem: &PlanningProblem<'_>, route: &Route<'_>) -> Option<Vec<f64>> {
    let fits = problem.goal.via.is_empty() && problem.options.search == Search::Auto;
    let end = match route.end {
        End::Reached => Some(route.last()),
        _ => route.goal.as_deref(),
    };
    let closes = || problem.errors.is_snapped() || closing_angle(problem, route).is_none();
    let end = end.filter(|_| fits && closes())?;
    let goal = route.reduction.groups.expand(end);
    let reduction = Reduction::of(problem, CreaseGroups::trivial(problem.pattern));
    let mut judge = Judge::new(problem, &reduction, problem.options.collision);
    judge.is_free(&goal, problem.options).then_some(goal)
}

/// Returns the angle (radians) by which creases are off, if the goal closes but for rounding; so do the goal's parts
/// then.
fn closing_angle(problem: &PlanningProblem<'_>, route: &Route<'_>) -> Option<f64> {
    let stars = ReducedStars::of_creases(problem.pattern);
    let most = route.reduction.closure_tolerance(problem.options);
    snapping_angle(&stars, &problem.goal.fold_angles, most, false)
}

/// Proposals of stops.
pub(super) trait StopSearch {
    /// Largest number of proposals that are tried as plans.
    const MAX_TRIES: usize;
    /// Fraction of the bound for which motions are certified at first.
    const BOUND_FRACTION: f64;

    /// Returns the next proposal: the fold angles at the stops, radians. Returns `None` if there is no other.
    fn next(&mut self) -> Option<Vec<Vec<f64>>>;

    /// Learns from a plan by way of the last proposal, which is not [planned](Outcome::Planned).
    fn learn(&mut self, plan: &Plan);
}

/// Returns the plan by way of the first proposal that leads to the goal free of crossings, if there is one.
pub(super) fn search_stops<S: StopSearch>(
    problem: &PlanningProblem<'_>,
    search: &mut S,
) -> Option<Plan> {
    let mut effort = Effort::default();
    for _ in 0..S::MAX_TRIES {
        if problem.is_late() {
            return None;
        }
        let mut plan = plan_via(problem, &search.next()?, S::BOUND_FRACTION);
        if plan.outcome == Outcome::Planned {
            plan.effort += effort;
            return Some(plan);
        }
        search.learn(&plan);
        effort += plan.effort;
    }
    None
}

/// Returns the plan by way of these fold angles (radians), certified for this fraction of the bound at first.
pub(super) fn plan_via(
    problem: &PlanningProblem<'_>,
    stops: &[Vec<f64>],
    bound_fraction: f64,
) -> Plan {
    let via = stops.iter().map(|angles| {
        let angles = angles.iter().copied().map(Some).collect();
        Goal::chosen(problem.pattern, angles, "a stop on the way".into())
    });
    let goal = Goal {
        via: via.collect(),
        ..problem.goal.clone()
    };
    let problem = PlanningProblem {
        goal: &goal,
        is_trial: true,
        ..*problem
    };
    let route = select_route(&problem);
    route.map_or_else(
        || Plan {
            outcome: Outcome::Partial,
            ..Plan::default()
        },
        |route| follow(&problem, &route, bound_fraction).0,
    )
}

/// Returns the stops of a motion that folds these sets of creases one after the other. The other creases are flat at the
/// stops; `goal` has the fold angles of folded ones, radians.
pub(super) fn stops_of(goal: &[f64], phases: &[FixedBitSet]) -> Vec<Vec<f64>> {
    let stops = (1..phases.len()).map(|k| angles(goal, &union(goal, &phases[..k])));
    stops.collect()
}

/// Returns the fold angles with these creases at their goals and the others flat, radians.
pub(super) fn angles(goal: &[f64], folded: &FixedBitSet) -> Vec<f64> {
    let angles = goal.iter().enumerate();
    angles
        .map(|(crease, &angle)| if folded[crease] { angle } else { 0.0 })
        .collect()
}

/// Returns the creases on the way from one face to another along a spanning tree.
pub(super) fn between(pattern: &CreasePattern, faces: [FaceId; 2]) -> FixedBitSet {
    let (steps, all) = (pattern.tree().steps(), pattern.creases());
    let [a, b] = faces.map(|face| {
        let step = |face: FaceId| steps.iter().find(|step| step.face == face);
        let way = core::iter::successors(step(face), |at| step(at.parent));
        let creases = way.filter_map(|step| step.crease);
        set(all, creases.map(|crease| crease.index()))
    });
    set(all, a.symmetric_difference(&b))
}

/// Returns all creases of some sets.
pub(super) fn union<T>(all: &[T], sets: &[FixedBitSet]) -> FixedBitSet {
    let mut union = set(all, []);
    sets.iter().for_each(|set| union.union_with(set));
    union
}

/// Makes a set of creases with room for as many creases as a list has items.
pub(super) fn set<T>(all: &[T], creases: impl IntoIterator<Item = usize>) -> FixedBitSet {
    let mut set = FixedBitSet::with_capacity(all.len());
    set.extend(creases);
    set
}

/// Returns the set of the creases that turn to `goal` (fold angles in radians).
pub(super) fn turned_creases(goal: &[f64]) -> FixedBitSet {
    let turned = (0..goal.len()).filter(|&crease| goal[crease].abs() > CLOSED);
    set(goal, turned)
}
