//! Answers whether faces pass through each other, at one configuration or anywhere on a motion.
//!
//! This is the only module that names parry3d. Faces are cut into convex pieces. A [`CollisionScene`] judges one
//! configuration: the broad phase, a bounding volume hierarchy, finds the pairs of pieces whose boxes overlap, and the narrow phase, [`crossing_depth`], judges each of these pairs. A
//! [`Sweep`] judges a whole motion by conservative advancement. `routes.rs` decides for all callers whether the
//! lattice of a tessellation stands in for its faces, and what a search may cost.
//!
//! No pair is left out without a bound. A pair of pieces needs no query, for a while or for good, in these places:
//!
//! | place | pairs | what keeps them from crossing |
//! |---|---|---|
//! | `Pieces::comparable`, `Sweep::classify` | of one face | they move as one |
//! | `Sweep::classify_side` | joined at a side | the tear moves no point of the smaller piece farther than contact; they turn about the side, by half a turn at most (`Sweep::overturned`) |
//! | `Sweep::open_until` | joined at a side that is torn by more | the angle between them is so large that the tear cannot move one into the other (`sides.rs`) |
//! | `Side::may_cross` | joined at a side, at one configuration | the measured tear moves no point of the smaller piece farther than contact |
//! | `Sweep::after` | any | the variation of the angles between them times levers, and twice the tears, are within their distance or angle |
//! | `Sweep::query_clusters` | of two clusters | the same for the spheres round the clusters |
//! | `SheetPairs::query` | that share no point of the flat sheet | a plane parts them over the interval, by second-order bounds |
//! | `ComovingNow::until` | at rest relative to each other | the bound on their relative motion is within contact |
//! | `LatticePairs` | that a pair of the lattice stands for | they move alike, up to the deviation of the lattice |
//! | `Sweep::at_contact` | in contact | a plane stays between them, by second-order bounds |
//! | the boxes of `CollisionScene` | any, at one configuration | their boxes do not overlap |

mod convex;
mod hierarchy;
mod narrow;
mod pairs;
mod pieces;
mod placed_pieces;
mod routes;
mod scene;
mod sides;
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
