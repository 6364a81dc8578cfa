//! Faces from edges: walks round the left side of each directed edge.

use std::collections::HashMap;

use super::Drawing;

/// Faces of a planar drawing, counter-clockwise, given for each vertex the edges round it
/// counter-clockwise. Left out are the outside and holes: cycles whose every edge is lettered as a
/// boundary and has a face on its other side.
pub(super) fn faces(drawing: &Drawing, stars: &[Vec<usize>]) -> Vec<Vec<usize>> {
    // Directed edge 2e runs from the first end of e to the second, 2e + 1 back.
    let origin = |half: usize| drawing.edges[half / 2].ends[half % 2];
    let mut next = vec![usize::MAX; 2 * drawing.edges.len()];
    for (vertex, star) in stars.iter().enumerate() {
        for (place, &edge) in star.iter().enumerate() {
            // Arriving along `edge`, the face to the left continues along the next edge clockwise.
            let before = star[(place + star.len() - 1) % star.len()];
            let leaving = |e: usize| 2 * e + usize::from(drawing.edges[e].ends[0] != vertex);
            next[leaving(edge) ^ 1] = leaving(before);
        }
    }
    let mut cycle_of = vec![usize::MAX; next.len()];
    let mut cycles: Vec<Vec<usize>> = Vec::new();
    for start in 0..next.len() {
        if cycle_of[start] != usize::MAX {
            continue;
        }
        let mut cycle = Vec::new();
        let mut half = start;
        while cycle_of[half] == usize::MAX {
            cycle_of[half] = cycles.len();
            cycle.push(half);
            half = next[half];
        }
        cycles.push(cycle);
    }
    let inner: Vec<bool> = cycles
        .iter()
        .map(|cycle| area(drawing, cycle.iter().map(|&half| origin(half))) > 0.0)
        .collect();
    let is_hole = |cycle: &Vec<usize>| {
        cycle.iter().all(|&half| {
            let letter = drawing.edges[half / 2].letter;
            letter == super::Letter::Boundary && inner[cycle_of[half ^ 1]]
        })
    };
    let kept = cycles.iter().zip(&inner);
    let kept = kept.filter(|(cycle, inner)| **inner && !is_hole(cycle));
    kept.map(|(cycle, _)| cycle.iter().map(|&half| origin(half)).collect())
        .collect()
}

/// Signed area of a cycle of vertices, positive counter-clockwise.
pub(super) fn area(drawing: &Drawing, cycle: impl Iterator<Item = usize> + Clone) -> f64 {
    let shifted = cycle.clone().skip(1).chain(cycle.clone().take(1));
    let twice: f64 = cycle
        .zip(shifted)
        .map(|(a, b)| drawing.vertices[a].perp(&drawing.vertices[b]))
        .sum();
    twice / 2.0
}

/// The edge between two vertices, by both orders of its ends.
pub(super) fn edge_between(drawing: &Drawing) -> HashMap<[usize; 2], usize> {
    let edges = drawing.edges.iter().enumerate();
    edges
        .flat_map(|(index, edge)| {
            let [a, b] = edge.ends;
            [([a, b], index), ([b, a], index)]
        })
        .collect()
}
