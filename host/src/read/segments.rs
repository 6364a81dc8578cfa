//! Repairs loose coloured line segments, as drawing programs leave them, into a planar drawing.
//!
//! Ends that nearly meet become one vertex. Lines are split where they cross, where other lines end on them and where
//! they overlap. Lines drawn twice are kept once. Lines that end in the open or lie within a panel are left out. Every
//! repair is reported with a count. Expected cost: O(n log n), as a uniform grid finds the neighbours of each line.

mod grid;
mod places;
mod planar;
mod repairs;

use std::path::Path;

use nalgebra::Vector2;

use self::planar::{Looks, planar};
use super::FileError;
use super::fold::PatternFile;
use crate::pattern::{CreasePattern, Drawing, LARGEST, Letter, PatternError};
use crate::progress::Watch;

/// Largest number of lines and of crossings. A hatched sheet has quadratically many crossings, and memory is finite.
pub(super) const MOST: usize = 1 << 22;

/// A straight line as drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// End points, y pointing up.
    pub(super) ends: [Vector2<f64>; 2],
    /// The letter (FOLD assignment) of the line.
    pub(super) letter: Letter,
    /// Goal fold angle in radians, valley positive.
    pub(super) goal: Option<f64>,
}

/// Makes a crease pattern of segments, titled by the name of the file; `notes` become its assumptions. `rounding` is
/// the largest distance of an end from the place where it was drawn.
///
/// # Errors
/// If the lines enclose no faces, are too many, or form no crease pattern even when repaired.
pub(super) fn pattern_file(
    path: &Path,
    segments: Vec<Segment>,
    rounding: f64,
    notes: Vec<String>,
    watch: Watch<'_>,
) -> Result<PatternFile, FileError> {
    let expected = |expected: String, found: String| FileError::Expected {
        path: path.to_path_buf(),
        place: "the drawing".into(),
        expected,
        found,
    };
    let finite = |segment: &Segment| {
        let coordinates = segment.ends.iter().flat_map(|end| end.iter());
        coordinates.into_iter().all(|c| c.abs() <= LARGEST)
    };
    if !segments.iter().all(finite) {
        let found = "a larger one".into();
        return Err(expected("coordinates from -1e50 to 1e50".into(), found));
    }
    let drawn = segments.len();
    let too_many = || {
        let found = "more (are lines hatched or drawn many times over?)".into();
        let most = format!("at most {MOST} lines and crossings, and not too many near each other");
        expected(most, found)
    };
    let (drawing, mut repairs) = planar(segments, rounding, watch).ok_or_else(too_many)?;
    if drawing.edges.len() < 3 {
        let found = format!("{drawn} lines, none of which does");
        return Err(expected("lines that enclose faces".into(), found));
    }
    let mut pattern = checked(path, drawing.clone(), watch)?;
    let (drawing, left_out) = without_islands(&pattern, drawing, watch).ok_or_else(too_many)?;
    if left_out > 0 {
        pattern = checked(path, drawing, watch)?;
        repairs.push(format!(
            "lines inside a panel and joined to nothing, which could not fold, left out with what they \
             enclose: {left_out}"
        ));
    }
    notes.into_iter().for_each(|note| pattern.assume(note));
    for repair in repairs {
        pattern.repaired(repair);
    }
    let title = path.file_stem().unwrap_or_default();
    Ok(PatternFile {
        title: title.to_string_lossy().into_owned(),
        pattern,
    })
}

/// Makes the crease pattern of a drawing; an error names its place in the file.
fn checked(path: &Path, drawing: Drawing, watch: Watch<'_>) -> Result<CreasePattern, FileError> {
    let vertices = drawing.vertices.clone();
    let edges: Vec<[usize; 2]> = drawing.edges.iter().map(|edge| edge.ends).collect();
    // The file's own coordinates, in which y points down.
    let written = |at: Vector2<f64>| format!("({}, {})", at.x, 0.0 - at.y);
    CreasePattern::watched(drawing, watch).map_err(|source| {
        if let PatternError::DeadEnd { edge, .. } | PatternError::OneFace { edge } = source {
            let [from, to] = edges[edge].map(|end| written(vertices[end]));
            return FileError::Expected {
                path: path.to_path_buf(),
                place: format!("the line from {from} to {to}"),
                expected: "different faces on its sides".into(),
                found: "one face all round what it leads to".into(),
            };
        }
        let frame = match place(&source, &edges).and_then(|vertex| vertices.get(vertex)) {
            Some(at) => format!("near {}, once repaired: ", written(*at)),
            None => "once repaired: ".into(),
        };
        FileError::Pattern {
            path: path.to_path_buf(),
            frame,
            source,
        }
    })
}

