//! Finds translations of the flat sheet that take faces to faces, and hinges to hinges that turn alike.
//!
//! A candidate takes a seed face to a face near it; walking over face and image together proves or refutes it.

use std::collections::VecDeque;

use foldpath_core::Membership;
use nalgebra::Vector2;

use super::orbits::Link;
use crate::pattern::{CreasePattern, EdgeId, FaceId, VertexId};
use crate::util::nan_max::bounding_box;

/// Largest distance between corners that count as equal: the tolerance of exact crease groups.
const SAME_POINT_EDGES: f64 = 1e-6;
/// Number of faces round a seed among which its images are searched. The second number is used if the first gives too
/// few steps. Cells of a few faces are the rule, and a candidate costs little unless it is an image.
const CANDIDATE_FACES: [usize; 2] = [64, 2048];
/// Positions of the seeds in the bounding box of the sheet, 0 to 1: the middle, then the corners, as in a small sheet
/// the middle face may have no image.
const SEED_POSITIONS: [[f64; 2]; 5] = [CENTRE, [0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
pub(super) const CENTRE: [f64; 2] = [0.5, 0.5];
/// Largest number of compared faces: `MAX_COMPARISONS` plus `MAX_PASSES` times the number of faces.
const MAX_COMPARISONS: usize = 100_000;
const MAX_PASSES: usize = 8;

/// Marks a missing face beyond the border of the sheet.
pub(super) const NONE: u32 = u32::MAX;

/// A side of a face, with the face beyond it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// The face beyond, or [`NONE`].
    pub(super) face: u32,
    /// Index of the same side as a side of the face beyond.
    twin: u32,
    /// Group and sign of the hinge; `None` if the side stays flat.
    hinge: Option<Membership>,
    pub(super) edge: EdgeId,
}

/// A translation, and for each face its image, or [`NONE`].
pub(super) struct Step {
    pub(super) shift: Vector2<f64>,
    pub(super) images: Vec<u32>,
}

/// A face, its image, and the corner of the image on which the first corner of the face lies.
#[derive(Clone, Copy)]
struct Pair {
    face: u32,
    image: u32,
    turn: u32,
}

/// The faces with the faces beyond their sides. A side has the number of the corner at which it begins.
pub(super) struct FaceAdjacency<'a> {
    pattern: &'a CreasePattern,
    sides: Vec<Side>,
    /// Position in the flat sheet at which each side begins.
    corners: Vec<Vector2<f64>>,
    tolerance: f64,
    budget: usize,
}

impl<'a> FaceAdjacency<'a> {
    /// Makes the adjacency of the faces. Returns `None` if `memberships` has not one entry for each crease. Cost:
    /// linear.
    pub(super) fn new(pattern: &'a CreasePattern, memberships: &[Membership]) -> Option<Self> {
        let vertices = pattern.vertices();
        let corners = pattern.faces().items().iter();
        let corners: Vec<_> = corners.map(|v| vertices[v.index()]).collect();
        let none = Side {
            face: NONE,
            twin: 0,
            hinge: None,
            edge: EdgeId(0),
        };
        let mut adjacency = Self {
            pattern,
            sides: vec![none; corners.len()],
            corners,
            tolerance: SAME_POINT_EDGES * pattern.median_edge(),
            budget: MAX_COMPARISONS + MAX_PASSES * pattern.faces().len(),
        };
        for (index, edge) in (0..).zip(pattern.edges()) {
            let Some([left, right]) = edge.inner_faces() else {
                continue;
            };
            let hinge = match edge.crease {
                Some(crease) => Some(*memberships.get(crease.index())?),
                None => None,
            };
            let [a, b] = edge.ends;
            let ours = adjacency.side_between(left, [a, b])?;
            let theirs = adjacency.side_between(right, [b, a])?;
            for (side, twin, face) in [(ours, theirs, right), (theirs, ours, left)] {
                adjacency.sides[side] = Side {
                    face: face.0,
                    twin: VertexId::new(twin).0,
                    hinge,
                    edge: EdgeId(index),
                };
            }
        }
        Some(adjacency)
    }

