//! Runs a session with a controller from the greeting to its outcome.

use core::mem::discriminant;
use std::io;

use foldpath_core::follower::{Denial, FollowerPosition, Reason, State};
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::key::Key;
use foldpath_core::wire::message::ToHost;
use foldpath_core::wire::sender::{self, Phase};

use super::link::{Link, send};
use super::telemetry::{Lag, Measured, Telemetry};
use super::{Ending, StreamPath};

/// Time in microseconds within which a controller has to report that the stop line is drawn, and after which the watcher is
/// told what slows the motion.
const PATIENCE_US: u64 = 1_000_000;

/// Decodes numbers of 4 bytes each.
fn numbers(bytes: &[u8]) -> Vec<f32> {
    let (numbers, _) = bytes.as_chunks::<4>();
    numbers.iter().copied().map(f32::from_le_bytes).collect()
}

/// Largest number of bytes that are read before the watcher is asked and frames are sent again. A controller on a fast
/// line sends fewer in a millisecond; a peer that floods the line is no controller.
pub(super) const MAX_BYTES: usize = 4096;

/// Source of the place where the sheet stands at the beginning of a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stands {
    /// The controller knows or measures it.
    #[default]
    Known,
    /// An operator has said that the sheet stands where the path begins, whatever the controller knows.
    AtStart,
    /// The controller measures it, and forgets what it knew.
    Measured,
}

/// Options of a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Options {
    /// `true` to undo whatever holds the sheet at the beginning of the session, a stop line and a fault as well, and to begin
    /// where the sheet stands instead of at the start of the path: where the controller says; and if the hinges were measured
    /// elsewhere, at the place that is [nearest](StreamPath::nearest) to what was measured, in another session. A later hold is
    /// not undone.
    pub resume: bool,
    /// `true` to resume the motion whenever it holds because the line was silent.
    pub unattended: bool,
    /// Source of the place where the sheet stands. If it is not [`Stands::Known`], the session begins at the start of the
    /// path.
    pub stands: Stands,
    /// Number of the session, different from that of any session with this controller before, and 1 above it as well.
    pub id: u32,
    /// Key that the controller has as well. Without it, a controller that has a key answers nothing.
    pub key: Option<Key>,
    /// With a key: upper half of a number of which `id` is the lower half, and which no session with this key has had.
    pub nonce: u32,
}

crate::util::changed_one_by_one!(Options);

/// Request of the watcher.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wish {
    /// The motion goes on.
    #[default]
    Run,
    /// The motion slows down along the path and holds; then the session ends.
    Stop,
    /// The motion stops at once, by the stop line if the host can draw it, and the session ends. A controller that
    /// hears nothing holds by itself.
    Quit,
}

/// Observer of a running session.
pub trait Watcher {
    /// Takes telemetry that has arrived.
    ///
    /// # Errors
    /// If the telemetry cannot be stored; the motion is held then, and the session ends.
    fn telemetry(&mut self, telemetry: &Telemetry) -> io::Result<()>;

    /// Returns the current request; called again and again.
    fn wish(&mut self) -> Wish;

    /// Notes that the motion has been slow or at rest for a second, for a reason that may pass. Called once for each reason
    /// that lasts.
    fn slowed(&mut self, _reason: Reason) {}
}

/// Outcome of a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Outcome {
    /// The sheet is at the end of the path.
    Done,
    /// The controller holds the motion, or did not begin it.
    Held,
    /// A hinge has stalled.
    Faulted,
    /// The watcher stopped the motion.
    Stopped,
    /// No controller answers, it speaks another version of the protocol, or the connection was lost.
    #[default]
    NoDevice,
}

impl Outcome {
    /// Returns the outcome's name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Held => "held",
            Self::Faulted => "faulted",
            Self::Stopped => "stopped",
            Self::NoDevice => "no_device",
        }
    }
}

