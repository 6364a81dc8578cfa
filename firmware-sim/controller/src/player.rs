//! A path in flash that a button plays, without a host.

use core::fmt;

use foldpath_core::follower::{Denial, Fault, FollowerPosition, Reason, State};
use foldpath_core::trajectory_file::{FileError, TrajectoryFile};
use foldpath_core::wire::file::FileItems;
use foldpath_core::wire::message::{Command, ItemRefusal};
use foldpath_core::wire::protection::Protection;
use foldpath_core::wire::sender::Source;

use crate::controller::{Controller, FRAME, settle};

/// Microseconds without a frame of the host after which a button counts.
const QUIET_US: u64 = 1_000_000;

/// Reason why a [`Player`] did not do what it was asked, or why it stopped.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PlayRefusal {
    /// A host was heard within the last second.
    Host,
    /// The path has ended, and there is no path of the way back.
    Done,
    /// The motion has failed; [`Player::release`] comes first.
    Fault(Fault),
    /// The controller denies it, as it would deny it to a host.
    Denied(Denial),
    /// The controller refuses a part of the file, as it would refuse it from a host.
    Item(ItemRefusal),
}

impl fmt::Display for PlayRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Host => f.write_str("a host was heard within the last second"),
            Self::Done => f.write_str("the path has ended, and there is no way back"),
            Self::Fault(fault) => fault.fmt(f),
            Self::Denied(denial) => denial.fmt(f),
            Self::Item(refusal) => refusal.fmt(f),
        }
    }
}

impl core::error::Error for PlayRefusal {}

impl From<Denial> for PlayRefusal {
    fn from(denial: Denial) -> Self {
        Self::Denied(denial)
    }
}

/// Reason why there is no [`Player`] of some bytes.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PlayerError {
    /// The bytes are no trajectory file.
    File(FileError),
    /// The file has no knot, or more than 2¹⁴ groups, hinges or spokes.
    Size,
}

impl fmt::Display for PlayerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(error) => error.fmt(f),
            Self::Size => {
                f.write_str("expected a knot, and at most 16384 groups, hinges and spokes each")
            }
        }
    }
}

impl core::error::Error for PlayerError {}

/// A request of a button.
#[derive(Clone, Copy, Debug)]
enum Ask {
    Press,
    PressFlat,
    Release,
}

/// A path of which items are taken, while nobody else has loaded one.
#[derive(Clone, Copy, Debug)]
struct Play<'a> {
    items: FileItems<'a>,
    /// Number of the next item.
    next: u64,
    start: Option<Start>,
}

/// A start that was asked for.
#[derive(Clone, Copy, Debug)]
struct Start {
    /// `true` if somebody has said that the sheet stands where the path begins.
    flat: bool,
    /// Time since when the path is ready, microseconds.
    ready: Option<u64>,
}

/// Plays a trajectory file (`.traj`) from flash when a button is pressed, through the same checks as the path of a host.
///
/// The board creates it once, tells it of each press, and lends it to [`Application::play`](crate::Application::play) in
/// each round of its main loop. It goes on from the place on the path that the controller knows, which a reset keeps. So a
/// host can go on with a path that a button has begun, and a button with a path of a host.
///
/// | state of the controller | [`press`](Self::press) | [`press_flat`](Self::press_flat) |
/// |---|---|---|
/// | a host was heard within the last second | refused: `Host` | refused: `Host` |
/// | [`Idle`](State::Idle) or [`Done`](State::Done), or at rest on a path of a silent host | starts where this path was left, or at its beginning. At its end it starts the way back, and at the end of that the path again. Without a way back it is refused: `Done` | starts the path at its beginning, and takes this as the operator's word that the sheet stands there if nobody knows where it stands |
/// | moving on a path of a silent host | refused: `Denied(Moving)` | the same |
/// | the file is being loaded, or the start waits for measurements | calls the start off; one more press starts | the same |
/// | [`Ready`](State::Ready), a start was refused | asks for the start once more | the same, with the operator's word |
/// | [`Running`](State::Running), or holding for a reason that passes (an empty queue, a lagging hinge, a lease) | holds | holds |
/// | [`Holding`](State::Holding) for any other reason | resumes | resumes |
/// | the stop line holds, or a host has asked to hold | refused: `Denied(Held)` | the same |
/// | [`Faulted`](State::Faulted) | refused: `Fault` | the same |
///
/// Only [`release`](Self::release), or a host, undoes a stop line, a fault or a host's hold. Nothing moves by that.
///
/// A start from a place that nobody knows waits for `Options::fresh`, so that all hinges can be measured, and nothing
/// counts that was measured before the press. If a group was not measured then, it is refused as [`Denial::Unknown`].
///
/// A press that starts a path ends the session of a silent host. A host that opens a session while the path is played
/// takes over: the motion holds, and the player is out until the host was silent for a second.
#[derive(Clone, Copy, Debug)]
pub struct Player<'a> {
    there: FileItems<'a>,
    back: Option<FileItems<'a>>,
    ask: Option<Ask>,
    play: Option<Play<'a>>,
    refused: Option<PlayRefusal>,
}

