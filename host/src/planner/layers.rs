//! Layers that lie on each other keep their order: where faces touch all over, neither is deep in the other, and yet one
//! that came from above must not leave below.

use std::collections::HashMap;

use nalgebra::Vector2;

use super::Path;
use crate::collision::Crossing;
use crate::folding::{FoldingMap, Pose, SpanningTree};
use crate::pattern::{CreasePattern, FaceId, VertexId};

/// Part of the median edge: closer faces touch.
const TOUCH: f64 = 1e-9;
/// Part of the square of the median edge: overlaps of less are none.
const OVERLAP: f64 = 1e-9;
/// Part of a segment beside a knot at which it is seen on which side a face is.
const BESIDE: f64 = 0.01;

/// The first knot at which a face leaves another on the side on which it did not come, if there is one, and the faces.
/// Cost: pairs of faces at each knot.
pub(super) fn passed(
    pattern: &CreasePattern,
    tree: &SpanningTree,
    path: &Path,
) -> Option<(usize, Crossing)> {
    let curves = path.curves();
    let mut map = FoldingMap::flat(pattern);
    let mut poses = |segment: usize, s: f64| {
        let angles: Vec<f64> = curves[segment].iter().map(|curve| curve.angle(s)).collect();
        map.fold_groups(pattern, tree, &path.memberships, &angles);
        map.poses().to_vec()
    };
    let mut sides: HashMap<[usize; 2], bool> = HashMap::new();
    for knot in 1..curves.len() {
        let [before, at, after] = [(knot - 1, 1.0 - BESIDE), (knot, 0.0), (knot, BESIDE)]
            .map(|(segment, s)| poses(segment, s));
        for a in 0..at.len() {
            let to_a = at[a].inverse();
            for b in a + 1..at.len() {
                let Some(point) = overlap(pattern, [a, b], to_a * at[b]) else {
                    continue;
                };
                let side = |poses: &[Pose]| {
                    let height = (poses[b].inverse() * poses[a]).apply(point).z;
                    (height.abs() > TOUCH * pattern.median_edge()).then_some(height > 0.0)
                };
                if let Some(came) = side(&before) {
                    sides.insert([a, b], came);
                }
                let came = sides.get(&[a, b]);
                if came.is_some_and(|came| side(&after).is_some_and(|leaves| leaves != *came)) {
                    let faces = [a, b].map(FaceId::new);
                    return Some((knot, Crossing { faces, depth: 0.0 }));
                }
            }
        }
    }
    None
}

/// A point of the first face, in the flat sheet, where the second lies on it, given as it is seen from the first; of the
/// triangles that do, the two that do most.
fn overlap(pattern: &CreasePattern, [a, b]: [usize; 2], b_in_a: Pose) -> Option<Vector2<f64>> {
    let unit = pattern.median_edge();
    let flat = |triangle: &[VertexId; 3]| triangle.map(|corner| pattern.vertices()[corner.index()]);
    let mut most = (OVERLAP * unit * unit, None);
    for theirs in &pattern.triangles()[b] {
        let corners = flat(theirs).map(|corner| b_in_a.apply(corner));
        if corners.iter().any(|corner| corner.z.abs() > TOUCH * unit) {
            return None;
        }
        for ours in &pattern.triangles()[a] {
            let common = clipped(flat(ours), corners.map(|corner| corner.xy()).to_vec());
            let Some(&first) = common.first() else {
                continue;
            };
            let area: f64 = common
                .windows(2)
                .map(|side| (side[0] - first).perp(&(side[1] - first)) / 2.0)
                .sum();
            if area.abs() > most.0 {
                #[allow(clippy::cast_precision_loss, reason = "a few corners")]
                let middle = common.iter().sum::<Vector2<f64>>() / common.len() as f64;
                most = (area.abs(), Some(middle));
            }
        }
    }
    most.1
}

/// What of a convex polygon lies in a counter-clockwise triangle (I. Sutherland, G. Hodgman).
fn clipped(triangle: [Vector2<f64>; 3], mut polygon: Vec<Vector2<f64>>) -> Vec<Vector2<f64>> {
    for side in 0..3 {
        let [from, to] = [triangle[side], triangle[(side + 1) % 3]];
        let inside = |p: &Vector2<f64>| (to - from).perp(&(p - from));
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (k, p) in polygon.iter().enumerate() {
            let q = polygon[(k + 1) % polygon.len()];
            let [here, next] = [inside(p), inside(&q)];
            if here >= 0.0 {
                kept.push(*p);
            }
            if here * next < 0.0 {
                kept.push(p + (q - p) * (here / (here - next)));
            }
        }
        polygon = kept;
    }
    polygon
}
