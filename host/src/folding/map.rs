//! The folding map at one configuration, by rotations along a spanning tree of the faces, and the rigidity of
//! the sheet under it.

use foldpath_core::{HalfAngle, Membership, Rotation, closure};
use nalgebra::Vector3;

use super::hinge::Product;
use super::pose::Pose;
use crate::pattern::{CreaseId, CreasePattern, FaceId, Rigidity, SpanningTree, Step, VertexId};
use crate::util::nan_max::{larger, largest};
use crate::util::range::Range;

/// Bound on deformation, gap and closure residual that a user may choose, a fraction of lengths.
pub const BOUND: Range = Range::above("a fraction", 0.0).up_to(1.0);
/// The bound of those who choose none.
pub const DEFAULT_BOUND: f64 = 0.01;

/// The folding map at one configuration: a pose for each face. Reused from one configuration to the next, so
/// that a path allocates once.
#[derive(Clone, Debug)]
pub struct FoldingMap {
    /// Half angle of each group, or of each crease.
    half_angles: Vec<HalfAngle<f64>>,
    /// Group and sign of each crease; empty if each crease is its own group.
    memberships: Vec<Membership>,
    poses: Vec<Pose>,
    vertices: Vec<Vector3<f64>>,
    /// Largest distance between two positions that faces give the same vertex, units of the sheet.
    gap: f64,
    struts: Vec<Strut>,
    /// Scratch: positions that faces give one vertex.
    positions: Vec<Vector3<f64>>,
}

impl FoldingMap {
    /// Folds the sheet by the fold angles of its creases (radians). Cost: O(faces).
    #[must_use]
    pub fn new(pattern: &CreasePattern, tree: &SpanningTree, fold_angles: &[f64]) -> Self {
        let mut map = Self::flat(pattern);
        map.fold(pattern, tree, fold_angles);
        map
    }

    /// Returns the map of the sheet as it is drawn.
    #[must_use]
    pub fn flat(pattern: &CreasePattern) -> Self {
        let struts = pattern.struts().map(|ends| Strut::new(pattern, ends));
        Self {
            half_angles: Vec::new(),
            memberships: Vec::new(),
            poses: vec![Pose::identity(); pattern.faces().len()],
            vertices: pattern.vertices().iter().map(|v| v.push(0.0)).collect(),
            gap: 0.0,
            struts: struts.collect(),
            positions: Vec::new(),
        }
    }

    /// Replaces this map by that at another configuration of the same sheet.
    pub fn fold(&mut self, pattern: &CreasePattern, tree: &SpanningTree, fold_angles: &[f64]) {
        self.turn(fold_angles);
        self.memberships.clear();
        self.place(pattern, tree);
    }

    /// Replaces this map as [`fold`](Self::fold) does, by the angles (radians) of crease groups: each crease
    /// has the angle of its group, up to its sign. Takes one sine and cosine a group.
    pub fn fold_groups(
        &mut self,
        pattern: &CreasePattern,
        tree: &SpanningTree,
        memberships: &[Membership],
        angles: &[f64],
    ) {
        self.turn(angles);
        self.memberships.clear();
        self.memberships.extend_from_slice(memberships);
        self.place(pattern, tree);
    }

    /// Stores the angles (radians) of groups or creases.
    fn turn(&mut self, angles: &[f64]) {
        self.half_angles.resize(angles.len(), HalfAngle::default());
        closure::half_angles(angles, &mut self.half_angles);
    }

    /// Returns the half angle of a crease; flat if no angle was given.
    #[inline]
    fn half_angle(&self, crease: CreaseId) -> HalfAngle<f64> {
        let half = |index: usize| self.half_angles.get(index).copied().unwrap_or_default();
        match self.memberships.get(crease.index()) {
            Some(of) => half(of.group.index()).signed(of.negative),
            None => half(crease.index()),
        }
    }

    /// Places faces and vertices by the half angles.
    fn place(&mut self, pattern: &CreasePattern, tree: &SpanningTree) {
        if self
            .half_angles
            .iter()
            .all(|half| *half == HalfAngle::default())
        {
            self.unfold(pattern);
            return;
        }
        for &root in tree.roots() {
            self.poses[root.index()] = Pose::identity();
        }
        for step in tree.steps() {
            let before = &self.poses[step.parent.index()];
            let pose = match step.crease {
                Some(crease) => {
                    let half = self.half_angle(crease);
                    Product::Measured.cross(before, step.pivot, step.axis, half)
                }
                None => *before,
            };
            self.poses[step.face.index()] = pose;
        }
        self.place_vertices(pattern);
    }

    /// Places faces and vertices as they are drawn.
    fn unfold(&mut self, pattern: &CreasePattern) {
        self.poses.fill(Pose::identity());
        for (folded, flat) in self.vertices.iter_mut().zip(pattern.vertices()) {
            *folded = flat.push(0.0);
        }
        self.gap = 0.0;
    }

