//! The answer of the planner, and what it is made of.

use core::ops::AddAssign;
use core::time::Duration;
use std::collections::HashMap;

use super::messages::percent;
use super::reason::{Note, Reason, Undecided};
use crate::collision::{Clearance, Crossing, SweepCounts};
use crate::folding::Rigidity;
use crate::motion::{self, Motion, PLANNED};
use crate::pattern::{CreaseId, FaceId};
use crate::util::clock::Instant;

/// Largest turn of a crease that rests in a step, radians.
const TURNED_RAD: f64 = 1e-6;

/// Answer of the planner.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Outcome {
    /// The path reaches the goal, within the bound and free of crossings.
    #[default]
    Planned,
    /// The path ends at a closed configuration that is farther from the goal than the tolerance, or leaves lettered
    /// creases flat.
    NearGoal,
    /// The path ends between flat and goal.
    Partial,
    /// The sheet deforms beyond the bound although its essential pattern does not, or is not proved to keep the bound.
    NotRigidlyFoldable,
    /// No closed configuration was found on the goal's side of the flat sheet.
    GoalNotClosed,
    /// Faces pass through each other.
    Crossing(Crossing),
    /// A path to the goal was found, but something that was asked could not be decided within its budget.
    Undecided,
    /// Out of time.
    Timeout,
}

impl Outcome {
    /// The answer to plates of which nothing is left where they hold a hinge, or that cannot turn as far as the motion does:
    /// their material is in the way.
    pub(crate) const MATERIAL_IN_THE_WAY: Self = Self::Crossing(Crossing {
        faces: [FaceId(0); 2],
        depth: 0.0,
    });

    /// The answers to paths that do not come to the goal, for want of a closed way or of a closed goal.
    pub(crate) const FALLS_SHORT: [Self; 3] = [Self::Partial, Self::NearGoal, Self::GoalNotClosed];

    /// Returns the name of the outcome in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Planned => PLANNED,
            Self::NearGoal => "near_goal",
            Self::Partial => "partial",
            Self::NotRigidlyFoldable => "not_rigidly_foldable",
            Self::GoalNotClosed => "goal_not_closed",
            Self::Crossing(_) => "crossing",
            Self::Undecided => "undecided",
            Self::Timeout => "timeout",
        }
    }
}

/// Time spent in each stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Times {
    /// Finding the spanning tree, crease groups and essential vertices, closing the goal under them, and the closure of
    /// the goal as asked.
    pub symmetry: Duration,
    /// Following paths in group angles, and everything that is not named here.
    pub solve: Duration,
    /// Placing knots on the path and certifying the motion between them.
    pub place: Duration,
    /// Folding the whole sheet at every knot and measuring it.
    pub fold: Duration,
    /// Looking for crossings.
    pub collision: Duration,
}

impl Times {
    /// Returns the sum with the times of another call.
    pub(super) fn plus(&self, other: &Self) -> Self {
        Self {
            symmetry: self.symmetry + other.symmetry,
            solve: self.solve + other.solve,
            place: self.place + other.place,
            fold: self.fold + other.fold,
            collision: self.collision + other.collision,
        }
    }
}

/// The reduced problem that the solver worked on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReducedProblem {
    /// Number of crease groups, which are the unknowns.
    pub groups: usize,
    /// Number of essential vertices.
    pub essential_vertices: usize,
    /// Number of closed configurations that the path was followed through, before knots were placed.
    pub waypoints: usize,
    /// Largest ratio of the errors of the whole sheet to the closure residuals of its vertices and holes; `None` if
    /// unknown.
    pub amplification: Option<f64>,
    /// Largest closure residual of a vertex with which the whole sheet keeps the bound.
    pub closure_tolerance: f64,
}

/// Largest errors over all knots.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SheetErrors {
    /// Deformation and gap of the whole sheet.
    pub rigidity: Rigidity,
    /// Closure residual of a real vertex or a hole, or twist of a hinge.
    pub closure: f64,
    /// Deformation and gap of the essential crease pattern.
    pub essential_rigidity: Rigidity,
    /// Number of faces of the essential crease pattern.
    pub essential_faces: usize,
}

/// Bounds on the whole sheet over the whole motion, rounding included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// Bound on the closure residual of every real vertex and hole; `None` if unknown.
    pub closure: Option<f64>,
    /// Bound on deformation and gap; infinite if unknown.
    ///
    /// If closure alone would allow more than the option's bound, this is the bound on the folded sheet by
    /// [`FoldingCertifier`](crate::certificate::FoldingCertifier).
    pub deformation: f64,
}

impl Certificate {
    /// Returns the certified deformation if it is over the bound.
    pub(super) fn over(&self, bound: f64) -> Option<f64> {
        let over = self.deformation > bound || self.deformation.is_nan();
        over.then_some(self.deformation)
    }
}

/// The goal, and how near to it the path ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Arrival {
    /// Largest closure residual of the goal as asked.
    pub goal_closure: f64,
    /// Largest difference of a fold angle at the end of the path from the goal as asked, radians.
    pub error: f64,
    /// Number of creases lettered M or V that the path leaves flat: turned less than a degree their way.
    pub flat_creases: usize,
}

