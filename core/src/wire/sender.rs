//! The host's end of the line.
//!
//! Go-back-N with cumulative acknowledgement: what is lost is sent again from the first item that has not come,
//! when the controller says once that there is a gap, or when it has said nothing new for a while. Items are asked of
//! a [`Source`] again instead of being kept.

use crate::follower::Denial;
use crate::wire::frame;
use crate::wire::message::{Command, Item, Report, SCHEMA, ToDevice, ToHost, VERSION};
use crate::wire::sequence::wrapped;

/// What is to be sent.
pub trait Source {
    /// Item number `index` from 0, its bytes in `scratch`; nothing behind the last, or if there is no room.
    fn item<'b>(&self, index: u64, scratch: &'b mut [u8]) -> Option<Item<'b>>;
}

/// Options of a [`Sender`], in microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Time after which what was not acknowledged is sent again.
    pub retry: u64,
    /// Longest time between two frames, if the last one was answered.
    pub alive: u64,
    /// Silence of the controller after which it is given up.
    pub silence: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            retry: 30_000,
            alive: 200_000,
            silence: 5_000_000,
        }
    }
}

/// How far a session is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The controller has not answered.
    Greeting,
    /// It has offered a session.
    Offered,
    /// Items and commands go through.
    Open,
    /// There is no session.
    Failed(Failure),
}

/// Why there is no session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The controller speaks this version of the protocol.
    Version {
        /// [`VERSION`] of the controller.
        version: u16,
        /// [`SCHEMA`] of the controller.
        schema: u32,
    },
    /// The controller does not know the session any more: it was reset, or another host has come.
    Lost,
    /// The controller is silent.
    Silent,
}

/// A command on its way.
#[derive(Clone, Copy, Debug)]
struct Pending {
    command: Command,
    sent: Option<u64>,
}

/// The state machine of the host's end.
#[derive(Clone, Debug)]
pub struct Sender {
    options: Options,
    id: u32,
    phase: Phase,
    session: u32,
    /// Items that have come, that are sent next, that were ever sent, and for which there is room.
    acked: u64,
    next: u64,
    highest: u64,
    limit: u64,
    /// The gap that was answered last.
    rewound: Option<u64>,
    repeated: u64,
    /// When the controller last took an item or the oldest one was sent.
    progress: u64,
    sent: Option<u64>,
    /// Whether a report has since told of one more frame.
    answered: bool,
    heard: Option<u64>,
    number: u8,
    pending: Option<Pending>,
    answer: Option<Result<(), Denial>>,
    report: Option<Report>,
}

