//! The controller without its board: bytes of the line and ticks of the clock go in, angles and bytes come out.
//!
//! On a board [`Application`](crate::application::Application) hands over received bytes ([`Controller::byte`]), calls
//! [`Controller::tick`] at a steady pace, drives the hinges, calls [`Controller::poll`] and [takes](Controller::take)
//! bytes for the line. Times are microseconds on the controller's clock.

use foldpath_core::acceptance::{Refusal, Setpoint};
use foldpath_core::follower::{Denial, Follower, Options, Reason, State};
use foldpath_core::wire::cobs::{self, Deframer};
use foldpath_core::wire::frame;
use foldpath_core::wire::message::{Command, Item, ItemRefusal, SetpointBytes, ToHost};
use foldpath_core::wire::path;
use foldpath_core::wire::receiver::{Event, Receiver, Status};
use foldpath_core::wire::transmit::Ring;
use foldpath_core::{Interpolation, Membership};
use heapless::Vec;

use crate::sheet::Sheet;

/// Length of the longest frame, bytes.
pub const FRAME: usize = 256;
/// Largest number of bytes that wait for the line.
pub const WAITING: usize = 512;
/// Bytes of the ring that telemetry leaves free for answers: four reports.
const RESERVE: usize = 4 * cobs::longest(56);

/// Options of a [`Controller`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Options of the follower.
    pub follower: Options<f32>,
    /// Largest closure residual that a host may ask for.
    pub closure: f32,
    /// Microseconds between two messages of telemetry.
    pub telemetry: u64,
    /// Number that tells the sessions of this run from those of other runs: a count of resets or a random number.
    pub boot: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            follower: Options::default(),
            closure: 1e-3,
            telemetry: 20_000,
            boot: 0,
        }
    }
}

/// A controller for at most `GROUPS` groups, `HINGES` hinges and `SPOKES` spokes of essential vertices, with a queue of
/// `KNOTS` setpoints.
#[derive(Debug)]
pub struct Controller<
    const GROUPS: usize,
    const HINGES: usize,
    const SPOKES: usize,
    const KNOTS: usize,
> {
    settings: Settings,
    sheet: Sheet<GROUPS, HINGES, SPOKES>,
    follower: Follower<f32, GROUPS, KNOTS>,
    receiver: Receiver,
    deframer: Deframer<FRAME>,
    ring: Ring<WAITING>,
    /// `true` if the path is that of the open session.
    loaded: bool,
    /// `true` if the stop line was drawn since a command was last answered.
    drawn: bool,
    /// State, reason and room that the host was last told.
    told: Option<(State, Reason, usize)>,
    telemetry: u64,
}

