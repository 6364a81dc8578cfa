//! The shapes of the sheet along a path.

use nalgebra::Vector3;

use crate::check::positions;
use crate::folding::{SpanningTree, sheets_laid_on};
use crate::formats::fold::PathFile;
use crate::numbers::largest;

/// Radians that a hinge turns at most from one shape to the next where vertices are drawn on straight lines
/// between: what is drawn is then shorter than the sheet by a thousandth.
pub const STEP: f64 = 0.1;

/// For each knot the folded positions of the vertices, those in the file or else by the folding map. Each
/// shape is laid on the one before, from the flat sheet on, so that every sheet as a whole stays where it is
/// while it folds. Cost: O(faces) a knot.
pub fn shapes(path: &PathFile) -> impl Iterator<Item = Vec<Vector3<f64>>> {
    let pattern = &path.pattern;
    let tree = SpanningTree::from_central_face(pattern);
    let flat: Vec<_> = pattern.vertices().iter().map(|v| v.push(0.0)).collect();
    path.knots.iter().scan(flat, move |before, knot| {
        *before = sheets_laid_on(pattern, &positions(pattern, &tree, knot), before);
        Some(before.clone())
    })
}

/// For each face the largest relative change of length of its edges and diagonals, at knots and between them.
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
