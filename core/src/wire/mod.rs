//! The protocol between a host and a controller over a line that loses, changes, doubles and reorders bytes.
//!
//! Everything here is a pure state machine: bytes, frames and times come in as arguments, frames go out.
//! `firmware-sim/PROTOCOL.md` describes every byte and every rule.
//!
//! - [`cobs`]: frames from bytes; a lost byte costs one frame.
//! - [`driver`]: the policy of a host, commands and their times.
//! - [`frame`]: a session, a message and a CRC-32 in a frame.
//! - [`message`]: the messages.
//! - [`key`], [`protection`]: keys, and frames that only their owners can make.
//! - [`sender`], [`receiver`]: the two ends. Items come through once each, in order, and never more than there is room
//!   for.
//! - [`path`], [`file`](mod@file): a path and its sheet as items, from memory and from a trajectory file.
//! - [`transmit`]: bytes that wait for the line; telemetry gives way to answers.

pub mod cobs;
mod credentials;
pub mod driver;
pub mod file;
pub mod frame;
pub mod key;
pub mod message;
pub mod path;
pub mod protection;
pub mod receiver;
pub mod sender;
mod sequence;
pub mod transmit;

pub use sequence::low_bits;
