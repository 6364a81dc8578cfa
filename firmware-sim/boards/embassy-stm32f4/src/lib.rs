//! The parts of this port that run on any machine: sizes and limits.
#![no_std]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::indexing_slicing)]

use core::f32::consts::PI;

use foldpath_controller::TICK;
use foldpath_controller::servo_bus::{ANSWER_US, packets};
use foldpath_core::GroupLimits;

/// Number of hinges, each with a servo: those of `patterns/miura-3x3.fold`.
pub const HINGES: usize = 12;
/// Number of groups for which there is room: each hinge may be a group of its own.
pub const GROUPS: usize = HINGES;
/// Number of spokes of essential vertices for which there is room: four vertices of four creases.
pub const SPOKES: usize = 16;
/// Number of setpoints in the queue.
pub const KNOTS: usize = 32;

/// Limits of every hinge: 5/6 of a half turn each way, at the speed of a small servo on a bus.
pub const LIMITS: GroupLimits = GroupLimits {
    lower: -PI * 5.0 / 6.0,
    upper: PI * 5.0 / 6.0,
    speed: 4.0,
    acceleration: f32::INFINITY,
};

/// Bits a second on the bus, of which a byte takes ten.
pub const BAUD: u32 = 1_000_000;

/// The packet of a tick, the question to a servo and its answer are over before the next tick.
const _: () = {
    let bytes = packets::goals_len(HINGES) + packets::READ + packets::ANSWER;
    assert!(10 * bytes as u64 * 1_000_000 / (BAUD as u64) + ANSWER_US < TICK);
};
