//! The start of a motion, which needs a place that is known.

use crate::Scalar;
use crate::follower::lag::LagWatch;
use crate::follower::survey::Survey;
use crate::follower::{Denial, Follower, FollowerPosition, Options, State};

impl<T: Scalar, const GROUPS: usize, const KNOTS: usize> Follower<T, GROUPS, KNOTS> {
    /// Tells the follower where the groups stand (radians), as commanded before a reset, and at which position on their
    /// path; no angles if only the position is known. `is_off_path` is what [`is_off_path`](Self::is_off_path) was.
    ///
    /// # Errors
    /// If not idle, or if there are too many groups.
    pub fn stand(
        &mut self,
        angles: &[T],
        position: FollowerPosition<T>,
        is_off_path: bool,
    ) -> Result<(), Denial> {
        if self.state != State::Idle {
            return Err(Denial::State);
        }
        let mine = self.angles.get_mut(..angles.len());
        mine.ok_or(Denial::Groups)?.copy_from_slice(angles);
        (self.groups, self.knows_position) = (angles.len(), !angles.is_empty());
        (self.last_position, self.is_off_path) = (position, is_off_path);
        Ok(())
    }

    /// Takes somebody's word that the groups stand where the path begins. It counts for this path. Nothing is commanded
    /// before the motion [starts](Self::start): groups of which hinges were measured then start from there.
    ///
    /// # Errors
    /// If not ready, if held or stopped, if it is known where the groups stand, if the path does not begin at its first
    /// setpoints, or if a hinge was measured farther from there than `reach`.
    pub fn confirm(&mut self) -> Result<(), Denial> {
        if self.knows_position {
            return Err(Denial::State);
        }
        let begin = self.ready()?;
        self.survey.near(begin, self.groups, self.options.reach)?;
        self.is_confirmed = true;
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
        (self.knows_position, self.is_confirmed, self.is_off_path) = (false, false, false);
        (self.last_position, self.survey) = (FollowerPosition::default(), Survey::new());
        Ok(())
    }

    /// Returns the angles at which the path begins, if the motion may start as far as the state is concerned. Forgets
    /// measurements that are too old.
    #[inline(never)]
    fn ready(&mut self) -> Result<[T; GROUPS], Denial> {
        if self.state != State::Ready {
            return Err(Denial::State);
        }
        if self.line || self.is_held() {
            return Err(Denial::Held);
        }
        if self.queue.setpoints().is_empty() {
            return Err(Denial::Empty);
        }
        if !self.queue.begins() {
            return Err(Denial::Place);
        }
        self.survey.age(self.now, self.options.fresh);
        Ok(self.queue.angles(self.angles))
    }

    /// Starts the motion: a slow approach to the beginning of the path, where it comes to rest, and then the path.
    ///
    /// # Errors
    /// If not ready, if held or stopped, if no setpoint is queued, if it is not known where the groups stand, or if they
    /// stand elsewhere.
    #[inline(never)]
    pub fn start(&mut self) -> Result<(), Denial> {
        let begin = self.ready()?;
        let Options {
            jump,
            reach,
            spread,
            approach,
            ..
        } = self.options;
        let (stand, reach) = if self.knows_position {
            (self.angles, if self.is_off_path { reach } else { jump })
        } else if self.is_confirmed {
            (self.survey.near(begin, self.groups, reach)?, reach)
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
        (self.angles, self.knows_position) = (stand, true);
        (self.is_on_path, self.is_confirmed, self.is_off_path) = (true, false, false);
        self.still();
        self.heard = self.now;
        self.lag = LagWatch::default();
        self.state = State::Running;
        Ok(())
    }
}
