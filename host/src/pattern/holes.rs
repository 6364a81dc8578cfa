//! Finds the holes of a sheet and the loops of faces round them.

use nalgebra::Vector2;

use super::model::Geometry;
use super::{ClosureSite, CreasePattern, EdgeId, FaceId, VertexId};
use crate::util::csr::Csr;

/// One step of the loop round a hole: across an edge that ends at the hole's rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// The edge that is crossed.
    pub edge: EdgeId,
    /// The face that the step enters.
    pub to: FaceId,
    /// The vertex of the rim at which the edge ends.
    pub at: VertexId,
}

impl CreasePattern {
    /// Returns `true` if creases go round a hole, which they have to close. Windows inside panels have none.
    pub(crate) fn has_hinged_holes(&self) -> bool {
        let mut passages = self.holes().iter().flatten();
        passages.any(|passage| self.edge(passage.edge).crease.is_some())
    }

    /// Returns the middle of a hole and the largest distance from there to a vertex of the loop round it. The distance
    /// is the unit of the loop's residual of translation.
    ///
    /// # Panics
    /// If there is no hole of that number.
    #[must_use]
    pub fn hole_frame(&self, hole: usize) -> (Vector2<f64>, f64) {
        let way = &self.holes()[hole];
        let place = |passage: &Passage| self.vertices()[passage.at.index()];
        #[allow(clippy::cast_precision_loss, reason = "a mean")]
        let middle = way.iter().map(place).sum::<Vector2<f64>>() / way.len() as f64;
        let from_middle = way.iter().map(|passage| (place(passage) - middle).norm());
        (middle, from_middle.fold(f64::MIN_POSITIVE, f64::max))
    }

    /// Returns the closure condition of a hole.
    ///
    /// # Panics
    /// If there is no hole of that number.
    #[must_use]
    pub fn hole_site(&self, hole: usize) -> ClosureSite {
        let first = self.holes()[hole].first();
        ClosureSite::Hole(first.map(|passage| passage.at).unwrap_or_default())
    }
}

impl Geometry {
    /// Finds for each hole the loop through the faces that touch its rim. A cut inside the sheet is a hole too. Cost:
    /// linear, and negligible without holes.
    pub(super) fn find_holes(&self) -> Csr<Passage> {
        let rims = self.rims();
        let mut outer = vec![(f64::NEG_INFINITY, 0); self.sheet_count()];
        let sheet = |rim: &[EdgeId]| {
            let faces = self.edges[rim[0].index()].faces;
            let face = faces.into_iter().flatten().next();
            face.map_or(0, |face| self.sheets[face.index()] as usize)
        };
        for (index, rim) in rims.iter().enumerate() {
            let best = &mut outer[sheet(rim)];
            // All rims are walked with the sheet on the left, so the outer rim of a sheet has the largest signed area.
            *best = if self.area(rim) > best.0 {
                (self.area(rim), index)
            } else {
                *best
            };
        }
        let rims = rims.iter().enumerate();
        let holes = rims.filter(|(index, rim)| outer[sheet(rim)].1 != *index);
        holes.map(|(_, rim)| self.way_along(rim)).collect()
    }

    /// Returns the cycles of edges with one face, each walked with the sheet on the left.
    fn rims(&self) -> Csr<EdgeId> {
        let mut leaving = vec![None; self.vertices.len()];
        for (index, edge) in self.edges.iter().enumerate() {
            if edge.inner_faces().is_none() && edge.faces.iter().any(Option::is_some) {
                let [from, _] = self.along_rim(EdgeId::new(index));
                leaving[from.index()] = Some(EdgeId::new(index));
            }
        }
        let mut rims = Csr::default();
        for start in 0..leaving.len() {
            let mut rim = Vec::new();
            let mut vertex = start;
            while let Some(edge) = leaving[vertex].take() {
                rim.push(edge);
                vertex = self.along_rim(edge)[1].index();
            }
            if !rim.is_empty() {
                rims.push(rim);
            }
        }
        rims
    }

    /// Returns the ends of an edge with one face, in the order that has the face on the left.
    fn along_rim(&self, edge: EdgeId) -> [VertexId; 2] {
        let edge = &self.edges[edge.index()];
        let [a, b] = edge.ends;
        if edge.faces[0].is_some() {
            [a, b]
        } else {
            [b, a]
        }
    }

    /// Returns twice the signed area that a rim encloses, positive counter-clockwise.
    fn area(&self, rim: &[EdgeId]) -> f64 {
        let origin = self.vertices[self.along_rim(rim[0])[0].index()];
        let from_origin =
            |vertex: VertexId| -> Vector2<f64> { self.vertices[vertex.index()] - origin };
        let parts = rim.iter().map(|&edge| {
            let [a, b] = self.along_rim(edge).map(from_origin);
            a.perp(&b)
        });
        parts.sum()
    }

    /// Returns the loop through all faces that touch a rim: at each vertex of the rim, clockwise through the fan of
    /// faces at that vertex.
    fn way_along(&self, rim: &[EdgeId]) -> Vec<Passage> {
        let next = rim.iter().cycle().skip(1);
        let mut way = Vec::new();
        for (arriving, leaving) in rim.iter().zip(next) {
            let at = self.along_rim(*leaving)[0];
            let star = &self.stars[at.index()];
            let Some(start) = star.iter().position(|edge| edge == arriving) else {
                continue;
            };
            let clockwise = star[..start].iter().rev().chain(star[start..].iter().rev());
            for &edge in clockwise.take_while(|edge| *edge != leaving) {
                let [left, right] = self.edges[edge.index()].faces;
                // The face to the right, looking along the edge from the rim.
                let to = if self.edges[edge.index()].ends[0] == at {
                    right
                } else {
                    left
                };
                if let Some(to) = to {
                    way.push(Passage { edge, to, at });
                }
            }
        }
        way
    }
}