/// Result of a session.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Summary {
    /// Outcome of the session.
    pub outcome: Outcome,
    /// Reason of the outcome, unless it is `Done`.
    pub reason: Option<Ending>,
    /// Number of setpoints that the controller accepted.
    pub setpoints: u64,
    /// Number of bytes on the line to the controller.
    pub bytes_sent: u64,
    /// Number of items that were sent again.
    pub retransmitted: u64,
    /// Number of items that were refused.
    pub refused: u64,
    /// Largest closure residual of an essential vertex at the angles in telemetry, once the sheet moves along the path.
    pub max_closure: f64,
    /// Largest lag of a hinge; `None` if none was measured.
    pub lag: Option<Lag>,
    /// Smoothed time of a round trip at the end, microseconds; `None` if none was measured.
    pub round_trip: Option<u64>,
    /// Duration in microseconds on the host's clock.
    pub duration: u64,
}

/// Sends a path over a link until the path is done, or until another outcome ends the session.
///
/// # Errors
/// If the watcher cannot store telemetry; the motion is held before. A broken link is an outcome.
pub fn run(
    link: &mut impl Link,
    path: &StreamPath,
    options: Options,
    watcher: &mut impl Watcher,
) -> io::Result<Summary> {
    // Only a host that goes on may stand on the reverse.
    let reverse = options.resume.then(|| path.reverse());
    let start = link.now();
    let mut session = Session {
        driver: driver(path, reverse.as_ref(), options)?,
        path,
        resume: options.resume,
        seeks: options.resume && options.stands == Stands::Known,
        wish: Wish::Run,
        last: None,
        telemetry: None,
        told: None,
        measured: vec![f32::NAN; path.hinges().len()],
        lag: None,
        denied: None,
        slowed: None,
        bytes: 0,
        closure: 0.0,
        begun: None,
        torn: None,
        quit: None,
    };
    let mut end = session.run(link, watcher)?;
    if let Some(place) = session.nearest(&end) {
        let id = options.id.wrapping_add(1);
        let driver = driver(path, reverse.as_ref(), Options { id, ..options })?;
        session.begin_again(driver.beginning_at(place));
        end = session.run(link, watcher)?;
    }
    Ok(session.summary(end, link.now() - start))
}

/// Makes the driver of a session, which may also stand on the `reverse` of the path.
fn driver<'a>(
    path: &'a StreamPath,
    reverse: Option<&'a StreamPath>,
    options: Options,
) -> io::Result<Driver<'a>> {
    let items = path.items().ok_or(io::ErrorKind::InvalidInput)?;
    let persistence = if options.resume {
        Persistence::Resume
    } else {
        Persistence::None
    };
    let mut driver = Driver::new(items, persistence, options.id, sender::Options::default());
    match options.stands {
        Stands::Known => {}
        Stands::AtStart => driver = driver.confirming(),
        Stands::Measured => driver = driver.measuring(),
    }
    if options.unattended {
        driver = driver.unattended();
    }
    if let Some(items) = reverse.and_then(StreamPath::items) {
        driver = driver.turning(items);
    }
    if let Some(key) = options.key {
        driver = driver.with_key(key, options.nonce);
    }
    Ok(driver)
}

struct Session<'a> {
    driver: Driver<'a>,
    path: &'a StreamPath,
    resume: bool,
    /// `true` if a sheet that was measured elsewhere goes on from there.
    seeks: bool,
    wish: Wish,
    /// State and rate in the last telemetry.
    last: Option<(State, f32)>,
    /// Telemetry of which pieces are missing.
    telemetry: Option<Telemetry>,
    /// Telemetry that is whole, until what was measured has come, or other telemetry.
    told: Option<Telemetry>,
    /// Newest measured angle of each hinge, radians; NaN for none.
    measured: Vec<f32>,
    /// Largest lag so far.
    lag: Option<Lag>,
    /// Time since which the controller denies to start the path.
    denied: Option<u64>,
    /// Reason that slows the motion, and the time since when; no time once the watcher knows it.
    slowed: Option<(Reason, Option<u64>)>,
    bytes: u64,
    closure: f64,
    /// Place that was told first since the sheet moves.
    begun: Option<FollowerPosition<f32>>,
    /// Time when the controller told angles on the path that do not close as the path does.
    torn: Option<u64>,
    /// `Some` once the watcher quits; inside, the time at which the stop line was drawn, if the host can draw it.
    quit: Option<Option<u64>>,
}