    /// Returns the side of `face` that leads from `a` to `b`.
    fn side_between(&self, face: FaceId, [a, b]: [VertexId; 2]) -> Option<usize> {
        let cycle = &self.pattern.faces()[face.index()];
        let next = |k: usize| cycle[if k + 1 == cycle.len() { 0 } else { k + 1 }];
        let at = (0..cycle.len()).find(|&k| cycle[k] == a && next(k) == b)?;
        Some(self.start(face.0) + at)
    }

    /// Returns the index of a face's first corner, which is also that of its first side.
    fn start(&self, face: u32) -> usize {
        self.pattern.faces().range(face as usize).start
    }

    fn degree(&self, face: u32) -> usize {
        self.pattern.faces()[face as usize].len()
    }

    /// Returns the number of faces.
    pub(super) fn faces(&self) -> usize {
        self.pattern.faces().len()
    }

    /// Returns the sides of a face.
    pub(super) fn sides(&self, face: u32) -> &[Side] {
        &self.sides[self.pattern.faces().range(face as usize)]
    }

    /// Returns `true` if a face may have been cut at the border of the sheet.
    fn is_at_border(&self, face: u32) -> bool {
        self.sides(face).iter().any(|side| side.face == NONE)
    }

    /// Returns a face at the vertex nearest to a position in the bounding box of the sheet, given from 0 to 1.
    pub(super) fn seed(&self, place: [f64; 2]) -> Option<FaceId> {
        let vertices = self.pattern.vertices();
        let (low, high) = bounding_box(vertices.iter().copied())?;
        let [x, y] = [0, 1].map(|k| low[k] + (high[k] - low[k]) * place[k]);
        let mut nearest = (f64::INFINITY, None);
        for (vertex, faces) in vertices.iter().zip(self.pattern.corners().iter()) {
            let distance = (vertex.x - x) * (vertex.x - x) + (vertex.y - y) * (vertex.y - y);
            if distance < nearest.0 && !faces.is_empty() {
                nearest = (distance, faces.first().copied());
            }
        }
        nearest.1
    }

    /// Returns at most two independent steps, the nearest that were found.
    pub(super) fn steps(&mut self) -> Vec<Step> {
        let mut steps: Vec<Step> = Vec::new();
        for seed in SEED_POSITIONS {
            let Some(seed) = self.seed(seed) else {
                continue;
            };
            for ball in CANDIDATE_FACES {
                for (shift, pair) in self.candidates(seed, ball) {
                    let line = steps.first().map(|step| step.shift.normalize());
                    if line.is_some_and(|line| line.perp(&shift).abs() <= self.tolerance) {
                        continue;
                    }
                    steps.extend(self.step(shift, pair));
                    if steps.len() == 2 {
                        return steps;
                    }
                }
                if ball >= self.faces() {
                    break;
                }
            }
        }
        steps
    }

    /// Returns translations that take the seed to one of the `ball` faces round it. They are sorted by the number of
    /// sides to cross, because few crossings lead along the borders that sheets have, and then by length.
    fn candidates(&self, seed: FaceId, ball: usize) -> Vec<(Vector2<f64>, Pair)> {
        let mut candidates = Vec::new();
        let mut rings = vec![NONE; self.faces()];
        rings[seed.index()] = 0;
        let mut open = vec![seed.0];
        let mut next = 0;
        while next < open.len().min(ball) {
            let image = open[next];
            let ring = rings[image as usize];
            next += 1;
            for side in self.sides(image) {
                if side.face != NONE && rings[side.face as usize] == NONE {
                    rings[side.face as usize] = ring + 1;
                    open.push(side.face);
                }
            }
            for turn in (0..).take(self.degree(image)) {
                let face = seed.0;
                let pair = Pair { face, image, turn };
                let first = self.corners[self.start(face)];
                let shift = self.corners[self.start(image) + turn as usize] - first;
                if image != face && self.fits(pair, shift) {
                    candidates.push((ring, shift, pair));
                }
            }
        }
        let size = |shift: &Vector2<f64>| shift.norm_squared();
        candidates.sort_by(|(r, a, _), (s, b, _)| r.cmp(s).then(size(a).total_cmp(&size(b))));
        let candidates = candidates.into_iter();
        candidates.map(|(_, shift, pair)| (shift, pair)).collect()
    }

