//! Symmetry: finds crease groups from the pattern alone, and the few closure conditions that remain.

mod essential;
mod groups;
mod isometry;
mod places;
mod signed_union_find;
mod unrounded;

pub use essential::{ReducedStars, closure_of, essential_pattern, largest_star_residual};
pub use groups::CreaseGroups;
