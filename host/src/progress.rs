//! How far work has come, for whoever looks on from another thread.

use core::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// What is done at the moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Reading files.
    Reading,
    /// Finding crease groups and essential vertices.
    Symmetry,
    /// Following the motion.
    Following,
    /// Placing knots on it, and certifying the motion between them.
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

    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

/// A stage, and the part of it that is done. Each news costs one relaxed store.
#[derive(Debug)]
pub struct Progress {
    stage: AtomicU32,
    /// How many of how many, the latter in the upper half; 0 of 0 where that is not known.
    done: AtomicU64,
}

impl Progress {
    /// Before anything is done.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            stage: AtomicU32::new(0),
            done: AtomicU64::new(0),
        }
    }

    /// A stage begins.
    pub fn begin(&self, stage: Stage) {
        self.done.store(0, Ordering::Relaxed);
        self.stage.store(stage as u32, Ordering::Relaxed);
    }

    /// So many of so many parts of the stage are done.
    pub fn done(&self, done: usize, of: usize) {
        let [done, of] =
            [done, of].map(|count| u64::from(u32::try_from(count).unwrap_or(u32::MAX)));
        self.done.store(done | of << 32, Ordering::Relaxed);
    }

    /// The part from 0 to 1 of the stage is done.
    pub fn part(&self, part: f64) {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 1000"
        )]
        let done = (1e3 * part.clamp(0.0, 1.0)) as usize;
        self.done(done, 1000);
    }

    /// What is done at the moment, and the part of it that is over, from 0 to 1, if that is known.
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

/// The same if it is the very same.
impl PartialEq for Progress {
    fn eq(&self, other: &Self) -> bool {
        core::ptr::eq(self, other)
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
