//! The sheet folded lazily: poses, crease lines and spheres at one time are computed when they are first requested, and
//! cached for that time.

use foldpath_core::{HalfAngle, Membership, Rotation};
use nalgebra::Vector3;

use super::chains::Link;
use super::hierarchy::{Hierarchy, Sphere};
use super::lattice::CellPairs;
use super::motion::{Motion, Tick};
use super::pieces::{Pieces, Placed};
use crate::folding::{SpanningTree, Step};
use crate::lattice::Pose;
use crate::pattern::{CreaseId, CreasePattern, FaceId};

/// A cache of items that are valid at one time only. It takes memory only for items that were requested.
#[derive(Clone, Debug)]
struct TimeCached<T> {
    /// For each index the position of its item plus one; 0 if there is none.
    numbers: Vec<u32>,
    items: Vec<(Tick, T)>,
}

impl<T> TimeCached<T> {
    fn new(count: usize) -> Self {
        Self {
            numbers: vec![0; count],
            items: Vec::new(),
        }
    }

    fn number(&self, index: usize) -> Option<usize> {
        let number = self.numbers.get(index)?;
        (*number as usize).checked_sub(1)
    }

    /// Returns the item stored last, of whatever time.
    fn last(&self, index: usize) -> Option<&T> {
        self.number(index).map(|number| &self.items[number].1)
    }

    fn get(&self, index: usize, time: Tick) -> Option<&T> {
        let (at, item) = &self.items[self.number(index)?];
        (*at == time).then_some(item)
    }

    fn forget(&mut self) {
        for (time, _) in &mut self.items {
            *time = Tick::MAX;
        }
    }

    fn set(&mut self, index: usize, time: Tick, item: T) {
        if index >= self.numbers.len() {
            self.numbers.resize(index + 1, 0);
        }
        if let Some(number) = self.number(index) {
            self.items[number] = (time, item);
        } else {
            self.items.push((time, item));
            self.numbers[index] = FaceId::new(self.items.len()).0;
        }
    }
}

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

/// A sheet that is folded at one time after the other.
#[derive(Clone, Debug)]
pub(super) struct LazyFolding<'a> {
    pattern: &'a CreasePattern,
    memberships: &'a [Membership],
    pub(super) time: Tick,
    /// The lattice that says where faces are, if there is one.
    pub(super) cells: Option<CellPairs<'a>>,
    /// For each face but the roots the step of the spanning tree that reaches it; empty if there is a lattice.
    steps: Vec<Option<Step>>,
    half_angles: TimeCached<HalfAngle<f64>>,
    frames: TimeCached<Pose>,
    axes: TimeCached<Axis>,
    spheres: TimeCached<Sphere>,
    spreads: TimeCached<f64>,
    /// Time at which each piece was placed last.
    placed: Vec<Tick>,
    /// Positions of the corners that were placed.
    pub(super) folded: Vec<Vector3<f64>>,
    normals: Vec<Vector3<f64>>,
    way: Vec<Step>,
    open: Vec<u32>,
}

impl<'a> LazyFolding<'a> {
    pub(super) fn new(
        pattern: &'a CreasePattern,
        memberships: &'a [Membership],
        groups: usize,
        tree: Option<&SpanningTree>,
        cells: Option<CellPairs<'a>>,
    ) -> Self {
        let faces = pattern.faces().len();
        let mut steps = vec![None; if tree.is_some() { faces } else { 0 }];
        for step in tree.into_iter().flat_map(SpanningTree::steps) {
            steps[step.face.index()] = Some(*step);
        }
        Self {
            pattern,
            memberships,
            time: 0,
            cells,
            half_angles: TimeCached::new(groups),
            frames: TimeCached::new(faces),
            axes: TimeCached::new(pattern.creases().len()),
            spheres: TimeCached::new(0),
            spreads: TimeCached::new(0),
            placed: Vec::new(),
            folded: Vec::new(),
            normals: Vec::new(),
            way: Vec::new(),
            open: Vec::new(),
            steps,
        }
    }

    /// Invalidates everything cached, as for another motion.
    pub(super) fn forget(&mut self) {
        self.half_angles.forget();
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

    fn half_angle(&mut self, motion: &Motion, member: Membership) -> HalfAngle<f64> {
        let (group, time) = (member.group.index(), self.time);
        let half = self.half_angles.get(group, time).copied();
        let half = half.unwrap_or_else(|| {
            let half = motion.half_angle(group, time);
            self.half_angles.set(group, time, half);
            half
        });
        half.signed(member.negative)
    }

    fn frame(&mut self, motion: &Motion, face: FaceId) -> Pose {
        if let Some(frame) = self.frames.get(face.index(), self.time) {
            return *frame;
        }
        let mut way = core::mem::take(&mut self.way);
        let mut at = face;
        let mut frame = loop {
            if let Some(frame) = self.frames.get(at.index(), self.time) {
                break *frame;
            }
            if let Some(cells) = &mut self.cells {
                let (pose, origin) = cells.pose(motion, self.time, at);
                let frame = Pose::about(pose.r_wf, origin, pose.p_w);
                self.frames.set(at.index(), self.time, frame);
                break frame;
            }
            let Some(step) = self.steps[at.index()] else {
                self.frames.set(at.index(), self.time, Pose::identity());
                break Pose::identity();
            };
            way.push(step);
            at = step.parent;
        };
        while let Some(step) = way.pop() {
            let member = step.crease.and_then(|c| self.memberships.get(c.index()));
            if let Some(&member) = member {
                let half = self.half_angle(motion, member);
                let turn = Rotation::about_crease(half, step.axis.into());
                frame = Pose::about(frame.r_wf * turn, step.pivot, frame.apply(step.pivot));
            }
            self.frames.set(step.face.index(), self.time, frame);
        }
        self.way = way;
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
