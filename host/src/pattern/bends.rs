//! Panels that bend: patterns whose faces are cut along diagonals that turn.

use fixedbitset::FixedBitSet;

use super::{CreasePattern, DrawnEdge, EdgeId, Letter, VertexId};
use crate::util::progress::Watch;
use crate::util::range::Range;

/// Bend of a panel that a user may allow.
pub const BEND_DEG: Range = Range::from("degrees", 0.0).up_to(180.0);

impl CreasePattern {
    /// Returns the pattern with each face cut into triangles whose common edges are creases, lettered
    /// [`Letter::Bend`]; edges lettered J between two faces turn as well. Vertices and edges keep their numbers: new edges
    /// come last, in the order of the faces. Faces are cut along the diagonals of their triangulation, which avoid narrow
    /// triangles, but for those in `others`, which are cut along their [other diagonal](Self::other_halves).
    ///
    /// Returns `None` if the sheet has no face to bend, or if it is cut, as cut vertices cannot be drawn again.
    pub(crate) fn with_bends(&self, others: &FixedBitSet) -> Option<Self> {
        let mut faces = Vec::new();
        let mut diagonals = Vec::new();
        for (face, triangles) in self.triangles().iter().enumerate() {
            let other = others.contains(face).then(|| self.other_halves(face));
            if let Some(halves) = other.flatten() {
                diagonals.push([halves[0][0], halves[0][2]]);
                faces.extend(halves.map(Vec::from));
                continue;
            }
            // Each triangle but the last was cut off along the side between its first and third corner.
            let cut_off = triangles.split_last().map_or(&[][..], |(_, others)| others);
            diagonals.extend(cut_off.iter().map(|&[a, _, c]| [a, c]));
            faces.extend(triangles.iter().map(|&triangle| Vec::from(triangle)));
        }
        self.bent(faces, diagonals, |edge| {
            self.edge(edge).letter == Letter::Join
        })
    }

    /// Returns the faces with four corners that have [another diagonal](Self::other_halves), and the edge of each that is its
    /// diagonal in the pattern [with bends](Self::with_bends).
    pub(crate) fn quadrilaterals(&self) -> impl Iterator<Item = (usize, EdgeId)> {
        let mut next = self.edges().len();
        let faces = self.triangles().iter().enumerate();
        faces.filter_map(move |(face, triangles)| {
            let edge = EdgeId::new(next);
            next += triangles.len().saturating_sub(1);
            self.other_halves(face).map(|_| (face, edge))
        })
    }

    /// Returns the two triangles of a face with four corners along the diagonal that its triangulation leaves out; `None` if
    /// that diagonal does not lie in the face, or the face has fewer or more corners.
    pub(crate) fn other_halves(&self, face: usize) -> Option<[[VertexId; 3]; 2]> {
        let &[a, b, c, d] = &self.faces()[face] else {
            return None;
        };
        let first = self.triangles()[face][0];
        let [a, b, c, d] = if first[0] == a || first[2] == a {
            [b, c, d, a]
        } else {
            [a, b, c, d]
        };
        let halves = [[a, b, c], [c, d, a]];
        let lies_in_face = halves.iter().all(|&half| self.is_counter_clockwise(half));
        lies_in_face.then_some(halves)
    }

    /// Returns the pattern with these edges lettered [`Letter::Bend`], if they are lettered J and lie between two faces;
    /// `None` if the sheet is cut, or none of them is such an edge.
    pub(crate) fn bent_along(&self, bends: &[bool]) -> Option<Self> {
        let faces = self.faces().iter().map(<[VertexId]>::to_vec).collect();
        self.bent(faces, Vec::new(), |edge| {
            bends.get(edge.index()) == Some(&true) && self.edge(edge).letter == Letter::Join
        })
    }

    fn is_counter_clockwise(&self, triangle: [VertexId; 3]) -> bool {
        let [a, b, c] = triangle.map(|v| self.vertices()[v.index()]);
        (b - a).perp(&(c - a)) > 0.0
    }

    /// Draws the pattern again with these faces, with bends along these diagonals and along the edges for which `bends`
    /// is true.
    fn bent(
        &self,
        faces: Vec<Vec<VertexId>>,
        diagonals: Vec<[VertexId; 2]>,
        bends: impl Fn(EdgeId) -> bool,
    ) -> Option<Self> {
        if self.is_cut() {
            return None;
        }
        let mut drawing = self.drawing();
        for (index, (drawn, edge)) in drawing.edges.iter_mut().zip(self.edges()).enumerate() {
            if edge.inner_faces().is_some() && bends(EdgeId::new(index)) {
                drawn.letter = Letter::Bend;
            }
        }
        drawing
            .edges
            .extend(diagonals.into_iter().map(|ends| DrawnEdge {
                ends: ends.map(VertexId::index),
                letter: Letter::Bend,
                goal: None,
            }));
        let is_bent = drawing.edges.iter().any(|edge| edge.letter == Letter::Bend);
        if !is_bent {
            return None;
        }
        let faces = faces.iter();
        let corners = |face: &Vec<VertexId>| face.iter().map(|corner| corner.index()).collect();
        drawing.faces = Some(faces.map(corners).collect());
        let drawn = drawing.edges.len();
        let mut pattern = self.redrawn(drawing, Watch::default()).ok()?;
        pattern.drawn = drawn;
        Some(pattern)
    }
}
