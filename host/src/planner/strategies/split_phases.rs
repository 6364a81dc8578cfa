//! Phases split at crossings: all creases fold at once, but for those that wait or go first because faces would cross.
//!
//! In a net every hinge is free to turn on its own, and configurations in which each hinge is flat or at its goal lead
//! round most obstacles. Source: Z. Xi, J.-M. Lien, report GMU-CS-TR-2015-4, which draws such configurations at random.
//! Here the faces that cross say which creases to move to another phase.

use core::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};

use fixedbitset::FixedBitSet;

use super::phase_samples::{PhaseSamples, SampledCrossing, turns_freely};
use super::stops::{Leg, StopSearch, between, search_stops, set};
use crate::planner::following::reduction::Reduction;
use crate::planner::lifting::swept_motion::FIRST_BOUND_FRACTION;
use crate::planner::plan::{Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::Note;
use crate::symmetry::CreaseGroups;

/// Fraction of the way to the goal that another phase is worth: a way with one phase more is tried first only if the
/// way that it was made from leads farther by this.
const WORTH_OF_PHASE: f64 = 0.05;

/// The creases that turn in each phase of a motion.
type Phases = Vec<FixedBitSet>;

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

/// Ways to part the creases into phases that are still to be tried.
struct Candidates<'a> {
    leg: &'a Leg,
    problem: &'a PlanningProblem<'a>,
    samples: PhaseSamples<'a>,
    /// The first phases of plans in which faces cross in the last of them: the faces, and the part of it that is free.
    crossed: HashMap<Phases, SampledCrossing>,
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
    let all = vec![leg.turned_creases()];
    let reduction = Reduction::of(problem, CreaseGroups::trivial(problem.pattern));
    let mut candidates = Candidates {
        leg,
        problem,
        samples: PhaseSamples::new(problem, &reduction, leg),
        crossed: HashMap::new(),
        known: HashSet::from([all.clone()]),
        open: BinaryHeap::new(),
        tried: all,
    };
    candidates.learn(straight);
    let mut plan = search_stops(problem, leg, &mut candidates)?;
    plan.notes.push(Note::Phases(candidates.tried.len()));
    Some(plan)
}

impl StopSearch for Candidates<'_> {
    // Phases that cross at samples are not tried.
    const MAX_TRIES: usize = 50;
    const BOUND_FRACTION: f64 = FIRST_BOUND_FRACTION;

    fn next(&mut self) -> Option<Vec<Vec<f64>>> {
        loop {
            self.tried = self.open.pop()?.phases;
            let Some((phase, crossing)) = self.sampled_crossing() else {
                return Some(self.leg.stops_of(&self.tried));
            };
            if self.samples.is_spent() {
                return None;
            }
            self.split(phase, crossing);
        }
    }

    fn learn(&mut self, plan: &Plan) {
        if let Outcome::Crossing(crossing) = plan.outcome {
            let phase = self.leg.ended_phases(plan).min(self.tried.len() - 1);
            let free = self.leg.folded_part(plan, &self.tried[phase]);
            let faces = crossing.faces;
            let crossing = SampledCrossing { free, faces };
            self.crossed.insert(self.tried[..=phase].to_vec(), crossing);
            self.split(phase, crossing);
        }
    }
}

impl Candidates<'_> {
    /// Returns the first phase of those tried in which samples cross, or plans with the same first phases did.
    fn sampled_crossing(&mut self) -> Option<(usize, SampledCrossing)> {
        let mut before = set(&self.leg.end, []);
        (0..self.tried.len()).find_map(|index| {
            let phase = &self.tried[index];
            let sampled = self.samples.crossing(&before, phase);
            before.union_with(phase);
            let planned = || self.crossed.get(&self.tried[..=index]).copied();
            Some((index, sampled.or_else(planned)?))
        })
    }

    /// Adds the ways to split the phase of those tried in which two faces cross.
    fn split(&mut self, phase: usize, crossing: SampledCrossing) {
        let phases = &self.tried;
        let lengths: Vec<f64> = phases.iter().map(|phase| self.leg.length(phase)).collect();
        let before: f64 = lengths[..phase].iter().sum();
        let whole: f64 = lengths.iter().sum();
        let reached = (before + crossing.free * lengths[phase]) / whole;
        let between = between(self.problem.pattern, crossing.faces);
        for crease in between.intersection(&phases[phase]) {
            for next in with_one_moved(phases, phase, crease) {
                if !self.known.insert(next.clone()) {
                    continue;
                }
                #[allow(clippy::cast_precision_loss, reason = "a count of phases")]
                let promise = 1e6 * (reached - WORTH_OF_PHASE * next.len() as f64);
                #[allow(clippy::cast_possible_truncation, reason = "millionths")]
                self.open.push(Candidate {
                    promise: promise as i64,
                    made: Reverse(self.known.len()),
                    phases: next,
                });
            }
        }
    }
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
