//! Fold sequences: folds one part of the sheet after the other if faces cross when all fold at once, as with the flaps
//! of a letter or a sheet that is folded by hand along one line after the other.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use fixedbitset::FixedBitSet;

use super::pipeline;
use super::simple_folds::simple_folds;
use crate::folding::{FoldingMap, SpanningTree};
use crate::pattern::FaceId;
use crate::planner::following::judge::Judge;
use crate::planner::following::mobility::independent_parts;
use crate::planner::following::reduction::{CLOSED, Reduction, snapping_angle};
use crate::planner::following::route::{End, Route};
use crate::planner::knots::Knot;
use crate::planner::lifting::whole_sheet::{FIRST_BOUND_FRACTION, LEAST_BOUND_FRACTION};
use crate::planner::plan::{Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::Note;
use crate::planner::{Goal, GoalKind, Search};
use crate::symmetry::{CreaseGroups, ReducedStars};

/// Largest number of creases of a sheet whose folds are put in sequence.
const MAX_CREASES: usize = 200;
/// Largest number of sequences that are tried as plans.
const MAX_TRIES: usize = 200;
/// Largest number of sets of folded creases that are judged.
const MAX_SETS: usize = 2000;
/// Largest number of steps in the search for sequences.
const MAX_STEPS: usize = 100_000;
/// Largest number of configurations of the path at which creases that move each other are found.
const MAX_CONFIGURATIONS: usize = 16;

/// Returns the fold angles (radians) to which creases may be folded one after the other, if they may be: the goal of
/// `route`, if that closes as it is or its errors are snapped.
pub(crate) fn goal_of_sequences(
    problem: &PlanningProblem<'_>,
    route: &Route<'_>,
) -> Option<Vec<f64>> {
    let fits = problem.goal.via.is_empty()
        && problem.goal.kind != GoalKind::Driven
        && problem.options.search == Search::Auto;
    let end = match route.end {
        End::Reached => Some(route.last()),
        _ => route.goal.as_deref(),
    };
    let closes = || problem.errors.is_snapped() || closing_angle(problem, route).is_none();
    let end = end.filter(|_| fits && closes())?;
    Some(route.reduction.groups.expand(end))
}

/// Returns `true` if the sheet closes at `goal` (fold angles in radians) and no faces cross there; else no sequence leads
/// to it.
pub(crate) fn goal_is_free(problem: &PlanningProblem<'_>, goal: &[f64]) -> bool {
    let reduction = Reduction::of(problem, CreaseGroups::trivial(problem.pattern));
    let mut judge = Judge::new(problem, &reduction, problem.options.collision);
    let closure_tolerance = reduction.closure_tolerance(problem.options);
    is_free(&mut judge, &reduction.groups, goal, closure_tolerance)
}

/// Returns `true` if the sheet closes at these fold angles (radians) to a tolerance, and no faces cross.
pub(super) fn is_free(
    judge: &mut Judge<'_>,
    groups: &CreaseGroups,
    angles: &[f64],
    closure_tolerance: f64,
) -> bool {
    let mut knot = Knot::at(groups.reduce_all(angles));
    judge.judge(&mut knot).is_none() && knot.errors().twist <= closure_tolerance
}

/// Returns `true` if a sheet has few enough creases for folds in sequence to be looked for.
pub(crate) fn has_few_creases(problem: &PlanningProblem<'_>) -> bool {
    problem.pattern.creases().len() <= MAX_CREASES
}

/// Returns the angle (radians) by which creases are off, if the goal closes but for rounding; so do the goal's parts
/// then.
fn closing_angle(problem: &PlanningProblem<'_>, route: &Route<'_>) -> Option<f64> {
    let stars = ReducedStars::of_creases(problem.pattern);
    let most = route.reduction.closure_tolerance(problem.options);
    snapping_angle(&stars, &problem.goal.fold_angles, most, false)
}

/// Returns the plan that folds independent parts of the sheet, and along lines, one after the other, if that leads to
/// `goal` and no faces cross; with as few stops as it takes. `goal` is that of [`goal_of_sequences`].
///
/// Sequences are found depth first. If a part cannot be next because two faces cross, it is not tried again in any
/// sequence that has folded the creases between these two faces in the same order: those creases alone determine where
/// the two faces are, and which one lies on the other. Source, for the assembly of parts: R. Wilson, J.-C. Latombe,
/// "Geometric reasoning about mechanical assembly", 1994.
pub(crate) fn fold_in_sequence(
    problem: &PlanningProblem<'_>,
    route: &Route<'_>,
    goal: Vec<f64>,
) -> Option<Plan> {
    let (pattern, options) = (problem.pattern, problem.options);
    let turned = goal.iter().enumerate();
    let turned = turned.filter(|(_, angle)| angle.abs() > CLOSED);
    let all = set(&goal, turned.map(|(crease, _)| crease));
    let reduction = Reduction::of(problem, CreaseGroups::trivial(pattern));
    let mut orders = Orders {
        problem,
        judge: Judge::new(problem, &reduction, options.collision),
        closure_tolerance: reduction.closure_tolerance(options),
        tree: reduction.tree,
        groups: &reduction.groups,
        in_the_way: vec![0; goal.len()],
        parts: parts(problem, route, &goal).unwrap_or_default(),
        goal,
        all,
        moves: HashMap::new(),
        free: HashMap::new(),
        dead: HashSet::new(),
        barred: Vec::new(),
        steps: 0,
    };
    let mut effort = Plan::default();
    for _ in 0..MAX_TRIES {
        let mut order = Vec::new();
        if problem.is_late() || orders.extend(&mut order).is_err() {
            return None;
        }
        // The motion is placed as near to its path as it gets, so that only a path that crosses is rejected.
        let plan = orders.plan_in_phases(&order, LEAST_BOUND_FRACTION);
        if plan.outcome == Outcome::Planned {
            let mut plan = with_fewer_stops(&mut orders, plan, order);
            plan.add_effort(&effort);
            return Some(plan);
        }
        let phases = plan.path.knots.iter().filter(|knot| knot.ends_phase);
        let next = phases.count().min(order.len() - 1);
        orders.bar(&order[..next], &order[next], &plan.outcome);
        effort.add_effort(&plan);
    }
    None
}

/// Reduces the number of phases of a plan: sets of creases that follow each other, and that could each be next, are
/// folded at once if no faces cross then.
fn with_fewer_stops(orders: &mut Orders<'_>, mut plan: Plan, order: Vec<FixedBitSet>) -> Plan {
    let mut effort = Plan::default();
    let mut phases: Vec<Vec<FixedBitSet>> = order.into_iter().map(|next| vec![next]).collect();
    let plan_of = |orders: &Orders<'_>, phases: &[Vec<_>], bound_fraction| {
        let phases = phases.iter().map(|once| union(&orders.goal, once));
        orders.plan_in_phases(&phases.collect::<Vec<_>>(), bound_fraction)
    };
    let mut run = phases.len().div_ceil(2);
    while run > 1 {
        let mut from = 0;
        while from + 1 < phases.len() && phases.len() > run {
            let to = phases.len().min(from + run);
            let once = phases[from..to].concat();
            let next = orders.moves(&union(&orders.goal, &phases[..from].concat()));
            let mut fewer = phases.clone();
            fewer.splice(from..to, [once.clone()]);
            from += run - 1;
            if !once.iter().all(|creases| next.contains(creases)) {
                continue;
            }
            let mut other = plan_of(orders, &fewer, LEAST_BOUND_FRACTION);
            if other.outcome == Outcome::Planned {
                core::mem::swap(&mut plan, &mut other);
                phases = fewer;
                from -= run - 1;
            }
            effort.add_effort(&other);
        }
        run = run.div_ceil(2).min(run - 1);
    }
    let mut other = plan_of(orders, &phases, FIRST_BOUND_FRACTION);
    if other.outcome == Outcome::Planned {
        core::mem::swap(&mut plan, &mut other);
    }
    plan.add_effort(&other);
    plan.add_effort(&effort);
    plan.notes.push(Note::Phases(phases.len()));
    plan
}

