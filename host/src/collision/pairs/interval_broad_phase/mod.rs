//! Broad phase for a whole sheet, over one interval of a motion after the other: proves by a separating plane
//! that two pieces stay apart during the whole interval.
//!
//! An interval has the positions of the pieces at its beginning, in its middle and at its end, and a bound on their
//! deviation from the quadratic curves through these positions. Along such a quadratic a corner stays in the convex
//! hull of the curve's control points, and a piece stays in the hull of its corners' control points. Take a fixed
//! direction and, at each of the three control points, the least distance by which the corners of one piece are ahead
//! of the corners of the other. At any time of the interval, the least distance by which that piece is ahead is no less
//! than a sum of these three with weights that are positive and sum to one. If all three exceed the deviations of both
//! pieces together, the pieces are apart from the beginning to the end, however both move together.

mod deviation;
mod near;

use core::ops::Range;

use foldpath_core::{HalfAngle, Membership};
use nalgebra::Vector3;

use self::deviation::{MotionBound, Turning};
use crate::collision::hierarchy::Hierarchy;
use crate::collision::narrow::crossing::ConvexPiece;
use crate::collision::narrow::separation::distance;
use crate::collision::pieces::Pieces;
use crate::collision::solids::solid::PlacedSolid;
use crate::collision::sweep::motion::{Motion, SEGMENT, Tick};
use crate::collision::tolerances::{
    MAX_DEVIATION_EDGES, MIN_INTERVAL_TICKS, THIRD_DERIVATIVE_PART_TICKS, THIRD_DERIVATIVE_PARTS,
};
use crate::folding::{Hinge, Pose, Product, place_all};
use crate::pattern::{CreasePattern, FaceId, bodies};

/// A value at the beginning of an interval, in its middle and at its end.
type Three<T> = [T; 3];

/// The pieces of a sheet over an interval: their places at three times, boxes round them, and bounds on their
/// deviation.
#[derive(Clone, Debug, Default)]
pub(super) struct IntervalBroadPhase {
    hinges: Vec<Hinge>,
    /// For each hinge two distances: from the pivot of the hinge before to this pivot, and from this pivot to the farthest
    /// corner of the face beyond.
    reaches: Vec<[f64; 2]>,
    /// For each hinge `true` if it keeps its angle over the current segment, and those distances (`spans`): a hinge that
    /// rests has the pivot of the hinge before.
    resting: Vec<bool>,
    spans: Vec<[f64; 2]>,
    /// For each cluster the body that has all its pieces, if one has: faces at rest relative to each other over the current
    /// segment.
    bodies: Vec<Option<FaceId>>,
    /// Limit on the deviation of a piece, units of the sheet.
    limit: f64,
    /// Bound on the third derivative of each group's angle, one row for each part of the segment.
    thirds: Vec<f64>,
    pub(super) from: Tick,
    pub(super) to: Tick,
    half_angles: Vec<HalfAngle<f64>>,
    /// First and second derivative of each group's angle at the beginning, with time in segments.
    rates: Vec<[f64; 2]>,
    /// Bounds on its first three derivatives over the interval, with time in intervals.
    rate_bounds: Vec<Three<f64>>,
    /// For each face: its turning at the beginning, bounds on its motion (`bounds`), bound on the deviation of its corners
    /// (`deviations`, units of the sheet), and pose.
    turning: Vec<Turning>,
    bounds: Vec<MotionBound>,
    deviations: Vec<f64>,
    poses: Vec<Pose>,
    /// The poses of the faces at the three times; empty unless pieces are solids.
    poses_of_solids: Three<Vec<Pose>>,
    normals: Three<Vec<Vector3<f64>>>,
    /// Position of each corner of the pieces; in the middle, its control point.
    places: Three<Vec<Vector3<f64>>>,
    /// For each cluster a box that contains it during the whole interval.
    boxes: Vec<[Vector3<f64>; 2]>,
    open: Vec<[u32; 2]>,
}