impl<const GROUPS: usize, const HINGES: usize, const SPOKES: usize, const KNOTS: usize>
    Controller<GROUPS, HINGES, SPOKES, KNOTS>
{
    /// Creates a controller that waits for a host.
    // Inlined for the reason given at `Application::new`.
    #[inline(always)]
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            sheet: Sheet::default(),
            follower: Follower::new(settings.follower),
            receiver: Receiver::new(settings.boot),
            deframer: Deframer::default(),
            ring: Ring::default(),
            loaded: false,
            drawn: false,
            told: None,
            telemetry: 0,
        }
    }

    /// Returns the follower, which has the commanded angles.
    #[must_use]
    pub fn follower(&self) -> &Follower<f32, GROUPS, KNOTS> {
        &self.follower
    }

    /// Returns the follower, to tell it where the hinges are.
    pub fn follower_mut(&mut self) -> &mut Follower<f32, GROUPS, KNOTS> {
        &mut self.follower
    }

    /// Returns the sheet, which has group and sign of each hinge.
    #[must_use]
    pub fn sheet(&self) -> &Sheet<GROUPS, HINGES, SPOKES> {
        &self.sheet
    }

    /// Takes a byte that came at `now`, microseconds.
    // Not inlined, nor are `poll` and the function `take`: one function that does everything is a third longer.
    #[inline(never)]
    pub fn byte(&mut self, byte: u8, now: u64) {
        let room = self.room();
        let Self {
            sheet,
            follower,
            receiver,
            deframer,
            ..
        } = self;
        let Some(frame) = deframer.push(byte) else {
            return;
        };
        let event = receiver.receive(frame, room);
        if receiver.opened() {
            self.loaded = false;
            if follower.is_under_way() {
                follower.hold(Reason::Session);
            }
        }
        let Some(event) = event else {
            return;
        };
        follower.heard(now);
        match event {
            Event::Alive => {}
            Event::Item(item) => {
                // A sheet that an earlier session has left is no base for items of this session.
                let founded = self.loaded || matches!(item, Item::Sheet(_));
                let taken = if founded {
                    take(item, sheet, follower, self.settings.closure)
                } else {
                    Err(ItemRefusal::Incomplete)
                };
                match taken {
                    Ok(()) => {
                        self.loaded = true;
                        receiver.took();
                    }
                    Err(refusal) => receiver.refuse(refusal),
                }
            }
            Event::Command(command) => {
                // The host may have sent `Resume` before it knew of the stop line. The denial tells it, and a later
                // `Resume` counts.
                let unaware = core::mem::take(&mut self.drawn) && command == Command::Resume;
                let answer = if unaware {
                    Err(Denial::Held)
                } else {
                    obey(command, follower, self.loaded)
                };
                receiver.answer(answer);
                let leaves = matches!(command, Command::Unload | Command::Clear);
                if leaves && answer.is_ok() {
                    sheet.clear();
                }
            }
        }
    }

    /// Sets the level of the stop line.
    pub fn stop(&mut self, drawn: bool) {
        self.drawn |= drawn;
        self.follower.stop(drawn);
    }

    /// Moves the follower on to `now`, microseconds.
    pub fn tick(&mut self, now: u64) {
        self.follower.tick(now);
    }

    /// Calls `drive` for each hinge with its number, its group and sign, and its commanded angle (radians). `drive`
    /// returns the measured angle, radians, if there is one. Cost: a multiplication and a comparison for each hinge.
    pub fn drive(&mut self, mut drive: impl FnMut(u32, Membership, f32) -> Option<f32>) {
        for (hinge, membership) in (0..).zip(self.sheet.hinges()) {
            let Some(angle) = self.follower.hinge(membership) else {
                continue;
            };
            if let Some(measured) = drive(hinge, membership, angle) {
                self.follower.measure(hinge, membership, measured);
            }
        }
    }

    /// Puts all answers due at `now`, microseconds, on the line, as far as there is room.
    #[inline(never)]
    pub fn poll(&mut self, now: u64) {
        let (state, reason) = (self.follower.state(), self.follower.reason());
        let room = self.follower.room();
        let news = self.told.is_none_or(|(old_state, old_reason, old_room)| {
            (state, reason) != (old_state, old_reason) || room >= old_room + KNOTS.div_ceil(4)
        });
        if news {
            self.receiver.announce();
        }
        let status = Status {
            state,
            reason,
            place: self.follower.position(),
            room: self.room(),
        };
        let mut buffer = [0; FRAME];
        while let Some(frame) = self.receiver.poll(&status, &mut buffer) {
            if !self.ring.add(frame, 0) {
                return;
            }
            self.receiver.sent();
            self.told = Some((state, reason, room));
        }
        let due = now.saturating_sub(self.telemetry) >= self.settings.telemetry;
        if let Some(session) = self.receiver.session().filter(|_| due) {
            self.telemetry = now;
            self.tell(session, now, &mut buffer);
        }
    }

    /// Takes the next byte for the line.
    pub fn take(&mut self) -> Option<u8> {
        self.ring.take()
    }

    /// Sends telemetry, if there is room for it.
    fn tell(&mut self, session: u32, now: u64, buffer: &mut [u8]) {
        let mut angles = [[0; 4]; GROUPS];
        let mut groups = 0;
        for (bytes, angle) in angles.iter_mut().zip(self.follower.angles()) {
            *bytes = angle.to_le_bytes();
            groups += 1;
        }
        let message = ToHost::Telemetry {
            time: now,
            state: self.follower.state(),
            rate: self.follower.rate(),
            place: self.follower.position(),
            angles: angles.get(..groups).unwrap_or(&[]).as_flattened(),
        };
        if let Some(frame) = frame::seal(session, &message, buffer) {
            self.ring.add(frame, RESERVE);
        }
    }

    /// Returns the number of items for which there is room. There is none while the sheet moves on the path of another
    /// host.
    fn room(&self) -> u16 {
        let room = if self.loaded
            && (self.follower.is_under_way() || self.follower.state() == State::Ready)
        {
            self.follower.room()
        } else if self.follower.rate() > 0.0 {
            0
        } else {
            KNOTS
        };
        u16::try_from(room).unwrap_or(u16::MAX)
    }
}

