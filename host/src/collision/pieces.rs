//! Cuts the faces of a sheet into convex pieces, and measures the crossing depth of two placed pieces.

use core::ops::Range;
use std::sync::Arc;

use nalgebra::{Vector2, Vector3};

use super::convex::{convex_parts, least_width, size};
use super::narrow::crossing::{Allowed, ConvexPiece, Lean, Overlap, side_crossing_depth};
use super::narrow::separation::distance;
use super::sides::Side;
use super::solids::Plates;
use super::solids::solid::{PlacedSolid, Solid};
use super::tolerances::{
    CHAIN_ROUNDING_RATIO, CROSSING_DEPTH_EDGES, CROSSING_DEPTH_RATIO, KEPT_BACK_RATIO,
    MAX_ROUNDING_EDGES, MAX_ROUNDING_RATIO, MIN_LEFT_RATIO,
};
use crate::folding::Pose;
use crate::pattern::{CreasePattern, Edge, EdgeId, FaceId, Precision, VertexId};

/// Returns the depth up to which an overlap of two faces counts as contact, in median edges: 1e-6, and what the precision
/// of the pattern explains, at most 1e-3 more. Coordinates explain ten units of their last digit, goal angles what turning
/// by ten of their units moves at a distance of a median edge. In front of a face whose size is below the median edge it
/// is less.
#[must_use]
pub fn contact_tolerance(pattern: &CreasePattern) -> f64 {
    let Precision { length, angle } = pattern.precision();
    let unit = length.unit() / pattern.median_edge() + angle.unit();
    CROSSING_DEPTH_EDGES + (CHAIN_ROUNDING_RATIO * unit).min(MAX_ROUNDING_EDGES)
}

/// Depths up to which an overlap of two pieces is contact. They belong to a pair: in front of a thin face they are less.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// Depth that counts as a crossing, and additional depth that rounded coordinates explain, units of the sheet.
    depth: f64,
    rounding: f64,
    /// Distance by which pieces may be elsewhere because the sheet does not quite close, units of the sheet.
    loose: f64,
}

impl Contact {
    /// Takes the depth up to which an overlap is contact, in median edges.
    pub(super) fn new(median_edge: f64, contact: f64) -> Self {
        let depth = CROSSING_DEPTH_EDGES.min(contact);
        Self {
            depth: depth * median_edge,
            rounding: (contact - depth) * median_edge,
            loose: 0.0,
        }
    }

    /// Takes a distance (units of the sheet) by which pieces may be elsewhere than they are placed, because the sheet does
    /// not quite close.
    pub(super) fn loosely(self, loose: f64) -> Self {
        Self { loose, ..self }
    }

    /// Returns the depth up to which an overlap of two pieces is contact, if a tear has moved them by `torn` at most.
    pub(super) fn of(&self, pieces: &Pieces, pair: [u32; 2], torn: f64) -> Allowed {
        let size = pieces.smaller_size(pair);
        Allowed {
            within: self.depth.min(CROSSING_DEPTH_RATIO * size),
            loose: self.loose,
            shift: self.rounding.min(MAX_ROUNDING_RATIO * size) + torn,
        }
    }

    /// Returns the depth that counts as a crossing of faces that are not small, in a sheet without rounding.
    pub(super) fn base(&self) -> f64 {
        self.depth
    }

    /// Returns the largest depth up to which an overlap of any pieces is contact, units of the sheet.
    pub(super) fn largest(&self) -> f64 {
        self.depth + self.rounding
    }
}

/// A convex part of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) face: FaceId,
    /// Range of the list of corners that belongs to this piece.
    start: u32,
    end: u32,
}

