//! The host's end of the line: sends items until they have come, and commands until they are answered.
//!
//! Go-back-N with cumulative acknowledgement: lost items are sent again from the first one that has not come, when the
//! controller tells a gap (once) or has told nothing new for a while. The sender does not keep items, but asks a
//! [`Source`] for them again. The time after which something is sent again follows the measured round trips, as in
//! [RFC6298](crate#references): the smoothed time plus four times its mean deviation, doubled with each repetition.

use core::fmt;

use crate::follower::Denial;
use crate::wire::credentials::Credentials;
use crate::wire::frame;
use crate::wire::key::Key;
use crate::wire::message::{Capacity, Command, Item, Report, SCHEMA, ToDevice, ToHost, VERSION};
use crate::wire::sequence::{low_bits, wrapped};

/// The items that are to be sent.
pub trait Source {
    /// Returns item number `index`, from 0, with its bytes in `scratch`; `None` behind the last item, or if there is no
    /// room.
    fn item<'b>(&self, index: u64, scratch: &'b mut [u8]) -> Option<Item<'b>>;
}

/// `None` has nothing to send.
impl<S: Source> Source for Option<S> {
    fn item<'b>(&self, index: u64, scratch: &'b mut [u8]) -> Option<Item<'b>> {
        self.as_ref()?.item(index, scratch)
    }
}

/// Options of a [`Sender`]. Times are microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Number of the controller on its line; 0 if it is the only one.
    pub node: u8,
    /// Shortest time after which items and frames without an answer are sent again. The measured round trips make it
    /// longer.
    pub retry: u64,
    /// Longest time after which they are sent again.
    pub max_retry: u64,
    /// Longest time between two frames, if the last frame was answered.
    pub alive: u64,
    /// Round trip from which on a line counts as slow: its buffers may fill.
    pub slow_trip: u64,
    /// Time after which the host gives up if no report has told that one more of its frames has come.
    pub silence: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            node: 0,
            retry: 30_000,
            max_retry: 500_000,
            alive: 200_000,
            slow_trip: 10_000,
            silence: 5_000_000,
        }
    }
}

/// Progress of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The controller has not answered.
    Greeting,
    /// The controller has offered a session.
    Offered,
    /// Items and commands go through.
    Open,
    /// There is no session.
    Failed(Failure),
}

/// Reason why there is no session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Failure {
    /// The controller speaks this version of the protocol.
    Version {
        /// [`VERSION`] of the controller.
        version: u16,
        /// [`SCHEMA`] of the controller.
        schema: u32,
    },
    /// The controller no longer knows the session: it was reset, or another host has come.
    Lost,
    /// The controller is silent, or hears nothing.
    Silent,
    /// No controller has ever answered. One with a key answers only a host with the same key, and one without a key only
    /// a host without one.
    NoAnswer,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Version { version, schema } => write!(
                f,
                "the controller speaks version {version} ({schema:08x}) of the protocol, \
                 expected {VERSION} ({SCHEMA:08x})"
            ),
            Self::Lost => {
                f.write_str("the session is lost: the controller was reset, or another host came")
            }
            Self::Silent => f.write_str("the controller is silent"),
            Self::NoAnswer => f.write_str(
                "no controller answers; one with a key answers only a host with the same key, and one without a key only a \
                 host without one",
            ),
        }
    }
}

impl core::error::Error for Failure {}

/// Time by which a round trip may be longer than the shortest one, microseconds, because items wait in a buffer of the line: a
/// command waits as long.
const MAX_QUEUED_US: u64 = 200_000;
/// Least and largest window, bytes.
const WINDOW_BYTES: [u64; 2] = [64, 1 << 20];

/// A command that was not answered yet.
#[derive(Clone, Copy, Debug)]
struct Pending {
    command: Command,
    sent: Option<u64>,
}

