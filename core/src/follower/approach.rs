//! The approach: a slow motion from where the groups stand to where the path begins.

use crate::Scalar;

/// A straight way to the beginning of the path, in time of the path clock, so that all that slows or holds the path
/// slows or holds the approach as well. The angles on this way do not close; they are as far from closed as those at
/// which the groups stand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Approach<T, const GROUPS: usize> {
    /// Angles at which the groups stand less those at the beginning of the path, radians.
    offsets: [T; GROUPS],
    /// Seconds of the way, and seconds of it that are left.
    span: T,
    left: T,
}

impl<T: Scalar, const GROUPS: usize> Approach<T, GROUPS> {
    // Inlined for the reason given at `Follower::new`.
    #[inline(always)]
    pub(super) fn none() -> Self {
        Self {
            offsets: [T::zero(); GROUPS],
            span: T::zero(),
            left: T::zero(),
        }
    }

    /// Begins the way from the angles `stand` to `begin`, radians, at most as fast as `speeds` allow, radians a second.
    pub(super) fn begin(
        &mut self,
        stand: &[T; GROUPS],
        begin: &[T; GROUPS],
        groups: usize,
        speeds: impl Iterator<Item = T>,
    ) {
        *self = Self::none();
        let ends = stand.iter().zip(begin).take(groups);
        for ((offset, (stand, begin)), speed) in self.offsets.iter_mut().zip(ends).zip(speeds) {
            *offset = *stand - *begin;
            self.span = self.span.max(offset.abs() / speed);
        }
        self.left = self.span;
    }

    /// Returns the seconds that are left.
    pub(super) fn left(&self) -> T {
        self.left
    }

    /// Advances by `step` seconds, and returns the seconds that remain for the path behind the approach.
    pub(super) fn advance(&mut self, step: T) -> T {
        let taken = step.min(self.left);
        let left = self.left - taken;
        // Rounding leaves a little of the way, which counts as none.
        self.left = if left > T::EPSILON * self.span {
            left
        } else {
            T::zero()
        };
        step - taken
    }

    /// Adds the offsets that are left to the angles at the beginning of the path, radians.
    pub(super) fn offset(&self, angles: &mut [T; GROUPS]) {
        let part = self.left / self.span;
        for (angle, offset) in angles.iter_mut().zip(&self.offsets) {
            *angle += *offset * part;
        }
    }

    /// Returns the rates of the groups, radians a second; `clock` is the seconds of the path in a second.
    pub(super) fn rates(&self, clock: T) -> [T; GROUPS] {
        self.offsets.map(|offset| -(offset / self.span) * clock)
    }
}
