//! The faces of a sheet cut in convex pieces, and how deep two of them cross where they are placed.

use core::ops::Range;

use nalgebra::{Vector2, Vector3};

use super::crossing::{ConvexPiece, depth_within, side_crossing_depth};
use crate::pattern::{CreasePattern, FaceId, VertexId};

/// A crossing deeper than this part of the median edge counts; what is less is contact.
pub(super) const CROSSING: f64 = 1e-6;
/// Times its gap that faces may be off which meet nowhere: gaps add up along the way from one to the other.
const FARTHER: f64 = 10.0;
/// The most (over the median edge) that rounded coordinates are taken to leave.
const ROUNDED: f64 = 1e-3;

/// How much deeper (over the median edge) than others faces that meet nowhere may cross in a sheet torn by a gap, in units
/// of the median edge, too: as far as it may be one of rounded coordinates, they lie elsewhere if it is folded from another
/// face.
#[must_use]
pub fn rounding(gap: f64) -> f64 {
    if gap.is_nan() {
        return 0.0;
    }
    (FARTHER * gap).min(ROUNDED)
}

/// A convex part of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) face: FaceId,
    pub(super) sheet: u32,
    /// The part of the list of corners that is this piece's.
    start: u32,
    end: u32,
}

impl Piece {
    pub(super) fn corners(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// A side that a piece shares with another.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Joint {
    pub(super) piece: u32,
    /// Positions in the list of corners.
    ends: [u32; 2],
}

/// The convex pieces of the faces of a pattern, of all or of those that were asked for.
#[derive(Clone, Debug)]
pub(super) struct Pieces {
    pub(super) list: Vec<Piece>,
    /// For each corner its vertex, and its place in the flat sheet.
    pub(super) vertices: Vec<VertexId>,
    pub(super) flat: Vec<Vector2<f64>>,
    /// For each face its first piece and that behind its last; both 0 for those not asked for.
    of_faces: Vec<[u32; 2]>,
    joints: Vec<Joint>,
    /// For each piece its part of the list of joints, once it was asked for.
    joints_of: Vec<Option<[u32; 2]>>,
}

impl Pieces {
    /// Those of all faces, and what joins them. Cost: O(faces).
    pub(super) fn new(pattern: &CreasePattern) -> Self {
        let mut pieces = Self::none(pattern);
        for face in (0..pattern.faces().len()).map(FaceId::new) {
            pieces.load(pattern, face);
        }
        for piece in (0..).take(pieces.list.len()) {
            pieces.join(pattern, piece);
        }
        pieces
    }

    /// The faces of two pieces, if they are different ones of the same sheet.
    pub(super) fn comparable(&self, a: u32, b: u32) -> Option<[FaceId; 2]> {
        let [a, b] = [a, b].map(|piece| self.list[piece as usize]);
        (a.sheet == b.sheet && a.face != b.face).then_some([a.face, b.face])
    }

    /// Those of no face yet.
    pub(super) fn none(pattern: &CreasePattern) -> Self {
        Self {
            list: Vec::new(),
            vertices: Vec::new(),
            flat: Vec::new(),
            of_faces: vec![[0; 2]; pattern.faces().len()],
            joints: Vec::new(),
            joints_of: Vec::new(),
        }
    }

    /// The pieces of a face, made if they are not yet there.
    pub(super) fn load(&mut self, pattern: &CreasePattern, face: FaceId) -> Range<u32> {
        if self.of_faces[face.index()] == [0; 2] {
            let start = self.list.len();
            let cycle = &pattern.faces()[face.index()];
            if is_convex(pattern, cycle) {
                self.add(pattern, face, cycle);
            } else {
                for triangle in &pattern.triangles()[face.index()] {
                    self.add(pattern, face, triangle);
                }
            }
            let range = [start, self.list.len()];
            self.of_faces[face.index()] = range.map(|n| FaceId::new(n).0);
        }
        let [start, end] = self.of_faces[face.index()];
        start..end
    }

    fn add(&mut self, pattern: &CreasePattern, face: FaceId, piece: &[VertexId]) {
        let start = self.vertices.len();
        self.vertices.extend(piece);
        let flat = piece.iter().map(|v| pattern.vertices()[v.index()]);
        self.flat.extend(flat);
        let [start, end] = [start, self.vertices.len()].map(|n| VertexId::new(n).0);
        self.list.push(Piece {
            face,
            sheet: pattern.sheet_of_faces()[face.index()],
            start,
            end,
        });
        self.joints_of.push(None);
    }

