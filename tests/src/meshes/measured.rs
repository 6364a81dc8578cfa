//! Sheets as they are measured or drawn by hand, and as files round them: nothing closes.

use foldpath::pattern::{CreasePattern, Drawing};
use nalgebra::Vector2;

use super::file::convex;
use crate::Random;

/// The drawing with each vertex off by up to a thousandth of the shortest edge, or far less; as it was if that is no
/// sheet of convex faces.
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

/// The drawing with its coordinates rounded to multiples of `unit`; as it was if that is no sheet of convex faces.
#[must_use]
pub fn rounded(drawing: Drawing, unit: f64) -> Drawing {
    with_vertices(drawing, |place| place.map(|x| (x / unit).round() * unit))
}

/// The drawing with its vertices moved; as it was if that is no sheet of convex faces.
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