/// Removes the islands: sheets that lie inside a face of another sheet. Returns the drawing and the number of lines
/// removed, or `None` if the budget of proximity tests is used up.
fn without_islands(
    pattern: &CreasePattern,
    mut drawing: Drawing,
    watch: Watch<'_>,
) -> Option<(Drawing, usize)> {
    if pattern.sheets() < 2 {
        return Some((drawing, 0));
    }
    let points = pattern.vertices();
    let mut corners = vec![None; pattern.sheets()];
    let mut faces = Vec::new();
    for (face, &sheet) in pattern.faces().iter().zip(pattern.sheet_of_faces()) {
        let polygon = || face.iter().map(|vertex| points[vertex.index()]);
        corners[sheet as usize].get_or_insert(points[face[0].index()]);
        let [low, high] = polygon().fold([points[face[0].index()]; 2], |[low, high], p| {
            [low.inf(&p), high.sup(&p)]
        });
        faces.push((low, high, sheet as usize, face));
    }
    let corners = corners.into_iter().enumerate();
    let mut corners: Vec<_> = corners
        .filter_map(|(sheet, at)| Some((at?, sheet)))
        .collect();
    corners.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
    // A sheet inside an island also lies inside the face round the island. With the widest faces first, most faces of
    // islands are skipped.
    faces.sort_by(|a, b| (b.1.x - b.0.x).total_cmp(&(a.1.x - a.0.x)));
    let mut island = vec![false; pattern.sheets()];
    let mut looks = Looks::for_lines(drawing.edges.len(), watch);
    for (low, high, around, face) in faces {
        if island[around] {
            continue;
        }
        let from = corners.partition_point(|(at, _)| at.x <= low.x);
        let within = corners[from..].iter().take_while(|(at, _)| at.x < high.x);
        for &(at, sheet) in within {
            looks.take(1);
            if sheet == around || island[sheet] || at.y <= low.y || at.y >= high.y {
                continue;
            }
            looks.take(face.len());
            let polygon = face.iter().map(|vertex| points[vertex.index()]);
            let next = polygon.clone().cycle().skip(1);
            let above = polygon.zip(next).filter(|(a, b)| {
                let part = (at.x - a.x) / (b.x - a.x);
                (a.x > at.x) != (b.x > at.x) && a.y + part * (b.y - a.y) > at.y
            });
            island[sheet] = above.count() % 2 == 1;
        }
        if looks.are_used_up() {
            return None;
        }
    }
    let on_island = |edge: &crate::pattern::Edge| {
        let mut faces = edge.faces.iter().flatten();
        faces.any(|face| island[pattern.sheet_of_faces()[face.index()] as usize])
    };
    let before = drawing.edges.len();
    let mut edges = pattern.edges().iter();
    drawing
        .edges
        .retain(|_| !edges.next().is_some_and(on_island));
    let left_out = before - drawing.edges.len();
    Some((planar::drawing(&drawing.vertices, drawing.edges), left_out))
}

/// Returns a vertex at which the error lies, if the error has a place.
fn place(error: &PatternError, edges: &[[usize; 2]]) -> Option<usize> {
    match error {
        PatternError::NotFinite { vertex }
        | PatternError::BrokenStar { vertex }
        | PatternError::NoArea { vertex, .. }
        | PatternError::OnEdge { vertex, .. } => Some(*vertex),
        PatternError::NoLength { edge }
        | PatternError::Duplicate { edge, .. }
        | PatternError::Crossing { edge, .. }
        | PatternError::Overlap { edge, .. } => edges.get(*edge).map(|ends| ends[0]),
        _ => None,
    }
}
