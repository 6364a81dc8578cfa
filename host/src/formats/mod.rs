//! Files. Only this module knows their formats.

mod cp;
pub mod csv;
mod error;
pub mod fold;
pub mod glb;
mod groups;
pub mod obj_sequence;
mod output;
pub mod rust;
mod segments;
mod svg;
pub mod svg_pattern;
pub mod traj;

use std::path::Path;

pub use error::FileError;
pub use output::{write_each_whole, write_whole, write_whole_with};

/// Reads a crease pattern of whatever format the name's ending says: `.svg`, `.cp`, and FOLD for all
/// others.
///
/// # Errors
/// If the file cannot be read or holds no flat crease pattern.
pub fn read_pattern(path: &Path) -> Result<fold::PatternFile, FileError> {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    match ending.to_ascii_lowercase().as_str() {
        "svg" => svg::read_pattern(path),
        "cp" => cp::read_pattern(path),
        _ => fold::read_pattern(path),
    }
}

/// The text of a file, without a byte order mark.
pub(crate) fn read_text(path: &Path) -> Result<String, FileError> {
    let bytes = std::fs::read(path).map_err(|source| FileError::Io {
        path: path.to_path_buf(),
        source,
    })?;
    let text = String::from_utf8(bytes).map_err(|error| FileError::Expected {
        path: path.to_path_buf(),
        place: format!("byte {}", error.utf8_error().valid_up_to()),
        expected: "text in UTF-8".into(),
        found: "other bytes".into(),
    })?;
    match text.strip_prefix('\u{feff}') {
        Some(text) => Ok(text.into()),
        None => Ok(text),
    }
}
