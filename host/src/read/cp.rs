//! Reads CP files of ORIPA and Oriedita: each line of text is one line of the drawing, `type x1 y1 x2 y2`.
//!
//! The types are 0 none, 1 contour, 2 mountain and 3 valley. Oriedita writes 4 for auxiliary lines and reads every
//! other type as auxiliary; lines of these types are no creases. On the screens of those programs y points down, so
//! this reader negates y to show the sheet as it was drawn.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Vector2;

use super::segments::{LooseLines, MOST, Segment, pattern_file};
use super::{FileError, ReadOptions};
use crate::pattern::Letter;
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
    let mut segments = Vec::new();
    let mut auxiliary: BTreeMap<u8, usize> = BTreeMap::new();
    let mut commas = 0_usize;
    for (index, line) in text.lines().enumerate() {
        let expected = |expected: &str, found: &str| FileError::Expected {
            path: path.to_path_buf(),
            place: format!("line {}", index + 1),
            expected: expected.into(),
            found: format!("\"{}\"", found.chars().take(40).collect::<String>()),
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
        let ends = [
            Vector2::new(number(x1)?, -number(y1)?),
            Vector2::new(number(x2)?, -number(y2)?),
        ];
        let letter = match kind.parse() {
            Ok(1) => Letter::Boundary,
            Ok(2) => Letter::Mountain,
            Ok(3) => Letter::Valley,
            Ok(other) => {
                *auxiliary.entry(other).or_default() += 1;
                continue;
            }
            Err(_) => {
                let types = "a type, 1 contour, 2 mountain, 3 valley or 4 auxiliary";
                return Err(expected(types, kind));
            }
        };
        if segments.len() == MOST {
            return Err(expected(&format!("at most {MOST} lines"), line));
        }
        segments.push(Segment {
            ends,
            letter,
            goal: None,
        });
    }
    let left_out = auxiliary.into_iter().map(|(kind, count)| {
        let name = match kind {
            0 => "lines of no type (type 0)".into(),
            4 => "auxiliary lines (type 4)".into(),
            other => format!("lines of type {other}, taken as auxiliary,"),
        };
        format!("{name} left out: {count}")
    });
    let mut notes: Vec<String> = left_out.collect();
    if commas > 0 {
        notes.push(format!("numbers with a comma for the point: {commas}"));
    }
    let lines = LooseLines {
        segments,
        y_down: true,
        notes,
        ..LooseLines::default()
    };
    pattern_file(path, lines, options, watch)
}
