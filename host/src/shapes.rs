//! Folded shapes of the sheet along a path, and the deformation of each face in them.

use nalgebra::Vector3;

use crate::check::positions;
use crate::folding::{SpanningTree, align_sheets};
use crate::formats::fold::PathFile;
use crate::util::nan_max::largest;

/// Largest turn of a hinge from one shape to the next, radians, where vertices are drawn on straight lines between
/// shapes: the drawn sheet is then shorter than the real one by a thousandth.
pub const STEP: f64 = 0.1;

/// Returns the folded positions of the vertices at each knot: those in the file, or else those of the folding map.
///
/// Each shape is aligned with the one before by rigid registration, the first one with the flat sheet, so that every
/// sheet as a whole stays where it is while it folds. Cost: O(faces) for each knot.
pub fn shapes(path: &PathFile) -> impl Iterator<Item = Vec<Vector3<f64>>> {
    let pattern = &path.pattern;
    let tree = SpanningTree::from_central_face(pattern);
    let flat: Vec<_> = pattern.vertices().iter().map(|v| v.push(0.0)).collect();
    path.knots.iter().scan(flat, move |before, knot| {
        *before = align_sheets(pattern, &positions(pattern, &tree, knot), before);
        Some(before.clone())
    })
}

/// Returns for each face the largest relative change of length of its edges and diagonals, at the knots and between
/// them.
#[must_use]
pub fn deformation_of_faces(path: &PathFile) -> Vec<f64> {
    let pattern = &path.pattern;
    let mut worst = vec![0.0_f64; pattern.faces().len()];
    for shape in shapes(&path.with_steps(STEP)) {
        for (worst, triangles) in worst.iter_mut().zip(pattern.triangles().iter()) {
            let sides = triangles
                .iter()
                .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
            let changes = sides.map(|ends| {
                let [a, b] = ends.map(|end| shape[end.index()]);
                ((b - a).norm() / pattern.length(ends) - 1.0).abs()
            });
            *worst = largest(changes.chain([*worst]));
        }
    }
    worst
}
