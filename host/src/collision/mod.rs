//! Whether faces pass through each other at a configuration.
//!
//! The only place that knows parry3d. Faces are cut in convex pieces; a bounding volume hierarchy
//! finds the pairs whose boxes meet, and each such pair is judged by [`crossing_depth`]. Pieces
//! joined by an edge need no look: they cannot cross while their fold angle is within half a turn.

mod crossing;
mod scene;

pub use crossing::{ConvexPiece, crossing_depth, side_crossing_depth};
pub use scene::{CollisionCounts, CollisionScene, Crossing};
