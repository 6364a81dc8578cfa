//! Phases split at crossings: all creases fold at once, but for those that wait or go first because faces would cross.
//!
//! In a net every hinge is free to turn on its own, and configurations in which each hinge is flat or at its goal lead
//! round most obstacles. Source: Z. Xi, J.-M. Lien, report GMU-CS-TR-2015-4, which draws such configurations at random.
//! Here the faces that cross say which creases to move to another phase.

use core::cmp::Reverse;
use std::collections::{BinaryHeap, HashSet};

use fixedbitset::FixedBitSet;

use super::fold_sequence::{between, plan_in_phases, set};
use crate::folding::SpanningTree;
use crate::planner::following::reduction::CLOSED;
use crate::planner::lifting::whole_sheet::FIRST_BOUND_FRACTION;
use crate::planner::plan::{Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::Note;

/// Largest number of ways to part the creases into phases that are tried as plans.
const MAX_TRIES: usize = 200;
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
    tree: &'a SpanningTree,
    known: HashSet<Phases>,
    open: BinaryHeap<Candidate>,
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
    let pattern = problem.pattern;
    let turned = goal.iter().enumerate();
    let turned = turned.filter(|(_, angle)| angle.abs() > CLOSED);
    let all = vec![set(goal, turned.map(|(crease, _)| crease))];
    let mut candidates = Candidates {
        goal,
        tree: pattern.tree(),
        known: HashSet::from([all.clone()]),
        open: BinaryHeap::new(),
    };
    candidates.split(&all, straight);
    let mut effort = Plan::default();
    for _ in 0..MAX_TRIES {
        let phases = candidates.open.pop()?.phases;
        if problem.is_late() {
            return None;
        }
        let mut plan = plan_in_phases(problem, goal, &phases, FIRST_BOUND_FRACTION);
        if plan.outcome == Outcome::Planned {
            plan.add_effort(&effort);
            plan.notes.push(Note::Phases(phases.len()));
            return Some(plan);
        }
        candidates.split(&phases, &plan);
        effort.add_effort(&plan);
    }
    None
}

impl Candidates<'_> {
    /// Adds the ways to split the phase of a plan in which faces cross.
    fn split(&mut self, phases: &Phases, plan: &Plan) {
        let Outcome::Crossing(crossing) = plan.outcome else {
            return;
        };
        let ended = plan.path.knots.iter().filter(|knot| knot.ends_phase);
        let phase = ended.count().min(phases.len() - 1);
        let between = between(self.tree, self.goal, crossing.faces);
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