impl<'a> Player<'a> {
    /// Creates a player of the bytes of a trajectory file, and of another one for the way back, if there is one. It has to
    /// begin where the first one ends, and to end where that one begins. Cost: a check of all bytes.
    ///
    /// # Errors
    /// If a file is not valid or has no knot or too many groups, hinges or spokes.
    pub fn new(there: &'a [u8], back: Option<&'a [u8]>) -> Result<Self, PlayerError> {
        Ok(Self {
            there: items(there)?,
            back: back.map(items).transpose()?,
            ask: None,
            play: None,
            refused: None,
        })
    }

    /// Notes that the button was pressed. The last press before the next round counts.
    pub fn press(&mut self) {
        self.ask = Some(Ask::Press);
    }

    /// Notes that an operator starts the path and says that the sheet stands where it begins, for instance by pressing the
    /// button for long.
    pub fn press_flat(&mut self) {
        self.ask = Some(Ask::PressFlat);
    }

    /// Notes that an operator undoes the stop line, which must not be drawn any more, a fault, and a hold that a host has asked
    /// for. The path is dropped, and its place is kept. Nothing moves before the next press.
    pub fn release(&mut self) {
        self.ask = Some(Ask::Release);
    }

    /// Returns why the last press or release did nothing, or why the path stopped since then.
    #[must_use]
    pub fn refused(&self) -> Option<PlayRefusal> {
        self.refused
    }

    /// Returns `true` while the path is loaded by this player.
    #[must_use]
    pub fn is_playing(&self) -> bool {
        self.play.is_some()
    }

    /// Returns the items that go on from a place on the path of this number: of the same path, or at its end of the path
    /// that goes the other way. `None` if there is none.
    fn from(&self, path: u32, place: FollowerPosition<f32>) -> Option<FileItems<'a>> {
        let ways = [(Some(self.there), self.back), (self.back, Some(self.there))];
        for (way, other) in ways {
            if let Some(way) = way.filter(|way| way.identity() == path) {
                let last = way.at(FollowerPosition {
                    knot: place.knot.saturating_add(1),
                    into: 0.0,
                });
                return if last.is_some() { way.at(place) } else { other };
            }
        }
        Some(self.there)
    }
}

/// Returns the items of the bytes of a file.
fn items(bytes: &[u8]) -> Result<FileItems<'_>, PlayerError> {
    let file = TrajectoryFile::read(bytes).map_err(PlayerError::File)?;
    FileItems::new(file).ok_or(PlayerError::Size)
}

impl<
    const GROUPS: usize,
    const HINGES: usize,
    const SPOKES: usize,
    const KNOTS: usize,
    P: Protection,
