//! The watch over hinges that lag behind their commands.

use crate::Scalar;

/// The hinge that was measured farthest from its command, radians; the default if no hinge was off its command.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lag<T> {
    pub(super) hinge: u32,
    pub(super) distance: T,
}

/// The farthest hinge of the round of measurements that is under way, and that of the round before until it is measured
/// again. Both count, so that a sensor that fails now and then hides no hinge that is stuck.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LagWatch<T> {
    round: Lag<T>,
    before: Lag<T>,
    /// One more than the hinge that was measured last; a round ends when the numbers of the hinges no longer rise.
    next: u32,
    /// Time for which a hinge was stuck, less the time for which none was, microseconds.
    stuck: u64,
}

impl<T: Scalar> LagWatch<T> {
    /// Returns the farthest hinge.
    pub(super) fn farthest(&self) -> Lag<T> {
        // Hinges below `next` were measured again in this round.
        if self.before.hinge >= self.next && self.before.distance > self.round.distance {
            self.before
        } else {
            self.round
        }
    }

    /// Begins a round of measurements.
    pub(super) fn begin(&mut self) {
        self.before = core::mem::take(&mut self.round);
        self.next = 0;
    }

    /// Notes the distance of a hinge from its command, radians. A distance that is no number counts as the largest.
    /// Begins a round if the number of the hinge is not larger than the one before.
    pub(super) fn note(&mut self, hinge: u32, distance: T) {
        if hinge < self.next {
            self.begin();
        }
        self.next = hinge.saturating_add(1);
        self.note_next(hinge, distance);
    }

    /// Notes a distance in a round that was begun, of which [`end`](Self::end) follows.
    #[inline]
    pub(super) fn note_next(&mut self, hinge: u32, distance: T) {
        // False for a NaN.
        let near = distance <= self.round.distance;
        if !near {
            let distance = if distance.is_finite() {
                distance
            } else {
                T::MAX
            };
            self.round = Lag { hinge, distance };
        }
    }

    /// Ends a round in which all hinges were measured.
    pub(super) fn end(&mut self) {
        self.next = u32::MAX;
    }

    /// Lets `passed` microseconds pass, in which a hinge was stuck or not; returns the time for which it was stuck, less
    /// the time for which it was not.
    pub(super) fn pass(&mut self, stuck: bool, passed: u32) -> u64 {
        let passed = u64::from(passed);
        self.stuck = if stuck {
            self.stuck.saturating_add(passed)
        } else {
            self.stuck.saturating_sub(passed)
        };
        self.stuck
    }

    /// Forgets for how long a hinge was stuck.
    pub(super) fn restart(&mut self) {
        self.stuck = 0;
    }
}