    /// Returns `true` if the translation, which takes the first face of one link to that of the other, takes the hinge
    /// to a hinge that turns alike, and the face beyond to the face beyond.
    pub(super) fn carries(&self, shift: Vector2<f64>, links: [Link; 2]) -> bool {
        let [side, other] = links.map(|link| {
            let start = self.start(link.from.0);
            let at = self.sides(link.from.0).iter();
            let at = at.take_while(|side| side.edge != link.edge).count();
            start + at
        });
        let off = self.corners[other] - self.corners[side] - shift;
        let (side, other) = (&self.sides[side], &self.sides[other]);
        off.norm() <= self.tolerance
            && side.hinge == other.hinge
            && self.fits(self.beyond(side, other), shift)
    }

    /// Returns `true` if the moved face is the image.
    fn fits(&self, pair: Pair, shift: Vector2<f64>) -> bool {
        let degree = self.degree(pair.face);
        if degree != self.degree(pair.image) {
            return false;
        }
        let corners = |face| &self.corners[self.start(face)..][..degree];
        let (face, image) = (corners(pair.face), corners(pair.image));
        let limit = self.tolerance * self.tolerance;
        let mut turned = pair.turn as usize;
        face.iter().all(|from| {
            let off = image[turned] - from - shift;
            turned = if turned + 1 == degree { 0 } else { turned + 1 };
            off.x * off.x + off.y * off.y <= limit
        })
    }

    /// Finds the images of all faces that can be reached from `seed.face` through faces with an image.
    ///
    /// Face and image are walked round together. Wherever both have a face beyond a side, the second must be the image
    /// of the first, and the hinges must turn alike; otherwise the translation is no step. Faces at the border
    /// that differ in shape are excused, as long as they are fewer than the images. Cost: O(images).
    fn step(&mut self, shift: Vector2<f64>, seed: Pair) -> Option<Step> {
        let mut images = vec![NONE; self.faces()];
        images[seed.face as usize] = seed.image;
        // A queue keeps the visited faces near each other in memory.
        let mut open = VecDeque::from([seed]);
        let (mut found, mut excused) = (1, 0);
        while let Some(pair) = open.pop_front() {
            self.budget = self.budget.checked_sub(1)?;
            let [from, to] = [pair.face, pair.image].map(|face| self.start(face));
            let degree = self.degree(pair.face);
            let mut image = pair.turn as usize;
            for side in &self.sides[from..from + degree] {
                let other = self.sides[to + image];
                image = if image + 1 == degree { 0 } else { image + 1 };
                if side.face == NONE || other.face == NONE {
                    continue;
                }
                let known = images[side.face as usize];
                if known == NONE {
                    let beyond = self.beyond(side, &other);
                    if !self.fits(beyond, shift) {
                        if !self.is_at_border(side.face) && !self.is_at_border(other.face) {
                            return None;
                        }
                        excused += 1;
                        continue;
                    }
                    images[side.face as usize] = other.face;
                    found += 1;
                    open.push_back(beyond);
                } else if known != other.face {
                    return None;
                }
                if side.hinge != other.hinge {
                    return None;
                }
            }
        }
        if excused > found {
            return None;
        }
        Some(Step { shift, images })
    }

    /// Pairs the face beyond a side with the face beyond the image of the side.
    fn beyond(&self, side: &Side, other: &Side) -> Pair {
        let degree = self.degree(other.face);
        let [of_face, of_image] =
            [side, other].map(|side| side.twin as usize - self.start(side.face));
        let back = || (of_image + degree).saturating_sub(of_face);
        // If the degrees differ, the faces are no images of each other, whatever `turn` is.
        let turn = of_image.checked_sub(of_face).unwrap_or_else(back);
        Pair {
            face: side.face,
            image: other.face,
            turn: VertexId::new(turn).0,
        }
    }
}
