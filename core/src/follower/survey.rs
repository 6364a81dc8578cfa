//! The survey of a sheet whose place is not known: the range of the measured angles of each group.

use crate::Scalar;
use crate::follower::Denial;

/// Smallest and largest measured angle of each group since the survey began, radians.
///
/// A group stands in the middle of its range, which is the angle whose largest distance from a measured angle is the
/// smallest. If the range is wider than the measurements may err, the group has no one angle. A survey begins anew when
/// it is too old, because a sheet without commands may be moved by hand.
#[derive(Clone, Debug)]
pub(super) struct Survey<T, const GROUPS: usize> {
    ranges: [[T; 2]; GROUPS],
    /// Time of the first measurement, microseconds; `None` if there is none.
    begun: Option<u64>,
}

impl<T: Scalar, const GROUPS: usize> Survey<T, GROUPS> {
    // The range of a group that was not measured is empty.
    pub(super) fn new() -> Self {
        Self {
            ranges: [[T::MAX, -T::MAX]; GROUPS],
            begun: None,
        }
    }

    /// Takes the angle of a group that was measured at `now`, radians, and forgets all measurements if the first is older
    /// than `fresh` microseconds. An angle that is no number makes the range as wide as can be.
    pub(super) fn measure(&mut self, group: usize, angle: T, now: u64, fresh: u32) {
        self.age(now, fresh);
        self.begun.get_or_insert(now);
        let Some([low, high]) = self.ranges.get_mut(group) else {
            return;
        };
        if angle.is_finite() {
            (*low, *high) = (low.min(angle), high.max(angle));
        } else {
            (*low, *high) = (-T::MAX, T::MAX);
        }
    }

    /// Forgets all measurements if the first is older than `fresh` microseconds.
    pub(super) fn age(&mut self, now: u64, fresh: u32) {
        let old = |begun: u64| now.saturating_sub(begun) > fresh.into();
        if self.begun.is_some_and(old) {
            *self = Self::new();
        }
    }

    /// Returns the angles of the first `groups` groups, each the middle of its range.
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

    /// Returns the angles of the first `groups` groups, of which somebody has said that they are `told`: the middle of
    /// the range of those that were measured, and what was told of all others.
    ///
    /// # Errors
    /// If a group was measured farther than `reach` from what was told.
    pub(super) fn near(
        &self,
        mut told: [T; GROUPS],
        groups: usize,
        reach: T,
    ) -> Result<[T; GROUPS], Denial> {
        let places = told.iter_mut().zip(&self.ranges).take(groups);
        for (group, (angle, [low, high])) in (0..=u16::MAX).zip(places) {
            if low > high {
                continue;
            }
            // A told angle that is no number is far from every other.
            let near = *high - *angle <= reach && *angle - *low <= reach;
            if !near {
                return Err(Denial::Jump(group));
            }
            *angle = *low + (*high - *low) * T::HALF;
        }
        Ok(told)
    }
}
