//! A spanning tree of the faces, from a central one.

use std::collections::VecDeque;

use nalgebra::Vector2;

use crate::pattern::{CreaseId, CreasePattern, FaceId};
use crate::ragged::Ragged;

/// One step of the tree: a face reached from its parent across an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The face reached.
    pub face: FaceId,
    /// The face it is reached from, which comes earlier.
    pub parent: FaceId,
    /// The crease between; `None` if the edge stays flat.
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
    faces: usize,
}

impl SpanningTree {
    /// A breadth-first tree from a central face of each sheet, which halves the depth and with it
    /// the growth of errors. Cost: linear.
    #[must_use]
    pub fn from_central_face(pattern: &CreasePattern) -> Self {
        let neighbours = pattern.neighbours();
        let mut tree = Self {
            roots: Vec::new(),
            steps: Vec::with_capacity(pattern.faces().len()),
            faces: pattern.faces().len(),
        };
        let mut parent = vec![None; tree.faces];
        let mut done = vec![false; tree.faces];
        for start in 0..tree.faces {
            if done[start] {
                continue;
            }
            // The middle of a longest shortest way, found by two searches, is central.
            let end = last_reached(&neighbours, FaceId::new(start), &mut parent);
            let other_end = last_reached(&neighbours, end, &mut parent);
            let mut way = vec![other_end];
            while let Some(before) = parent[way[way.len() - 1].index()] {
                way.push(before);
            }
            tree.grow(pattern, &neighbours, way[way.len() / 2], &mut done);
        }
        tree
    }

    fn grow(
        &mut self,
        pattern: &CreasePattern,
        neighbours: &Ragged<(FaceId, crate::pattern::EdgeId)>,
        root: FaceId,
        done: &mut [bool],
    ) {
        self.roots.push(root);
        done[root.index()] = true;
        let mut open = VecDeque::from([root]);
        while let Some(parent) = open.pop_front() {
            for &(face, edge_id) in &neighbours[parent.index()] {
                if done[face.index()] {
                    continue;
                }
                done[face.index()] = true;
                open.push_back(face);
                let edge = pattern.edge(edge_id);
                // A positive turn about the edge's direction lifts its left side.
                let start = usize::from(edge.faces[0] != Some(face));
                self.steps.push(Step {
                    face,
                    parent,
                    crease: edge.crease,
                    pivot: pattern.vertices()[edge.ends[start].index()],
                    axis: pattern.direction(edge_id, edge.ends[start]),
                });
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

    /// Number of faces.
    #[must_use]
    pub fn faces(&self) -> usize {
        self.faces
    }
}

/// A face farthest from `start`, with `parent` holding the way back.
fn last_reached(
    neighbours: &Ragged<(FaceId, crate::pattern::EdgeId)>,
    start: FaceId,
    parent: &mut [Option<FaceId>],
) -> FaceId {
    let mut order = vec![start];
    let mut seen = vec![false; parent.len()];
    seen[start.index()] = true;
    parent[start.index()] = None;
    let mut next = 0;
    while next < order.len() {
        let from = order[next];
        next += 1;
        for &(face, _) in &neighbours[from.index()] {
            if !seen[face.index()] {
                seen[face.index()] = true;
                parent[face.index()] = Some(from);
                order.push(face);
            }
        }
    }
    order[order.len() - 1]
}
