//! Runs the tests of the Python package, with the extension module of this build.
//!
//! `FOLDPATH_PYTHON` names an interpreter that has numpy and pytest; `tests/run` makes one. Without it nothing is tested,
//! and the output says so.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Returns the library that cargo has built beside this program.
fn extension() -> PathBuf {
    let program = std::env::current_exe().expect("the name of this program");
    let folder = program.parent().expect("a folder").to_path_buf();
    let name = format!(
        "{}_foldpath{}",
        std::env::consts::DLL_PREFIX,
        std::env::consts::DLL_SUFFIX
    );
    folder.join(name)
}

#[test]
fn the_package_passes_its_tests() {
    let Some(python) = std::env::var_os("FOLDPATH_PYTHON") else {
        println!("skipped: FOLDPATH_PYTHON names no interpreter");
        return;
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let status = Command::new(python)
        .arg(root.join("tests/run.py"))
        .arg(extension())
        .status()
        .expect("the interpreter of FOLDPATH_PYTHON");
    assert!(
        status.success(),
        "the tests of the Python package: {status}"
    );
}
