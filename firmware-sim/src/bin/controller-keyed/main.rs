//! The controller's image for Arm's MPS2 boards AN386 and AN500, as QEMU emulates them, with room for a key.
//! It differs from the image `foldpath-controller` only by this room.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::indexing_slicing)]

#[cfg(target_os = "none")]
#[path = "../controller/mps2.rs"]
mod mps2;

#[cfg(target_os = "none")]
use foldpath_core::wire::protection::Keyed as Protection;

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "This program is for a microcontroller: firmware-sim/README.md says how to build and run it."
    );
}
