//! Searches over stops: a motion is led by way of other and other configurations, until one is free of crossings. The
//! searches differ in the stops that they propose, and in what they learn from a motion that leads nowhere.

use fixedbitset::FixedBitSet;

use super::pipeline::follow;
use crate::folding::SpanningTree;
use crate::pattern::FaceId;
use crate::planner::Goal;
use crate::planner::following::judge::Judge;
use crate::planner::following::reduction::CLOSED;
use crate::planner::following::route_selection::select_route;
use crate::planner::plan::{Effort, Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::symmetry::CreaseGroups;

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

/// Returns `true` if the sheet closes at these fold angles (radians) to a tolerance, and no faces cross.
pub(super) fn is_free(
    judge: &mut Judge<'_>,
    groups: &CreaseGroups,
    angles: &[f64],
    closure_tolerance: f64,
) -> bool {
    let errors = judge.errors_at(&groups.reduce_all(angles));
    judge.crossing().is_none() && errors.twist <= closure_tolerance
}

/// Returns the creases on the way from one face to another along a spanning tree.
pub(super) fn between<T>(tree: &SpanningTree, all: &[T], faces: [FaceId; 2]) -> FixedBitSet {
    let [a, b] = faces.map(|face| {
        let step = |face: FaceId| tree.steps().iter().find(|step| step.face == face);
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
