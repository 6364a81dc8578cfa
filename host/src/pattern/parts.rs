//! Cuts a panel with inner boundaries into convex faces, along lines that stay flat.
//!
//! A panel with a window, with a flap that is cut out of it, or with an outline that touches itself is no simple polygon,
//! and FOLD's `faces_vertices` has no place for one. FOLD 1.2 has the letter J for this: an edge that joins two parts of
//! one panel. So the panel becomes a few convex faces with J between them, and everything that folds, proves, draws and
//! writes faces handles them as it handles all others. The file that is written is read as it is.
//!
//! The lines are sides of a constrained Delaunay triangulation of the panel (crate `spade`, with exact predicates): it
//! uses every vertex, those on straight sides as well, and avoids narrow triangles.

use nalgebra::Vector2;
use robust::{Coord, orient2d};
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

/// A panel whose boundary is not one simple cycle. Vertices are numbered within the panel.
pub(super) struct Panel {
    pub(super) vertices: Vec<Vector2<f64>>,
    /// The edges of all boundaries, each with the panel on its left.
    pub(super) boundary: Vec<[usize; 2]>,
    /// Lines with the panel on both sides; they end up between two parts.
    pub(super) lines: Vec<[usize; 2]>,
}

/// The parts of a panel.
#[derive(Default)]
pub(super) struct Parts {
    /// Convex polygons, counter-clockwise.
    pub(super) faces: Vec<Vec<usize>>,
    /// The edges between the parts that the drawing does not have.
    pub(super) joins: Vec<[usize; 2]>,
}

/// Cuts a panel into as few convex parts as come of joining triangles one by one. Returns `None` if the coordinates are too
/// large or too small to triangulate. Cost: O(n log n).
pub(super) fn parts(panel: &Panel) -> Option<Parts> {
    let mut mesh = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    for at in &panel.vertices {
        mesh.insert(Point2::new(at.x, at.y)).ok()?;
    }
    let handle = FixedVertexHandle::from_index;
    for &[a, b] in panel.boundary.iter().chain(&panel.lines) {
        let [a, b] = [a, b].map(handle);
        if mesh.get_edge_from_neighbors(a, b).is_none() && !mesh.can_add_constraint(a, b) {
            return None;
        }
        mesh.add_constraint(a, b);
    }
    // 0 for sides of triangles, 1 for lines of the drawing, 2 for boundaries.
    let mut kinds = vec![0_u8; mesh.num_undirected_edges()];
    let mut open = Vec::new();
    for (edges, kind) in [(&panel.boundary, 2), (&panel.lines, 1)] {
        for &[a, b] in edges {
            let edge = mesh.get_edge_from_neighbors(handle(a), handle(b))?;
            kinds[edge.as_undirected().fix().index()] = kind;
            if kind == 2 {
                open.extend(edge.face().as_inner().map(|face| face.fix().index()));
            }
        }
    }
    let triangles: Vec<_> = mesh.inner_faces().collect();
    let first = triangles.first()?.fix().index();
    let mut inside = vec![false; triangles.len()];
    // The polygons that are left, as rings of directed edges with the polygon on their left.
    let mut rings = Rings {
        next: vec![None; mesh.num_directed_edges()],
        previous: vec![0; mesh.num_directed_edges()],
        from: vec![0; mesh.num_directed_edges()],
    };
    let mut sides = Vec::new();
    while let Some(face) = open.pop() {
        let index = face.checked_sub(first)?;
        if core::mem::replace(inside.get_mut(index)?, true) {
            continue;
        }
        for edge in triangles[index].adjacent_edges() {
            let here = edge.fix().index();
            rings.next[here] = Some(edge.next().fix().index());
            rings.previous[here] = edge.prev().fix().index();
            rings.from[here] = edge.from().fix().index();
            let kind = kinds[edge.as_undirected().fix().index()];
            if kind < 2 {
                open.push(edge.rev().face().as_inner()?.fix().index());
            }
            let ends = [edge.from(), edge.to()].map(|end| end.fix().index());
            if kind == 0 && ends[0] < ends[1] {
                let [a, b] = ends.map(|end| panel.vertices[end]);
                sides.push((
                    (b - a).norm_squared(),
                    ends,
                    [here, edge.rev().fix().index()],
                ));
            }
        }
    }
    // Long sides go first: the longer a line between parts is, the farther an error at it moves other faces.
    sides.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut joins = Vec::new();
    for (_, ends, edges) in sides {
        if !rings.join_if_convex(edges, &panel.vertices) {
            joins.push(ends);
        }
    }
    Some(Parts {
        faces: rings.polygons(),
        joins,
    })
}

/// Polygons as rings of directed edges.
struct Rings {
    /// The edge behind each; `None` for edges of no polygon.
    next: Vec<Option<usize>>,
    previous: Vec<usize>,
    from: Vec<usize>,
}

impl Rings {
    /// Joins the polygons on the two sides of an edge if they are convex together (S. Hertel, K. Mehlhorn, "Fast
    /// triangulation of simple polygons", 1983): both ends of the edge have to turn left then, or go straight on. `edges`
    /// are the two directions of the edge.
    fn join_if_convex(&mut self, edges: [usize; 2], places: &[Vector2<f64>]) -> bool {
        let [there, back] = edges;
        let (Some(behind), Some(ahead)) = (self.next[there], self.next[back]) else {
            return false;
        };
        let (before, last) = (self.previous[there], self.previous[back]);
        // At the start of the edge and at its end: the edge that arrives, and the one that leaves.
        let joints = [[before, ahead], [last, behind]];
        let is_convex = |[arriving, leaving]: [usize; 2]| {
            let after = self.next[leaving].map_or(0, |edge| self.from[edge]);
            let [p, q, r] = [self.from[arriving], self.from[leaving], after].map(|v| places[v]);
            let [a, b, c] = [p, q, r].map(|at| Coord { x: at.x, y: at.y });
            let turn = orient2d(a, b, c);
            turn > 0.0 || (turn >= 0.0 && (p - q).dot(&(r - q)) < 0.0)
        };
        if !joints.into_iter().all(is_convex) {
            return false;
        }
        for [arriving, leaving] in joints {
            self.next[arriving] = Some(leaving);
            self.previous[leaving] = arriving;
        }
        for edge in edges {
            self.next[edge] = None;
        }
        true
    }

    /// Returns the corners of all polygons.
    fn polygons(mut self) -> Vec<Vec<usize>> {
        let mut polygons = Vec::new();
        for start in 0..self.next.len() {
            let mut polygon = Vec::new();
            let mut edge = start;
            while let Some(next) = self.next[edge].take() {
                polygon.push(self.from[edge]);
                edge = next;
            }
            if !polygon.is_empty() {
                polygons.push(polygon);
            }
        }
        polygons
    }
}
