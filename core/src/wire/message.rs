//! The messages between a host and a controller, which postcard encodes.
//!
//! [`ToDevice::Hello`] and [`ToHost::Mismatch`] keep their encoding in all versions, so that two ends that do not
//! understand each other can at least say so.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::Interpolation;
use crate::acceptance::Refusal;
use crate::follower::{Denial, FollowerPosition, Reason, State};
use crate::numbers::{Numbers, number};

/// Version of the protocol.
pub const VERSION: u16 = 3;
/// CRC-32 of the examples of all messages in `firmware-sim/PROTOCOL.md`, one behind the other. It changes with the
/// encoding even if someone forgets to raise the version.
pub const SCHEMA: u32 = 0xda8d_9db4;

/// A message from the host.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ToDevice<'a> {
    /// Asks for a session, in session 0.
    Hello {
        /// [`VERSION`] of the host.
        #[serde(with = "number")]
        version: u16,
        /// [`SCHEMA`] of the host.
        #[serde(with = "number")]
        schema: u32,
        /// Number that the host has not used before.
        #[serde(with = "number")]
        id: u32,
    },
    /// One of the numbered items, which come through once each and in order.
    Item {
        /// Number of the item, modulo 2¹⁶, from 0.
        #[serde(with = "number")]
        sequence: u16,
        /// The item.
        #[serde(borrow)]
        item: Item<'a>,
    },
    /// A command to carry out at once, whatever items are on their way.
    Command {
        /// Number of the command: one more than that of the command before, modulo 2⁸, from 1.
        number: u8,
        /// The command.
        command: Command,
    },
    /// Sign of life of the host, which asks for a [`Report`].
    Alive,
    /// A key for a controller that has none, [`SIZE`](crate::wire::key::Key::SIZE) bytes. A controller that takes it ends
    /// the session, and from then on takes only frames with tags of this key.
    Pair(#[serde(borrow)] &'a [u8]),
    /// Tells how much of the newest [`ToHost::Telemetry`] has come. From then on the controller waits for this before it sends
    /// more, so that no buffer of the line fills with telemetry. There is no answer.
    Seen {
        /// Lowest 32 bits of its time.
        #[serde(with = "number")]
        time: u32,
        /// Number of its groups that have come.
        #[serde(with = "number")]
        groups: u16,
    },
}

