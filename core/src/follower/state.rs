//! What a follower does, why, and what it is told.

use serde::{Deserialize, Serialize};

use crate::Scalar;
use crate::acceptance::Refusal;
use crate::path_clock::ClockLimits;

/// What a follower does.
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

/// Why a follower does not run at full speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reason {
    /// Nothing keeps it.
    #[default]
    None,
    /// The host asked for it.
    Asked,
    /// The queue has run dry.
    Underrun,
    /// The host has been silent for too long.
    Silence,
    /// This hinge lags.
    Lag(u32),
    /// The stop line.
    StopLine,
    /// Another host has come.
    Session,
    /// A setpoint was refused.
    Refused(Refusal),
    /// This hinge has stalled.
    Stalled(u32),
}

/// Why a command is not carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Denial {
    /// Not in this state.
    State,
    /// The sheet moves.
    Moving,
    /// The sheet has more groups than there is room for, or none.
    Groups,
    /// No setpoint is queued.
    Empty,
    /// The place to begin at is not on the first segment.
    Place,
    /// This group stands too far from the beginning of the path.
    Jump(u16),
    /// The stop line is drawn, or no one has asked to go on since something held the motion.
    Held,
}

/// A place on a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Place<T> {
    /// Number of the knot at it or before it.
    pub knot: u32,
    /// Seconds behind that knot.
    pub into: T,
}

/// Options of a [`Follower`](crate::follower::Follower). Times in microseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options<T> {
    /// How fast the path clock may change. An acceleration of a hinge grows by at most its speed times this.
    pub clock: ClockLimits<T>,
    /// Silence of the host after which the motion holds.
    pub silence: u32,
    /// No tick passes for longer than this.
    pub longest_tick: u32,
    /// Distance between a hinge and its command from which on the clock slows, radians.
    pub lag: T,
    /// Distance from which on it holds. Braking takes the command on by up to speed / (2 · brake).
    pub most_lag: T,
    /// Time that a hinge may lag by so much before the motion fails.
    pub stall: u32,
    /// How far each group may stand from where a path begins, radians.
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