/// The measured round trips, microseconds.
#[derive(Clone, Copy, Debug, Default)]
struct RoundTrips {
    /// Smoothed time (`mean`) and mean deviation from it, if a time was measured.
    measured: Option<(u64, u64)>,
    /// Shortest time.
    least: Option<u64>,
    /// Number of repetitions since the controller was heard.
    repeated: u32,
    /// Item that is timed, and the time when it was sent. An item that was sent again is not timed, because its answer may
    /// be that to either frame (Karn's algorithm).
    timed: Option<(u64, u64)>,
}

impl RoundTrips {
    fn measure(&mut self, time: u64) {
        self.repeated = 0;
        self.least = Some(self.least.map_or(time, |least| least.min(time)));
        self.measured = Some(match self.measured {
            None => (time, time / 2),
            Some((mean, deviation)) => (
                (7 * mean + time) / 8,
                (3 * deviation + mean.abs_diff(time)) / 4,
            ),
        });
    }

    /// Notes that something is sent again.
    fn repeat(&mut self) {
        (self.repeated, self.timed) = (self.repeated.saturating_add(1), None);
    }

    /// Returns the time after which something is sent again.
    fn retry(&self, options: &Options) -> u64 {
        let time = self
            .measured
            .map_or(0, |(mean, deviation)| mean + 4 * deviation);
        let doubled = time.max(options.retry) << self.repeated.min(16);
        doubled.min(options.max_retry.max(options.retry))
    }
}

/// The state machine of the host's end of the line.
#[derive(Clone, Debug)]
pub struct Sender {
    options: Options,
    id: u32,
    phase: Phase,
    session: u32,
    /// Number of items that have come (`acked`), number of the item to send next (`next`), number of items ever sent
    /// (`highest`), and number of the first item for which there is no room (`limit`).
    acked: u64,
    next: u64,
    highest: u64,
    limit: u64,
    /// Item from which the last gap was sent again.
    rewound: Option<u64>,
    /// `true` once round trips take long: then bytes of items that may be under way behind the first one (`window`), and bytes
    /// of the frame of the last item (`size`).
    slow: bool,
    window: u64,
    size: u64,
    repeated: u64,
    trips: RoundTrips,
    /// Time of the first greeting, microseconds.
    greeted_at: Option<u64>,
    /// Time of the first frame since a report has told of one more, microseconds.
    asked: Option<u64>,
    /// Time when the controller last took an item, or when the last item had left, microseconds.
    progress: u64,
    /// `true` while the last item may still be leaving: a frame takes its time on a slow line.
    leaves: bool,
    sent: Option<u64>,
    /// `true` if a report has told of one more frame since the last frame was sent.
    answered: bool,
    heard: Option<u64>,
    /// Telemetry that has come since the host last told what it has seen: the lowest bits of its time, and the number of its
    /// groups that have come.
    seen: Option<(u32, u16)>,
    /// Time of the last `Seen`, microseconds.
    seen_at: Option<u64>,
    /// Newest epoch that the controller has told.
    epoch: u8,
    number: u8,
    pending: Option<Pending>,
    answer: Option<Result<(), Denial>>,
    report: Option<Report>,
    capacity: Option<Capacity>,
    credentials: Option<Credentials>,
}

impl Sender {
    /// Creates a host that asks for a session. Its `id` is a number that it has not used before, such as a random one.
    #[must_use]
    pub fn new(id: u32, options: Options) -> Self {
        Self {
            options,
            id,
            phase: Phase::Greeting,
            session: 0,
            acked: 0,
            next: 0,
            highest: 0,
            limit: 0,
            rewound: None,
            slow: false,
            window: WINDOW_BYTES[0],
            size: 0,
            repeated: 0,
            trips: RoundTrips::default(),
            greeted_at: None,
            asked: None,
            progress: 0,
            leaves: false,
            sent: None,
            answered: false,
            heard: None,
            seen: None,
            seen_at: None,
            epoch: 0,
            number: 0,
            pending: None,
            answer: None,
            report: None,
            capacity: None,
            credentials: None,
        }
    }

    /// Protects all frames by a key that the controller has as well. `nonce` is the upper half of a number of which the
    /// host's id is the lower one, and which no host with this key has used before.
    #[must_use]
    pub fn with_key(self, key: Key, nonce: u32) -> Self {
        let nonce = u64::from(nonce) << 32 | u64::from(self.id);
        Self {
            credentials: Some(Credentials::new(key, nonce)),
            ..self
        }
    }

