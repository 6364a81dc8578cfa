//! The policy of a host: sends a path from the place where it is to begin, starts it, and undoes what holds it, as far as
//! its [`Persistence`] says.

use crate::follower::{FollowerPosition, Reason, State};
use crate::wire::cobs::Deframer;
use crate::wire::key::Key;
use crate::wire::message::{Command, Report, ToHost};
use crate::wire::path::PathItems;
use crate::wire::sender::{Options, Phase, Sender};

/// Time between two commands, microseconds. Meanwhile reports show what the first one has done.
const COMMAND_INTERVAL_US: u64 = 100_000;
/// Length of the longest frame from a controller, bytes.
const MAX_FRAME_BYTES: usize = 512;

/// Holds that a host undoes: it sends `Resume`, and `Clear` after a fault. [`Driver::held`] tells what holds the motion and
/// is not undone; unless that is the stop line alone, the host then sends nothing but signs of life.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Persistence {
    /// Begins at the start of the path, and undoes nothing.
    #[default]
    None,
    /// Begins at the place where the sheet stands, and undoes whatever holds it at the beginning of the session, a stop line
    /// and a fault as well. Once the path has started, it undoes nothing.
    Resume,
    /// As [`Resume`](Persistence::Resume), and goes on undoing whatever holds the motion.
    Always,
}

/// A host: its policy over a [`Sender`].
#[derive(Clone, Debug)]
pub struct Driver<'a> {
    sender: Sender,
    deframer: Deframer<MAX_FRAME_BYTES>,
    persistence: Persistence,
    path: PathItems<'a>,
    /// Reverse of the path.
    reverse: Option<PathItems<'a>>,
    /// Place at which to begin, if the host has chosen it.
    chosen: Option<FollowerPosition<f32>>,
    /// Items to send: none until it is known where to begin.
    current: Option<PathItems<'a>>,
    /// Position that the controller told, if it is not on the path.
    off_path: Option<FollowerPosition<f32>>,
    started: bool,
    stopping: bool,
    /// `true` until the operator's word was passed on that the sheet stands where the path begins.
    confirms: bool,
    /// `true` if the controller has to forget where the sheet stands, and to measure it.
    measures: bool,
    /// `true` if the host resumes whenever the line was silent.
    unattended: bool,
    asked: Option<u64>,
}

impl<'a> Driver<'a> {
    /// Creates a host that sends all knots of this path. For `id`, see [`Sender::new`].
    #[must_use]
    pub fn new(path: PathItems<'a>, persistence: Persistence, id: u32, options: Options) -> Self {
        Self {
            sender: Sender::new(id, options),
            deframer: Deframer::default(),
            persistence,
            path,
            reverse: None,
            chosen: None,
            current: None,
            off_path: None,
            started: false,
            stopping: false,
            confirms: false,
            measures: false,
            unattended: false,
            asked: None,
        }
    }

    /// Passes on the operator's word that the sheet stands where the path begins, whatever the controller knows.
    #[must_use]
    pub fn confirming(self) -> Self {
        Self {
            confirms: true,
            ..self
        }
    }

    /// Lets the controller forget where the sheet stands, so that it has to measure it.
    #[must_use]
    pub fn measuring(self) -> Self {
        Self {
            measures: true,
            ..self
        }
    }

    /// Resumes whenever the controller did not hear a host for a while, however persistent the host is.
    #[must_use]
    pub fn unattended(self) -> Self {
        Self {
            unattended: true,
            ..self
        }
    }

    /// Goes on from the mirrored place if the sheet stands on this path, the reverse of the path that is sent, and the
    /// host begins where the sheet stands.
    #[must_use]
    pub fn turning(self, reverse: PathItems<'a>) -> Self {
        Self {
            reverse: Some(reverse),
            ..self
        }
    }

    /// Begins at this place of the path, wherever the controller says that the sheet stands.
    #[must_use]
    pub fn beginning_at(self, place: FollowerPosition<f32>) -> Self {
        Self {
            chosen: Some(place),
            ..self
        }
    }

    /// Protects all frames by a key; see [`Sender::with_key`].
    #[must_use]
    pub fn with_key(self, key: Key, nonce: u32) -> Self {
        Self {
            sender: self.sender.with_key(key, nonce),
            ..self
        }
    }

    /// Returns the host's end of the line.
    #[must_use]
    pub fn sender(&self) -> &Sender {
        &self.sender
    }

    /// Returns the number of setpoints that the controller has taken.
    #[must_use]
    pub fn setpoints(&self) -> u64 {
        let head = self.current.map_or(u64::MAX, |items| items.head() as u64);
        let items = self.sender.acknowledged().saturating_sub(head);
        items / self.path.pieces() as u64
    }

    /// Returns the number of the knot that was sent first.
    #[must_use]
    pub fn first_knot(&self) -> u64 {
        self.current.map_or(0, |items| items.first() as u64)
    }

    /// Returns the place where the sheet stands, if it is not on the path.
    #[must_use]
    pub fn off_path(&self) -> Option<FollowerPosition<f32>> {
        self.off_path
    }

