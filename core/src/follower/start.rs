//! The start of a motion, which needs a place that is known.

use crate::Scalar;
use crate::follower::lag::LagWatch;
use crate::follower::survey::Survey;
use crate::follower::{Denial, Follower, FollowerPosition, Options, State};

impl<T: Scalar, const GROUPS: usize, const KNOTS: usize> Follower<T, GROUPS, KNOTS> {
    /// Tells the follower where the groups stand (radians), as commanded before a reset, and at which position on their
    /// path.
    ///
    /// # Errors
    /// If not idle, or if there are too many groups.
    pub fn stand(&mut self, angles: &[T], position: FollowerPosition<T>) -> Result<(), Denial> {
        if self.state != State::Idle {
            return Err(Denial::State);
        }
        let mine = self.angles.get_mut(..angles.len());
        mine.ok_or(Denial::Groups)?.copy_from_slice(angles);
        self.groups = angles.len();
        (self.stands, self.stood, self.astray) = (true, position, false);
        Ok(())
    }

    /// Takes somebody's word that the groups stand where the path begins.
    ///
    /// # Errors
    /// If not ready, if it is known where they stand, or if the path does not begin at its first setpoints.
    #[inline(never)]
    pub fn confirm(&mut self) -> Result<(), Denial> {
        if self.state != State::Ready || self.stands {
            return Err(Denial::State);
        }
        self.angles = self.beginning()?;
        self.stood = self.queue.position().unwrap_or_default();
        (self.stands, self.astray) = (true, false);
        Ok(())
    }

    /// Forgets where the groups stand, so that they have to be measured or [confirmed](Self::confirm). A path that has
    /// begun is dropped.
    ///
    /// # Errors
    /// While moving, or in a fault.
    pub fn forget(&mut self) -> Result<(), Denial> {
        if self.state != State::Ready {
            self.unload()?;
        }
        self.stands = false;
        (self.stood, self.survey) = (FollowerPosition::default(), Survey::new());
        Ok(())
    }

    /// Returns the angles at which the path begins.
    #[inline(never)]
    fn beginning(&self) -> Result<[T; GROUPS], Denial> {
        if self.queue.setpoints().is_empty() {
            return Err(Denial::Empty);
        }
        if !self.queue.begins() {
            return Err(Denial::Place);
        }
        Ok(self.queue.angles(self.angles))
    }

    /// Starts the motion: a slow approach to the beginning of the path, and then the path.
    ///
    /// # Errors
    /// If not ready, if held or stopped, if no setpoint is queued, if it is not known where the groups stand, or if they
    /// stand elsewhere.
    #[inline(never)]
    pub fn start(&mut self) -> Result<(), Denial> {
        if self.state != State::Ready {
            return Err(Denial::State);
        }
        if self.line || self.is_held() {
            return Err(Denial::Held);
        }
        let begin = self.beginning()?;
        let Options {
            jump,
            reach,
            spread,
            approach,
            ..
        } = self.options;
        let (stand, reach) = if self.stands {
            (self.angles, if self.astray { reach } else { jump })
        } else {
            // The next start needs new measurements.
            let survey = core::mem::replace(&mut self.survey, Survey::new());
            (survey.angles(self.groups, spread)?, reach)
        };
        // The comparison is false for a NaN, so that a group at no number is denied.
        let near = |(from, to): (&T, &T)| (*from - *to).abs() <= reach;
        let mut groups = (0..=u16::MAX).zip(stand.iter().zip(&begin).take(self.groups));
        if let Some((group, _)) = groups.find(|(_, ends)| !near(*ends)) {
            return Err(Denial::Jump(group));
        }
        let speeds = self.queue.speeds().map(|speed| speed.min(approach));
        self.approach.begin(&stand, &begin, self.groups, speeds);
        (self.angles, self.stands, self.astray) = (stand, true, false);
        self.still();
        self.heard = self.now;
        self.lag = LagWatch::default();
        self.state = State::Running;
        Ok(())
    }
}
