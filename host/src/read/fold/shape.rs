//! Reads the folded shape of a FOLD file.

use std::path::Path;

use super::document::{Document, Frame};
use super::keys;
use super::pattern::{Goals, edges, faces, goals, letters, points, title, unit};
use crate::read::merge::{Vertices, tidied};
use crate::read::{FileError, ShapeFile};
use crate::unfold::{FoldedShape, ShapeEdge};

/// Parses the folded shape of frame number `frame`; the key frame is 0. Without a number, parses the last folded form in the
/// file, or else the key frame. `path` names the file in errors.
///
/// # Errors
/// If the frame has no faces in space.
pub fn parse_shape(
    path: &Path,
    bytes: &[u8],
    frame: Option<usize>,
) -> Result<ShapeFile, FileError> {
    let document = Document::parse(path, bytes)?;
    let (frame, folded) = chosen(&document, frame)?;
    let mut notes = Vec::from_iter(keys::not_known(&document));
    if folded && frame.own("vertices_coords").is_none() {
        let expected = "the folded positions of the vertices";
        return Err(frame.missing("vertices_coords", expected));
    }
    let vertices = points(&frame)?;
    let Some(faces) = faces(&frame)? else {
        return Err(frame.missing("faces_vertices", "the faces of the shape"));
    };
    let ends = match frame.get("edges_vertices") {
        Some(_) => {
            let drawn = edges(&document, &frame, None, &mut notes)?;
            if let Some((edge, _)) = drawn.curves.first() {
                let place = format!("{}edges_vertices[{edge}]", frame.prefix());
                return Err(document.expected(place, "2 vertices", "4 of a curve"));
            }
            drawn.ends
        }
        None => Vec::new(),
    };
    let lettered = frame.get("edges_assignment").is_some();
    let letters = match lettered {
        true => letters(&frame, ends.len(), &mut notes)?,
        false => Vec::new(),
    };
    let goals = goals(&frame)?;
    if let Some(goals) = &goals {
        goals.check_count(&document, ends.len())?;
    }
    let goals = goals.filter(Goals::leads_away);
    let edges = ends.into_iter().enumerate().map(|(index, ends)| ShapeEdge {
        ends,
        letter: letters.get(index).copied(),
        angle: goals.as_ref().and_then(|goals| goals.angles[index]),
    });
    let shape = FoldedShape {
        vertices,
        faces,
        edges: edges.collect(),
    };
    shape.check().map_err(|source| FileError::Shape {
        path: path.to_path_buf(),
        source,
    })?;
    let list = format!("{}faces_vertices", frame.prefix_of("faces_vertices"));
    let place = |face: usize| format!("{list}[{face}]");
    Ok(ShapeFile {
        unit: unit(&frame, &mut notes)?,
        title: title(&document, &frame)?,
        shape: tidied(path, shape, Vertices::Shared, place, &mut notes)?,
        notes,
    })
}

/// Returns the frame with the shape, and `true` if the frame is a folded form.
fn chosen(document: &Document, number: Option<usize>) -> Result<(Frame<'_>, bool), FileError> {
    let frames = document.frames()?;
    let folded = |number: &usize| frames.classes[*number].folded_form;
    let number = match number {
        Some(number) if number > frames.len() => {
            let place = format!("file_frames[{}]", number - 1);
            return Err(document.expected(place, "a frame", "none"));
        }
        Some(number) => number,
        None => (1..=frames.len()).rev().find(folded).unwrap_or(0),
    };
    Ok((frames.get(number), folded(&number)))
}
