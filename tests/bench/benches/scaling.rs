//! Benchmark `scaling`: time and memory of whole plans against the number of hinges, up to more than a million.
//!
//! `cargo bench --profile dist --bench scaling` in `tests/bench` takes minutes, with `-- short` seconds. Writes
//! `scaling.csv` and `scaling.svg` to `tests/bench/results`.

use std::process::ExitCode;

use foldpath_bench::{results, scaling};

fn main() -> ExitCode {
    if let Some(status) = scaling::measure::as_measurement() {
        return status;
    }
    let arguments: Vec<String> = std::env::args().collect();
    if !arguments.iter().any(|argument| argument == "--bench") {
        return ExitCode::SUCCESS;
    }
    let section = scaling::section(arguments.iter().any(|argument| argument == "short"));
    for (name, text) in &section.files {
        results::write(name, text);
    }
    print!("{}", section.text);
    ExitCode::SUCCESS
}
