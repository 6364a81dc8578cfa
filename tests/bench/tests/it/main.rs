//! Tests of the benchmarks, which run their short forms.

mod report;
mod stability;
mod work_precision;
