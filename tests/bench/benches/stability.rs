//! Benchmark `stability`: errors of core and planner on extreme sheets, against a reference of 192 bits, and the first
//! sheets on which something breaks.
//!
//! `cargo bench --profile dist --bench stability` in `tests/bench` takes minutes, with `-- short` seconds. Writes
//! tables to `tests/bench/results/stability-*.csv`.

use std::path::Path;
use std::process::ExitCode;

use foldpath_bench::{results, stability};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().collect();
    if !arguments.iter().any(|argument| argument == "--bench") {
        return ExitCode::SUCCESS;
    }
    let command = Path::new(env!("CARGO_BIN_EXE_foldpath-bench-command"));
    let short = arguments.iter().any(|argument| argument == "short");
    let section = stability::section(command, short);
    for (name, text) in &section.files {
        results::write(name, text);
    }
    print!("{}", section.text);
    for wrong in &section.wrong {
        eprintln!("wrong: {wrong}");
    }
    ExitCode::from(u8::from(!section.wrong.is_empty()))
}
