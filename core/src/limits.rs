//! Limits of a crease group: the range of its fold angle, its speed and its acceleration.

use crate::Scalar;

/// Limits that every hinge of a group has to keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupLimits<T = f32> {
    /// Smallest fold angle of the group, radians.
    pub lower: T,
    /// Largest fold angle of the group, radians.
    pub upper: T,
    /// Largest speed, radians per second; infinite if there is no limit.
    pub speed: T,
    /// Largest acceleration, radians per second squared; infinite if there is no limit.
    pub acceleration: T,
}

impl<T: Scalar> GroupLimits<T> {
    /// Returns the limits of four numbers, in the order of the fields.
    pub(crate) fn from_numbers([lower, upper, speed, acceleration]: [T; 4]) -> Self {
        Self {
            lower,
            upper,
            speed,
            acceleration,
        }
    }

    /// Returns the numbers of [`from_numbers`](Self::from_numbers).
    pub(crate) fn numbers(self) -> [T; 4] {
        [self.lower, self.upper, self.speed, self.acceleration]
    }

    /// Returns `true` if the angles are finite and in order, and speed and acceleration are above 0.
    // Not inlined, so that an image has it once.
    #[inline(never)]
    #[must_use]
    pub fn are_sound(&self) -> bool {
        let angles = self.lower.is_finite() && self.upper.is_finite() && self.lower <= self.upper;
        angles && self.speed > T::zero() && self.acceleration > T::zero()
    }

    /// Returns `true` if `angle` (radians) is between `lower` and `upper`.
    #[must_use]
    pub fn allow(&self, angle: T) -> bool {
        (self.lower..=self.upper).contains(&angle)
    }
}
