//! The states of a follower, the reasons for slowing or holding, its options, and its answers to commands.

use serde::{Deserialize, Serialize};

use crate::Scalar;
use crate::acceptance::Refusal;
use crate::path_clock::ClockLimits;

/// State of a follower.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
    /// A hinge has stalled; nothing moves.
    Faulted,
}

/// Reason why a follower does not run at full speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reason {
    /// Nothing slows or holds the motion.
    #[default]
    None,
    /// The host asked to hold.
    Asked,
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
    /// This hinge has stalled.
    Stalled(u32),
}

/// Reason why a command is not carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Denial {
    /// The command is not allowed in this state.
    State,
    /// The sheet is moving.
    Moving,
    /// The sheet has more groups than there is room for, no group, or other groups than those that stand.
    Groups,
    /// No setpoint is queued.
    Empty,
    /// The position to begin at is not on the first segment.
    Place,
    /// This group stands too far from the beginning of the path.
    Jump(u16),
    /// The stop line is drawn, or something held the motion and nobody has asked to resume since.
    Held,
}

/// A position on a path; the protocol calls it a place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FollowerPosition<T> {
    /// Number of the last knot at or before the position.
    pub knot: u32,
    /// Seconds behind that knot.
    pub into: T,
}

/// Options of a [`Follower`](crate::follower::Follower). Times are microseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options<T> {
    /// Limits on the change of the path clock's rate. They add at most the hinge's speed times this to the acceleration
    /// of a hinge.
    pub clock: ClockLimits<T>,
    /// Silence of the host after which the motion holds.
    pub silence: u32,
    /// Longest time that one tick lets pass.
    pub longest_tick: u32,
    /// Distance between a hinge and its command above which the clock slows, radians.
    pub lag: T,
    /// Distance between a hinge and its command from which on the motion holds, radians. Braking moves the command on
    /// by up to speed / (2 · brake).
    pub most_lag: T,
    /// Time for which a hinge may lag by `most_lag` before the motion fails.
    pub stall: u32,
    /// Largest distance of a group from the beginning of a path at which the path may start, radians.
    pub jump: T,
}

impl<T: Scalar> Default for Options<T> {
    fn default() -> Self {
        Self {
            clock: ClockLimits {
                rise: T::lit(4.0),
                brake: T::lit(4.0),
            },
            silence: 500_000,
            longest_tick: 10_000,
            lag: T::lit(0.05),
            most_lag: T::lit(0.15),
            stall: 1_000_000,
            jump: T::lit(0.01),
        }
    }
}
