//! Reads OPX files of ORIPA, which are XML of `java.beans.XMLEncoder`.
//!
//! The lines are an array of objects with the properties `type`, `x0`, `x1`, `y0` and `y1`. The encoder leaves out every
//! property that is zero. The types are 0 auxiliary, 1 contour, 2 mountain and 3 valley, as in CP files; other types are
//! no creases. On the screen of ORIPA y points down, so this reader negates y to show the sheet as it was drawn.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Vector2;
use usvg::roxmltree::{Document, Error, Node, ParsingOptions};

use super::error::Wrong;
use super::segments::{LooseLines, MOST, Segment, pattern_file};
use super::{FileError, ReadOptions, svg};
use crate::pattern::Letter;
use crate::progress::Watch;
use crate::read::fold::PatternFile;

/// Largest number of nodes of the document. A line has up to 42, texts between elements included.
const NODES: u32 = 1 << 23;

/// Largest number of characters of a file's text that an error shows.
const SHOWN: usize = 40;

/// Parses a crease pattern from the text of a file. The file names no angles, so its creases have no goals.
///
/// # Errors
/// If the text is no XML of ORIPA, a line of the drawing has another form, or the lines form no crease pattern.
pub(super) fn parse_pattern(
    path: &Path,
    text: &str,
    options: &ReadOptions,
    watch: Watch<'_>,
) -> Result<PatternFile, FileError> {
    let told = |(place, expected, found)| FileError::expected(path, place, expected, found);
    let (lines, title) = lines(text).map_err(told)?;
    let mut file = pattern_file(path, lines, options, watch)?;
    if let Some(title) = title {
        file.title = title;
    }
    Ok(file)
}

/// Returns the lines of the drawing and its title, if it has one.
fn lines(text: &str) -> Result<(LooseLines, Option<String>), Wrong> {
    svg::check_text(text)?;
    // Without a document type there are no entities to expand.
    let parsing = ParsingOptions {
        nodes_limit: NODES,
        ..Default::default()
    };
    let document = Document::parse_with_options(text, parsing).map_err(|error| {
        let expected = "an OPX drawing, which is XML of ORIPA".into();
        let found = match error {
            Error::NodesLimitReached => "a longer one".into(),
            _ => format!("no XML ({error})"),
        };
        let at = error.pos();
        (
            format!("line {}, column {}", at.row, at.col),
            expected,
            found,
        )
    })?;
    let wrong = |node: Node<'_, '_>, expected: &str, found: String| {
        let place = format!("line {}", document.text_pos_at(node.range().start).row);
        (place, expected.to_string(), found)
    };
    let array = document.descendants().find(|node| {
        node.has_tag_name("array") && is_line(node.attribute("class").unwrap_or_default())
    });
    let Some(array) = array else {
        let root = document.root_element();
        let expected = "an OPX drawing, with an array of the class oripa.OriLineProxy";
        return Err(wrong(root, expected, "none".into()));
    };
    let mut lines = LooseLines {
        y_down: true,
        ..LooseLines::default()
    };
    let mut auxiliary: BTreeMap<i64, usize> = BTreeMap::new();
    let items = array.children().filter(Node::is_element);
    for item in items.filter_map(|item| item.first_element_child()) {
        if !item.has_tag_name("object") || !is_line(item.attribute("class").unwrap_or_default()) {
            let expected = "an object of the class oripa.OriLineProxy";
            return Err(wrong(
                item,
                expected,
                format!("<{}>", item.tag_name().name()),
            ));
        }
        let (mut kind, mut place) = (0, [0.0; 4]);
        for property in item.children().filter(Node::is_element) {
            let Some(value) = property.first_element_child() else {
                continue;
            };
            let name = property.attribute("property").unwrap_or_default();
            let text = value.text().unwrap_or_default().trim();
            let shown = || format!("\"{}\"", text.chars().take(SHOWN).collect::<String>());
            if name == "type" {
                let expected = "a type, 1 contour, 2 mountain, 3 valley or 0 auxiliary";
                kind = text.parse().map_err(|_| wrong(value, expected, shown()))?;
            } else if let Some(index) = ["x0", "y0", "x1", "y1"].iter().position(|at| *at == name) {
                let number = text.parse().ok().filter(|number: &f64| number.is_finite());
                place[index] = number.ok_or_else(|| wrong(value, "a number", shown()))?;
            }
        }
        let letter = match kind {
            1 => Letter::Boundary,
            2 => Letter::Mountain,
            3 => Letter::Valley,
            other => {
                *auxiliary.entry(other).or_default() += 1;
                continue;
            }
        };
        if lines.segments.len() == MOST {
            return Err(wrong(item, &format!("at most {MOST} lines"), "more".into()));
        }
        let [x0, y0, x1, y1] = place;
        lines.segments.push(Segment {
            ends: [Vector2::new(x0, -y0), Vector2::new(x1, -y1)],
            letter,
            goal: None,
        });
    }
    let left_out = auxiliary.into_iter().map(|(kind, count)| match kind {
        0 | 4 => format!("auxiliary lines (type {kind}) left out: {count}"),
        other => format!("lines of type {other}, taken as auxiliary, left out: {count}"),
    });
    lines.notes = left_out.collect();
    let title = title(array)
        .map(str::trim)
        .filter(|title| !title.is_empty());
    Ok((lines, title.map(String::from)))
}

/// Returns `true` if objects of this class are lines of the drawing.
fn is_line(class: &str) -> bool {
    class.rsplit('.').next() == Some("OriLineProxy")
}

/// Returns the title of the data set to which the array of lines belongs. The encoder writes a value as
/// `<void property="title"><string>..`, or as a field that is set:
/// `<void method="getField"><string>title</string><void method="set"><object idref=".."/><string>..`.
fn title<'a>(array: Node<'a, '_>) -> Option<&'a str> {
    let data = array
        .ancestors()
        .skip(1)
        .find(|node| node.has_tag_name("object"))?;
    data.children().find_map(|value| {
        let text = |node: Node<'a, '_>| node.has_tag_name("string").then(|| node.text())?;
        if value.attribute("property") == Some("title") {
            return text(value.first_element_child()?);
        }
        let field = value.attribute("method") == Some("getField");
        if !field || text(value.first_element_child()?) != Some("title") {
            return None;
        }
        text(value.last_element_child()?.last_element_child()?)
    })
}
