//! Crease patterns: the flat sheet as a straight-edged planar graph.
//!
//! A [`Drawing`] is what a file says, a [`CreasePattern`] what was made of it: faces found, every
//! reference checked, real and virtual vertices told apart, panels triangulated.

mod build;
mod drawing;
mod flat_folding;
mod holes;
mod ids;
mod letter;
mod model;
mod planarity;
mod split;
mod trace;
mod triangulate;

pub(crate) use build::{LARGEST, check_goal};
pub use drawing::{Drawing, DrawnEdge, PatternError};
pub use flat_folding::FlatFlaw;
pub use holes::Passage;
pub use ids::{CreaseId, EdgeId, FaceId, VertexId};
pub use letter::Letter;
pub use model::{CreasePattern, Edge};
pub(crate) use trace::twice_area;
