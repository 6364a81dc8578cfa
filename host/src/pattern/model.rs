//! The crease pattern: immutable and checked, so that every reference in it is valid.

use std::sync::{Arc, OnceLock};

use nalgebra::{Vector2, Vector3};

use super::precision::Precision;
use super::{
    CreaseId, EdgeId, EdgeNames, FaceId, Letter, LostLines, NearLines, Passage, SpanningTree, Unit,
    VertexId,
};
use crate::util::csr::Csr;
use crate::util::union_find::UnionFind;

/// An edge of a crease pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Its ends.
    pub ends: [VertexId; 2],
    /// The letter (FOLD assignment). Always [`Letter::Boundary`] if the edge has a face on one side only.
    pub letter: Letter,
    /// The faces to the left and to the right of the way from its first end to its second.
    pub faces: [Option<FaceId>; 2],
    /// The crease, if the edge is a hinge: it lies between two faces and its letter is M, V or U.
    pub crease: Option<CreaseId>,
    /// Goal fold angle in radians, valley positive, if the drawing names one.
    pub goal: Option<f64>,
}

impl Edge {
    /// Returns the faces on both sides, if there are two.
    #[must_use]
    pub fn inner_faces(&self) -> Option<[FaceId; 2]> {
        Some([self.faces[0]?, self.faces[1]?])
    }

    /// Returns the end that is not `vertex`.
    #[must_use]
    pub fn other_end(&self, vertex: VertexId) -> VertexId {
        if self.ends[0] == vertex {
            self.ends[1]
        } else {
            self.ends[0]
        }
    }
}

/// Vertices, edges and faces of a pattern, with all that is derived from them. They never change once the pattern is built.
#[derive(Debug)]
pub(super) struct Geometry {
    pub(super) vertices: Vec<Vector2<f64>>,
    pub(super) edges: Vec<Edge>,
    /// Unit direction of each edge from its first end to its second.
    pub(super) directions: Vec<Vector2<f64>>,
    pub(super) faces: Csr<VertexId>,
    pub(super) creases: Vec<EdgeId>,
    pub(super) stars: Csr<EdgeId>,
    pub(super) real: Vec<bool>,
    pub(super) corners: Csr<FaceId>,
    pub(super) neighbours: Csr<(FaceId, EdgeId)>,
    pub(super) triangles: Csr<[VertexId; 3]>,
    pub(super) diagonals: Vec<[VertexId; 2]>,
    pub(super) median_edge: f64,
    pub(super) sheets: Vec<u32>,
    pub(super) holes: Csr<Passage>,
    /// The spanning tree of the faces, once requested.
    pub(super) tree: OnceLock<SpanningTree>,
}

impl Geometry {
    /// Finds the connected components of the faces and numbers these sheets in the order of their first faces.
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

    /// Returns the number of sheets.
    pub(super) fn sheet_count(&self) -> usize {
        self.sheets
            .iter()
            .max()
            .map_or(0, |last| *last as usize + 1)
    }

    /// Finds the neighbours of each face from the edges.
    pub(super) fn find_neighbours(&self) -> Csr<(FaceId, EdgeId)> {
        let edges = (0..).map(EdgeId).zip(&self.edges);
        let inner = edges.filter_map(|(id, edge)| Some((id, edge.inner_faces()?)));
        let pairs = inner.flat_map(|(edge, [left, right])| {
            [(left.index(), (right, edge)), (right.index(), (left, edge))]
        });
        crate::util::csr::group_by_key(self.faces.len(), pairs)
    }
}

/// A crease pattern. A clone shares the vertices, edges and faces with it, and costs little.
#[derive(Clone, Debug)]
pub struct CreasePattern {
    pub(super) geometry: Arc<Geometry>,
    pub(super) drawn: usize,
    pub(super) slits: Vec<EdgeId>,
    pub(super) assumptions: Vec<String>,
    pub(super) repairs: Vec<String>,
    pub(super) lost: Option<LostLines>,
    pub(super) near: Option<NearLines>,
    pub(super) names: EdgeNames,
    pub(super) y_down: bool,
    pub(super) straightens_within: Option<f64>,
    pub(super) unit: Option<Unit>,
    /// The precision with which the pattern was written, once told or requested.
    pub(super) precision: OnceLock<Precision>,
}

