//! Lines to controllers that need an operating system: TCP, serial devices, and a controller in QEMU.

mod emulator;
mod wire;

pub use emulator::{Emulator, default_image};
pub use wire::Wire;
pub(crate) use wire::with_host;
