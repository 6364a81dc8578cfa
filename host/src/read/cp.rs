//! Reads CP files of ORIPA and Oriedita: each line of text is one line of the drawing, `type x1 y1 x2 y2`.
//!
//! The types are 0 none, 1 contour, 2 mountain and 3 valley. Oriedita writes 4 for auxiliary lines and reads every
//! other type as auxiliary; lines of these types are no creases.

use std::path::Path;

use super::error::quoted;
use super::oripa::TypedLines;
use super::segments::{MAX_LINES, pattern_file};
use super::{FileError, ReadOptions};
use crate::progress::Watch;
use crate::read::fold::PatternFile;

/// Parses a crease pattern from the text of a file. A CP file names no angles, so its creases have no goals. Empty
/// lines and lines that begin with `#` are skipped.
///
/// # Errors
/// If a line of the text has another form, or the lines form no crease pattern.
pub(super) fn parse_pattern(
    path: &Path,
    text: &str,
    options: &ReadOptions,
    watch: Watch<'_>,
) -> Result<PatternFile, FileError> {
    let mut lines = TypedLines::default();
    let mut commas = 0_usize;
    for (index, line) in text.lines().enumerate() {
        let expected = |expected: &str, found: &str| {
            FileError::expected(path, format!("line {}", index + 1), expected, quoted(found))
        };
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let mut fields = line.split_whitespace();
        let mut next = || fields.next();
        let (Some(kind), Some(x1), Some(y1), Some(x2), Some(y2), None) =
            (next(), next(), next(), next(), next(), next())
        else {
            return Err(expected("5 fields, type x1 y1 x2 y2", line));
        };
        let mut number = |field: &str| {
            let with_point = field.replacen(',', ".", 1);
            let number = with_point.parse().ok().filter(|n: &f64| n.is_finite());
            commas += usize::from(number.is_some() && field.contains(','));
            number.ok_or_else(|| expected("a number", field))
        };
        let coordinates = [number(x1)?, number(y1)?, number(x2)?, number(y2)?];
        let types = "a type, 1 contour, 2 mountain, 3 valley or 4 auxiliary";
        let kind: u8 = kind.parse().map_err(|_| expected(types, kind))?;
        let added = lines.add(kind.into(), coordinates);
        added.ok_or_else(|| expected(&format!("at most {MAX_LINES} lines"), line))?;
    }
    let mut lines = lines.into_loose("lines of no type");
    if commas > 0 {
        let note = format!("numbers with a comma for the point: {commas}");
        lines.notes.push(note);
    }
    pattern_file(path, lines, options, watch)
}