impl<'a> Session<'a> {
    /// Exchanges frames until the session has ended; returns its outcome and the reason.
    fn run(
        &mut self,
        link: &mut impl Link,
        watcher: &mut impl Watcher,
    ) -> io::Result<(Outcome, Option<Ending>)> {
        let mut failed = None;
        let end = loop {
            if let Err(error) = self.round(link, watcher, &mut failed) {
                let what = format!("the line: {error}");
                break (Outcome::NoDevice, Some(Ending::Line(what)));
            }
            if let Some(end) = self.end(link.now()) {
                break end;
            }
        };
        if let Some(telemetry) = self.tell().filter(|_| failed.is_none()) {
            failed = watcher.telemetry(&telemetry).err();
        }
        failed.map_or(Ok(end), Err)
    }

    /// Returns the place of the path that is nearest to the measured angles, if the session resumes, and has ended because the
    /// sheet stands elsewhere than the controller said.
    fn nearest(&self, end: &(Outcome, Option<Ending>)) -> Option<FollowerPosition<f32>> {
        let elsewhere = matches!(end.1, Some(Ending::Denied(Denial::Jump(_))));
        let knot = u32::try_from(self.driver.first_knot()).ok()?;
        let told = FollowerPosition { knot, into: 0.0 };
        let place = self.path.nearest(&self.measured, told)?;
        (elsewhere && self.seeks).then_some(place)
    }

    /// Begins another session with this driver.
    fn begin_again(&mut self, driver: Driver<'a>) {
        self.driver = driver;
        (self.last, self.telemetry, self.told) = (None, None, None);
        (self.denied, self.begun) = (None, None);
    }

    /// Asks the watcher, reads what has arrived, and sends what is due. An error of the watcher goes to `failed`, after
    /// which the motion is stopped and the watcher gets no more telemetry.
    fn round(
        &mut self,
        link: &mut impl Link,
        watcher: &mut impl Watcher,
        failed: &mut Option<io::Error>,
    ) -> io::Result<()> {
        let wish = match (&failed, watcher.wish()) {
            (Some(_), Wish::Run) => Wish::Stop,
            (_, Wish::Run) if self.torn.is_some() => Wish::Stop,
            (_, wish) => wish,
        };
        self.look(wish, link)?;
        let mut left = MAX_BYTES;
        while let Some(heard) = self.hear(link, &mut left) {
            let telemetry = heard?;
            if failed.is_none() {
                *failed = watcher.telemetry(&telemetry).err();
            }
        }
        if let Some(reason) = self.slowed(link.now()) {
            watcher.slowed(reason);
        }
        // Exchanges after reading: a host that was suspended must not mistake its own pause for silence of the
        // controller.
        self.exchange(link)
    }

    fn look(&mut self, wish: Wish, link: &mut impl Link) -> io::Result<()> {
        if wish != Wish::Run && self.wish == Wish::Run {
            self.driver.stop();
        }
        if wish == Wish::Quit && self.quit.is_none() {
            let now = link.now();
            self.quit = Some(link.stop()?.then_some(now));
        }
        self.wish = wish;
        Ok(())
    }

    /// Returns a reason that has slowed the motion for a while and may pass, unless it was returned before.
    fn slowed(&mut self, now: u64) -> Option<Reason> {
        let reason = self.driver.sender().report()?.reason;
        if reason == Reason::None || !reason.passes() {
            self.slowed = None;
            return None;
        }
        // Another hinge that lags is no other reason.
        let same = |old: &&mut (Reason, _)| discriminant(&old.0) == discriminant(&reason);
        let Some((_, since)) = self.slowed.as_mut().filter(same) else {
            self.slowed = Some((reason, Some(now)));
            return None;
        };
        let lasts = since.is_some_and(|since| now > since + PATIENCE_US);
        lasts.then(|| {
            *since = None;
            reason
        })
    }

