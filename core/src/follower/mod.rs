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
//! | [Faulted](State::Faulted) | a [`Fault`] | [`clear`](Follower::clear) |
//!
//! An empty queue, a lagging hinge and a reached [lease](Follower::lease) hold the motion only while they last. Every
//! other reason holds the motion until [`resume`](Follower::resume), whatever else happens in between. The stop line and
//! a fault are two latches: neither hides nor releases the other.
//!
//! No motion starts from an unknown place, and nothing is commanded that is not there. A hinge that is measured far from its
//! command while nothing moves was moved by a hand, or lost its supply: from then on it is not known where the groups stand,
//! and no hinge is commanded. On a path this is a fault.
//!
//! A new follower does not know where the groups stand. It is told
//! ([`stand`](Follower::stand), [`confirm`](Follower::confirm)), or it takes the [measured](Follower::drive_from) angles of
//! the hinges while a path is ready. [`start`](Follower::start) then approaches the beginning of the path slowly, and
//! comes to rest there before the path begins. Until then nothing is commanded.

mod approach;
mod hinges;
mod intake;
mod lag;
mod motion;
mod options;
mod queue;
mod start;
mod state;
mod survey;

use crate::Scalar;
use crate::acceptance::{Progress, Setpoint, SheetView};
use crate::path_clock::PathClock;

use approach::Approach;
pub use hinges::{Hinge, Measurement, Target};
use lag::{Lag, LagWatch};
pub use motion::STUCK_BRAKE_RATIO;
pub use options::{CheckedOptions, OptionError, Options};
use queue::Queue;
pub use state::{Denial, Fault, FollowerPosition, Reason, State};
use survey::Survey;

/// Says how well it is known where the groups stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stance {
    Unknown,
    /// Somebody has said that they stand where the path begins.
    Told,
    /// They stood at `angles` before a reset, and no sensor has said so yet.
    Kept,
    /// The same, and a sensor agrees. The others have not yet had their time.
    Agreed,
    /// They stand at `angles`.
    Known,
}

/// A follower of at most `GROUPS` groups, with a queue of at most `KNOTS` setpoints.
// Fields are in this order, with large ones last, because a Cortex-M4 reaches only the first 4 kB of a struct by one
// instruction, and 1 kB for floating-point numbers. Structs that hold a follower are in order for the same reason.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct Follower<T, const GROUPS: usize, const KNOTS: usize> {
    options: Options<T>,
    /// Reason other than the stop line that holds the motion until [`resume`](Follower::resume).
    latch: Reason,
    state: State,
    /// `line`: `true` while the stop line is drawn. `stopped`: `true` from then on until [`resume`](Follower::resume).
    line: bool,
    stopped: bool,
    /// `true` if the last tick came late.
    is_late: bool,
    /// `true` if the last setpoint has come.
    ended: bool,
    stance: Stance,
    /// `true` if the angles are those of the position in the queue. Otherwise they are those of `last_position`.
    is_on_path: bool,
    /// `true` if the groups stand beside the path, because an approach was broken off.
    is_off_path: bool,
    /// Number of the essential vertex that is guarded next.
    guarded: u16,
    /// Failure, if the state is [`State::Faulted`].
    fault: Option<Fault>,
    clock: PathClock<T>,
    /// Place that the motion may not pass, if there is one.
    lease: Option<FollowerPosition<T>>,
    next: u32,
    now: u64,
    heard: u64,
    lag: LagWatch<T>,
    groups: usize,
    /// Time when the path was loaded, microseconds.
    loaded_at: u64,
    /// Position on the path before.
    last_position: FollowerPosition<T>,
    /// Measurements made while it is not known where the groups stand.
    survey: Survey<T, GROUPS>,
    angles: [T; GROUPS],
    rates: [T; GROUPS],
    approach: Approach<T, GROUPS>,
    /// Setpoint that is being checked, and how far its check has come.
    pending: Option<(Setpoint<T, GROUPS>, Progress)>,
    queue: Queue<T, GROUPS, KNOTS>,
}

