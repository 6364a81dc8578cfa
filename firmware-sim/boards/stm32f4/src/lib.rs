//! The parts of this port that run on any machine, so that a test runs them: sizes, limits, and the numbers of servos
//! and potentiometers.
#![no_std]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::indexing_slicing)]

use core::f32::consts::PI;

use foldpath_core::GroupLimits;

/// Number of hinges, each with a servo.
pub const HINGES: usize = 4;
/// Number of groups for which there is room: each hinge may be a group of its own.
pub const GROUPS: usize = HINGES;
/// Number of spokes of essential vertices for which there is room: one vertex between all hinges.
pub const SPOKES: usize = HINGES;
/// Number of setpoints in the queue.
pub const KNOTS: usize = 16;

/// Limits of every hinge: a quarter turn each way, at the speed of a small servo.
pub const LIMITS: GroupLimits = GroupLimits {
    lower: -PI / 2.0,
    upper: PI / 2.0,
    speed: 5.0,
    acceleration: f32::INFINITY,
};

/// Pulse of a servo at angle 0 (`MIDDLE`) and its growth for each radian (`RADIAN`), microseconds. A servo turns a
/// quarter turn each way.
const MIDDLE: f32 = 1500.0;
const RADIAN: f32 = 1000.0 / PI;
/// Reading of a potentiometer at angle 0 (`ZERO`) and its growth for each radian (`READING`): the quarter turns take four
/// fifths of the range. Both have to be calibrated for each servo.
const ZERO: f32 = 2048.0;
const READING: f32 = 0.8 * 2048.0 / (PI / 2.0);
/// Distance from `ZERO` from which on a reading tells of a wire that is broken or shorted: no servo turns so far.
const BROKEN: f32 = 0.95 * 2048.0;

/// Returns the pulse of a servo at this angle (radians), microseconds.
#[must_use]
pub fn pulse(angle: f32) -> u16 {
    let pulse = (MIDDLE + RADIAN * angle).clamp(1000.0, 2000.0);
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 1000 to 2000"
    )]
    let pulse = (pulse + 0.5) as u16;
    pulse
}

/// Returns the angle at which a potentiometer has this reading, radians; NaN, which holds the motion, for a wire that is
/// broken or shorted.
#[must_use]
pub fn angle(reading: u16) -> f32 {
    let off = f32::from(reading) - ZERO;
    if off.abs() < BROKEN {
        off / READING
    } else {
        f32::NAN
    }
}

/// The path in flash, which the button plays.
pub const PATH: &[u8] = include_bytes!("../example/vertex.traj");

/// Press of the button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Press {
    /// Pressed it: to start, hold or resume the path.
    Short,
    /// Kept it down for two seconds: to say that the sheet stands where the path begins, and to start.
    Long,
}

/// A button that is looked at each millisecond.
#[derive(Clone, Copy, Debug, Default)]
pub struct Button {
    /// Milliseconds for which it is down.
    down: u32,
}

impl Button {
    /// Milliseconds for which contacts bounce at most (`BOUNCE`), and after which a press is a long one (`LONG`).
    const BOUNCE: u32 = 20;
    const LONG: u32 = 2000;

    /// Takes its level for one more millisecond. A short press is told when the button comes up, a long one while it is
    /// down.
    pub fn look(&mut self, is_down: bool) -> Option<Press> {
        let before = self.down;
        self.down = if is_down { before.saturating_add(1) } else { 0 };
        if self.down == Self::LONG {
            Some(Press::Long)
        } else if !is_down && (Self::BOUNCE..Self::LONG).contains(&before) {
            Some(Press::Short)
        } else {
            None
        }
    }
}
