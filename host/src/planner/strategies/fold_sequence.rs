//! Fold sequences: folds one part of the sheet after the other if faces cross when all fold at once, as with the flaps
//! of a letter or a sheet that is folded by hand along one line after the other.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use fixedbitset::FixedBitSet;

use super::phase_samples::{PhaseSamples, turns_freely};
use super::simple_folds::simple_folds;
use super::stops::{Leg, StopSearch, between, of_those, plan_via, search_stops, set, union};
use crate::folding::FoldingMap;
use crate::pattern::{CreasePattern, FaceId};
use crate::planner::following::judge::Judge;
use crate::planner::following::mobility::independent_parts;
use crate::planner::following::reduction::{CLOSED, Reduction};
use crate::planner::following::route::Route;
use crate::planner::lifting::swept_motion::{FIRST_BOUND_FRACTION, LEAST_BOUND_FRACTION};
use crate::planner::plan::{Effort, Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::Note;
use crate::progress::Stage;
use crate::symmetry::{CreaseGroups, ReducedStars};

/// Largest number of creases of a sheet whose folds are put in sequence.
const MAX_CREASES: usize = 200;
/// Largest number of creases of a sheet whose hinges turn freely and whose folds are put in sequence.
const MAX_FREE_CREASES: usize = 1000;
/// Largest number of sets of folded creases that are judged.
const MAX_SETS: usize = 2000;
/// Largest number of steps in the search for sequences.
const MAX_STEPS: usize = 100_000;
/// Largest number of configurations of the path at which creases that move each other are found.
const MAX_CONFIGURATIONS: usize = 16;

/// Returns `true` if a sheet has few enough creases for folds in sequence to be looked for.
pub(crate) fn has_few_creases(problem: &PlanningProblem<'_>) -> bool {
    let most = if turns_freely(problem.pattern) {
        MAX_FREE_CREASES
    } else {
        MAX_CREASES
    };
    problem.pattern.creases().len() <= most
}

/// Returns the plan that folds independent parts of the sheet, and along lines, one after the other on one leg, if that
/// leads to its end and no faces cross; with as few stops as it takes. The leg is that of
/// [`try_phases`](super::stops::try_phases).
///
/// Sequences are found depth first. If a part cannot be next because two faces cross, it is not tried again in any
/// sequence that has folded the creases between these two faces in the same order: those creases alone determine where
/// the two faces are, and which one lies on the other. Source, for the assembly of parts: R. Wilson, J.-C. Latombe,
/// "Geometric reasoning about mechanical assembly", 1994.
pub(crate) fn fold_in_sequence(
    problem: &PlanningProblem<'_>,
    route: &Route<'_>,
    leg: &Leg,
) -> Option<Plan> {
    let (pattern, options) = (problem.pattern, problem.options);
    let all = leg.turned_creases();
    let reduction = Reduction::of(problem, CreaseGroups::trivial(pattern));
    let is_free = turns_freely(pattern);
    let mut orders = Orders {
        problem,
        samples: is_free.then(|| PhaseSamples::new(problem, &reduction, leg)),
        beyond: if is_free {
            faces_beyond(pattern)
        } else {
            Vec::new()
        },
        judge: Judge::new(problem, &reduction, options.collision),
        in_the_way: vec![0; leg.end.len()],
        parts: parts(problem, route, leg).unwrap_or_default(),
        leg,
        all,
        moves: HashMap::new(),
        free: HashMap::new(),
        dead: HashSet::new(),
        barred: Vec::new(),
        steps: 0,
        order: Vec::new(),
    };
    let plan = search_stops(problem, leg, &mut orders)?;
    Some(with_fewer_stops(&mut orders, plan))
}

/// Phases of a motion, each with the sets of creases that fold at once in it.
type Phases = Vec<Vec<FixedBitSet>>;

/// Reduces the number of phases of a plan: sets of creases that follow each other, and that could each be next, are
/// folded at once if no faces cross then. If hinges turn freely, a set in which samples cross is not tried.
fn with_fewer_stops(orders: &mut Orders<'_>, mut plan: Plan) -> Plan {
    let mut effort = Effort::default();
    let order = core::mem::take(&mut orders.order).into_iter();
    let mut phases: Phases = order.map(|next| vec![next]).collect();
    let plan_of = |orders: &Orders<'_>, phases: &Phases, bound_fraction| {
        let phases = phases.iter().map(|once| union(&orders.leg.end, once));
        let stops = orders.leg.stops_of(&phases.collect::<Vec<_>>());
        plan_via(orders.problem, orders.leg, &stops, bound_fraction)
    };
    let mut is_planned = |orders: &mut Orders<'_>, phases: &Phases, bound_fraction| {
        let mut other = plan_of(orders, phases, bound_fraction);
        let is_planned = other.outcome == Outcome::Planned;
        if is_planned {
            core::mem::swap(&mut plan, &mut other);
        }
        effort += other.effort;
        is_planned
    };
    let sampled = orders.samples.is_some();
    let fewest = sampled.then(|| merged(orders, phases.clone(), |_, _| true));
    match fewest {
        Some(fewest) if is_planned(orders, &fewest, FIRST_BOUND_FRACTION) => phases = fewest,
        _ => {
            phases = merged(orders, phases, |orders, fewer| {
                is_planned(orders, fewer, LEAST_BOUND_FRACTION)
            });
            is_planned(orders, &phases, FIRST_BOUND_FRACTION);
        }
    }
    plan.effort += effort;
    plan.notes.push(Note::Phases(phases.len()));
    plan
}

