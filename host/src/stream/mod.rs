//! Sending a path to a controller and following what it does.
//!
//! - [`StreamPath`]: a path with its sheet, as it is sent.
//! - [`Link`]: bytes to a controller and back: [`Sim`], one in this process in virtual time; [`Tcp`].
//! - [`run`]: a session from the greeting to its [`Outcome`], over [`foldpath_core::wire::driver`].

mod link;
mod path;
mod session;
mod sim;
mod words;

pub use link::{Link, Tcp};
pub use path::StreamPath;
pub use session::{Options, Outcome, Summary, Telemetry, Watcher, Wish, run};
pub use sim::Sim;
