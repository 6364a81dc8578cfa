//! Judges single configurations of a tessellation for crossings, with one pair of faces tested for all that move alike.

use core::ops::Range;
use std::collections::HashMap;

use foldhash::fast::FixedState;
use foldpath_core::Membership;
use nalgebra::Vector3;

use super::pairs::CellPairs;
use crate::collision::motion::Tick;
use crate::collision::pieces::{Contact, Pieces, Placed};
use crate::collision::scene::Crossing;
use crate::collision::sweep::SweepCounts;
use crate::collision::tolerances::{CROSSING_DEPTH_EDGES, MAX_OFFSETS};
use crate::lattice::{Lattice, PairClass};
use crate::pattern::CreasePattern;

/// A tessellation folded into one configuration after the other. It answers the same question as a
/// [`CollisionScene`](crate::collision::CollisionScene), but of all pairs of faces that are placed alike it tests only
/// one.
#[derive(Clone, Debug)]
pub struct LatticeScene<'a> {
    pattern: &'a CreasePattern,
    contact: Contact,
    cells: CellPairs<'a>,
    /// All differences between two cells of the sheet.
    offsets: Vec<[i32; 2]>,
    pieces: Pieces,
    /// Pairs of pieces that share no side, of the pair classes requested so far.
    pairs: Vec<[u32; 2]>,
    /// For each of these classes its range of `pairs`, and the number of its pairs that share a side.
    classes: HashMap<PairClass, (Range<usize>, u64), FixedState>,
    /// Number of pairs of pieces, and number of representative pairs (those for which no other pair stands).
    alike: [u64; 2],
    near: Vec<PairClass>,
    /// Configuration at which each piece was placed last.
    placed: Vec<Tick>,
    counts: SweepCounts,
    folded: Vec<Vector3<f64>>,
    normals: Vec<Vector3<f64>>,
}

impl<'a> LatticeScene<'a> {
    /// Creates the scene of a sheet with the lattice found for these memberships in `groups` crease groups. Returns
    /// `None` if the lattice has too many differences of cells to go through. Cost: O(faces of a cell + cells).
    #[must_use]
    pub fn new(
        pattern: &'a CreasePattern,
        memberships: &[Membership],
        groups: usize,
        lattice: &'a Lattice,
    ) -> Option<Self> {
        let cells = CellPairs::new(pattern, memberships, groups, lattice);
        let [pieces, pairs] = cells.count();
        let all = pieces * pieces.saturating_sub(1) / 2;
        Some(Self {
            pattern,
            contact: Contact::new(pattern.median_edge(), CROSSING_DEPTH_EDGES),
            offsets: lattice.offsets(MAX_OFFSETS)?,
            cells,
            pieces: Pieces::none(pattern),
            pairs: Vec::new(),
            classes: HashMap::default(),
            alike: [all, pairs.min(all)],
            near: Vec::new(),
            placed: Vec::new(),
            counts: SweepCounts::default(),
            folded: Vec::new(),
            normals: Vec::new(),
        })
    }

    /// Returns the deepest crossing at a configuration (group angles, radians), at which the sheet has to close. Its
    /// faces stand for all pairs that are placed alike. Cost: O(cells + pairs of faces near one cell).
    pub fn deepest_crossing(&mut self, angles: &[f64]) -> Option<Crossing> {
        self.cells.go_to(angles);
        let mut near = core::mem::take(&mut self.near);
        near.clear();
        self.cells.touching(&self.offsets, |class| near.push(class));
        let mut deepest: Option<Crossing> = None;
        let (mut tested, mut joined) = (0, 0);
        for &class in &near {
            let (pairs, others) = self.find(class);
            tested += pairs.len() as u64;
            joined += others;
            for index in pairs {
                let pair = self.pairs[index];
                let depth = self.depth(pair);
                let faces = pair.map(|piece| self.pieces.list[piece as usize].face);
                let crossing = Crossing::new(faces, depth);
                if depth > 0.0 && deepest.is_none_or(|deepest| crossing.exceeds(&deepest)) {
                    deepest = Some(crossing);
                }
            }
        }
        self.near = near;
        let [all, alike] = self.alike;
        self.counts.pairs += all;
        self.counts.tested += tested;
        self.counts.skipped_symmetry += all - alike;
        self.counts.skipped_edges += joined;
        self.counts.skipped_bounds += alike.saturating_sub(tested + joined);
        deepest
    }

    /// Returns the numbers of pairs tested and skipped since the scene was made.
    #[must_use]
    pub fn counts(&self) -> SweepCounts {
        self.counts
    }

    /// Returns the range of a class in the list of pairs, and the number of its pairs that share a side.
    fn find(&mut self, class: PairClass) -> (Range<usize>, u64) {
        if let Some(found) = self.classes.get(&class) {
            return found.clone();
        }
        let (start, mut joined) = (self.pairs.len(), 0);
        if let Some(faces) = self.cells.lattice.pair_of(class) {
            let [first, second] = faces.map(|face| self.pieces.load(self.pattern, face));
            for a in first {
                self.pieces.join(self.pattern, a);
                for b in second.clone() {
                    self.pieces.join(self.pattern, b);
                    if self.pieces.joined(a, b) {
                        joined += 1;
                    } else {
                        self.pairs.push([a, b]);
                    }
                }
            }
        }
        let found = (start..self.pairs.len(), joined);
        self.classes.insert(class, found.clone());
        found
    }

    /// Returns the depth to which two pieces cross.
    fn depth(&mut self, pair: [u32; 2]) -> f64 {
        for piece in pair {
            self.put(piece);
        }
        let tolerance = self.contact.depth(&self.pieces, pair);
        let (depth, stands) = self.placed().depth_alone(pair, tolerance);
        if depth > 0.0 {
            return depth;
        }
        for (piece, _) in pair.into_iter().zip(stands).filter(|(_, stands)| *stands) {
            for index in 0..self.pieces.joints(piece).len() {
                self.put(self.pieces.joints(piece)[index].piece);
            }
        }
        self.placed().depth_beyond(pair, stands, tolerance)
    }

    fn placed(&self) -> Placed<'_> {
        Placed {
            pieces: &self.pieces,
            folded: &self.folded,
            normals: &self.normals,
        }
    }

    /// Places a piece at the current configuration.
    fn put(&mut self, piece: u32) {
        let pieces = &self.pieces;
        self.placed.resize(pieces.list.len(), Tick::MAX);
        let placed = &mut self.placed[piece as usize];
        if *placed == self.cells.time() {
            return;
        }
        *placed = self.cells.time();
        self.normals.resize(pieces.list.len(), Vector3::zeros());
        self.folded.resize(pieces.flat.len(), Vector3::zeros());
        let part = pieces.list[piece as usize];
        let (pose, origin) = self.cells.pose_here(part.face);
        self.normals[piece as usize] = pose.r_wf.rotate(&Vector3::z());
        for corner in part.corners() {
            self.folded[corner] = pose.apply(pieces.flat[corner] - origin);
        }
    }
}
