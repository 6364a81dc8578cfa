//! Phases split at crossings: all creases fold at once, but for those that wait or go first because faces would cross.
//!
//! In a net every hinge is free to turn on its own, and configurations in which each hinge is flat or at its goal lead
//! round most obstacles. Source: Z. Xi, J.-M. Lien, report GMU-CS-TR-2015-4, which draws such configurations at random.
//! Here the faces that cross say which creases to move to another phase.

use core::cmp::Reverse;
use std::collections::{BinaryHeap, HashSet};

use fixedbitset::FixedBitSet;

use super::phase_samples::{PhaseSamples, SampledCrossing, turns_freely};
use super::rings::Rings;
use super::stops::{Leg, StopSearch, between, of_those, search_stops, set};
use crate::pattern::EdgeId;
use crate::planner::following::reduction::{CLOSED, Reduction};
use crate::planner::lifting::swept_motion::FIRST_BOUND_FRACTION;
use crate::planner::plan::{FoldOrder, Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::Note;
use crate::symmetry::CreaseGroups;

/// Fraction of the way to the goal that another phase is worth: a way with one phase more is tried first only if the
/// way that it was made from leads farther by this.
const WORTH_OF_PHASE: f64 = 0.05;

/// The creases that turn in each phase of a motion.
type Phases = Vec<FixedBitSet>;

/// Angles (degrees) by which creases beyond others turn past their goals and return, in the order in which they are tried.
const PAST_DEG: [f64; 4] = [20.0, 10.0, 35.0, 0.0];
/// Effort for plans in which rings close first, for each of these angles, over that for all others.
const RINGS_EFFORT_RATIO: f64 = 0.03;

/// A way to part the creases into phases that is still to be tried. The greatest is tried first: the one that promises
/// most, and of these the first made.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// Millionths of the way to the goal on which the phases that these were made from are free, less what the number
    /// of phases costs.
    promise: i64,
    made: Reverse<usize>,
    phases: Phases,
}

/// A crossing on a plan. The creases between the two faces alone determine where they are and which lies on the other, so
/// that the faces cross in all phases in which these creases turn alike.
struct PlannedCrossing {
    crossing: SampledCrossing,
    between: FixedBitSet,
    /// The creases between that turn in each phase in which some do, up to the one with the crossing.
    phases: Phases,
}

/// Ways to part the creases into phases that are still to be tried.
struct Candidates<'a> {
    leg: &'a Leg,
    problem: &'a PlanningProblem<'a>,
    samples: PhaseSamples<'a>,
    /// Creases that turn before all others; none if all may turn at any time.
    body: FixedBitSet,
    /// Fold angles of the creases at the goal, radians. Creases that turn past theirs on the leg return to it at last.
    goal: &'a [f64],
    /// `true` if they return one after the other.
    return_in_turn: bool,
    /// Crossings on plans, and the number of phases that were not planned because of them.
    crossed: Vec<PlannedCrossing>,
    saved: usize,
    known: HashSet<Phases>,
    open: BinaryHeap<Candidate>,
    /// The phases that are tried.
    tried: Phases,
}

/// Returns `true` if each hinge of a sheet is free to turn on its own, and faces cross on the plan that folds all at
/// once.
pub(crate) fn splits_phases(problem: &PlanningProblem<'_>, straight: &Plan) -> bool {
    turns_freely(problem.pattern) && matches!(straight.outcome, Outcome::Crossing(_))
}

/// Returns a plan in which some creases fold before or after the others on one leg, if one is found. `straight` is the plan
/// that folds all at once, for which [`splits_phases`] is true.
///
/// Best first: where two faces cross in a phase, each crease between them is moved to a phase before or after. Only phases
/// whose samples are free are planned.
pub(crate) fn fold_in_split_phases(
    problem: &PlanningProblem<'_>,
    leg: &Leg,
    straight: &Plan,
) -> Option<Plan> {
    let reduction = Reduction::of(problem, CreaseGroups::trivial(problem.pattern));
    let mut found = None;
    for rings in Rings::of(problem.pattern, leg) {
        fold_rings_first(problem, &reduction, leg, &rings, &mut found);
    }
    let mut candidates = Candidates::new(problem, &reduction, leg, &leg.end);
    candidates.tried = vec![leg.turned_creases()];
    candidates.known.insert(candidates.tried.clone());
    candidates.learn(straight);
    candidates.find(&mut found);
    found
}

