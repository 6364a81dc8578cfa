//! Pairs of faces that a sweep has to look at: of a whole sheet, or of a lattice, where one pair stands for all that move
//! alike.

mod interval_broad_phase;
mod lattice;
mod sheet;

pub(super) use lattice::LatticePairs;
pub(super) use sheet::SheetPairs;

use core::fmt::Debug;

use super::hierarchy::Hierarchy;
use super::pieces::{Contact, Pieces};
use super::sweep::motion::{Motion, Tick};
use super::sweep::{Found, QueryOutcome, SweepOptions};
use crate::folding::Pose;
use crate::pattern::FaceId;
use crate::util::progress::Watch;

/// Pairs that are looked at together, before any of them is followed by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Batch {
    /// All pairs of pieces of a sheet, over an interval of the motion.
    Interval,
    /// All cells of a lattice that were not near each other yet.
    Far,
    /// Cells of a lattice whose difference has this number.
    Cells(u32),
}

/// The state of the search that a source of pairs may use when a batch is due.
pub(super) struct Now<'s> {
    pub(super) motion: &'s Motion,
    pub(super) time: Tick,
    pub(super) pieces: &'s Pieces,
    pub(super) hierarchy: &'s Hierarchy,
    pub(super) contact: Contact,
    pub(super) options: &'s SweepOptions,
    pub(super) found: &'s mut Found,
    pub(super) watch: Watch<'s>,
}

/// Answer of a source of pairs to a batch.
pub(super) struct Answer {
    pub(super) outcome: QueryOutcome,
    /// Batches that are due now or later.
    pub(super) batches: Vec<(Batch, Tick)>,
    /// Pairs of faces to be followed from now on.
    pub(super) faces: Vec<[FaceId; 2]>,
    /// Pairs of pieces to be followed over an interval: a time before it at which they are apart, its beginning and its
    /// end.
    pub(super) pieces: (Vec<[u32; 2]>, [Tick; 3]),
    /// Pairs of faces to be measured, because they may be the nearest.
    pub(super) measure: Vec<[FaceId; 2]>,
    /// `true` if all pairs of each sheet are to be followed from now on, by its clusters.
    pub(super) clusters: bool,
    /// Number of pairs of pieces that were skipped, including those to be measured.
    pub(super) skipped: u64,
}

impl Answer {
    /// Returns the answer with this outcome that asks for nothing.
    pub(super) fn new(outcome: QueryOutcome) -> Self {
        Self {
            outcome,
            batches: Vec::new(),
            faces: Vec::new(),
            pieces: Default::default(),
            measure: Vec::new(),
            clusters: false,
            skipped: 0,
        }
    }
}

/// Numbers of pairs of pieces at one configuration.
pub(super) struct PairCounts {
    /// All pairs.
    pub(super) all: u64,
    /// Pairs for which no other pair stands.
    pub(super) representative: u64,
    /// Pairs that share a side, if they were counted.
    pub(super) joined: Option<u64>,
}

/// The sheet as a sweep sees it: where its faces are at a time, and which pairs of them have to be looked at.
pub(super) trait PairSource: Debug + Send + Sync {
    /// Begins a motion, and returns the batch and the pairs of pieces that are due at its beginning; `None` if all pairs
    /// are to be followed one by one.
    fn begin(&mut self, motion: &Motion, pieces: &Pieces) -> Option<(Batch, Vec<[u32; 2]>)>;

    /// Looks at a batch that is due.
    fn query(&mut self, batch: Batch, now: &mut Now<'_>) -> Answer;

    /// Returns the pose of a face.
    fn pose(&mut self, motion: &Motion, time: Tick, face: FaceId) -> Pose;

    /// Returns the numbers of pairs of pieces.
    fn count(&self, pieces: &Pieces) -> PairCounts;

    /// Returns a time until which two faces approach each other by no more than `allowance`, and a bound on their
    /// approach until then. Returns `None` if no such time is known but from the creases between them.
    fn until(&self, _: &Motion, _: Tick, _: [FaceId; 2], _allowance: f64) -> Option<(Tick, f64)> {
        None
    }
}
