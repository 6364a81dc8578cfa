//! What a host and a controller say to each other.
//!
//! [`ToDevice::Hello`] and [`ToHost::Mismatch`] keep their encoding in all versions, so that two ends that do not
//! understand each other can at least say so.

use serde::{Deserialize, Serialize};

use crate::Interpolation;
use crate::acceptance::Refusal;
use crate::follower::{Denial, Place, Reason, State};

/// The version of the protocol.
pub const VERSION: u16 = 1;
/// CRC-32 of the examples of all messages in `firmware-sim/PROTOCOL.md`, one behind the other: it changes with
/// the encoding, though someone forgets the version.
pub const SCHEMA: u32 = 0x1f42_b7e1;

/// From the host.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ToDevice<'a> {
    /// Asks for a session, in session 0.
    Hello {
        /// [`VERSION`] of the host.
        version: u16,
        /// [`SCHEMA`] of the host.
        schema: u32,
        /// A number that the host has not used before.
        id: u32,
    },
    /// One of the numbered items, which come through once each and in order.
    Item {
        /// Its number, modulo 2¹⁶, from 0.
        sequence: u16,
        /// What it is.
        #[serde(borrow)]
        item: Item<'a>,
    },
    /// Something to do at once, whatever items are on their way.
    Command {
        /// One more than that of the command before, modulo 2⁸, from 1.
        number: u8,
        /// What to do.
        command: Command,
    },
    /// The host is there, and asks for a [`Report`].
    Alive,
}

/// What is sent in order: a sheet, and then the setpoints of a path on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Item<'a> {
    /// A new sheet.
    Sheet(SheetHead),
    /// Limits of its next groups, 16 bytes each: smallest and largest angle, speed, acceleration.
    Limits(#[serde(borrow)] &'a [u8]),
    /// Its next hinges, in [as few bits as that takes](crate::wire::path::hinge_bits): twice the group, and 1 more if
    /// it turns the opposite way. All but the last item of them fill whole bytes.
    Hinges(#[serde(borrow)] &'a [u8]),
    /// The next spokes of its essential vertices, 10 bytes each: four times the group, 2 more if it is the last of
    /// its vertex, 1 more if it turns the opposite way; then the two numbers of its direction.
    Spokes(#[serde(borrow)] &'a [u8]),
    /// A knot of the path.
    Setpoint(#[serde(borrow)] SetpointBytes<'a>),
}

/// What a sheet has, and where on its path to begin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SheetHead {
    /// How the motion between setpoints is made.
    pub interpolation: Interpolation,
    /// Number of groups.
    pub groups: u16,
    /// Number of hinges.
    pub hinges: u16,
    /// Number of spokes of all essential vertices.
    pub spokes: u16,
    /// Largest closure residual of a commanded configuration.
    pub closure: f32,
    /// The knot of the first setpoint, and the place behind it at which to begin.
    pub place: Place<f32>,
}

/// A setpoint as it is sent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetpointBytes<'a> {
    /// Number of the knot in its path.
    pub number: u32,
    /// Seconds since the start of the path.
    pub time: f32,
    /// Whether the path ends here.
    pub last: bool,
    /// For each group its angle and its rate, and where the interpolation has weights, its weight and the
    /// weight's rate; 4 bytes each, little endian.
    pub nodes: &'a [u8],
}

/// What a host may ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Command {
    /// Begin to move.
    Start,
    /// Slow down along the path and hold.
    Hold,
    /// Go on.
    Resume,
    /// Drop the path.
    Unload,
    /// Leave a fault behind.
    Clear,
}

/// From the controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ToHost<'a> {
    /// The controller speaks another version; in session 0.
    Mismatch {
        /// The host that asked.
        id: u32,
        /// [`VERSION`] of the controller.
        version: u16,
        /// [`SCHEMA`] of the controller.
        schema: u32,
    },
    /// Offers a session, which begins with the first frame in it; in session 0.
    Welcome {
        /// The host that asked.
        id: u32,
        /// The session.
        session: u32,
    },
    /// The session of this frame is not the one that is open.
    Unknown,
    /// Where things stand.
    Report(Report),
    /// What is commanded at a moment. May be lost.
    Telemetry {
        /// Microseconds on the controller's clock.
        time: u64,
        /// What the follower does.
        state: State,
        /// Seconds of the path in a second.
        rate: f32,
        /// Where on the path.
        place: Place<f32>,
        /// Commanded angle of each group, 4 bytes each, little endian.
        angles: &'a [u8],
    },
}

/// Acknowledges all that came, grants credit and says what is going on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Number of the item that is expected next: all before it have come.
    pub next: u16,
    /// Number of the first item for which there is no room yet.
    pub limit: u16,
    /// Number of frames of the session that have come, modulo 2⁸.
    pub heard: u8,
    /// Whether a later item came first; said once a gap.
    pub gap: bool,
    /// Why the item that is expected was refused when it came.
    pub refused: Option<ItemRefusal>,
    /// Number of the last command carried out or denied.
    pub command: u8,
    /// Why it was denied.
    pub denied: Option<Denial>,
    /// What the follower does.
    pub state: State,
    /// Why it does not run at full speed.
    pub reason: Reason,
    /// Where on the path it is.
    pub place: Place<f32>,
}

/// Why an item is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ItemRefusal {
    /// The setpoint is not fit to follow.
    Setpoint(Refusal),
    /// The path cannot be taken up.
    Path(Denial),
    /// The sheet has more of something than there is room for.
    Room,
    /// More came of something than the sheet has, or a piece of a number.
    Pieces,
    /// The sheet is not complete.
    Incomplete,
    /// The limits of this group are no range or not above 0.
    Limits(u16),
    /// This hinge has no group of the sheet.
    Hinge(u16),
    /// The essential vertices are not sound: a group, a direction, or the last spoke ends none.
    Stars,
    /// The closure asked for is no number, or more than the controller allows.
    Closure,
}