/// Looks for plans in which rings close before all else folds.
fn fold_rings_first(
    problem: &PlanningProblem<'_>,
    reduction: &Reduction<'_>,
    leg: &Leg,
    rings: &Rings,
    found: &mut Option<Plan>,
) {
    let edges = |creases: &FixedBitSet| -> Vec<EdgeId> {
        let creases = creases.ones();
        creases
            .map(|crease| problem.pattern.creases()[crease])
            .collect()
    };
    let mut tried = Vec::new();
    for past in PAST_DEG {
        let past = leg.with_end(rings.past(leg, past.to_radians(), problem.options));
        if tried.contains(&past.end) {
            continue;
        }
        tried.push(past.end.clone());
        let mut candidates = Candidates::new(problem, reduction, &past, &leg.end);
        candidates.samples = candidates.samples.with_part(RINGS_EFFORT_RATIO);
        candidates.body.clone_from(&rings.body);
        candidates.add(rings.phases(), 0.0);
        let is_first = found.is_none();
        candidates.find(found);
        if let Some(plan) = found.as_mut().filter(|_| is_first) {
            plan.notes.push(Note::RingsFirst(edges(&rings.body)));
            let by = |crease: usize| (past.end[crease] - leg.end[crease]).abs();
            let by = (0..leg.end.len()).map(by).fold(0.0, f64::max);
            if by > CLOSED {
                let edges = edges(&rings.outer);
                plan.notes.push(Note::TurnsPast { edges, by });
            }
        }
    }
}

impl StopSearch for Candidates<'_> {
    // Phases that cross at samples are not tried.
    const MAX_TRIES: usize = 50;
    const BOUND_FRACTION: f64 = FIRST_BOUND_FRACTION;

    fn next(&mut self) -> Option<Vec<Vec<f64>>> {
        loop {
            self.tried = self.open.pop()?.phases;
            let Some((phase, crossing)) = self.sampled_crossing() else {
                let mut stops = self.leg.stops_of(&self.tried);
                stops.extend(self.return_stops());
                return Some(stops);
            };
            // Phases that are known to cross count as if they were planned.
            if self.samples.is_spent() || self.crossed.len() + self.saved >= Self::MAX_TRIES {
                return None;
            }
            self.split(phase, crossing);
        }
    }

    fn learn(&mut self, plan: &Plan) {
        if let Outcome::Crossing(crossing) = plan.outcome {
            let ended = self.leg.ended_phases(plan);
            if ended >= self.tried.len() && !self.return_stops().is_empty() {
                if !core::mem::replace(&mut self.return_in_turn, true) {
                    self.known.remove(&self.tried);
                    self.add(self.tried.clone(), 1.0);
                }
                return;
            }
            let phase = ended.min(self.tried.len() - 1);
            let free = self.leg.folded_part(plan, &self.tried[phase]);
            let faces = crossing.faces;
            let crossing = SampledCrossing { free, faces };
            let between = between(self.problem.pattern, faces);
            self.crossed.push(PlannedCrossing {
                crossing,
                phases: of_those(&self.tried[..=phase], &between).collect(),
                between,
            });
            self.split(phase, crossing);
        }
    }
}

impl<'a> Candidates<'a> {
    fn new(
        problem: &'a PlanningProblem<'a>,
        reduction: &'a Reduction<'a>,
        leg: &'a Leg,
        goal: &'a [f64],
    ) -> Self {
        Self {
            leg,
            problem,
            samples: PhaseSamples::new(problem, reduction, leg),
            body: set(&leg.end, []),
            goal,
            return_in_turn: false,
            crossed: Vec::new(),
            saved: 0,
            known: HashSet::new(),
            open: BinaryHeap::new(),
            tried: Vec::new(),
        }
    }

    /// Looks for a plan, unless one is found, and for as many orders that differ as are asked for.
    fn find(&mut self, found: &mut Option<Plan>) {
        let asked = self.problem.options.orders;
        while found.as_ref().is_none_or(|plan| plan.orders.len() < asked) {
            let Some(mut plan) = search_stops(self.problem, self.leg, self) else {
                return;
            };
            let order = plan.motion.as_ref().map(FoldOrder::of);
            let Some(first) = found else {
                let phases = self.tried.len() + self.return_stops().len();
                plan.notes.push(Note::Phases(phases));
                plan.orders.extend(order);
                *found = Some(plan);
                continue;
            };
            first.effort += plan.effort;
            let order = order.filter(|order| first.orders.iter().all(|it| it.differs_from(order)));
            first.orders.extend(order);
        }
    }

