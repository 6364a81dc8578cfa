//! The faces of a sheet as a scene that is asked for crossings at one configuration after another.

use nalgebra::{Vector2, Vector3};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};

use super::crossing::{ConvexPiece, crossing_depth, side_crossing_depth};
use crate::folding::FoldingMap;
use crate::pattern::{CreasePattern, FaceId, VertexId};
use crate::ragged::Ragged;

/// A crossing deeper than this part of the median edge counts; what is less is contact.
const CROSSING: f64 = 1e-6;

/// Two faces that pass through each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The faces, the smaller first.
    pub faces: [FaceId; 2],
    /// How deep, in the units of the sheet.
    pub depth: f64,
}

/// What the search for crossings looked at, and what it did not need to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CollisionCounts {
    /// Pairs of pieces of the same sheet in all configurations asked for; those joined by an edge left
    /// out.
    pub pairs: u64,
    /// Pairs judged.
    pub tested: u64,
    /// Pairs passed over because their bounding boxes do not meet.
    pub skipped_bounds: u64,
}

/// A convex part of a face.
#[derive(Clone, Copy, Debug)]
struct Piece {
    face: FaceId,
    sheet: u32,
    /// The part of the list of corners that is this piece's.
    start: u32,
    end: u32,
}

/// A side that a piece shares with another.
#[derive(Clone, Copy, Debug, Default)]
struct Joint {
    piece: u32,
    /// Positions in the list of corners.
    ends: [u32; 2],
}

/// The faces of a pattern. Those of different sheets are not compared.
#[derive(Clone)]
pub struct CollisionScene {
    pieces: Vec<Piece>,
    flat: Vec<Vector2<f64>>,
    folded: Vec<Vector3<f64>>,
    normals: Vec<Vector3<f64>>,
    joints: Ragged<Joint>,
    /// Pairs of pieces of the same sheet that no side joins.
    pairs: u64,
    hierarchy: Bvh,
    workspace: BvhWorkspace,
    median_edge: f64,
    counts: CollisionCounts,
}