> Controller<GROUPS, HINGES, SPOKES, KNOTS, P>
{
    /// Does what a player was asked since the last call, and takes an item of its path if there is room; to be called in
    /// each round, at `now`, microseconds.
    #[inline(never)]
    pub fn play(&mut self, player: &mut Player<'_>, now: u64) {
        // A host has come.
        if self.receiver.session().is_some() {
            player.play = None;
        }
        if player.is_playing() {
            self.loader.follower.heard(now);
        }
        if self.is_busy() {
            return;
        }
        if let Some(ask) = player.ask.take() {
            let done = match ask {
                Ask::Press => self.press(player, false),
                Ask::PressFlat => self.press(player, true),
                Ask::Release => self.release(player),
            };
            player.refused = done.err();
        }
        if let Some(play) = &mut player.play
            && let Err(refusal) = self.feed(play, now)
        {
            player.refused = Some(refusal);
            // A start that is denied may be asked for again.
            if !matches!(refusal, PlayRefusal::Denied(_)) {
                player.play = None;
            }
        }
        if self.loader.follower.state() == State::Done {
            player.play = None;
        }
    }

    fn is_hosted(&self) -> bool {
        self.receiver.session().is_some() && self.loader.follower.quiet() < QUIET_US
    }

    fn press(&mut self, player: &mut Player<'_>, flat: bool) -> Result<(), PlayRefusal> {
        let follower = &self.loader.follower;
        if self.is_hosted() {
            return Err(PlayRefusal::Host);
        }
        if let Some(fault) = follower.fault() {
            return Err(PlayRefusal::Fault(fault));
        }
        if follower.is_stopped() {
            return Err(Denial::Held.into());
        }
        let state = follower.state();
        match &mut player.play {
            Some(play) if play.start.is_some() => play.start = None,
            Some(_) if follower.is_under_way() => {
                let command = if follower.reason().passes() {
                    Command::Hold
                } else {
                    Command::Resume
                };
                self.loader.obey(command, &self.settings)?;
            }
            Some(play) => play.start = Some(Start { flat, ready: None }),
            None => {
                if state == State::Running || follower.rate() > 0.0 {
                    return Err(Denial::Moving.into());
                }
                // Whoever asked to hold may stand beside the sheet.
                if follower.reason() == Reason::HoldCommand {
                    return Err(Denial::Held.into());
                }
                let items = if flat {
                    Some(player.there)
                } else {
                    player.from(self.loader.path, follower.position())
                };
                let items = items.ok_or(PlayRefusal::Done)?;
                self.vacate(Command::Unload)?;
                // Nobody else has asked to hold.
                self.loader.obey(Command::Resume, &self.settings)?;
                player.play = Some(Play {
                    items,
                    next: 0,
                    start: Some(Start { flat, ready: None }),
                });
            }
        }
        Ok(())
    }

    fn release(&mut self, player: &mut Player<'_>) -> Result<(), PlayRefusal> {
        let follower = &self.loader.follower;
        if self.is_hosted() {
            return Err(PlayRefusal::Host);
        }
        let fault = follower.fault().is_some();
        // A hold of this player ends with the next press.
        let held = player.play.is_none() && follower.reason() == Reason::HoldCommand;
        if !(fault || held || follower.is_stopped()) {
            return Ok(());
        }
        player.play = None;
        self.vacate(if fault {
            Command::Clear
        } else {
            Command::Unload
        })?;
        Ok(self.loader.obey(Command::Resume, &self.settings)?)
    }

    /// Ends the session of a host, and drops the path by a command. The place on it is kept.
    fn vacate(&mut self, command: Command) -> Result<(), Denial> {
        self.receiver.close();
        self.loader.enter();
        self.loader.obey(command, &self.settings)
    }

    /// Takes the next item of a path if there is room, or starts the path once there is no room or no item left.
    fn feed(&mut self, play: &mut Play<'_>, now: u64) -> Result<(), PlayRefusal> {
        if let Some(fault) = self.loader.follower.fault() {
            return Err(PlayRefusal::Fault(fault));
        }
        // The receiver counts the items that were taken, also those that were checked over several rounds.
        if let Some(refusal) = self.receiver.refused() {
            return Err(PlayRefusal::Item(refusal));
        }
        let [low, high, ..] = play.next.to_le_bytes();
        let counted = u16::from_le_bytes([low, high]);
        play.next += u64::from(self.receiver.next().wrapping_sub(counted));
        let mut scratch = [0; FRAME];
        if self.loader.room() > 0
            && let Some(item) = play.items.item(play.next, &mut scratch)
        {
            settle(&mut self.receiver, self.loader.take(item, &self.settings));
            return Ok(());
        }
        self.start(play, now)
    }

    /// Starts a path that is ready, if that was asked for.
    fn start(&mut self, play: &mut Play<'_>, now: u64) -> Result<(), PlayRefusal> {
        let known = self.loader.follower.is_known();
        let Some(Start { flat, ready }) = &mut play.start else {
            return Ok(());
        };
        let flat = *flat;
        let since = *ready.get_or_insert(now);
        let fresh = u64::from(self.settings.follower.fresh);
        if !known && now.saturating_sub(since) <= fresh {
            return Ok(());
        }
        play.start = None;
        if flat && !known {
            self.loader.obey(Command::Stand, &self.settings)?;
        }
        Ok(self.loader.obey(Command::Start, &self.settings)?)
    }
}