impl Piece {
    pub(super) fn corners(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// A side that one piece shares with another.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Joint {
    pub(super) piece: u32,
    /// Positions of the side's ends in the list of corners.
    ends: [u32; 2],
}

/// The convex pieces of a pattern's faces: of all faces, or of those requested so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Pieces {
    pub(super) list: Vec<Piece>,
    /// Vertex of each corner (`vertices`), and its position in the flat sheet (`flat`).
    pub(super) vertices: Vec<VertexId>,
    pub(super) flat: Vec<Vector2<f64>>,
    /// For each face its range of `list`: first piece and one past the last; `[0, 0]` if the face was not requested.
    of_faces: Vec<[u32; 2]>,
    /// For each piece the length of the shortest edge of its face, or the least width of the face or of the piece, whichever
    /// is least.
    sizes: Vec<f64>,
    joints: Vec<Joint>,
    /// For each piece its range of `joints`, once `join` has found them.
    joints_of: Vec<Option<[u32; 2]>>,
    /// The plates of which the pieces are parts; `None` for pieces without a thickness.
    plates: Option<Arc<Plates>>,
    /// For each piece of plates its solid.
    solids: Vec<Solid>,
    /// For each piece of plates its range of a list of the points of all solids.
    hulls: Vec<[u32; 2]>,
}

impl Pieces {
    /// Cuts all faces and finds the sides that the pieces share. With plates, cuts these. Cost: O(faces).
    pub(super) fn new(pattern: &CreasePattern, plates: Option<&Arc<Plates>>) -> Self {
        let mut pieces = Self::none(pattern, plates);
        for face in (0..pattern.faces().len()).map(FaceId::new) {
            pieces.load(pattern, face);
        }
        for piece in (0..).take(pieces.list.len()) {
            pieces.join(pattern, piece);
        }
        pieces
    }

    /// Returns the faces of two pieces if they are different.
    pub(super) fn comparable(&self, a: u32, b: u32) -> Option<[FaceId; 2]> {
        let [a, b] = [a, b].map(|piece| self.list[piece as usize].face);
        (a != b).then_some([a, b])
    }

    /// Returns an empty list, to which `load` adds the pieces of a face or a plate on request.
    pub(super) fn none(pattern: &CreasePattern, plates: Option<&Arc<Plates>>) -> Self {
        Self {
            of_faces: vec![[0; 2]; pattern.faces().len()],
            plates: plates.cloned(),
            ..Self::default()
        }
    }

    /// Returns the pieces of a face, and cuts the face if this has not been done yet. The pieces of a plate are those of the
    /// face that names it.
    pub(super) fn load(&mut self, pattern: &CreasePattern, face: FaceId) -> Range<u32> {
        let plates = self.plates.clone();
        let plate = plates
            .as_ref()
            .map(|plates| (plates, &plates.list[plates.of_face[face.index()]]));
        let face = plate.map_or(face, |(_, plate)| plate.faces[0]);
        if self.of_faces[face.index()] == [0; 2] {
            let start = self.list.len();
            let cycle = plate.map_or(&pattern.faces()[face.index()], |(_, plate)| {
                &plate.corners[..]
            });
            let size = size(pattern, cycle);
            let parts = plate.map_or_else(
                || convex_parts(pattern, face),
                |(_, plate)| plate.parts.clone(),
            );
            for part in parts {
                self.add(pattern, face, &part);
                let corners = self.list[self.list.len() - 1].corners();
                self.sizes.push(size.min(least_width(&self.flat[corners])));
                if let Some((plates, plate)) = plate {
                    self.add_solid(Solid::new(pattern, plates, plate, &part), plates);
                }
            }
            let range = [start, self.list.len()];
            self.of_faces[face.index()] = range.map(|n| FaceId::new(n).0);
        }
        let [start, end] = self.of_faces[face.index()];
        start..end
    }

    /// Adds the solid of the last piece. No overlap is contact that is deeper than a part of the thickness.
    fn add_solid(&mut self, solid: Solid, plates: &Plates) {
        let start = self.hulls.last().map_or(0, |[_, end]| *end);
        let end = start as usize + solid.points.len();
        self.hulls.push([start, FaceId::new(end).0]);
        self.solids.push(solid);
        if let Some(size) = self.sizes.last_mut() {
            *size = size.min(plates.options.thickness);
        }
    }

    /// Returns the largest distance of a point of a piece from the plane of its face.
    pub(super) fn height(&self) -> f64 {
        self.plates.as_ref().map_or(0.0, |plates| plates.reach())
    }

    /// Returns the thickness of plates; 0 for pieces without one.
    pub(super) fn thickness(&self) -> f64 {
        let plates = self.plates.as_ref();
        plates.map_or(0.0, |plates| plates.options.thickness)
    }

