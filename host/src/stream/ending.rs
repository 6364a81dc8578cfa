//! Reason why a session ended before its path did.

use std::fmt;

use foldpath_core::follower::{Denial, Reason};
use foldpath_core::wire::message::{Capacity, ItemRefusal};
use foldpath_core::wire::sender::Failure;

/// Reason why a session ended before its path did.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Ending {
    /// The line cannot be opened, or is broken: its name, and what the operating system says.
    Line(String),
    /// There is no session with the controller.
    NoSession(Failure),
    /// The watcher left at once, and the host cannot draw the stop line.
    Left,
    /// The watcher stopped the motion at once by the stop line.
    Quit {
        /// `true` if the controller has reported that the line is drawn.
        reported: bool,
    },
    /// The watcher stopped the motion before it began.
    NotBegun,
    /// The watcher stopped the motion, and the sheet rests.
    Stopped,
    /// The controller holds the motion.
    Held(Reason),
    /// The motion has failed.
    Failed {
        /// What failed.
        reason: Reason,
        /// `true` if the stop line is drawn as well, and has to be let go.
        stopped: bool,
    },
    /// The controller has told angles on the path at which an essential vertex is open by this closure residual, more than
    /// the path.
    Torn(f64),
    /// The sheet stands at this knot, which is not on the path.
    OffPath(u32),
    /// The controller has refused an item.
    Refused {
        /// The reason of the refusal.
        item: ItemRefusal,
        /// Number of the knot that the controller expected next.
        knot: u64,
        /// Room of the controller.
        room: Capacity,
    },
    /// The controller does not begin the motion.
    Denied(Denial),
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(what) => f.write_str(what),
            Self::NoSession(failure) => failure.fmt(f),
            Self::Left => f.write_str("left at once; the controller holds when it hears nothing"),
            Self::Quit { reported: true } => f.write_str("stopped at once by the stop line"),
            Self::Quit { reported: false } => {
                f.write_str("the stop line was drawn; no word of it came")
            }
            Self::NotBegun => f.write_str("stopped before it began"),
            Self::Stopped => f.write_str("stopped"),
            Self::Held(reason)
            | Self::Failed {
                reason,
                stopped: false,
            } => reason.fmt(f),
            Self::Failed {
                reason,
                stopped: true,
            } => write!(
                f,
                "{reason}. The stop line holds the motion as well and has to be let go"
            ),
            Self::Torn(closure) => write!(
                f,
                "the controller told angles that tear the sheet: closure {closure:.1e}, more than the path has"
            ),
            Self::OffPath(knot) => {
                write!(f, "the sheet stands at knot {knot}, not on this path")
            }
            Self::Refused { item, knot, room } => match item {
                ItemRefusal::Setpoint(refusal) => write!(f, "knot {knot} was refused: {refusal}"),
                ItemRefusal::Room => write!(
                    f,
                    "the sheet was refused: the controller has room for {} groups, {} hinges and {} spokes",
                    room.groups, room.hinges, room.spokes
                ),
                item => item.fmt(f),
            },
            Self::Denied(denial) => denial.fmt(f),
        }
    }
}
