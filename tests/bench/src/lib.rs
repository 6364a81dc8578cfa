//! Code that the benchmarks share: the report's method, peers, and writers of tables and plots.
//!
//! Every bench prints its section of `docs/benchmarks` as Markdown on stdout; `tests/bench/run` puts it into the file.

pub mod precision;
pub mod report;
pub mod results;
pub mod scaling;
pub mod stability;
