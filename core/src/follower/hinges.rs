//! The hinges of a follower: their commanded and their measured angles.

use crate::follower::{Follower, Stance, State};
use crate::{Membership, Scalar};

/// Command of a hinge at a moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Target<T> {
    /// Angle where it is to be now, radians.
    pub angle: T,
    /// Rate at which this angle changes, radians per second; 0 at rest.
    pub rate: T,
}

/// A hinge that is driven.
pub trait Hinge {
    /// Returns its group and sign.
    fn membership(&self) -> Membership;

    /// Notes that it was measured.
    fn heard(&self) {}
}

impl Hinge for Membership {
    #[inline]
    fn membership(&self) -> Membership {
        *self
    }
}

/// Measured angle of a hinge.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Measurement<T> {
    /// Angle, radians. NaN, or what is no angle, tells of a sensor that has failed, and holds the motion.
    pub angle: T,
    /// Time since the hinge was at this angle, microseconds.
    pub age: u32,
}

impl<T: Scalar> Target<T> {
    /// Returns the angle that was commanded `age` microseconds ago, radians, if the rate was the same since then.
    fn before(self, age: u32) -> T {
        if age == 0 {
            self.angle
        } else {
            self.angle - self.rate * T::whole(age) * T::lit(1e-6)
        }
    }
}

impl<T> From<T> for Measurement<T> {
    /// Returns the measurement of an angle at this moment.
    fn from(angle: T) -> Self {
        Self { angle, age: 0 }
    }
}

impl<T: Scalar, const GROUPS: usize, const KNOTS: usize> Follower<T, GROUPS, KNOTS> {
    /// Returns the commanded angle of a hinge, radians.
    #[must_use]
    pub fn hinge(&self, membership: Membership) -> Option<T> {
        let angle = self.angles().get(membership.group.index())?;
        Some(membership.apply(*angle))
    }

    /// Calls `drive` for each of these hinges, numbered from `first` on, with its number, its group and sign, and its
    /// target, or `None` while it is not known where the groups stand. Takes what `drive` returns, if there is something, as
    /// the measured angle of the hinge. Cost: a multiplication and a comparison for each hinge, and another multiplication if
    /// `drive` uses the rate.
    ///
    /// Hinges may be measured at any pace and in any order. A hinge that lags counts until it is measured again. While it is
    /// not known where the groups stand, the measured angles tell it.
    pub fn drive_from(
        &mut self,
        first: u32,
        hinges: impl Iterator<Item = impl Hinge>,
        mut drive: impl FnMut(u32, Membership, Option<Target<T>>) -> Option<Measurement<T>>,
    ) {
        if self.is_known() {
            self.drive_known(first, hinges, drive);
        } else {
            self.drive_none(first, hinges, &mut drive);
        }
    }

    /// Does what [`drive_from`](Self::drive_from) does while it is known where the groups stand, for a controller that asks
    /// before. While it is not known, the hinges are not surveyed.
    pub fn drive_known(
        &mut self,
        first: u32,
        hinges: impl Iterator<Item = impl Hinge>,
        mut drive: impl FnMut(u32, Membership, Option<Target<T>>) -> Option<Measurement<T>>,
    ) {
        let mut unremarkable = self.lag.unremarkable();
        // The smaller number spares a comparison for each hinge, as does a count beside the loop.
        let groups = self.groups.min(GROUPS);
        let angles = self.angles.get(..groups).unwrap_or(&[]);
        let rates = self.rates.get(..groups).unwrap_or(&[]);
        let mut hinge = first;
        for driven in hinges {
            let membership = driven.membership();
            let group = membership.group.index();
            let target = angles.get(group).zip(rates.get(group));
            let target = target.map(|(angle, rate)| Target {
                angle: membership.apply(*angle),
                rate: membership.apply(*rate),
            });
            let measured = drive(hinge, membership, target);
            if measured.is_some() {
                driven.heard();
            }
            if let Some((Measurement { angle, age }, target)) = measured.zip(target) {
                let distance = (target.before(age) - angle).abs();
                // False for a NaN.
                let near = distance <= unremarkable;
                if !near {
                    unremarkable = self.lag.note(hinge, distance);
                }
            }
            hinge = hinge.wrapping_add(1);
        }
    }

    /// Tells that the sensor of a hinge has fallen silent. Until the hinge is measured again, it counts as one whose sensor
    /// tells no angle.
    pub fn lose_sensor(&mut self, hinge: u32) {
        if self.is_known() {
            self.lag.note(hinge, T::MAX);
        }
    }

    /// Commands nothing. Compares what is measured with the angles that were kept, and surveys the groups of a path that is
    /// ready. Not inlined, so that other ticks do not pay for it.
    #[inline(never)]
    fn drive_none(
        &mut self,
        first: u32,
        hinges: impl Iterator<Item = impl Hinge>,
        drive: &mut impl FnMut(u32, Membership, Option<Target<T>>) -> Option<Measurement<T>>,
    ) {
        let checks = matches!(self.stance, Stance::Kept | Stance::Agreed);
        for (hinge, driven) in (first..).zip(hinges) {
            let membership = driven.membership();
            let Some(Measurement { angle, age }) = drive(hinge, membership, None) else {
                continue;
            };
            driven.heard();
            let (group, angle) = (membership.group.index(), membership.apply(angle));
            if let Some(kept) = self.angles.get(group).filter(|_| checks) {
                let distance = (*kept - angle).abs();
                self.lag.note(hinge, distance);
                if distance <= self.lag.slows {
                    self.stance = Stance::Agreed;
                }
            }
            if self.state == State::Ready {
                let times = [self.now.saturating_sub(age.into()), self.now];
                self.survey.measure(group, angle, times, self.options.fresh);
            }
        }
    }
}
