//! An example of a port to an async framework, embassy, on an STM32F407 with servos on a bus: see `board.rs` and
//! `firmware-sim/PORTING.md`. It compiles and links, but was never tried on hardware.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod board;

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "This program is for a microcontroller. In firmware-sim/boards: cargo build \
         --package foldpath-port-embassy-stm32f4 --profile firmware --target thumbv7em-none-eabihf"
    );
}
