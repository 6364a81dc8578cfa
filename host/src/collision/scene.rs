//! Judges one configuration of a sheet after another: finds the deepest crossing of faces. A bounding volume hierarchy is
//! the broad phase.

use std::sync::Arc;

use nalgebra::Vector3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};

use super::pieces::{Contact, Pieces, Placed};
use super::sides::Side;
use super::solids::Plates;
use super::sweep::SweepCounts;
use crate::folding::{FoldingMap, Pose};
use crate::pattern::{CreasePattern, FaceId};

/// Two faces that pass through each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The faces, the smaller number first.
    pub faces: [FaceId; 2],
    /// Depth of the crossing, in units of the sheet.
    pub depth: f64,
}

impl Crossing {
    pub(super) fn new(faces: [FaceId; 2], depth: f64) -> Self {
        let [a, b] = faces;
        Self {
            faces: [a.min(b), a.max(b)],
            depth,
        }
    }

    /// Returns `true` if this crossing is deeper. Equal depths, as symmetry makes them, are ordered by face
    /// number, so that the answer does not depend on the order of the search.
    pub(super) fn exceeds(&self, other: &Self) -> bool {
        let order = self.depth.total_cmp(&other.depth);
        order.then(other.faces.cmp(&self.faces)).is_gt()
    }
}

/// The faces of a pattern, to be searched for crossings.
#[derive(Clone)]
pub struct CollisionScene {
    pieces: Pieces,
    /// The pairs of pieces of different faces that share a side.
    sides: Vec<([u32; 2], Side)>,
    folded: Vec<Vector3<f64>>,
    normals: Vec<Vector3<f64>>,
    /// Points of solids, and poses of their pieces; empty for faces.
    hulls: Vec<Vector3<f64>>,
    poses: Vec<Pose>,
    /// Number of pairs of pieces of the same sheet that share no side.
    pairs: u64,
    median_edge: f64,
    hierarchy: Bvh,
    workspace: BvhWorkspace,
    counts: SweepCounts,
}

impl CollisionScene {
    /// Creates the scene of a pattern. Cost: O(faces).
    #[must_use]
    pub fn new(pattern: &CreasePattern) -> Self {
        Self::of_plates(pattern, None)
    }

    /// Creates the scene of a pattern whose panels are plates, if any are given. Cost: O(faces).
    #[must_use]
    pub(crate) fn of_plates(pattern: &CreasePattern, plates: Option<&Arc<Plates>>) -> Self {
        let pieces = Pieces::new(pattern, plates);
        let mut sides = pieces.sides();
        sides.retain(|(pair, _)| pieces.keeps_back(pattern, *pair).is_none());
        let [points, solids] = match plates {
            Some(_) => [pieces.hull_points(), pieces.list.len()],
            None => [0; 2],
        };
        Self {
            hulls: vec![Vector3::zeros(); points],
            poses: vec![Pose::identity(); solids],
            folded: pieces.flat.iter().map(|p| p.push(0.0)).collect(),
            normals: vec![Vector3::z(); pieces.list.len()],
            median_edge: pattern.median_edge(),
            hierarchy: Bvh::new(),
            workspace: BvhWorkspace::default(),
            counts: SweepCounts::default(),
            pairs: pieces.pairs() - pieces.joined_pairs().len() as u64,
            sides,
            pieces,
        }
    }

    /// Returns the deepest crossing under a folding map, if any.
    ///
    /// Faces that share a vertex cross only if they are deeper in each other than the distance between the positions that
    /// they give this vertex. `contact` is the depth up to which any faces may overlap, in median edges: the
    /// [`contact_tolerance`](super::contact_tolerance), of which at most a thousandth of the smaller of two faces counts.
    /// Cost: about O(faces log faces) while few bounding boxes overlap.
    pub fn deepest_crossing(&mut self, map: &FoldingMap, contact: f64) -> Option<Crossing> {
        self.deepest_crossing_of(map, contact, |_| true)
    }