impl<T: Scalar, const GROUPS: usize, const KNOTS: usize> Follower<T, GROUPS, KNOTS> {
    /// Creates an idle follower that does not know where the hinges are.
    // Inlined, so that a large follower is built in its place and not on the stack.
    #[inline(always)]
    #[must_use]
    pub fn new(options: CheckedOptions<T>) -> Self {
        Self {
            options: *options,
            state: State::Idle,
            latch: Reason::None,
            line: false,
            stopped: false,
            fault: None,
            clock: PathClock::default(),
            lease: None,
            now: 0,
            heard: 0,
            lag: LagWatch::new(&options),
            is_late: false,
            guarded: 0,
            approach: Approach::none(),
            queue: Queue::new(),
            pending: None,
            next: 0,
            ended: false,
            groups: 0,
            stance: Stance::Unknown,
            loaded_at: 0,
            is_on_path: false,
            last_position: FollowerPosition::default(),
            is_off_path: false,
            survey: Survey::new(),
            angles: [T::zero(); GROUPS],
            rates: [T::zero(); GROUPS],
        }
    }

    /// Returns the state.
    #[must_use]
    pub fn state(&self) -> State {
        self.state
    }

    /// Returns the reason that holds or slows the motion. A fault comes before the stop line, and the stop line before
    /// all others; see also [`fault`](Self::fault) and [`is_stopped`](Self::is_stopped).
    #[inline(never)]
    #[must_use]
    pub fn reason(&self) -> Reason {
        let Lag { hinge, distance } = self.lag.farthest();
        match (self.fault, self.state, self.latch) {
            (Some(fault), ..) => Reason::Fault(fault),
            _ if self.stopped => Reason::StopLine,
            (_, State::Running | State::Holding, Reason::None) if distance > T::zero() => {
                Reason::Lag(hinge)
            }
            (_, State::Running, Reason::None) if self.is_late => Reason::LateTick,
            (_, State::Running, Reason::None) if self.is_approaching() => Reason::Approach,
            (_, State::Holding, Reason::None)
                if self.ahead() <= T::zero()
                    && (self.left() > T::zero() || self.is_approaching()) =>
            {
                Reason::Lease
            }
            (_, State::Holding, Reason::None) => Reason::Underrun,
            (_, _, latch) => latch,
        }
    }

    /// Returns the failure, if the state is [`State::Faulted`].
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Returns `true` if the stop line is drawn, or was drawn and nobody has asked to resume since.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// Returns `true` until the groups have reached the beginning of a path that was started.
    #[must_use]
    pub fn is_approaching(&self) -> bool {
        self.approach.left() > T::zero()
    }

    /// Returns `true` if the groups stand beside the path, because an approach has not ended.
    #[must_use]
    pub fn is_off_path(&self) -> bool {
        self.is_off_path || self.is_approaching()
    }

