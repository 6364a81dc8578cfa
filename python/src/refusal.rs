//! Errors as Python's `foldpath.FoldpathError`, with the text of the command line.

use foldpath_cli::embed::{CliError, ErrorFields, plain_text};
use pyo3::prelude::*;

/// Makes the exception of a refusal.
pub(crate) fn error(py: Python<'_>, refusal: impl Into<CliError>) -> PyErr {
    let error = refusal.into();
    let told = ErrorFields::of(&error);
    let make = || {
        let module = py.import("foldpath._error")?;
        let class = module.getattr("FoldpathError")?;
        class.call1((
            plain_text(&error),
            told.file,
            told.line,
            told.column,
            told.hint,
        ))
    };
    make().map_or_else(|error| error, PyErr::from_value)
}

/// Makes the exception of a value that an argument cannot have.
pub(crate) fn usage(py: Python<'_>, text: String) -> PyErr {
    error(py, foldpath::request::RequestError::Usage(text))
}
