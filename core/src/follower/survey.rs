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

    /// Forgets all measurements. Not inlined, so that an image has it once.
    #[inline(never)]
    pub(super) fn clear(&mut self) {
        *self = Self::new();
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

    /// Returns the angles of the first `groups` groups, each the middle of its range. Somebody may have said that they are
    /// `claimed`, which are then the angles of groups that were not measured.
    ///
    /// # Errors
    /// If a group was measured farther than `reach` from its claimed angle. Without claimed angles, if the range of a group is
    /// wider than `spread`, or if a group was not measured.
    #[inline(never)]
    pub(super) fn angles(
        &self,
        claimed: Option<&[T; GROUPS]>,
        groups: usize,
        [spread, reach]: [T; 2],
    ) -> Result<[T; GROUPS], Denial> {
        let mut angles = claimed.copied().unwrap_or([T::zero(); GROUPS]);
        let places = angles.iter_mut().zip(self.both()).take(groups);
        for (group, (angle, [low, high])) in (0..=u16::MAX).zip(places) {
            if low > high {
                if claimed.is_none() {
                    return Err(Denial::Unknown(group));
                }
                continue;
            }
            // Claimed angles that are no numbers are far from all others.
            if claimed.is_some() {
                let near = high - *angle <= reach && *angle - low <= reach;
                if !near {
                    return Err(Denial::Jump(group));
                }
            } else if high * T::HALF - low * T::HALF > spread * T::HALF {
                return Err(Denial::Spread(group));
            }
            *angle = low + (high - low) * T::HALF;
        }
        Ok(angles)
    }
}
