//! Answers whether faces pass through each other, at one configuration or anywhere on a motion.
//!
//! This is the only module that names parry3d. Faces are cut into convex pieces. A [`CollisionScene`] judges one
//! configuration: the broad phase, a bounding volume hierarchy, finds the pairs of pieces whose boxes overlap, and the
//! narrow phase, [`crossing_depth`], judges each of these pairs. A [`Sweep`] judges a whole motion by conservative advancement. `routes.rs` decides for all callers whether the
//! lattice of a tessellation stands in for its faces, and what a search may cost.
//!
//! No pair is left out without a bound. A pair of pieces needs no query, for a while or for good, in these places.
//! Files of tests without a folder are in `tests/tests/it`:
//!
//! | place | pairs | what keeps them from crossing | tests |
//! |---|---|---|---|
//! | `Pieces::comparable`, `Sweep::classify` | of one face | they move as one | `host/tests/it/bends.rs`: a panel that bends is several faces |
//! | `Sweep::classify_side` | joined at a side | the tear moves no point of the smaller piece farther than contact; they turn about the side, by half a turn at most (`Sweep::overturned`) | `torn_sides.rs`, `exact.rs` |
//! | `Sweep::keeps_back` | plates joined at a hinge | each lies on its side of the plane that halves the angle between them; the tear moves them into each other by no more than a thousandth of their thickness | `plates.rs`, the oracle; `physics.rs` |
//! | `Sweep::open_until` | joined at a side that is torn by more | the angle between them is so large that the tear cannot move one into the other (`sides.rs`) | `torn_sides.rs` |
//! | `Side::may_cross` | joined at a side, at one configuration | the measured tear moves no point of the smaller piece farther than contact | `torn_sides.rs`, fans that cross at a knot |
//! | `Sweep::after` | any | the variation of the angles between them times levers, and twice the tears, are within their distance or angle | `campaign.rs`, torn motions; `exact.rs` |
//! | `Sweep::query_clusters` | of two clusters | the same for the spheres round the clusters | `campaign.rs`, torn motions; `skips.rs` |
//! | `SheetPairs::query` | that share no point of the flat sheet | a plane parts them over the interval, by second-order bounds | `interval_broad_phase`; `exact.rs` |
//! | `IntervalBroadPhase::is_body` | at rest relative to each other over a segment | all creases between them along the tree keep their angles | `host/tests/it/sweep.rs`, layers that rested |
//! | `ComovingNow::until` | at rest relative to each other | the bound on their relative motion is within contact | `comoving_faces.rs`; `wrong_paths.rs`, layers that leave through each other |
//! | `LatticePairs` | that a pair of the lattice stands for | they move alike, up to the deviation of the lattice | `skips.rs`; `host/tests/it/lattice.rs` |
//! | `Sweep::at_contact` | in contact | a plane stays between them, or all turns together move one by no more than `Sweep::after` admits, by second-order bounds | `wrong_paths.rs`, layers that leave through each other; `exact.rs` |
//! | the boxes of `CollisionScene` | any, at one configuration | their boxes do not overlap | `host/tests/it/clearance.rs`; `campaign.rs`, the oracle |

mod convex;
mod hierarchy;
mod layer_order;
mod narrow;
mod pairs;
mod pieces;
mod placed_pieces;
mod routes;
mod scene;
mod sides;
mod solids;
mod sweep;
mod tolerances;

pub use layer_order::faces_without_order;
pub use narrow::crossing::{ConvexPiece, crossing_depth, side_crossing_depth};
pub use narrow::separation::distance;
pub(crate) use narrow::separation::face_distance;
pub use pieces::contact_tolerance;
pub(crate) use routes::{Openness, Routed, SearchEffort, Searched, SearchedSheet};
pub use scene::{CollisionScene, Crossing};
pub(crate) use solids::thickest;
pub use solids::{Plate, PlateError, PlateMesh, Plates, SheetMesh, Thickest, TooThick, Trims};
pub use sweep::{Clearance, Place, Sweep, SweepCounts, SweepOptions, SweepVerdict};
pub use tolerances::CONTACT_EDGES;
pub(crate) use tolerances::CROSSING_DEPTH_EDGES;
