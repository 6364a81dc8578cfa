//! Answers whether faces pass through each other, at one configuration or anywhere on a motion.
//!
//! This is the only module that names parry3d. Faces are cut into convex pieces. Two pieces joined by an edge
//! need no test: they cannot cross while the fold angle between them is within half a turn. A
//! [`CollisionScene`] judges one configuration: the broad phase, a bounding volume hierarchy, finds the pairs
//! of pieces whose boxes overlap, and the narrow phase, [`crossing_depth`], judges each of these pairs. A
//! [`Sweep`] judges a whole motion by conservative advancement. `routes.rs` decides for all callers whether the
//! lattice of a tessellation stands in for its faces, and what a search may cost.

mod hierarchy;
mod narrow;
mod pairs;
mod pieces;
mod placed_pieces;
mod routes;
mod scene;
mod sweep;
mod tolerances;

pub use narrow::crossing::{ConvexPiece, crossing_depth, side_crossing_depth};
pub use narrow::separation::distance;
pub(crate) use narrow::separation::face_distance;
pub use pieces::contact_tolerance;
pub(crate) use routes::{Openness, Routed, SearchEffort, Searched, SearchedSheet};
pub use scene::{CollisionScene, Crossing};
pub use sweep::{Clearance, Place, Sweep, SweepCounts, SweepOptions, SweepVerdict};
pub use tolerances::CONTACT_EDGES;