impl CreasePattern {
    /// Returns the vertices of the flat sheet, in the drawing's units.
    #[must_use]
    pub fn vertices(&self) -> &[Vector2<f64>] {
        &self.geometry.vertices
    }

    /// Returns the coordinates of a vertex as the drawing has them: in drawings whose y points down, that of the pattern
    /// is turned round.
    #[must_use]
    pub fn drawn_place(&self, vertex: VertexId) -> [f64; 2] {
        let at = self.vertices()[vertex.index()];
        // Subtracting from 0 gives 0 rather than -0.
        [at.x, if self.y_down { 0.0 - at.y } else { at.y }]
    }

    /// Notes that y points down in the drawing.
    pub(crate) fn drawn_with_y_down(&mut self) {
        self.y_down = true;
    }

    /// Returns a vertex of the flat sheet as a point in space with z = 0.
    #[must_use]
    pub fn point(&self, vertex: VertexId) -> Vector3<f64> {
        self.vertices()[vertex.index()].push(0.0)
    }

    /// Returns the edges in the order of the drawing, followed by the edges that join the parts of panels with inner
    /// boundaries, and by the second sides of cuts.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        &self.geometry.edges
    }

    /// Returns the number of edges of the drawing; the edges behind them are further chords of its curves, join the parts of
    /// panels with inner boundaries, or are the second sides of cuts.
    #[must_use]
    pub fn drawn_edges(&self) -> usize {
        self.drawn
    }

    /// Returns `true` if the edge is not drawn but joins two parts of a panel with inner boundaries.
    pub(crate) fn joins_parts(&self, edge: EdgeId) -> bool {
        edge.index() >= self.drawn && self.edge(edge).letter == Letter::Join
    }

    /// Returns the cuts along a single edge inside the sheet, which are free hinges. Fold angles that a file names for
    /// them are no goal.
    #[must_use]
    pub fn slits(&self) -> &[EdgeId] {
        &self.slits
    }

    /// Returns the edge with this id.
    #[must_use]
    pub fn edge(&self, edge: EdgeId) -> &Edge {
        &self.geometry.edges[edge.index()]
    }

    /// Returns the faces as counter-clockwise cycles of vertices.
    #[must_use]
    pub fn faces(&self) -> &Csr<VertexId> {
        &self.geometry.faces
    }

    /// Returns the hinges: edges between two faces whose fold angle may change. Without closure conditions, their
    /// number is the sheet's number of degrees of freedom.
    #[must_use]
    pub fn creases(&self) -> &[EdgeId] {
        &self.geometry.creases
    }

    /// Returns the edges at each vertex, counter-clockwise.
    #[must_use]
    pub fn stars(&self) -> &Csr<EdgeId> {
        &self.geometry.stars
    }

    /// Returns the spanning tree of the faces along which the sheet is folded. It is made once, at the first call.
    pub fn tree(&self) -> &SpanningTree {
        self.geometry
            .tree
            .get_or_init(|| SpanningTree::from_central_face(self))
    }

    /// Returns the faces round each vertex.
    #[must_use]
    pub fn corners(&self) -> &Csr<FaceId> {
        &self.geometry.corners
    }

    /// Returns `true` if the vertex is real: it lies inside the sheet and therefore has a closure condition.
    #[must_use]
    pub fn is_real(&self, vertex: VertexId) -> bool {
        self.geometry.real[vertex.index()]
    }

    /// Returns the real vertices.
    pub fn real_vertices(&self) -> impl Iterator<Item = VertexId> {
        let real = self
            .geometry
            .real
            .iter()
            .enumerate()
            .filter(|(_, real)| **real);
        real.map(|(vertex, _)| VertexId::new(vertex))
    }

    /// Returns the triangles of each face, counter-clockwise.
    #[must_use]
    pub fn triangles(&self) -> &Csr<[VertexId; 3]> {
        &self.geometry.triangles
    }

    /// Returns the diagonals that triangulate the faces of more than three vertices.
    #[must_use]
    pub fn diagonals(&self) -> &[[VertexId; 2]] {
        &self.geometry.diagonals
    }

    /// Returns the pairs of vertices whose distance rigid panels keep: edges and diagonals.
    pub fn struts(&self) -> impl Iterator<Item = [VertexId; 2]> {
        let used = |edge: &&Edge| edge.faces.iter().any(Option::is_some);
        let edges = self.edges().iter().filter(used).map(|edge| edge.ends);
        edges.chain(self.diagonals().iter().copied())
    }

    /// Returns the number of virtual edges: diagonals of the triangulation, and edges of the drawing that stay flat.
    #[must_use]
    pub fn virtual_edges(&self) -> usize {
        let flat = |e: &&Edge| e.crease.is_none() && e.inner_faces().is_some();
        self.diagonals().len() + self.edges().iter().filter(flat).count()
    }

    /// Returns the median length of the edges, the unit of gaps and of crossing depths.
    #[must_use]
    pub fn median_edge(&self) -> f64 {
        self.geometry.median_edge
    }

    /// Returns the distance of two vertices in the flat sheet.
    #[must_use]
    pub fn length(&self, [a, b]: [VertexId; 2]) -> f64 {
        (self.vertices()[b.index()] - self.vertices()[a.index()]).norm()
    }

    /// Returns the unit direction from `vertex` along `edge` in the flat sheet.
    #[must_use]
    pub fn direction(&self, edge: EdgeId, vertex: VertexId) -> Vector2<f64> {
        let direction = self.geometry.directions[edge.index()];
        if self.edge(edge).ends[0] == vertex {
            direction
        } else {
            -direction
        }
    }

    /// Returns the number of sheets, the connected components of the graph of faces.
    #[must_use]
    pub fn sheets(&self) -> usize {
        self.geometry.sheet_count()
    }

    /// Returns the number of each face's sheet, counted from 0.
    #[must_use]
    pub fn sheet_of_faces(&self) -> &[u32] {
        &self.geometry.sheets
    }

    /// Returns the loop of passages round each hole, from face to face. Cuts that end inside the sheet are holes.
    #[must_use]
    pub fn holes(&self) -> &Csr<Passage> {
        &self.geometry.holes
    }

    /// Returns the panels: sets of faces that are joined by edges that stay flat, in the order of their first faces.
    #[must_use]
    pub fn panels(&self) -> Vec<Vec<FaceId>> {
        let mut sets = UnionFind::new(self.faces().len());
        for edge in self.edges().iter().filter(|edge| edge.crease.is_none()) {
            if let Some(faces) = edge.inner_faces() {
                sets.join_to_smaller(faces.map(FaceId::index));
            }
        }
        let mut panels: Vec<Vec<FaceId>> = Vec::new();
        let mut of_first = vec![None; self.faces().len()];
        for (face, first) in (0..).map(FaceId).zip(sets.representatives()) {
            let panel: usize = *of_first[first].get_or_insert_with(|| {
                panels.push(Vec::new());
                panels.len() - 1
            });
            panels[panel].push(face);
        }
        panels
    }

    /// Returns for each face the faces beyond its edges, each with the edge between.
    #[must_use]
    pub fn neighbours(&self) -> &Csr<(FaceId, EdgeId)> {
        &self.geometry.neighbours
    }

    /// Returns the assumptions made where the drawing is silent or odd, one sentence each.
    #[must_use]
    pub fn assumptions(&self) -> &[String] {
        &self.assumptions
    }

    /// Records an assumption.
    pub fn assume(&mut self, assumption: String) {
        self.assumptions.push(assumption);
    }

    /// Returns the repairs made to the drawing before this pattern was built, one sentence each.
    #[must_use]
    pub fn repairs(&self) -> &[String] {
        &self.repairs
    }

    /// Records a repair.
    pub fn repaired(&mut self, repair: String) {
        self.repairs.push(repair);
    }

    /// Returns the lines of the drawing that were left out because they end in the open, if there are any. The repairs
    /// tell them as well.
    #[must_use]
    pub fn lost_lines(&self) -> Option<&LostLines> {
        self.lost.as_ref()
    }

    /// Records lines that were left out.
    pub(crate) fn lose(&mut self, lost: LostLines) {
        self.repaired(lost.to_string());
        self.lost = Some(lost);
    }

    /// Returns the lines of the drawing that pass near each other without meeting, if there are any. The assumptions tell
    /// them as well.
    #[must_use]
    pub fn near_lines(&self) -> Option<&NearLines> {
        self.near.as_ref()
    }

    /// Records lines that pass near each other.
    pub(crate) fn leave_apart(&mut self, near: NearLines) {
        self.assume(near.to_string());
        self.near = Some(near);
    }
}
