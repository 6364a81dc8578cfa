//! Data structures and functions that know nothing of origami.

pub(crate) mod angle;
pub mod csr;
pub(crate) mod nan_max;
pub(crate) mod parallel;
pub mod progress;
pub(crate) mod union_find;