    /// Returns the largest distance of a point that moves with a face from that face: plates of several faces move with one of
    /// them.
    pub(super) fn beyond(&self) -> f64 {
        let Some(plates) = self.plates.as_ref().filter(|plates| !plates.are_faces()) else {
            return self.height();
        };
        let across = plates.list.iter().map(|plate| plate.width());
        self.height() + across.fold(0.0, f64::max)
    }

    /// Returns `true` for the pieces of plates.
    pub(super) fn are_solid(&self) -> bool {
        self.plates.is_some()
    }

    /// Returns the solid of a piece, if it is a part of a plate.
    pub(super) fn solid(&self, piece: u32) -> Option<&Solid> {
        self.solids.get(piece as usize)
    }

    /// Returns the range of a piece in a list of the points that span all pieces: their corners, or the points of solids.
    pub(super) fn hull(&self, piece: u32) -> Range<usize> {
        match self.hulls.get(piece as usize) {
            Some(&[start, end]) => start as usize..end as usize,
            None => self.list[piece as usize].corners(),
        }
    }

    /// Returns the number of points that span all pieces.
    pub(super) fn hull_points(&self) -> usize {
        self.hulls
            .last()
            .map_or(self.flat.len(), |[_, end]| *end as usize)
    }

    /// Places the points that span a piece, in their order.
    pub(super) fn place(&self, piece: u32, pose: &Pose, mut put: impl FnMut(Vector3<f64>)) {
        match self.solid(piece) {
            Some(solid) => solid.points.iter().for_each(|point| put(pose.carry(point))),
            None => {
                let corners = &self.flat[self.list[piece as usize].corners()];
                corners.iter().for_each(|corner| put(pose.apply(*corner)));
            }
        }
    }

    /// Returns an edge between two pieces of plates from which both stay as far back as its angles ask, if there is one: while
    /// they turn about it, they lie on their sides of the plane that halves the angle between them. Returns the edges inside
    /// the two plates as well, at which the sheet may be torn.
    pub(super) fn keeps_back(
        &self,
        pattern: &CreasePattern,
        pair: [u32; 2],
    ) -> Option<(EdgeId, Vec<EdgeId>)> {
        let plates = self.plates.as_ref()?;
        let [plate, other] = pair
            .map(|piece| self.list[piece as usize].face)
            .map(|face| plates.of_face[face.index()]);
        let slack = KEPT_BACK_RATIO * CROSSING_DEPTH_EDGES * pattern.median_edge();
        let keeps_back = |edge: &EdgeId| {
            let Edge { ends, .. } = *pattern.edge(*edge);
            let tangents = plates.tangents(*edge);
            pair.into_iter().all(|piece| {
                let back = [ends[1], ends[0]];
                // `has_side` looks for a side in the opposite direction.
                let line = [ends, back]
                    .into_iter()
                    .find(|line| self.has_side(piece, [line[1], line[0]]));
                line.is_some_and(|line| {
                    let line = line.map(|end| pattern.vertices()[end.index()]);
                    self.solids[piece as usize].keeps_back(line, tangents, slack)
                })
            })
        };
        let between = |edge: &&EdgeId| {
            let faces = pattern.edge(**edge).inner_faces();
            let plates = faces.map(|faces| faces.map(|face| plates.of_face[face.index()]));
            plates == Some([plate, other]) || plates == Some([other, plate])
        };
        let sides = plates.list[plate].sides.iter();
        let hinge = sides
            .filter(between)
            .copied()
            .find(|edge| keeps_back(edge))?;
        let inside = [plate, other].map(|plate| plates.list[plate].edges_inside(pattern));
        Some((hinge, inside.concat()))
    }

    /// Returns the size of the smaller of the faces of two pieces.
    pub(super) fn smaller_size(&self, pair: [u32; 2]) -> f64 {
        let [a, b] = pair.map(|piece| self.sizes[piece as usize]);
        a.min(b)
    }

    fn add(&mut self, pattern: &CreasePattern, face: FaceId, piece: &[VertexId]) {
        let start = self.vertices.len();
        self.vertices.extend(piece);
        let flat = piece.iter().map(|v| pattern.vertices()[v.index()]);
        self.flat.extend(flat);
        let [start, end] = [start, self.vertices.len()].map(|n| VertexId::new(n).0);
        self.list.push(Piece { face, start, end });
        self.joints_of.push(None);
    }

