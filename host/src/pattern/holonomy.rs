//! Bounds the errors of the whole folded sheet by the closure residuals of its vertices and holes.

use std::collections::VecDeque;

use super::{CreasePattern, EdgeId, Rigidity, SpanningTree, VertexId};
use crate::util::csr::{Csr, group_by_key};

/// The vertices and holes enclosed by each loop of faces that the spanning tree closes.
///
/// Faces joined by a step of the spanning tree fit. Faces at an edge that no step crosses are joined the long way
/// round, by a loop of faces. Their mismatch is the composition of the misclosures of the real vertices and holes
/// inside the loop. The misclosure of a vertex with residual r is a rotation about an axis through the vertex, and
/// moves a point at distance d from the vertex by at most |r| d. The misclosure of a hole moves a point at distance d
/// from the hole's middle by at most |r| d + |t|, with t the residual of translation times the size of the loop. A
/// composition of isometries moves a point by no more than the sum of their displacements.
///
/// If every hole is contracted to one of its points, the edges that no step crosses form a forest: each tree
/// hangs on one vertex of the outer border, and the loop of an edge encloses the vertices and holes below that
/// edge. In the folded sheet, a vertex u below p is no farther from p than the length `way(u, p)` of the flat
/// way along the forest. This way stays inside the loop, so the bound holds for sheets of any outline. A way
/// that meets a hole goes on along the rim, from one vertex of the rim to the next as they lie in the face
/// between. This takes half the way round the hole at most, as the other vertices can be left to the other
/// side. The middle of the hole is at most half the way round and the size of the loop away.
///
/// Round a vertex p one can go from any of its faces to any other without crossing the edge on which p itself
/// hangs. So the positions that faces give p differ by at most T(p) = Σ |r(u)| `way(u, p)` over all u below p,
/// and likewise for holes. A vertex by which a hole hangs has everything below it that the hole has. This gives
/// three bounds: on the gap, max T over the median edge; on the deformation, max (T(a) + T(b)) / |ab|, as both
/// ends of an edge may be displaced; and on the twist, Σ |r| over everything below an edge.
#[derive(Clone, Debug)]
pub struct Holonomy {
    /// Edges of the forest, each before those below it.
    hanging: Vec<Hanging>,
    holes: Vec<Hole>,
    rims: Csr<VertexId>,
    vertices: usize,
    median_edge: f64,
    struts: Vec<([VertexId; 2], f64)>,
}

/// Bound on the tear at an edge that no step of the tree crosses. The tear is an isometry: it takes the position that
/// one of the two faces would have in a sheet that closes to the position that the face has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tear {
    /// The edge.
    pub edge: EdgeId,
    /// Bound on the angle of its rotation, radians.
    pub turn: f64,
    /// Bound on the distance by which it moves the ends of the edge, units of the sheet.
    pub shift: f64,
}

/// An edge of the forest.
#[derive(Clone, Copy, Debug)]
struct Hanging {
    edge: EdgeId,
    vertex: VertexId,
    /// The hole on whose rim the vertex is.
    hole: Option<usize>,
    on: VertexId,
    length: f64,
}

#[derive(Clone, Copy, Debug)]
struct Hole {
    /// Half the length of the way round the hole.
    half_way: f64,
    /// Unit of the hole's residual of translation: the largest distance from its middle to its rim.
    size: f64,
}

/// Returns the vertices on the rim of each hole, in order.
fn rims(pattern: &CreasePattern) -> Csr<VertexId> {
    let rims = pattern.holes().iter().map(|way| {
        let mut rim: Vec<_> = way.iter().map(|passage| passage.at).collect();
        rim.dedup();
        rim
    });
    rims.collect()
}

/// Measures the holes with these rims.
fn holes(pattern: &CreasePattern, rims: &Csr<VertexId>) -> Vec<Hole> {
    let holes = rims.iter().enumerate().map(|(hole, rim)| {
        let next = rim.iter().cycle().skip(1);
        let steps = rim.iter().zip(next).map(|(&a, &b)| pattern.length([a, b]));
        Hole {
            half_way: steps.sum::<f64>() / 2.0,
            size: pattern.hole_frame(hole).1,
        }
    });
    holes.collect()
}

