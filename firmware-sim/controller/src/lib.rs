//! Follows a planned folding path on a microcontroller: everything but the board.
//!
//! [`Application`] is the main loop: a board offers it a serial line by the traits of [`embedded_io`] and a [`Board`].
//! [`Controller`] is what it drives, without a clock, a line or hinges of its own: bytes and ticks go in, angles and bytes
//! come out. A program with a main loop of its own, such as an async framework, drives it itself.
//!
//! Nothing here allocates, waits or panics.
#![no_std]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::indexing_slicing)]

#[cfg(test)]
extern crate std;

mod application;
mod channel;
mod controller;
mod fifo;
#[cfg(feature = "embedded-hal")]
pub mod hal;
mod jog;
mod loader;
mod player;
mod power;
pub mod retained;
pub mod servo_bus;
pub mod sheet;
mod snapshot;
pub mod stored;
mod window;

pub use application::{Application, Board, TICK};
pub use channel::Channel;
pub use controller::{ALONE, Condition, Controller, FRAME, Settings, WAITING};
pub use fifo::{Fifo, Line};
pub use player::{PlayRefusal, Player, PlayerError};
pub use power::{Hold, Power};
