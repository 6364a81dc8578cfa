//! Symmetry: finds crease groups from the pattern alone, and the few closure conditions that remain.

mod essential;
mod essential_pattern;
mod group_search;
mod groups;
mod isometry;
mod places;
mod signed_union_find;
mod snapping;

pub use essential::{ReducedStars, closure_of, largest_star_residual};
pub use essential_pattern::essential_pattern;
pub use groups::CreaseGroups;
