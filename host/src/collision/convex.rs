//! Cuts faces into convex parts.

use nalgebra::Vector2;

use crate::pattern::{CreasePattern, FaceId, VertexId};

/// Largest sine of a bend to the right at a corner that counts as straight, as on the sides of waterbomb units.
const STRAIGHT_SINE: f64 = 1e-12;

/// Returns the convex parts of a face, each as a cycle of vertices: the face itself, or else its triangles, joined across
/// the diagonals that convexity does not need, in the order of the triangulation (S. Hertel, K. Mehlhorn, "Fast
/// triangulation of simple polygons", 1983). At most four times as many as there have to be.
pub(super) fn convex_parts(pattern: &CreasePattern, face: FaceId) -> Vec<Vec<VertexId>> {
    let cycle = &pattern.faces()[face.index()];
    if is_convex(pattern, cycle) {
        return vec![cycle.to_vec()];
    }
    let triangles = &pattern.triangles()[face.index()];
    let mut parts: Vec<Vec<VertexId>> = triangles.iter().map(|corners| corners.to_vec()).collect();
    // Each triangle but the last was cut off along the side between its first and third corner.
    let cut_off = triangles.split_last().map_or(&[][..], |(_, others)| others);
    for &[to, _, from] in cut_off {
        let side = |from: VertexId, to: VertexId| {
            parts.iter().enumerate().find_map(|(part, corners)| {
                let next = corners.iter().cycle().skip(1);
                let mut sides = corners.iter().zip(next);
                let at = sides.position(|(a, b)| [*a, *b] == [from, to])?;
                Some((part, at))
            })
        };
        let (Some((one, at)), Some((other, beyond))) = (side(from, to), side(to, from)) else {
            continue;
        };
        let mut joined = parts[one].clone();
        // From the end of the diagonal round one part to its start, and on round the other part.
        joined.rotate_left(at + 1);
        let others = &parts[other];
        let inner = (2..others.len()).map(|k| others[(beyond + k) % others.len()]);
        joined.extend(inner);
        if is_convex(pattern, &joined) {
            parts[one] = joined;
            parts.remove(other);
        }
    }
    parts
}

/// Returns `true` if a cycle of vertices nowhere bends to the right.
pub(super) fn is_convex(pattern: &CreasePattern, cycle: &[VertexId]) -> bool {
    let point = |k: usize| pattern.vertices()[cycle[k % cycle.len()].index()];
    (0..cycle.len()).all(|k| {
        let (a, b, c) = (point(k), point(k + 1), point(k + 2));
        let turn = (b - a).perp(&(c - b));
        turn >= -STRAIGHT_SINE * (b - a).norm() * (c - b).norm()
    })
}

/// Returns the length of the shortest edge of a face, or its least width if that is less.
pub(super) fn size(pattern: &CreasePattern, cycle: &[VertexId]) -> f64 {
    let point = |v: &VertexId| pattern.vertices()[v.index()];
    let next = cycle.iter().cycle().skip(1);
    let sides = cycle.iter().zip(next);
    let shortest = sides.map(|(a, b)| (point(b) - point(a)).norm());
    let corners: Vec<Vector2<f64>> = cycle.iter().map(point).collect();
    shortest.fold(least_width(&corners), f64::min)
}

/// Returns the least width of a polygon across one of its sides.
pub(super) fn least_width(corners: &[Vector2<f64>]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let widths = corners.iter().zip(next).map(|(a, b)| {
        let side = b - a;
        let across = corners.iter().map(|corner| side.perp(&(corner - a)).abs());
        across.fold(0.0, f64::max) / side.norm()
    });
    widths.fold(f64::INFINITY, f64::min)
}
