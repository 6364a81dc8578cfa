//! A spanning tree of the faces, from a central one.

use std::collections::VecDeque;
use std::sync::OnceLock;

use nalgebra::Vector2;

use super::holonomy::Holonomy;
use crate::pattern::{CreaseId, CreasePattern, EdgeId, FaceId};
use crate::ragged::Ragged;

/// One step of the tree: a face reached from its parent across an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The face reached.
    pub face: FaceId,
    /// The face it is reached from, which comes earlier.
    pub parent: FaceId,
    /// The edge between.
    pub edge: EdgeId,
    /// Its crease; `None` if the edge stays flat.
    pub crease: Option<CreaseId>,
    /// A point of the edge in the flat sheet.
    pub pivot: Vector2<f64>,
    /// Unit direction along the edge about which a positive (valley) fold angle turns the face.
    pub axis: Vector2<f64>,
}

/// Order in which the folding map visits the faces.
#[derive(Clone, Debug)]
pub struct SpanningTree {
    roots: Vec<FaceId>,
    steps: Vec<Step>,
    loops: Vec<Step>,
    faces: usize,
    /// What its loops enclose, once somebody asked.
    holonomy: OnceLock<Option<Holonomy>>,
}

impl SpanningTree {
    /// A breadth-first tree from a central face of each sheet, which halves the depth and with it
    /// the growth of errors. Cost: linear.
    #[must_use]
    pub fn from_central_face(pattern: &CreasePattern) -> Self {
        Self::from_faces(pattern, pattern.neighbours(), central)
    }

    /// A breadth-first tree from a face of each sheet that is as far as can be from the central one. Cost: linear.
    #[must_use]
    pub fn from_outer_face(pattern: &CreasePattern) -> Self {
        Self::from_faces(pattern, pattern.neighbours(), outer)
    }

    /// Trees that tear a sheet that does not close in many ways: both of these, and both with the neighbours of each face
    /// taken the other way round, so that what one reaches along a row the other does along a column. Cost: linear.
    #[must_use]
    pub fn diverse(pattern: &CreasePattern) -> [Self; 4] {
        let around = pattern.neighbours();
        let backwards = around.iter().map(|faces| faces.iter().rev().copied());
        let backwards: Ragged<_> = backwards.map(Iterator::collect::<Vec<_>>).collect();
        [
            Self::from_faces(pattern, around, central),
            Self::from_faces(pattern, &backwards, central),
            Self::from_faces(pattern, around, outer),
            Self::from_faces(pattern, &backwards, outer),
        ]
    }

    /// The longest way in the flat sheet from the first corner of a root to a corner, from step to step: nothing is ever
    /// farther from the root. Cost: linear.
    #[must_use]
    pub fn reach(&self, pattern: &CreasePattern) -> f64 {
        let corners = |face: usize| {
            let corners = pattern.faces()[face].iter();
            corners.map(|v| pattern.vertices()[v.index()])
        };
        let mut ways: Vec<_> = (0..self.faces)
            .map(|face| (corners(face).next().unwrap_or_default(), 0.0))
            .collect();
        for step in &self.steps {
            let (before, way) = ways[step.parent.index()];
            ways[step.face.index()] = (step.pivot, way + (step.pivot - before).norm());
        }
        let reaches = ways.iter().enumerate().map(|(face, (pivot, way))| {
            let far = corners(face).map(|corner| (corner - pivot).norm());
            way + far.fold(0.0, f64::max)
        });
        reaches.fold(0.0, f64::max)
    }

    /// A breadth-first tree from a face of each sheet, which is found from another.
    fn from_faces(
        pattern: &CreasePattern,
        neighbours: &Ragged<(FaceId, EdgeId)>,
        root: impl Fn(&Ragged<(FaceId, EdgeId)>, FaceId) -> FaceId,
    ) -> Self {
        let mut tree = Self {
            roots: Vec::new(),
            steps: Vec::with_capacity(pattern.faces().len()),
            loops: Vec::with_capacity(pattern.edges().len().saturating_sub(pattern.faces().len())),
            faces: pattern.faces().len(),
            holonomy: OnceLock::new(),
        };
        let mut done = vec![false; tree.faces];
        for start in 0..tree.faces {
            if !done[start] {
                let root = root(neighbours, FaceId::new(start));
                tree.grow(pattern, neighbours, root, &mut done);
            }
        }
        tree
    }

