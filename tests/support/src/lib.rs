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

use foldpath_core::Curve;
use foldpath_core::trajectory_file::TrajectoryFile;

/// Returns the motion of a group in a file from knot number `segment` to the next knot; `None` if there is none.
#[must_use]
pub fn curve(file: &TrajectoryFile<'_>, segment: usize, group: usize) -> Option<Curve<f32>> {
    let next = segment.checked_add(1)?;
    let span = file.time(next)? - file.time(segment)?;
    let (from, to) = (file.node(segment, group)?, file.node(next, group)?);
    Some(Curve::between(file.interpolation(), span, from, to))
}