/// Carries out a command. The path of another session does not go on.
fn obey<const GROUPS: usize, const KNOTS: usize>(
    command: Command,
    follower: &mut Follower<f32, GROUPS, KNOTS>,
    loaded: bool,
) -> Result<(), Denial> {
    match command {
        Command::Start if !loaded => Err(Denial::State),
        Command::Start => follower.start(),
        Command::Hold => {
            follower.hold(Reason::Asked);
            Ok(())
        }
        Command::Resume if !loaded && follower.is_under_way() => Err(Denial::State),
        Command::Resume => follower.resume(),
        Command::Unload => follower.unload(),
        Command::Clear => follower.clear(),
    }
}

/// Takes an item.
#[inline(never)]
fn take<const GROUPS: usize, const HINGES: usize, const SPOKES: usize, const KNOTS: usize>(
    item: Item<'_>,
    sheet: &mut Sheet<GROUPS, HINGES, SPOKES>,
    follower: &mut Follower<f32, GROUPS, KNOTS>,
    closure: f32,
) -> Result<(), ItemRefusal> {
    match item {
        Item::Sheet(head) => {
            follower.unload().map_err(ItemRefusal::Path)?;
            sheet.begin(head, closure)
        }
        Item::Limits(bytes) => sheet.add_limits(bytes),
        Item::Hinges(bytes) => sheet.add_hinges(bytes),
        Item::Spokes(bytes) => sheet.add_spokes(bytes),
        Item::Setpoint(bytes) => {
            let (view, head) = sheet.view().ok_or(ItemRefusal::Incomplete)?;
            if follower.state() == State::Idle {
                follower
                    .load(&view, head.place)
                    .map_err(ItemRefusal::Path)?;
            }
            let setpoint = setpoint(&bytes, view.interpolation);
            let Some(setpoint) = setpoint else {
                follower.hold(Reason::Refused(Refusal::Groups));
                return Err(ItemRefusal::Setpoint(Refusal::Groups));
            };
            let accepted = follower.accept(&view, setpoint);
            accepted.map_err(ItemRefusal::Setpoint)
        }
    }
}

/// Decodes a setpoint; `None` if it has too many groups, or if a group is cut off.
fn setpoint<const GROUPS: usize>(
    bytes: &SetpointBytes<'_>,
    interpolation: Interpolation,
) -> Option<Setpoint<f32, GROUPS>> {
    let mut nodes = Vec::new();
    for node in path::nodes(interpolation, bytes.nodes) {
        nodes.push(node).ok()?;
    }
    let whole = nodes.len() * 4 * interpolation.width() == bytes.nodes.len();
    whole.then_some(Setpoint {
        number: bytes.number,
        time: bytes.time,
        last: bytes.last,
        nodes,
    })
}
