//! How much larger than the closure residuals of its vertices the errors of a folded sheet can be.

use std::collections::VecDeque;

use super::tree::SpanningTree;
use crate::pattern::{CreasePattern, VertexId};
use crate::ragged::group_by_key;

/// Bounds on gap, deformation and twist of the whole sheet, each per closure residual: none is larger
/// than its factor times the largest residual |r(v)| of a real vertex. Answers an open question of
/// [XiLien2015](crate#references): what essential bound a bound on the whole sheet asks for.
///
/// Why. Faces that a step of the spanning tree joins fit. Those at an edge that no step crosses are
/// joined the long way round, a loop of faces; what they miss each other by is the composition of the
/// misclosures of the real vertices inside the loop, each a turn about an axis through its vertex.
/// A turn with residual r moves a point at distance d from its axis by at most |r| d, and isometries
/// composed move a point by no more than the sum. The edges that no step crosses form a forest: every
/// tree of it hangs on one vertex of the border, and the vertices inside the loop of an edge are those
/// below it. In the folded sheet a vertex u below p is no farther from p than the flat way along the
/// forest, `way(u, p)`, is long, which stays inside the loop: so this holds for sheets of any outline.
///
/// Round a vertex p one can go from any of its faces to any other without crossing the edge on which p
/// itself hangs. So the positions that faces give p differ by at most max|r| T(p), with
/// T(p) = Σ `way(u, p)` over all u below p. That gives the gap, max T over the median edge; the
/// deformation, as both ends of an edge may be off, max (T(a) + T(b)) / |ab|; and the twist, the
/// number of vertices below an edge.
///
/// It holds for every configuration. How much of it was filled, at most, in `host/tests/amplification.rs`:
///
/// | sheet | gap, factor: filled | deformation, factor: filled | twist, factor: filled |
/// |---|---|---|---|
/// | Miura 3x3 | 1: 1.00 | 2: 0.43 | 1: 1.00 |
/// | Miura 11x11 | 15: 0.44 | 30: 0.14 | 5: 0.69 |
/// | Miura 24x24 | 78: 0.34 | 156: 0.13 | 12: 0.61 |
/// | waterbomb 12x22 | 66: 0.21 | 121: 0.08 | 11: 0.26 |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Amplification {
    /// Of the gap.
    pub gap: f64,
    /// Of the deformation.
    pub deformation: f64,
    /// Of the twist.
    pub twist: f64,
}

impl Amplification {
    /// The factors of a sheet folded along this tree. `None` where a loop encloses a hole: what it
    /// misses by is not a matter of vertices alone. Cost: linear.
    #[must_use]
    pub fn new(pattern: &CreasePattern, tree: &SpanningTree) -> Option<Self> {
        let vertices = pattern.vertices();
        let edges = tree.loops().iter().map(|step| pattern.edge(step.edge).ends);
        let pairs = edges.flat_map(|[a, b]| [(a.index(), b), (b.index(), a)]);
        let uncrossed = group_by_key(vertices.len(), pairs);

        // The vertex that each hangs on; those of the border hang on none.
        let mut above: Vec<Option<VertexId>> = vec![None; vertices.len()];
        let mut order = Vec::with_capacity(vertices.len());
        let border = (0..vertices.len()).map(VertexId::new);
        let mut open: VecDeque<_> = border.filter(|v| !pattern.is_real(*v)).collect();
        while let Some(vertex) = open.pop_front() {
            for &next in &uncrossed[vertex.index()] {
                if above[vertex.index()] == Some(next) {
                    continue;
                }
                if !pattern.is_real(next) || above[next.index()].is_some() {
                    return None;
                }
                above[next.index()] = Some(vertex);
                order.push(next);
                open.push_back(next);
            }
        }
        if order.len() != tree.loops().len() {
            return None;
        }

        // From the ends of the forest to the border.
        let mut below = vec![0.0; vertices.len()];
        let mut ways = vec![0.0; vertices.len()];
        let mut twist = 0.0_f64;
        for &vertex in order.iter().rev() {
            let turns = pattern.stars()[vertex.index()]
                .iter()
                .any(|&edge| pattern.edge(edge).crease.is_some());
            let count = below[vertex.index()] + if turns { 1.0 } else { 0.0 };
            twist = twist.max(count);
            if let Some(p) = above[vertex.index()] {
                below[p.index()] += count;
                ways[p.index()] += ways[vertex.index()] + count * pattern.length([vertex, p]);
            }
        }
        let strain = |ends: [VertexId; 2]| {
            let [a, b] = ends.map(|end| ways[end.index()]);
            (a + b) / pattern.length(ends)
        };
        Some(Self {
            gap: ways.iter().copied().fold(0.0, f64::max) / pattern.median_edge(),
            deformation: pattern.struts().map(strain).fold(0.0, f64::max),
            twist,
        })
    }

    /// The largest of the factors; at least 1, as a residual is an error in itself.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.gap.max(self.deformation).max(self.twist).max(1.0)
    }
}
