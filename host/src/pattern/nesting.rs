//! Finds inside which region of a drawing each part of it lies that no line joins to the rest.
//!
//! Implements the sweep of J. Bentley and T. Ottmann ("Algorithms for reporting and counting geometric intersections",
//! 1979) for lines that do not cross: a vertical line goes over the sheet from left to right and keeps the edges that it
//! meets in their order. All orientation tests are exact.

use robust::{Coord, orient2d};

use super::{Drawing, EdgeId, PatternError};
use crate::util::csr::Csr;
use crate::util::progress::Watch;
use crate::util::union_find::UnionFind;

/// Largest number of entries of the list of edges that may be moved as edges come and go: some seconds of copying.
const MAX_MOVED: u64 = 1 << 35;

/// Number of vertices between two looks at the clock.
const VERTICES_BETWEEN_LOOKS: usize = 1 << 12;

/// A connected part of the edges of a drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Component {
    /// Its leftmost vertex; of several the lowest. Nothing of the component is to the left of it.
    pub(super) first: usize,
    /// The directed edge right below that vertex, with the vertex on its left: 2e runs from the first end of edge e to the
    /// second, 2e + 1 runs back. It belongs to another component. `None` if there is none below.
    pub(super) below: Option<usize>,
}

/// Returns the components of a planar drawing from left to right, so that each comes after the component of the edge below
/// it. `stars` has the edges at each vertex, counter-clockwise from direction -π. Cost: O(n log n) comparisons for n edges.
///
/// # Errors
/// If too many edges lie one above the other, or if the caller cancels.
pub(super) fn components(
    drawing: &Drawing,
    stars: &Csr<EdgeId>,
    watch: Watch<'_>,
) -> Result<Vec<Component>, PatternError> {
    let points = &drawing.vertices;
    let mut sets = UnionFind::new(points.len());
    for edge in &drawing.edges {
        sets.join(edge.ends);
    }
    let mut order: Vec<usize> = (0..points.len())
        .filter(|&vertex| !stars[vertex].is_empty())
        .collect();
    order.sort_unstable_by(|&a, &b| {
        // Adding 0 turns a negative zero into zero.
        let [a, b] = [a, b].map(|vertex| points[vertex].map(|c| c + 0.0));
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y))
    });
    let mut rank = vec![0; points.len()];
    for (index, &vertex) in order.iter().enumerate() {
        rank[vertex] = index;
    }
    let mut seen = vec![false; points.len()];
    let is_first = |vertex: usize, sets: &mut UnionFind, seen: &mut Vec<bool>| {
        !core::mem::replace(&mut seen[sets.find(vertex)], true)
    };
    let firsts: Vec<usize> = order
        .iter()
        .copied()
        .filter(|&vertex| is_first(vertex, &mut sets, &mut seen))
        .collect();
    let mut components: Vec<Component> = firsts
        .into_iter()
        .map(|first| Component { first, below: None })
        .collect();
    if components.len() < 2 {
        return Ok(components);
    }
    // The ends of an edge from left to right.
    let ends = |edge: usize| {
        let [a, b] = drawing.edges[edge].ends;
        if rank[a] < rank[b] { [a, b] } else { [b, a] }
    };
    let coord = |vertex: usize| Coord {
        x: points[vertex].x,
        y: points[vertex].y,
    };
    let mut met: Vec<usize> = Vec::new();
    let mut moved: u64 = 0;
    let mut next = components.iter_mut().peekable();
    for (index, &vertex) in order.iter().enumerate() {
        let is_below = |&edge: &usize| {
            let [left, right] = ends(edge).map(coord);
            ends(edge)[1] != vertex && orient2d(left, right, coord(vertex)) > 0.0
        };
        let from = met.partition_point(is_below);
        if let Some(component) = next.next_if(|component| component.first == vertex)
            && let Some(&edge) = from.checked_sub(1).and_then(|below| met.get(below))
        {
            let is_backwards = ends(edge)[0] != drawing.edges[edge].ends[0];
            component.below = Some(2 * edge + usize::from(is_backwards));
        }
        let ending = met[from..]
            .iter()
            .take_while(|&&edge| ends(edge)[1] == vertex)
            .count();
        let starting = stars[vertex].iter().map(|edge| edge.index());
        let starting = starting.filter(|&edge| ends(edge)[0] == vertex);
        met.splice(from..from + ending, starting);
        moved += (met.len() - from.min(met.len())) as u64;
        if index % VERTICES_BETWEEN_LOOKS == 0 && watch.is_over() {
            return Err(PatternError::Cancelled);
        }
        if moved > MAX_MOVED {
            let edge = stars[vertex].first().map_or(0, |edge| edge.index());
            return Err(PatternError::Crowded { edge });
        }
    }
    Ok(components)
}
