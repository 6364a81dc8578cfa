//! The crease pattern: immutable, every reference in it known to be good.

use nalgebra::{Vector2, Vector3};

use super::{CreaseId, EdgeId, FaceId, Letter, Passage, VertexId};
use crate::ragged::Ragged;

/// An edge of a crease pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Its ends.
    pub ends: [VertexId; 2],
    /// What it is for. Always [`Letter::Boundary`] where there is a face on one side only.
    pub letter: Letter,
    /// The faces to the left and to the right of the way from its first end to its second.
    pub faces: [Option<FaceId>; 2],
    /// The crease, if it is a hinge: between two faces, and neither flat nor a join.
    pub crease: Option<CreaseId>,
    /// Goal fold angle in radians, valley positive, if the drawing names one.
    pub goal: Option<f64>,
}

impl Edge {
    /// The faces on both sides, if it has two.
    #[must_use]
    pub fn inner_faces(&self) -> Option<[FaceId; 2]> {
        Some([self.faces[0]?, self.faces[1]?])
    }

    /// The end that is not `vertex`.
    #[must_use]
    pub fn other_end(&self, vertex: VertexId) -> VertexId {
        if self.ends[0] == vertex {
            self.ends[1]
        } else {
            self.ends[0]
        }
    }
}

/// A crease pattern.
#[derive(Clone, Debug)]
pub struct CreasePattern {
    pub(super) vertices: Vec<Vector2<f64>>,
    pub(super) edges: Vec<Edge>,
    /// Of each edge from its first end to its second, of length one.
    pub(super) directions: Vec<Vector2<f64>>,
    pub(super) faces: Ragged<VertexId>,
    pub(super) creases: Vec<EdgeId>,
    pub(super) stars: Ragged<EdgeId>,
    pub(super) real: Vec<bool>,
    pub(super) corners: Ragged<FaceId>,
    pub(super) neighbours: Ragged<(FaceId, EdgeId)>,
    pub(super) triangles: Ragged<[VertexId; 3]>,
    pub(super) diagonals: Vec<[VertexId; 2]>,
    pub(super) median_edge: f64,
    pub(super) drawn: usize,
    pub(super) slits: Vec<EdgeId>,
    pub(super) sheets: Vec<u32>,
    pub(super) holes: Ragged<Passage>,
    pub(super) assumptions: Vec<String>,
    pub(super) repairs: Vec<String>,
}

impl CreasePattern {
    /// Vertices of the flat sheet, in the drawing's units.
    #[must_use]
    pub fn vertices(&self) -> &[Vector2<f64>] {
        &self.vertices
    }

    /// A vertex of the flat sheet as a point in space, z = 0.
    #[must_use]
    pub fn point(&self, vertex: VertexId) -> Vector3<f64> {
        self.vertices[vertex.index()].push(0.0)
    }

    /// Edges in the order of the drawing.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Number of edges of the drawing: those behind them are the second sides of cuts.
    #[must_use]
    pub fn drawn_edges(&self) -> usize {
        self.drawn
    }

    /// Cuts of the drawing along a single edge inside the sheet, taken as free hinges: what a file says of
    /// their fold angles is no goal.
    #[must_use]
    pub fn slits(&self) -> &[EdgeId] {
        &self.slits
    }

    /// The edge of that name.
    #[must_use]
    pub fn edge(&self, edge: EdgeId) -> &Edge {
        &self.edges[edge.index()]
    }

    /// Faces as counter-clockwise cycles of vertices.
    #[must_use]
    pub fn faces(&self) -> &Ragged<VertexId> {
        &self.faces
    }

    /// The hinges: edges between two faces whose fold angle may change. Their number is the sheet's
    /// number of degrees of freedom, closure aside.
    #[must_use]
    pub fn creases(&self) -> &[EdgeId] {
        &self.creases
    }

    /// For each vertex its edges, counter-clockwise.
    #[must_use]
    pub fn stars(&self) -> &Ragged<EdgeId> {
        &self.stars
    }

    /// For each vertex the faces round it.
    #[must_use]
    pub fn corners(&self) -> &Ragged<FaceId> {
        &self.corners
    }

    /// Whether the vertex is real: inside the sheet, so that it has a closure condition.
    #[must_use]
    pub fn is_real(&self, vertex: VertexId) -> bool {
        self.real[vertex.index()]
    }

    /// The real vertices.
    pub fn real_vertices(&self) -> impl Iterator<Item = VertexId> {
        let real = self.real.iter().enumerate().filter(|(_, real)| **real);
        real.map(|(vertex, _)| VertexId::new(vertex))
    }