/// Returns the sets of creases that turn and move each other along `route`; creases of different sets do not.
fn parts(
    problem: &PlanningProblem<'_>,
    route: &Route<'_>,
    goal: &[f64],
) -> Option<Vec<FixedBitSet>> {
    let groups = &route.reduction.groups;
    let waypoints = &route.waypoints;
    // The sheet is singular where it is flat, and often at the goal: only configurations between are used.
    let inner = waypoints.get(1..waypoints.len().checked_sub(1)?)?;
    let step = inner.len().div_ceil(MAX_CONFIGURATIONS).max(1);
    let looks = inner.iter().step_by(step);
    let mut looks: Vec<_> = looks.map(|w| groups.expand(&w.angles)).collect();
    if looks.is_empty() {
        looks.push(goal.iter().map(|angle| angle / 2.0).collect());
    }
    let stars = ReducedStars::of_creases(problem.pattern);
    let stars = if problem.errors.is_snapped() {
        stars.snapped(route.reduction.within).0
    } else {
        stars
    };
    let parts = independent_parts(&stars, &looks)?;
    let turned = |crease: &usize| goal[*crease].abs() > CLOSED;
    let parts = parts
        .into_iter()
        .map(|part| part.into_iter().filter(turned));
    Some(parts.map(|part| set(goal, part)).collect())
}

