//! The survey of a sheet whose place is not known: the range of the measured angles of each group.

use crate::Scalar;
use crate::follower::Denial;

/// Smallest and largest measured angle of each group, radians: since the survey began, and in the time before.
///
/// A group stands in the middle of its range, which is the angle whose largest distance from a measured angle is the
/// smallest. If the range is wider than the measurements may err, the group has no one angle. Old measurements are
/// forgotten, because a sheet without commands may be moved by hand; the newer half stays, so that a board may take its
/// time to measure all hinges.
#[derive(Clone, Debug)]
pub(super) struct Survey<T, const GROUPS: usize> {
    ranges: [Ranges<T, GROUPS>; 2],
    /// Time of the first measurement of the newer ranges, microseconds; `None` if nothing was measured.
    started_at: Option<u64>,
}

type Ranges<T, const GROUPS: usize> = [[T; 2]; GROUPS];

impl<T: Scalar, const GROUPS: usize> Survey<T, GROUPS> {
    // The range of a group that was not measured is empty.
    // Inlined for the reason given at `Follower::new`.
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self {
            ranges: [[[T::MAX, -T::MAX]; GROUPS]; 2],
            started_at: None,
        }
    }

    /// Takes the angle of a group that was measured at `at`, radians, and has come `now`. An angle that is no number makes
    /// the range as wide as can be. One that is too old is no measurement. For `fresh`, see [`age`](Self::age).
    #[inline(never)]
    pub(super) fn measure(&mut self, group: usize, angle: T, [at, now]: [u64; 2], fresh: u32) {
        self.age(now, fresh);
        if now.saturating_sub(at) > u64::from(fresh) {
            return;
        }
        let started_at = self.started_at.get_or_insert(at);
        *started_at = at.min(*started_at);
        let [newer, _] = &mut self.ranges;
        let Some([low, high]) = newer.get_mut(group) else {
            return;
        };
        if angle.is_finite() {
            (*low, *high) = (low.min(angle), high.max(angle));
        } else {
            (*low, *high) = (-T::MAX, T::MAX);
        }
    }

    /// Forgets measurements that are older than `fresh` microseconds, and none that is younger than half of it.
    #[inline(never)]
    pub(super) fn age(&mut self, now: u64, fresh: u32) {
        let age = self
            .started_at
            .map_or(0, |started_at| now.saturating_sub(started_at));
        let fresh = u64::from(fresh);
        if age <= fresh / 2 {
            return;
        }
        let [newer, older] = &mut self.ranges;
        for (older, newer) in older.iter_mut().zip(newer) {
            let empty = [T::MAX, -T::MAX];
            let range = core::mem::replace(newer, empty);
            *older = if age <= fresh { range } else { empty };
        }
        self.started_at = None;
    }

    /// Returns the range of each group over both times.
    fn both(&self) -> impl Iterator<Item = [T; 2]> {
        let [newer, older] = &self.ranges;
        let pairs = newer.iter().zip(older);
        pairs.map(|([low, high], [lower, higher])| [low.min(*lower), high.max(*higher)])
    }

    /// Returns the angles of the first `groups` groups, each the middle of its range.
    ///
    /// # Errors
    /// If a group was not measured, or if its range is wider than `spread`.
    pub(super) fn angles(&self, groups: usize, spread: T) -> Result<[T; GROUPS], Denial> {
        let mut angles = [T::zero(); GROUPS];
        let places = angles.iter_mut().zip(self.both()).take(groups);
        for (group, (angle, [low, high])) in (0..=u16::MAX).zip(places) {
            if low > high {
                return Err(Denial::Unknown(group));
            }
            if high * T::HALF - low * T::HALF > spread * T::HALF {
                return Err(Denial::Spread(group));
            }
            *angle = low + (high - low) * T::HALF;
        }
        Ok(angles)
    }

    /// Returns the angles of the first `groups` groups, of which somebody has said that they are `claimed`: the middle of
    /// the range of those that were measured, and the claimed angles of all others.
    ///
    /// # Errors
    /// If a group was measured farther than `reach` from its claimed angle.
    #[inline(never)]
    pub(super) fn near(
        &self,
        mut claimed: [T; GROUPS],
        groups: usize,
        reach: T,
    ) -> Result<[T; GROUPS], Denial> {
        let places = claimed.iter_mut().zip(self.both()).take(groups);
        for (group, (angle, [low, high])) in (0..=u16::MAX).zip(places) {
            if low > high {
                continue;
            }
            // A claimed angle that is no number is far from every other.
            let near = high - *angle <= reach && *angle - low <= reach;
            if !near {
                return Err(Denial::Jump(group));
            }
            *angle = low + (high - low) * T::HALF;
        }
        Ok(claimed)
    }
}
