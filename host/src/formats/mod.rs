//! Files. Only this module knows their formats.

mod cp;
pub mod csv;
mod error;
pub mod fold;
mod groups;
mod merge;
mod obj;
mod output;
pub mod rust;
mod segments;
mod stl;
mod svg;
pub mod traj;

use std::path::Path;

pub use error::FileError;
pub use output::{write_whole, write_whole_with};

use crate::unfold::FoldedShape;

/// Reads a crease pattern of whatever format the name's ending says: `.svg`, `.cp`, `.obj`, and FOLD
/// for all others.
///
/// # Errors
/// If the file cannot be read or holds no flat crease pattern.
pub fn read_pattern(path: &Path) -> Result<fold::PatternFile, FileError> {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    match ending.to_ascii_lowercase().as_str() {
        "svg" => svg::read_pattern(path),
        "cp" => cp::read_pattern(path),
        "obj" => obj::read_pattern(path),
        _ => fold::read_pattern(path),
    }
}

/// A folded shape as a file has it.
#[derive(Clone, Debug)]
pub struct ShapeFile {
    /// The file's title, or else its name.
    pub title: String,
    /// The shape.
    pub shape: FoldedShape,
    /// What was assumed in reading, in words.
    pub notes: Vec<String>,
}

/// Reads a folded shape of whatever format the name's ending says: `.obj`, `.stl`, and FOLD for all others,
/// of which `frame` may choose a frame: the key frame is 0.
///
/// # Errors
/// If the file cannot be read or holds no faces in space, or a frame is asked of a file that has none.
pub fn read_shape(path: &Path, frame: Option<usize>) -> Result<ShapeFile, FileError> {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let ending = ending.to_ascii_lowercase();
    match (ending.as_str(), frame) {
        ("obj", None) => obj::read_shape(path),
        ("stl", None) => stl::read_shape(path),
        ("obj" | "stl", Some(frame)) => Err(FileError::Expected {
            path: path.to_path_buf(),
            place: format!("frame {frame}"),
            expected: "a FOLD file, which has frames".into(),
            found: format!("an {} file", ending.to_ascii_uppercase()),
        }),
        _ => fold::read_shape(path, frame),
    }
}

/// The name of a file without its ending.
fn stem(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
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