impl IntervalBroadPhase {
    pub(super) fn new(pattern: &CreasePattern, memberships: &[Membership], groups: usize) -> Self {
        let (tree, faces) = (pattern.tree(), pattern.faces().len());
        let mut pivots = vec![None; faces];
        let reaches = tree.steps().iter().map(|step| {
            let pivot = step.pivot;
            let before = pivots[step.parent.index()].unwrap_or(pivot);
            pivots[step.face.index()] = Some(pivot);
            let corners = pattern.faces()[step.face.index()].iter();
            let away = corners.map(|v| (pattern.vertices()[v.index()] - pivot).norm());
            [(pivot - before).norm(), away.fold(0.0, f64::max)]
        });
        let reaches = reaches.collect();
        let steps = tree.steps().iter();
        let hinges: Vec<Hinge> = steps.map(|step| Hinge::of(step, memberships)).collect();
        Self {
            hinges,
            reaches,
            limit: MAX_DEVIATION_EDGES * pattern.median_edge(),
            half_angles: vec![HalfAngle::default(); groups],
            rate_bounds: vec![[0.0; 3]; groups],
            turning: vec![Turning::default(); faces],
            bounds: vec![MotionBound::default(); faces],
            deviations: vec![0.0; faces],
            poses: vec![Pose::identity(); faces],
            normals: [(); 3].map(|()| vec![Vector3::z(); faces]),
            ..Self::default()
        }
    }

    /// Goes to the beginning of a motion.
    pub(super) fn begin(&mut self, motion: &Motion, pieces: &Pieces) {
        (self.from, self.to) = (0, 0);
        for places in &mut self.places {
            places.resize(pieces.hull_points(), Vector3::zeros());
        }
        self.reach_solids(pieces);
        self.fold(motion, pieces, 0, 2);
    }

    /// Makes the reaches of faces those of the solids that move with them.
    fn reach_solids(&mut self, pieces: &Pieces) {
        if !pieces.are_solid() {
            return;
        }
        let mut hinges = vec![None; self.poses.len()];
        for (index, hinge) in self.hinges.iter().enumerate() {
            hinges[hinge.to as usize] = Some(index);
        }
        for piece in &pieces.list {
            if let Some(index) = hinges[piece.face.index()] {
                let (pivot, reach) = (self.hinges[index].pivot, &mut self.reaches[index][1]);
                let corners = pieces.flat[piece.corners()].iter();
                let away = corners.map(|corner| (corner - pivot).norm() + pieces.height());
                *reach = away.fold(*reach, f64::max);
            }
        }
    }

    /// Goes on to the next interval. Returns `false` if the deviation is beyond the limit even over the shortest one.
    pub(super) fn advance(
        &mut self,
        motion: &Motion,
        pieces: &Pieces,
        hierarchy: &Hierarchy,
    ) -> bool {
        // Twice the last length, unless the interval would then not end on a multiple of its length.
        let mut length = 2 * (self.to - self.from);
        self.from = self.to;
        let into = self.from % SEGMENT;
        if into > 0 {
            length = length.min(1 << into.trailing_zeros());
        } else {
            motion.third_derivatives(self.from, THIRD_DERIVATIVE_PARTS, &mut self.thirds);
            self.enter_segment(motion, pieces, hierarchy);
            if self.from == 0 || length > SEGMENT {
                length = SEGMENT;
            }
        }
        self.to = self.from + length;
        self.begin_turning(motion);
        while !self.is_within_limit() {
            length /= 2;
            if length < MIN_INTERVAL_TICKS {
                return false;
            }
            self.to = self.from + length;
        }
        self.places.swap(0, 2);
        self.normals.swap(0, 2);
        self.poses_of_solids.swap(0, 2);
        self.fold(motion, pieces, self.from + length / 2, 1);
        self.fold(motion, pieces, self.to, 2);
        let [from, middle, to] = &mut self.places;
        for ((middle, from), to) in middle.iter_mut().zip(from).zip(to) {
            *middle = *middle * 2.0 - (*from + *to) / 2.0;
        }
        self.enclose(pieces, hierarchy);
        true
    }

