//! Pieces of a folded sheet, crease lines and spheres at one time after the other: computed when they are first
//! requested, and kept for that time.

use foldpath_core::Membership;
use nalgebra::Vector3;

use super::chains::Link;
use super::hierarchy::{Hierarchy, Sphere};
use super::lattice::CellPairs;
use super::motion::{Motion, Tick};
use super::pieces::{Pieces, Placed};
use crate::folding::{LazyFolding, Pose, SpanningTree};
use crate::pattern::{CreaseId, CreasePattern, FaceId};
use crate::util::time_cached::TimeCached;

/// The line of a crease in space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) point: Vector3<f64>,
    pub(super) direction: Vector3<f64>,
}

impl Axis {
    /// Returns the distance of a point from the line.
    pub(super) fn distance(&self, point: &Vector3<f64>) -> f64 {
        (point - self.point).cross(&self.direction).norm()
    }
}

/// The pieces of a sheet that is folded at one time after the other.
#[derive(Clone, Debug)]
pub(super) struct PlacedPieces<'a> {
    pattern: &'a CreasePattern,
    pub(super) time: Tick,
    /// The lattice that says where faces are, if there is one.
    pub(super) cells: Option<CellPairs<'a>>,
    /// The folding along a tree, if there is no lattice.
    sheet: LazyFolding,
    frames: TimeCached<Pose>,
    axes: TimeCached<Axis>,
    spheres: TimeCached<Sphere>,
    spreads: TimeCached<f64>,
    /// Time at which each piece was placed last.
    placed: Vec<Tick>,
    /// Positions of the corners that were placed.
    pub(super) folded: Vec<Vector3<f64>>,
    normals: Vec<Vector3<f64>>,
    open: Vec<u32>,
}

impl<'a> PlacedPieces<'a> {
    pub(super) fn new(
        pattern: &'a CreasePattern,
        memberships: &[Membership],
        groups: usize,
        tree: Option<&SpanningTree>,
        cells: Option<CellPairs<'a>>,
    ) -> Self {
        let sheet = tree.map(|tree| LazyFolding::new(tree, memberships, groups));
        Self {
            pattern,
            time: 0,
            cells,
            sheet: sheet.unwrap_or_default(),
            frames: TimeCached::new(pattern.faces().len()),
            axes: TimeCached::new(pattern.creases().len()),
            spheres: TimeCached::new(0),
            spreads: TimeCached::new(0),
            placed: Vec::new(),
            folded: Vec::new(),
            normals: Vec::new(),
            open: Vec::new(),
        }
    }

    /// Invalidates everything cached, as for another motion.
    pub(super) fn forget(&mut self) {
        self.sheet.forget();
        self.frames.forget();
        self.axes.forget();
        self.spheres.forget();
        self.spreads.forget();
        self.placed.fill(Tick::MAX);
    }

    /// Returns the radius of the sphere computed last for a cluster.
    pub(super) fn radius(&self, node: u32) -> f64 {
        let sphere = self.spheres.last(node as usize);
        sphere.map_or(0.0, |sphere| sphere.radius)
    }

    fn frame(&mut self, motion: &Motion, face: FaceId) -> Pose {
        let time = self.time;
        let Some(cells) = &mut self.cells else {
            let half_angle = |group| motion.half_angle(group, time);
            return self.sheet.pose(face, time, half_angle);
        };
        if let Some(frame) = self.frames.get(face.index(), time) {
            return *frame;
        }
        let (pose, origin) = cells.pose(motion, time, face);
        let frame = Pose::about(pose.r_wf, origin, pose.p_w);
        self.frames.set(face.index(), time, frame);
        frame
    }

