//! Pieces of a folded sheet, crease lines and spheres at one time after the other: computed when they are first
//! requested, and kept for that time.

use core::ops::Range;
use std::sync::Arc;

use nalgebra::Vector3;

use super::hierarchy::{Hierarchy, Sphere};
use super::narrow::crossing::Allowed;
use super::pairs::{Batch, PairSource};
use super::pieces::{Pieces, Placed};
use super::sweep::Place;
use super::sweep::chains::Link;
use super::sweep::motion::{Motion, Tick};
use crate::folding::Pose;
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
#[derive(Debug)]
pub(super) struct PlacedPieces<'a> {
    pattern: &'a CreasePattern,
    pub(super) pieces: Pieces,
    pub(super) hierarchy: Hierarchy,
    /// Tells where faces are, and which pairs of them have to be looked at.
    pub(super) source: Box<dyn PairSource + 'a>,
    /// `true` if faces are cut when they are first requested. There are no clusters then.
    cuts_on_request: bool,
    pub(super) motion: Arc<Motion>,
    pub(super) time: Tick,
    axes: TimeCached<Axis>,
    spheres: TimeCached<Sphere>,
    /// Time at which each piece was placed last.
    placed: Vec<Tick>,
    /// Positions of the corners that were placed, and normals of the pieces.
    folded: Vec<Vector3<f64>>,
    normals: Vec<Vector3<f64>>,
    /// Positions of the points of solids that were placed, and poses of their pieces.
    hulls: Vec<Vector3<f64>>,
    poses: Vec<Pose>,
    open: Vec<u32>,
}

impl<'a> PlacedPieces<'a> {
    pub(super) fn new(
        pattern: &'a CreasePattern,
        (pieces, hierarchy): (Pieces, Hierarchy),
        source: Box<dyn PairSource + 'a>,
        cuts_on_request: bool,
    ) -> Self {
        Self {
            pattern,
            pieces,
            hierarchy,
            source,
            cuts_on_request,
            motion: Arc::default(),
            time: 0,
            axes: TimeCached::default(),
            spheres: TimeCached::default(),
            placed: Vec::new(),
            folded: Vec::new(),
            normals: Vec::new(),
            hulls: Vec::new(),
            poses: Vec::new(),
            open: Vec::new(),
        }
    }

    /// Goes to the beginning of a motion. Returns the batch and the pairs of pieces that are due there.
    pub(super) fn begin(&mut self, motion: Arc<Motion>) -> Option<(Batch, Vec<[u32; 2]>)> {
        self.axes.forget();
        self.spheres.forget();
        self.placed.fill(Tick::MAX);
        self.motion = motion;
        self.time = 0;
        self.source.begin(&self.motion, &self.pieces)
    }

    /// Returns the place on the motion.
    pub(super) fn place(&self) -> Place {
        self.motion.place(self.time)
    }

    /// Returns `true` at the end of the motion.
    pub(super) fn is_at_end(&self) -> bool {
        self.time == self.motion.end()
    }

    /// Returns the faces of two pieces or clusters.
    pub(super) fn faces(&self, nodes: [u32; 2]) -> [FaceId; 2] {
        nodes.map(|node| self.hierarchy.nodes[node as usize].face)
    }

    /// Returns the pieces of two faces.
    pub(super) fn load(&mut self, faces: [FaceId; 2]) -> [Range<u32>; 2] {
        let loaded = faces.map(|face| self.pieces.load(self.pattern, face));
        self.extend();
        loaded
    }

    fn extend(&mut self) {
        if self.cuts_on_request {
            self.hierarchy.extend(&self.pieces);
        }
    }

    /// Returns the radius of the sphere computed last for a cluster.
    pub(super) fn radius(&self, node: u32) -> f64 {
        let sphere = self.spheres.last(node as usize);
        sphere.map_or(0.0, |sphere| sphere.radius)
    }