    /// Finds the hinges that rest over the segment that begins now, and what moves as one body for it.
    fn enter_segment(&mut self, motion: &Motion, pieces: &Pieces, hierarchy: &Hierarchy) {
        let segment = [self.from, self.from + SEGMENT];
        let rests = |hinge: &Hinge| {
            hinge
                .group()
                .is_none_or(|group| motion.rests(group, segment))
        };
        self.resting.clear();
        self.resting.extend(self.hinges.iter().map(rests));
        let hinges = || self.hinges.iter().zip(&self.resting);
        let faces = self.poses.len();
        let joined = hinges().filter(|(_, rests)| **rests);
        let of_faces = bodies(faces, joined.map(|(hinge, _)| [hinge.from, hinge.to]));
        near::find_bodies(&mut self.bodies, &of_faces, hierarchy);
        self.spans.clone_from(&self.reaches);
        if !hinges().any(|(hinge, rests)| *rests && hinge.turns.is_some()) {
            self.resting.fill(false);
            return;
        }
        // Distances across hinges that rest are those in the sheet as it is now.
        let mut pivots: Vec<Option<Vector3<f64>>> = vec![None; faces];
        for ((hinge, span), &rests) in self.hinges.iter().zip(&mut self.spans).zip(&self.resting) {
            let [from, to] = [hinge.from, hinge.to].map(|face| face as usize);
            let pivot = self.poses[from].apply(hinge.pivot);
            span[0] = pivots[from].map_or(0.0, |before| (pivot - before).norm());
            pivots[to] = if rests { pivots[from] } else { Some(pivot) };
        }
        let mut farthest = vec![0.0_f64; faces];
        for (index, piece) in (0..).zip(&pieces.list) {
            let face = piece.face.index();
            let corners = self.places[2][pieces.hull(index)].iter();
            let away = corners.map(|at| pivots[face].map_or(0.0, |pivot| (at - pivot).norm()));
            farthest[face] = away.fold(farthest[face], f64::max);
        }
        for (hinge, span) in self.hinges.iter().zip(&mut self.spans) {
            span[1] = farthest[hinge.to as usize];
        }
    }

    /// Finds how all faces turn at the beginning of the interval, where they are placed already.
    fn begin_turning(&mut self, motion: &Motion) {
        motion.derivatives(self.from, &mut self.rates);
        self.turning.fill(Turning::default());
        for (hinge, &rests) in self.hinges.iter().zip(&self.resting) {
            let [face, parent] = [hinge.to, hinge.from].map(|face| face as usize);
            let before = self.turning[parent];
            let turns = hinge.turns.filter(|_| !rests);
            self.turning[face] = turns.map_or(before, |member| {
                let rates = self.rates[member.group.index()].map(|rate| member.apply(rate));
                before.across(self.poses[parent].turn(hinge.axis), rates)
            });
        }
    }

    /// Returns `true` if no piece deviates beyond the limit over the interval.
    fn is_within_limit(&mut self) -> bool {
        #[allow(clippy::cast_precision_loss, reason = "37 bits are exact")]
        let part = (self.to - self.from) as f64 / SEGMENT as f64;
        let into = self.from % SEGMENT;
        let parts = into / THIRD_DERIVATIVE_PART_TICKS
            ..(into + self.to - self.from).div_ceil(THIRD_DERIVATIVE_PART_TICKS);
        let groups = self.rates.len();
        for (group, (bounds, rates)) in self.rate_bounds.iter_mut().zip(&self.rates).enumerate() {
            let index = |k: Tick| usize::try_from(k).unwrap_or(usize::MAX) * groups + group;
            let thirds = parts.clone().map(|k| self.thirds[index(k)]);
            let third = thirds.fold(0.0, f64::max) * part.powi(3);
            let [first, second] = [rates[0].abs() * part, rates[1].abs() * part * part];
            *bounds = [first + second + third / 2.0, second + third, third];
        }
        self.bounds.fill(MotionBound::default());
        self.deviations.fill(0.0);
        let spans = self.spans.iter().zip(&self.resting);
        for (hinge, (&[way, reach], &rests)) in self.hinges.iter().zip(spans) {
            let [face, parent] = [hinge.to, hinge.from].map(|face| face as usize);
            let before = self.bounds[parent];
            let bound = if rests {
                before
            } else {
                let rates = hinge
                    .group()
                    .map_or([0.0; 3], |group| self.rate_bounds[group]);
                before.across(way, rates, &self.turning[face], part)
            };
            self.bounds[face] = bound;
            let deviation = bound.deviation(reach);
            self.deviations[face] = deviation;
            if deviation.is_nan() || deviation > self.limit {
                return false;
            }
        }
        true
    }