/// Returns the plan that folds these sets of creases one after the other, certified for this fraction of the bound at
/// first. The other creases are flat at the stops; `goal` has the fold angles of folded ones, radians.
pub(super) fn plan_in_phases(
    problem: &PlanningProblem<'_>,
    goal: &[f64],
    phases: &[FixedBitSet],
    bound_fraction: f64,
) -> Plan {
    let stops = (1..phases.len()).map(|k| angles(goal, &union(goal, &phases[..k])));
    plan_via(problem, &stops.collect::<Vec<_>>(), bound_fraction)
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
    let pass = pipeline::run(&problem, bound_fraction);
    pass.map_or_else(
        || Plan {
            outcome: Outcome::Partial,
            ..Plan::default()
        },
        |pass| pass.plan,
    )
}

/// Returns the fold angles with these creases at their goals and the others flat, radians.
fn angles(goal: &[f64], folded: &FixedBitSet) -> Vec<f64> {
    let angles = goal.iter().enumerate();
    angles
        .map(|(crease, &angle)| if folded[crease] { angle } else { 0.0 })
        .collect()
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
fn union<T>(all: &[T], sets: &[FixedBitSet]) -> FixedBitSet {
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

/// A set of creases that cannot be folded next after others.
struct Barred {
    /// The creases that matter: those between two faces that cross, or all.
    between: FixedBitSet,
    /// Those of them that are folded, in the order in which they were.
    before: Vec<FixedBitSet>,
    /// The set that cannot be next.
    next: FixedBitSet,
}

/// Search for sequences in which sets of creases can be folded.
struct Orders<'a> {
    problem: &'a PlanningProblem<'a>,
    judge: Judge<'a>,
    tree: &'a SpanningTree,
    /// Closure residual up to which a configuration counts as closed.
    closure_tolerance: f64,
    groups: &'a CreaseGroups,
    /// Fold angles of the creases when all are folded, radians.
    goal: Vec<f64>,
    /// The creases that turn.
    all: FixedBitSet,
    /// Sets of creases that move each other.
    parts: Vec<FixedBitSet>,
    /// For each set of folded creases, the sets that can turn next.
    moves: HashMap<FixedBitSet, Rc<[FixedBitSet]>>,
    /// For each set of folded creases, `true` if the sheet closes and no faces cross.
    free: HashMap<FixedBitSet, bool>,
    /// Sets of folded creases from which nothing leads on, in whatever order they were folded.
    dead: HashSet<FixedBitSet>,
    barred: Vec<Barred>,
    /// Number of times that each crease was folded before a set that could not follow.
    in_the_way: Vec<usize>,
    /// Number of steps in the search so far.
    steps: usize,
}

impl Orders<'_> {
    /// Returns the plan that folds these sets of creases one after the other, as [`plan_in_phases`] does.
    fn plan_in_phases(&self, phases: &[FixedBitSet], bound_fraction: f64) -> Plan {
        plan_in_phases(self.problem, &self.goal, phases, bound_fraction)
    }

    fn is_free(&mut self, folded: &FixedBitSet) -> bool {
        if let Some(&free) = self.free.get(folded) {
            return free;
        }
        let angles = angles(&self.goal, folded);
        let free = self.free.len() < MAX_SETS
            && is_free(
                &mut self.judge,
                self.groups,
                &angles,
                self.closure_tolerance,
            );
        self.free.insert(folded.clone(), free);
        free
    }

    /// Returns the sets that can turn next: simple folds, and parts that move on their own, without their folded
    /// creases.
    fn moves(&mut self, folded: &FixedBitSet) -> Rc<[FixedBitSet]> {
        if let Some(moves) = self.moves.get(folded) {
            return moves.clone();
        }
        let map = FoldingMap::new(self.problem.pattern, self.tree, &angles(&self.goal, folded));
        let mut turns = vec![0.0; self.goal.len()];
        for crease in self.all.difference(folded) {
            turns[crease] = self.goal[crease];
        }
        let folds = simple_folds(self.problem.pattern, map.vertices(), &turns);
        let rest = self
            .parts
            .iter()
            .map(|part| part.difference(folded).collect());
        let mut moves: Vec<FixedBitSet> = Vec::new();
        for creases in folds.into_iter().chain(rest) {
            let creases: Vec<usize> = creases;
            let creases = set(&self.goal, creases);
            // All creases at once were the first try.
            if !creases.is_clear() && creases != self.all && !moves.contains(&creases) {
                moves.push(creases);
            }
        }
        let moves: Rc<[FixedBitSet]> = moves.into();
        self.moves.insert(folded.clone(), moves.clone());
        moves
    }

    /// Extends a sequence to all creases, if possible. `Err(true)` says that it is impossible in any order of the
    /// creases folded so far.
    fn extend(&mut self, order: &mut Vec<FixedBitSet>) -> Result<(), bool> {
        let folded = union(&self.goal, order);
        if folded == self.all {
            return Ok(());
        }
        self.steps += 1;
        if self.steps > MAX_STEPS {
            return Err(false);
        }
        let mut in_any_order = true;
        let mut moves = self.moves(&folded).to_vec();
        // Sets whose creases were seldom in the way come first.
        moves.sort_by_cached_key(|next| next.ones().map(|crease| self.in_the_way[crease]).max());
        for next in moves {
            let after = &folded | &next;
            if self.dead.contains(&after) || !self.is_free(&after) {
                continue;
            }
            let mut barred = self.barred.iter();
            if let Some(barred) = barred.find(|barred| barred.bars(order, &next)) {
                in_any_order &= barred.before.len() < 2;
                continue;
            }
            order.push(next);
            match self.extend(order) {
                Ok(()) => return Ok(()),
                Err(whatever) => in_any_order &= whatever,
            }
            order.pop();
        }
        if in_any_order {
            self.dead.insert(folded);
        }
        Err(in_any_order)
    }

    /// Bars a set of creases from being next after others, as the plan ended with this outcome.
    fn bar(&mut self, order: &[FixedBitSet], next: &FixedBitSet, outcome: &Outcome) {
        let between = match outcome {
            Outcome::Crossing(crossing) => between(self.tree, &self.goal, crossing.faces),
            _ => self.all.clone(),
        };
        let before: Vec<_> = of_those(order, &between).collect();
        for crease in before.iter().flat_map(FixedBitSet::ones) {
            self.in_the_way[crease] += 1;
        }
        self.barred.push(Barred {
            between,
            before,
            next: next.clone(),
        });
    }
}

/// Returns the parts of a sequence that lie in `between`.
fn of_those<'a>(
    order: &'a [FixedBitSet],
    between: &'a FixedBitSet,
) -> impl Iterator<Item = FixedBitSet> + 'a {
    let parts = order.iter().map(move |creases| creases & between);
    parts.filter(|creases| !creases.is_clear())
}

impl Barred {
    fn bars(&self, order: &[FixedBitSet], next: &FixedBitSet) -> bool {
        self.next == *next && of_those(order, &self.between).eq(self.before.iter().cloned())
    }
}
