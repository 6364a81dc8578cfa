//! Progress of a long call as another thread sees it, and a way to cancel the call.
//!
//! The caller lends a [`Progress`] to [`plan_watched`](crate::planner::plan_watched),
//! [`check_watched`](crate::check::check_watched) and the like, and reads it, or cancels the call, from another thread:
//!
//! ```
//! use foldpath::generate::Miura;
//! use foldpath::pattern::CreasePattern;
//! use foldpath::planner::{Goal, Outcome, PlanOptions, plan_watched};
//! use foldpath::progress::Progress;
//!
//! let miura = Miura { rows: 3, columns: 3, sector_angle: 60_f64.to_radians(), fold: 0.9 };
//! let pattern = CreasePattern::new(miura.drawing()?)?;
//! let progress = Progress::new();
//! std::thread::scope(|scope| {
//!     scope.spawn(|| progress.cancel());
//! });
//! let plan = plan_watched(&pattern, &Goal::of_pattern(&pattern)?, &PlanOptions::default(), &progress);
//! assert_eq!(plan.outcome, Outcome::Timeout);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use core::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

use crate::util::clock::Instant;

/// Stage of a long call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Reading files.
    Reading,
    /// Finding crease groups and essential vertices.
    Symmetry,
    /// Following the motion.
    Following,
    /// Placing knots on the motion, and certifying it between them.
    Placing,
    /// Folding and measuring the whole sheet.
    Folding,
    /// Bounding closure.
    Closure,
    /// Looking for crossings.
    Crossings,
    /// Writing files.
    Writing,
}

impl Stage {
    const ALL: [(Self, &'static str); 8] = [
        (Self::Reading, "reading"),
        (Self::Symmetry, "finding crease groups"),
        (Self::Following, "following the motion"),
        (Self::Placing, "placing knots"),
        (Self::Folding, "folding the sheet"),
        (Self::Closure, "bounding closure"),
        (Self::Crossings, "looking for crossings"),
        (Self::Writing, "writing"),
    ];

    /// Returns the name of the stage, in words.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

/// Stage of a long call, the fraction of the stage that is done, and the request to cancel the call. A change costs one
/// or two relaxed stores.
#[derive(Debug)]
pub struct Progress {
    cancelled: AtomicBool,
    stage: AtomicU32,
    /// Number of parts of the stage that are done, and in the upper half the number of all its parts; 0 of 0 if
    /// unknown.
    done: AtomicU64,
    /// Called on the thread of the call at each change.
    listener: Option<fn(&Self)>,
}

impl Progress {
    /// Makes the progress of a call that has not begun.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            cancelled: AtomicBool::new(false),
            stage: AtomicU32::new(0),
            done: AtomicU64::new(0),
            listener: None,
        }
    }

    /// Makes the progress of a call that has not begun, with a function that is called at each change, on a thread of the
    /// call: for programs of one thread. The function should return soon.
    #[must_use]
    pub const fn told_to(listener: fn(&Self)) -> Self {
        Self {
            listener: Some(listener),
            ..Self::new()
        }
    }

    fn tell(&self) {
        if let Some(listener) = self.listener {
            listener(self);
        }
    }

    /// Asks the call to end soon. The call then answers as if its time were up.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Returns `true` once the call has been asked to end.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Notes that a stage begins.
    pub fn begin(&self, stage: Stage) {
        self.done.store(0, Ordering::Relaxed);
        self.stage.store(stage as u32, Ordering::Relaxed);
        self.tell();
    }

    /// Notes that `done` of `of` parts of the stage are done.
    pub fn done(&self, done: usize, of: usize) {
        let [done, of] =
            [done, of].map(|count| u64::from(u32::try_from(count).unwrap_or(u32::MAX)));
        self.done.store(done | of << 32, Ordering::Relaxed);
        self.tell();
    }

    /// Notes that a fraction of the stage, from 0 to 1, is done.
    pub fn part(&self, part: f64) {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 1000"
        )]
        let done = (1e3 * part.clamp(0.0, 1.0)) as usize;
        self.done(done, 1000);
    }

    /// Returns the present stage and the fraction of it that is done, from 0 to 1, if that is known.
    #[must_use]
    pub fn now(&self) -> (Stage, Option<f64>) {
        let stage = self.stage.load(Ordering::Relaxed) as usize;
        let stage = Stage::ALL
            .get(stage)
            .map_or(Stage::Reading, |(stage, _)| *stage);
        let done = self.done.load(Ordering::Relaxed);
        #[allow(clippy::cast_precision_loss, reason = "counts below 2³²")]
        let [done, of] = [done & u64::from(u32::MAX), done >> 32].map(|count| count as f64);
        (stage, (of > 0.0).then(|| (done / of).min(1.0)))
    }
}

impl Default for Progress {
    fn default() -> Self {
        Self::new()
    }
}

/// Progress that a long call reports, if a caller watches it, and the deadline of the call, if there is one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watch<'a> {
    progress: Option<&'a Progress>,
    deadline: Option<Instant>,
}

impl<'a> Watch<'a> {
    /// Makes a watch that reports to `progress`, and ends the call when that is cancelled.
    #[must_use]
    pub fn new(progress: &'a Progress) -> Self {
        Self {
            progress: Some(progress),
            deadline: None,
        }
    }

    /// Ends the call at `deadline` too.
    #[must_use]
    pub fn until(self, deadline: Option<Instant>) -> Self {
        Self { deadline, ..self }
    }

    /// Returns `true` once the call is cancelled or its deadline has passed.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.progress.is_some_and(Progress::is_cancelled)
            || self
                .deadline
                .is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Reports that a stage begins.
    pub(crate) fn begin(&self, stage: Stage) {
        if let Some(progress) = self.progress {
            progress.begin(stage);
        }
    }

    /// Reports that `done` of `of` parts of the stage are done.
    pub(crate) fn done(&self, done: usize, of: usize) {
        if let Some(progress) = self.progress {
            progress.done(done, of);
        }
    }

    /// Reports that a fraction of the stage, from 0 to 1, is done.
    pub(crate) fn part(&self, part: f64) {
        if let Some(progress) = self.progress {
            progress.part(part);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_is_seen() {
        let progress = Progress::new();
        assert_eq!(progress.now(), (Stage::Reading, None));
        for (index, (stage, name)) in Stage::ALL.into_iter().enumerate() {
            progress.begin(stage);
            assert_eq!((stage as usize, stage.name()), (index, name));
            assert_eq!(progress.now(), (stage, None));
            progress.done(3, 4);
            assert_eq!(progress.now(), (stage, Some(0.75)));
        }
        progress.part(0.25);
        assert_eq!(progress.now().1, Some(0.25));
        for wild in [f64::NAN, -1.0] {
            progress.part(wild);
            assert_eq!(progress.now().1, Some(0.0));
        }
        progress.done(usize::MAX, 7);
        assert_eq!(progress.now().1, Some(1.0));
    }
}
