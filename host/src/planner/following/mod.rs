//! How does the sheet get from flat to the goal, in few unknowns?
//!
//! One entry point: [`select_route`](route_selection::select_route) reduces the problem to crease groups and follows the
//! motion on them.

pub(super) mod branch;
mod completion;
pub(super) mod follow;
pub(super) mod judge;
pub(super) mod legs;
pub(super) mod mobility;
mod nearly_closed;
pub(super) mod reduction;
pub(super) mod route;
pub(super) mod route_selection;
pub(super) mod search;
