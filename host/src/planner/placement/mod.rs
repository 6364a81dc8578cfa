//! Where on a path are knots needed, and when does the motion pass them?
//!
//! One entry point: [`place`](knot_placement::place).

pub(super) mod knot_placement;
pub(super) mod knot_placer;
pub(super) mod overshoot;
pub(super) mod reachability;
pub(super) mod reduced_path;
mod segment;
pub mod timing;
