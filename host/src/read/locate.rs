//! Finds the byte range in a text of the place that an error names.
//!
//! The parsers keep no positions. This module reads the text a second time, at the cost of parsing, and only after an
//! error.

use core::ops::Range;
use std::collections::HashMap;

use serde_json::value::RawValue;

/// Returns the byte range of `place` in a JSON text, such as `file_frames[3].edges_foldAngle[2]`. If the last keys or
/// positions of `place` do not exist, returns the first byte of the innermost value that does. Returns `None` if that
/// value is the whole text, or if the text is not JSON.
pub(super) fn in_json(text: &str, place: &str) -> Option<Range<usize>> {
    let offset = |part: &str| part.as_ptr() as usize - text.as_ptr() as usize;
    let mut here = text;
    for part in place.split(['.', '[']) {
        let Some(inside) = entered(here, part) else {
            let start = offset(here);
            return (start > 0).then_some(start..start + 1);
        };
        here = inside;
    }
    Some(offset(here)..offset(here) + here.len())
}

/// Returns the byte range of the character at a line and column, both counted from 1; column 0 is before the first
/// character. A column beyond the end of the line gives the last character.
pub(super) fn at_position(text: &str, line: usize, column: usize) -> Option<Range<usize>> {
    let line = line_of(text, line)?;
    let content = text[line.clone()].trim_end();
    let most = content.len().saturating_sub(1);
    let start = content.floor_char_boundary(column.saturating_sub(1).min(most));
    let length = content[start..].chars().next()?.len_utf8();
    Some(line.start + start..line.start + start + length)
}

/// Returns the byte range of `found` in a line, counted from 1. If the line does not contain `found`, returns the range
/// of the whole line without surrounding blanks.
pub(super) fn in_line(text: &str, line: usize, found: &str) -> Option<Range<usize>> {
    let line = line_of(text, line)?;
    let content = &text[line.clone()];
    let found = match content.find(found) {
        Some(at) if !found.is_empty() => at..at + found.len(),
        _ => content.len() - content.trim_start().len()..content.trim_end().len(),
    };
    (!found.is_empty()).then_some(line.start + found.start..line.start + found.end)
}

fn line_of(text: &str, line: usize) -> Option<Range<usize>> {
    let before = text.split_inclusive('\n').take(line.checked_sub(1)?);
    let start = before.map(str::len).sum();
    let length = text.get(start..)?.split('\n').next()?.len();
    Some(start..start + length)
}

/// Returns the text of the value that one part of a place leads to. If a key occurs more than once, takes its last value,
/// as the reader does.
fn entered<'t>(text: &'t str, part: &str) -> Option<&'t str> {
    let index = part
        .strip_suffix(']')
        .and_then(|at| at.parse::<usize>().ok());
    let found = match index {
        Some(index) => {
            let entries: Vec<&RawValue> = serde_json::from_str(text).ok()?;
            *entries.get(index)?
        }
        None => {
            let entries: HashMap<String, &RawValue> = serde_json::from_str(text).ok()?;
            *entries.get(part)?
        }
    };
    Some(found.get())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"{ "a": [[1, 2], [3, "é"]],
  "b:c": {"x": 7},
  "frames": [ {}, {"x": [4 ,5.5]} ], "b:c": {"x": 8}}"#;

    #[test]
    fn places_in_json_are_found() {
        for (place, found) in [
            ("a", Some("[[1, 2], [3, \"é\"]]")),
            ("a[1]", Some("[3, \"é\"]")),
            ("a[1][1]", Some("\"é\"")),
            ("b:c.x", Some("8")),
            ("frames[1].x[1]", Some("5.5")),
            // The range is the first byte of the value in which the place is missing.
            ("frames[0].x", Some("{")),
            ("frames[1].x[2]", Some("[")),
            ("frames[1].x[0].y", Some("4")),
            ("c", None),
            ("the file", None),
        ] {
            let span = in_json(TEXT, place);
            assert_eq!(span.map(|span| &TEXT[span]), found, "{place}");
        }
        assert_eq!(in_json("[1, 2", "[1]"), None);
    }

    #[test]
    fn positions_are_found_and_stay_within_the_text() {
        let text = "ab é\ncd\r\n\nlast";
        let at = |line, column| at_position(text, line, column).map(|span| &text[span]);
        assert_eq!(at(1, 0), Some("a"));
        assert_eq!([4, 5, 99].map(|column| at(1, column)), [Some("é"); 3]);
        assert_eq!(at(2, 3), Some("d"));
        assert_eq!([at(3, 1), at(5, 1), at(0, 1)], [None; 3]);
        let within = |line, found| in_line(text, line, found).map(|span| &text[span]);
        assert_eq!(within(4, "st"), Some("st"));
        assert_eq!(within(2, "x"), Some("cd"));
        assert_eq!(within(3, ""), None);
    }
}