/// Merges phases that follow each other, from long runs to short ones, where samples are free and `is_good` is true of the
/// phases that are left.
fn merged(
    orders: &mut Orders<'_>,
    mut phases: Phases,
    mut is_good: impl FnMut(&mut Orders<'_>, &Phases) -> bool,
) -> Phases {
    let mut run = phases.len().div_ceil(2);
    while run > 1 && !orders.is_spent() {
        let mut from = 0;
        while from + 1 < phases.len() && phases.len() > run {
            let to = phases.len().min(from + run);
            let once = phases[from..to].concat();
            let before = union(&orders.leg.end, &phases[..from].concat());
            let next = orders.moves(&before);
            let mut fewer = phases.clone();
            fewer.splice(from..to, [once.clone()]);
            from += run - 1;
            if once.iter().all(|creases| next.contains(creases))
                && orders.is_sampled_free(&before, &once)
                && is_good(orders, &fewer)
            {
                phases = fewer;
                from -= run - 1;
            }
        }
        run = run.div_ceil(2).min(run - 1);
    }
    phases
}

/// Returns for each crease the number of faces on the side that has fewer, on a sheet whose hinges turn freely.
fn faces_beyond(pattern: &CreasePattern) -> Vec<usize> {
    let mut faces = vec![1; pattern.faces().len()];
    let mut beyond = vec![0; pattern.creases().len()];
    for step in pattern.tree().steps().iter().rev() {
        let own = faces[step.face.index()];
        faces[step.parent.index()] += own;
        if let Some(crease) = step.crease {
            beyond[crease.index()] = own.min(faces.len() - own);
        }
    }
    beyond
}

/// Returns the sets of creases that turn and move each other along `route`; creases of different sets do not.
fn parts(problem: &PlanningProblem<'_>, route: &Route<'_>, leg: &Leg) -> Option<Vec<FixedBitSet>> {
    let groups = &route.reduction.groups;
    let waypoints = &route.waypoints;
    // The sheet is singular where it is flat, and often at the goal: only configurations between are used.
    let inner = waypoints.get(1..waypoints.len().checked_sub(1)?)?;
    let step = inner.len().div_ceil(MAX_CONFIGURATIONS).max(1);
    let looks = inner.iter().step_by(step);
    let mut looks: Vec<_> = looks.map(|w| groups.expand(&w.angles)).collect();
    if looks.is_empty() {
        looks.push(
            (0..leg.end.len())
                .map(|crease| leg.angle(crease, 0.5))
                .collect(),
        );
    }
    let stars = ReducedStars::of_creases(problem.pattern);
    let stars = if problem.errors.is_snapped() {
        stars.snapped(route.reduction.within).0
    } else {
        stars
    };
    let parts = independent_parts(&stars, &looks)?;
    let turned = |crease: &usize| leg.turn(*crease).abs() > CLOSED;
    let parts = parts
        .into_iter()
        .map(|part| part.into_iter().filter(turned));
    Some(parts.map(|part| set(&leg.end, part)).collect())
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
    /// Samples of what turns next, if hinges turn freely; otherwise only whole plans tell how creases turn together.
    samples: Option<PhaseSamples<'a>>,
    /// For each crease the number of faces on the side that has fewer, if hinges turn freely.
    beyond: Vec<usize>,
    leg: &'a Leg,
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
    /// The sequence that is tried.
    order: Vec<FixedBitSet>,
}

impl StopSearch for Orders<'_> {
    const MAX_TRIES: usize = 200;
    // The motion is placed as near to its path as it gets, so that only a path that crosses is rejected.
    const BOUND_FRACTION: f64 = LEAST_BOUND_FRACTION;

    fn next(&mut self) -> Option<Vec<Vec<f64>>> {
        let mut order = Vec::new();
        let is_first = self.barred.is_empty() && self.steps == 0;
        if let Some(opened) = is_first.then(|| self.opened()).flatten() {
            order = opened;
        } else {
            self.extend(&mut order).ok()?;
        }
        self.order = order;
        Some(self.leg.stops_of(&self.order))
    }

    /// Bars the set of creases that ended the plan from being next after the others.
    fn learn(&mut self, plan: &Plan) {
        let next = self.leg.ended_phases(plan).min(self.order.len() - 1);
        let between = match plan.outcome {
            Outcome::Crossing(crossing) => between(self.problem.pattern, crossing.faces),
            _ => self.all.clone(),
        };
        let before: Vec<_> = of_those(&self.order[..next], &between).collect();
        for crease in before.iter().flat_map(FixedBitSet::ones) {
            self.in_the_way[crease] += 1;
        }
        self.barred.push(Barred {
            between,
            before,
            next: self.order[next].clone(),
        });
    }
}

