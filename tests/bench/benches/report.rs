//! Benchmark `report`: the report's tables and figures, foldpath beside the report's method.
//!
//! `cargo bench --profile dist --bench report` in `tests/bench` prints `docs/benchmarks/report.md` in
//! about ten minutes and writes data and plots to `tests/bench/results`. With `-- short` it takes a few rows, in
//! seconds, and writes to a folder of the target directory.

use std::path::Path;

use foldpath_bench::report::{Extent, print};
use foldpath_bench::results;

fn main() -> std::io::Result<()> {
    let arguments: Vec<String> = std::env::args().collect();
    let has = |name: &str| arguments.iter().any(|argument| argument == name);
    if !has("--bench") {
        return Ok(());
    }
    let extent = if has("short") {
        Extent::Short
    } else {
        Extent::Full
    };
    let folder = match extent {
        Extent::Short => Path::new(env!("CARGO_TARGET_TMPDIR")).join("report"),
        Extent::Full => results::folder(),
    };
    print(extent, &mut std::io::stdout().lock(), &folder)
}
