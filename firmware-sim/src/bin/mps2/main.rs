//! The controller's image for Arm's MPS2 boards AN386 and AN500, as QEMU emulates them: room for every pattern
//! of `patterns/`. Only `board.rs` knows the board.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::indexing_slicing)]

#[cfg(target_os = "none")]
mod board;

#[cfg(target_os = "none")]
mod sizes {
    /// Largest numbers of groups, of hinges, of spokes of essential vertices, and of setpoints in the queue.
    pub(crate) const GROUPS: usize = 256;
    pub(crate) const HINGES: usize = 2048;
    pub(crate) const SPOKES: usize = 512;
    pub(crate) const KNOTS: usize = 32;
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "This program is for a microcontroller: firmware-sim/README.md says how to build and run it."
    );
}
