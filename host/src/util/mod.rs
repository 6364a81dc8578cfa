//! Data structures and functions that know nothing of origami.

pub(crate) mod angle;
pub(crate) mod clock;
pub mod csr;
pub(crate) mod nan_max;
pub mod parallel;
pub mod progress;
pub mod range;
pub(crate) mod union_find;
