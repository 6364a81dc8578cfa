//! The extension module of the Python package `foldpath`.
//!
//! It moves bytes and texts between Python and the library: arrays are bytes, options and answers are JSON. The Python
//! code in `python/foldpath`, which people use, makes arrays and dictionaries of them.
//!
//! - `sheet.rs`: a crease pattern, with closure residuals and Jacobian.
//! - `answer.rs`: plans.
//! - `derivatives.rs`: derivatives of a folded sheet.
//! - `path.rs`: motions, and judging them.
//! - `waiting.rs`: long calls, during which Python goes on and Ctrl-C works.
//! - `refusal.rs`: errors.
//! - `command.rs`: the command line, and designs of a batch.

mod answer;
mod arrays;
mod command;
mod derivatives;
mod path;
mod refusal;
mod sheet;
mod waiting;

#[pyo3::pymodule]
mod _foldpath {
    #[pymodule_export]
    use super::answer::{Answer, plan};
    #[pymodule_export]
    use super::command::{main, plan_line};
    #[pymodule_export]
    use super::path::{Path, read_drives, write_text};
    #[pymodule_export]
    use super::sheet::{Sheet, unfold};
}