    /// Places each vertex by the first of its faces, and measures how far apart its faces place it.
    fn place_vertices(&mut self, pattern: &CreasePattern) {
        let mut positions = core::mem::take(&mut self.positions);
        // Square of the widest distance so far.
        let mut widest = 0.0;
        let vertices = self.vertices.iter_mut().zip(pattern.vertices());
        for ((folded, &flat), faces) in vertices.zip(pattern.corners().iter()) {
            let at = |face: &FaceId| self.poses[face.index()].apply(flat);
            let Some((first, others)) = faces.split_first() else {
                *folded = flat.push(0.0);
                continue;
            };
            let place = at(first);
            *folded = place;
            let mut reach = 0.0;
            for face in others {
                reach = largest([reach, (at(face) - place).norm_squared()]);
            }
            // No two positions are farther apart than twice the reach from the first.
            if 4.0 * reach <= widest {
                continue;
            }
            widest = largest([widest, reach]);
            positions.clear();
            positions.extend(others.iter().map(at));
            for (index, a) in positions.iter().enumerate() {
                for b in &positions[..index] {
                    widest = largest([widest, (a - b).norm_squared()]);
                }
            }
        }
        self.gap = widest.sqrt();
        self.positions = positions;
    }

    /// Returns the rotation of the face that a step reaches, from that of its parent and the step's fold angle. It is not
    /// renormalised.
    fn beyond(&self, step: &Step) -> Rotation<f64> {
        let r_wp = self.poses[step.parent.index()].r_wf;
        match step.crease {
            Some(crease) => r_wp.across_crease(self.half_angle(crease), step.axis.into()),
            None => r_wp,
        }
    }

    /// Returns the rigid motion of each face.
    #[must_use]
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// Returns the folded position of each vertex, as one of its faces places it.
    #[must_use]
    pub fn vertices(&self) -> &[Vector3<f64>] {
        &self.vertices
    }

    /// Returns the folded position of a vertex.
    #[must_use]
    pub fn vertex(&self, vertex: VertexId) -> Vector3<f64> {
        self.vertices[vertex.index()]
    }

    /// Returns the rigidity of the sheet under this map, made with the same tree. Cost: O(edges + corners).
    #[must_use]
    pub fn rigidity(&self, pattern: &CreasePattern, tree: &SpanningTree) -> Rigidity {
        let twists = tree.loops().iter().map(|step| self.twist(step));
        Rigidity {
            deformation: strain(self.struts.iter().copied(), &self.vertices),
            gap: self.gap / pattern.median_edge(),
            twist: largest(twists),
        }
    }

    /// Returns the largest distance by which the fold angles of creases off the tree, of which the positions of faces tell
    /// nothing, part two faces, in median edges: the twist times how far the smaller face reaches from the crease.
    ///
    /// Cost: O(corners of the faces at these creases).
    #[must_use]
    pub fn parting(&self, pattern: &CreasePattern, tree: &SpanningTree) -> f64 {
        let parted = tree
            .loops()
            .iter()
            .map(|step| self.twist(step) * least_reach(pattern, step));
        largest(parted) / pattern.median_edge()
    }

    /// Returns twice the sine of half the angle by which the face of a step off the tree is turned from where the step's
    /// fold angle has it.
    fn twist(&self, step: &Step) -> f64 {
        let r_wb = self.poses[step.face.index()].r_wf;
        2.0 * (self.beyond(step).inverse() * r_wb).v.norm()
    }
}

/// Returns how far the smaller of the two faces of a step reaches from the edge between them.
pub(super) fn least_reach(pattern: &CreasePattern, step: &Step) -> f64 {
    let reach = |face: FaceId| {
        let corners = pattern.faces()[face.index()].iter();
        largest(corners.map(|corner| {
            let away = pattern.vertices()[corner.index()] - step.pivot;
            step.axis.perp(&away).abs()
        }))
    };
    reach(step.face).min(reach(step.parent))
}

/// Returns the largest relative change of length of an edge or virtual edge, for given folded positions.
#[must_use]
pub fn deformation(pattern: &CreasePattern, vertices: &[Vector3<f64>]) -> f64 {
    strain(
        pattern.struts().map(|ends| Strut::new(pattern, ends)),
        vertices,
    )
}

/// Two vertices that panels hold at a fixed distance.
#[derive(Clone, Copy, Debug)]
struct Strut {
    ends: [VertexId; 2],
    /// Square of this distance.
    square: f64,
}

impl Strut {
    fn new(pattern: &CreasePattern, ends: [VertexId; 2]) -> Self {
        let [a, b] = ends.map(|end| pattern.vertices()[end.index()]);
        let square = (b - a).norm_squared();
        Self { ends, square }
    }
}

fn strain(struts: impl Iterator<Item = Strut>, vertices: &[Vector3<f64>]) -> f64 {
    // Bits of the least and the greatest squared distance over that in the flat sheet. The bits of numbers that
    // are not negative are in the order of the numbers, and those of NaN come last.
    let mut least = 1.0_f64.to_bits();
    let mut greatest = least;
    for Strut { ends, square } in struts {
        let [a, b] = ends.map(|end| vertices[end.index()]);
        let ratio = ((b - a).norm_squared() / square).to_bits();
        greatest = greatest.max(ratio);
        least = least.min(ratio);
    }
    let [least, greatest] = [least, greatest].map(|bits| f64::from_bits(bits).sqrt());
    larger(greatest - 1.0, 1.0 - least)
}
