//! The hinges of a follower: their commanded and their measured angles.

use crate::follower::{Follower, State};
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
        hinges: impl Iterator<Item = Membership>,
        mut drive: impl FnMut(u32, Membership, Option<Target<T>>) -> Option<Measurement<T>>,
    ) {
        let surveys = self.state == State::Ready && !self.knows_position;
        let groups = if self.knows_position { self.groups } else { 0 };
        // The smaller number spares a comparison for each hinge, as does a count beside the loop.
        let groups = groups.min(GROUPS);
        let angles = self.angles.get(..groups).unwrap_or(&[]);
        let rates = self.rates.get(..groups).unwrap_or(&[]);
        let (lag, mut unremarkable) = (self.options.lag, self.lag.unremarkable(self.options.lag));
        let mut hinge = first;
        for membership in hinges {
            let group = membership.group.index();
            let target = angles.get(group).zip(rates.get(group));
            let target = target.map(|(angle, rate)| Target {
                angle: membership.apply(*angle),
                rate: membership.apply(*rate),
            });
            match (drive(hinge, membership, target), target) {
                (Some(Measurement { angle, age }), Some(target)) => {
                    let distance = (target.before(age) - angle).abs();
                    // False for a NaN.
                    let near = distance <= unremarkable;
                    if !near {
                        self.lag.note(hinge, distance, lag);
                        unremarkable = self.lag.unremarkable(lag);
                    }
                }
                (Some(Measurement { angle, age }), None) if surveys => {
                    let angle = membership.apply(angle);
                    let at = self.now.saturating_sub(age.into());
                    self.survey
                        .measure(group, angle, [at, self.now], self.options.fresh);
                }
                _ => {}
            }
            hinge = hinge.wrapping_add(1);
        }
    }
}