/// Items, which are sent in order: a sheet, and then the setpoints of a path on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Item<'a> {
    /// A new sheet.
    Sheet(SheetHead),
    /// Limits of the sheet's next groups, 16 bytes each: smallest and largest angle, speed, acceleration.
    Limits(#[serde(borrow)] &'a [u8]),
    /// The sheet's next hinges, in [the fewest bits](crate::wire::path::hinge_bits) that hold their codes: twice the
    /// group, and 1 more if the hinge turns the opposite way. All but the last item of hinges fill whole bytes.
    Hinges(#[serde(borrow)] &'a [u8]),
    /// The next spokes of the sheet's essential vertices, 10 bytes each: four times the group, 2 more if the spoke is
    /// the last of its vertex, 1 more if it turns the opposite way; then the two numbers of its direction.
    Spokes(#[serde(borrow)] &'a [u8]),
    /// A knot of the path, or the last piece of one.
    Setpoint(#[serde(borrow)] SetpointBytes<'a>),
    /// Numbers of the next groups of a knot that does not fit into one item, of
    /// [`NODES_BYTES`](crate::wire::path::NODES_BYTES). The setpoint with the rest of the groups follows.
    Nodes(#[serde(borrow)] &'a [u8]),
}

/// Numbers of groups, hinges and spokes of a sheet, and the place on its path at which to begin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SheetHead {
    /// Kind of motion between setpoints.
    pub interpolation: Interpolation,
    /// Number of groups.
    #[serde(with = "number")]
    pub groups: u16,
    /// Number of hinges.
    #[serde(with = "number")]
    pub hinges: u16,
    /// Number of spokes of all essential vertices.
    #[serde(with = "number")]
    pub spokes: u16,
    /// Largest closure residual of a commanded configuration.
    pub closure: f32,
    /// Number that tells this path from others: a checksum of its numbers that is not 0.
    #[serde(with = "number")]
    pub path: u32,
    /// The knot of the first setpoint, and the time behind that knot at which to begin.
    pub place: FollowerPosition<f32>,
    /// Distance between a hinge and its command from which on the motion holds, radians; infinite for that of the
    /// controller's options, which is never exceeded.
    pub most_lag: f32,
}

/// A setpoint as it is sent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SetpointBytes<'a> {
    /// Number of the knot in its path.
    #[serde(with = "number")]
    pub number: u32,
    /// Seconds since the knot before; 0 at the first knot.
    pub span: f32,
    /// `true` if the path ends here.
    pub last: bool,
    /// Angle and rate of each group, and if the interpolation has weights, its weight and the weight's rate; 4 bytes
    /// each, little endian.
    pub nodes: &'a [u8],
}

/// Commands of a host.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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
    /// Take the operator's word that the sheet stands where the path begins.
    Stand,
    /// Forget where the sheet stands.
    Forget,
    /// Watch one hinge, and move it slowly if there is an angle to move it to. Angles are in radians and have the sign of
    /// the hinge itself, valley positive.
    Jog {
        /// Number of the hinge.
        #[serde(with = "number")]
        hinge: u16,
        /// Angle at which it stands, by the word of an operator.
        from: Option<f32>,
        /// Angle to which it moves; `None` if it is only measured.
        to: Option<f32>,
    },
}

/// The largest numbers for which a controller has room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Capacity {
    /// Number of groups.
    #[serde(with = "number")]
    pub groups: u16,
    /// Number of hinges.
    #[serde(with = "number")]
    pub hinges: u16,
    /// Number of spokes of all essential vertices.
    #[serde(with = "number")]
    pub spokes: u16,
    /// Number of setpoints in the queue.
    #[serde(with = "number")]
    pub knots: u16,
}

/// A message from the controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ToHost<'a> {
    /// Told in session 0 that the controller speaks another version.
    Mismatch {
        /// Id of the host that asked.
        #[serde(with = "number")]
        id: u32,
        /// [`VERSION`] of the controller.
        #[serde(with = "number")]
        version: u16,
        /// [`SCHEMA`] of the controller.
        #[serde(with = "number")]
        schema: u32,
    },
    /// Offers a session, which begins with the first frame in it. Sent in session 0.
    Welcome {
        /// Id of the host that asked.
        #[serde(with = "number")]
        id: u32,
        /// Number of the session.
        #[serde(with = "number")]
        session: u32,
        /// Number that the controller has not used in any run before.
        #[serde(with = "number")]
        nonce: u64,
        /// Lowest bits of the controller's [epoch](crate::wire::key::epoch).
        epoch: u8,
        /// Room of the controller.
        capacity: Capacity,
    },
    /// The session of this frame is not the open one.
    Unknown,
    /// State of the session and of the follower.
    Report(Report),
    /// Commanded state and angles at a moment, in pieces if there are many groups. May be lost.
    Telemetry {
        /// Microseconds on the controller's clock.
        #[serde(with = "number")]
        time: u64,
        /// State of the follower.
        state: State,
        /// Rate of the path clock, seconds of the path in a second.
        rate: f32,
        /// Position on the path.
        place: FollowerPosition<f32>,
        /// Number of the first group of this piece.
        #[serde(with = "number")]
        first: u16,
        /// Commanded angles of groups, 4 bytes each, little endian; none while it is not known where they stand.
        angles: &'a [u8],
    },
    /// Measured angles of some hinges at the moment of the [`Telemetry`](Self::Telemetry) before. May be lost.
    Measured {
        /// Microseconds on the controller's clock: those of the telemetry before.
        #[serde(with = "number")]
        time: u64,
        /// Number of the first hinge.
        #[serde(with = "number")]
        first: u16,
        /// Commanded angle of the first hinge, radians, if it was moved by [`Command::Jog`].
        target: Option<f32>,
        /// Measured angles of hinges, 4 bytes each, little endian; NaN for a hinge that was not measured.
        angles: &'a [u8],
    },
}

