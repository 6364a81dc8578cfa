//! The clock, for deadlines and durations: that of `std`, or in a browser that of the page.

pub(crate) use web_time::Instant;
