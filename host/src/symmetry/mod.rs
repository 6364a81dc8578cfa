//! Symmetry: crease groups found from the pattern alone, and the few closure conditions that remain.

mod essential;
mod groups;
mod isometry;
mod parity;
mod places;

pub use essential::{ReducedStars, essential_pattern};
pub use groups::CreaseGroups;
