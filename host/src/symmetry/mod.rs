//! Symmetry: finds crease groups and lattices from the pattern alone, and the few closure conditions that remain.

mod essential;
mod groups;
mod isometry;
mod lattice;
mod pair_classes;
mod parity;
mod places;
mod steps;
mod unrounded;

pub use essential::{ReducedStars, essential_pattern, largest_star_residual};
pub use groups::CreaseGroups;
pub use lattice::{Lattice, Link, Orbit, Place};
pub use pair_classes::PairClass;
