//! Commissioning: a session that watches and moves one hinge at a time, without a path.

use std::io;

use foldpath_core::follower::{Denial, State};
use foldpath_core::wire::cobs::Deframer;
use foldpath_core::wire::key::Key;
use foldpath_core::wire::message::{Command, ToHost};
use foldpath_core::wire::sender::{self, Failure, Phase, Sender};
use thiserror::Error;

use super::link::{Link, Nothing, send};
use super::session::MAX_BYTES;

/// Time for a message that tells of a hinge, microseconds. A controller tells every 20 ms, and less often on a slow line.
const PATIENCE_US: u64 = 500_000;

/// Angles of the hinge that is watched or moved, radians, with the sign of the hinge itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Number of the hinge.
    pub hinge: u16,
    /// Commanded angle, if the hinge was moved.
    pub commanded: Option<f32>,
    /// Measured angle, if there is one. NaN tells of a sensor that has failed.
    pub measured: Option<f32>,
}

impl Seen {
    /// Returns the angle at which the hinge stands: the measured angle, or else the commanded one.
    #[must_use]
    pub fn angle(&self) -> Option<f32> {
        self.measured.or(self.commanded)
    }
}

/// Angle to which a hinge is moved, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// To this angle.
    To(f32),
    /// By this angle, from where it stands.
    By(f32),
}

/// Outcome of [`Bench::jog`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Jogged {
    /// The hinge is commanded to be where it was to move.
    There(Seen),
    /// The motion was held, as was asked.
    Held(Seen),
    /// The motion ended before: the hinge does not follow, or the stop line was drawn.
    Ended(Seen),
}

/// Reason why a command was not carried out.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BenchError {
    /// The line is broken.
    #[error("the line: {0}")]
    Line(#[from] io::Error),
    /// There is no session with the controller.
    #[error(transparent)]
    NoSession(Failure),
    /// The controller has denied the command.
    #[error("{denial}")]
    Denied {
        /// Why.
        denial: Denial,
        /// State of the controller, if it has told one.
        state: Option<State>,
        /// Number of hinges for which the controller has room.
        hinges: u16,
    },
}

/// A session with a controller that has no path.
pub struct Bench<L> {
    link: L,
    sender: Sender,
    deframer: Deframer<512>,
    /// The hinge that is watched or moved, and the time when it was last told, microseconds.
    seen: Option<(Seen, u64)>,
}

impl<L: Link> Bench<L> {
    /// Opens a session. `id` and `nonce` are those of [`Options`](super::Options).
    ///
    /// # Errors
    /// If the line breaks, or no controller answers.
    pub fn open(link: L, key: Option<Key>, id: u32, nonce: u32) -> Result<Self, BenchError> {
        let sender = Sender::new(id, sender::Options::default());
        let mut this = Self {
            link,
            sender: match key {
                Some(key) => sender.with_key(key, nonce),
                None => sender,
            },
            deframer: Deframer::default(),
            seen: None,
        };
        while this.sender.report().is_none() {
            this.round()?;
        }
        Ok(this)
    }

    /// Sends and takes what is due, and waits for at most a millisecond. It has to be called again and again, also while
    /// there is nothing to do: a controller that hears nothing ends the motion.
    ///
    /// # Errors
    /// If the line breaks, or the session is over.
    pub fn round(&mut self) -> Result<(), BenchError> {
        let (mut scratch, mut buffer) = ([0; 64], [0; 64]);
        while self.link.is_free() {
            let now = self.link.now();
            let frame = self.sender.poll(now, &Nothing, &mut scratch, &mut buffer);
            let Some(frame) = frame else { break };
            send(&mut self.link, frame)?;
        }
        self.link.wait()?;
        for _ in 0..MAX_BYTES {
            let Some(byte) = self.link.read()? else { break };
            let now = self.link.now();
            let Some(frame) = self.deframer.push(byte) else {
                continue;
            };
            if let Some(ToHost::Measured {
                first,
                target,
                angles,
                ..
            }) = self.sender.receive(frame, now)
                && let Some((seen, told)) = &mut self.seen
                && seen.hinge == first
            {
                let (angles, _) = angles.as_chunks::<4>();
                seen.measured = angles.first().copied().map(f32::from_le_bytes);
                (seen.commanded, *told) = (target, now);
                // A hinge that is moved without a sensor is told with no number.
                if target.is_some() {
                    seen.measured = seen.measured.filter(|angle| !angle.is_nan());
                }
            }
        }
        if let Phase::Failed(failure) = self.sender.phase() {
            return Err(BenchError::NoSession(failure));
        }
        Ok(())
    }

    /// Sends a command and waits for its answer.
    fn ask(&mut self, command: Command) -> Result<Result<(), Denial>, BenchError> {
        while !self.sender.command(command) {
            self.round()?;
        }
        loop {
            if let Some(answer) = self.sender.answer() {
                return Ok(answer);
            }
            self.round()?;
        }
    }

