//! What the benchmarks share: the report's method, peers, and how tables and plots are written.
//!
//! Every bench prints its section of `BENCHMARKS.md` as Markdown on stdout; `tests/bench/run` puts it there.

pub mod precision;
pub mod report;
pub mod results;
pub mod scaling;
pub mod stability;
