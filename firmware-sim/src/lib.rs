//! The controller's program without its board. It runs on the microcontroller, and on the host when a test compares the
//! two.
#![no_std]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::indexing_slicing)]

#[cfg(not(target_os = "none"))]
extern crate std;

#[cfg(not(target_os = "none"))]
pub mod faults;
pub mod figures;
#[cfg(not(target_os = "none"))]
pub mod hinges;
pub mod plant;
pub mod probe;

#[cfg(not(target_os = "none"))]
pub use foldpath_controller as controller;
