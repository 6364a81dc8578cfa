//! Faces that pass through each other in single configurations of a tessellation.

use std::collections::HashMap;

use foldpath_core::{HalfAngle, Membership};
use nalgebra::Vector3;

use super::cells::Cells;
use super::crossing::depth_within;
use super::motion::Tick;
use super::pieces::{CROSSING, Pieces, Placed};
use super::scene::Crossing;
use super::sweep::SweepCounts;
use crate::pattern::CreasePattern;
use crate::symmetry::{Lattice, PairClass};

/// A tessellation folded at one configuration after the other: what a [`CollisionScene`](super::CollisionScene) is
/// for any sheet, but of all pairs of faces that are alike only one is looked at.
#[derive(Clone, Debug)]
pub struct LatticeScene<'a> {
    pattern: &'a CreasePattern,
    /// What is no deeper is contact.
    tolerance: f64,
    cells: Cells<'a>,
    /// All differences of cells.
    differences: Vec<[i32; 2]>,
    half_angles: Vec<HalfAngle<f64>>,
    pieces: Pieces,
    /// For each class that was asked for, pairs of pieces that no side joins, and the number of others.
    pairs: HashMap<PairClass, (Vec<[u32; 2]>, u64)>,
    near: Vec<PairClass>,
    /// When each piece was placed.
    placed: Vec<Tick>,
    counts: SweepCounts,
    folded: Vec<Vector3<f64>>,
    normals: Vec<Vector3<f64>>,
}

impl<'a> LatticeScene<'a> {
    /// The scene of a sheet with the lattice found for these memberships in so many groups. `None` if that has too
    /// many cells to go through. Cost: O(faces of a cell + cells).
    #[must_use]
    pub fn new(
        pattern: &'a CreasePattern,
        memberships: &[Membership],
        groups: usize,
        lattice: &'a Lattice,
    ) -> Option<Self> {
        let mut cells = Cells::new(pattern, memberships, groups, lattice);
        Some(Self {
            pattern,
            tolerance: CROSSING * pattern.median_edge(),
            differences: cells.all()?,
            cells,
            half_angles: Vec::new(),
            pieces: Pieces::none(pattern),
            pairs: HashMap::new(),
            near: Vec::new(),
            placed: Vec::new(),
            counts: SweepCounts::default(),
            folded: Vec::new(),
            normals: Vec::new(),
        })
    }

    /// The deepest crossing at a configuration (group angles, radians), at which the sheet has to close; of faces that
    /// stand for all that are placed alike. Cost: O(cells + pairs of faces near one cell).
    pub fn deepest_crossing(&mut self, angles: &[f64]) -> Option<Crossing> {
        self.half_angles.clear();
        let half_angles = angles.iter().map(|&angle| HalfAngle::of(angle));
        self.half_angles.extend(half_angles);
        self.cells.go_to(&self.half_angles);
        let mut near = core::mem::take(&mut self.near);
        near.clear();
        self.cells
            .touching(&self.differences, |class| near.push(class));
        let mut deepest: Option<Crossing> = None;
        let (mut tested, mut joined) = (0, 0);
        for &class in &near {
            self.find(class);
            let (count, others) = self
                .pairs
                .get(&class)
                .map_or((0, 0), |(pairs, others)| (pairs.len(), *others));
            tested += count as u64;
            joined += others;
            for index in 0..count {
                let pair = self.pairs[&class].0[index];
                let depth = self.depth(pair);
                let crossing = Crossing::new(
                    pair.map(|piece| self.pieces.list[piece as usize].face),
                    depth,
                );
                if depth > 0.0 && deepest.is_none_or(|deepest| crossing.exceeds(&deepest)) {
                    deepest = Some(crossing);
                }
            }
        }
        self.near = near;
        let [pieces, pairs] = self.cells.count();
        let alike = pieces * pieces.saturating_sub(1) / 2;
        let pairs = pairs.min(alike);
        self.counts.pairs += alike;
        self.counts.tested += tested;
        self.counts.skipped_symmetry += alike - pairs;
        self.counts.skipped_edges += joined;
        self.counts.skipped_bounds += pairs.saturating_sub(tested + joined);
        deepest
    }

    /// What was looked at since the scene was made.
    #[must_use]
    pub fn counts(&self) -> SweepCounts {
        self.counts
    }

    /// Finds the pairs of a class, once.
    fn find(&mut self, class: PairClass) {
        if self.pairs.contains_key(&class) {
            return;
        }
        let (mut pairs, mut joined) = (Vec::new(), 0);
        if let Some(faces) = self.cells.lattice.pair_of(class) {
            let [first, second] = faces.map(|face| self.pieces.load(self.pattern, face));
            for a in first {
                self.pieces.join(self.pattern, a);
                for b in second.clone() {
                    self.pieces.join(self.pattern, b);
                    if self.pieces.joined(a, b) {
                        joined += 1;
                    } else {
                        pairs.push([a, b]);
                    }
                }
            }
        }
        self.pairs.insert(class, (pairs, joined));
    }

    /// How deep two pieces cross.
    fn depth(&mut self, [a, b]: [u32; 2]) -> f64 {
        let tolerance = self.tolerance;
        for piece in [a, b] {
            self.put(piece);
        }
        let placed = self.placed();
        let [first, second] = [a, b].map(|piece| placed.piece(piece));
        let reaches = [
            first.reach(&second, tolerance),
            second.reach(&first, tolerance),
        ];
        let depth = depth_within(&first, &second, reaches, tolerance);
        if depth > 0.0 || !reaches.iter().any(|reach| reach.stands(tolerance)) {
            return depth;
        }
        for piece in [a, b] {
            for index in 0..self.pieces.joints(piece).len() {
                self.put(self.pieces.joints(piece)[index].piece);
            }
        }
        self.placed().depth(a, b, tolerance)
    }

    fn placed(&self) -> Placed<'_> {
        Placed {
            pieces: &self.pieces,
            folded: &self.folded,
            normals: &self.normals,
        }
    }

    /// Puts a piece in its place.
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