impl Holonomy {
    /// Creates the forest of a sheet folded along this tree. Returns `None` if the edges that no step crosses
    /// form no such forest; no pattern is known for which this happens. Cost: linear.
    #[must_use]
    pub fn new(pattern: &CreasePattern, tree: &SpanningTree) -> Option<Self> {
        let vertices = pattern.vertices().len();
        let edges = tree.loops().iter().map(|step| step.edge);
        let pairs: Vec<_> = edges
            .flat_map(|edge| {
                let [a, b] = pattern.edge(edge).ends;
                [(a.index(), (b, edge)), (b.index(), (a, edge))]
            })
            .collect();
        let uncrossed = group_by_key(vertices, &pairs);
        let rims = rims(pattern);
        let mut hole_at = vec![None; vertices];
        for (hole, rim) in rims.iter().enumerate() {
            for vertex in rim {
                hole_at[vertex.index()] = Some(hole);
            }
        }

        let outer = |v: &VertexId| !pattern.is_real(*v) && hole_at[v.index()].is_none();
        let mut open: VecDeque<_> = (0..vertices).map(VertexId::new).filter(outer).collect();
        let mut above: Vec<Option<VertexId>> = vec![None; vertices];
        let mut hangs = vec![false; rims.len()];
        let mut hanging: Vec<Hanging> = Vec::with_capacity(tree.loops().len());
        while let Some(on) = open.pop_front() {
            for &(vertex, edge) in &uncrossed[on.index()] {
                if above[on.index()] == Some(vertex) {
                    continue;
                }
                let hole = hole_at[vertex.index()];
                let met = hole.map_or(above[vertex.index()].is_some(), |hole| hangs[hole]);
                if met || outer(&vertex) {
                    return None;
                }
                above[vertex.index()] = Some(on);
                let length = pattern.length([vertex, on]);
                hanging.push(Hanging {
                    edge,
                    vertex,
                    hole,
                    on,
                    length,
                });
                if let Some(hole) = hole {
                    hangs[hole] = true;
                    open.extend(&rims[hole]);
                } else {
                    open.push_back(vertex);
                }
            }
        }
        (hanging.len() == tree.loops().len()).then(|| Self {
            hanging,
            holes: holes(pattern, &rims),
            rims,
            vertices,
            median_edge: pattern.median_edge(),
            struts: pattern
                .struts()
                .map(|ends| (ends, pattern.length(ends)))
                .collect(),
        })
    }

    /// Bounds gap, deformation and twist by residuals: |r| of each vertex, 0 if it has none, and the residuals
    /// of rotation and of translation of each hole. Cost: linear.
    ///
    /// # Panics
    /// If a vertex or a hole has no entry.
    #[must_use]
    pub fn rigidity(&self, vertices: &[f64], holes: &[[f64; 2]]) -> Rigidity {
        let mut twist = 0.0_f64;
        let moved = self.sum_up(vertices, holes, |tear| twist = twist.max(tear.turn));
        let strain = |(ends, length): &([VertexId; 2], f64)| {
            let [a, b] = ends.map(|end| moved[end.index()]);
            (a + b) / length
        };
        Rigidity {
            deformation: self.struts.iter().map(strain).fold(0.0, f64::max),
            gap: moved.iter().copied().fold(0.0, f64::max) / self.median_edge,
            twist,
        }
    }

    /// Bounds the tear at each edge that no step of the tree crosses, on a sheet whose vertices and holes all have
    /// residuals of at most `closure`. Cost: linear.
    #[must_use]
    pub fn tears(&self, closure: f64) -> Vec<Tear> {
        let (vertices, holes) = (
            vec![closure; self.vertices],
            vec![[closure; 2]; self.holes.len()],
        );
        let mut tears = Vec::with_capacity(self.hanging.len());
        self.sum_up(&vertices, &holes, |tear| tears.push(tear));
        tears
    }

    /// Calls `tear` for each edge of the forest, those below an edge before it. Returns T for each vertex.
    fn sum_up(&self, vertices: &[f64], holes: &[[f64; 2]], mut tear: impl FnMut(Tear)) -> Vec<f64> {
        // Sums over everything below a vertex: of |r| (`below`), and T (`moved`).
        let mut below = vec![0.0; self.vertices];
        let mut moved = vec![0.0; self.vertices];
        for &Hanging {
            edge,
            vertex,
            hole,
            on,
            length,
        } in self.hanging.iter().rev()
        {
            let turned = if let Some(hole) = hole {
                let Hole { half_way, size } = self.holes[hole];
                let [turn, shift] = holes[hole];
                let rim = || self.rims[hole].iter();
                let others: f64 = rim().map(|v| below[v.index()]).sum();
                let ways: f64 = rim().map(|v| moved[v.index()]).sum();
                moved[vertex.index()] =
                    ways + others * half_way + turn * (half_way + size) + shift * size;
                others + turn
            } else {
                below[vertex.index()] + vertices[vertex.index()]
            };
            let shift = moved[vertex.index()] + turned * length;
            tear(Tear {
                edge,
                turn: turned,
                shift,
            });
            below[on.index()] += turned;
            moved[on.index()] += shift;
        }
        moved
    }
}
