//! A tick of a follower: how far does it move, and what slows, holds or ends the motion?

use crate::follower::lag::{Lag, LagWatch};
use crate::follower::{Fault, Follower, Options, Reason, Stance, State};
use crate::{Scalar, StarsView};

/// Smallest rate of the clock, in fractions of the full rate, while a hinge lags by less than `most_lag`. If the rate fell
/// to 0, the command would stop moving away from a stalled hinge, and the lag would never reach `most_lag`.
const MIN_LAGGING_RATE: f64 = 0.1;

/// Loss of the clock's rate in a second while a hinge lags by `most_lag` or more, in losses while anything else brakes. Each
/// moment of it tears the sheet farther, unlike that of other reasons, for which all hinges go on alike.
pub const STUCK_BRAKE_RATIO: f64 = 8.0;

impl<T: Scalar, const GROUPS: usize, const KNOTS: usize> Follower<T, GROUPS, KNOTS> {
    /// Moves on to `now`, microseconds, on a sheet with these essential vertices. Time that has already passed does not pass
    /// again. If a group would move farther than its speed allows, or an essential vertex would be torn, the commands stay,
    /// and the motion fails. One vertex is looked at in a tick, in turn.
    ///
    /// Cost: a cubic and its derivative for each group, and a sine, a cosine and some twenty operations for each spoke of the
    /// vertex; when a knot is passed, also the curves of the next segment.
    pub fn tick(&mut self, stars: StarsView<'_, T>, now: u64) {
        let passed = now.saturating_sub(self.now);
        let passed = u32::try_from(passed).unwrap_or(u32::MAX);
        self.now = self.now.max(now);
        let longest = self.options.longest_tick;
        self.is_late = passed > longest;
        let passed = passed.min(longest);
        if self.stance == Stance::Agreed {
            self.keep();
        }
        let lag = self.lag.farthest();
        if lag.distance > T::zero() {
            self.doubt(passed);
        }
        if !self.is_under_way() {
            return;
        }
        self.watch(lag, passed);
        if !self.is_under_way() {
            return;
        }
        let dt = T::whole(passed) * T::lit(1e-6);
        let goal = self.goal(lag.distance);
        let mut limits = self.options.clock;
        if lag.distance >= self.lag.holds {
            limits.brake *= T::lit(STUCK_BRAKE_RATIO);
        }
        let step = self.clock.tick(limits, dt, goal, self.ahead());
        if step > T::zero() {
            self.move_by(stars, step, dt);
        } else {
            // The angles stay as they are to the last bit, at the beginning of an approach as well.
            self.still();
        }
        self.settle(goal);
    }

    /// Moves by `step` seconds of the path, in `dt` seconds of the world.
    fn move_by(&mut self, stars: StarsView<'_, T>, step: T, dt: T) {
        let (before, approaches) = (self.position(), self.is_approaching());
        let step = if approaches {
            self.approach.advance(step)
        } else {
            step
        };
        self.queue.advance(step);
        let mut angles = self.queue.angles(self.angles);
        let clock = self.clock.rate();
        let mut rates = self.queue.rates(clock);
        if self.is_approaching() {
            self.approach.offset(&mut angles);
            rates = self.approach.rates(clock);
        }
        let leap = self.queue.leap(&self.angles, &angles, dt).map(Fault::Leap);
        // The angles of an approach do not close.
        let torn = || {
            let star = self.queue.torn(stars, &mut self.guarded, &angles);
            star.filter(|_| !approaches).map(Fault::Torn)
        };
        if let Some(fault) = leap.or_else(torn) {
            // The groups stay where they were, and so does the position that is told.
            (self.is_on_path, self.last_position) = (false, before);
            self.is_off_path |= approaches;
            self.fail(fault);
        } else {
            (self.angles, self.rates) = (angles, rates);
        }
    }

    /// Returns the seconds of path time for which the motion may go on: up to the beginning of the path, where the
    /// approach comes to rest, and from there up to the last setpoint and the bound from outside. The approach waits as
    /// well until the bound lets the path begin.
    #[inline(never)]
    pub(super) fn ahead(&self) -> T {
        let leased = self.lease.map_or(T::MAX, |place| self.queue.until(place));
        if !self.is_approaching() {
            self.left().min(leased.max(T::zero()))
        } else if leased > T::zero() {
            self.approach.left()
        } else {
            T::zero()
        }
    }

    /// Forgets where the groups stand if a hinge is measured far from its command, and neither a motion nor the brakes
    /// explain it: otherwise its drive would pull it back as fast as it can, once it can. A sensor that tells no angle tells
    /// nothing here.
    #[inline(never)]
    fn doubt(&mut self, passed: u32) {
        let Lag { hinge, distance } = self.lag.farthest_measured();
        let Options {
            lag,
            most_lag,
            clock,
            ..
        } = self.options;
        let rests = self.is_held() && self.clock.rate() <= T::zero();
        let most = if self.is_under_way() && !rests {
            let fastest = self.queue.speeds().fold(T::zero(), T::max);
            most_lag + fastest * T::HALF / clock.brake + lag
        } else {
            most_lag
        };
        if !self.lag.stays(distance >= most, passed) {
            return;
        }
        if self.is_under_way() {
            self.fail(Fault::Stalled(hinge));
        }
        self.lose();
    }

    /// Checks for a silent host and for a stalled hinge, after `passed` microseconds.
    fn watch(&mut self, Lag { hinge, distance }: Lag<T>, passed: u32) {
        if self.is_silent() && !self.is_held() {
            self.hold(Reason::Silence);
        }
        if self.is_held() {
            self.lag.restart();
            return;
        }
        let stuck = self.lag.pass(distance >= self.lag.holds, passed);
        if stuck >= self.options.stall {
            self.fail(Fault::Stalled(hinge));
        }
    }

    /// Returns the rate that the clock should have while the farthest hinge is at this distance, from 0 to 1.
    fn goal(&self, distance: T) -> T {
        let LagWatch { slows, holds, .. } = self.lag;
        if self.is_held() || distance >= holds {
            T::zero()
        } else if distance > slows {
            let part = (distance - slows) / (holds - slows);
            T::one() - (T::one() - T::lit(MIN_LAGGING_RATE)) * part
        } else {
            T::one()
        }
    }

    /// Commands rates of 0.
    pub(super) fn still(&mut self) {
        self.rates = [T::zero(); GROUPS];
    }

    /// Sets the state after a tick with this goal of the rate.
    fn settle(&mut self, goal: T) {
        if self.fault.is_some() {
            return;
        }
        let rests = self.clock.rate() <= T::zero();
        let dry = self.ahead() <= T::zero();
        let arrived = self.left() <= T::zero() && !self.is_approaching();
        self.state = if self.ended && arrived {
            self.clock.halt();
            self.still();
            State::Done
        } else if self.is_held() || rests && (dry || goal <= T::zero()) {
            State::Holding
        } else {
            State::Running
        };
    }
}