/// Time and work that an answer took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Number of iterations of the solver.
    pub iterations: u64,
    /// Number of evaluations of the closure conditions by the solver.
    pub evaluations: u64,
    /// Time spent by the whole call, whatever it led to.
    pub times: Times,
    /// `true` if random numbers may have decided the answer.
    pub is_random: bool,
}

/// The search for crossings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CrossingSearch {
    /// Number of pairs that were looked at and skipped.
    pub counts: SweepCounts,
    /// Smallest distance of two faces that share no vertex, over the whole motion, if crossings were looked for and
    /// none was found.
    pub clearance: Option<Clearance>,
    /// Depth up to which an overlap of faces counted as contact, in median edges.
    pub contact_tolerance: f64,
}

/// A plan: the answer, the motion as far as it leads, and measurements.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// The answer.
    pub outcome: Outcome,
    /// Reason why the outcome is not `Planned`.
    pub reason: Option<Reason>,
    /// Fraction of the way to the goal that the sheet can go.
    pub reached: f64,
    /// The motion from flat, as far as one was found. Its title is empty.
    pub motion: Option<Motion>,
    /// Largest angle by which a panel bends along the path, radians; 0 for rigid panels.
    pub max_bend: f64,
    /// The reduced problem that the solver worked on.
    pub reduced: ReducedProblem,
    /// Largest errors over all knots.
    pub errors: SheetErrors,
    /// Bounds over the whole motion; `None` if nothing was to be certified.
    pub certificate: Option<Certificate>,
    /// The goal, and how near to it the path ends.
    pub arrival: Arrival,
    /// Time and work spent.
    pub effort: Effort,
    /// The search for crossings.
    pub crossings: CrossingSearch,
    /// Orders in which the creases of a sheet whose hinges turn freely may fold, as many as were asked for and found, that of
    /// the motion first. In any two of them, some creases fold in the opposite order.
    pub orders: Vec<FoldOrder>,
    /// Remarks for the user.
    pub notes: Vec<Note>,
    /// Questions left open; with any of them, the outcome is no longer [`Outcome::Planned`].
    pub undecided: Vec<Undecided>,
    /// Strategies that were tried, in this order.
    pub attempts: Vec<Attempt>,
    /// Thickness of the plates that the motion is proved for, units of the sheet; `None` for panels without a thickness.
    pub thickness: Option<f64>,
    /// Thickness up to which plates are proved to be free of crossings, and one at which they are not, units of the sheet, if
    /// it was asked for.
    pub max_thickness: Option<[f64; 2]>,
}

/// Steps in which creases turn one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct FoldOrder {
    /// The creases that turn in each step, with their fold angles at its end, radians.
    pub steps: Vec<Vec<(CreaseId, f64)>>,
}

impl FoldOrder {
    /// Returns the order in which the creases turn in the phases of a motion.
    #[must_use]
    pub fn of(motion: &Motion) -> Self {
        let last = motion.segments();
        let mut ends: Vec<usize> = motion.phases.iter().copied().chain([last]).collect();
        ends.dedup();
        let mut before = motion.crease_angles(0);
        let steps = ends.into_iter().map(|knot| {
            let angles = motion.crease_angles(knot);
            let turns = (0..).map(CreaseId).zip(before.iter().zip(&angles));
            let turns = turns.filter(|(_, (before, after))| (*after - *before).abs() > TURNED_RAD);
            let step = turns.map(|(crease, (_, &angle))| (crease, angle)).collect();
            before = angles;
            step
        });
        Self {
            steps: steps.filter(|step: &Vec<_>| !step.is_empty()).collect(),
        }
    }

    /// Returns `true` if one crease begins to turn before another here, and after it in another order.
    #[must_use]
    pub fn differs_from(&self, other: &Self) -> bool {
        let begun = |order: &Self| {
            let mut begun = HashMap::new();
            for (step, turns) in order.steps.iter().enumerate() {
                for (crease, _) in turns {
                    begun.entry(*crease).or_insert(step);
                }
            }
            begun
        };
        let (here, there) = (begun(self), begun(other));
        let both: Vec<[usize; 2]> = (here.iter())
            .filter_map(|(crease, &step)| Some([step, *there.get(crease)?]))
            .collect();
        let is_swapped = |a: &[usize; 2]| both.iter().any(|b| a[0] < b[0] && a[1] > b[1]);
        both.iter().any(is_swapped)
    }
}

