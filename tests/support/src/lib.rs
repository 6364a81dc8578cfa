//! Helpers that the tests of all packages share: seeded noise, stars, closed forms, commands in temporary folders, and
//! JSON documents.
//!
//! The crate depends on no package but `foldpath-core`, so that core's tests build without the host.

pub mod closed_form;
mod folder;
mod json;
mod precision;
mod random;
pub mod stars;

pub use folder::{Answer, Folder};
pub use json::{edited, numbers};
pub use precision::cast;
pub use random::Random;
