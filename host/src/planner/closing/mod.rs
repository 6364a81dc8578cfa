//! Which closed configuration is near this one, and in which directions can it move?
//!
//! One entry point: [`ClosureSolver`](solver::ClosureSolver), by core's solvers with memory from the heap.

pub(super) mod chord;
pub(super) mod solver;
pub(super) mod sparse;