    /// Sends all frames that are due, then waits.
    fn exchange(&mut self, link: &mut impl Link) -> io::Result<()> {
        let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
        while link.is_free() {
            let frame = self.driver.poll(link.now(), &mut scratch, &mut buffer);
            let Some(frame) = frame else { break };
            self.bytes += send(link, frame)?;
        }
        link.wait()
    }

    /// Reads bytes until the next telemetry, or until no byte is there; at most as many as are `left` in this round.
    fn hear(&mut self, link: &mut impl Link, left: &mut usize) -> Option<io::Result<Telemetry>> {
        loop {
            *left = left.checked_sub(1)?;
            let byte = match link.read() {
                Ok(byte) => byte?,
                Err(error) => return Some(Err(error)),
            };
            let now = link.now();
            let (time, state, rate, place, first, piece) = match self.driver.byte(byte, now) {
                Some(ToHost::Telemetry {
                    time,
                    state,
                    rate,
                    place,
                    first,
                    angles,
                }) => (time, state, rate, place, first, numbers(angles)),
                Some(ToHost::Measured {
                    time,
                    first,
                    angles,
                    ..
                }) => {
                    let (first, angles) = (usize::from(first), numbers(angles));
                    for (measured, angle) in self.measured.iter_mut().skip(first).zip(&angles) {
                        *measured = *angle;
                    }
                    if let Some(told) = self.told.as_mut().filter(|told| told.time == time) {
                        told.measured = Measured { first, angles };
                        return self.tell().map(Ok);
                    }
                    continue;
                }
                _ => continue,
            };
            self.last = Some((state, rate));
            let before = self.tell().map(Ok);
            // Pieces of one moment follow each other; without the first one they are dropped.
            let mut angles = match self.telemetry.take() {
                Some(begun) if first > 0 && begun.time == time => begun.angles,
                _ => Vec::new(),
            };
            if angles.len() != usize::from(first) {
                if before.is_some() {
                    return before;
                }
                continue;
            }
            angles.extend(piece);
            let whole = angles.is_empty() || angles.len() >= self.path.groups();
            let telemetry = Telemetry {
                time,
                state,
                rate,
                place,
                angles,
                measured: Measured::default(),
                lag: None,
                retransmitted: 0,
                round_trip: None,
            };
            if whole {
                self.judge(&telemetry, now);
                self.told = Some(telemetry);
            } else {
                self.telemetry = Some(telemetry);
            }
            if before.is_some() {
                return before;
            }
        }
    }

    /// Takes the closure residual of angles that were told at `now`, microseconds.
    fn judge(&mut self, told: &Telemetry, now: u64) {
        let runs = told.state == State::Running;
        // Before the place moves the groups approach it, and need not close.
        let begun = *self.begun.get_or_insert(told.place);
        if !runs {
            self.begun = None;
        } else if told.place == begun {
            return;
        }
        let closure = self.path.residual(&told.angles);
        self.closure = self.closure.max(closure);
        let follows = runs || told.state == State::Done;
        if follows && closure > self.path.max_reported_closure() {
            self.torn.get_or_insert(now);
        }
    }

    /// Returns the telemetry that was waiting for what was measured, with the state of the line.
    fn tell(&mut self) -> Option<Telemetry> {
        let mut told = self.told.take()?;
        told.lag = told.worst_lag(self.path);
        let farther = |lag: &Lag| self.lag.is_none_or(|worst| lag.angle > worst.angle);
        self.lag = told.lag.filter(farther).or(self.lag);
        let sender = self.driver.sender();
        (told.retransmitted, told.round_trip) = (sender.repeated(), sender.round_trip());
        Some(told)
    }

