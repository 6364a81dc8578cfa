//! The folder for the files of the benchmarks.

use std::path::{Path, PathBuf};

/// Returns `tests/bench/results`, or the folder that the environment variable `FOLDPATH_BENCH_RESULTS` names.
#[must_use]
pub fn folder() -> PathBuf {
    let named = std::env::var_os("FOLDPATH_BENCH_RESULTS").map(PathBuf::from);
    named.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("results"))
}

/// Writes a file to the folder.
///
/// # Panics
/// If the file cannot be written.
pub fn write(name: &str, text: &str) {
    let folder = folder();
    std::fs::create_dir_all(&folder).expect("a folder for results");
    std::fs::write(folder.join(name), text).expect("a file to write");
}
