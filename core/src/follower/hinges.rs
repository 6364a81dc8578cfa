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

    /// Takes the measured angle of a hinge, radians. Hinges may be measured at any pace, in the order of their numbers
    /// and then from the first one again. The farthest from its command in this round or the last counts. While it is
    /// not known where the groups stand, the measured angles tell it.
    pub fn measure(&mut self, hinge: u32, membership: Membership, angle: T) {
        if let Some(commanded) = self.hinge(membership) {
            self.lag.note(hinge, (commanded - angle).abs());
        } else if self.state == State::Ready && !self.stands {
            let group = membership.group.index();
            self.survey.measure(group, membership.apply(angle));
        }
    }

    /// Calls `drive` for each of these hinges, numbered from 0, with its number, its group and sign, and its commanded
    /// angle (radians), or `None` while it is not known where the groups stand. [Measures](Self::measure) the angle that
    /// `drive` returns, radians, if there is one. Cost: a multiplication and a comparison for each hinge.
    pub fn drive(
        &mut self,
        hinges: impl Iterator<Item = Membership>,
        mut drive: impl FnMut(u32, Membership, Option<T>) -> Option<T>,
    ) {
        let hinges = (0..).zip(hinges);
        if !self.stands {
            for (hinge, membership) in hinges {
                if let Some(angle) = drive(hinge, membership, None) {
                    self.measure(hinge, membership, angle);
                }
            }
            return;
        }
        self.lag.begin();
        let angles = self.angles.get(..self.groups).unwrap_or(&[]);
        for (hinge, membership) in hinges {
            if let Some(angle) = angles.get(membership.group.index()) {
                let command = membership.apply(*angle);
                if let Some(angle) = drive(hinge, membership, Some(command)) {
                    self.lag.note_next(hinge, (command - angle).abs());
                }
            }
        }
        self.lag.end();
    }
}
