//! Checks that a drawing is planar: no edge crosses another edge or passes through a vertex.

use nalgebra::Vector2;
use robust::{Coord, orient2d};

use super::{Drawing, PatternError};
use crate::util::csr::group_by_key;
use crate::util::progress::Watch;

/// Mean number of cells covered by an edge above which the grid is made coarser.
const MAX_CELLS_PER_EDGE: f64 = 64.0;

/// Budget of compared pairs of edges: the first number for each edge, but in all at least the second. If all edges are
/// in one place, each is near all others. In tessellations each is near some tens of others.
const MAX_PAIRS: [usize; 2] = [1 << 10, 1 << 27];

/// Checks every pair of edges that come near each other. A uniform grid with cells of about one edge length finds these
/// pairs in expected linear time. The orientation tests are exact. Vertices at the same place count as one: `places`
/// has for each vertex the first vertex at its place.
pub(super) fn check(
    drawing: &Drawing,
    places: &[usize],
    watch: Watch<'_>,
) -> Result<(), PatternError> {
    let mut cell = mean_extent(drawing);
    let covered = |cell: f64| -> f64 {
        let cells = |e: &super::DrawnEdge| {
            let [low, high] = bounds(drawing, e.ends);
            (high - low).iter().map(|d| d / cell + 2.0).product::<f64>()
        };
        drawing.edges.iter().map(cells).sum()
    };
    #[allow(clippy::cast_precision_loss, reason = "a bound on work, not a result")]
    let most = MAX_CELLS_PER_EDGE * drawing.edges.len() as f64;
    while covered(cell) > most {
        cell *= 2.0;
    }
    let cells = |edge: usize| {
        let bounds = bounds(drawing, drawing.edges[edge].ends);
        #[allow(
            clippy::cast_possible_truncation,
            reason = "saturates, and cells may be shared"
        )]
        let [low, high] =
            bounds.map(|p| [(p.x / cell).floor() as i64, (p.y / cell).floor() as i64]);
        (low[0]..=high[0]).flat_map(move |x| (low[1]..=high[1]).map(move |y| [x, y]))
    };
    // Different cells that share a bucket cost time but do not change the result.
    let buckets = drawing.edges.len().next_power_of_two();
    let edges = 0..drawing.edges.len();
    let in_buckets = |edge| cells(edge).map(move |cell| (bucket(cell, buckets), edge));
    let grid = group_by_key(buckets, edges.clone().flat_map(in_buckets));
    let most = MAX_PAIRS[1].max(MAX_PAIRS[0] * drawing.edges.len());
    let mut pairs = 0;
    for edge in edges {
        for cell in cells(edge) {
            let list = &grid[bucket(cell, buckets)];
            for &other in list.iter().take_while(|other| **other < edge) {
                check_pair(drawing, places, edge, other)?;
                pairs += 1;
            }
        }
        if pairs > most {
            return Err(PatternError::Crowded { edge });
        }
        if watch.is_over() {
            return Err(PatternError::Cancelled);
        }
    }
    Ok(())
}

/// Returns the hash bucket of a cell; `buckets` is a power of two. Cells of one row have consecutive buckets, and rows
/// are spread by the golden ratio (Fibonacci hashing).
#[allow(
    clippy::cast_possible_truncation,
    reason = "below the number of buckets"
)]
fn bucket([x, y]: [i64; 2], buckets: usize) -> usize {
    let row = y.cast_unsigned().wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let start = row >> (buckets.leading_zeros() + 1);
    start.wrapping_add(x.cast_unsigned()) as usize & (buckets - 1)
}

fn mean_extent(drawing: &Drawing) -> f64 {
    let extents = drawing.edges.iter().map(|e| {
        let [low, high] = bounds(drawing, e.ends);
        (high - low).max()
    });
    #[allow(clippy::cast_precision_loss, reason = "a mean for a grid")]
    let mean = extents.sum::<f64>() / drawing.edges.len() as f64;
    mean
}

fn bounds(drawing: &Drawing, ends: [usize; 2]) -> [Vector2<f64>; 2] {
    let [a, b] = ends.map(|v| drawing.vertices[v]);
    [a.inf(&b), a.sup(&b)]
}

fn check_pair(
    drawing: &Drawing,
    places: &[usize],
    edge: usize,
    other: usize,
) -> Result<(), PatternError> {
    let [[a, b], [c, d]] = [edge, other].map(|edge| drawing.edges[edge].ends.map(|v| places[v]));
    let boxes = [bounds(drawing, [a, b]), bounds(drawing, [c, d])];
    if (0..2).any(|k| boxes[0][0][k] > boxes[1][1][k] || boxes[1][0][k] > boxes[0][1][k]) {
        return Ok(());
    }
    let coord = |v: usize| Coord {
        x: drawing.vertices[v].x,
        y: drawing.vertices[v].y,
    };
    let turn = |p: usize, q: usize, r: usize| {
        let turn = orient2d(coord(p), coord(q), coord(r));
        i8::from(turn > 0.0) - i8::from(turn < 0.0)
    };
    // A vertex on the line through an edge is on the edge if it lies between the ends.
    let on = |v: usize, [p, q]: [usize; 2], turn: i8| {
        let [to_p, to_q] = [p, q].map(|end| drawing.vertices[end] - drawing.vertices[v]);
        turn == 0 && v != p && v != q && to_p.dot(&to_q) <= 0.0
    };
    let (c_side, d_side) = (turn(a, b, c), turn(a, b, d));
    let (a_side, b_side) = (turn(c, d, a), turn(c, d, b));
    for (edge, vertex, ends, side) in [
        (edge, c, [a, b], c_side),
        (edge, d, [a, b], d_side),
        (other, a, [c, d], a_side),
        (other, b, [c, d], b_side),
    ] {
        if on(vertex, ends, side) {
            return Err(PatternError::OnEdge { edge, vertex });
        }
    }
    if c_side * d_side < 0 && a_side * b_side < 0 {
        return Err(PatternError::Crossing { edge, other });
    }
    Ok(())
}