    /// For each face the triangles it is made of, counter-clockwise.
    #[must_use]
    pub fn triangles(&self) -> &Ragged<[VertexId; 3]> {
        &self.triangles
    }

    /// The diagonals that triangulate faces of more than three vertices.
    #[must_use]
    pub fn diagonals(&self) -> &[[VertexId; 2]] {
        &self.diagonals
    }

    /// Pairs of vertices that rigid panels hold at their distance: edges and diagonals.
    pub fn struts(&self) -> impl Iterator<Item = [VertexId; 2]> {
        let used = |edge: &&Edge| edge.faces.iter().any(Option::is_some);
        let edges = self.edges.iter().filter(used).map(|edge| edge.ends);
        edges.chain(self.diagonals.iter().copied())
    }

    /// Number of virtual edges: diagonals of the triangulation, and edges of the drawing that stay
    /// flat.
    #[must_use]
    pub fn virtual_edges(&self) -> usize {
        let flat = |e: &&Edge| e.crease.is_none() && e.inner_faces().is_some();
        self.diagonals.len() + self.edges.iter().filter(flat).count()
    }

    /// Median length of the edges: the unit of gaps and of crossing depths.
    #[must_use]
    pub fn median_edge(&self) -> f64 {
        self.median_edge
    }

    /// Length of the vector from the first end to the second in the flat sheet.
    #[must_use]
    pub fn length(&self, [a, b]: [VertexId; 2]) -> f64 {
        (self.vertices[b.index()] - self.vertices[a.index()]).norm()
    }

    /// Unit direction from `vertex` along `edge` in the flat sheet.
    #[must_use]
    pub fn direction(&self, edge: EdgeId, vertex: VertexId) -> Vector2<f64> {
        let direction = self.directions[edge.index()];
        if self.edge(edge).ends[0] == vertex {
            direction
        } else {
            -direction
        }
    }

    /// Number of sheets: parts that no chain of faces joins.
    #[must_use]
    pub fn sheets(&self) -> usize {
        self.sheets
            .iter()
            .max()
            .map_or(0, |last| *last as usize + 1)
    }

    /// For each face the number of its sheet, from 0.
    #[must_use]
    pub fn sheet_of_faces(&self) -> &[u32] {
        &self.sheets
    }

    /// For each hole the way round it, from face to face. Cuts that end inside the sheet are holes.
    #[must_use]
    pub fn holes(&self) -> &Ragged<Passage> {
        &self.holes
    }

    /// For each face the number of its sheet, the sheets in the order of their first faces.
    pub(super) fn find_sheets(&self) -> Vec<u32> {
        const NONE: u32 = u32::MAX;
        let mut sheets = vec![NONE; self.faces.len()];
        let mut open = Vec::new();
        let mut next = 0;
        for start in 0..sheets.len() {
            if sheets[start] != NONE {
                continue;
            }
            sheets[start] = next;
            open.push(start);
            while let Some(face) = open.pop() {
                for &(beyond, _) in &self.neighbours[face] {
                    if sheets[beyond.index()] == NONE {
                        sheets[beyond.index()] = next;
                        open.push(beyond.index());
                    }
                }
            }
            next += 1;
        }
        sheets
    }

    /// For each face the faces beyond its edges, and the edge between.
    #[must_use]
    pub fn neighbours(&self) -> &Ragged<(FaceId, EdgeId)> {
        &self.neighbours
    }

    /// The same, found from the edges.
    pub(super) fn find_neighbours(&self) -> Ragged<(FaceId, EdgeId)> {
        let edges = (0..).map(EdgeId).zip(&self.edges);
        let inner = edges.filter_map(|(id, edge)| Some((id, edge.inner_faces()?)));
        let pairs = inner.flat_map(|(edge, [left, right])| {
            [(left.index(), (right, edge)), (right.index(), (left, edge))]
        });
        crate::ragged::group_by_key(self.faces.len(), pairs)
    }

    /// What was assumed about the drawing where it was silent or odd, in words.
    #[must_use]
    pub fn assumptions(&self) -> &[String] {
        &self.assumptions
    }

    /// Notes an assumption made on the way here.
    pub fn assume(&mut self, assumption: String) {
        self.assumptions.push(assumption);
    }

    /// What was repaired in the drawing before it was one, in words.
    #[must_use]
    pub fn repairs(&self) -> &[String] {
        &self.repairs
    }

    /// Notes a repair made on the way here.
    pub fn repaired(&mut self, repair: String) {
        self.repairs.push(repair);
    }
}
