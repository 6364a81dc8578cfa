//! The states of a follower, the reasons for slowing or holding, and its answers to commands.
//!
//! The enumerations here and in [`wire::message`](crate::wire::message) list all variants, so that a program that matches
//! them misses none. A new variant changes the protocol, and is a new minor version of this crate before 1.0.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::acceptance::Refusal;
use crate::numbers::{Numbers, number};

/// State of a follower.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "Numbers")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// There is no path.
    #[default]
    Idle,
    /// There is a path, and the motion has not begun.
    Ready,
    /// Moving along the path.
    Running,
    /// Slowing down along the path, or at rest on it.
    Holding,
    /// At the end of the path.
    Done,
    /// Something failed, see [`Fault`]; nothing moves.
    Faulted,
}

impl From<State> for Numbers {
    fn from(state: State) -> Self {
        Self::variant(state as u32)
    }
}

/// Failure that ends a motion. It stays until it is [cleared](crate::follower::Follower::clear).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "Numbers")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Fault {
    /// This hinge did not follow its command.
    Stalled(u32),
    /// The next command of this group would have been farther away than its largest speed allows.
    Leap(u16),
    /// This essential vertex would not have been closed at the next command: panels would have been torn.
    Torn(u16),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stalled(hinge) => write!(f, "hinge {hinge} has stalled"),
            Self::Leap(group) => {
                write!(
                    f,
                    "group {group} would have moved farther in a tick than it may"
                )
            }
            Self::Torn(star) => write!(f, "essential vertex {star} would have been torn"),
        }
    }
}

impl From<Fault> for Numbers {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Stalled(hinge) => Self::of(0, hinge),
            Fault::Leap(group) => Self::of(1, group),
            Fault::Torn(star) => Self::of(2, star),
        }
    }
}

/// Reason why a follower does not run at full speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "Numbers")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reason {
    /// Nothing slows or holds the motion.
    #[default]
    None,
    /// The host asked to hold.
    HoldCommand,
    /// The queue has run dry.
    Underrun,
    /// The host has been silent for too long.
    Silence,
    /// This hinge lags behind its command.
    Lag(u32),
    /// The stop line was drawn.
    StopLine,
    /// Another host has opened a session.
    Session,
    /// A setpoint was refused.
    Refused(Refusal),
    /// The motion has failed.
    Fault(Fault),
    /// The groups slowly approach the beginning of the path.
    Approach,
    /// The motion has reached the place that was set from outside as its bound.
    Lease,
    /// The last tick came later than [`Options::longest_tick`](crate::follower::Options::longest_tick), so that a part of the
    /// time does not count.
    LateTick,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "nothing holds the motion",
            Self::HoldCommand => "a host has asked to hold",
            Self::Underrun => "the queue ran dry",
            Self::Silence => "the controller did not hear its host for a while",
            Self::Lag(hinge) => return write!(f, "hinge {hinge} lags"),
            Self::StopLine => "the stop line was drawn",
            Self::Session => "the sheet moved for another host when this one came",
            Self::Refused(refusal) => return write!(f, "a setpoint was refused: {refusal}"),
            Self::Fault(fault) => return fault.fmt(f),
            Self::Approach => "the groups approach the beginning of the path",
            Self::Lease => "the motion has reached its bound",
            Self::LateTick => "the controller's ticks come late",
        })
    }
}

impl Reason {
    /// Returns `true` if this reason slows or holds the motion only while it lasts, and not until somebody resumes.
    #[must_use]
    pub fn passes(self) -> bool {
        matches!(
            self,
            Self::None
                | Self::Underrun
                | Self::Lag(_)
                | Self::Approach
                | Self::Lease
                | Self::LateTick
        )
    }
}

impl From<Reason> for Numbers {
    fn from(reason: Reason) -> Self {
        match reason {
            Reason::None => Self::variant(0),
            Reason::HoldCommand => Self::variant(1),
            Reason::Underrun => Self::variant(2),
            Reason::Silence => Self::variant(3),
            Reason::Lag(hinge) => Self::of(4, hinge),
            Reason::StopLine => Self::variant(5),
            Reason::Session => Self::variant(6),
            Reason::Refused(refusal) => Self::around(7, refusal),
            Reason::Fault(fault) => Self::around(8, fault),
            Reason::Approach => Self::variant(9),
            Reason::Lease => Self::variant(10),
            Reason::LateTick => Self::variant(11),
        }
    }
}

/// Reason why a command is not carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "Numbers")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Denial {
    /// The command is not allowed in this state.
    State,
    /// The sheet is moving.
    Moving,
    /// The sheet has no group, or more groups than there is room for.
    Groups,
    /// No setpoint is queued.
    Empty,
    /// The position to begin at is not on the first segment.
    Place,
    /// This group stands too far from the beginning of the path. If one hinge is to move alone, this is its number: it was
    /// measured too far from where it is said to stand, or stands too far from its limits.
    Jump(u16),
    /// The stop line is drawn, or something held the motion and nobody has asked to resume since.
    Held,
    /// It is not known where this group stands: no hinge of it was measured, and nobody has told it. If one hinge is to move
    /// alone, this is its number, and it is not known where it stands.
    Unknown(u16),
    /// The measured angles of this group's hinges differ too much to be one angle.
    Spread(u16),
    /// The angle is no number or beyond the limits of the board for its hinge, or the board has no such hinge.
    Range,
    /// The nonce of the controller does not vary, so that frames that somebody has recorded could move the sheet.
    Nonce,
}

impl fmt::Display for Denial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::State => f.write_str("the controller cannot do that in its state"),
            Self::Moving => f.write_str("the sheet still moves"),
            Self::Groups => f.write_str("the controller has another number of crease groups"),
            Self::Empty => f.write_str("no setpoint is queued"),
            Self::Place => {
                f.write_str("the sheet does not stand on the first segment that was sent")
            }
            Self::Jump(group) => write!(f, "group {group} stands elsewhere than the path begins"),
            Self::Held => f.write_str("something holds the motion"),
            Self::Unknown(group) => write!(
                f,
                "the controller does not know where group {group} stands, and measures none of its hinges"
            ),
            Self::Spread(group) => {
                write!(
                    f,
                    "the hinges of group {group} are measured at different angles"
                )
            }
            Self::Range => f.write_str(
                "the angle is beyond the limits of the controller's board for this hinge",
            ),
            Self::Nonce => f.write_str(
                "the controller has no nonce that varies, so that recorded frames could move the sheet",
            ),
        }
    }
}

impl core::error::Error for Denial {}

impl From<Denial> for Numbers {
    fn from(denial: Denial) -> Self {
        match denial {
            Denial::State => Self::variant(0),
            Denial::Moving => Self::variant(1),
            Denial::Groups => Self::variant(2),
            Denial::Empty => Self::variant(3),
            Denial::Place => Self::variant(4),
            Denial::Jump(group) => Self::of(5, group),
            Denial::Held => Self::variant(6),
            Denial::Unknown(group) => Self::of(7, group),
            Denial::Spread(group) => Self::of(8, group),
            Denial::Range => Self::variant(9),
            Denial::Nonce => Self::variant(10),
        }
    }
}

/// A position on a path; the protocol calls it a place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FollowerPosition<T> {
    /// Number of the last knot at or before the position.
    #[serde(with = "number")]
    pub knot: u32,
    /// Seconds behind that knot.
    pub into: T,
}
