//! The follower of a path: turns setpoints into the commanded angles of each moment.
//!
//! It is a state machine without a clock of its own. Setpoints are [accepted](Follower::accept) one after the other
//! into a queue. [`Follower::tick`], called at a steady pace, moves along the queued path as fast as the
//! [path clock](crate::path_clock) allows. Whatever slows or holds the motion does so through that clock, so that the
//! sheet stays on configurations that close. `examples/follower.rs` follows a path that is compiled in.
//!
//! | state | meaning | left by |
//! |---|---|---|
//! | [Idle](State::Idle) | no path | [`load`](Follower::load) |
//! | [Ready](State::Ready) | a path that has not begun | [`start`](Follower::start) |
//! | [Running](State::Running) | the clock runs, or is slowed by a hinge | the path's end, whatever holds it, a stalled hinge |
//! | [Holding](State::Holding) | braking, or at rest on the path; [`reason`](Follower::reason) says why | [`resume`](Follower::resume), or what it waits for |
//! | [Done](State::Done) | at the last setpoint of the path | [`load`](Follower::load) |
//! | [Faulted](State::Faulted) | a hinge stalled | [`clear`](Follower::clear) |
//!
//! An empty queue and a lagging hinge hold the motion only while they last. Every other reason holds the motion until
//! [`resume`](Follower::resume), whatever else happens in between.

mod queue;
mod state;

use crate::acceptance::{self, Refusal, Setpoint, SheetView};
use crate::path_clock::PathClock;
use crate::{Membership, Scalar};

use queue::Queue;
pub use state::{Denial, FollowerPosition, Options, Reason, State};

/// Smallest rate of the clock, in fractions of the full rate, while a hinge lags by less than `most_lag`. If the rate fell
/// to 0, the command would stop moving away from a stalled hinge, and the lag would never reach `most_lag`.
const MIN_LAGGING_RATE: f64 = 0.1;

/// The hinge that was last measured farthest from its command, radians; the default if no hinge was off its command.
#[derive(Clone, Copy, Debug, Default)]
struct Lag<T> {
    hinge: u32,
    distance: T,
}

/// A follower of at most `GROUPS` groups, with a queue of at most `KNOTS` setpoints.
#[derive(Clone, Debug)]
pub struct Follower<T, const GROUPS: usize, const KNOTS: usize> {
    options: Options<T>,
    state: State,
    /// Reason that holds the motion until [`resume`](Follower::resume).
    latch: Reason,
    /// `true` while the stop line is drawn.
    line: bool,
    clock: PathClock<T>,
    now: u64,
    heard: u64,
    lag: Lag<T>,
    /// Time since which a hinge has lagged by at least `most_lag`, microseconds.
    lagging: Option<u64>,

    queue: Queue<T, GROUPS, KNOTS>,
    next: u32,
    ended: bool,

    groups: usize,
    /// `stands`: `true` if `angles` have been commanded or measured. `stood`: position of those angles on the path that
    /// was left.
    stands: bool,
    stood: FollowerPosition<T>,
    angles: [T; GROUPS],
    rates: [T; GROUPS],
}

impl<T: Scalar, const GROUPS: usize, const KNOTS: usize> Follower<T, GROUPS, KNOTS> {
    /// Creates an idle follower that does not know where the hinges are.
    // Inlined, so that a large follower is built in its place and not on the stack.
    #[inline(always)]
    #[must_use]
    pub fn new(options: Options<T>) -> Self {
        Self {
            options,
            state: State::Idle,
            latch: Reason::None,
            line: false,
            clock: PathClock::new(options.clock),
            now: 0,
            heard: 0,
            lag: Lag::default(),
            lagging: None,
            queue: Queue::new(),
            next: 0,
            ended: false,
            groups: 0,
            stands: false,
            stood: FollowerPosition::default(),
            angles: [T::zero(); GROUPS],
            rates: [T::zero(); GROUPS],
        }
    }

    /// Returns the state.
    #[must_use]
    pub fn state(&self) -> State {
        self.state
    }

    /// Returns the reason that holds or slows the motion.
    #[must_use]
    pub fn reason(&self) -> Reason {
        let Lag { hinge, distance } = self.lag;
        match (self.state, self.latch) {
            (State::Faulted, _) => Reason::Stalled(hinge),
            (State::Running | State::Holding, Reason::None) if distance > self.options.lag => {
                Reason::Lag(hinge)
            }
            (State::Holding, Reason::None) => Reason::Underrun,
            (_, latch) => latch,
        }
    }

    /// Returns the rate of the path clock, seconds of the path in a second, from 0 to 1.
    #[must_use]
    pub fn rate(&self) -> T {
        self.clock.rate()
    }

    /// Returns the position of the commanded angles: on this path, or on the path before if this one has not begun.
    #[must_use]
    pub fn position(&self) -> FollowerPosition<T> {
        match self.state {
            State::Idle | State::Ready => self.stood,
            _ => self.queue.position().unwrap_or(self.stood),
        }
    }

