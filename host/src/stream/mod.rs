//! Sends a path to a controller and follows its motion.
//!
//! - [`StreamPath`]: the content of a `.traj` file in the form in which it is sent.
//! - [`Link`]: bytes to a controller and back. [`Sim`] is a controller in this process in virtual time, which may drive
//!   a [`Plant`]; [`Faulty`] adds faults to any link. Links over TCP, serial devices and QEMU are in the command's
//!   package.
//! - [`pair`]: gives a controller a [`Key`](foldpath_core::wire::key::Key) over a local line.
//! - [`Bench`]: a session that watches and moves one hinge at a time, and [`Channels`], the map from hinges to channels.
//! - [`run`]: a session from the greeting to its [`Outcome`], over [`foldpath_core::wire::driver`].

mod bench;
mod channels;
mod ending;
mod faulty;
mod link;
mod pair;
mod path;
mod plant;
mod script;
mod session;
mod sim;
mod telemetry;

pub use bench::{Bench, BenchError, Jogged, Seen, Way};
pub use channels::{Channel, Channels};
pub use ending::Ending;
pub use faulty::Faulty;
pub use link::Link;
pub use pair::{Pairing, pair};
pub use path::StreamPath;
pub use plant::Plant;
pub use script::parse_script;
pub use session::{Options, Outcome, Stands, Summary, Watcher, Wish, run};
pub use sim::{Sim, SimDevice};
pub use telemetry::{Lag, Measured, Telemetry};
