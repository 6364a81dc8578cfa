//! In which ways is a plan looked for, and which answer is the best?
//!
//! One entry point: [`plan`](driver::plan).

pub(super) mod advice;
mod arrival;
pub(super) mod bending;
pub(super) mod driver;
pub(super) mod fold_sequence;
pub(super) mod lines;
mod phase_samples;
pub(super) mod pipeline;
mod plates;
mod rings;
mod rows;
pub(super) mod simple_folds;
pub(super) mod split_phases;
mod stops;
pub(super) mod way_round;
