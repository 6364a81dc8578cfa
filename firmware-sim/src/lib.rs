//! Surroundings of a simulated controller: a line and hinges with faults on the host, and the hinges of the emulated board.
#![no_std]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::indexing_slicing)]

#[cfg(not(target_os = "none"))]
extern crate std;

#[cfg(not(target_os = "none"))]
pub mod faults;
#[cfg(not(target_os = "none"))]
pub mod hinges;
pub mod plant;

#[cfg(not(target_os = "none"))]
pub use foldpath_controller as controller;
