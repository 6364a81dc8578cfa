//! Narrow phase: measures two convex pieces in space. It finds the depth of their crossing or their distance, which of two
//! stacked pieces lies on top, and for how long two pieces in contact stay on two sides of a plane, be it fixed to a piece
//! or spanned by a side of each.

pub(super) mod crossing;
pub(super) mod layers;
pub(super) mod planes;
pub(super) mod separation;
pub(super) mod side_planes;