    /// Finds the sides that a piece shares with others, which are made if they are not yet there.
    pub(super) fn join(&mut self, pattern: &CreasePattern, piece: u32) {
        if self.joints_of[piece as usize].is_some() {
            return;
        }
        let first = self.joints.len();
        let Piece {
            face, start, end, ..
        } = self.list[piece as usize];
        for from in start..end {
            let ends = [from, if from + 1 == end { start } else { from + 1 }];
            let side = ends.map(|corner| self.vertices[corner as usize]);
            let inner = self
                .load(pattern, face)
                .find(|&other| self.has_side(other, side));
            let joined = inner.or_else(|| {
                let mut neighbours = pattern.neighbours()[face.index()].iter();
                neighbours.find_map(|&(beyond, edge)| {
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

    /// Whether a piece has the side from the second vertex to the first.
    fn has_side(&self, piece: u32, [to, from]: [VertexId; 2]) -> bool {
        let corners = &self.vertices[self.list[piece as usize].corners()];
        let next = corners.iter().cycle().skip(1);
        corners
            .iter()
            .zip(next)
            .any(|(a, b)| [*a, *b] == [from, to])
    }

    /// The sides that a piece shares with others, once they were found.
    pub(super) fn joints(&self, piece: u32) -> &[Joint] {
        let [first, end] = self.joints_of[piece as usize].unwrap_or_default();
        &self.joints[first as usize..end as usize]
    }

    /// Number of pairs of pieces of the same sheet.
    pub(super) fn pairs(&self, sheets: usize) -> u64 {
        let mut in_sheet = vec![0_u64; sheets];
        for piece in &self.list {
            in_sheet[piece.sheet as usize] += 1;
        }
        in_sheet.iter().map(|n| n * n.saturating_sub(1) / 2).sum()
    }

    /// How many of them a side joins, where all are there.
    pub(super) fn joined_pairs(&self) -> u64 {
        // Two faces may share several sides in a line.
        let mut joined: Vec<(u32, u32)> = (0..)
            .take(self.list.len())
            .flat_map(|a| self.joints(a).iter().map(move |joint| (a, joint.piece)))
            .filter(|(a, b)| a < b)
            .collect();
        joined.sort_unstable();
        joined.dedup();
        joined.len() as u64
    }

    /// Whether a side joins the pieces.
    pub(super) fn joined(&self, a: u32, b: u32) -> bool {
        self.joints(a).iter().any(|joint| joint.piece == b)
    }

    /// Pairs of pieces of the same sheet that [`meet`](Self::meet), each once.
    pub(super) fn touching(&self) -> Vec<[u32; 2]> {
        let mut corners: Vec<_> = (0..)
            .zip(&self.list)
            .flat_map(|(index, piece)| {
                let places = self.flat[piece.corners()].iter();
                // -0 is 0.
                places.map(move |place| ([place.x + 0.0, place.y + 0.0].map(f64::to_bits), index))
            })
            .collect();
        corners.sort_unstable();
        let places = corners.chunk_by(|a, b| a.0 == b.0);
        let pairs = places.flat_map(|at| {
            let pairs = at.iter().enumerate();
            pairs.flat_map(move |(k, (_, a))| at[k + 1..].iter().map(move |(_, b)| [*a, *b]))
        });
        let sheet = |piece: u32| self.list[piece as usize].sheet;
        let same = |[a, b]: &[u32; 2]| a != b && sheet(*a) == sheet(*b);
        let mut pairs: Vec<_> = pairs.filter(same).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Whether the pieces meet in a place of the flat sheet. Those on the two sides of a cut do, although
    /// each has a vertex of its own there.
    pub(super) fn meet(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a, b].map(|index| &self.flat[self.list[index as usize].corners()]);
        a.iter().any(|p| b.contains(p))
    }
}

/// Number of convex pieces that a face is cut in.
pub(super) fn count(pattern: &CreasePattern, face: FaceId) -> usize {
    let whole = is_convex(pattern, &pattern.faces()[face.index()]);
    if whole {
        1
    } else {
        pattern.triangles()[face.index()].len()
    }
}

/// Pieces where a configuration puts them.
#[derive(Clone, Copy)]
pub(super) struct Placed<'a> {
    pub(super) pieces: &'a Pieces,
    /// For each corner its place.
    pub(super) folded: &'a [Vector3<f64>],
    pub(super) normals: &'a [Vector3<f64>],
}

impl<'a> Placed<'a> {
    pub(super) fn piece(&self, index: u32) -> ConvexPiece<'a> {
        ConvexPiece {
            corners: &self.folded[self.pieces.list[index as usize].corners()],
            normal: self.normals[index as usize],
        }
    }

    /// How deep the pieces cross, alone or with those joined to them; 0 for no deeper than `tolerance`.
    pub(super) fn depth(&self, a: u32, b: u32, tolerance: f64) -> f64 {
        let (depth, stands) = self.depth_alone([a, b], tolerance);
        if depth > 0.0 {
            return depth;
        }
        self.depth_beyond([a, b], stands, tolerance)
    }

    /// How deep the pieces cross without those joined to them; if not at all, which of them may go on to the other side.
    #[inline]
    pub(super) fn depth_alone(&self, pair: [u32; 2], tolerance: f64) -> (f64, [bool; 2]) {
        let [first, second] = pair.map(|index| self.piece(index));
        let reach = first.reach(&second, tolerance);
        if reach.is_clear(tolerance) {
            return (0.0, [false; 2]);
        }
        let reaches = [reach, second.reach(&first, tolerance)];
        if reaches[1].is_clear(tolerance) {
            return (0.0, [false; 2]);
        }
        let depth = depth_within(&first, &second, reaches, tolerance);
        (depth, reaches.map(|reach| reach.stands(tolerance)))
    }

    /// How deep those joined to the pieces that stand on the other cross it.
    #[inline]
    pub(super) fn depth_beyond(
        &self,
        [a, b]: [u32; 2],
        [on_second, on_first]: [bool; 2],
        tolerance: f64,
    ) -> f64 {
        let mut depth = 0.0_f64;
        if on_second {
            depth = depth.max(self.beyond(a, b, tolerance));
        }
        if on_first {
            depth = depth.max(self.beyond(b, a, tolerance));
        }
        depth
    }

    /// A piece that only touches another may go on beyond it across one of its sides.
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

fn is_convex(pattern: &CreasePattern, cycle: &[VertexId]) -> bool {
    let point = |k: usize| pattern.vertices()[cycle[k % cycle.len()].index()];
    (0..cycle.len()).all(|k| {
        let (a, b, c) = (point(k), point(k + 1), point(k + 2));
        let turn = (b - a).perp(&(c - b));
        // Straight corners, as on the sides of waterbomb units, are convex.
        turn >= -1e-12 * (b - a).norm() * (c - b).norm()
    })
}