    /// Finds the sides that a piece shares with others. Faces of the others are cut if this has not been done yet.
    pub(super) fn join(&mut self, pattern: &CreasePattern, piece: u32) {
        if self.joints_of[piece as usize].is_some() {
            return;
        }
        let first = self.joints.len();
        let Piece {
            face, start, end, ..
        } = self.list[piece as usize];
        let around = |face: &FaceId| &pattern.neighbours()[face.index()];
        let neighbours = match &self.plates {
            Some(plates) => {
                let faces = &plates.list[plates.of_face[face.index()]].faces;
                faces.iter().flat_map(around).copied().collect()
            }
            None => around(&face).to_vec(),
        };
        for from in start..end {
            let ends = [from, if from + 1 == end { start } else { from + 1 }];
            let side = ends.map(|corner| self.vertices[corner as usize]);
            let inner = self
                .load(pattern, face)
                .find(|&other| self.has_side(other, side));
            let joined = inner.or_else(|| {
                neighbours.iter().find_map(|&(beyond, edge)| {
                    let ends = pattern.edge(edge).ends;
                    if !side.iter().all(|end| ends.contains(end)) {
                        return None;
                    }
                    let mut pieces = self.load(pattern, beyond);
                    pieces.find(|&other| self.has_side(other, side))
                })
            });
            self.joints
                .extend(joined.map(|piece| Joint { piece, ends }));
        }
        let range = [first, self.joints.len()].map(|n| FaceId::new(n).0);
        self.joints_of[piece as usize] = Some(range);
    }

    /// Returns `true` if the piece has a side from the second of the vertices to the first.
    fn has_side(&self, piece: u32, [to, from]: [VertexId; 2]) -> bool {
        let corners = &self.vertices[self.list[piece as usize].corners()];
        let next = corners.iter().cycle().skip(1);
        corners
            .iter()
            .zip(next)
            .any(|(a, b)| [*a, *b] == [from, to])
    }

    /// Returns the sides that a piece shares with others, as found by `join`.
    pub(super) fn joints(&self, piece: u32) -> &[Joint] {
        let [first, end] = self.joints_of[piece as usize].unwrap_or_default();
        &self.joints[first as usize..end as usize]
    }

    /// Returns the vertex at a corner of a piece.
    pub(super) fn vertex(&self, piece: u32, corner: u32) -> VertexId {
        self.vertices[self.list[piece as usize].corners()][corner as usize]
    }

    /// Returns the positions of the corners of two pieces at each vertex that they share.
    pub(super) fn shared(&self, a: u32, b: u32) -> Vec<[u32; 2]> {
        let corners = |piece: u32| {
            let corners = self.list[piece as usize].corners();
            (0..).zip(&self.vertices[corners])
        };
        let both = corners(a).flat_map(|(k, v)| {
            let same = corners(b).filter(move |(_, w)| v == *w);
            same.map(move |(l, _)| [k, l])
        });
        both.collect()
    }

    /// Returns the number of pairs of pieces.
    pub(super) fn pairs(&self) -> u64 {
        let count = self.list.len() as u64;
        count * count.saturating_sub(1) / 2
    }

    /// Returns the pairs of pieces that share a side, each once. All pieces have to be cut and joined.
    pub(super) fn joined_pairs(&self) -> Vec<[u32; 2]> {
        // Two faces may share several collinear sides.
        let mut joined: Vec<[u32; 2]> = (0..)
            .take(self.list.len())
            .flat_map(|a| self.joints(a).iter().map(move |joint| [a, joint.piece]))
            .filter(|[a, b]| a < b)
            .collect();
        joined.sort_unstable();
        joined.dedup();
        joined
    }

    /// Returns the sides that pieces of different faces share, each with the two pieces. All pieces have to be cut and
    /// joined.
    pub(super) fn sides(&self) -> Vec<([u32; 2], Side)> {
        let joined = self.joined_pairs().into_iter();
        let between = joined.filter(|&[a, b]| self.comparable(a, b).is_some());
        let sides = between.filter_map(|pair| {
            let side = Side::of(self, pair, &self.shared(pair[0], pair[1]))?;
            Some((pair, side))
        });
        sides.collect()
    }