    fn grow(
        &mut self,
        pattern: &CreasePattern,
        neighbours: &Ragged<(FaceId, EdgeId)>,
        root: FaceId,
        done: &mut [bool],
    ) {
        self.roots.push(root);
        done[root.index()] = true;
        // The edge by which a face was reached.
        let mut by = vec![None; self.faces];
        let mut open = VecDeque::from([root]);
        while let Some(parent) = open.pop_front() {
            for &(face, edge_id) in &neighbours[parent.index()] {
                let new = !done[face.index()];
                // Every edge is met from both sides; once is enough.
                if !new && (by[parent.index()] == Some(edge_id) || parent > face) {
                    continue;
                }
                let edge = pattern.edge(edge_id);
                // A positive turn about the edge's direction lifts its left side.
                let start = usize::from(edge.faces[0] != Some(face));
                let step = Step {
                    face,
                    parent,
                    edge: edge_id,
                    crease: edge.crease,
                    pivot: pattern.vertices()[edge.ends[start].index()],
                    axis: pattern.direction(edge_id, edge.ends[start]),
                };
                if new {
                    done[face.index()] = true;
                    open.push_back(face);
                    self.steps.push(step);
                    by[face.index()] = Some(edge_id);
                } else {
                    self.loops.push(step);
                }
            }
        }
    }

    /// The faces that stay where they are, one a sheet.
    #[must_use]
    pub fn roots(&self) -> &[FaceId] {
        &self.roots
    }

    /// The steps; each parent is a root or the face of an earlier step.
    #[must_use]
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// The edges between two faces that no step crosses, each as the step that it would be: there the
    /// sheet either closes or is torn.
    #[must_use]
    pub fn loops(&self) -> &[Step] {
        &self.loops
    }

    /// What the loops enclose, of the pattern that this is the tree of. `None` as of [`Holonomy::new`].
    pub fn holonomy(&self, pattern: &CreasePattern) -> Option<&Holonomy> {
        let holonomy = self.holonomy.get_or_init(|| Holonomy::new(pattern, self));
        holonomy.as_ref()
    }

    /// Number of faces.
    #[must_use]
    pub fn faces(&self) -> usize {
        self.faces
    }
}

/// Corners of the sheet to which the way from the centre is to be short.
const CORNERS: usize = 4;

/// A face of the sheet of `start` that is as far as can be from the central one.
fn outer(neighbours: &Ragged<(FaceId, EdgeId)>, start: FaceId) -> FaceId {
    let (sheet, _) = distances(neighbours, central(neighbours, start));
    sheet.last().copied().unwrap_or(start)
}

/// A face from which the farthest others are near: of all, the one whose greatest distance from some
/// far corners of the sheet, each chosen as far from those before as can be, is least.
fn central(neighbours: &Ragged<(FaceId, EdgeId)>, start: FaceId) -> FaceId {
    let (sheet, from_start) = distances(neighbours, start);
    let farthest = |distance: &[u32]| {
        let far = sheet
            .iter()
            .copied()
            .max_by_key(|face| distance[face.index()]);
        far.unwrap_or(start)
    };
    let mut nearest_corner = from_start;
    let mut farthest_corner = vec![0; nearest_corner.len()];
    for corner in 0..CORNERS {
        let (_, distance) = distances(neighbours, farthest(&nearest_corner));
        for face in &sheet {
            let (face, distance) = (face.index(), distance[face.index()]);
            farthest_corner[face] = distance.max(farthest_corner[face]);
            // The face that the search began with is no corner.
            let nearest = nearest_corner[face];
            nearest_corner[face] = if corner == 0 {
                distance
            } else {
                distance.min(nearest)
            };
        }
    }
    let least = sheet
        .iter()
        .copied()
        .min_by_key(|face| farthest_corner[face.index()]);
    least.unwrap_or(start)
}

/// The faces of the sheet of `start`, and for all faces the number of steps from there.
fn distances(neighbours: &Ragged<(FaceId, EdgeId)>, start: FaceId) -> (Vec<FaceId>, Vec<u32>) {
    let mut order = vec![start];
    let mut distance = vec![u32::MAX; neighbours.len()];
    distance[start.index()] = 0;
    let mut next = 0;
    while next < order.len() {
        let from = order[next];
        next += 1;
        for &(face, _) in &neighbours[from.index()] {
            if distance[face.index()] == u32::MAX {
                distance[face.index()] = distance[from.index()] + 1;
                order.push(face);
            }
        }
    }
    (order, distance)
}