    /// Returns `true` if the whole path was sent, and the controller is at its end.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.is_sent() && self.sender.report().is_some_and(|r| r.state == State::Done)
    }

    /// Returns `true` if this path was started.
    #[must_use]
    pub fn is_started(&self) -> bool {
        self.started
    }

    /// Returns the reason that holds the motion until a host resumes it, if this host does not.
    #[must_use]
    pub fn held(&self) -> Option<Reason> {
        let report = self.sender.report()?;
        (is_latched(report.reason) && !self.undoes(report)).then_some(report.reason)
    }

    /// From now on slows the motion down and holds it, instead of resuming it.
    pub fn stop(&mut self) {
        (self.stopping, self.asked) = (true, None);
    }

    /// Takes a byte that came at `now`, microseconds; returns the message that it ends.
    pub fn byte(&mut self, byte: u8, now: u64) -> Option<ToHost<'_>> {
        let frame = self.deframer.push(byte)?;
        let message = self.sender.receive(frame, now)?;
        if let ToHost::Report(report) = message {
            let moves = matches!(report.state, State::Running | State::Done);
            let head = self.current.map(|items| items.head() as u64);
            self.started |= moves && head.is_some_and(|head| self.sender.acknowledged() > head);
        }
        Some(message)
    }

    /// Writes the next frame for the line to `buffer`, as [`Sender::poll`] gives it.
    pub fn poll<'b>(
        &mut self,
        now: u64,
        scratch: &mut [u8],
        buffer: &'b mut [u8],
    ) -> Option<&'b [u8]> {
        if self.sender.phase() == Phase::Open
            && let Some(report) = self.sender.report().copied()
        {
            self.begin(&report);
            let wait = |asked| now < asked + COMMAND_INTERVAL_US;
            let command = self.wanted(&report);
            if let Some(command) = command.filter(|_| !self.asked.is_some_and(wait))
                && self.sender.command(command)
            {
                self.confirms &= command != Command::Stand;
                self.asked = Some(now);
            }
        }
        self.sender.poll(now, &self.current, scratch, buffer)
    }

    /// Chooses the place to begin at, once the sheet is at rest. While the sheet moves on an old path there is no room,
    /// and the place told is not the last one. A fault has to be cleared before.
    fn begin(&mut self, report: &Report) {
        let rests = report.limit != report.next && report.state != State::Faulted;
        if self.current.is_some() || !rests || self.stopping || self.is_kept_out() {
            return;
        }
        // A controller that was on no path yet begins as well at the start.
        let is_placed_anew = self.confirms || self.measures;
        let begins = self.persistence == Persistence::None || is_placed_anew || report.path == 0;
        let place = if self.chosen.is_some() {
            self.chosen
        } else if begins {
            Some(FollowerPosition::default())
        } else if report.path == self.path.identity() {
            Some(report.place)
        } else {
            let turns = self.reverse.map(|path| path.identity()) == Some(report.path);
            self.path.mirrored(report.place).filter(|_| turns)
        };
        self.current = place.and_then(|place| self.path.at(place));
        self.off_path = self.current.is_none().then_some(report.place);
    }

    /// Returns `true` if the host undoes whatever holds the motion, a stop line and a fault as well.
    fn recovers(&self) -> bool {
        match self.persistence {
            Persistence::None => false,
            Persistence::Resume => !self.started,
            Persistence::Always => true,
        }
    }

    /// Returns `true` if the host resumes the motion, which is held for the reason of this report.
    fn undoes(&self, report: &Report) -> bool {
        match report.reason {
            Reason::Silence => self.unattended || self.recovers(),
            // The refused setpoint belongs to the path of an earlier session.
            Reason::Refused(_) => self.recovers() && !self.started && report.refused.is_none(),
            reason => is_latched(reason) && self.recovers(),
        }
    }

    /// Returns `true` if all items were sent and have come.
    fn is_sent(&self) -> bool {
        let items = self.current.map(|items| items.count() as u64);
        items == Some(self.sender.acknowledged())
    }

    /// Returns the command to send next, if any.
    fn wanted(&self, report: &Report) -> Option<Command> {
        if self.stopping {
            let held = !report.reason.passes();
            // A controller that is ready may have a start on its way to it, and one that holds a `Resume`.
            let under_way = matches!(report.state, State::Ready | State::Running | State::Holding);
            let held = held && !self.sender.is_asking();
            return (under_way && !held).then_some(Command::Hold);
        }
        if report.state == State::Faulted {
            return self.recovers().then_some(Command::Clear);
        }
        self.current?;
        if self.undoes(report) {
            return Some(Command::Resume);
        }
        // The controller's queue is as full as it can be, or the rest of the path is before the command on the line. If a
        // setpoint of the rest gets lost, the motion waits for it at the last one before it.
        let items = self.current.map(|items| items.count() as u64);
        let full = items == Some(self.sender.under_way()) || report.limit == report.next;
        let command = if report.known && (self.confirms || self.measures) {
            Command::Forget
        } else if self.confirms {
            Command::Stand
        } else {
            Command::Start
        };
        (report.state == State::Ready && full && !self.is_kept_out()).then_some(command)
    }

    /// Returns `true` if somebody else holds the motion, so that the host leaves it as it is. A stop line alone does not
    /// keep the host from sending the sheet: hinges without a command after a reset have one again then.
    fn is_kept_out(&self) -> bool {
        self.held().is_some_and(|reason| reason != Reason::StopLine)
    }
}

/// Returns `true` if a follower holds for this reason until a host resumes the motion.
fn is_latched(reason: Reason) -> bool {
    !(reason.passes() || matches!(reason, Reason::Fault(_)))
}
