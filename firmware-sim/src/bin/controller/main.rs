//! The controller's image for QEMU's `mps2-an386` and `mps2-an500` boards: see `app.rs`.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::indexing_slicing)]

#[cfg(target_os = "none")]
mod app;
#[cfg(target_os = "none")]
mod mps2;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("This program is for a microcontroller: firmware-sim/PROTOCOL.md says how to talk to it.");
}
