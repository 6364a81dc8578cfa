//! The cells of a tessellation along a motion: where their faces are, and how long two of them stay apart.

use std::collections::BTreeMap;

use foldpath_core::{HalfAngle, Membership};
use nalgebra::Vector2;

use super::motion::{Motion, Tick};
use super::pieces::Pieces;
use crate::folding::{CellDrift, LatticeMotion, Pose};
use crate::pattern::{CreasePattern, FaceId};
use crate::symmetry::{Lattice, PairClass};

/// A lattice that is folded at one time after the other.
#[derive(Clone, Debug)]
pub(super) struct Cells<'a> {
    pub(super) lattice: &'a Lattice,
    folded: LatticeMotion,
    time: Tick,
    half_angles: Vec<HalfAngle<f64>>,
    /// For ever longer steps from this time, when they end and how far cells can move until then.
    drifts: Vec<(Tick, CellDrift)>,
    offsets: Vec<Offset>,
}

/// A difference of cells, which stands for the opposite one too.
#[derive(Clone, Debug)]
pub(super) struct Offset {
    cell: [i32; 2],
    /// The pairs of faces.
    pub(super) classes: Vec<PairClass>,
    /// Number of their pairs of pieces.
    pub(super) pairs: u64,
}

impl<'a> Cells<'a> {
    /// Cost: O(classes of pairs).
    pub(super) fn new(
        pattern: &CreasePattern,
        memberships: &[Membership],
        groups: usize,
        pieces: &Pieces,
        lattice: &'a Lattice,
    ) -> Self {
        let orbits = lattice.orbits().iter();
        let counts: Vec<_> = orbits
            .map(|orbit| pieces.of(orbit.representative).len() as u64)
            .collect();
        let mut offsets: BTreeMap<[i32; 2], Vec<PairClass>> = BTreeMap::new();
        for class in lattice.pair_classes() {
            let [column, row] = class.offset;
            let back = (row, column) < (0, 0);
            let offset = if back { [-column, -row] } else { [column, row] };
            offsets.entry(offset).or_default().push(class);
        }
        Self {
            lattice,
            folded: LatticeMotion::new(pattern, memberships, lattice),
            time: Tick::MAX,
            half_angles: vec![HalfAngle::default(); groups],
            drifts: Vec::new(),
            offsets: offsets
                .into_iter()
                .map(|(cell, classes)| {
                    let pairs = classes.iter().map(|class| {
                        let [a, b] = class.orbits.map(|orbit| counts[orbit as usize]);
                        a * b
                    });
                    Offset {
                        cell,
                        pairs: pairs.sum(),
                        classes,
                    }
                })
                .collect(),
        }
    }

    /// Forgets where the cells are.
    pub(super) fn forget(&mut self) {
        self.time = Tick::MAX;
    }

    /// Differences of cells.
    pub(super) fn offsets(&self) -> &[Offset] {
        &self.offsets
    }

    fn fold(&mut self, motion: &Motion, time: Tick) {
        if self.time == time {
            return;
        }
        self.time = time;
        self.drifts.clear();
        for (group, half) in self.half_angles.iter_mut().enumerate() {
            *half = motion.half_angle(group, time);
        }
        self.folded.fold(&self.half_angles);
    }

    /// The pose of a face, and the place of the flat sheet that it takes to its point.
    pub(super) fn pose(
        &mut self,
        motion: &Motion,
        time: Tick,
        face: FaceId,
    ) -> (Pose, Vector2<f64>) {
        self.fold(motion, time);
        let place = self.lattice.place(face);
        let origin = self.lattice.translation(place.cell);
        (self.folded.pose(place.orbit, place.cell), origin)
    }

    /// How far apart two cells are at least.
    pub(super) fn apart(&mut self, motion: &Motion, time: Tick, offset: u32) -> f64 {
        self.fold(motion, time);
        self.folded.gap_of_cells(self.offsets[offset as usize].cell)
    }

    /// The end of a step in which two cells come closer by no more than `allowance`, and by how much they
    /// may: within a factor of two in tabulated times the longest one.
    pub(super) fn until(
        &mut self,
        motion: &Motion,
        time: Tick,
        offset: u32,
        allowance: f64,
    ) -> Option<(Tick, f64)> {
        self.fold(motion, time);
        let offset = self.offsets[offset as usize].cell;
        let mut reached = None;
        for step in 0.. {
            if step == self.drifts.len() {
                let end = motion.tabulated_after(time, 1 << step);
                if self.drifts.last().map_or(time, |(last, _)| *last) == end {
                    break;
                }
                let changes = motion.varied(time, end);
                self.drifts.push((end, self.folded.drift(&changes)));
            }
            let (end, drift) = &self.drifts[step];
            let moved = drift.between(offset);
            if moved > allowance {
                break;
            }
            reached = Some((*end, moved));
        }
        reached
    }
}