    /// Returns `true` if the pieces share a side.
    pub(super) fn joined(&self, a: u32, b: u32) -> bool {
        self.joints(a).iter().any(|joint| joint.piece == b)
    }

    /// Returns the pairs of pieces that [`meet`](Self::meet), each once.
    pub(super) fn touching(&self) -> Vec<[u32; 2]> {
        let mut corners: Vec<_> = (0..)
            .zip(&self.list)
            .flat_map(|(index, piece)| {
                let places = self.flat[piece.corners()].iter();
                // The sum turns -0 into 0, so that equal coordinates have equal bits.
                places.map(move |place| ([place.x + 0.0, place.y + 0.0].map(f64::to_bits), index))
            })
            .collect();
        corners.sort_unstable();
        let places = corners.chunk_by(|a, b| a.0 == b.0);
        let pairs = places.flat_map(|at| {
            let pairs = at.iter().enumerate();
            pairs.flat_map(move |(k, (_, a))| at[k + 1..].iter().map(move |(_, b)| [*a, *b]))
        });
        let mut pairs: Vec<_> = pairs.filter(|[a, b]| a != b).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Returns `true` if the pieces share a point of the flat sheet. Pieces on the two sides of a cut do,
    /// although each has a vertex of its own at that point.
    pub(super) fn meet(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a, b].map(|index| &self.flat[self.list[index as usize].corners()]);
        a.iter().any(|p| b.contains(p))
    }
}

/// The pieces as one configuration places them.
#[derive(Clone, Copy)]
pub(super) struct Placed<'a> {
    pub(super) pieces: &'a Pieces,
    /// Position of each corner in space (`folded`), and unit normal of each piece (`normals`).
    pub(super) folded: &'a [Vector3<f64>],
    pub(super) normals: &'a [Vector3<f64>],
    /// Positions of the points of solids (`hulls`), and poses of their pieces; empty for pieces without a thickness.
    pub(super) hulls: &'a [Vector3<f64>],
    pub(super) poses: &'a [Pose],
}

