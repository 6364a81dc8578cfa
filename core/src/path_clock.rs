//! The clock of a path: how many seconds of the path pass in a second of the world?
//!
//! All hinges share one path parameter. Slowing its clock leaves the sheet on the motion that was planned and
//! certified, whereas braking each hinge on its own would tear the sheet. The clock's rate is between 0 and 1 and
//! changes by no more than its limits allow.
//!
//! At the rate ṙ the braking distance is ṙ²/2b with the braking b. The rate therefore never exceeds √(2 b · path time
//! left), and the clock comes to rest exactly at the end of the known path. With the trapezoidal rule a tick from ṙ to
//! ṙ − b·dt keeps that parabola without error, so that no margin is needed.

use crate::Scalar;

/// Limits on the change of the rate of a [`PathClock`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockLimits<T> {
    /// Largest growth of the rate in a second.
    pub rise: T,
    /// Largest loss of the rate in a second.
    pub brake: T,
}

/// The rate of path time, 0 at first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathClock<T> {
    rate: T,
}

impl<T: Scalar> PathClock<T> {
    /// Returns the rate, seconds of the path in a second of the world, from 0 to 1.
    #[must_use]
    pub fn rate(&self) -> T {
        self.rate
    }

    /// Stops the clock at once, whatever its limits.
    pub fn halt(&mut self) {
        self.rate = T::zero();
    }

    /// Lets `dt` seconds of the world pass and returns the seconds of the path that pass meanwhile, at most `left`.
    ///
    /// The rate moves towards `goal` as far as the `limits`, and the path time then left, allow. The limits have to be
    /// finite and above 0, as those of [checked options](crate::follower::CheckedOptions) are. Cost: a square root and a
    /// division.
    #[must_use]
    pub fn tick(&mut self, limits: ClockLimits<T>, dt: T, goal: T, left: T) -> T {
        let positive = |value: T| value.max(T::zero());
        let (dt, left) = (positive(dt), positive(left));
        let goal = positive(goal).min(T::one());
        let (before, ClockLimits { rise, brake }) = (self.rate, limits);
        let slewed = goal.max(before - brake * dt).min(before + rise * dt);
        // The largest rate r whose braking distance r²/2b is at most the path time left after (before + r)/2 · dt.
        let half = brake * dt * T::HALF;
        let room = T::TWO * (brake * left - half * before);
        let largest = if room > T::zero() {
            room / ((half * half + room).sqrt() + half)
        } else {
            T::zero()
        };
        self.rate = slewed.min(largest);
        ((before + self.rate) * T::HALF * dt).min(left)
    }
}