    /// Returns the line of a crease.
    pub(super) fn axis(&mut self, motion: &Motion, crease: CreaseId) -> Axis {
        if let Some(axis) = self.axes.get(crease.index(), self.time) {
            return *axis;
        }
        let id = self.pattern.creases()[crease.index()];
        let edge = self.pattern.edge(id);
        let start = edge.ends[0];
        let frame = self.frame(motion, edge.faces[0].unwrap_or_default());
        let axis = Axis {
            point: frame.apply(self.pattern.vertices()[start.index()]),
            direction: frame.turn(self.pattern.direction(id, start)),
        };
        self.axes.set(crease.index(), self.time, axis);
        axis
    }

    /// Returns the distance between the lines of a pair of creases.
    pub(super) fn width(&mut self, motion: &Motion, link: &Link) -> f64 {
        let [a, b] = link.creases.map(|crease| self.axis(motion, crease));
        a.distance(&b.point)
    }

    /// Returns the spread of a cluster, if it was stored at this time.
    pub(super) fn spread_of(&self, node: u32) -> Option<f64> {
        self.spreads.get(node as usize, self.time).copied()
    }

    /// Stores the spread of a cluster.
    pub(super) fn set_spread(&mut self, node: u32, spread: f64) {
        self.spreads.set(node as usize, self.time, spread);
    }

    /// Returns a sphere round a cluster.
    pub(super) fn sphere(
        &mut self,
        motion: &Motion,
        pieces: &Pieces,
        hierarchy: &Hierarchy,
        node: u32,
    ) -> Sphere {
        let mut open = core::mem::take(&mut self.open);
        open.push(node);
        let mut last = None;
        while let Some(&node) = open.last() {
            last = self.sphere_of(motion, pieces, hierarchy, node, &mut open);
            if let Some(sphere) = last {
                self.spheres.set(node as usize, self.time, sphere);
                open.pop();
            }
        }
        self.open = open;
        last.unwrap_or(Sphere {
            center: Vector3::zeros(),
            radius: f64::INFINITY,
        })
    }

    /// Returns the sphere of a cluster; `None` if the spheres of its children are missing, which are then added
    /// to `open`.
    fn sphere_of(
        &mut self,
        motion: &Motion,
        pieces: &Pieces,
        hierarchy: &Hierarchy,
        node: u32,
        open: &mut Vec<u32>,
    ) -> Option<Sphere> {
        if let Some(sphere) = self.spheres.get(node as usize, self.time) {
            return Some(*sphere);
        }
        let Some(children) = hierarchy.nodes[node as usize].children else {
            let frame = self.frame(motion, pieces.list[node as usize].face);
            let (center, radius) = hierarchy.circles[node as usize];
            return Some(Sphere {
                center: frame.apply(center),
                radius,
            });
        };
        let spheres = children.map(|child| self.spheres.get(child as usize, self.time).copied());
        let [Some(a), Some(b)] = spheres else {
            open.extend(children);
            return None;
        };
        Some(a.round(b))
    }

    /// Places a piece and, with `joined`, the pieces that share a side with it.
    pub(super) fn put(&mut self, motion: &Motion, pieces: &Pieces, piece: u32, joined: bool) {
        if joined {
            for joint in pieces.joints(piece) {
                self.put(motion, pieces, joint.piece, false);
            }
        }
        self.placed.resize(pieces.list.len(), Tick::MAX);
        if self.placed[piece as usize] == self.time {
            return;
        }
        self.placed[piece as usize] = self.time;
        self.normals.resize(pieces.list.len(), Vector3::zeros());
        self.folded.resize(pieces.flat.len(), Vector3::zeros());
        let part = pieces.list[piece as usize];
        let frame = self.frame(motion, part.face);
        self.normals[piece as usize] = frame.normal();
        for corner in part.corners() {
            self.folded[corner] = frame.apply(pieces.flat[corner]);
        }
    }

    /// Returns the placed pieces.
    pub(super) fn placed<'b>(&'b self, pieces: &'b Pieces) -> Placed<'b> {
        Placed {
            pieces,
            folded: &self.folded,
            normals: &self.normals,
        }
    }
}
