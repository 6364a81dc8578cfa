//! Measures the goal of a file that shows the folded sheet and names no fold angles.

use core::f64::consts::PI;

use nalgebra::Vector3;

use super::document::Frames;
use super::pattern::{Goals, points};
use crate::pattern::{CreasePattern, Edge, Letter};
use crate::read::FileError;
use crate::unfold::{FoldedShape, ShapeEdge, fold_angles};

/// Largest relative difference between the lengths of an edge in the folded and the flat sheet, both drawn to the same
/// scale.
const MAX_STRETCH_RATIO: f64 = 0.01;
/// Distance (radians) from half a turn within which the sign of an angle cannot be measured.
const HALF_TURN_RAD: f64 = 1e-6;

/// Measures the goal angles on the last folded frame that has positions. `flat` is the frame of the flat sheet if that
/// is in the same file; this frame is not measured. Returns `None` if no folded frame has positions.
///
/// # Errors
/// If the frame does not show the sheet of `pattern`.
pub(super) fn measured(
    frames: &Frames<'_>,
    flat: Option<usize>,
    pattern: &CreasePattern,
) -> Result<Option<Goals>, FileError> {
    let shows = |number: &usize| {
        Some(*number) != flat
            && frames.classes[*number].folded_form
            && frames.own(*number).own("vertices_coords").is_some()
    };
    let Some(number) = (1..=frames.len()).rev().chain([0]).find(shows) else {
        return Ok(None);
    };
    let frame = frames.own(number);
    let no_such_sheet =
        |expected: &str, found: &str| Err(frame.expected("vertices_coords", expected, found));
    let vertices = points(&frame)?;
    if vertices.len() != pattern.vertices().len() {
        let expected = format!("{} entries, one for each vertex", pattern.vertices().len());
        return no_such_sheet(&expected, &vertices.len().to_string());
    }
    let edges = &pattern.edges()[..pattern.drawn_edges()];
    if let Some((edge, stretch)) = stretched_edge(pattern, edges, &vertices) {
        let expected = "the sheet, its edges as long as in the crease pattern";
        let found = format!("edge {edge} off by {:.1} %", 100.0 * stretch);
        return no_such_sheet(expected, &found);
    }
    let faces = pattern.faces().iter();
    let shape = FoldedShape {
        vertices,
        faces: faces
            .map(|face| face.iter().map(|v| v.index()).collect())
            .collect(),
        edges: edges
            .iter()
            .map(|edge| ShapeEdge {
                ends: edge.ends.map(|end| end.index()),
                letter: Some(edge.letter),
                angle: None,
            })
            .collect(),
    };
    let angles = match fold_angles(&shape) {
        Ok(angles) => angles,
        Err(error) => return no_such_sheet("flat panels", &error.to_string()),
    };
    let against = |(edge, &angle): (&Edge, &f64)| {
        angle.abs() > 0.0 && edge.letter.sign() * angle <= 0.0 && says(edge)
    };
    if let Some(edge) = edges.iter().zip(&angles).position(against) {
        let found = format!(
            "edge {edge} folded by {:.3} degrees",
            angles[edge].to_degrees()
        );
        return no_such_sheet("edges folded as their letters say", &found);
    }
    let goals = edges.iter().zip(angles).map(|(edge, angle)| {
        let signless = PI - angle.abs() <= HALF_TURN_RAD && !says(edge);
        (!signless).then_some(angle)
    });
    Ok(Some(Goals {
        angles: goals.collect(),
        frame: frame.prefix(),
    }))
}

/// Returns the first edge whose length in the folded shape differs too much from that in the flat sheet, with the
/// relative difference, both drawn to the same scale.
fn stretched_edge(
    pattern: &CreasePattern,
    edges: &[Edge],
    vertices: &[Vector3<f64>],
) -> Option<(usize, f64)> {
    let lengths = edges.iter().map(|Edge { ends: [a, b], .. }| {
        let flat = pattern.vertices()[b.index()] - pattern.vertices()[a.index()];
        [
            flat.norm(),
            (vertices[b.index()] - vertices[a.index()]).norm(),
        ]
    });
    let sum = |which: usize| lengths.clone().map(|pair| pair[which]).sum::<f64>();
    let scale = sum(1) / sum(0);
    let stretch = lengths.map(|[flat, folded]| (folded / (scale * flat) - 1.0).abs());
    let within = |stretch: f64| stretch <= MAX_STRETCH_RATIO;
    stretch.enumerate().find(|&(_, stretch)| !within(stretch))
}

/// Returns `true` if the letter (FOLD assignment) of an edge determines its direction of folding.
fn says(edge: &Edge) -> bool {
    edge.letter != Letter::Unassigned
}
