//! Phases split at crossings: all creases fold at once, but for those that wait or go first because faces would cross.
//!
//! In a net every hinge is free to turn on its own, and configurations in which each hinge is flat or at its goal lead
//! round most obstacles. Source: Z. Xi, J.-M. Lien, report GMU-CS-TR-2015-4, which draws such configurations at random.
//! Here the faces that cross say which creases to move to another phase.

use core::cmp::Reverse;
use std::collections::{BinaryHeap, HashSet};

use fixedbitset::FixedBitSet;

use super::stops::{StopSearch, between, search_stops, stops_of, turned_creases};
use crate::pattern::CreasePattern;
use crate::planner::lifting::swept_motion::FIRST_BOUND_FRACTION;
use crate::planner::plan::{Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::Note;

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
    /// Fold angle of each crease at the goal, radians.
    goal: &'a [f64],
    pattern: &'a CreasePattern,
    known: HashSet<Phases>,
    open: BinaryHeap<Candidate>,
    /// The phases that are tried.
    tried: Phases,
}

/// Returns `true` if each hinge of a sheet is free to turn on its own, and faces cross on the plan that folds all at
/// once.
pub(crate) fn splits_phases(problem: &PlanningProblem<'_>, straight: &Plan) -> bool {
    let pattern = problem.pattern;
    let is_free = pattern.real_vertices().next().is_none() && pattern.holes().is_empty();
    is_free && matches!(straight.outcome, Outcome::Crossing(_))
}

/// Returns a plan to `goal` (fold angles in radians) in which some creases fold before or after the others, if one is
/// found. `straight` is the plan that folds all at once, for which [`splits_phases`] is true.
///
/// Best first: where two faces cross in a phase, each crease between them is moved to a phase before or after.
pub(crate) fn fold_in_split_phases(
    problem: &PlanningProblem<'_>,
    goal: &[f64],
    straight: &Plan,
) -> Option<Plan> {
    let all = vec![turned_creases(goal)];
    let mut candidates = Candidates {
        goal,
        pattern: problem.pattern,
        known: HashSet::from([all.clone()]),
        open: BinaryHeap::new(),
        tried: all,
    };
    candidates.learn(straight);
    let mut plan = search_stops(problem, &mut candidates)?;
    plan.notes.push(Note::Phases(candidates.tried.len()));
    Some(plan)
}

impl StopSearch for Candidates<'_> {
    const MAX_TRIES: usize = 200;
    const BOUND_FRACTION: f64 = FIRST_BOUND_FRACTION;

    fn next(&mut self) -> Option<Vec<Vec<f64>>> {
        self.tried = self.open.pop()?.phases;
        Some(stops_of(self.goal, &self.tried))
    }

    /// Adds the ways to split the phase of a plan in which faces cross.
    fn learn(&mut self, plan: &Plan) {
        let Outcome::Crossing(crossing) = plan.outcome else {
            return;
        };
        let phases = &self.tried;
        let phase = plan.ended_phases().min(phases.len() - 1);
        let between = between(self.pattern, crossing.faces);
        for crease in between.intersection(&phases[phase]) {
            for next in with_one_moved(phases, phase, crease) {
                if !self.known.insert(next.clone()) {
                    continue;
                }
                #[allow(clippy::cast_precision_loss, reason = "a count of phases")]
                let promise = 1e6 * (plan.reached - WORTH_OF_PHASE * next.len() as f64);
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
