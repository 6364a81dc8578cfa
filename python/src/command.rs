//! The command line, and designs of a batch.

use std::ffi::OsString;

use foldpath_cli::embed;
use pyo3::prelude::*;

use crate::waiting::{Threads, waiting};

/// Runs the command with these arguments, the first of which is its name, and returns its exit status. `program` starts
/// it once more.
#[pyfunction]
pub(crate) fn main(py: Python<'_>, arguments: Vec<OsString>, program: Vec<OsString>) -> u8 {
    py.detach(|| foldpath_cli::run_command(arguments, &program))
}

/// Plans the design of one line of a batch and returns its result.
#[pyfunction]
pub(crate) fn plan_line(
    py: Python<'_>,
    line: String,
    timeout: f64,
    stable: bool,
) -> PyResult<String> {
    waiting(py, Threads::Some(1), move |progress| {
        embed::plan_line(&line, timeout, stable, progress)
    })
}