    /// Returns `true` if it is known where the groups stand.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.stance == Stance::Known
    }

    /// Returns the rate of the path clock, seconds of the path in a second, from 0 to 1.
    #[must_use]
    pub fn rate(&self) -> T {
        self.clock.rate()
    }

    /// Returns the position of the commanded angles: on this path, or on the path before if this one has not begun.
    // Not inlined, so that an image has it once.
    #[inline(never)]
    #[must_use]
    pub fn position(&self) -> FollowerPosition<T> {
        let here = self.queue.position().filter(|_| self.is_on_path);
        here.unwrap_or(self.last_position)
    }

    /// Returns the number of the setpoint that is expected next.
    #[must_use]
    pub fn next(&self) -> u32 {
        self.next
    }

    /// Returns the number of groups of the path, or of the path before if there is none.
    #[must_use]
    pub fn groups(&self) -> usize {
        self.groups
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
        let groups = if self.is_known() { self.groups } else { 0 };
        values.get(..groups).unwrap_or(&[])
    }

    /// Returns `true` if the stop line or another reason holds the motion until [`resume`](Self::resume).
    fn is_held(&self) -> bool {
        self.stopped || self.latch != Reason::None
    }

    /// Bounds the path from outside: the motion comes to rest at this place, and goes on when the bound has grown. `None`
    /// removes the bound. A bound that shrinks below the braking distance stops the motion at once, but never moves it
    /// back.
    pub fn lease(&mut self, place: Option<FollowerPosition<T>>) {
        self.lease = place;
    }

    /// Takes up a new path on this sheet, from its beginning or from a position on it. Drops the path before.
    ///
    /// The setpoints come next, from the knot of the position on. If the sheet has another number of groups than the
    /// sheet before, it is not known where they stand.
    ///
    /// # Errors
    /// While moving, in a fault, or if the sheet has no group or too many.
    pub fn load(
        &mut self,
        sheet: &SheetView<'_, T>,
        from: FollowerPosition<T>,
    ) -> Result<(), Denial> {
        self.unload()?;
        let groups = sheet.limits.len();
        if groups == 0 || groups > GROUPS {
            return Err(Denial::Groups);
        }
        if self.groups != groups {
            self.stance = Stance::Unknown;
        }
        (self.groups, self.loaded_at) = (groups, self.now);
        self.limit_lag(T::MAX);
        self.survey.clear();
        self.queue.begin(sheet, from.into);
        self.next = from.knot;
        self.state = State::Ready;
        Ok(())
    }

    /// Drops the path.
    ///
    /// # Errors
    /// While moving, or in a fault.
    #[inline(never)]
    pub fn unload(&mut self) -> Result<(), Denial> {
        if self.state == State::Faulted {
            return Err(Denial::State);
        }
        if self.clock.rate() > T::zero() || self.state == State::Running {
            return Err(Denial::Moving);
        }
        (self.last_position, self.is_off_path) = (self.position(), self.is_off_path());
        self.is_on_path = false;
        if self.stance == Stance::Told {
            self.stance = Stance::Unknown;
        }
        self.approach = Approach::none();
        self.queue.clear();
        self.pending = None;
        self.ended = false;
        self.still();
        self.state = State::Idle;
        Ok(())
    }

    /// Slows down along the path and holds until asked to resume.
    pub fn hold(&mut self, reason: Reason) {
        // The first reason is kept, beside the stop line.
        if reason == Reason::StopLine {
            self.stopped = true;
        } else if self.latch == Reason::None {
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

    /// Lowers the largest speed of each group to that of `speed`, radians per second, until another path is loaded. A
    /// tick that would exceed it is a [fault](Fault::Leap).
    pub fn limit_speeds(&mut self, speed: impl Fn(usize) -> T) {
        self.queue.limit_speeds(speed);
    }

    /// Lowers [`Options::most_lag`] to `most` radians until another path is loaded, and [`Options::lag`] to half of it, if
    /// they are larger: some sheets bear less than the controller allows. A number that is not above 0 lowers nothing.
    // Not inlined, so that an image has it once.
    #[inline(never)]
    pub fn limit_lag(&mut self, most: T) {
        let Options { lag, most_lag, .. } = self.options;
        (self.lag.slows, self.lag.holds) = (lag, most_lag);
        if most > T::zero() && most < most_lag {
            self.lag.holds = most;
            let half = most * T::HALF;
            if half < lag {
                self.lag.slows = half;
            }
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
        (self.latch, self.stopped) = (Reason::None, false);
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
        (self.state, self.fault) = (State::Holding, None);
        self.lag.clear();
        self.unload()
    }

    /// Stops at once because of a failure, in any state. Nothing moves until the failure is [cleared](Self::clear).
    #[inline(never)]
    pub fn fail(&mut self, fault: Fault) {
        self.clock.halt();
        self.still();
        self.pending = None;
        (self.state, self.fault) = (State::Faulted, Some(fault));
    }

    /// Returns the time of the last tick, microseconds.
    #[must_use]
    pub fn now(&self) -> u64 {
        self.now
    }

    /// Returns the microseconds since the host was heard.
    #[must_use]
    pub fn quiet(&self) -> u64 {
        self.now.saturating_sub(self.heard)
    }

    /// Returns `true` if the host was not heard for longer than [`Options::silence`].
    #[must_use]
    pub fn is_silent(&self) -> bool {
        self.quiet() > u64::from(self.options.silence)
    }

    /// Notes that the host was heard at `now`, microseconds.
    pub fn heard(&mut self, now: u64) {
        self.heard = self.heard.max(now);
    }
}
