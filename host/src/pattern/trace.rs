//! Finds faces from edges by walking round the left side of each directed edge (half-edge traversal).

use nalgebra::Vector2;

use super::{Drawing, EdgeId, Letter, VertexId};
use crate::util::csr::Csr;

/// Returns the faces of a planar drawing, counter-clockwise. `stars` has the edges at each vertex, counter-clockwise.
/// The outside and holes are left out. A hole is a cycle whose edges all have the letter B and a face on their other
/// side.
pub(super) fn faces(drawing: &Drawing, stars: &Csr<EdgeId>) -> Csr<VertexId> {
    const NONE: usize = usize::MAX;
    // Directed edge 2e runs from the first end of edge e to the second, directed edge 2e + 1 runs back.
    let origin = |half: usize| VertexId::new(drawing.edges[half / 2].ends[half % 2]);
    let mut next = vec![NONE; 2 * drawing.edges.len()];
    for (vertex, star) in stars.iter().enumerate() {
        let leaving = |edge: EdgeId| {
            2 * edge.index() + usize::from(drawing.edges[edge.index()].ends[0] != vertex)
        };
        // At the end of an edge, the face to the left continues along the next edge clockwise.
        let clockwise = star
            .iter()
            .skip(1)
            .zip(star)
            .chain(star.first().zip(star.last()));
        for (&edge, &before) in clockwise {
            next[leaving(edge) ^ 1] = leaving(before);
        }
    }
    let mut cycle_of = vec![NONE; next.len()];
    let mut cycles: Csr<usize> = Csr::default();
    for start in 0..next.len() {
        if cycle_of[start] != NONE {
            continue;
        }
        let cycle = cycles.len();
        let mut half = start;
        cycles.push(core::iter::from_fn(|| {
            let here = half;
            half = next[here];
            let new = cycle_of[here] == NONE;
            cycle_of[here] = cycle;
            new.then_some(here)
        }));
    }
    let inner: Vec<bool> = cycles
        .iter()
        .map(|cycle| area(drawing, cycle.iter().map(|&half| origin(half))) > 0.0)
        .collect();
    let is_hole = |cycle: &[usize]| {
        cycle.iter().all(|&half| {
            let letter = drawing.edges[half / 2].letter;
            letter == Letter::Boundary && inner[cycle_of[half ^ 1]]
        })
    };
    let kept = cycles.iter().zip(&inner);
    let kept = kept.filter(|(cycle, inner)| **inner && !is_hole(cycle));
    kept.map(|(cycle, _)| cycle.iter().map(|&half| origin(half)))
        .collect()
}

/// Returns the signed area of a cycle of vertices, positive counter-clockwise.
pub(super) fn area(drawing: &Drawing, cycle: impl Iterator<Item = VertexId> + Clone) -> f64 {
    let places = cycle.map(|vertex| drawing.vertices[vertex.index()]);
    twice_area(places) / 2.0
}

/// Returns twice the signed area of a polygon. Coordinates are taken relative to the first corner, because far from the
/// origin the products of absolute coordinates would cancel completely.
pub(crate) fn twice_area(corners: impl Iterator<Item = Vector2<f64>> + Clone) -> f64 {
    let Some(first) = corners.clone().next() else {
        return 0.0;
    };
    let from_first = corners.map(|corner| corner - first);
    let next = from_first.clone().skip(1);
    from_first.zip(next).map(|(a, b)| a.perp(&b)).sum()
}