    /// Returns the deepest crossing of those pairs of faces for which `may_cross` is true.
    pub(crate) fn deepest_crossing_of(
        &mut self,
        map: &FoldingMap,
        contact: f64,
        may_cross: impl Fn([FaceId; 2]) -> bool,
    ) -> Option<Crossing> {
        self.place(map);
        let mut deepest: Option<Crossing> = None;
        let contact = Contact::new(self.median_edge, contact);
        let pieces = &self.pieces;
        let placed = Placed {
            pieces,
            folded: &self.folded,
            normals: &self.normals,
            hulls: &self.hulls,
            poses: &self.poses,
        };
        let mut judge = |faces: [FaceId; 2], [a, b]: [u32; 2]| {
            // Few pairs overlap, so that few tears are measured.
            let depth = |torn| placed.depth([a, b], contact.of(pieces, [a, b], torn));
            let mut depth = match depth(0.0) {
                overlap if overlap > 0.0 => depth(placed.torn([a, b])),
                _ => return,
            };
            if depth > 0.0 && !placed.are_exact([a, b]) {
                // Only what is certain counts.
                let least = placed.least_depth([a, b], depth);
                let is_deep = least > contact.of(pieces, [a, b], 0.0).largest();
                depth = if is_deep { least } else { 0.0 };
            }
            if depth <= 0.0 {
                return;
            }
            let crossing = Crossing::new(faces, depth);
            if deepest.is_none_or(|deepest| crossing.exceeds(&deepest)) {
                deepest = Some(crossing);
            }
        };
        for (pair, side) in &self.sides {
            let may_meet = || side.may_cross(&placed, contact.of(pieces, *pair, 0.0).within);
            if (pieces.are_solid() || may_meet())
                && let Some(faces) = pieces.comparable(pair[0], pair[1])
                && may_cross(faces)
            {
                judge(faces, *pair);
            }
        }
        let mut tested = 0;
        let judge = &mut |a: u32, b: u32| {
            if let Some(faces) = pieces.comparable(a, b)
                && may_cross(faces)
                && !pieces.joined(a, b)
            {
                tested += 1;
                judge(faces, [a, b]);
            }
        };
        self.hierarchy
            .traverse_bvtt_single_tree::<false>(&mut self.workspace, judge);
        self.counts.pairs += self.pairs;
        self.counts.tested += tested;
        self.counts.skipped_bounds += self.pairs - tested;
        deepest
    }

    /// Returns the numbers of pairs tested, and skipped because their bounding boxes do not overlap, since the scene was
    /// made. Pairs joined by an edge do not count.
    #[must_use]
    pub fn counts(&self) -> SweepCounts {
        self.counts
    }

    /// Places the pieces and updates the hierarchy.
    fn place(&mut self, map: &FoldingMap) {
        let boxes =
            (0..)
                .zip(&self.pieces.list)
                .zip(&mut self.normals)
                .map(|((index, piece), normal)| {
                    let pose = &map.poses()[piece.face.index()];
                    *normal = pose.r_wf.rotate(&Vector3::z());
                    let corners = piece.corners();
                    let mut low = Vector3::repeat(f64::INFINITY);
                    let mut high = -low;
                    let places = self.folded[corners.clone()].iter_mut();
                    for (folded, flat) in places.zip(&self.pieces.flat[corners]) {
                        *folded = pose.apply(*flat);
                        low = low.inf(folded);
                        high = high.sup(folded);
                    }
                    if let Some(known) = self.poses.get_mut(index as usize) {
                        *known = *pose;
                        let mut points = self.hulls[self.pieces.hull(index)].iter_mut();
                        self.pieces.place(index, pose, |at| {
                            low = low.inf(&at);
                            high = high.sup(&at);
                            if let Some(point) = points.next() {
                                *point = at;
                            }
                        });
                    }
                    Aabb::new(
                        Vector::new(low.x, low.y, low.z),
                        Vector::new(high.x, high.y, high.z),
                    )
                });
        if self.hierarchy.is_empty() {
            let boxes: Vec<_> = boxes.collect();
            self.hierarchy = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
        } else {
            for (leaf, aabb) in (0..).zip(boxes) {
                self.hierarchy.insert_or_update_partially(aabb, leaf, 0.0);
            }
            self.hierarchy.refit(&mut self.workspace);
        }
    }
}
