//! What can be wrong with a file: always with its path, the place in it and what was expected.

use std::path::PathBuf;

use foldpath_core::trajectory_file;
use thiserror::Error;

use crate::pattern::PatternError;
use crate::unfold::ShapeError;

/// Why a file could not be read or written.
#[derive(Debug, Error)]
pub enum FileError {
    /// The system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The text is not JSON.
    #[error("{}:{line}:{column}: expected a FOLD file, which is JSON: {message}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What the parser says.
        message: String,
    },
    /// A value is not what its place asks for.
    #[error("{}: {place}: expected {expected}, found {found}", path.display())]
    Expected {
        /// The file.
        path: PathBuf,
        /// The place, as keys and positions.
        place: String,
        /// What it asks for.
        expected: String,
        /// What is there.
        found: String,
    },
    /// The bytes are no trajectory.
    #[error("{}: {source}", path.display())]
    Trajectory {
        /// The file.
        path: PathBuf,
        /// What is wrong with them, and where.
        source: trajectory_file::FileError,
    },
    /// The drawing in the file is no crease pattern.
    #[error("{}: {frame}{source}", path.display())]
    Pattern {
        /// The file.
        path: PathBuf,
        /// The frame that the keys of the source are in, with a full stop; empty for the key frame.
        frame: String,
        /// What is wrong with it.
        source: PatternError,
    },
    /// The shape in the file is no surface of flat faces.
    #[error("{}: {source}", path.display())]
    Shape {
        /// The file.
        path: PathBuf,
        /// What is wrong with it; faces and vertices are counted from 0.
        source: ShapeError,
    },
}