    fn pose(&mut self, face: FaceId) -> Pose {
        self.source.pose(&self.motion, self.time, face)
    }

    /// Returns the line of a crease.
    pub(super) fn axis(&mut self, crease: CreaseId) -> Axis {
        if let Some(axis) = self.axes.get(crease.index(), self.time) {
            return *axis;
        }
        let id = self.pattern.creases()[crease.index()];
        let edge = self.pattern.edge(id);
        let start = edge.ends[0];
        let pose = self.pose(edge.faces[0].unwrap_or_default());
        let axis = Axis {
            point: pose.apply(self.pattern.vertices()[start.index()]),
            direction: pose.turn(self.pattern.direction(id, start)),
        };
        self.axes.set(crease.index(), self.time, axis);
        axis
    }

    /// Returns the distance between the lines of a pair of creases.
    pub(super) fn width(&mut self, link: &Link) -> f64 {
        let [a, b] = link.creases.map(|crease| self.axis(crease));
        a.distance(&b.point)
    }

    /// Returns a sphere round a cluster.
    pub(super) fn sphere(&mut self, node: u32) -> Sphere {
        let mut open = core::mem::take(&mut self.open);
        open.push(node);
        let mut last = None;
        while let Some(&node) = open.last() {
            last = self.sphere_of(node, &mut open);
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
    fn sphere_of(&mut self, node: u32, open: &mut Vec<u32>) -> Option<Sphere> {
        if let Some(sphere) = self.spheres.get(node as usize, self.time) {
            return Some(*sphere);
        }
        let Some(children) = self.hierarchy.nodes[node as usize].children else {
            let pose = self.pose(self.pieces.list[node as usize].face);
            let (center, radius) = self.hierarchy.circles[node as usize];
            return Some(Sphere {
                center: pose.apply(center),
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

    /// Places two pieces.
    pub(super) fn put(&mut self, nodes: [u32; 2]) {
        for node in nodes {
            self.put_piece(node);
        }
    }

    fn put_piece(&mut self, piece: u32) {
        self.placed.resize(self.pieces.list.len(), Tick::MAX);
        if self.placed[piece as usize] == self.time {
            return;
        }
        self.placed[piece as usize] = self.time;
        self.normals
            .resize(self.pieces.list.len(), Vector3::zeros());
        self.folded.resize(self.pieces.flat.len(), Vector3::zeros());
        let part = self.pieces.list[piece as usize];
        let pose = self.pose(part.face);
        self.normals[piece as usize] = pose.normal();
        for corner in part.corners() {
            self.folded[corner] = pose.apply(self.pieces.flat[corner]);
        }
        if self.pieces.are_solid() {
            self.hulls
                .resize(self.pieces.hull_points(), Vector3::zeros());
            self.poses.resize(self.pieces.list.len(), Pose::identity());
            self.poses[piece as usize] = pose;
            let mut points = self.hulls[self.pieces.hull(piece)].iter_mut();
            self.pieces.place(piece, &pose, |at| {
                if let Some(point) = points.next() {
                    *point = at;
                }
            });
        }
    }

    /// Returns the placed pieces.
    pub(super) fn placed(&self) -> Placed<'_> {
        Placed {
            pieces: &self.pieces,
            folded: &self.folded,
            normals: &self.normals,
            hulls: &self.hulls,
            poses: &self.poses,
        }
    }

    /// Returns the depth to which two pieces cross, alone or together with those that share a side with them; 0 if they
    /// are in contact at most.
    pub(super) fn depth(&mut self, nodes: [u32; 2], allowed: Allowed) -> f64 {
        for piece in nodes {
            self.pieces.join(self.pattern, piece);
        }
        self.extend();
        for piece in nodes {
            for joint in 0..self.pieces.joints(piece).len() {
                let joined = self.pieces.joints(piece)[joint].piece;
                self.put_piece(joined);
            }
            self.put_piece(piece);
        }
        self.placed().depth(nodes, allowed)
    }
}
