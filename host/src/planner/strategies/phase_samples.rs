//! Phases of a sheet whose hinges all turn freely, judged by samples: whether faces cross at some configurations of a
//! phase. A phase that is free at all of them may still cross between them, so that what is found is planned in full.

use std::collections::HashMap;

use fixedbitset::FixedBitSet;

use super::stops::Leg;
use crate::collision::Crossing;
use crate::pattern::{CreaseId, CreasePattern, FaceId, bodies};
use crate::planner::following::judge::Judge;
use crate::planner::following::reduction::Reduction;
use crate::planner::problem::PlanningProblem;
use crate::progress::Stage;

/// Fewest faces that are placed for samples of a sheet, and their number for each pair of its faces.
const FEWEST_FACES: usize = 200_000;
const FACES_PER_PAIR: usize = 40;
/// Parts of a phase at which crossings are looked for. Near the ends, layers come to lie on each other or leave each other.
const SAMPLES: [f64; 16] = [
    0.01, 0.03, 0.08, 0.16, 0.24, 0.32, 0.4, 0.48, 0.56, 0.64, 0.72, 0.8, 0.88, 0.95, 0.985, 1.0,
];
/// The numbers of these samples in an order in which the first few are spread over the whole phase.
const SPREAD: [usize; 16] = [15, 14, 9, 4, 12, 2, 6, 13, 11, 8, 0, 10, 7, 5, 3, 1];
/// Number of times that the part between a sample that is free and one that crosses is halved, to tell how far phases lead
/// that part the creases in nearly the same way.
const HALVINGS: usize = 6;

/// Returns `true` if each hinge of a sheet turns freely, whatever the others do.
pub(super) fn turns_freely(pattern: &CreasePattern) -> bool {
    pattern.real_vertices().next().is_none() && !pattern.has_hinged_holes()
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
    /// Number of faces that may yet be placed for samples.
    left: usize,
    judge: Judge<'a>,
    leg: &'a Leg,
    /// By the creases folded before a phase and those that turn in it.
    known: HashMap<[FixedBitSet; 2], Option<SampledCrossing>>,
}

impl<'a> PhaseSamples<'a> {
    /// `reduction` is that without crease groups.
    pub(super) fn new(
        problem: &'a PlanningProblem<'a>,
        reduction: &'a Reduction<'a>,
        leg: &'a Leg,
    ) -> Self {
        let faces = problem.pattern.faces().len();
        Self {
            problem,
            left: FEWEST_FACES.max(FACES_PER_PAIR * faces * faces),
            judge: Judge::new(problem, reduction, problem.options.collision).of_plates(problem),
            leg,
            known: HashMap::new(),
        }
    }

    /// Returns these samples with a part of the effort.
    pub(super) fn with_part(mut self, part: f64) -> Self {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "an effort"
        )]
        let left = (part * self.left as f64) as usize;
        self.left = left;
        self
    }

    /// Returns `true` if no more samples are taken, as enough were, or time has run out.
    pub(super) fn is_spent(&self) -> bool {
        self.left == 0 || self.problem.is_late()
    }

    /// Returns the first crossing found while the creases of a phase turn, after those `before`.
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
        let found = self.first(&sets, &SAMPLES);
        let found = found.map(|found| self.bisected(&sets, found));
        self.known.insert(sets, found);
        found
    }

    /// Returns `true` if no crossing is found while the creases of a phase turn. Asks first near the end, where most of those
    /// that cross do.
    pub(super) fn is_free(&mut self, before: &FixedBitSet, phase: &FixedBitSet) -> bool {
        let sets = [before.clone(), phase.clone()];
        if let Some(known) = self.known.get(&sets) {
            return known.is_none();
        }
        let found = self.first(&sets, &SPREAD.map(|sample| SAMPLES[sample]));
        self.known.insert(sets, found);
        found.is_none()
    }

    /// Returns the number of faces that may yet be placed for samples.
    pub(super) fn left(&self) -> usize {
        self.left
    }

    /// Sets the number of faces that may yet be placed for samples.
    pub(super) fn allow(&mut self, faces: usize) {
        self.left = faces;
    }

    /// Returns the crossing that ends the free part of a phase, given the first sample that crosses.
    fn bisected(&mut self, sets: &[FixedBitSet; 2], mut found: SampledCrossing) -> SampledCrossing {
        let mut crossed = SAMPLES
            .into_iter()
            .find(|&part| part > found.free)
            .unwrap_or(1.0);
        for _ in 0..HALVINGS {
            let half = 0.5 * (found.free + crossed);
            match self.first(sets, &[half]) {
                Some(SampledCrossing { faces, .. }) => {
                    crossed = half;
                    found.faces = faces;
                }
                None => found.free = half,
            }
        }
        found
    }

    /// Returns the crossing at the first of some parts of a phase at which faces cross that it moves relative to each other,
    /// given the creases folded before and those that turn.
    fn first(
        &mut self,
        [before, phase]: &[FixedBitSet; 2],
        parts: &[f64],
    ) -> Option<SampledCrossing> {
        let pattern = self.problem.pattern;
        let faces = pattern.faces().len();
        let turns = |crease: CreaseId| phase[crease.index()];
        let steps = pattern.tree().steps().iter();
        let joined = steps.filter(|step| !step.crease.is_some_and(turns));
        let bodies = bodies(faces, joined.map(|step| [step.parent.0, step.face.0]));
        let mut at = self.leg.angles(before);
        let mut free = 0.0;
        for &part in parts {
            for crease in phase.ones() {
                at[crease] = self.leg.angle(crease, part);
            }
            self.left = self.left.saturating_sub(faces);
            let crossing = self.problem.stage(Stage::Crossings, || {
                self.judge.crossing_of_bodies(&at, &bodies)
            });
            if let Some(Crossing { faces, .. }) = crossing {
                return Some(SampledCrossing { free, faces });
            }
            free = part;
        }
        None
    }
}
