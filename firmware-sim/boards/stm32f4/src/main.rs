//! An example of a port, the controller on an STM32F411: see `board.rs` and `firmware-sim/PORTING.md`. It compiles and
//! links, but was never tried on hardware.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod board;

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "This program is for a microcontroller. In firmware-sim/boards: cargo build \
         --package foldpath-port-stm32f4 --profile firmware --target thumbv7em-none-eabihf"
    );
}
