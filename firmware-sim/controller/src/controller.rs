//! The controller without its board: bytes of the line and ticks of the clock go in, angles and bytes come out.
//!
//! On a board [`Application`](crate::Application) [restores](Controller::restore) what a reset has left,
//! hands over received bytes ([`Controller::byte`]), calls [`Controller::tick`] at a steady pace, powers and
//! [drives](Controller::drive) the hinges, keeps the [record](Controller::record), calls [`Controller::poll`] and
//! [takes](Controller::take) bytes for the line. Times are microseconds on the controller's clock.

use core::num::NonZero;

use foldpath_core::follower::{
    CheckedOptions, Denial, Fault, Follower, Measurement, Reason, State, Target,
};
use foldpath_core::wire::cobs::{self, Deframer};
use foldpath_core::wire::key::Key;
use foldpath_core::wire::low_bits;
use foldpath_core::wire::message::{Capacity, Command, ItemRefusal, Report, ToHost};
use foldpath_core::wire::protection::{Keyed, Protection, Unkeyed};
use foldpath_core::wire::receiver::{Event, Identity, Receiver};
use foldpath_core::wire::transmit::Ring;
use foldpath_core::{GroupId, GroupLimits, Membership};

use crate::loader::Loader;
use crate::power::Power;
use crate::retained::{self, Record};
use crate::sheet::Sheet;
use crate::snapshot::Snapshot;
use crate::window::Window;

/// Length of the longest frame, bytes.
pub const FRAME: usize = 256;
/// Largest number of bytes that wait for the line.
pub const WAITING: usize = 512;
/// Bytes of the ring that telemetry leaves free for answers: four reports, or three of the longest ones with a key, which have
/// 65 bytes.
const RESERVE_BYTES: usize = 4 * cobs::longest(64);
/// Shortest time between two answers that are no reports, on a link with room for a key, microseconds. Otherwise greetings
/// that somebody plays back would leave no room for telemetry, which is sent only while the line is free.
const MIN_GREETING_US: u64 = 50_000;
/// Longest wait for a host that tells what it has seen, microseconds. After four times as long as the last one took, or then, its
/// word or the telemetry was lost.
const UNSEEN_US: u32 = 500_000;
/// Group and sign with which [`Controller::drive`] drives a hinge alone that is none of the sheet's: a group that no sheet
/// has.
pub const ALONE: Membership = Membership {
    group: GroupId(u32::MAX),
    negative: false,
};

/// Options of a [`Controller`].
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Options of the follower.
    pub follower: CheckedOptions<f32>,
    /// Microseconds between two messages of telemetry.
    pub telemetry: u64,
    /// Number that tells this run from all other runs of the controller, and from the runs of controllers that have the same
    /// key. With a number that comes again, bytes that somebody recorded move the sheet. Without one, no host moves it.
    pub nonce: Option<NonZero<u64>>,
    /// Number that tells this image and its hinge map from others of the same board: a checksum of both, for one. A record that
    /// another image has left does not count.
    pub image: u32,
    /// Returns the limits of a hinge, with the sign of the hinge itself. No message widens them.
    pub limits: fn(hinge: u32) -> GroupLimits,
    /// `true` to refuse sheets without essential vertices. Only a sheet without inner vertices has none.
    pub closed: bool,
    /// Number of the controller on its line; 0 if it is the only one.
    pub node: u8,
    /// `true` if a host may set the key of a controller that has room for one and has none yet. Only for lines that no
    /// stranger reaches: whoever reads the message has the key.
    pub pairs: bool,
}

