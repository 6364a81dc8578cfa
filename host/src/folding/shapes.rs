//! Folded shapes of the sheet along a path, and the deformation of each face in them.

use nalgebra::Vector3;

use super::{FoldingMap, SpanningTree, fit_sheets};
use crate::motion::Motion;
use crate::pattern::FaceId;
use crate::util::nan_max::largest;

/// Largest turn of a hinge from one shape to the next, radians, where vertices are drawn on straight lines between
/// shapes: the drawn sheet is then shorter than the real one by a thousandth.
pub const STEP: f64 = 0.1;

/// Returns the folded positions of the vertices at each knot: those that are stored, or else those of the folding map.
///
/// Each shape is aligned with the one before by rigid registration, the first one with the flat sheet, so that the
/// whole stays where it is while it folds. Cost: O(faces) for each knot.
pub fn shapes(motion: &Motion) -> impl Iterator<Item = Vec<Vector3<f64>>> {
    shapes_with(motion, &[])
}

/// Returns the positions of the vertices as [`shapes`] does, followed by those of points in the frame of the flat sheet, each
/// of which moves with a face.
pub fn shapes_with<'a>(
    motion: &'a Motion,
    points: &'a [(FaceId, Vector3<f64>)],
) -> impl Iterator<Item = Vec<Vector3<f64>>> + 'a {
    let pattern = &motion.pattern;
    let tree = pattern.tree();
    let flat: Vec<_> = pattern.vertices().iter().map(|v| v.push(0.0)).collect();
    (0..motion.knots.len()).scan(flat, move |before, knot| {
        let mut shape = positions(motion, tree, knot);
        let (r_ba, [from, to]) = fit_sheets(pattern, &shape, before);
        if !points.is_empty() {
            let map = FoldingMap::new(pattern, tree, &motion.crease_angles(knot));
            let places = points
                .iter()
                .map(|(face, at)| map.poses()[face.index()].carry(at));
            shape.extend(places);
        }
        let laid = shape.iter().map(|point| r_ba * (point - from) + to);
        let laid: Vec<_> = laid.collect();
        before.clear();
        before.extend_from_slice(&laid[..pattern.vertices().len()]);
        Some(laid)
    })
}

/// Returns for each face the largest relative change of length of its edges and diagonals, at the knots and between
/// them.
#[must_use]
pub fn deformation_of_faces(motion: &Motion) -> Vec<f64> {
    let pattern = &motion.pattern;
    let mut worst = vec![0.0_f64; pattern.faces().len()];
    for shape in shapes(&motion.with_steps(STEP)) {
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

/// Returns the positions of the vertices at a knot: those that are stored, or else those of the folding map.
fn positions(motion: &Motion, tree: &SpanningTree, knot: usize) -> Vec<Vector3<f64>> {
    let stored = &motion.knots[knot].vertices;
    if !stored.is_empty() {
        return stored.clone();
    }
    let map = FoldingMap::new(&motion.pattern, tree, &motion.crease_angles(knot));
    map.vertices().to_vec()
}
