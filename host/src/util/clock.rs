//! The clock, for deadlines and durations: that of `std`, or in a browser that of the page.

#[cfg(not(target_family = "wasm"))]
pub(crate) use std::time::Instant;
#[cfg(target_family = "wasm")]
pub(crate) use web_time::Instant;