impl Settings {
    /// Returns the usual options of a board with these limits.
    ///
    /// `draws` are two numbers that its source of nonces gives one after the other: random numbers of the hardware; or a
    /// count in memory that keeps it without power, and the number of the chip. If they are the same, the source does not
    /// vary, and there is no [nonce](Self::nonce): the continuous test of random numbers in FIPS 140-2, section 4.9.2.
    #[must_use]
    pub fn new(draws: [u64; 2], limits: fn(hinge: u32) -> GroupLimits) -> Self {
        let [first, second] = draws;
        Self {
            follower: CheckedOptions::default(),
            telemetry: 20_000,
            nonce: NonZero::new(first ^ second.rotate_left(32)).filter(|_| first != second),
            image: 0,
            limits,
            closed: true,
            node: 0,
            pairs: false,
        }
    }
}

/// State of a controller for whatever powers its drives: to hold them, or to let them rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Condition {
    /// State of the follower.
    pub state: State,
    /// Reason why the follower does not run at full speed.
    pub reason: Reason,
    /// `true` if the stop line holds the motion.
    pub stopped: bool,
    /// Failure of the motion, if it has failed.
    pub fault: Option<Fault>,
    /// `true` if it is known where the sheet stands.
    pub known: bool,
    /// Tells the drives to hold the hinges or to let them go.
    pub power: Power,
    /// Number of the sheet's hinges that are measured.
    pub measured: usize,
    /// Number of hinges that [`Controller::drive`] commands now. Before the first sheet, after a reset until a host has sent
    /// the sheet again, and while it is not known where the sheet stands, this is 1 for a hinge that was moved alone, and
    /// otherwise 0.
    pub commanded: usize,
}

/// A controller for at most `GROUPS` groups, `HINGES` hinges and `SPOKES` spokes of essential vertices, with a queue of
/// `KNOTS` setpoints. Its frames have tags of a key if `P` is [`Keyed`] and there is a key.
// In order, for the reason given at `Follower`.
#[derive(Debug)]
#[repr(C)]
pub struct Controller<
    const GROUPS: usize,
    const HINGES: usize,
    const SPOKES: usize,
    const KNOTS: usize,
    P: Protection = Unkeyed,
> {
    pub(crate) settings: Settings,
    pub(crate) receiver: Receiver<P>,
    /// State, reason and room of the last report, whether the stop line held, and whether it was known where the
    /// sheet stands.
    reported: Option<(State, Reason, usize, [bool; 2])>,
    /// Time when telemetry was due last. It is taken in the tick behind that of the time `due_tick`; `is_due` until then.
    telemetry: u64,
    is_due: bool,
    /// `true` if the host of this session tells what it has seen.
    sees: bool,
    /// `true` if the stop line was drawn since a command was last answered.
    drawn: bool,
    due_tick: u32,
    /// Time when telemetry was last sent (`posted`, lowest 32 bits), and microseconds from then on until more is sent
    /// (`pause`): 0 for a host that does not tell what it has seen.
    posted: u32,
    pause: u32,
    /// Microseconds that the host takes at most to tell what it has seen, unless its word was lost.
    patience: u32,
    /// Time of the last answer that was no report.
    greeted_at: Option<u64>,
    /// Time when sensors are looked at next.
    looks: u64,
    snapshot: Snapshot<GROUPS>,
    window: Window,
    deframer: Deframer<FRAME>,
    ring: Ring<WAITING>,
    pub(crate) loader: Loader<GROUPS, HINGES, SPOKES, KNOTS>,
}

impl<const GROUPS: usize, const HINGES: usize, const SPOKES: usize, const KNOTS: usize>
    Controller<GROUPS, HINGES, SPOKES, KNOTS, Keyed>
{
    /// Creates a controller that waits for a host with this key. Without a key it takes frames of any host, until a host
    /// sets one.
    // Inlined for the reason given at `Application::new`.
    #[inline(always)]
    #[must_use]
    pub fn keyed(settings: Settings, key: Option<Key>) -> Self {
        Self::protected(settings, Keyed::new(key))
    }
}

impl<
    const GROUPS: usize,
    const HINGES: usize,
    const SPOKES: usize,
    const KNOTS: usize,
    P: Protection,
