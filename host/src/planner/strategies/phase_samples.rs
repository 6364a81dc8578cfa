//! Phases of a sheet whose hinges all turn freely, judged by samples: whether faces cross at some configurations of a
//! phase. A phase that is free at all of them may still cross between them, so that what is found is planned in full.

use std::collections::HashMap;

use fixedbitset::FixedBitSet;

use super::stops::angles;
use crate::collision::Crossing;
use crate::pattern::{CreasePattern, FaceId};
use crate::planner::following::judge::Judge;
use crate::planner::following::reduction::Reduction;
use crate::planner::problem::PlanningProblem;

/// Fewest faces that are placed for samples of a sheet, and their number for each pair of its faces.
const FEWEST_FACES: usize = 200_000;
const FACES_PER_PAIR: usize = 40;
/// Parts of a phase at which crossings are looked for. Near the ends, layers come to lie on each other or leave each other.
const SAMPLES: [f64; 16] = [
    0.01, 0.03, 0.08, 0.16, 0.24, 0.32, 0.4, 0.48, 0.56, 0.64, 0.72, 0.8, 0.88, 0.95, 0.985, 1.0,
];

/// Returns `true` if each hinge of a sheet turns freely, whatever the others do.
pub(super) fn turns_freely(pattern: &CreasePattern) -> bool {
    pattern.real_vertices().next().is_none() && pattern.holes().is_empty()
}

/// The first sample of a phase at which faces cross.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampledCrossing {
    /// Part of the phase up to which samples are free, from 0 to 1.
    pub(super) free: f64,
    pub(super) faces: [FaceId; 2],
}

/// The phases of a sheet that were sampled.
pub(super) struct PhaseSamples<'a> {
    problem: &'a PlanningProblem<'a>,
    pattern: &'a CreasePattern,
    /// Number of faces that may yet be placed for samples.
    left: usize,
    judge: Judge<'a>,
    /// Fold angles of the creases when all are folded, radians.
    goal: Vec<f64>,
    /// By the creases folded before a phase and those that turn in it.
    known: HashMap<[FixedBitSet; 2], Option<SampledCrossing>>,
}

impl<'a> PhaseSamples<'a> {
    /// `reduction` is that without crease groups.
    pub(super) fn new(
        problem: &'a PlanningProblem<'a>,
        reduction: &'a Reduction<'a>,
        goal: &[f64],
    ) -> Self {
        let faces = problem.pattern.faces().len();
        Self {
            problem,
            left: FEWEST_FACES.max(FACES_PER_PAIR * faces * faces),
            pattern: problem.pattern,
            judge: Judge::new(problem, reduction, problem.options.collision),
            goal: goal.to_vec(),
            known: HashMap::new(),
        }
    }

    /// Returns `true` if no more samples are taken, as enough were, or time has run out.
    pub(super) fn is_spent(&self) -> bool {
        self.left == 0 || self.problem.is_late()
    }

    /// Returns the first crossing found while the creases of a phase turn from flat to their goals, after those `before`.
    /// No faces cross before the phase.
    pub(super) fn crossing(
        &mut self,
        before: &FixedBitSet,
        phase: &FixedBitSet,
    ) -> Option<SampledCrossing> {
        let sets = [before.clone(), phase.clone()];
        if let Some(known) = self.known.get(&sets) {
            return *known;
        }
        let mut free = 0.0;
        let found = SAMPLES.iter().find_map(|&part| {
            let found = self.sample(&sets, part);
            if found.is_none() {
                free = part;
            }
            Some(SampledCrossing {
                free,
                faces: found?.faces,
            })
        });
        self.known.insert(sets, found);
        found
    }

    /// Returns `true` if no crossing is found while the creases of a phase turn. Asks first at the end, where most of those
    /// that cross do.
    pub(super) fn is_free(&mut self, before: &FixedBitSet, phase: &FixedBitSet) -> bool {
        let sets = [before.clone(), phase.clone()];
        if !self.known.contains_key(&sets)
            && let Some(Crossing { faces, .. }) = self.sample(&sets, 1.0)
        {
            self.known
                .insert(sets, Some(SampledCrossing { free: 0.0, faces }));
            return false;
        }
        self.crossing(before, phase).is_none()
    }

    /// Returns the deepest crossing at a part of a phase, given the creases folded before and those that turn, of faces that
    /// the phase moves relative to each other.
    fn sample(&mut self, [before, phase]: &[FixedBitSet; 2], part: f64) -> Option<Crossing> {
        let mut at = angles(&self.goal, before);
        for crease in phase.ones() {
            at[crease] = self.goal[crease] * part;
        }
        let bodies = self.bodies(phase);
        self.left = self.left.saturating_sub(bodies.len());
        self.judge.crossing_of_bodies(&at, &bodies)
    }

    /// Returns for each face the first face of its body: of the faces that are at rest relative to each other while the
    /// creases of a phase turn.
    fn bodies(&self, phase: &FixedBitSet) -> Vec<FaceId> {
        let mut bodies: Vec<FaceId> = (0..self.pattern.faces().len()).map(FaceId::new).collect();
        for step in self.pattern.tree().steps() {
            if step.crease.is_none_or(|crease| !phase[crease.index()]) {
                bodies[step.face.index()] = bodies[step.parent.index()];
            }
        }
        bodies
    }
}
