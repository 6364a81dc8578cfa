//! Checks the numbers of a drawing. usvg would silently read an invalid length as 0, read a list only up to its first
//! error, and drop elements whose numbers are too large for single precision.

use svgtypes::{Error, Length, NumberListParser, PathParser};
use usvg::roxmltree::{Document, Node};

use super::limits::sum;
use crate::read::error::{Wrong, quoted};

/// Largest absolute value of a number: far below the limit of single precision, whatever the number is multiplied by or
/// added to.
const MAX_NUMBER: f64 = 1e30;

/// Returns an error at the first number that is invalid or too large.
pub(super) fn check(document: &Document<'_>) -> Result<(), Wrong> {
    document.descendants().try_for_each(|node| {
        let names: &[&str] = match node.tag_name().name() {
            "line" => &["x1", "y1", "x2", "y2"],
            "rect" => &["x", "y", "width", "height"],
            "polyline" | "polygon" => &["points"],
            "path" => &["d"],
            _ => &[],
        };
        names
            .iter()
            .try_for_each(|name| of_attribute(document, node, name))
    })
}

fn of_attribute(document: &Document<'_>, node: Node<'_, '_>, name: &str) -> Result<(), Wrong> {
    let Some(attribute) = node.attribute_node(name) else {
        return Ok(());
    };
    let value = attribute.value();
    let (right, what) = match name {
        "points" => (points(value), "numbers"),
        "d" => (data(value), "path data with numbers"),
        _ => (length(value), "a number"),
    };
    let Err(characters) = right else {
        return Ok(());
    };
    let at = value.char_indices().nth(characters);
    let at = at.map_or(value.len(), |(at, _)| at);
    let written = attribute.range_value();
    // Entities are longer than the text that they stand for.
    let within = if written.len() == value.len() { at } else { 0 };
    let place = document.text_pos_at(written.start + within);
    Err((
        format!("line {}, column {}", place.row, place.col),
        format!("{name} to be {what} from -{MAX_NUMBER:e} to {MAX_NUMBER:e}"),
        match &value[at..] {
            "" => "its end".into(),
            found => quoted(found),
        },
    ))
}

/// The error is the number of characters before the defect, or 0 for a number that is too large anywhere in the value.
type Right = Result<(), usize>;

fn length(value: &str) -> Right {
    let length: Length = value.parse().map_err(|_| 0_usize)?;
    small(length.number.abs())
}

fn points(value: &str) -> Right {
    NumberListParser::from(value).try_for_each(|number| number.map(drop).map_err(before))?;
    small(sum(value))
}

fn data(value: &str) -> Right {
    PathParser::from(value).try_for_each(|part| part.map(drop).map_err(before))?;
    // No point lies beyond the sum, whether its coordinates are absolute or relative.
    small(sum(value))
}

fn small(number: f64) -> Right {
    (number <= MAX_NUMBER).then_some(()).ok_or(0)
}

/// Returns the number of characters before an error. The parser counts characters from 1.
fn before(error: Error) -> usize {
    match error {
        Error::UnexpectedData(at)
        | Error::InvalidChar(_, at)
        | Error::InvalidString(_, at)
        | Error::InvalidNumber(at) => at.saturating_sub(1),
        // The missing text is missing at the end of the value.
        Error::UnexpectedEndOfStream => usize::MAX,
        Error::InvalidValue | Error::InvalidIdent => 0,
    }
}
