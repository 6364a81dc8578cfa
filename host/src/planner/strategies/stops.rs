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
use crate::planner::lifting::swept_motion::FIRST_BOUND_FRACTION;
use crate::planner::plan::{Attempt, Effort, Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{Reason, TimeoutAt};
use crate::planner::{Goal, GoalKind, Search};
use crate::symmetry::{CreaseGroups, ReducedStars};
use crate::util::clock::Instant;

/// The part of a motion that is folded in phases: from flat, or one of the goals on the way, to the next goal.
pub(crate) struct Leg {
    /// Fold angles of the creases at its start, radians.
    start: Vec<f64>,
    /// Fold angles of the creases at its end, radians.
    pub(super) end: Vec<f64>,
    /// Number of goals on the way up to its start.
    before: usize,
}

impl Leg {
    /// Returns the leg that has the same start and ends at these fold angles, radians.
    pub(super) fn with_end(&self, end: Vec<f64>) -> Self {
        let start = self.start.clone();
        Self {
            start,
            end,
            ..*self
        }
    }

    /// Returns by how much a crease turns, radians.
    pub(super) fn turn(&self, crease: usize) -> f64 {
        self.end[crease] - self.start[crease]
    }

    /// Returns the fold angle of a crease after this part of its turn, radians.
    pub(super) fn angle(&self, crease: usize, part: f64) -> f64 {
        self.start[crease] + part * self.turn(crease)
    }

    /// Returns the fold angles with these creases at the end of the leg and the others at its start, radians.
    pub(super) fn angles(&self, folded: &FixedBitSet) -> Vec<f64> {
        let part = |crease: usize| f64::from(u8::from(folded[crease]));
        (0..self.end.len())
            .map(|crease| self.angle(crease, part(crease)))
            .collect()
    }

    /// Returns the set of the creases that turn.
    pub(super) fn turned_creases(&self) -> FixedBitSet {
        let turned = (0..self.end.len()).filter(|&crease| self.turn(crease).abs() > CLOSED);
        set(&self.end, turned)
    }

    /// Returns the stops of a motion that folds these sets of creases one after the other.
    pub(super) fn stops_of(&self, phases: &[FixedBitSet]) -> Vec<Vec<f64>> {
        let stops = (1..phases.len()).map(|k| self.angles(&union(&self.end, &phases[..k])));
        stops.collect()
    }

    /// Returns the length of the path on which these creases turn at once, radians: the root of the sum of the squares of
    /// their turns.
    pub(super) fn length(&self, phase: &FixedBitSet) -> f64 {
        let squares = phase.ones().map(|crease| self.turn(crease).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// Returns the part of their turn, 0 to 1, that these creases have made where a plan ends.
    pub(super) fn folded_part(&self, plan: &Plan, phase: &FixedBitSet) -> f64 {
        let by_turn = |a: &usize, b: &usize| self.turn(*a).abs().total_cmp(&self.turn(*b).abs());
        let (motion, crease) = (plan.motion.as_ref(), phase.ones().max_by(by_turn));
        motion.zip(crease).map_or(0.0, |(motion, crease)| {
            let angle = motion.crease_angles(motion.segments())[crease];
            ((angle - self.start[crease]) / self.turn(crease)).clamp(0.0, 1.0)
        })
    }

    /// Returns the goal of a problem with stops on this leg, fold angles in radians.
    fn by_way_of(&self, problem: &PlanningProblem<'_>, stops: &[Vec<f64>]) -> Goal {
        let stops = stops.iter().map(|angles| {
            let angles = angles.iter().copied().map(Some).collect();
            Goal::chosen(problem.pattern, angles, "a stop on the way".into())
        });
        let mut goal = problem.goal.clone();
        goal.via.splice(self.before..self.before, stops);
        goal
    }

    /// Returns the number of phases of the leg that are at their end in a plan by way of its stops.
    pub(super) fn ended_phases(&self, plan: &Plan) -> usize {
        plan.ended_phases().saturating_sub(self.before)
    }
}

/// Finds a plan that folds in phases the last leg of this problem, on this route, of which this is the plan that folds all at
/// once.
pub(crate) type FoldLeg = fn(&PlanningProblem<'_>, &Route<'_>, &Plan, &Leg) -> Option<Plan>;

/// Looks for a plan that folds in phases the legs of a route on which something is in the way, and lists the attempt. If
/// `fold_leg` finds none, the reason is `none`. Returns `None` if there is none, or no phases lead to the end of the first of
/// these legs.
pub(crate) fn try_phases(
    context: &Context<'_>,
    attempts: &mut Vec<Attempt>,
    none: Reason,
    fold_leg: FoldLeg,
) -> Option<Plan> {
    let (problem, route) = (context.problem, context.route?);
    let leg = leg_in_phases(problem, route, context.best)?;
    let start = Instant::now();
    let found = fold_legs(problem, route, context.best, &leg, fold_leg);
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
        reached: found.as_ref().map_or(0.0, |plan| plan.reached),
        seconds: start.elapsed().as_secs_f64(),
    });
    found
}

/// Folds this leg in phases, and each later one on which something is in the way then. A leg starts where the one before
/// ends, whatever phases led there, so that each is folded for itself, as the last one of the motion up to its end.
fn fold_legs(
    problem: &PlanningProblem<'_>,
    route: &Route<'_>,
    straight: &Plan,
    leg: &Leg,
    fold_leg: FoldLeg,
) -> Option<Plan> {
    let (asked, before) = (problem.goal, leg.before);
    let end = asked.via.get(before);
    let end = Goal {
        via: asked.via.iter().take(before).cloned().collect(),
        ..completed(end.unwrap_or(asked), &leg.end)
    };
    let folded = fold_leg(&problem.with_goal(&end), route, straight, leg)?;
    if before == asked.via.len() {
        return Some(folded);
    }
    let motion = folded.motion.as_ref()?;
    let stops = motion.phases.get(before..)?.iter();
    let stops: Vec<Vec<f64>> = stops.map(|&knot| motion.crease_angles(knot)).collect();
    let mut goal = leg.by_way_of(problem, &stops);
    *goal.via.get_mut(before + stops.len())? = end;
    let problem = problem.with_goal(&goal);
    let route = select_route(&problem)?;
    let (mut plan, _) = follow(&problem, &route, FIRST_BOUND_FRACTION);
    if plan.outcome != Outcome::Planned {
        let next = leg_in_phases(&problem, &route, &plan)?;
        let leads_on = next.before > before + stops.len();
        let later = leads_on.then(|| fold_legs(&problem, &route, &plan, &next, fold_leg));
        plan = later.flatten()?;
    }
    plan.effort += folded.effort;
    for note in folded.notes {
        if !plan.notes.contains(&note) {
            plan.notes.push(note);
        }
    }
    Some(plan)
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

/// Returns the leg of a route on which its plan ends, if creases may be folded one after the other there: if the goal at its
/// end closes as it is or its errors are snapped, and no faces cross there.
fn leg_in_phases(problem: &PlanningProblem<'_>, route: &Route<'_>, plan: &Plan) -> Option<Leg> {
    let goals = &problem.goal.via;
    let before = plan.ended_phases().min(goals.len());
    let asked = goals.get(before).unwrap_or(problem.goal);
    let ends: Vec<&[f64]> = route
        .waypoints
        .iter()
        .filter(|it| it.ends_phase)
        .map(|it| it.angles.as_slice())
        .collect();
    let end = match route.end {
        _ if before < goals.len() => ends.get(before).copied(),
        End::Reached => Some(route.last()),
        _ => route.goal.as_deref(),
    };
    let closes = || problem.errors.is_snapped() || closing_angle(problem, route, asked).is_none();
    let end = end.filter(|_| problem.options.search == Search::Auto && closes())?;
    let groups = &route.reduction.groups;
    let start = match before.checked_sub(1) {
        Some(last) => groups.expand(ends.get(last)?),
        None => vec![0.0; problem.pattern.creases().len()],
    };
    let end = groups.expand(end);
    let reduction = Reduction::of(problem, CreaseGroups::trivial(problem.pattern));
    let judge = Judge::new(problem, &reduction, problem.options.collision);
    judge
        .of_plates(problem)
        .is_free(&end, problem.options)
        .then_some(Leg { start, end, before })
}

/// Returns the angle (radians) by which creases are off, if a goal closes but for rounding; so do the goal's parts then.
fn closing_angle(problem: &PlanningProblem<'_>, route: &Route<'_>, goal: &Goal) -> Option<f64> {
    let stars = ReducedStars::of_creases(problem.pattern);
    let most = route.reduction.closure_tolerance(problem.options);
    snapping_angle(&stars, &goal.fold_angles, most, false)
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

/// Returns the plan that folds a leg by way of the first proposal that leads to the goal free of crossings, if there is one.
pub(super) fn search_stops<S: StopSearch>(
    problem: &PlanningProblem<'_>,
    leg: &Leg,
    search: &mut S,
) -> Option<Plan> {
    let mut effort = Effort::default();
    for _ in 0..S::MAX_TRIES {
        if problem.is_late() {
            return None;
        }
        let mut plan = plan_via(problem, leg, &search.next()?, S::BOUND_FRACTION);
        if plan.outcome == Outcome::Planned {
            plan.effort += effort;
            return Some(plan);
        }
        search.learn(&plan);
        effort += plan.effort;
    }
    None
}

/// Returns the plan that folds a leg by way of these fold angles (radians), certified for this fraction of the bound at
/// first.
pub(super) fn plan_via(
    problem: &PlanningProblem<'_>,
    leg: &Leg,
    stops: &[Vec<f64>],
    bound_fraction: f64,
) -> Plan {
    let goal = leg.by_way_of(problem, stops);
    let problem = PlanningProblem {
        is_trial: true,
        ..problem.with_goal(&goal)
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

/// Returns the parts of a sequence that lie in `between`.
pub(super) fn of_those<'a>(
    order: &'a [FixedBitSet],
    between: &'a FixedBitSet,
) -> impl Iterator<Item = FixedBitSet> + 'a {
    let parts = order.iter().map(move |creases| creases & between);
    parts.filter(|creases| !creases.is_clear())
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