    /// Returns the outcome and its reason, if the session has ended.
    fn end(&mut self, now: u64) -> Option<(Outcome, Option<Ending>)> {
        if let Phase::Failed(failure) = self.driver.sender().phase() {
            return Some((Outcome::NoDevice, Some(Ending::NoSession(failure))));
        }
        if let Some(drawn) = self.quit {
            let report = self.driver.sender().report();
            let stands = report.is_none_or(|report| report.stopped);
            let reason = match drawn {
                None => Ending::Left,
                Some(_) if stands => Ending::Quit { reported: true },
                Some(drawn) if now > drawn + PATIENCE_US => Ending::Quit { reported: false },
                Some(_) => return None,
            };
            return Some((Outcome::Stopped, Some(reason)));
        }
        // Waits for the telemetry at the end of the path, so that the log is complete.
        if self.driver.is_done() && self.last.is_some_and(|(state, _)| state == State::Done) {
            return Some((Outcome::Done, None));
        }
        let end = self.obstacle(now)?;
        Some((end.0, Some(end.1)))
    }

    /// Returns the outcome and its reason if the motion cannot go on, once the sheet is at rest.
    fn obstacle(&mut self, now: u64) -> Option<(Outcome, Ending)> {
        let sender = self.driver.sender();
        let Some(report) = sender.report() else {
            let gone = self.wish == Wish::Stop;
            return gone.then_some((Outcome::Stopped, Ending::NotBegun));
        };
        let (state, reason) = (report.state, report.reason);
        if let Some(since) = self.torn {
            // A controller that does not obey is left to hold by itself.
            let over = state != State::Running || now > since + PATIENCE_US;
            return over.then_some((Outcome::Faulted, Ending::Torn(self.closure)));
        }
        let recovers = self.resume && !self.driver.is_started();
        if state == State::Faulted {
            let stopped = report.stopped;
            return (!recovers).then_some((Outcome::Faulted, Ending::Failed { reason, stopped }));
        }
        let rests = match state {
            State::Running => false,
            State::Holding => self
                .last
                .is_some_and(|(state, rate)| state == State::Holding && rate <= 0.0),
            _ => true,
        };
        if !rests {
            return None;
        }
        if let Some(place) = self.driver.off_path() {
            return Some((Outcome::Held, Ending::OffPath(place.knot)));
        }
        if let Some(item) = report.refused {
            let (knot, room) = (self.knot(), sender.capacity().unwrap_or_default());
            return Some((Outcome::Held, Ending::Refused { item, knot, room }));
        }
        let refuses = sender.answer() == Some(Err(Denial::Held));
        if report.stopped && (!recovers || refuses) {
            return Some((Outcome::Held, Ending::Held(Reason::StopLine)));
        }
        if self.wish == Wish::Stop && (state != State::Ready || reason != Reason::None) {
            return Some((Outcome::Stopped, Ending::Stopped));
        }
        if let Some(reason) = self.driver.held() {
            return Some((Outcome::Held, Ending::Held(reason)));
        }
        let Some(Err(why)) = sender.answer().filter(|_| state == State::Ready) else {
            return None;
        };
        match why {
            Denial::Place | Denial::Empty | Denial::Nonce => {
                Some((Outcome::Held, Ending::Denied(why)))
            }
            Denial::Jump(_) if !self.seeks => Some((Outcome::Held, Ending::Denied(why))),
            // The controller may need a while to measure all hinges and to tell of them, or for whatever else it denies a start.
            _ => {
                let since = *self.denied.get_or_insert(now);
                (now > since + PATIENCE_US).then_some((Outcome::Held, Ending::Denied(why)))
            }
        }
    }

    /// Returns the number of the knot that the controller has to accept next.
    fn knot(&self) -> u64 {
        self.driver.first_knot() + self.driver.setpoints()
    }

    fn summary(&self, (outcome, reason): (Outcome, Option<Ending>), duration: u64) -> Summary {
        let sender = self.driver.sender();
        let refused = sender.report().is_some_and(|r| r.refused.is_some());
        Summary {
            outcome,
            reason,
            setpoints: self.driver.setpoints(),
            bytes_sent: self.bytes,
            retransmitted: sender.repeated(),
            refused: refused.into(),
            max_closure: self.closure,
            lag: self.lag,
            round_trip: sender.round_trip(),
            duration,
        }
    }
}
