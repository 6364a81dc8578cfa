//! The probe's image for QEMU's `mps2-an386` board, a Cortex-M4F: see `board.rs`.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::indexing_slicing)]

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod figures;
#[cfg(target_os = "none")]
mod probe;

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "This program is for a microcontroller. With qemu-system-arm, `cargo firmware` runs it."
    );
}
