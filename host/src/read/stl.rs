//! Reads STL files, text or binary: triangles in space, each with corners of its own.

use std::path::Path;

use nalgebra::Vector3;

use super::error::quoted;
use super::merge::{Vertices, tidied};
use super::{FileError, ShapeFile, stem};
use crate::pattern::LARGEST;
use crate::unfold::FoldedShape;

/// Bytes before the number of triangles in a binary file.
const HEADER_BYTES: usize = 80;

/// Bytes of a triangle in a binary file: normal, three corners, attributes.
const TRIANGLE_BYTES: usize = 50;

/// Parses a folded shape. Triangles are joined at corners that are at the same place; their normals are ignored.
///
/// # Errors
/// If the bytes are not STL, or hold no triangles.
pub(super) fn parse_shape(path: &Path, bytes: &[u8]) -> Result<ShapeFile, FileError> {
    let (corners, lines) = match binary(bytes) {
        Some(corners) => (corners, Vec::new()),
        None => match core::str::from_utf8(bytes) {
            Ok(text) if is_text(text) => ascii(text).map_err(|(line, what, found)| {
                FileError::expected(path, format!("line {line}"), what, quoted(found))
            })?,
            _ => {
                let what = "an STL file: text that begins with \"solid\", or 84 bytes and 50 for each triangle";
                let found = format!("{} bytes", bytes.len());
                return Err(FileError::expected(path, "the file", what, found));
            }
        },
    };
    let bad = |p: &Vector3<f64>| p.iter().any(|c| c.is_nan() || c.abs() > LARGEST);
    if let Some(corner) = corners.iter().position(bad) {
        let place = format!("triangle {}", corner / 3);
        let found = format!("{:?}", corners[corner].as_slice());
        let expected = "coordinates from -1e50 to 1e50";
        return Err(FileError::expected(path, place, expected, found));
    }
    if corners.is_empty() {
        let expected = "at least one triangle";
        return Err(FileError::expected(path, "the file", expected, "none"));
    }
    let faces = (0..corners.len() / 3).map(|face| vec![3 * face, 3 * face + 1, 3 * face + 2]);
    let soup = FoldedShape {
        faces: faces.collect(),
        vertices: corners,
        edges: Vec::new(),
    };
    let place = |face: usize| match lines.get(face) {
        Some(line) => format!("line {line}"),
        None => format!("triangle {face}"),
    };
    let mut notes = Vec::new();
    Ok(ShapeFile {
        unit: None,
        title: stem(path),
        shape: tidied(path, soup, Vertices::Separate, place, &mut notes)?,
        notes,
    })
}

/// Returns `true` if a text begins as an STL file does.
pub(super) fn is_text(text: &str) -> bool {
    let word = text.trim_start().as_bytes().get(..FIRST_WORD.len());
    word.is_some_and(|word| word.eq_ignore_ascii_case(FIRST_WORD.as_bytes()))
}

/// First word of an STL file that is text. Some programs write keywords in capitals.
const FIRST_WORD: &str = "solid";

/// Returns the triangles of a binary file, or `None` if the length of the file does not agree with their number.
pub(super) fn triangles(bytes: &[u8]) -> Option<&[u8]> {
    let (count, triangles) = bytes.get(HEADER_BYTES..)?.split_first_chunk()?;
    let count = usize::try_from(u32::from_le_bytes(*count)).ok()?;
    (triangles.len() == count.checked_mul(TRIANGLE_BYTES)?).then_some(triangles)
}

/// Returns the corners of a binary file, or `None` if it is none.
fn binary(bytes: &[u8]) -> Option<Vec<Vector3<f64>>> {
    let number = |bytes: &[u8]| {
        let bytes = bytes.first_chunk().copied().unwrap_or_default();
        f64::from(f32::from_le_bytes(bytes))
    };
    let corner = |bytes: &[u8]| Vector3::from_iterator(bytes.chunks_exact(4).map(number));
    let corners = triangles(bytes)?
        .chunks_exact(TRIANGLE_BYTES)
        .flat_map(|triangle| triangle[12..48].chunks_exact(12).map(corner));
    Some(corners.collect())
}

/// Corners of triangles, and for each triangle the line of its last corner.
type Corners = (Vec<Vector3<f64>>, Vec<usize>);

/// Returns the corners of a text file, or the number of the defective line with what was expected and found there.
fn ascii(text: &str) -> Result<Corners, (usize, &'static str, &str)> {
    let (mut corners, mut lines) = (Vec::new(), Vec::new());
    let mut in_loop = 0;
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        let mut fields = line.split_whitespace();
        let keyword = fields.next().map(str::to_ascii_lowercase);
        match keyword.as_deref() {
            Some("vertex") => {
                let numbers = fields.map(|field| field.parse().ok());
                let numbers: Option<Vec<f64>> = numbers.take(4).collect();
                match numbers.as_deref() {
                    Some(&[x, y, z]) => corners.push(Vector3::new(x, y, z)),
                    _ => return Err((index + 1, "a corner, vertex and 3 numbers", line)),
                }
                in_loop += 1;
                if corners.len() % 3 == 0 {
                    lines.push(index + 1);
                }
            }
            Some("outer") => in_loop = 0,
            Some("endloop") if in_loop != 3 => {
                return Err((index + 1, "3 corners (vertex) before endloop", line));
            }
            Some("solid" | "facet" | "endloop" | "endfacet" | "endsolid") | None => {}
            Some(_) => {
                let what = "solid, facet, outer loop, vertex, endloop, endfacet or endsolid";
                return Err((index + 1, what, line));
            }
        }
    }
    if corners.len() % 3 != 0 {
        return Err((text.lines().count(), "3 corners for each triangle", ""));
    }
    Ok((corners, lines))
}
