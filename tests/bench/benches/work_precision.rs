//! Benchmark `work-precision`: run time against error, of foldpath's solvers beside peers, and of whole paths.
//!
//! `cargo bench --profile dist --bench work_precision` in `tests/bench` takes minutes, with `-- short` seconds on
//! small sheets. Prints `docs/benchmarks/work-precision.md`, and writes CSV files and plots to
//! `tests/bench/results`.

use std::process::ExitCode;

use foldpath_bench::precision::{Form, write};
use foldpath_bench::results;

fn main() -> ExitCode {
    let has = |word| std::env::args().any(|argument| argument == word);
    if !has("--bench") {
        return ExitCode::SUCCESS;
    }
    let form = if has("short") {
        Form::Short
    } else {
        Form::Full
    };
    let folder = results::folder();
    match write(form, &folder, "tests/bench/results") {
        Ok(markdown) => {
            print!("{markdown}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{}: {error}", folder.display());
            ExitCode::FAILURE
        }
    }
}