impl Sender {
    /// A host that wants a session. Its `id` is one that it has not used before, as a random number.
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
            repeated: 0,
            progress: 0,
            sent: None,
            answered: false,
            heard: None,
            number: 0,
            pending: None,
            answer: None,
            report: None,
        }
    }

    /// How far the session is.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Items that have come.
    #[must_use]
    pub fn acknowledged(&self) -> u64 {
        self.acked
    }

    /// Items that were sent again.
    #[must_use]
    pub fn repeated(&self) -> u64 {
        self.repeated
    }

    /// What the controller said last. While it has refused an item, none are sent.
    #[must_use]
    pub fn report(&self) -> Option<&Report> {
        self.report.as_ref()
    }

    /// Asks for a command; `false` while the one before has not been answered.
    pub fn command(&mut self, command: Command) -> bool {
        let free = self.pending.is_none();
        if free {
            self.number = self.number.wrapping_add(1);
            let sent = None;
            (self.pending, self.answer) = (Some(Pending { command, sent }), None);
        }
        free
    }

    /// How the last command ended; nothing while it is on its way.
    #[must_use]
    pub fn answer(&self) -> Option<Result<(), Denial>> {
        self.answer
    }

    /// Sends the refused item again, which its source has changed.
    pub fn amend(&mut self) {
        if let Some(report) = &mut self.report {
            report.refused = None;
        }
        self.next = self.acked;
    }

    /// The next frame to send at `now`, microseconds, in `buffer`; nothing if it is not time, or the buffers are
    /// too small.
    pub fn poll<'b>(
        &mut self,
        now: u64,
        source: &impl Source,
        scratch: &mut [u8],
        buffer: &'b mut [u8],
    ) -> Option<&'b [u8]> {
        let heard = *self.heard.get_or_insert(now);
        if matches!(self.phase, Phase::Failed(_)) {
            return None;
        }
        if now.saturating_sub(heard) > self.options.silence {
            self.phase = Phase::Failed(Failure::Silent);
            return None;
        }
        let (session, message) = self.message(now, source, scratch)?;
        (self.sent, self.answered) = (Some(now), false);
        frame::seal(session, &message, buffer)
    }

    /// What to say at `now`, and in which session.
    fn message<'s>(
        &mut self,
        now: u64,
        source: &impl Source,
        scratch: &'s mut [u8],
    ) -> Option<(u32, ToDevice<'s>)> {
        let Options { retry, alive, .. } = self.options;
        let since = |then: Option<u64>| then.map_or(u64::MAX, |then| now.saturating_sub(then));
        if self.phase == Phase::Greeting {
            let hello = ToDevice::Hello {
                version: VERSION,
                schema: SCHEMA,
                id: self.id,
            };
            return (since(self.sent) >= retry).then_some((0, hello));
        }
        let number = self.number;
        if let (Phase::Open, Some(pending)) = (self.phase, &mut self.pending)
            && since(pending.sent) >= retry
        {
            pending.sent = Some(now);
            let command = pending.command;
            return Some((self.session, ToDevice::Command { number, command }));
        }
        if self.phase == Phase::Open
            && let Some((sequence, item)) = self.item(now, source, scratch)
        {
            return Some((self.session, ToDevice::Item { sequence, item }));
        }
        let pace = if self.phase == Phase::Open && self.answered {
            alive
        } else {
            retry
        };
        (since(self.sent) >= pace).then_some((self.session, ToDevice::Alive))
    }

    /// The item to send at `now`.
    fn item<'s>(
        &mut self,
        now: u64,
        source: &impl Source,
        scratch: &'s mut [u8],
    ) -> Option<(u16, Item<'s>)> {
        let late = now.saturating_sub(self.progress) >= self.options.retry;
        if late && self.next > self.acked {
            self.next = self.acked;
        }
        let refused = self.report.is_some_and(|report| report.refused.is_some());
        if self.next >= self.limit || refused {
            return None;
        }
        let item = source.item(self.next, scratch)?;
        let sequence = wrapped(self.next);
        if self.next == self.acked {
            self.progress = now;
        }
        self.repeated += u64::from(self.next < self.highest);
        self.next += 1;
        self.highest = self.highest.max(self.next);
        Some((sequence, item))
    }

    /// Takes a frame that came at `now`; returns the message if it is for this host.
    pub fn receive<'b>(&mut self, bytes: &'b [u8], now: u64) -> Option<ToHost<'b>> {
        let (session, message) = frame::open(bytes)?;
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
            ToHost::Welcome { id, session: offer } => {
                let mine = session == 0 && id == self.id && self.phase == Phase::Greeting;
                mine.then_some(())?;
                (self.phase, self.session, self.sent) = (Phase::Offered, offer, None);
            }
            _ if session != self.session || self.phase == Phase::Greeting => return None,
            ToHost::Unknown => match self.phase {
                Phase::Offered => self.phase = Phase::Greeting,
                Phase::Open => self.phase = Phase::Failed(Failure::Lost),
                _ => return None,
            },
            ToHost::Report(report) => self.learn(report, now)?,
            ToHost::Telemetry { .. } => {}
        }
        self.heard = Some(now);
        Some(message)
    }

    /// Takes in a report unless it is older than what is known.
    fn learn(&mut self, report: Report, now: u64) -> Option<()> {
        let came = u64::from(report.next.wrapping_sub(wrapped(self.acked)));
        // An old one seems to acknowledge what was never sent.
        if came > self.highest - self.acked {
            return None;
        }
        self.answered |= self.report.is_none_or(|last| last.heard != report.heard);
        if self.phase == Phase::Offered {
            self.phase = Phase::Open;
        }
        if came > 0 {
            self.acked += came;
            self.next = self.next.max(self.acked);
            self.progress = now;
        }
        let room = u64::from(report.limit.wrapping_sub(report.next));
        self.limit = self.limit.max(self.acked + room);
        if report.gap && self.next > self.acked && self.rewound != Some(self.acked) {
            self.rewound = Some(self.acked);
            self.next = self.acked;
        }
        if report.command == self.number && self.pending.is_some() {
            (self.pending, self.answer) = (None, Some(report.denied.map_or(Ok(()), Err)));
        }
        self.report = Some(report);
        Some(())
    }
}
