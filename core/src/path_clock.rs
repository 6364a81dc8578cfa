//! The clock of a path: how fast the time of the path passes in the time of the world.
//!
//! All hinges share one path parameter, so that slowing its clock leaves the sheet on the motion that was
//! planned and certified, while braking each hinge on its own would tear it. The clock's rate is between 0
//! and 1 and changes by no more than its limits allow.
//!
//! At the rate ṙ the way to a stop is ṙ²/2b with the braking b. So the rate never exceeds √(2 b · what is left),
//! and the clock comes to rest exactly at the end of what is known of the path. With the trapezoidal rule a
//! tick from ṙ to ṙ − b·dt keeps that parabola without error, so no margin is needed.

use crate::Scalar;

/// How fast the rate of a [`PathClock`] may change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockLimits<T> {
    /// Growth of the rate in a second.
    pub rise: T,
    /// Loss of the rate in a second.
    pub brake: T,
}

impl<T: Scalar> ClockLimits<T> {
    /// Whether both are finite and above 0.
    #[must_use]
    pub fn are_sound(&self) -> bool {
        [self.rise, self.brake]
            .iter()
            .all(|limit| limit.is_finite() && *limit > T::zero())
    }
}

/// The rate of path time, at first 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathClock<T> {
    limits: ClockLimits<T>,
    rate: T,
}

impl<T: Scalar> PathClock<T> {
    /// A clock at rest. Limits that are not [sound](ClockLimits::are_sound) never let it start.
    #[must_use]
    pub fn new(limits: ClockLimits<T>) -> Self {
        Self {
            limits,
            rate: T::zero(),
        }
    }

    /// Seconds of the path in a second of the world, from 0 to 1.
    #[must_use]
    pub fn rate(&self) -> T {
        self.rate
    }

    /// Stops the clock at once, whatever its limits.
    pub fn halt(&mut self) {
        self.rate = T::zero();
    }

    /// Lets `dt` seconds of the world pass and returns how many of the path pass in them: never more than
    /// `left`. The rate moves towards `goal` as its limits and what is then left allow.
    ///
    /// Cost: a square root and a division.
    #[must_use]
    pub fn tick(&mut self, dt: T, goal: T, left: T) -> T {
        let positive = |value: T| value.max(T::zero());
        let (dt, left) = (positive(dt), positive(left));
        let goal = positive(goal).min(T::one());
        let (before, ClockLimits { rise, brake }) = (self.rate, self.limits);
        if !self.limits.are_sound() {
            return T::zero();
        }
        let slewed = goal.max(before - brake * dt).min(before + rise * dt);
        // Of the rates r with r²/2b no more than what is left after (before + r)/2 · dt, the largest.
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
