//! Sending a path to a controller and following what it does.
//!
//! - [`StreamPath`]: the content of a `.traj` file, as it is sent.
//! - [`Link`]: bytes to a controller and back: [`Sim`], one in this process in virtual time, which may drive a
//!   [`Plant`]; [`Wire`], one behind TCP or a serial device; [`Emulator`], one in QEMU; [`Faulty`], any of them with
//!   faults.
//! - [`run`]: a session from the greeting to its [`Outcome`], over [`foldpath_core::wire::driver`].

mod emulator;
mod faulty;
mod link;
mod path;
mod plant;
mod script;
mod session;
mod sim;
mod words;

pub use emulator::{Emulator, default_image};
pub use faulty::Faulty;
pub use link::{Link, Wire};
pub use path::StreamPath;
pub use plant::Plant;
pub use script::script;
pub use session::{Options, Outcome, Summary, Telemetry, Watcher, Wish, run};
pub use sim::Sim;
