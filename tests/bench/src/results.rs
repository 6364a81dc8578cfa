//! Where files of the benchmarks go.

use std::path::Path;

/// Writes a file to `tests/bench/results`.
///
/// # Panics
/// If that cannot be written to.
pub fn write(name: &str, text: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    std::fs::create_dir_all(&folder).expect("a folder for results");
    std::fs::write(folder.join(name), text).expect("a file to write");
}
