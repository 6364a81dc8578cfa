//! Errors of reading and writing files. Every error names the file, the place in it and what was expected.

use core::ops::Range;
use std::path::{Path, PathBuf};

use foldpath_core::trajectory_file;
use thiserror::Error;

use super::{BYTE_ORDER_MARK, locate};
use crate::pattern::PatternError;
use crate::unfold::ShapeError;

/// Place of an error in a file, the value expected at that place and the value found.
#[cfg(feature = "svg")]
pub(super) type Wrong = (String, String, String);

/// Largest number of characters of a file's text that an error shows.
const MAX_SHOWN_CHARS: usize = 40;

/// Returns the beginning of a file's text in quotes, to show in an error.
pub(super) fn quoted(text: &str) -> String {
    let shown: String = text.chars().take(MAX_SHOWN_CHARS).collect();
    format!("\"{shown}\"")
}

/// Reason why a file could not be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FileError {
    /// The operating system reported an error.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Error reported by the operating system.
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
        /// Message of the JSON parser.
        message: String,
    },
    /// A value is not of the kind that its place requires.
    #[error("{}: {place}: expected {expected}, found {found}", path.display())]
    Expected {
        /// The file.
        path: PathBuf,
        /// The place of the value, as keys and positions.
        place: String,
        /// Description of the value that the place requires.
        expected: String,
        /// Description of the value that was found.
        found: String,
    },
    /// The bytes are no valid trajectory file.
    #[error("{}: {source}", path.display())]
    Trajectory {
        /// The file.
        path: PathBuf,
        /// The defect of the bytes and its position.
        source: trajectory_file::FileError,
    },
    /// The drawing in the file is no valid crease pattern.
    #[error("{}: {frame}{source}", path.display())]
    Pattern {
        /// The file.
        path: PathBuf,
        /// Prefix that names the frame to which the keys in `source` belong, ending in a full stop; empty for the key
        /// frame.
        frame: String,
        /// The defect of the drawing.
        source: PatternError,
    },
    /// The caller cancelled reading.
    #[error("{}: reading was cancelled", path.display())]
    Cancelled {
        /// The file.
        path: PathBuf,
    },
    /// The shape in the file is no surface of flat faces.
    #[error("{}: {source}", path.display())]
    Shape {
        /// The file.
        path: PathBuf,
        /// The defect of the shape; faces and vertices are counted from 0.
        source: ShapeError,
    },
}

/// Size in bytes beyond which a file is not read again to show the place of an error.
const MAX_SHOWN_BYTES: u64 = 1 << 28;

impl FileError {
    /// Makes the error that another value was expected at a place of a file.
    pub(crate) fn expected(
        path: &Path,
        place: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self::Expected {
            path: path.to_path_buf(),
            place: place.into(),
            expected: expected.into(),
            found: found.into(),
        }
    }

    /// Returns a function that makes an error of what is wrong at a place of a file.
    #[cfg(feature = "svg")]
    pub(super) fn wrong(path: &Path) -> impl Fn(Wrong) -> Self {
        |(place, expected, found)| Self::expected(path, place, expected, found)
    }

    /// Returns a function that makes an error about a file of one that the operating system reports.
    pub fn io(path: &Path) -> impl Fn(std::io::Error) -> Self {
        move |source| Self::Io {
            path: path.to_path_buf(),
            source,
        }
    }

    /// Returns the path of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        match self {
            Self::Io { path, .. }
            | Self::Syntax { path, .. }
            | Self::Expected { path, .. }
            | Self::Trajectory { path, .. }
            | Self::Pattern { path, .. }
            | Self::Cancelled { path }
            | Self::Shape { path, .. } => path,
        }
    }

    /// Reads the file again and returns its text and the byte range that the error is about. Returns `None` if the
    /// error names no place in a text, or if the file cannot be read again.
    #[must_use]
    pub fn locate(&self) -> Option<(String, Range<usize>)> {
        let text = self.text_again()?;
        let span = self.locate_in(&text)?;
        Some((text, span))
    }

    /// Returns the byte range in the text of the file, without a byte order mark, that the error is about. Returns `None`
    /// if the error names no place in a text.
    #[must_use]
    pub fn locate_in(&self, text: &str) -> Option<Range<usize>> {
        match self {
            Self::Io { .. }
            | Self::Trajectory { .. }
            | Self::Cancelled { .. }
            | Self::Shape { .. } => None,
            Self::Syntax { line, column, .. } => locate::at_position(text, *line, *column),
            Self::Expected { place, found, .. } => span_of(text, place, found),
            Self::Pattern { frame, source, .. } => {
                let place = format!("{frame}{source}");
                locate::in_json(text, place.split(": ").next()?)
            }
        }
    }

    /// Reads the text of the file once more. Returns `None` for pipes, whose bytes can be read only once.
    fn text_again(&self) -> Option<String> {
        let found = std::fs::metadata(self.path()).ok()?;
        if !found.is_file() || found.len() > MAX_SHOWN_BYTES {
            return None;
        }
        let text = String::from_utf8(std::fs::read(self.path()).ok()?).ok()?;
        Some(
            text.strip_prefix(BYTE_ORDER_MARK)
                .map(String::from)
                .unwrap_or(text),
        )
    }
}

/// Returns the byte range of a place: `line N`, `line N, column M`, an element with an `id="..."`, or a place in JSON.
fn span_of(text: &str, place: &str, found: &str) -> Option<Range<usize>> {
    if let Some(position) = place.strip_prefix("line ") {
        let (line, column) = match position.split_once(", column ") {
            Some((line, column)) => (line, column.parse().ok()),
            None => (position, None),
        };
        let line = line.parse().ok()?;
        return match column {
            Some(column) => locate::at_position(text, line, column),
            None => locate::in_line(text, line, found.trim_matches('"')),
        };
    }
    if let Some(at) = place.find("id=\"") {
        let id = &place[at..];
        let end = id.match_indices('"').nth(1)?.0;
        let start = text.find(&id[..=end])?;
        return Some(start..start + end + 1);
    }
    locate::in_json(text, place)
}