> Controller<GROUPS, HINGES, SPOKES, KNOTS, P>
{
    /// Creates a controller that waits for a host, with this protection of its frames.
    #[inline(always)]
    #[must_use]
    pub fn protected(settings: Settings, protection: P) -> Self {
        let count = |room: usize| u16::try_from(room).unwrap_or(u16::MAX);
        let identity = Identity {
            node: settings.node,
            nonce: settings.nonce.map_or(0, NonZero::get),
            capacity: Capacity {
                groups: count(GROUPS),
                hinges: count(HINGES),
                spokes: count(SPOKES),
                knots: count(KNOTS),
            },
        };
        Self {
            settings,
            loader: Loader::new(Follower::new(settings.follower)),
            receiver: Receiver::protected(identity, protection),
            deframer: Deframer::default(),
            ring: Ring::default(),
            drawn: false,
            reported: None,
            telemetry: 0,
            is_due: false,
            sees: false,
            due_tick: 0,
            posted: 0,
            pause: 0,
            patience: UNSEEN_US,
            greeted_at: None,
            looks: 0,
            snapshot: Snapshot::none(),
            window: Window::new(),
        }
    }

    /// Restores what a record holds: the place on the path, the stop line, a fault, and the angles that were commanded
    /// last, if the drives have `held` the hinges since then. Otherwise the hinges may have moved, and it is not known
    /// where they stand. If hinges were measured, nothing is commanded until they were measured again.
    pub fn restore(&mut self, record: &Record<GROUPS>, held: bool) {
        let angles = if held { record.angles() } else { &[] };
        self.loader.holds = held && record.has(retained::HOLDS);
        let follower = &mut self.loader.follower;
        let _ = follower.stand(angles, record.place, record.has(retained::OFF_PATH));
        if record.has(retained::MEASURED) {
            follower.withhold();
        }
        (self.loader.path, self.loader.on) = (record.path, record.sheet);
        if record.has(retained::STOPPED) {
            self.loader.follower.hold(Reason::StopLine);
        }
        if let Some(fault) = record.fault {
            self.loader.follower.fail(fault);
        }
    }

    /// Returns what is to be kept over a reset, as record number `count` after this number of `starts`.
    #[must_use]
    pub fn record(&self, starts: u32, count: u32) -> Record<GROUPS> {
        let mut record = Record::default();
        (record.starts, record.count) = (starts, count);
        record.fault = self.loader.follower.fault();
        let flag = |flag, is_set| if is_set { flag } else { 0 };
        record.flags = flag(retained::STOPPED, self.loader.follower.is_stopped())
            | flag(retained::OFF_PATH, self.loader.follower.is_off_path())
            | flag(retained::MEASURED, self.loader.sheet.measured() > 0)
            | flag(retained::HOLDS, self.loader.holds);
        record.place = self.loader.follower.position();
        (record.path, record.sheet) = (self.loader.path, self.loader.on);
        record.stand(self.loader.follower.angles());
        record
    }

    /// Returns the state of the controller for whatever powers its drives; to be called once a tick.
    #[must_use]
    pub fn condition(&self) -> Condition {
        let known = self.loader.follower.is_known();
        Condition {
            state: self.loader.follower.state(),
            reason: self.loader.follower.reason(),
            stopped: self.loader.follower.is_stopped(),
            fault: self.loader.follower.fault(),
            known,
            power: if self.loader.holds || self.loader.jog.target().is_some() {
                Power::Hold
            } else {
                Power::Rest
            },
            measured: self.loader.sheet.measured(),
            commanded: self.commanded(known),
        }
    }

    /// Returns the number of hinges that are commanded.
    fn commanded(&self, known: bool) -> usize {
        let sheet = if known {
            self.loader.sheet.hinges().count()
        } else {
            0
        };
        let jog = &self.loader.jog;
        let alone = jog.hinge().is_some_and(|hinge| usize::from(hinge) >= sheet);
        sheet + usize::from(alone && jog.target().is_some())
    }

    /// Returns the follower, which has the commanded angles.
    #[must_use]
    pub fn follower(&self) -> &Follower<f32, GROUPS, KNOTS> {
        &self.loader.follower
    }

    /// Returns the follower, to tell it where the hinges are.
    pub fn follower_mut(&mut self) -> &mut Follower<f32, GROUPS, KNOTS> {
        &mut self.loader.follower
    }

    /// Returns the sheet, which has group and sign of each hinge.
    #[must_use]
    pub fn sheet(&self) -> &Sheet<GROUPS, HINGES, SPOKES> {
        &self.loader.sheet
    }

    /// Takes a byte that came at `now`, microseconds. A setpoint that is being checked is checked to its end before, which
    /// may take long: hand over bytes while the controller is not [busy](Self::is_busy).
    // Not inlined, nor are `poll` and the function `take`: one function that does everything is a third longer.
    #[inline(never)]
    pub fn byte(&mut self, byte: u8, now: u64) {
        while self.is_busy() {
            self.work();
        }
        let Self {
            loader,
            receiver,
            deframer,
            ..
        } = self;
        let Some(frame) = deframer.push(byte) else {
            return;
        };
        receiver.clock(now);
        let event = receiver.receive(frame, loader.room());
        if receiver.opened() {
            loader.enter();
            // A host that comes later learns of the stop line from its first report.
            self.drawn = false;
            (self.sees, self.pause) = (false, 0);
        }
        let Some(event) = event else {
            return;
        };
        loader.follower.heard(now);
        match event {
            Event::Alive => {}
            // On a slow line the next telemetry waits for as long again, so that it takes no more than half of the line.
            Event::Seen(time, groups) => {
                let newest = (low_bits(self.snapshot.time), self.snapshot.groups_sent());
                let passed = low_bits(now).wrapping_sub(self.posted);
                self.sees = true;
                if newest == (time, groups.into()) {
                    self.pause = passed.saturating_mul(2).min(UNSEEN_US);
                    self.patience = self.pause.saturating_mul(2).min(UNSEEN_US);
                }
            }
            // A motion that is not at rest would have to hold at once, because its session ends.
            Event::Pair(key) => {
                let follower = &loader.follower;
                let rests = follower.state() != State::Running && follower.rate() <= 0.0;
                if self.settings.pairs && rests {
                    receiver.propose(key);
                }
            }
            Event::Item(item) => settle(receiver, loader.take(item, &self.settings)),
            Event::Command(command) => {
                // The host may have sent `Resume` before it knew of the stop line. The denial tells it, and a later
                // `Resume` counts.
                let unaware = core::mem::take(&mut self.drawn) && command == Command::Resume;
                let moves = match command {
                    Command::Start => true,
                    Command::Jog { to, .. } => to.is_some(),
                    _ => false,
                };
                let answer = if unaware {
                    Err(Denial::Held)
                } else if moves && self.settings.nonce.is_none() {
                    Err(Denial::Nonce)
                } else {
                    loader.obey(command, &self.settings)
                };
                receiver.answer(answer);
            }
        }
    }

    /// Returns `true` while a setpoint is checked that takes more than one round; each [`poll`](Self::poll) goes on with
    /// it.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.loader.checks
    }

    /// Goes on to check a setpoint, if one is checked.
    fn work(&mut self) {
        if self.is_busy() {
            let checked = self.loader.check_on();
            settle(&mut self.receiver, checked);
        }
    }

    /// Returns a key that a host has sent since the last call, which the board has to store. Only then it is
    /// [taken](Self::pair).
    pub fn proposed_key(&mut self) -> Option<Key> {
        self.receiver.proposed()
    }

    /// Takes a key that is stored, and ends the session.
    pub fn pair(&mut self, key: Key) {
        self.receiver.pair(key);
    }

    /// Sets the level of the stop line.
    pub fn stop(&mut self, drawn: bool) {
        self.drawn |= drawn;
        self.loader.follower.stop(drawn);
    }

    /// Moves the follower on to `now`, microseconds.
    pub fn tick(&mut self, now: u64) {
        let stars = self.loader.sheet.stars();
        self.loader.follower.tick(stars, now);
        self.look(now);
        if self.loader.jog.hinge().is_some() {
            self.tick_alone();
        }
    }

    /// Looks for sensors that have fallen silent, at the end of each time in which all hinges have to be measured twice.
    fn look(&mut self, now: u64) {
        if now < self.looks {
            return;
        }
        self.looks = now + u64::from(self.settings.follower.fresh);
        if let Some(hinge) = self.loader.sheet.silent() {
            self.loader.follower.lose_sensor(hinge);
        }
    }

    /// Moves the hinge that is moved alone. Not inlined, so that other ticks do not pay for it.
    #[inline(never)]
    fn tick_alone(&mut self) {
        let Loader { follower, jog, .. } = &mut self.loader;
        let failed = follower.state() != State::Idle;
        let holds = failed || follower.is_stopped() || follower.is_silent();
        jog.tick(follower.now(), holds, &self.settings.follower);
    }

    /// Calls `drive` for each hinge with its number, its group and sign, and its target, or `None` while it is not known
    /// where the sheet stands. `drive` returns the measured angle, if there is one. Cost: a multiplication and a
    /// comparison for each hinge; some more with telemetry, or while a hinge is watched or moved alone.
    ///
    /// A hinge that is watched or moved alone and is none of the sheet's comes last, with the group [`ALONE`].
    pub fn drive(
        &mut self,
        mut drive: impl FnMut(u32, Membership, Option<Target<f32>>) -> Option<Measurement<f32>>,
    ) {
        let follower = &self.loader.follower;
        if self.is_due || !follower.is_known() || self.loader.jog.hinge().is_some() {
            return self.drive_and_note(&mut drive);
        }
        let Loader {
            sheet, follower, ..
        } = &mut self.loader;
        follower.drive_known(0, sheet.driven(), drive);
    }

    /// Drives all hinges, and notes what is measured of those that telemetry tells, or of the one that is watched or moved
    /// alone. Not inlined, so that other ticks do not pay for it.
    #[inline(never)]
    fn drive_and_note(
        &mut self,
        drive: &mut impl FnMut(u32, Membership, Option<Target<f32>>) -> Option<Measurement<f32>>,
    ) {
        let Loader {
            sheet,
            follower,
            jog,
            ..
        } = &mut self.loader;
        let window = &mut self.window;
        window.begin(jog.hinge());
        let first = window.first();
        let (alone, mut newest) = (jog.target(), None);
        let noting = |hinge, membership, target| {
            let Some(place) = window.place(hinge) else {
                return drive(hinge, membership, target);
            };
            let measurement = drive(hinge, membership, alone.or(target));
            let angle = measurement.map_or(f32::NAN, |measurement| measurement.angle);
            *place = angle.to_le_bytes();
            newest = measurement.or(newest);
            measurement
        };
        let hinges = sheet.driven();
        let count = hinges.len();
        follower.drive_from(0, hinges, noting);
        window.end(newest.is_some(), count);
        if jog.hinge().is_some() {
            if count <= first {
                newest = drive(number(first), ALONE, alone);
            }
            jog.measure(newest);
            window.narrow(jog, self.settings.follower.fresh);
        }
    }

    /// Puts all answers due at `now`, microseconds, on the line, as far as there is room. If a setpoint is being checked,
    /// it bounds the closure of an essential vertex on one more part of the segment before, so that no setpoint delays a tick.
    #[inline(never)]
    pub fn poll(&mut self, now: u64) {
        self.work();
        self.receiver.clock(now);
        let follower = &self.loader.follower;
        let (state, reason) = (follower.state(), follower.reason());
        let room = follower.room();
        let [stopped, known] = [follower.is_stopped(), follower.is_known()];
        let news = self
            .reported
            .is_none_or(|(old_state, old_reason, old_room, old_flags)| {
                (state, reason, [stopped, known]) != (old_state, old_reason, old_flags)
                    || room >= old_room + KNOTS.div_ceil(4)
            });
        if news {
            self.receiver.announce();
        }
        let status = Report {
            state,
            reason,
            place: follower.position(),
            path: self.loader.path,
            known,
            stopped,
            ..Report::default()
        };
        let items = self.loader.room();
        let mut buffer = [0; FRAME];
        while let Some(frame) = self.receiver.poll(&status, items, &mut buffer) {
            let reports = self.receiver.reports();
            let since = |then| now.saturating_sub(then);
            let early = self
                .greeted_at
                .is_some_and(|then| since(then) < MIN_GREETING_US);
            if P::KEYED && !reports && early {
                break;
            }
            if !self
                .ring
                .add(frame, if reports { 0 } else { RESERVE_BYTES })
            {
                return;
            }
            if !reports {
                self.greeted_at = Some(now);
            }
            self.receiver.sent();
            self.reported = Some((state, reason, room, [stopped, known]));
        }
        if self.receiver.session().is_some() {
            self.send_telemetry(now, &mut buffer);
        } else {
            self.is_due = false;
        }
    }

    /// Takes the next byte for the line.
    pub fn take(&mut self) -> Option<u8> {
        self.ring.take()
    }

    /// Sends telemetry, as far as there is room for it. All pieces are of one moment. Telemetry that finds the line busy at
    /// its time is dropped.
    fn send_telemetry(&mut self, now: u64, buffer: &mut [u8]) {
        let tick = low_bits(self.loader.follower.now());
        if !self.is_due {
            if low_bits(now).wrapping_sub(self.posted) < self.pause {
                return;
            }
            let due = now.saturating_sub(self.telemetry) >= self.settings.telemetry;
            if due && self.snapshot.is_sent() {
                (self.is_due, self.due_tick, self.telemetry) = (true, tick, now);
                self.window.clear();
            }
        } else if tick != self.due_tick {
            self.is_due = false;
            // On a slow line, answers would otherwise wait behind telemetry that nobody needs any more.
            if self.ring.is_empty() {
                self.snapshot.take(&self.loader.follower, now);
            } else {
                self.window.clear();
            }
        }
        while let Some(message) = self.message() {
            let frame = self.receiver.post(&message, buffer);
            if !frame.is_some_and(|frame| self.ring.add(frame, RESERVE_BYTES)) {
                return;
            }
            self.receiver.posted();
            if self.snapshot.is_sent() {
                self.window.clear();
                continue;
            }
            self.snapshot.sent();
            self.posted = low_bits(now);
            self.pause = if self.sees { self.patience } else { 0 };
            if self.sees && !self.snapshot.is_sent() {
                return;
            }
        }
    }

    /// Returns the next message of telemetry: the pieces of the snapshot, and then the window.
    fn message(&self) -> Option<ToHost<'_>> {
        if self.is_due {
            return None;
        }
        let piece = self.snapshot.message();
        piece.or_else(|| self.window.message(self.snapshot.time))
    }
}

/// Returns the number of a hinge; those that are sent have 16 bits.
fn number(hinge: usize) -> u32 {
    u32::try_from(hinge).unwrap_or(u32::MAX)
}

/// Tells whether an item was taken, if that is known.
pub(crate) fn settle<P: Protection>(receiver: &mut Receiver<P>, taken: Result<bool, ItemRefusal>) {
    match taken {
        Ok(true) => receiver.took(),
        Ok(false) => {}
        Err(refusal) => receiver.refuse(refusal),
    }
}
