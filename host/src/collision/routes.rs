//! Chooses how a sheet is searched for crossings. `plan`, `check`, `view` and `plot` all ask here, so that they cannot
//! choose by different rules, or take different overlaps for contact.
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

use core::cell::OnceCell;

use foldpath_core::{Curve, Membership};

use super::pieces::contact_tolerance;
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
}

/// How far a sheet is from closing on a motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Openness {
    /// Bound on the closure residuals of all vertices and holes.
    pub(crate) closure: f64,
    /// Largest distance between the positions that the faces round a vertex give it, median edges.
    pub(crate) gap: f64,
}

/// A sheet that is searched for crossings, with the rule of contact.
#[derive(Debug)]
pub(crate) struct SearchedSheet<'a> {
    pattern: &'a CreasePattern,
    /// Group and sign of each crease.
    memberships: &'a [Membership],
    /// Depth up to which an overlap of faces is contact, median edges.
    pub(crate) contact: f64,
    /// The lattice, once requested.
    lattice: OnceCell<Option<Lattice>>,
}

impl<'a> SearchedSheet<'a> {
    /// Takes a sheet and the depth up to which an overlap is contact, median edges; `None` for what the coordinates'
    /// precision explains.
    pub(crate) fn new(
        pattern: &'a CreasePattern,
        memberships: &'a [Membership],
        contact: Option<f64>,
    ) -> Self {
        Self {
            pattern,
            memberships,
            contact: contact.unwrap_or_else(|| contact_tolerance(pattern)),
            lattice: OnceCell::new(),
        }
    }

    /// Searches a motion, given a curve for each group in each segment.
    pub(crate) fn search(
        &self,
        segments: &[Vec<Curve<f64>>],
        effort: &SearchEffort,
        openness: Openness,
        watch: Watch<'_>,
    ) -> Searched {
        let motion = SearchedMotion {
            pattern: self.pattern,
            memberships: self.memberships,
            segments,
            options: self.options(effort, openness),
            watch,
        };
        motion.search(self.lattice(effort, openness))
    }

    /// Returns a search for the nearest faces on motions; `None` if it would take too long.
    pub(crate) fn nearest<'s>(
        &'s self,
        effort: &SearchEffort,
        openness: Openness,
        watch: Watch<'s>,
    ) -> Option<Sweep<'s>> {
        let lattice = self.lattice(effort, openness);
        let affords = lattice.is_some() || self.pattern.faces().len() <= effort.max_faces;
        let options = self.options(effort, openness);
        let sweep = || Sweep::new(self.pattern, self.memberships, options, lattice);
        affords.then(|| sweep().watched(watch))
    }

    fn options(&self, effort: &SearchEffort, openness: Openness) -> SweepOptions {
        SweepOptions {
            closure: openness.closure,
            contact: self.contact,
            max_queries: effort.max_queries,
            ..SweepOptions::default()
        }
    }

    /// Returns the lattice, if this effort uses it.
    fn lattice(&self, effort: &SearchEffort, openness: Openness) -> Option<&Lattice> {
        let large = self.pattern.faces().len() > effort.lattice_above_faces;
        let used = large && (effort.torn_lattice || !is_torn(openness.gap));
        let find = || Lattice::find(self.pattern, self.memberships);
        used.then(|| self.lattice.get_or_init(find).as_ref())?
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
    fn search(&self, lattice: Option<&Lattice>) -> Searched {
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
