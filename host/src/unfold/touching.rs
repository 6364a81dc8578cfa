//! Gives corners that touch in the flat pattern exactly the same place, so that the sides there count as a slit.

use std::collections::HashMap;

use nalgebra::{Vector2, Vector3};

use crate::pattern::{Drawing, DrawnEdge, Letter};
use crate::util::nan_max::bounding_box;

/// Largest number of pairs of a side and a corner that are compared. If there are more, the remaining sides stay as they
/// are.
const MAX_PAIRS: usize = 1 << 28;

/// Moves corners of the boundary that lie within `tolerance` of each other to one place, and adds a corner to each side on
/// which a corner of another face lies. `sources` has for each vertex its place in the folded shape, and is extended.
pub(super) fn join_touching(
    drawing: &mut Drawing,
    sources: &mut Vec<Vector3<f64>>,
    tolerance: f64,
) {
    let is_rim = |edge: &&DrawnEdge| edge.letter == Letter::Boundary;
    let rim = drawing.edges.iter().filter(is_rim);
    let mut corners: Vec<usize> = rim.flat_map(|edge| edge.ends).collect();
    corners.sort_unstable();
    corners.dedup();
    let places = corners.iter().map(|&corner| drawing.vertices[corner]);
    let (low, high) = bounding_box(places).unwrap_or_default();
    let axis = (high - low).imax();
    corners.sort_by(|&a, &b| drawing.vertices[a][axis].total_cmp(&drawing.vertices[b][axis]));
    for (k, &corner) in corners.iter().enumerate() {
        let place = drawing.vertices[corner];
        let before = corners[..k].iter().rev();
        let mut before =
            before.take_while(|&&c| place[axis] - drawing.vertices[c][axis] <= tolerance);
        if let Some(&near) = before.find(|&&c| (drawing.vertices[c] - place).norm() <= tolerance) {
            drawing.vertices[corner] = drawing.vertices[near];
        }
    }
    split_sides(drawing, sources, &corners, axis, tolerance);
}

/// Adds a corner to each side of the boundary on which a corner of another face lies. `corners` are those of the boundary
/// in the order of their places along `axis`.
fn split_sides(
    drawing: &mut Drawing,
    sources: &mut Vec<Vector3<f64>>,
    corners: &[usize],
    axis: usize,
    tolerance: f64,
) {
    let Some(faces) = &mut drawing.faces else {
        return;
    };
    let mut face_at = HashMap::new();
    for (face, cycle) in faces.iter().enumerate() {
        let next = cycle.iter().cycle().skip(1);
        face_at.extend(cycle.iter().zip(next).map(|(&a, &b)| ([a, b], face)));
    }
    let along: Vec<f64> = corners.iter().map(|&c| drawing.vertices[c][axis]).collect();
    let mut compared = 0;
    for edge in 0..drawing.edges.len() {
        let [a, b] = drawing.edges[edge].ends;
        let found = face_at.get(&[a, b]).or_else(|| face_at.get(&[b, a]));
        let (Letter::Boundary, Some(&face)) = (drawing.edges[edge].letter, found) else {
            continue;
        };
        let [from, to] = [a, b].map(|end| drawing.vertices[end]);
        let side = to - from;
        let (least, most) = (from[axis].min(to[axis]), from[axis].max(to[axis]));
        let first = along.partition_point(|x| *x < least - tolerance);
        let behind = along.partition_point(|x| *x <= most + tolerance);
        compared += behind - first;
        if compared > MAX_PAIRS {
            return;
        }
        let fraction = |place: Vector2<f64>| (place - from).dot(&side) / side.norm_squared();
        let touches = |&corner: &usize| {
            let place = drawing.vertices[corner];
            let off = side.perp(&(place - from)).abs() / side.norm();
            let inner = [from, to]
                .iter()
                .all(|end| (end - place).norm() > tolerance);
            let between = (0.0..=1.0).contains(&fraction(place));
            off <= tolerance && inner && between && !faces[face].contains(&corner)
        };
        let touching = corners[first..behind].iter().copied().filter(touches);
        let places = touching.map(|corner| drawing.vertices[corner]);
        let mut places: Vec<_> = places.map(|place| (fraction(place), place)).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        places.dedup_by(|a, b| a.1 == b.1);
        if places.is_empty() {
            continue;
        }
        let mut chain = vec![a];
        for (fraction, place) in places {
            chain.push(drawing.vertices.len());
            drawing.vertices.push(place);
            sources.push(sources[a].lerp(&sources[b], fraction));
        }
        chain.push(b);
        let cycle = &mut faces[face];
        let at = |end| cycle.iter().position(|corner| *corner == end);
        if let (Some(at_a), Some(at_b)) = (at(a), at(b)) {
            let inner = &chain[1..chain.len() - 1];
            if (at_a + 1) % cycle.len() == at_b {
                cycle.splice(at_a + 1..at_a + 1, inner.iter().copied());
            } else {
                cycle.splice(at_b + 1..at_b + 1, inner.iter().rev().copied());
            }
        }
        let mut parts = chain.windows(2).map(|ends| [ends[0], ends[1]]);
        drawing.edges[edge].ends = parts.next().unwrap_or([a, b]);
        drawing.edges.extend(parts.map(DrawnEdge::boundary));
    }
}