    /// Asks for a hinge to be watched, or moved to an angle. `from` is where an operator says that it stands.
    fn ask_jog(
        &mut self,
        hinge: u16,
        from: Option<f32>,
        to: Option<f32>,
    ) -> Result<(), BenchError> {
        let answer = self.ask(Command::Jog { hinge, from, to })?;
        answer.map_err(|denial| self.denied(denial))
    }

    /// Returns a denial with what the controller has told of itself.
    fn denied(&self, denial: Denial) -> BenchError {
        let state = self.sender.report().map(|report| report.state);
        let hinges = self.sender.capacity().unwrap_or_default().hinges;
        BenchError::Denied {
            denial,
            state,
            hinges,
        }
    }

    /// Waits for the next word of the watched hinge.
    fn look(&mut self) -> Result<Seen, BenchError> {
        let begun = self.link.now();
        loop {
            self.round()?;
            let (seen, told) = self.seen.unwrap_or_default();
            if told > begun || self.link.now() > begun + PATIENCE_US {
                return Ok(seen);
            }
        }
    }

    /// Watches a hinge. Nothing moves. Another hinge that was moved before has no command any more.
    ///
    /// # Errors
    /// If the controller has a path or a fault, if there is no such hinge, or if there is no session any more.
    pub fn watch(&mut self, hinge: u16) -> Result<Seen, BenchError> {
        self.ask_jog(hinge, None, None)?;
        if self.seen.is_none_or(|(seen, _)| seen.hinge != hinge) {
            let seen = Seen {
                hinge,
                ..Seen::default()
            };
            self.seen = Some((seen, 0));
        }
        self.look()
    }

    /// Returns the angle (radians) at which [`jog`](Self::jog) would end.
    ///
    /// # Errors
    /// If nobody knows where the hinge stands, if it cannot be watched, or if there is no session any more.
    pub fn end_of(&mut self, hinge: u16, from: Option<f32>, way: Way) -> Result<f32, BenchError> {
        let seen = self.watch(hinge)?;
        Ok(match way {
            Way::To(angle) => angle,
            Way::By(angle) => {
                let measured = seen.measured.filter(|angle| angle.is_finite());
                let begin = seen.commanded.or(measured).or(from);
                let unknown = Denial::Unknown(hinge);
                angle + begin.ok_or_else(|| self.denied(unknown))?
            }
        })
    }

    /// Moves a hinge slowly, until it is there, or until `stops` returns `true`. `from` is where an operator says that it
    /// stands, for a hinge that is not measured.
    ///
    /// # Errors
    /// If nobody knows where the hinge stands, if the controller denies the motion, or if there is no session any more.
    pub fn jog(
        &mut self,
        hinge: u16,
        from: Option<f32>,
        way: Way,
        stops: &dyn Fn() -> bool,
    ) -> Result<Jogged, BenchError> {
        let to = self.end_of(hinge, from, way)?;
        let (seen, _) = self.seen.unwrap_or_default();
        self.ask_jog(hinge, from, Some(to))?;
        let bits = |seen: Seen| seen.commanded.map(f32::to_bits);
        let (mut last, mut since) = (bits(seen), self.link.now());
        loop {
            self.round()?;
            let (seen, told) = self.seen.unwrap_or_default();
            if bits(seen) == Some(to.to_bits()) {
                return Ok(Jogged::There(seen));
            }
            if stops() {
                // The motion ends whatever is answered.
                let _ = self.ask(Command::Hold)?;
                return Ok(Jogged::Held(self.look()?));
            }
            if bits(seen) != last {
                (last, since) = (bits(seen), told);
            }
            // Told again and again, and always of the same angle; or not told at all.
            let now = self.link.now();
            if told > since + PATIENCE_US || now > told.max(since) + 4 * PATIENCE_US {
                return Ok(Jogged::Ended(seen));
            }
        }
    }

    /// Tells where the hinge that is watched stands now; watches it before, if it is another.
    ///
    /// # Errors
    /// As [`watch`](Self::watch).
    pub fn place(&mut self, hinge: u16) -> Result<Seen, BenchError> {
        if self.seen.is_some_and(|(seen, _)| seen.hinge == hinge) {
            self.look()
        } else {
            self.watch(hinge)
        }
    }

    /// Leaves a fault and a stop line behind, drops the path, and forgets where the sheet stands. Nothing moves.
    ///
    /// # Errors
    /// If the sheet still moves, if the stop line is drawn, or if there is no session any more.
    pub fn clear(&mut self) -> Result<(), BenchError> {
        if self
            .sender
            .report()
            .is_some_and(|report| report.state == State::Faulted)
        {
            self.ask(Command::Clear)?
                .map_err(|denial| self.denied(denial))?;
        }
        // The path goes before the hold, so that nothing can move.
        for command in [Command::Forget, Command::Resume] {
            self.ask(command)?.map_err(|denial| self.denied(denial))?;
        }
        Ok(())
    }
}