    /// Returns the progress of the session.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Returns the number of the session that was offered last; 0 if there is none.
    #[must_use]
    pub fn session(&self) -> u32 {
        self.session
    }

    /// Returns the number of items that have come.
    #[must_use]
    pub fn acknowledged(&self) -> u64 {
        self.acked
    }

    /// Returns the number of items that were sent and are not known to be lost.
    #[must_use]
    pub fn under_way(&self) -> u64 {
        self.next
    }

    /// Returns the number of items that were sent again.
    #[must_use]
    pub fn repeated(&self) -> u64 {
        self.repeated
    }

    /// Returns the smoothed time of a round trip, microseconds; `None` until one was measured.
    #[must_use]
    pub fn round_trip(&self) -> Option<u64> {
        self.trips.measured.map(|(mean, _)| mean)
    }

    /// Returns the controller's last report. While it tells of a refused item, no items are sent.
    #[must_use]
    pub fn report(&self) -> Option<&Report> {
        self.report.as_ref()
    }

    /// Returns the room of the controller; `None` until it has offered a session.
    #[must_use]
    pub fn capacity(&self) -> Option<Capacity> {
        self.capacity
    }

    /// Asks for a command; returns `false` while the command before has not been answered. [`Command::Hold`] does not wait for
    /// another one, and takes its place.
    ///
    /// Until `Hold` is answered, nothing else is sent in the open session: if it does not come through, the motion holds
    /// because the controller hears nothing.
    pub fn command(&mut self, command: Command) -> bool {
        let free = !self.holds() && (self.pending.is_none() || command == Command::Hold);
        if free {
            self.number = self.number.wrapping_add(1);
            let sent = None;
            (self.pending, self.answer) = (Some(Pending { command, sent }), None);
        }
        free
    }

    /// Returns `true` while `Hold` is on its way.
    fn holds(&self) -> bool {
        let pending = self.pending.as_ref();
        pending.is_some_and(|pending| pending.command == Command::Hold)
    }

    /// Returns `true` while a command is on its way.
    #[must_use]
    pub fn is_asking(&self) -> bool {
        self.pending.is_some()
    }

    /// Returns the result of the last command; `None` while it is on its way.
    #[must_use]
    pub fn answer(&self) -> Option<Result<(), Denial>> {
        self.answer
    }

    /// Sends the refused item again, after its source has changed it.
    pub fn amend(&mut self) {
        if let Some(report) = &mut self.report {
            report.refused = None;
        }
        self.next = self.acked;
    }

