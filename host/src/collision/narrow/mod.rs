//! Narrow phase: two convex pieces in space. How deep they cross, how far they are apart, which of two stacked pieces lies
//! on top, and how long two pieces in contact stay on two sides of a plane.

pub(super) mod crossing;
pub(super) mod layers;
pub(super) mod planes;
pub(super) mod separation;