    /// Places all pieces at a time, as entry `which` of the three.
    fn fold(&mut self, motion: &Motion, pieces: &Pieces, time: Tick, which: usize) {
        motion.half_angles(time, &mut self.half_angles);
        self.poses.fill(Pose::identity());
        let (poses, half_angles) = (&mut self.poses, &self.half_angles);
        place_all(poses, &self.hinges, half_angles, Product::Plain);
        for (normal, pose) in self.normals[which].iter_mut().zip(&self.poses) {
            *normal = pose.r_wf.rotate(&Vector3::z());
        }
        if pieces.are_solid() {
            self.poses_of_solids[which].clone_from(&self.poses);
        }
        for (index, piece) in (0..).zip(&pieces.list) {
            let mut places = self.places[which][pieces.hull(index)].iter_mut();
            pieces.place(index, &self.poses[piece.face.index()], |at| {
                if let Some(place) = places.next() {
                    *place = at;
                }
            });
        }
    }

    /// Looks for a plane that keeps two pieces farther apart than `touching` from the beginning to the end. Returns
    /// their separations along the plane's normal at the three control points; the first and the last are lower bounds
    /// of their distance at the beginning and at the end. Returns `None` if no such plane is found.
    #[inline]
    pub(super) fn parted(
        &self,
        pieces: &Pieces,
        pair: [u32; 2],
        touching: f64,
    ) -> Option<Three<f64>> {
        let corners = pair.map(|piece| pieces.hull(piece));
        let faces = pair.map(|piece| pieces.list[piece as usize].face.index());
        let slack = self.deviations[faces[0]] + self.deviations[faces[1]] + touching;
        let center = |corners: &Range<usize>| {
            let sum: Vector3<f64> = self.places[1][corners.clone()].iter().sum();
            #[allow(clippy::cast_precision_loss, reason = "a mean")]
            let center = sum / corners.len() as f64;
            center
        };
        let between = center(&corners[1]) - center(&corners[0]);
        let along = |direction: &Vector3<f64>| {
            let forwards = direction * direction.dot(&between).signum();
            self.ahead(&corners, &forwards, slack)
        };
        let normals = |which: usize| {
            let mut normals = faces.iter().map(|&face| &self.normals[which][face]);
            normals.find_map(along)
        };
        normals(1)
            .or_else(|| along(&between.try_normalize(0.0)?))
            .or_else(|| normals(2))
            .or_else(|| normals(0))
    }

    /// Returns, for each control point, the distance by which the second piece is ahead of the first; `None` if it is not
    /// more than `slack` at each.
    #[inline]
    fn ahead(
        &self,
        corners: &[Range<usize>; 2],
        direction: &Vector3<f64>,
        slack: f64,
    ) -> Option<Three<f64>> {
        let mut ahead = [0.0; 3];
        for (ahead, places) in ahead.iter_mut().zip(&self.places) {
            let (mut first, mut second) = (f64::NEG_INFINITY, f64::INFINITY);
            for place in &places[corners[0].clone()] {
                first = f64::max(first, direction.dot(place));
            }
            for place in &places[corners[1].clone()] {
                second = f64::min(second, direction.dot(place));
            }
            *ahead = second - first;
            if ahead.is_nan() || *ahead <= slack {
                return None;
            }
        }
        Some(ahead)
    }

