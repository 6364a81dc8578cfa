//! Chooses how a motion is searched for crossings. `plan`, `check`, `view` and `plot` all ask here, so that they cannot
//! choose by different rules.
//!
//! There are two routes. *Along the lattice* of a tessellation, one pair of faces stands for all pairs that move alike.
//! *All faces* compares every pair of faces that come near each other. The first is tried where a caller's [`SearchEffort`]
//! allows it, and hands over to the second where it does not decide:
//!
//! | effort | lattice is tried | queries of pairs | largest sheet without a lattice |
//! |---|---|---|---|
//! | [`SearchEffort::PLAN`] | on every sheet | 10 million | any |
//! | [`SearchEffort::CHECK`] | above 4,000 faces | 10 million | any |
//! | [`SearchEffort::CHECK_FAILED`]: the path fails already | never | 200,000 | any |
//! | [`SearchEffort::PICTURE`]: clearance of a motion | on sheets that are not torn | 1 million | 2,000 faces |
//! | [`SearchEffort::PICTURE_SHAPE`]: clearance of a shape | like the motion | 200,000 | like the motion |

use foldpath_core::{Curve, Membership};

use super::sweep::{Sweep, SweepCounts, SweepOptions, SweepVerdict};
use crate::lattice::Lattice;
use crate::pattern::CreasePattern;
use crate::util::progress::Watch;

/// Cost that a search may have: a row of the table above.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SearchEffort {
    /// Largest number of faces whose lattice is not looked for: all pairs are compared, which rests on less.
    lattice_above_faces: usize,
    /// `true` if the lattice is used although the sheet is torn by more than faces may overlap.
    torn_lattice: bool,
    /// Largest number of faces that are searched without a lattice.
    max_faces: usize,
    /// Number of queries of pairs after which the search ends undecided.
    pub(crate) max_queries: u64,
}

impl SearchEffort {
    pub(crate) const PLAN: Self = Self {
        lattice_above_faces: 0,
        torn_lattice: true,
        max_faces: usize::MAX,
        max_queries: 10_000_000,
    };
    pub(crate) const CHECK: Self = Self {
        lattice_above_faces: 4000,
        ..Self::PLAN
    };
    pub(crate) const CHECK_FAILED: Self = Self {
        lattice_above_faces: usize::MAX,
        max_queries: 200_000,
        ..Self::PLAN
    };
    pub(crate) const PICTURE: Self = Self {
        lattice_above_faces: 0,
        torn_lattice: false,
        max_faces: 2000,
        max_queries: 1_000_000,
    };
    pub(crate) const PICTURE_SHAPE: Self = Self {
        max_queries: 200_000,
        ..Self::PICTURE
    };

    /// Finds the lattice of a sheet, if this effort uses it on a sheet with gaps of `gap` median edges.
    pub(crate) fn lattice(
        &self,
        pattern: &CreasePattern,
        memberships: &[Membership],
        gap: f64,
    ) -> Option<Lattice> {
        let large = pattern.faces().len() > self.lattice_above_faces;
        let used = large && (self.torn_lattice || !is_torn(gap));
        used.then(|| Lattice::find(pattern, memberships)).flatten()
    }

    /// Returns `true` if a sheet may be searched, with its lattice or without one.
    pub(crate) fn affords(&self, pattern: &CreasePattern, lattice: Option<&Lattice>) -> bool {
        lattice.is_some() || pattern.faces().len() <= self.max_faces
    }
}

/// Returns `true` if a sheet with this gap, in median edges, may be torn by more than faces may lie across each other.
/// Such a sheet may cross elsewhere than its path does.
pub(crate) fn is_torn(gap: f64) -> bool {
    gap.is_nan() || gap > SweepOptions::default().contact
}

/// A motion to be searched for crossings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SearchedMotion<'a> {
    pub(crate) pattern: &'a CreasePattern,
    /// Group and sign of each crease.
    pub(crate) memberships: &'a [Membership],
    /// For each segment the curve of each group.
    pub(crate) segments: &'a [Vec<Curve<f64>>],
    pub(crate) options: SweepOptions,
    pub(crate) watch: Watch<'a>,
}

/// Result of a search over a motion.
pub(crate) struct Searched {
    pub(crate) verdict: SweepVerdict,
    pub(crate) counts: SweepCounts,
}

impl SearchedMotion<'_> {
    /// Returns the motion, to be searched with at most this number of queries of pairs.
    pub(crate) fn with_queries(mut self, max_queries: u64) -> Self {
        self.options.max_queries = max_queries.min(self.options.max_queries);
        self
    }

    /// Searches by the lattice if there is one and it decides, and all faces otherwise.
    pub(crate) fn search(&self, lattice: Option<&Lattice>) -> Searched {
        let along = lattice.and_then(|lattice| self.along_lattice(lattice));
        along.unwrap_or_else(|| self.all_faces())
    }

    /// Searches along the lattice. Returns `None` if faces may be far from where the lattice has them, or the lattice
    /// does not decide.
    pub(crate) fn along_lattice(&self, lattice: &Lattice) -> Option<Searched> {
        let deviation = lattice.lattice_deviation(self.pattern, self.options.closure);
        if deviation.is_nan() || deviation >= SweepOptions::FAR_FROM_LATTICE_EDGES {
            return None;
        }
        // A deviation that counts as contact may be left out.
        let torn = is_torn(deviation);
        let options = if torn {
            SweepOptions {
                lattice_deviation: deviation,
                lattice_turn: lattice.turn_deviation(self.pattern, self.options.closure),
                ..self.options
            }
        } else {
            self.options
        };
        let sweep = Sweep::new(self.pattern, self.memberships, options, Some(lattice));
        let searched = self.run(sweep);
        let decided = match searched.verdict {
            SweepVerdict::Free(_) => true,
            // Too many cells may meet along the lattice, more than the pairs of faces that do meet.
            SweepVerdict::Undecided { faces: None, .. } => false,
            // On a torn sheet, faces that nearly touch along the lattice may not do so by the folding map.
            _ => !torn,
        };
        decided.then_some(searched)
    }

    /// Searches all faces.
    pub(crate) fn all_faces(&self) -> Searched {
        let sweep = Sweep::new(self.pattern, self.memberships, self.options, None);
        self.run(sweep)
    }

    fn run(&self, sweep: Sweep<'_>) -> Searched {
        let mut sweep = sweep.watched(self.watch);
        Searched {
            verdict: sweep.sweep(self.segments),
            counts: sweep.counts(),
        }
    }
}