/// Acknowledges the items that have come, grants credit and tells the state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Report {
    /// Number of the item that is expected next: all items before it have come.
    #[serde(with = "number")]
    pub next: u16,
    /// Number of the first item for which there is no room yet.
    #[serde(with = "number")]
    pub limit: u16,
    /// Number of frames of the session that have come, modulo 2⁸.
    pub heard: u8,
    /// Lowest bits of the controller's [epoch](crate::wire::key::epoch).
    pub epoch: u8,
    /// `true` if a later item came first; told once for each gap.
    pub gap: bool,
    /// Reason why the expected item was refused when it came.
    pub refused: Option<ItemRefusal>,
    /// Number of the last command, carried out or denied.
    pub command: u8,
    /// Reason why that command was denied.
    pub denied: Option<Denial>,
    /// State of the follower.
    pub state: State,
    /// Reason why the follower does not run at full speed.
    pub reason: Reason,
    /// Position of the follower on the path.
    pub place: FollowerPosition<f32>,
    /// Number of the path on which the place is, see [`SheetHead::path`]; 0 if there was none.
    #[serde(with = "number")]
    pub path: u32,
    /// `true` if it is known where the sheet stands.
    pub known: bool,
    /// `true` if the stop line holds the motion, whatever the reason says.
    pub stopped: bool,
}

/// Reason why an item is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "Numbers")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ItemRefusal {
    /// The setpoint is not valid.
    Setpoint(Refusal),
    /// The path cannot be taken up.
    Path(Denial),
    /// The sheet has more groups, hinges or spokes than there is room for.
    Room,
    /// There are more pieces than the sheet has, or a number is cut off.
    Pieces,
    /// The sheet is not complete.
    Incomplete,
    /// The limits of this group are no range, are not above 0, or leave nothing of those of the board.
    Limits(u16),
    /// This hinge follows a group that the sheet does not have.
    Hinge(u16),
    /// The essential vertices are not valid: a group or a direction is wrong, the last spoke does not end a vertex, or
    /// there is none although the board asks for one.
    Stars,
    /// The closure residual asked for is no number, or more than the controller allows.
    Closure,
}

impl fmt::Display for ItemRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Setpoint(refusal) => write!(f, "a setpoint was refused: {refusal}"),
            Self::Path(denial) => write!(f, "the path was refused: {denial}"),
            Self::Room => {
                f.write_str("the sheet was refused: the controller has not enough room for it")
            }
            Self::Pieces | Self::Incomplete => {
                f.write_str("the sheet was refused: its pieces do not fit together")
            }
            Self::Limits(group) => write!(
                f,
                "the limits of group {group} were refused: the board's own limits leave nothing of them"
            ),
            Self::Hinge(hinge) => write!(f, "hinge {hinge} was refused: it has no group"),
            Self::Stars => f.write_str(
                "the essential vertices were refused: they are not sound, or there is none",
            ),
            Self::Closure => f.write_str(
                "the sheet was refused: its path is open by more than the controller allows",
            ),
        }
    }
}

impl core::error::Error for ItemRefusal {}

impl From<ItemRefusal> for Numbers {
    fn from(refusal: ItemRefusal) -> Self {
        match refusal {
            ItemRefusal::Setpoint(refusal) => Self::around(0, refusal),
            ItemRefusal::Path(denial) => Self::around(1, denial),
            ItemRefusal::Room => Self::variant(2),
            ItemRefusal::Pieces => Self::variant(3),
            ItemRefusal::Incomplete => Self::variant(4),
            ItemRefusal::Limits(group) => Self::of(5, group),
            ItemRefusal::Hinge(hinge) => Self::of(6, hinge),
            ItemRefusal::Stars => Self::variant(7),
            ItemRefusal::Closure => Self::variant(8),
        }
    }
}
