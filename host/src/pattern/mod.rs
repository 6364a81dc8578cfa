//! Crease patterns: the flat sheet as a straight-edged planar graph.
//!
//! A [`Drawing`] has the content of a file. A [`CreasePattern`] is built from it: faces are found, every reference is
//! checked, vertices are classified as real or virtual, and panels are triangulated.

mod bends;
mod build;
mod drawing;
mod flat_folding;
mod holes;
mod holonomy;
mod ids;
mod letter;
mod lost;
mod model;
mod names;
mod near;
mod nesting;
mod parts;
mod planarity;
mod precision;
mod redraw;
mod rigidity;
mod split;
mod trace;
mod tree;
mod triangulate;
mod unit;

pub use bends::BEND_DEG;
pub(crate) use build::{LARGEST, check_goal, places};
pub use drawing::{Drawing, DrawnEdge, PatternError};
pub use flat_folding::FlatFlaw;
pub use holes::Passage;
pub use holonomy::{Holonomy, Tear};
pub use ids::{ClosureSite, CreaseId, EdgeId, FaceId, VertexId};
pub use letter::Letter;
pub use lost::LostLines;
pub(crate) use lost::rounded;
pub use model::{CreasePattern, Edge};
pub use names::EdgeNames;
pub use near::NearLines;
pub use precision::{Digits, Precision};
pub use rigidity::Rigidity;
pub(crate) use trace::twice_area;
pub(crate) use tree::bodies;
pub use tree::{SpanningTree, Step};
pub(crate) use triangulate::triangulate;
pub use unit::Unit;
