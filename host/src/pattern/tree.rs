//! A breadth-first spanning tree of the faces, from a central one.

use std::collections::VecDeque;
use std::sync::OnceLock;

use nalgebra::Vector2;

use super::holonomy::Holonomy;
use super::{CreaseId, CreasePattern, EdgeId, FaceId};
use crate::util::csr::Csr;

/// One step of the tree: a face reached from its parent across an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The face reached.
    pub face: FaceId,
    /// The face from which it is reached, which comes earlier.
    pub parent: FaceId,
    /// The edge between the two faces.
    pub edge: EdgeId,
    /// The crease of this edge; `None` if the edge stays flat.
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
    /// Holonomy of the loops, once requested.
    holonomy: OnceLock<Option<Holonomy>>,
}

/// Returns for each face the first face of its body, given the faces that are joined rigidly, each with the face before it
/// along the tree, in the order of the tree.
pub(crate) fn bodies(faces: usize, joined: impl IntoIterator<Item = [u32; 2]>) -> Vec<FaceId> {
    let mut bodies: Vec<FaceId> = (0..faces).map(FaceId::new).collect();
    for [before, face] in joined {
        bodies[face as usize] = bodies[before as usize];
    }
    bodies
}

impl SpanningTree {
    /// Makes a breadth-first tree from a central face of each sheet, which halves the depth and, with the
    /// depth, the growth of errors. Cost: linear.
    pub(super) fn from_central_face(pattern: &CreasePattern) -> Self {
        Self::from_faces(pattern, pattern.neighbours(), central)
    }

    /// Returns a breadth-first tree from a face of each sheet that is as far as possible from the central one.
    /// Cost: linear.
    #[must_use]
    pub fn from_outer_face(pattern: &CreasePattern) -> Self {
        Self::from_faces(pattern, pattern.neighbours(), outer)
    }

    /// Returns trees that tear a sheet that does not close in different ways: from the central and from the
    /// outer face, each with the neighbours of every face in both orders. Faces that one order reaches along a
    /// row the other reaches along a column. Cost: linear.
    #[must_use]
    pub fn diverse(pattern: &CreasePattern) -> [Self; 4] {
        let around = pattern.neighbours();
        let backwards = around.iter().map(|faces| faces.iter().rev().copied());
        let backwards: Csr<_> = backwards.map(Iterator::collect::<Vec<_>>).collect();
        [
            Self::from_faces(pattern, around, central),
            Self::from_faces(pattern, &backwards, central),
            Self::from_faces(pattern, around, outer),
            Self::from_faces(pattern, &backwards, outer),
        ]
    }

    /// Returns the longest way in the flat sheet, from step to step, from the first corner of a root to a
    /// corner. No point of the folded sheet is ever farther from the first corner of the root. Cost: linear.
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

    /// Returns a breadth-first tree from a face of each sheet, which `root` finds from any face of the sheet.
    fn from_faces(
        pattern: &CreasePattern,
        neighbours: &Csr<(FaceId, EdgeId)>,
        root: impl Fn(&Csr<(FaceId, EdgeId)>, FaceId) -> FaceId,
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
        neighbours: &Csr<(FaceId, EdgeId)>,
        root: FaceId,
        done: &mut [bool],
    ) {
        self.roots.push(root);
        done[root.index()] = true;
        // The edge by which each face was reached.
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

    /// Returns the faces that stay where they are, one a sheet.
    #[must_use]
    pub fn roots(&self) -> &[FaceId] {
        &self.roots
    }

    /// Returns the steps; each parent is a root or the face of an earlier step.
    #[must_use]
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Returns the edges between two faces that no step crosses, each as the step that it would be: at these
    /// edges the sheet either closes or is torn.
    #[must_use]
    pub fn loops(&self) -> &[Step] {
        &self.loops
    }

    /// Returns the holonomy of the loops, for the pattern of which this is the tree. `None` as for [`Holonomy::new`].
    pub fn holonomy(&self, pattern: &CreasePattern) -> Option<&Holonomy> {
        let holonomy = self.holonomy.get_or_init(|| Holonomy::new(pattern, self));
        holonomy.as_ref()
    }

    /// Returns the number of faces.
    #[must_use]
    pub fn faces(&self) -> usize {
        self.faces
    }
}

/// Number of far corners of the sheet from which the central face is to be near.
const FAR_CORNERS: usize = 4;

/// Returns a face of the sheet of `start` that is as far as possible from the central one.
fn outer(neighbours: &Csr<(FaceId, EdgeId)>, start: FaceId) -> FaceId {
    let (sheet, _) = distances(neighbours, central(neighbours, start));
    sheet.last().copied().unwrap_or(start)
}

/// Returns a central face: the one whose greatest distance, in steps, from some far corners of the sheet is
/// least. Each of these corners is chosen as far as possible from those before.
fn central(neighbours: &Csr<(FaceId, EdgeId)>, start: FaceId) -> FaceId {
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
    for corner in 0..FAR_CORNERS {
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

/// Returns the faces of the sheet of `start` in breadth-first order, and the number of steps from `start` to each face.
fn distances(neighbours: &Csr<(FaceId, EdgeId)>, start: FaceId) -> (Vec<FaceId>, Vec<u32>) {
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