impl<'a> Placed<'a> {
    /// Returns a solid, if the piece is a part of a plate.
    pub(super) fn solid(&self, index: u32) -> Option<PlacedSolid<'a>> {
        let solid = self.pieces.solid(index)?;
        Some(PlacedSolid {
            solid,
            pose: &self.poses[index as usize],
            points: &self.hulls[self.pieces.hull(index)],
        })
    }

    /// Returns both pieces as solids, if they are parts of plates.
    pub(super) fn solids(&self, [a, b]: [u32; 2]) -> Option<[PlacedSolid<'a>; 2]> {
        Some([self.solid(a)?, self.solid(b)?])
    }

    /// Returns `true` if an overlap of two pieces proves that what they are parts of crosses: faces, and solids of which all
    /// facets are known.
    pub(super) fn are_exact(&self, pair: [u32; 2]) -> bool {
        let mut solids = pair
            .into_iter()
            .filter_map(|index| self.pieces.solid(index));
        solids.all(|solid| solid.is_exact)
    }

    /// Returns a depth to which the plates of two pieces that overlap by `depth` are in each other for certain: the largest
    /// width of a ball in both that is found.
    pub(super) fn least_depth(&self, pair: [u32; 2], depth: f64) -> f64 {
        let (Some([a, b]), Some(plates)) = (self.solids(pair), &self.pieces.plates) else {
            return depth;
        };
        let room = |piece: u32, at: &Vector3<f64>| {
            let face = self.pieces.list[piece as usize].face;
            let pose = &self.poses[piece as usize];
            let at = pose
                .r_wf
                .inverse()
                .rotate(&(at - pose.carry(&Vector3::zeros())));
            plates.room(plates.of_face[face.index()], &at)
        };
        let balls = a.points_in_both(&b, depth).into_iter();
        let widths = balls.map(|at| 2.0 * room(pair[0], &at).min(room(pair[1], &at)));
        widths.fold(0.0, f64::max)
    }

    /// Returns the distance of two pieces; 0 if they overlap.
    pub(super) fn distance(&self, pair: [u32; 2]) -> f64 {
        match self.solids(pair) {
            Some([a, b]) if a.separation(&b) > 0.0 => a.distance(&b),
            Some(_) => 0.0,
            None => distance(&self.piece(pair[0]), &self.piece(pair[1])),
        }
    }

    /// Returns the points that span a piece.
    pub(super) fn hull(&self, index: u32) -> &'a [Vector3<f64>] {
        let points = if self.pieces.are_solid() {
            self.hulls
        } else {
            self.folded
        };
        &points[self.pieces.hull(index)]
    }

    pub(super) fn piece(&self, index: u32) -> ConvexPiece<'a> {
        ConvexPiece {
            corners: &self.folded[self.pieces.list[index as usize].corners()],
            normal: self.normals[index as usize],
        }
    }

    /// Returns the depth to which the pieces cross, alone or together with the pieces joined to them; 0 if they are in
    /// contact at most.
    #[inline]
    pub(super) fn depth(&self, [a, b]: [u32; 2], allowed: Allowed) -> f64 {
        if let Some([a, b]) = self.solids([a, b]) {
            let depth = -a.separation(&b);
            return if depth > allowed.largest() {
                depth
            } else {
                0.0
            };
        }
        let [first, second] = [a, b].map(|index| self.piece(index));
        let tolerance = allowed.within;
        let reach = first.reach(&second, tolerance);
        if reach.is_clear(allowed) {
            return 0.0;
        }
        let reaches = [reach, second.reach(&first, tolerance)];
        if reaches[1].is_clear(allowed) {
            return 0.0;
        }
        let overlap = Overlap::of(&first, &second, reaches, allowed);
        let mut depth = overlap.map_or(0.0, |overlap| overlap.depth(allowed));
        if depth > 0.0 {
            return depth;
        }
        for (on, [piece, other]) in reaches.into_iter().zip([[a, b], [b, a]]) {
            if on.stands(tolerance) {
                depth = depth.max(self.beyond(piece, other, tolerance));
            }
        }
        if depth > allowed.largest() {
            depth
        } else {
            0.0
        }
    }

    /// Returns by how much points of two pieces may approach each other at least until an overlap is no longer contact. The
    /// pieces are apart by a distance or an angle above 0, or else overlap. `turn` bounds the turn until then, radians.
    pub(super) fn left(&self, pair: [u32; 2], apart: f64, turn: f64, allowed: Allowed) -> f64 {
        if self.pieces.are_solid() {
            // The least way that parts solids shrinks by no more than their points approach each other.
            return allowed.largest();
        }
        let [a, b] = pair.map(|index| self.piece(index));
        let lean = Lean::of(&a, &b, turn);
        let reaches = || [a.reach(&b, 0.0), b.reach(&a, 0.0)];
        let overlap = (apart <= 0.0)
            .then(|| Overlap::of(&a, &b, reaches(), Allowed::NOTHING))
            .flatten();
        overlap.map_or(allowed.until_shared(lean), |overlap| {
            let least = MIN_LEFT_RATIO * allowed.across(lean);
            overlap.left(allowed, lean).max(least)
        })
    }

    /// Returns the distance between the positions that two pieces give a vertex that they share, the largest if they share
    /// several; 0 if they share none.
    pub(super) fn torn(&self, pair: [u32; 2]) -> f64 {
        let [first, second] = pair.map(|piece| self.pieces.list[piece as usize].corners());
        let vertices = &self.pieces.vertices;
        let tears = first.flat_map(|a| {
            let same = second.clone().filter(move |&b| vertices[a] == vertices[b]);
            same.map(move |b| (self.folded[a] - self.folded[b]).norm())
        });
        tears.fold(0.0, f64::max)
    }

    /// Returns the depth to which piece `a`, which only touches `b`, passes through it together with a piece
    /// joined to `a`: the sheet may continue beyond `b` across a side of `a`.
    fn beyond(&self, a: u32, b: u32, tolerance: f64) -> f64 {
        let joints = self.pieces.joints(a).iter();
        let depths = joints.filter(|joint| joint.piece != b).map(|joint| {
            let side = joint.ends.map(|end| self.folded[end as usize]);
            let both = [&self.piece(a), &self.piece(joint.piece)];
            side_crossing_depth(both, side, &self.piece(b), tolerance)
        });
        depths.fold(0.0, f64::max)
    }
}