impl Orders<'_> {
    /// Returns `true` if time has run out, or enough samples were taken.
    fn is_spent(&self) -> bool {
        let samples = self.samples.as_ref();
        samples.map_or(self.problem.is_late(), PhaseSamples::is_spent)
    }

    /// Returns `true` if nothing is known that keeps a set of creases from turning after others.
    fn may_follow(
        &mut self,
        folded: &FixedBitSet,
        next: &FixedBitSet,
        after: &FixedBitSet,
    ) -> bool {
        match &mut self.samples {
            Some(samples) => samples.is_free(folded, next),
            None => self.is_free(after),
        }
    }

    /// Returns `true` if samples are free, or none are taken, while sets of creases turn at once after those `before`.
    fn is_sampled_free(&mut self, before: &FixedBitSet, once: &[FixedBitSet]) -> bool {
        let once = union(&self.leg.end, once);
        let samples = self.samples.as_mut();
        samples.is_none_or(|samples| samples.is_free(before, &once))
    }

    fn is_free(&mut self, folded: &FixedBitSet) -> bool {
        if let Some(&free) = self.free.get(folded) {
            return free;
        }
        let angles = self.leg.angles(folded);
        let free = self.free.len() < MAX_SETS
            && (self.problem).stage(Stage::Crossings, || {
                self.judge.is_free(&angles, self.problem.options)
            });
        self.free.insert(folded.clone(), free);
        free
    }

    /// Returns the sets that can turn next: simple folds, and parts that move on their own, without their folded
    /// creases.
    fn moves(&mut self, folded: &FixedBitSet) -> Rc<[FixedBitSet]> {
        if let Some(moves) = self.moves.get(folded) {
            return moves.clone();
        }
        let pattern = self.problem.pattern;
        let map = FoldingMap::new(pattern, pattern.tree(), &self.leg.angles(folded));
        let mut turns = vec![0.0; self.leg.end.len()];
        for crease in self.all.difference(folded) {
            turns[crease] = self.leg.turn(crease);
        }
        let folds = simple_folds(pattern, map.vertices(), &turns);
        let rest = self
            .parts
            .iter()
            .map(|part| part.difference(folded).collect());
        let mut moves: Vec<FixedBitSet> = Vec::new();
        for creases in folds.into_iter().chain(rest) {
            let creases: Vec<usize> = creases;
            let creases = set(&self.leg.end, creases);
            // All creases at once were the first try.
            if !creases.is_clear() && creases != self.all && !moves.contains(&creases) {
                moves.push(creases);
            }
        }
        let moves: Rc<[FixedBitSet]> = moves.into();
        self.moves.insert(folded.clone(), moves.clone());
        moves
    }

    /// Looks for a sequence from its end, if samples are taken: opens a part that can be opened, until all are open. Near the
    /// end, where parts lie in each other, few can. Nothing that was opened is closed again, so that some sequences are not
    /// found. Parts beside the one opened last are tried first, and those last that could not be opened most often.
    fn opened(&mut self) -> Option<Vec<FixedBitSet>> {
        let samples = self.samples.as_mut()?;
        let all = samples.left();
        // The rest is for folding at once what can be.
        let least_left = all / 4;
        let pattern = self.problem.pattern;
        let faces = |part: &FixedBitSet| {
            let edges = part.ones().map(|crease| pattern.creases()[crease]);
            let faces = edges.filter_map(|edge| pattern.edge(edge).inner_faces());
            faces.flatten().collect::<Vec<FaceId>>()
        };
        let beyond = |part: &FixedBitSet| part.ones().map(|crease| self.beyond[crease]).max();
        let parts = self.parts.iter().filter(|part| !part.is_clear());
        let mut closed: Vec<(usize, &FixedBitSet)> = parts.map(|part| (0, part)).collect();
        let mut folded = self.all.clone();
        let (mut order, mut last) = (Vec::new(), Vec::new());
        while !closed.is_empty() {
            closed.sort_by_cached_key(|&(failures, part)| {
                let is_beside = faces(part).iter().any(|face| last.contains(face));
                (!is_beside, failures, beyond(part))
            });
            let next = closed.iter_mut().position(|(failures, part)| {
                let before = folded.difference(part).collect();
                *failures += 1;
                samples.left() > least_left && !samples.is_spent() && samples.is_free(&before, part)
            });
            let Some(next) = next else {
                // Other searches may take as many samples as without this one.
                samples.allow(all);
                return None;
            };
            let (_, part) = closed.remove(next);
            folded.difference_with(part);
            last = faces(part);
            order.push(part.clone());
        }
        order.reverse();
        Some(order)
    }

    /// Extends a sequence to all creases, if possible. `Err(true)` says that it is impossible in any order of the
    /// creases folded so far.
    fn extend(&mut self, order: &mut Vec<FixedBitSet>) -> Result<(), bool> {
        let folded = union(&self.leg.end, order);
        if folded == self.all {
            return Ok(());
        }
        self.steps += 1;
        if self.steps > MAX_STEPS {
            return Err(false);
        }
        let mut in_any_order = true;
        let mut moves = self.moves(&folded).to_vec();
        // Sets whose creases were seldom in the way come first, and of these the ones that turn few faces.
        let most = |counts: &[usize], next: &FixedBitSet| {
            next.ones()
                .filter_map(|crease| counts.get(crease).copied())
                .max()
        };
        moves.sort_by_cached_key(|next| (most(&self.in_the_way, next), most(&self.beyond, next)));
        for next in moves {
            if self.is_spent() {
                return Err(false);
            }
            let after = &folded | &next;
            if self.dead.contains(&after) || !self.may_follow(&folded, &next, &after) {
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
}

impl Barred {
    fn bars(&self, order: &[FixedBitSet], next: &FixedBitSet) -> bool {
        self.next == *next && of_those(order, &self.between).eq(self.before.iter().cloned())
    }
}
