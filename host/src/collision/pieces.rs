//! The faces of a sheet cut in convex pieces, and how deep two of them cross where they are placed.

use nalgebra::{Vector2, Vector3};

use super::crossing::{ConvexPiece, crossing_depth, side_crossing_depth};
use crate::pattern::{CreasePattern, FaceId, VertexId};
use crate::ragged::Ragged;

/// A crossing deeper than this part of the median edge counts; what is less is contact.
pub(super) const CROSSING: f64 = 1e-6;

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
    pub(super) fn corners(self) -> core::ops::Range<usize> {
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

/// The convex pieces of all faces of a pattern.
#[derive(Clone, Debug)]
pub(super) struct Pieces {
    pub(super) list: Vec<Piece>,
    /// For each corner its vertex, and its place in the flat sheet.
    pub(super) vertices: Vec<VertexId>,
    pub(super) flat: Vec<Vector2<f64>>,
    pub(super) joints: Ragged<Joint>,
}

impl Pieces {
    /// Cost: O(faces).
    pub(super) fn new(pattern: &CreasePattern) -> Self {
        let mut vertices: Vec<VertexId> = Vec::new();
        let mut list = Vec::new();
        let mut add = |face: usize, piece: &[VertexId]| {
            let start = vertices.len();
            vertices.extend(piece);
            let id = |n: usize| VertexId::new(n).0;
            list.push(Piece {
                face: FaceId::new(face),
                sheet: pattern.sheet_of_faces()[face],
                start: id(start),
                end: id(vertices.len()),
            });
        };
        for (face, cycle) in pattern.faces().iter().enumerate() {
            if is_convex(pattern, cycle) {
                add(face, cycle);
            } else {
                for triangle in &pattern.triangles()[face] {
                    add(face, triangle);
                }
            }
        }
        let flat = vertices.iter().map(|v| pattern.vertices()[v.index()]);
        Self {
            flat: flat.collect(),
            joints: joints(&list, &vertices),
            list,
            vertices,
        }
    }

    /// Pairs of pieces of the same sheet, and how many of them a side joins.
    pub(super) fn count_pairs(&self, sheets: usize) -> [u64; 2] {
        // Two faces may share several sides in a line.
        let mut joined: Vec<(u32, u32)> = (0..)
            .zip(self.joints.iter())
            .flat_map(|(a, list)| list.iter().map(move |joint| (a, joint.piece)))
            .filter(|(a, b)| a < b)
            .collect();
        joined.sort_unstable();
        joined.dedup();
        let mut in_sheet = vec![0_u64; sheets];
        for piece in &self.list {
            in_sheet[piece.sheet as usize] += 1;
        }
        let alike = in_sheet.iter().map(|n| n * n.saturating_sub(1) / 2);
        [alike.sum(), joined.len() as u64]
    }

    /// The pieces of a face.
    pub(super) fn of(&self, face: FaceId) -> core::ops::Range<u32> {
        let bound = |before: bool| {
            let at = self
                .list
                .partition_point(|piece| piece.face < face || !before && piece.face == face);
            FaceId::new(at).0
        };
        bound(true)..bound(false)
    }

    /// Whether a side joins the pieces.
    pub(super) fn joined(&self, a: u32, b: u32) -> bool {
        self.joints[a as usize].iter().any(|joint| joint.piece == b)
    }

    /// Whether the pieces meet in a place of the flat sheet. Those on the two sides of a cut do, although
    /// each has a vertex of its own there.
    pub(super) fn meet(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a, b].map(|index| &self.flat[self.list[index as usize].corners()]);
        a.iter().any(|p| b.contains(p))
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
        let depth = crossing_depth(&self.piece(a), &self.piece(b), tolerance);
        if depth > 0.0 {
            return depth;
        }
        self.beyond(a, b, tolerance)
            .max(self.beyond(b, a, tolerance))
    }

    /// A piece that only touches another may go on beyond it across one of its sides.
    fn beyond(&self, a: u32, b: u32, tolerance: f64) -> f64 {
        if !self.piece(a).stands_on(&self.piece(b), tolerance) {
            return 0.0;
        }
        let joints = self.pieces.joints[a as usize].iter();
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

/// For each piece, the sides that it shares with others: the other piece, and which of its own corners
/// are the ends of the side.
fn joints(pieces: &[Piece], corners: &[VertexId]) -> Ragged<Joint> {
    let mut sides: Vec<([VertexId; 2], u32, [u32; 2])> = Vec::with_capacity(corners.len());
    for (index, piece) in (0..).zip(pieces) {
        for from in piece.start..piece.end {
            let to = if from + 1 == piece.end {
                piece.start
            } else {
                from + 1
            };
            let [a, b] = [from, to].map(|corner| corners[corner as usize]);
            sides.push(([a.min(b), a.max(b)], index, [from, to]));
        }
    }
    sides.sort_unstable();
    let twins = sides.windows(2).filter(|w| w[0].0 == w[1].0);
    let both: Vec<_> = twins
        .flat_map(|w| {
            let joint = |other: usize, own: usize| Joint {
                piece: w[other].1,
                ends: w[own].2,
            };
            [
                (w[0].1 as usize, joint(1, 0)),
                (w[1].1 as usize, joint(0, 1)),
            ]
        })
        .collect();
    crate::ragged::group_by_key(pieces.len(), &both)
}