/// Strategy of the planner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// The creases turn in groups, as far as the sheet and its goal are symmetric.
    CreaseGroups,
    /// Every crease is an unknown of its own.
    EveryCrease,
    /// Coordinates are moved by little more than the least with which the goal closes.
    SnappedFine,
    /// Coordinates are moved by the most with which the goal closes.
    SnappedCoarse,
    /// Vertices may fail to close by more than would add up to the bound in the worst case: their sum is measured.
    MeasuredError,
    /// Coordinates are moved by little, and the sum of what is left open is measured.
    SnappedMeasured,
    /// The sheet is taken to the goal straight, and deforms within the bound.
    StraightDeforming,
    /// Creases between faces that would cross fold before or after the others.
    SplitPhases,
    /// Parts of the sheet are folded one after the other.
    FoldSequence,
    /// The path leads by way of configurations in which faces that would cross are clear of each other.
    WayRound,
    /// The sheet is taken to the closed configuration nearest to the goal, however far from it.
    NearestConfiguration,
    /// The sheet is straightened, and planned like any other.
    Straightened,
    /// Crease groups or every crease, with other random numbers.
    OtherSeed,
    /// Driven creases turn alone, with the lines that they are on.
    DrivenAlone,
    /// Lines from border to border turn alone.
    LinesAlone,
    /// Panels bend about their diagonals.
    BendingPanels,
}

impl Strategy {
    /// Returns the name of the strategy, in words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::CreaseGroups => "crease groups",
            Self::EveryCrease => "every crease",
            Self::SnappedFine => "snapped coordinates (fine)",
            Self::SnappedCoarse => "snapped coordinates (coarse)",
            Self::MeasuredError => "measured error",
            Self::SnappedMeasured => "snapped coordinates, measured error",
            Self::StraightDeforming => "straight, deforming",
            Self::SplitPhases => "phases split at crossings",
            Self::FoldSequence => "folds in sequence",
            Self::WayRound => "a way round crossings",
            Self::NearestConfiguration => "nearest configuration",
            Self::Straightened => "straightened sheet",
            Self::OtherSeed => "another seed",
            Self::DrivenAlone => "driven creases alone",
            Self::LinesAlone => "lines alone",
            Self::BendingPanels => "panels that bend",
        }
    }
}

/// One strategy that was tried, and how it ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Attempt {
    /// The strategy.
    pub strategy: Strategy,
    /// Its answer.
    pub outcome: Outcome,
    /// Reason why the outcome is not `Planned`.
    pub reason: Option<Reason>,
    /// Fraction of the way to the goal that its path leads, 0 to 1.
    pub reached: f64,
    /// Seconds that it took.
    pub seconds: f64,
}

impl Attempt {
    /// Makes the attempt that ended with a plan. It began at `start`.
    pub(super) fn new(strategy: Strategy, plan: &Plan, start: Instant) -> Self {
        Self {
            strategy,
            outcome: plan.outcome,
            reason: plan.reason.clone(),
            reached: plan.reached,
            seconds: start.elapsed().as_secs_f64(),
        }
    }
}

impl Plan {
    /// Returns the knots of the motion; none if no motion was found.
    #[must_use]
    pub fn knots(&self) -> &[motion::Knot] {
        self.motion.as_ref().map_or(&[], |motion| &motion.knots)
    }

    /// Returns `true` if it is proved that the faces cannot be stacked at the goal.
    pub(super) fn has_no_layer_order(&self) -> bool {
        let mut notes = self.notes.iter();
        notes.any(|note| matches!(note, Note::NoLayerOrder(_)))
    }

    /// Returns the bound on deformation and gap of the whole sheet over the whole motion, infinite if nothing is known;
    /// `None` if nothing was to be certified.
    #[must_use]
    pub fn certified_deformation(&self) -> Option<f64> {
        self.certificate.map(|certificate| certificate.deformation)
    }

    /// Returns the bound on the closure residual of every real vertex and hole over the whole motion; `None` if unknown.
    #[must_use]
    pub fn certified_closure(&self) -> Option<f64> {
        self.certificate?.closure
    }

    /// Returns the part of the way to the goal that the sheet can go as a percentage for people, rounded to below 100 if the
    /// path ends before its goal.
    #[must_use]
    pub fn percent(&self) -> f64 {
        let is_end = matches!(self.outcome, Outcome::Planned | Outcome::Undecided);
        percent(self.reached, is_end)
    }

    /// Returns `true` if it is known that plates are in the way of a motion that the sheet has without a thickness.
    pub(super) fn knows_plates(&self) -> bool {
        let reason = self.reason.as_ref();
        reason.is_some_and(|it| matches!(it, Reason::PlatesCross { .. } | Reason::PlatesNotMade(_)))
    }

    /// Returns the number of phases of the motion that are at their end; the last knot counts, too, if a phase ends there.
    pub(super) fn ended_phases(&self) -> usize {
        self.motion.as_ref().map_or(0, |motion| motion.phases.len())
    }

    /// Returns the deformation that the sheet is proved to keep, infinite for none; `None` if nothing was to be proved.
    pub(super) fn proved(&self) -> Option<f64> {
        self.certified_closure()?;
        let certified = self.certified_deformation();
        Some(certified.filter(|c| !c.is_nan()).unwrap_or(f64::INFINITY))
    }
}

impl AddAssign for Effort {
    /// Adds the effort of an answer that is not kept; its random numbers have not decided.
    fn add_assign(&mut self, other: Self) {
        self.iterations += other.iterations;
        self.evaluations += other.evaluations;
    }
}
