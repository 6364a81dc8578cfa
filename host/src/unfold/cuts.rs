//! Orders the edges of a surface for the spanning tree along which the surface is laid flat, in several ways.

use nalgebra::Vector3;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

use super::FoldedShape;
use super::angles::Creases;
use super::surface::Surface;

/// Returns the edges between two faces in the order in which they join faces (as in Kruskal's algorithm). An edge joins
/// its faces unless that closes a ring; all remaining edges are whole only if both their faces come to lie at the same
/// place.
///
/// Attempt 0 goes outwards from the middle: of otherwise equal edges, those near the middle come first. Every other
/// attempt cuts for each vertex the edge that rises most steeply in some direction (W. Schlickenrieder, "Nets of
/// polyhedra", 1997), which on convex polyhedra hardly ever gives an overlap. In all attempts, edges that are not
/// folded come first.
pub(super) fn order(
    shape: &FoldedShape,
    surface: &Surface,
    creases: &Creases,
    levels: &[usize],
    attempt: usize,
) -> Vec<usize> {
    let cut = match attempt {
        0 => vec![false; surface.edges.len()],
        _ => steepest(shape, surface, attempt),
    };
    let edges = surface.edges.iter().enumerate();
    let joints = edges.filter_map(|(index, edge)| Some((index, edge.joint()?)));
    let key = |(index, [a, b]): (usize, [super::surface::Side; 2])| {
        let folded = creases.angles[index].abs() > 0.0;
        let whole = surface.discs[surface.parts[a.face]];
        let level = levels[a.face] + levels[b.face];
        (folded && !whole, cut[index], level, index)
    };
    let mut keys: Vec<_> = joints.map(key).collect();
    keys.sort_unstable();
    keys.into_iter().map(|key| key.3).collect()
}

/// Marks for each vertex the edge that rises most steeply in a direction drawn at random for the attempt.
fn steepest(shape: &FoldedShape, surface: &Surface, attempt: usize) -> Vec<bool> {
    let mut random = Pcg64::new(attempt as u128, 0);
    let mut number = || f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5;
    let up = Vector3::new(number(), number(), number());
    let mut best = vec![(f64::NEG_INFINITY, None); shape.vertices.len()];
    for (index, edge) in surface.edges.iter().enumerate() {
        let [a, b] = edge.ends;
        let rise = (shape.vertices[b] - shape.vertices[a]).normalize().dot(&up);
        for (from, rise) in [(a, rise), (b, -rise)] {
            if rise > best[from].0 {
                best[from] = (rise, Some(index));
            }
        }
    }
    let mut cut = vec![false; surface.edges.len()];
    for index in best.iter().filter_map(|(_, index)| *index) {
        cut[index] = true;
    }
    cut
}
