//! Tests of the benchmarks, which run their short forms.

mod allocations;
mod report;
mod stability;
mod steps;
mod work_precision;