    /// Returns the distance of two pieces at the beginning (0) or the end (2) of the interval.
    pub(super) fn distance(&self, pieces: &Pieces, pair: [u32; 2], end: usize) -> f64 {
        let face = |piece: u32| pieces.list[piece as usize].face.index();
        let points = |piece: u32| &self.places[end][pieces.hull(piece)];
        let solid = |piece: u32| {
            Some(PlacedSolid {
                solid: pieces.solid(piece)?,
                pose: &self.poses_of_solids[end][face(piece)],
                points: points(piece),
            })
        };
        if let [Some(a), Some(b)] = pair.map(solid) {
            return a.distance(&b);
        }
        let [a, b] = pair.map(|piece| ConvexPiece {
            corners: points(piece),
            normal: self.normals[end][face(piece)],
        });
        distance(&a, &b)
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;
    use crate::collision::sweep::Place;
    use crate::folding::FoldingMap;
    use crate::generate::{Miura, Waterbomb};
    use crate::pattern::{Drawing, DrawnEdge, Letter};
    use crate::symmetry::CreaseGroups;
    use foldpath_core::Curve;
    use nalgebra::Vector2;
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::Rng as _;

    #[test]
    fn pieces_that_lie_on_each_other_are_not_parted() {
        let vertices = (0..8).map(|k| Vector2::new(f64::from(k / 2), f64::from(k % 2)));
        let edge = |ends| DrawnEdge {
            ends,
            letter: Letter::Unassigned,
            goal: None,
        };
        let across = (0..4).map(|k| edge([2 * k, 2 * k + 1]));
        let along = (0..6).map(|k| edge([k, k + 2]));
        let drawing = Drawing {
            vertices: vertices.collect(),
            edges: across.chain(along).collect(),
            faces: None,
        };
        let pattern = CreasePattern::new(drawing).unwrap();
        let groups = CreaseGroups::trivial(&pattern);
        let turned = [1.0, -1.0].map(|sign| Curve::Angle([sign * PI; 4]));
        let motion = Motion::new(&[turned.to_vec()], groups.len());
        let pieces = Pieces::new(&pattern, None);
        let hierarchy = Hierarchy::new(&pieces);
        let members = groups.memberships();
        let mut broad_phase = IntervalBroadPhase::new(&pattern, members, groups.len());
        broad_phase.begin(&motion, &pieces);
        assert!(broad_phase.advance(&motion, &pieces, &hierarchy));
        assert!(broad_phase.parted(&pieces, [0, 2], 1e-12).is_none());
        // Not even along the line between their centers, if the centers coincide.
        for places in &mut broad_phase.places {
            places.copy_within(pieces.list[0].corners(), pieces.list[2].corners().start);
        }
        assert!(broad_phase.parted(&pieces, [0, 2], 1e-12).is_none());
    }

    /// Returns a Miura or a waterbomb.
    fn sheet(is_miura: bool) -> CreasePattern {
        let miura = Miura {
            rows: 4,
            columns: 5,
            sector_angle: 1.0,
            fold: 0.5,
        };
        let waterbomb = Waterbomb {
            rows: 2,
            columns: 4,
            fold: 0.5,
        };
        let drawing = if is_miura {
            miura.drawing()
        } else {
            waterbomb.drawing()
        };
        CreasePattern::new(drawing.unwrap()).unwrap()
    }

    /// Returns a motion of three segments, the one in the middle in half angles.
    fn noisy(groups: usize, mut noise: impl FnMut() -> f64) -> Vec<Vec<Curve<f64>>> {
        let mut start: Vec<f64> = (0..groups).map(|_| 0.3 * noise()).collect();
        let mut curve = |angle: &mut f64, segment: usize| {
            let knots = [0.2, 0.4, 0.6].map(|part| *angle + part * noise());
            let angles = [*angle, knots[0], knots[1], knots[2]];
            *angle = knots[2];
            if segment != 1 {
                return Curve::Angle(angles);
            }
            let half = angles.map(|a| a / 2.0);
            // The angles at the ends do not depend on the weights as long as these are not 0.
            let weight = [1.0, 1.0 + 0.2 * noise(), 1.0 + 0.2 * noise(), 1.0];
            Curve::HalfAngle {
                cos: core::array::from_fn(|k| weight[k] * half[k].cos()),
                sin: core::array::from_fn(|k| weight[k] * half[k].sin()),
            }
        };
        let segments = (0..3).map(|segment| {
            let curves = start.iter_mut().map(|angle| curve(angle, segment));
            curves.collect()
        });
        segments.collect()
    }

    /// Torn sheets, each crease a group of its own: the spanning tree alone says where faces are.
    #[test]
    fn pieces_deviate_no_farther_and_stay_as_far_apart_as_is_said() {
        let mut random = Pcg64::new(7, 1);
        let mut noise = || f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0;
        let (mut parted, mut deviated) = (0, 0.0_f64);
        for round in 0..12 {
            let pattern = sheet(round % 2 == 0);
            let groups = CreaseGroups::trivial(&pattern);
            let tree = pattern.tree();
            let segments = noisy(groups.len(), &mut noise);
            let motion = Motion::new(&segments, groups.len());
            let pieces = Pieces::new(&pattern, None);
            let hierarchy = Hierarchy::new(&pieces);
            let members = groups.memberships();
            let mut broad_phase = IntervalBroadPhase::new(&pattern, members, groups.len());
            broad_phase.begin(&motion, &pieces);
            let mut map = FoldingMap::flat(&pattern);
            while broad_phase.to < motion.end() {
                assert!(broad_phase.advance(&motion, &pieces, &hierarchy));
                let mut pairs = Vec::new();
                let parted_at =
                    |broad_phase: &IntervalBroadPhase, pair| broad_phase.parted(&pieces, pair, 0.0);
                broad_phase.near(&hierarchy, [0.0, f64::INFINITY], parted_at, |_, pair, _| {
                    pairs.push(pair);
                    f64::INFINITY
                });
                parted += pairs.len();
                for part in 0..=10 {
                    let time = broad_phase.from + (broad_phase.to - broad_phase.from) / 10 * part;
                    let Place { segment, s } = motion.place(time.min(broad_phase.to - 1));
                    let angles: Vec<_> = segments[segment].iter().map(|c| c.angle(s)).collect();
                    map.fold_groups(&pattern, tree, groups.memberships(), &angles);
                    let at = |piece: u32| {
                        let piece = pieces.list[piece as usize];
                        let pose = &map.poses()[piece.face.index()];
                        let corners = pieces.flat[piece.corners()].iter();
                        let corners: Vec<_> = corners.map(|&c| pose.apply(c)).collect();
                        (corners, pose.r_wf.rotate(&Vector3::z()))
                    };
                    #[allow(clippy::cast_precision_loss, reason = "a small number")]
                    let s = part as f64 / 10.0;
                    let weights = [(1.0 - s) * (1.0 - s), 2.0 * s * (1.0 - s), s * s];
                    for (index, piece) in (0..).zip(&pieces.list) {
                        let deviation = broad_phase.deviations[piece.face.index()];
                        for (corner, place) in piece.corners().zip(at(index).0) {
                            let along: Vector3<f64> = (0..3)
                                .map(|k| broad_phase.places[k][corner] * weights[k])
                                .sum();
                            let off = (place - along).norm();
                            assert!(off <= deviation + 1e-9, "{round} {time}: {off} {deviation}");
                            deviated = deviated.max(off / broad_phase.limit);
                        }
                    }
                    for pair in &pairs {
                        let [(a, n), (b, m)] = pair.map(at);
                        let [a, b] = [(&a, n), (&b, m)]
                            .map(|(corners, normal)| ConvexPiece { corners, normal });
                        assert!(distance(&a, &b) > 0.0, "{round} {time}: {pair:?}");
                    }
                }
            }
        }
        // The bounds are not vacuous: many pairs are parted, and pieces do deviate.
        assert!(parted > 10_000 && deviated > 0.02, "{parted} {deviated}");
    }
}
