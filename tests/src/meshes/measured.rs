//! Sheets as they are measured, drawn by hand or rounded by files: no configuration but the flat one closes exactly.

use foldpath::pattern::{CreasePattern, Drawing};
use nalgebra::Vector2;

use super::file::convex;
use crate::Random;

/// Returns the drawing with each vertex moved by up to a thousandth of the shortest edge, or far less. Returns the
/// drawing unchanged if the result is not a sheet of convex faces.
#[must_use]
pub fn measured(drawing: Drawing, random: &mut Random) -> Drawing {
    let length = |ends: [usize; 2]| {
        let [a, b] = ends.map(|end| drawing.vertices[end]);
        (a - b).norm()
    };
    let lengths = drawing.edges.iter().map(|edge| length(edge.ends));
    let off = random.log_uniform(1e-7, 1e-3) * lengths.fold(f64::INFINITY, f64::min);
    with_vertices(drawing, |place| {
        place + Vector2::new(random.uniform(-off, off), random.uniform(-off, off))
    })
}

/// Returns the drawing with coordinates rounded to multiples of `unit`, or unchanged if that is not a sheet of convex
/// faces.
#[must_use]
pub fn rounded(drawing: Drawing, unit: f64) -> Drawing {
    with_vertices(drawing, |place| place.map(|x| (x / unit).round() * unit))
}

/// Returns the drawing with its vertices moved, or unchanged if that is not a sheet of convex faces.
fn with_vertices(drawing: Drawing, moved: impl FnMut(&Vector2<f64>) -> Vector2<f64>) -> Drawing {
    let moved = Drawing {
        vertices: drawing.vertices.iter().map(moved).collect(),
        ..drawing.clone()
    };
    let pattern = CreasePattern::new(moved.clone());
    if pattern.is_ok_and(|pattern| convex(&pattern)) {
        moved
    } else {
        drawing
    }
}
