//! The start of a motion, which needs a place that is known.

use crate::Scalar;
use crate::follower::{Denial, Follower, FollowerPosition, Options, Stance, State};

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
        self.groups = angles.len();
        self.stance = if angles.is_empty() {
            Stance::Unknown
        } else {
            Stance::Known
        };
        (self.last_position, self.is_off_path) = (position, is_off_path);
        Ok(())
    }

    /// Commands nothing before a path has been loaded for half of [`Options::fresh`], within which each hinge with a sensor is
    /// measured. If none is measured elsewhere, the angles that the follower was [told](Self::stand) count from then on.
    pub fn withhold(&mut self) {
        if self.is_known() {
            self.stance = Stance::Kept;
        }
    }

    /// Commands the angles that were kept over a reset, and with which a sensor agrees, once all sensors had their time.
    #[inline(never)]
    pub(super) fn keep(&mut self) {
        let passed = self.now.saturating_sub(self.loaded_at);
        let all_measured = self.state != State::Idle && passed >= u64::from(self.options.fresh / 2);
        if all_measured && self.lag.farthest().distance <= T::zero() {
            self.stance = Stance::Known;
        }
    }

    /// Takes somebody's word that the groups stand where the path begins. It counts for this path. Nothing is commanded
    /// before the motion [starts](Self::start): groups of which hinges were measured then start from there.
    ///
    /// # Errors
    /// If not ready, if held or stopped, if it is known where the groups stand, if the path does not begin at its first
    /// setpoints, or if a hinge was measured farther from there than `reach`.
    pub fn confirm(&mut self) -> Result<(), Denial> {
        if self.is_known() {
            return Err(Denial::State);
        }
        let begin = self.ready()?;
        let Options { spread, reach, .. } = self.options;
        self.survey
            .angles(Some(&begin), self.groups, [spread, reach])?;
        self.stance = Stance::Told;
        Ok(())
    }

    /// Forgets where the groups stand, so that they have to be measured or [confirmed](Self::confirm). A path that has
    /// begun is dropped.
    ///
    /// # Errors
    /// While moving, or in a fault.
    #[inline(never)]
    pub fn forget(&mut self) -> Result<(), Denial> {
        if self.state != State::Ready {
            self.unload()?;
        }
        self.lose();
        self.last_position = FollowerPosition::default();
        Ok(())
    }

    /// Forgets where the groups stand, and keeps their position on the path.
    #[inline(never)]
    pub(super) fn lose(&mut self) {
        (self.stance, self.is_off_path) = (Stance::Unknown, false);
        self.survey.clear();
        self.lag.clear();
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

    /// Moves measured angles by at most `error` to a place of the path, because angles with the errors of sensors do not close:
    /// to its beginning if somebody has said that the groups stand there, or else to the place that fits best on its tangent.
    fn fit(&self, stand: &mut [T; GROUPS], begin: &[T; GROUPS], error: T) {
        let rates = self.queue.rates(T::one());
        let places = || stand.iter().zip(begin).zip(&rates).take(self.groups);
        let (along, norm) =
            places().fold((T::zero(), T::zero()), |sums, ((stand, begin), rate)| {
                (sums.0 + (*stand - *begin) * *rate, sums.1 + *rate * *rate)
            });
        let time = if self.stance == Stance::Told || norm <= T::zero() {
            T::zero()
        } else {
            along / norm
        };
        for ((stand, begin), rate) in stand.iter_mut().zip(begin).zip(&rates) {
            // A sum with 0 would lose the sign of 0.
            let fitted = if time.is_zero() {
                *begin
            } else {
                *begin + *rate * time
            };
            if (*stand - fitted).abs() <= error {
                *stand = fitted;
            }
        }
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
        let (mut stand, reach) = if self.is_known() {
            (self.angles, if self.is_off_path { reach } else { jump })
        } else {
            let claimed = (self.stance == Stance::Told).then_some(&begin);
            let angles = self.survey.angles(claimed, self.groups, [spread, reach]);
            // The next start from measurements needs new ones.
            if claimed.is_none() {
                self.survey.clear();
            }
            (angles?, reach)
        };
        // The comparison is false for a NaN, so that a group at no number is denied.
        let near = |(from, to): (&T, &T)| (*from - *to).abs() <= reach;
        let mut groups = (0..=u16::MAX).zip(stand.iter().zip(&begin).take(self.groups));
        if let Some((group, _)) = groups.find(|(_, ends)| !near(*ends)) {
            return Err(Denial::Jump(group));
        }
        if !self.is_known() {
            self.fit(&mut stand, &begin, spread * T::HALF);
        }
        let speeds = self.queue.speeds().map(|speed| speed.min(approach));
        self.approach.begin(&stand, &begin, self.groups, speeds);
        (self.angles, self.stance) = (stand, Stance::Known);
        (self.is_on_path, self.is_off_path) = (true, false);
        self.still();
        self.heard = self.now;
        self.lag.clear();
        self.state = State::Running;
        Ok(())
    }
}
