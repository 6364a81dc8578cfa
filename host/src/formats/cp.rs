//! CP files of ORIPA and Oriedita: one line of the drawing a line, `type x1 y1 x2 y2`.
//!
//! Types are 1 contour, 2 mountain, 3 valley and 4 auxiliary, which is no crease. As on the screens of
//! those programs y points down; it is turned round, so that the sheet is seen as it was drawn.

use std::path::Path;

use nalgebra::Vector2;

use super::segments::{Segment, pattern_file};
use super::{FileError, read_text};
use crate::formats::fold::PatternFile;
use crate::pattern::Letter;

/// Reads a crease pattern. A CP file names no angles, so that its creases have no goals.
///
/// # Errors
/// If the file cannot be read, a line of it is not such a line, or they are no crease pattern.
pub(super) fn read_pattern(path: &Path) -> Result<PatternFile, FileError> {
    let text = read_text(path)?;
    let mut segments = Vec::new();
    let mut auxiliary = 0_usize;
    for (index, line) in text.lines().enumerate() {
        let expected = |expected: &str, found: &str| FileError::Expected {
            path: path.to_path_buf(),
            place: format!("line {}", index + 1),
            expected: expected.into(),
            found: format!("\"{}\"", found.chars().take(40).collect::<String>()),
        };
        if line.trim().is_empty() {
            continue;
        }
        let fields: Vec<&str> = line.split_whitespace().take(6).collect();
        let &[kind, x1, y1, x2, y2] = fields.as_slice() else {
            return Err(expected("5 fields, type x1 y1 x2 y2", line.trim()));
        };
        let number = |field: &str| {
            let number = field.parse().ok().filter(|n: &f64| n.is_finite());
            number.ok_or_else(|| expected("a number", field))
        };
        let ends = [
            Vector2::new(number(x1)?, -number(y1)?),
            Vector2::new(number(x2)?, -number(y2)?),
        ];
        let letter = match kind {
            "1" => Letter::Boundary,
            "2" => Letter::Mountain,
            "3" => Letter::Valley,
            "4" => {
                auxiliary += 1;
                continue;
            }
            _ => {
                let types = "a type, 1 contour, 2 mountain, 3 valley or 4 auxiliary";
                return Err(expected(types, kind));
            }
        };
        segments.push(Segment {
            ends,
            letter,
            goal: None,
        });
    }
    let mut notes = Vec::new();
    if auxiliary > 0 {
        notes.push(format!("auxiliary lines (type 4) left out: {auxiliary}"));
    }
    pattern_file(path, &segments, notes)
}
