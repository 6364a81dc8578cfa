//! Finds sides of a sheet at which lines end in the open because no border is drawn.

use core::ops::Range;
use std::collections::BTreeSet;

use nalgebra::Vector2;

use crate::pattern::{DrawnEdge, Letter};
use crate::util::csr::group_by_key;
use crate::util::hull::convex_hull;

/// A part of the drawing's convex hull where a border is missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MissingBorder {
    /// Its ends, of which the first comes first counter-clockwise; the same if the whole hull has no border.
    pub(super) ends: [Vector2<f64>; 2],
    /// Number of lines that end there in the open.
    pub(super) lines: usize,
}

/// Smallest number of lines that end in the open at a side without a border. A single line may just be too long.
const MIN_LINES: usize = 2;

/// Finds the parts of the convex hull at which several lines end in the open. `near` is the distance within which points
/// lie on a line. Ends of lines that go past a border do not count, nor do ends of lines shorter than `short`.
pub(super) fn missing_borders(
    points: &[Vector2<f64>],
    pieces: &[DrawnEdge],
    near: f64,
    short: f64,
) -> Vec<MissingBorder> {
    let ends = pieces.iter().enumerate();
    let ends = ends.flat_map(|(index, piece)| piece.ends.map(|end| (end, index)));
    let stars = group_by_key(points.len(), ends);
    let is_border = |&piece: &usize| pieces[piece].letter == Letter::Boundary;
    let is_open = |vertex: usize| {
        let &[piece] = &stars[vertex] else {
            return false;
        };
        let [a, b] = pieces[piece].ends;
        let other = if a == vertex { b } else { a };
        let is_past_border = !is_border(&piece) && stars[other].iter().any(is_border);
        (points[a] - points[b]).norm() > short && !is_past_border
    };
    let used = (0..points.len()).filter(|&vertex| !stars[vertex].is_empty());
    let open: Vec<usize> = used.clone().filter(|&vertex| is_open(vertex)).collect();
    if open.len() < MIN_LINES {
        return Vec::new();
    }
    let corners = convex_hull(used.map(|vertex| points[vertex]).collect(), near);
    let corner = |index: usize| corners[index % corners.len()];
    // The open ends at each side of the hull.
    let at_side = |side: usize| {
        let [a, b] = [corner(side), corner(side + 1)];
        let along = (b - a).normalize();
        let is_there = move |vertex: &usize| {
            let from = points[*vertex] - a;
            along.perp(&from).abs() <= near
                && (-near..=(b - a).norm() + near).contains(&along.dot(&from))
        };
        open.iter().copied().filter(is_there)
    };
    let is_missing = |side: usize| at_side(side % corners.len()).count() >= MIN_LINES;
    let sides = 0..corners.len();
    // Sides without a border that follow each other count as one.
    let first = sides.clone().find(|&side| !is_missing(side));
    let mut missing: Vec<(Range<usize>, BTreeSet<usize>)> = Vec::new();
    for side in sides.map(|side| side + first.unwrap_or_default()) {
        if !is_missing(side) {
            continue;
        }
        let ends = at_side(side % corners.len());
        match missing.last_mut() {
            Some((sides, lines)) if sides.end == side => {
                sides.end += 1;
                lines.extend(ends);
            }
            _ => missing.push((side..side + 1, ends.collect())),
        }
    }
    let missing = missing.into_iter().map(|(sides, lines)| MissingBorder {
        ends: [corner(sides.start), corner(sides.end)],
        lines: lines.len(),
    });
    missing.collect()
}
