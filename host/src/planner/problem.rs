//! The planning problem: sheet, goal and options, and how errors of rounded input are treated.

use core::time::Duration;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::plan::Times;
use super::{Goal, PlanOptions};
use crate::collision::Plates;
use crate::pattern::CreasePattern;
use crate::progress::{Stage, Watch};
use crate::symmetry::closure_of;
use crate::util::clock::Instant;

/// Treatment of the errors that rounded coordinates leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ErrorModel {
    /// Coordinates are exact. No vertex may fail to close by more than adds up to the bound in the worst case.
    Exact,
    /// Stars that nearly fold flat are taken to fold flat exactly.
    ///
    /// At a vertex where two straight lines cross, one line can turn while the other is flat, and once the first is
    /// folded flat, the other can turn. If a line bends by the least amount at the vertex, neither can.
    Snapped {
        /// `true` to allow for the largest rounding with which the goal closes, `false` for little more than the
        /// smallest.
        coarse: bool,
        /// `true` if errors are measured as in [`Measured`](Self::Measured).
        measured: bool,
    },
    /// Vertices may fail to close by more than adds up to the bound in the worst case: what they do add up to is
    /// measured.
    Measured,
}

impl ErrorModel {
    /// Returns `true` if stars that nearly fold flat are taken to fold flat exactly.
    pub(super) fn is_snapped(self) -> bool {
        matches!(self, Self::Snapped { .. })
    }

    /// Returns `true` if the errors of vertices are not bounded in the worst case beforehand, but their sum is
    /// measured.
    pub(super) fn is_measured(self) -> bool {
        matches!(self, Self::Measured | Self::Snapped { measured: true, .. })
    }
}

/// A sheet, the goal to which it is to fold, and the conditions.
#[derive(Clone, Copy)]
pub(super) struct PlanningProblem<'a> {
    pub(super) pattern: &'a Arc<CreasePattern>,
    pub(super) goal: &'a Goal,
    pub(super) options: &'a PlanOptions,
    pub(super) errors: ErrorModel,
    /// `true` if the closed configuration nearest to the goal will do, however far from the goal it is.
    pub(super) goes_near: bool,
    /// `true` if the straight way to the goal is the only one that is tried.
    pub(super) goes_straight: bool,
    /// `true` if a plan is kept only if it reaches its goal: the end of its motion is not looked at then.
    pub(super) is_trial: bool,
    /// Depth up to which an overlap of faces is contact, median edges.
    pub(super) contact: f64,
    /// Plates that phases have to be free of crossings for, as the motion of the thin sheet is not; `None` before that is known.
    pub(super) plates: Option<&'a Arc<Plates>>,
    pub(super) watch: Watch<'a>,
    pub(super) stage_times: &'a StageTimes,
}

/// Time that a call has spent in each stage so far. A stage within another one counts for itself alone.
#[derive(Default)]
pub(super) struct StageTimes(Mutex<Spent>);

#[derive(Default)]
struct Spent {
    times: Times,
    /// Time of the stages within the present one that are over.
    within: Duration,
}

impl StageTimes {
    /// Returns the time spent in stages that are over.
    pub(super) fn times(&self) -> Times {
        self.spent().times
    }

    fn spent(&self) -> MutexGuard<'_, Spent> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Spent {
    fn add(&mut self, stage: Stage, time: Duration) {
        let times = &mut self.times;
        *match stage {
            Stage::Symmetry => &mut times.symmetry,
            Stage::Placing => &mut times.place,
            Stage::Folding => &mut times.fold,
            Stage::Crossings => &mut times.collision,
            _ => &mut times.solve,
        } += time;
    }
}

impl PlanningProblem<'_> {
    /// Returns the same problem with another goal.
    pub(super) fn with_goal<'b>(&'b self, goal: &'b Goal) -> PlanningProblem<'b> {
        PlanningProblem { goal, ..*self }
    }

    /// Returns the goal angles of the creases of the pattern, or of one made of it, if each has one and the residuals there
    /// are at most `residual`.
    pub(super) fn closed_goal(&self, pattern: &CreasePattern, residual: f64) -> Option<Vec<f64>> {
        let goal = &self.goal.fold_angles;
        let angles = goal.iter().copied().collect::<Option<Vec<f64>>>()?;
        let is_whole = angles.len() == pattern.creases().len();
        (is_whole && closure_of(pattern, goal)? <= residual).then_some(angles)
    }

    /// Does the work of a stage: tells who watches that it begins, and adds the time that it takes.
    pub(super) fn stage<T>(&self, stage: Stage, work: impl FnOnce() -> T) -> T {
        self.watch.begin(stage);
        let before = core::mem::take(&mut self.stage_times.spent().within);
        let start = Instant::now();
        let done = work();
        let time = start.elapsed();
        let mut spent = self.stage_times.spent();
        let within = core::mem::replace(&mut spent.within, before + time);
        spent.add(stage, time.saturating_sub(within));
        done
    }

    /// Returns `true` once the call is over.
    pub(super) fn is_late(&self) -> bool {
        self.watch.is_over()
    }
}