    /// Writes the next frame to send at `now`, microseconds, to `buffer`; `None` if it is not time yet, or if the
    /// buffers are too small.
    pub fn poll<'b>(
        &mut self,
        now: u64,
        source: &impl Source,
        scratch: &mut [u8],
        buffer: &'b mut [u8],
    ) -> Option<&'b [u8]> {
        let since = |then: Option<u64>| now.saturating_sub(then.unwrap_or(now));
        if matches!(self.phase, Phase::Failed(_)) {
            return None;
        }
        // Frames from the controller do not count: they come as well if somebody keeps those of the host back, or keeps a
        // session from beginning.
        if since(self.asked) > self.options.silence {
            let met = self.capacity.is_some();
            let failure = if met {
                Failure::Silent
            } else {
                Failure::NoAnswer
            };
            self.phase = Phase::Failed(failure);
            return None;
        }
        // A controller with a key does not answer frames of a session that it does not know.
        if self.phase == Phase::Offered
            && self.credentials.is_some()
            && since(self.heard) > self.options.max_retry
        {
            self.phase = Phase::Greeting;
        }
        let (session, message) = self.message(now, source, scratch)?;
        // The controller does not answer to what was seen.
        if !matches!(message, ToDevice::Seen { .. }) {
            (self.sent, self.answered) = (Some(now), false);
            self.asked = self.asked.or(Some(now));
        }
        let length = frame::write(self.options.node, session, &message, buffer)?;
        let length = match &mut self.credentials {
            None => frame::close(buffer, length)?,
            Some(credentials) => credentials.close(session, self.epoch, buffer, length)?,
        };
        if matches!(message, ToDevice::Item { .. }) {
            self.size = length as u64;
        }
        buffer.get(..length)
    }

    /// Returns the message to send at `now`, and its session.
    fn message<'s>(
        &mut self,
        now: u64,
        source: &impl Source,
        scratch: &'s mut [u8],
    ) -> Option<(u32, ToDevice<'s>)> {
        let (retry, alive) = (self.trips.retry(&self.options), self.options.alive);
        let since = |then: Option<u64>| then.map_or(u64::MAX, |then| now.saturating_sub(then));
        if self.phase == Phase::Greeting {
            let hello = ToDevice::Hello {
                version: VERSION,
                schema: SCHEMA,
                id: self.id,
            };
            let due = since(self.sent) >= retry;
            if due && self.greeted_at.is_some() {
                self.trips.repeat();
            }
            self.greeted_at = self.greeted_at.or(Some(now).filter(|_| due));
            return due.then_some((0, hello));
        }
        let number = self.number;
        if let (Phase::Open, Some(pending)) = (self.phase, &mut self.pending)
            && since(pending.sent) >= retry
        {
            if pending.sent.is_some() {
                self.trips.repeat();
            }
            pending.sent = Some(now);
            let command = pending.command;
            return Some((self.session, ToDevice::Command { number, command }));
        }
        if self.phase == Phase::Open && self.holds() {
            return None;
        }
        if let Some((time, groups)) = self.seen.take() {
            self.seen_at = Some(now);
            return Some((self.session, ToDevice::Seen { time, groups }));
        }
        if self.phase == Phase::Open
            && let Some((sequence, item)) = self.item(now, source, scratch)
        {
            return Some((self.session, ToDevice::Item { sequence, item }));
        }
        let pace = if self.phase == Phase::Open && self.answered {
            alive
        } else {
            // The controller holds if it hears nothing for a while, and a short frame costs little, unless the line is slower.
            let often = alive / 4;
            let longer = self.round_trip().map_or(self.slow, |mean| mean > often);
            retry.min(if longer { 2 * often } else { often })
        };
        // A controller that was told what was seen has heard the host, and has not answered.
        let due = since(self.sent) >= alive || since(self.sent.max(self.seen_at)) >= pace;
        due.then_some((self.session, ToDevice::Alive))
    }

    /// Returns the item to send at `now`.
    fn item<'s>(
        &mut self,
        now: u64,
        source: &impl Source,
        scratch: &'s mut [u8],
    ) -> Option<(u16, Item<'s>)> {
        // The host asks for the next frame once the line has taken the last one.
        if core::mem::take(&mut self.leaves) {
            self.progress = now;
        }
        let late = now.saturating_sub(self.progress) >= self.trips.retry(&self.options);
        if late && self.next > self.acked {
            self.trips.repeat();
            self.next = self.acked;
        }
        let refused = self.report.is_some_and(|report| report.refused.is_some());
        let bytes = (self.next - self.acked) * self.size;
        if self.next >= self.limit || refused || self.slow && bytes > self.window {
            return None;
        }
        let item = source.item(self.next, scratch)?;
        let sequence = wrapped(self.next);
        self.leaves = true;
        let repeats = self.next < self.highest;
        self.repeated += u64::from(repeats);
        if !repeats && self.trips.timed.is_none() {
            self.trips.timed = Some((self.next, now));
        }
        self.next += 1;
        self.highest = self.highest.max(self.next);
        Some((sequence, item))
    }

    /// Takes a frame that came at `now`, microseconds; returns the message if it is for this host.
    pub fn receive<'b>(&mut self, bytes: &'b [u8], now: u64) -> Option<ToHost<'b>> {
        let session = frame::session(self.options.node, bytes)?;
        let covered = match &mut self.credentials {
            None => frame::checked(bytes)?,
            Some(credentials) => credentials.take(session, bytes)?,
        };
        let message = frame::message(covered)?;
        match message {
            ToHost::Mismatch {
                id,
                version,
                schema,
            } => {
                let mine = session == 0 && id == self.id && self.phase == Phase::Greeting;
                mine.then_some(())?;
                self.phase = Phase::Failed(Failure::Version { version, schema });
            }
            ToHost::Welcome {
                id,
                session: offer,
                nonce,
                epoch,
                capacity,
            } => {
                let mine = session == 0 && id == self.id && self.phase == Phase::Greeting;
                mine.then_some(())?;
                if let Some(credentials) = &mut self.credentials {
                    credentials.welcome(nonce, offer);
                }
                self.epoch = epoch;
                self.capacity = Some(capacity);
                // The answer may be that to the last of several greetings: a loss makes no line slow.
                let time = now.saturating_sub(self.sent.unwrap_or(now));
                if self.trips.repeated == 0 {
                    self.trips.measure(time);
                }
                self.slow = time >= self.options.slow_trip;
                (self.phase, self.session, self.sent) = (Phase::Offered, offer, None);
                // The controller has to know before it sends telemetry.
                self.seen = self.slow.then_some((0, 0));
            }
            _ if session != self.session || self.phase == Phase::Greeting => return None,
            ToHost::Unknown => match self.phase {
                Phase::Offered => self.phase = Phase::Greeting,
                Phase::Open => self.phase = Phase::Failed(Failure::Lost),
                _ => return None,
            },
            ToHost::Report(report) => {
                // On a link with a key, reports come in the order in which they were sent.
                self.epoch = report.epoch;
                self.learn(report, now)?;
            }
            ToHost::Telemetry {
                time,
                first,
                angles,
                ..
            } if self.slow => {
                let groups = u16::try_from(angles.len() / 4).unwrap_or(u16::MAX);
                self.seen = Some((low_bits(time), first.saturating_add(groups)));
            }
            ToHost::Telemetry { .. } | ToHost::Measured { .. } => {}
        }
        self.heard = Some(now);
        Some(message)
    }

    /// Notes whether the line is slow. Doubles the window if little waited on the line in this round trip, and otherwise halves it.
    fn widen(&mut self, trip: u64) {
        self.slow |= self
            .round_trip()
            .is_some_and(|mean| mean >= self.options.slow_trip);
        let [least, most] = WINDOW_BYTES;
        let shortest = self.trips.least.unwrap_or(trip);
        self.window = if trip <= shortest + MAX_QUEUED_US {
            most.min(2 * self.window)
        } else {
            least.max(self.window / 2)
        };
    }

    /// Takes in a report, unless it is older than the last one.
    fn learn(&mut self, report: Report, now: u64) -> Option<()> {
        let came = u64::from(report.next.wrapping_sub(wrapped(self.acked)));
        // An old report seems to acknowledge items that were never sent.
        if came > self.highest - self.acked {
            return None;
        }
        // Before the first round trip was measured, only longer times can tell how long it takes.
        if self.trips.measured.is_some() {
            self.trips.repeated = 0;
        }
        if self.report.is_none_or(|last| last.heard != report.heard) {
            (self.answered, self.asked) = (true, None);
        }
        if self.phase == Phase::Offered {
            self.phase = Phase::Open;
        }
        if came > 0 {
            self.acked += came;
            if let Some((_, sent)) = self.trips.timed.filter(|(item, _)| *item < self.acked) {
                self.trips.timed = None;
                let time = now.saturating_sub(sent);
                self.trips.measure(time);
                self.widen(time);
            }
            self.next = self.next.max(self.acked);
            self.progress = now;
        }
        let room = u64::from(report.limit.wrapping_sub(report.next));
        self.limit = self.limit.max(self.acked + room);
        if report.gap && self.next > self.acked && self.rewound != Some(self.acked) {
            self.rewound = Some(self.acked);
            self.next = self.acked;
            self.trips.timed = None;
        }
        if report.command == self.number && self.pending.is_some() {
            (self.pending, self.answer) = (None, Some(report.denied.map_or(Ok(()), Err)));
        }
        self.report = Some(report);
        Some(())
    }
}
