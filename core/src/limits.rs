//! What the hinges of a group are allowed.

use crate::Scalar;

/// What a group's hinges are allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupLimits<T = f32> {
    /// Smallest fold angle of the group, radians.
    pub lower: T,
    /// Largest fold angle of the group, radians.
    pub upper: T,
    /// Largest speed, radians per second; infinite for any.
    pub speed: T,
    /// Largest acceleration, radians per second squared; infinite for any.
    pub acceleration: T,
}

impl<T: Scalar> GroupLimits<T> {
    /// Whether the angles are finite and in order, and the others above 0.
    #[must_use]
    pub fn are_sound(&self) -> bool {
        let angles = self.lower.is_finite() && self.upper.is_finite() && self.lower <= self.upper;
        angles && self.speed > T::zero() && self.acceleration > T::zero()
    }

    /// Whether the angle (radians) is within them.
    #[must_use]
    pub fn allow(&self, angle: T) -> bool {
        (self.lower..=self.upper).contains(&angle)
    }
}