    /// Returns the number of the setpoint that is expected next.
    #[must_use]
    pub fn next(&self) -> u32 {
        self.next
    }

    /// Returns the number of setpoints for which there is room.
    #[must_use]
    pub fn room(&self) -> usize {
        KNOTS.saturating_sub(self.queue.setpoints().len())
    }

    /// Returns the seconds of the path that are queued ahead.
    #[must_use]
    pub fn left(&self) -> T {
        self.queue.left()
    }

    /// Returns `true` if the follower is running or holding.
    #[must_use]
    pub fn is_under_way(&self) -> bool {
        matches!(self.state, State::Running | State::Holding)
    }

    /// Returns the commanded angle of each group, radians; empty while it is not known where the groups stand.
    #[must_use]
    pub fn angles(&self) -> &[T] {
        self.known(&self.angles)
    }

    /// Returns the rate of each group, radians per second of the world.
    #[must_use]
    pub fn rates(&self) -> &[T] {
        self.known(&self.rates)
    }

    fn known<'a>(&self, values: &'a [T]) -> &'a [T] {
        let groups = if self.stands { self.groups } else { 0 };
        values.get(..groups).unwrap_or(&[])
    }

    /// Returns the commanded angle of a hinge, radians.
    #[must_use]
    pub fn hinge(&self, membership: Membership) -> Option<T> {
        let angle = self.angles().get(membership.group.index())?;
        Some(membership.apply(*angle))
    }

    /// Tells the follower where the groups stand (radians), as measured or as commanded before a reset, and at which
    /// position on their path.
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
        (self.stands, self.stood) = (true, position);
        Ok(())
    }

    /// Takes up a new path on this sheet, from its beginning or from a position on it. Drops the path before.
    ///
    /// The setpoints come next, from the knot of the position on.
    ///
    /// # Errors
    /// While moving, in a fault, or if the sheet has too many groups or other groups than those that stand.
    pub fn load(
        &mut self,
        sheet: &SheetView<'_, T>,
        from: FollowerPosition<T>,
    ) -> Result<(), Denial> {
        self.unload()?;
        let groups = sheet.limits.len();
        let others = self.stands && self.groups != groups;
        if groups == 0 || groups > GROUPS || others {
            return Err(Denial::Groups);
        }
        self.groups = groups;
        self.queue.begin(sheet, from.into);
        self.next = from.knot;
        self.state = State::Ready;
        Ok(())
    }

    /// Drops the path.
    ///
    /// # Errors
    /// While moving, or in a fault.
    pub fn unload(&mut self) -> Result<(), Denial> {
        if self.state == State::Faulted {
            return Err(Denial::State);
        }
        if self.clock.rate() > T::zero() || self.state == State::Running {
            return Err(Denial::Moving);
        }
        self.stood = self.position();
        self.queue.clear();
        self.ended = false;
        self.still();
        self.state = State::Idle;
        Ok(())
    }

    /// Queues a setpoint. An invalid setpoint holds the motion.
    ///
    /// Cost: that of [`acceptance::check`].
    ///
    /// # Errors
    /// The reason why the setpoint is not followed; nothing but the hold has changed then.
    pub fn accept(
        &mut self,
        sheet: &SheetView<'_, T>,
        setpoint: Setpoint<T, GROUPS>,
    ) -> Result<(), Refusal> {
        if !matches!(self.state, State::Ready | State::Running | State::Holding) {
            return Err(Refusal::State);
        }
        if self.room() == 0 {
            return Err(Refusal::Full);
        }
        let in_order = setpoint.number == self.next && !self.ended;
        let checked = if in_order {
            acceptance::check(sheet, self.queue.setpoints().back(), &setpoint)
        } else {
            Err(Refusal::Sequence(self.next))
        };
        if let Err(refusal) = checked {
            self.hold(Reason::Refused(refusal));
            return Err(refusal);
        }
        self.next = self.next.wrapping_add(1);
        self.ended = setpoint.last;
        self.queue.push(setpoint)
    }

    /// Starts the motion.
    ///
    /// # Errors
    /// If not ready, if held or stopped, if no setpoint is queued, or if the hinges stand elsewhere.
    pub fn start(&mut self) -> Result<(), Denial> {
        if self.state != State::Ready {
            return Err(Denial::State);
        }
        if self.line || self.latch != Reason::None {
            return Err(Denial::Held);
        }
        if self.queue.setpoints().is_empty() {
            return Err(Denial::Empty);
        }
        if !self.queue.begins() {
            return Err(Denial::Place);
        }
        let begin = self.queue.angles(self.angles);
        // The comparison is false for a NaN, so that a group at no number is denied.
        let near = |(from, to): (&T, &T)| (*from - *to).abs() <= self.options.jump;
        let mut groups = (0..=u16::MAX).zip(self.angles().iter().zip(&begin));
        if let Some((group, _)) = groups.find(|(_, ends)| !near(*ends)) {
            return Err(Denial::Jump(group));
        }
        self.angles = begin;
        self.still();
        self.stands = true;
        self.heard = self.now;
        (self.lag, self.lagging) = (Lag::default(), None);
        self.state = State::Running;
        Ok(())
    }

    /// Slows down along the path and holds until asked to resume.
    pub fn hold(&mut self, reason: Reason) {
        // The first reason is kept; only the stop line replaces it.
        if self.latch == Reason::None || reason == Reason::StopLine {
            self.latch = reason;
        }
        if self.state == State::Running {
            self.state = State::Holding;
        }
    }

    /// Sets the level of the stop line. If it is drawn, everything stops at once and stays stopped until
    /// [`resume`](Self::resume).
    pub fn stop(&mut self, drawn: bool) {
        self.line = drawn;
        if drawn {
            self.clock.halt();
            self.still();
            self.hold(Reason::StopLine);
        }
    }

    /// Lets the motion go on from its position.
    ///
    /// # Errors
    /// While the stop line is drawn.
    pub fn resume(&mut self) -> Result<(), Denial> {
        if self.line {
            return Err(Denial::Held);
        }
        self.latch = Reason::None;
        self.heard = self.now;
        if self.state == State::Holding {
            self.state = State::Running;
        }
        Ok(())
    }

    /// Leaves a fault and drops the path.
    ///
    /// # Errors
    /// If not faulted.
    pub fn clear(&mut self) -> Result<(), Denial> {
        if self.state != State::Faulted {
            return Err(Denial::State);
        }
        self.state = State::Holding;
        (self.lag, self.lagging) = (Lag::default(), None);
        self.unload()
    }

    /// Notes that the host was heard at `now`, microseconds.
    pub fn heard(&mut self, now: u64) {
        self.heard = self.heard.max(now);
    }

    /// Takes the measured angle of a hinge, radians. Hinges may be measured in any order and at any pace; the one
    /// farthest from its command counts until it is measured again.
    pub fn measure(&mut self, hinge: u32, membership: Membership, angle: T) {
        let Some(commanded) = self.hinge(membership) else {
            return;
        };
        let distance = (commanded - angle).abs();
        if distance <= self.lag.distance && hinge != self.lag.hinge {
            return;
        }
        // In a fault the hinge that stalled is kept.
        if self.state != State::Faulted {
            let distance = if distance.is_finite() {
                distance
            } else {
                T::MAX
            };
            self.lag = Lag { hinge, distance };
        }
    }

    /// Moves on to `now`, microseconds. Time that has already passed does not pass again.
    ///
    /// Cost: a cubic and its derivative for each group; when a knot is passed, also the curves of the next segment.
    pub fn tick(&mut self, now: u64) {
        let passed = now.saturating_sub(self.now);
        let passed = u32::try_from(passed).unwrap_or(u32::MAX);
        self.now = self.now.max(now);
        if !self.is_under_way() {
            return;
        }
        self.watch();
        if !self.is_under_way() {
            return;
        }
        let dt = T::whole(passed.min(self.options.longest_tick)) * T::lit(1e-6);
        let goal = self.goal();
        let step = self.clock.tick(dt, goal, self.left());
        self.queue.advance(step);
        self.angles = self.queue.angles(self.angles);
        self.rates = self.queue.rates(self.clock.rate());
        self.settle(goal);
    }

    /// Checks for a silent host and for a stalled hinge.
    fn watch(&mut self) {
        let silent = self.now.saturating_sub(self.heard) > u64::from(self.options.silence);
        if silent && self.latch == Reason::None {
            self.hold(Reason::Silence);
        }
        let stuck = self.lag.distance >= self.options.most_lag;
        if !stuck || self.latch != Reason::None {
            self.lagging = None;
            return;
        }
        let since = *self.lagging.get_or_insert(self.now);
        if self.now.saturating_sub(since) >= u64::from(self.options.stall) {
            self.clock.halt();
            self.still();
            self.state = State::Faulted;
        }
    }

    /// Returns the rate that the clock should have, from 0 to 1.
    fn goal(&self) -> T {
        let Options { lag, most_lag, .. } = self.options;
        let distance = self.lag.distance;
        if self.latch != Reason::None || distance >= most_lag {
            T::zero()
        } else if distance > lag {
            let part = (distance - lag) / (most_lag - lag);
            T::one() - (T::one() - T::lit(MIN_LAGGING_RATE)) * part
        } else {
            T::one()
        }
    }

    /// Commands rates of 0.
    fn still(&mut self) {
        self.rates = [T::zero(); GROUPS];
    }

    /// Sets the state after a tick with this goal of the rate.
    fn settle(&mut self, goal: T) {
        let rests = self.clock.rate() <= T::zero();
        let dry = self.left() <= T::zero();
        self.state = if self.ended && dry {
            self.clock.halt();
            State::Done
        } else if self.latch != Reason::None || rests && (dry || goal <= T::zero()) {
            State::Holding
        } else {
            State::Running
        };
    }
}