impl CollisionScene {
    /// The scene of a pattern. Cost: O(faces).
    #[must_use]
    pub fn new(pattern: &CreasePattern) -> Self {
        let mut corners: Vec<VertexId> = Vec::new();
        let mut pieces = Vec::new();
        let mut add = |face: usize, piece: &[VertexId]| {
            let start = corners.len();
            corners.extend(piece);
            let id = |n: usize| VertexId::new(n).0;
            pieces.push(Piece {
                face: FaceId::new(face),
                sheet: pattern.sheet_of_faces()[face],
                start: id(start),
                end: id(corners.len()),
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
        let joints = joints(&pieces, &corners);
        // Two faces may share several sides in a line.
        let mut pairs: Vec<(u32, u32)> = (0..)
            .zip(joints.iter())
            .flat_map(|(a, list)| {
                list.iter()
                    .map(move |joint| (a, joint.piece))
                    .filter(|(a, b)| a < b)
            })
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        let mut in_sheet = vec![0_u64; pattern.sheets()];
        for piece in &pieces {
            in_sheet[piece.sheet as usize] += 1;
        }
        let alike = in_sheet.iter().map(|n| n * n.saturating_sub(1) / 2);
        let pairs = alike.sum::<u64>() - pairs.len() as u64;
        let flat: Vec<_> = corners
            .iter()
            .map(|v| pattern.vertices()[v.index()])
            .collect();
        Self {
            folded: flat.iter().map(|p| p.push(0.0)).collect(),
            normals: vec![Vector3::z(); pieces.len()],
            hierarchy: Bvh::new(),
            workspace: BvhWorkspace::default(),
            median_edge: pattern.median_edge(),
            counts: CollisionCounts::default(),
            pieces,
            flat,
            joints,
            pairs,
        }
    }

    /// The deepest crossing under a folding map, if any. Where the map tears the sheet by a `gap`
    /// (over the median edge), faces that meet in a vertex may lie across each other by as much: of
    /// those only what is deeper counts. Cost: about O(faces log faces) while few bounding boxes meet.
    pub fn deepest_crossing(&mut self, map: &FoldingMap, gap: f64) -> Option<Crossing> {
        self.place(map);
        let mut deepest: Option<Crossing> = None;
        let mut tested = 0;
        let Self {
            pieces,
            folded,
            normals,
            joints,
            flat,
            median_edge,
            hierarchy,
            workspace,
            ..
        } = self;
        let tolerance = CROSSING * *median_edge;
        let torn = tolerance + gap * *median_edge;
        let ids = |index: u32| {
            let piece = pieces[index as usize];
            piece.start as usize..piece.end as usize
        };
        let piece = |index: u32| ConvexPiece {
            corners: &folded[ids(index)],
            normal: normals[index as usize],
        };
        // A piece that only touches another may go on beyond it across one of its sides.
        let beyond = |a: u32, b: u32| {
            if !piece(a).stands_on(&piece(b), tolerance) {
                return 0.0;
            }
            let sides = joints[a as usize].iter().filter(|joint| joint.piece != b);
            let depths = sides.map(|joint| {
                let side = joint.ends.map(|end| folded[end as usize]);
                side_crossing_depth([&piece(a), &piece(joint.piece)], side, &piece(b), tolerance)
            });
            depths.fold(0.0, f64::max)
        };
        hierarchy.traverse_bvtt_single_tree::<false>(workspace, &mut |a, b| {
            let faces = [a, b].map(|index| pieces[index as usize].face);
            let sheets = [a, b].map(|index| pieces[index as usize].sheet);
            let joined = joints[a as usize].iter().any(|joint| joint.piece == b);
            if joined || faces[0] == faces[1] || sheets[0] != sheets[1] {
                return;
            }
            tested += 1;
            let mut depth = crossing_depth(&piece(a), &piece(b), tolerance);
            if depth <= 0.0 {
                depth = beyond(a, b).max(beyond(b, a));
            }
            // Where the sheet is torn, faces that meet in a vertex may overlap by as much. Those on the
            // two sides of a cut meet at places, where each has a vertex of its own.
            let meet = || flat[ids(a)].iter().any(|p| flat[ids(b)].contains(p));
            if depth <= 0.0 || depth <= torn && meet() {
                return;
            }
            let crossing = Crossing {
                faces: [faces[0].min(faces[1]), faces[0].max(faces[1])],
                depth,
            };
            // Equal depths, as symmetry makes them, are told apart by number, so that the answer
            // does not hang on the order of the search.
            let better = deepest.is_none_or(|d| {
                let order = depth.total_cmp(&d.depth);
                order.then(d.faces.cmp(&crossing.faces)).is_gt()
            });
            if better {
                deepest = Some(crossing);
            }
        });
        self.counts.pairs += self.pairs;
        self.counts.tested += tested;
        self.counts.skipped_bounds += self.pairs - tested;
        deepest
    }

    /// What was looked at since the scene was made.
    #[must_use]
    pub fn counts(&self) -> CollisionCounts {
        self.counts
    }

    /// Moves the pieces to their places and the hierarchy with them.
    fn place(&mut self, map: &FoldingMap) {
        let boxes = self
            .pieces
            .iter()
            .zip(&mut self.normals)
            .map(|(piece, normal)| {
                let pose = &map.poses()[piece.face.index()];
                *normal = pose.r_wf.rotate(&Vector3::z());
                let range = piece.start as usize..piece.end as usize;
                let mut low = Vector3::repeat(f64::INFINITY);
                let mut high = -low;
                for (folded, flat) in self.folded[range.clone()].iter_mut().zip(&self.flat[range]) {
                    *folded = pose.apply(*flat);
                    low = low.inf(folded);
                    high = high.sup(folded);
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
