//! Whether faces pass through each other, at a configuration or anywhere on a motion.
//!
//! The only place that knows parry3d. Faces are cut in convex pieces. Pieces joined by an edge need no
//! look: they cannot cross while their fold angle is within half a turn. A [`CollisionScene`] asks at one
//! configuration: a bounding volume hierarchy finds the pairs whose boxes meet, and each such pair is
//! judged by [`crossing_depth`]. A [`Sweep`] asks for a whole motion.

mod cells;
mod chains;
mod contact;
mod course;
mod crossing;
mod hierarchy;
mod lattice_scene;
mod layers;
mod motion;
mod near_cells;
mod pieces;
mod scene;
mod separation;
mod sheet;
mod sweep;
mod together;
mod variation;

pub use crossing::{ConvexPiece, crossing_depth, side_crossing_depth};
pub use lattice_scene::LatticeScene;
pub use pieces::rounding;
pub use scene::{CollisionCounts, CollisionScene, Crossing};
pub use separation::distance;
pub use sweep::{Clearance, Place, Sweep, SweepCounts, SweepOptions, SweepVerdict};
