//! Reads OPX files of ORIPA, which are XML of `java.beans.XMLEncoder`.
//!
//! The lines are an array of objects with the properties `type`, `x0`, `x1`, `y0` and `y1`. The encoder leaves out every
//! property that is zero. The types are 0 auxiliary, 1 contour, 2 mountain and 3 valley, as in CP files; other types are
//! no creases.

use std::path::Path;

use usvg::roxmltree::{Document, Error, Node, ParsingOptions};

use super::error::{Wrong, quoted};
use super::oripa::TypedLines;
use super::segments::{LooseLines, MAX_LINES, pattern_file};
use super::{FileError, ReadOptions, svg};
use crate::progress::Watch;
use crate::read::fold::PatternFile;

/// Largest number of nodes of the document. A line has up to 42, texts between elements included.
const MAX_NODES: u32 = 1 << 23;

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
    let (lines, title) = lines(text).map_err(FileError::wrong(path))?;
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
        nodes_limit: MAX_NODES,
        ..Default::default()
    };
    let document = Document::parse_with_options(text, parsing).map_err(|error| {
        let expected = "an OPX drawing, which is XML of ORIPA".into();
        let found = match error {
            Error::NodesLimitReached => "a longer one".into(),
            _ => format!("no XML ({error})"),
        };
        let at = error.pos();
        let place = format!("line {}, column {}", at.row, at.col);
        (place, expected, found)
    })?;
    let array = document.descendants().find(|node| {
        node.has_tag_name("array") && is_line(node.attribute("class").unwrap_or_default())
    });
    let Some(array) = array else {
        let root = document.root_element();
        let expected = "an OPX drawing, with an array of the class oripa.OriLineProxy";
        return Err(wrong(root, expected, "none".into()));
    };
    let mut lines = TypedLines::default();
    let items = array.children().filter(Node::is_element);
    for item in items.filter_map(|item| item.first_element_child()) {
        if !item.has_tag_name("object") || !is_line(item.attribute("class").unwrap_or_default()) {
            let expected = "an object of the class oripa.OriLineProxy";
            let found = format!("<{}>", item.tag_name().name());
            return Err(wrong(item, expected, found));
        }
        let (kind, ends) = properties(item)?;
        let most = || wrong(item, &format!("at most {MAX_LINES} lines"), "more".into());
        lines.add(kind, ends).ok_or_else(most)?;
    }
    let title = title(array)
        .map(str::trim)
        .filter(|title| !title.is_empty());
    let lines = lines.into_loose("auxiliary lines");
    Ok((lines, title.map(String::from)))
}

/// Returns the type of a line and the coordinates x0, y0, x1 and y1 of its ends.
fn properties(item: Node<'_, '_>) -> Result<(i64, [f64; 4]), Wrong> {
    let (mut kind, mut ends) = (0, [0.0; 4]);
    for property in item.children().filter(Node::is_element) {
        let Some(value) = property.first_element_child() else {
            continue;
        };
        let name = property.attribute("property").unwrap_or_default();
        let text = value.text().unwrap_or_default().trim();
        if name == "type" {
            let expected = "a type, 1 contour, 2 mountain, 3 valley or 0 auxiliary";
            let wrong = |_| wrong(value, expected, quoted(text));
            kind = text.parse().map_err(wrong)?;
        } else if let Some(index) = ["x0", "y0", "x1", "y1"].iter().position(|at| *at == name) {
            let number = text.parse().ok().filter(|number: &f64| number.is_finite());
            ends[index] = number.ok_or_else(|| wrong(value, "a number", quoted(text)))?;
        }
    }
    Ok((kind, ends))
}

/// Makes the error that something else was expected at a node.
fn wrong(node: Node<'_, '_>, expected: &str, found: String) -> Wrong {
    let line = node.document().text_pos_at(node.range().start).row;
    (format!("line {line}"), expected.into(), found)
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
