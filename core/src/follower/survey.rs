//! The survey of a sheet whose place is not known: the range of the measured angles of each group.

use crate::Scalar;
use crate::follower::Denial;

/// Smallest and largest measured angle of each group, radians.
///
/// A group stands in the middle of its range, which is the angle whose largest distance from a measured angle is the
/// smallest. If the range is wider than the measurements may err, the group has no one angle.
#[derive(Clone, Debug)]
pub(super) struct Survey<T, const GROUPS: usize> {
    ranges: [[T; 2]; GROUPS],
}

impl<T: Scalar, const GROUPS: usize> Survey<T, GROUPS> {
    // The range of a group that was not measured is empty.
    pub(super) fn new() -> Self {
        Self {
            ranges: [[T::MAX, -T::MAX]; GROUPS],
        }
    }

    /// Takes a measured angle of a group, radians. An angle that is no number makes the range as wide as can be.
    pub(super) fn measure(&mut self, group: usize, angle: T) {
        let Some([low, high]) = self.ranges.get_mut(group) else {
            return;
        };
        if angle.is_finite() {
            (*low, *high) = (low.min(angle), high.max(angle));
        } else {
            (*low, *high) = (-T::MAX, T::MAX);
        }
    }

    /// Returns the angles of the first `groups` groups.
    ///
    /// # Errors
    /// If a group was not measured, or if its range is wider than `spread`.
    pub(super) fn angles(&self, groups: usize, spread: T) -> Result<[T; GROUPS], Denial> {
        let mut angles = [T::zero(); GROUPS];
        let places = angles.iter_mut().zip(&self.ranges).take(groups);
        for (group, (angle, [low, high])) in (0..=u16::MAX).zip(places) {
            if low > high {
                return Err(Denial::Unknown(group));
            }
            if *high * T::HALF - *low * T::HALF > spread * T::HALF {
                return Err(Denial::Spread(group));
            }
            *angle = *low + (*high - *low) * T::HALF;
        }
        Ok(angles)
    }
}
