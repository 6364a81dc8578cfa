//! The hinges of a follower: their commanded and their measured angles.

use crate::follower::{Follower, State};
use crate::{Membership, Scalar};

impl<T: Scalar, const GROUPS: usize, const KNOTS: usize> Follower<T, GROUPS, KNOTS> {
    /// Returns the commanded angle of a hinge, radians.
    #[must_use]
    pub fn hinge(&self, membership: Membership) -> Option<T> {
        let angle = self.angles().get(membership.group.index())?;
        Some(membership.apply(*angle))
    }

    /// Takes the measured angle of a hinge, radians. Hinges may be measured at any pace and in any order. A hinge that
    /// lags counts until it is measured again. While it is not known where the groups stand, the measured angles tell it.
    pub fn measure(&mut self, hinge: u32, membership: Membership, angle: T) {
        let mut member = Some(membership).into_iter();
        self.drive_from(hinge, &mut member, |_, _, _| Some(angle));
    }

    /// Calls `drive` for each of these hinges, numbered from 0, with its number, its group and sign, and its commanded
    /// angle (radians), or `None` while it is not known where the groups stand. [Measures](Self::measure) the angle that
    /// `drive` returns, radians, if there is one. Cost: a multiplication and a comparison for each hinge.
    pub fn drive(
        &mut self,
        hinges: impl Iterator<Item = Membership>,
        drive: impl FnMut(u32, Membership, Option<T>) -> Option<T>,
    ) {
        self.drive_from(0, hinges, drive);
    }

    fn drive_from(
        &mut self,
        first: u32,
        hinges: impl Iterator<Item = Membership>,
        mut drive: impl FnMut(u32, Membership, Option<T>) -> Option<T>,
    ) {
        let surveys = self.state == State::Ready && !self.stands;
        let groups = if self.stands { self.groups } else { 0 };
        // The smaller number spares a comparison for each hinge, as does a count beside the loop.
        let angles = self.angles.get(..groups.min(GROUPS)).unwrap_or(&[]);
        let (lag, mut unremarkable) = (self.options.lag, self.lag.unremarkable(self.options.lag));
        let mut hinge = first;
        for membership in hinges {
            let group = membership.group.index();
            let command = angles.get(group).map(|angle| membership.apply(*angle));
            match (drive(hinge, membership, command), command) {
                (Some(angle), Some(command)) => {
                    let distance = (command - angle).abs();
                    // False for a NaN.
                    let near = distance <= unremarkable;
                    if !near {
                        self.lag.note(hinge, distance, lag);
                        unremarkable = self.lag.unremarkable(lag);
                    }
                }
                (Some(angle), None) if surveys => {
                    let angle = membership.apply(angle);
                    self.survey
                        .measure(group, angle, self.now, self.options.fresh);
                }
                _ => {}
            }
            hinge = hinge.wrapping_add(1);
        }
    }
}