    /// Returns the fold angles (radians) from which creases past their goals return: all at once, or one after the other.
    fn return_stops(&self) -> Vec<Vec<f64>> {
        let mut at = self.leg.end.clone();
        let mut stops: Vec<Vec<f64>> = Vec::new();
        for (crease, &goal) in self.goal.iter().enumerate() {
            if (at[crease] - goal).abs() > CLOSED {
                if stops.is_empty() || self.return_in_turn {
                    stops.push(at.clone());
                }
                at[crease] = goal;
            }
        }
        stops
    }

    /// Adds phases to those that are to be tried, if they are new and the body folds first, given the fraction of the way
    /// to the goal on which the phases that they were made from are free.
    fn add(&mut self, phases: Phases, reached: f64) {
        if !folds_first(&phases, &self.body) || !self.known.insert(phases.clone()) {
            return;
        }
        #[allow(clippy::cast_precision_loss, reason = "a count of phases")]
        let promise = 1e6 * (reached - WORTH_OF_PHASE * phases.len() as f64);
        #[allow(clippy::cast_possible_truncation, reason = "millionths")]
        self.open.push(Candidate {
            promise: promise as i64,
            made: Reverse(self.known.len()),
            phases,
        });
    }

    /// Returns the first phase of those tried in which samples cross, or in which faces are known to cross from plans.
    fn sampled_crossing(&mut self) -> Option<(usize, SampledCrossing)> {
        let mut before = set(&self.leg.end, []);
        for (index, phase) in self.tried.iter().enumerate() {
            if let Some(sampled) = self.samples.crossing(&before, phase) {
                return Some((index, sampled));
            }
            let phases = &self.tried[..=index];
            if let Some(known) = self.crossed.iter().find_map(|it| it.crosses(phases)) {
                self.saved += 1;
                return Some((index, known));
            }
            before.union_with(phase);
        }
        None
    }

    /// Adds the ways to split the phase of those tried in which two faces cross.
    fn split(&mut self, phase: usize, crossing: SampledCrossing) {
        let phases = self.tried.clone();
        let lengths: Vec<f64> = phases.iter().map(|phase| self.leg.length(phase)).collect();
        let before: f64 = lengths[..phase].iter().sum();
        let whole: f64 = lengths.iter().sum();
        let reached = (before + crossing.free * lengths[phase]) / whole;
        let between = between(self.problem.pattern, crossing.faces);
        for crease in between.intersection(&phases[phase]) {
            for next in with_one_moved(&phases, phase, crease) {
                self.add(next, reached);
            }
        }
    }
}

impl PlannedCrossing {
    /// Returns the crossing if the faces cross in the last of these phases.
    fn crosses(&self, phases: &[FixedBitSet]) -> Option<SampledCrossing> {
        let turns = |phase: &&FixedBitSet| !phase.is_disjoint(&self.between);
        let alike = || of_those(phases, &self.between).eq(self.phases.iter().cloned());
        let crosses = phases.last().filter(turns).is_some() && alike();
        crosses.then_some(self.crossing)
    }
}

/// Returns `true` if some creases fold in the first phases, and in these nothing else does.
fn folds_first(phases: &Phases, body: &FixedBitSet) -> bool {
    let mut left = body.clone();
    phases.iter().all(|phase| {
        let may_fold = left.is_clear() || phase.is_subset(&left);
        left.difference_with(phase);
        may_fold
    })
}

/// Returns the ways to move a crease out of a phase: to a new phase after or before it, or to the phase that is there.
fn with_one_moved(phases: &Phases, phase: usize, crease: usize) -> Vec<Phases> {
    let mut without = phases.clone();
    without[phase].remove(crease);
    let mut alone = FixedBitSet::with_capacity(phases[phase].len());
    alone.insert(crease);
    let new = [phase + 1, phase].map(|to| {
        let mut moved = without.clone();
        moved.insert(to, alone.clone());
        moved
    });
    let others = [Some(phase + 1), phase.checked_sub(1)];
    let joined = others.into_iter().flatten().filter_map(|to| {
        let mut moved = without.clone();
        moved.get_mut(to)?.insert(crease);
        Some(moved)
    });
    let mut all: Vec<Phases> = new.into_iter().chain(joined).collect();
    for moved in &mut all {
        moved.retain(|phase| !phase.is_clear());
    }
    all
}
