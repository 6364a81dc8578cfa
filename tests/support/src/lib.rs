//! What the tests of all packages share: seeded noise, builders, closed forms, and commands in temporary folders.
//!
//! It depends on no package but `foldpath-core`, so that core's tests build without the host.

pub mod closed_form;
mod folder;
mod json;
mod random;

pub use folder::{Answer, Folder};
pub use json::{edited, numbers};
pub use random::Random;
