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
//! | [`SearchEffort::PLAN_ALL`]: nothing is to be skipped | on every sheet | any number | any |
//! | [`SearchEffort::CHECK`] | above 4,000 faces | 10 million | any |
//! | [`SearchEffort::CHECK_FAILED`]: the path fails already | never | 200,000 | any |
//! | [`SearchEffort::PICTURE`]: clearance of a motion | on sheets that are not torn | 1 million | 2,000 faces |
//! | [`SearchEffort::PICTURE_SHAPE`]: clearance of a shape | like the motion | 200,000 | like the motion |
//!
//! On a sheet that does not quite close, layers may overlap by what the closure bound explains. `check` bounds the closure
//! of a file by itself, and may find a smaller bound than `plan` did, but not by more than a known factor. `plan` divides
//! its bound by that factor, so that what it finds free, `check` finds free, too.

use core::cell::OnceCell;
use std::sync::Arc;

use foldpath_core::{Curve, Membership};

use super::pieces::contact_tolerance;
use super::solids::Plates;
use super::sweep::{Sweep, SweepCounts, SweepOptions, SweepVerdict};
use super::tolerances::CROSSING_DEPTH_EDGES;
use crate::certificate::LOOSE_RATIO;
use crate::lattice::Lattice;
use crate::pattern::CreasePattern;
use crate::util::progress::Watch;

/// Number of queries of pairs after which a motion nearer to the path is tried, if tears may hide contact.
const MAX_HIDDEN_QUERIES: u64 = 200_000;
/// Largest number of faces for which a torn sheet is swept without its lattice at once.
const MAX_TORN_FACES: usize = 400;
/// Ratio of the sum of all tears to the depth that counts as a crossing above which tears may hide contact.
const HIDING_RATIO: f64 = 0.1;
/// Difference of a fold angle from half a turn up to which the faces at a crease may be layers that touch, radians.
const NEARLY_FOLDED_RAD: f64 = 1e-3;

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
    max_queries: u64,
    /// Fraction of the closure bound that counts as contact, see [`SweepOptions::closure_as_contact`].
    closure_as_contact: f64,
}

impl SearchEffort {
    pub(crate) const PLAN: Self = Self {
        lattice_above_faces: 0,
        torn_lattice: true,
        max_faces: usize::MAX,
        max_queries: 10_000_000,
        closure_as_contact: 1.0 / LOOSE_RATIO,
    };
    /// `plan` by a user who switches a skip off, to look at everything.
    pub(crate) const PLAN_ALL: Self = Self {
        max_queries: u64::MAX,
        ..Self::PLAN
    };
    pub(crate) const CHECK: Self = Self {
        lattice_above_faces: 4000,
        closure_as_contact: 1.0,
        ..Self::PLAN
    };
    pub(crate) const CHECK_FAILED: Self = Self {
        lattice_above_faces: usize::MAX,
        max_queries: 200_000,
        ..Self::CHECK
    };
    pub(crate) const PICTURE: Self = Self {
        lattice_above_faces: 0,
        torn_lattice: false,
        max_faces: 2000,
        max_queries: 1_000_000,
        ..Self::CHECK
    };
    pub(crate) const PICTURE_SHAPE: Self = Self {
        max_queries: 200_000,
        ..Self::PICTURE
    };
}

/// The distance of a sheet from closing on a motion.
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
    /// The plates of which the panels are made, if they have a thickness.
    plates: Option<Arc<Plates>>,
    watch: Watch<'a>,
}

impl<'a> SearchedSheet<'a> {
    /// Takes a sheet and the depth up to which an overlap is contact, median edges; `None` for what the coordinates'
    /// precision explains.
    pub(crate) fn new(
        pattern: &'a CreasePattern,
        memberships: &'a [Membership],
        contact: Option<f64>,
        watch: Watch<'a>,
    ) -> Self {
        Self {
            pattern,
            memberships,
            contact: contact.unwrap_or_else(|| contact_tolerance(pattern)),
            lattice: OnceCell::new(),
            plates: None,
            watch,
        }
    }

    /// Makes the panels of the sheet plates.
    pub(crate) fn made_of(self, plates: Arc<Plates>) -> Self {
        Self {
            plates: Some(plates),
            ..self
        }
    }

    /// Searches a motion, given a curve for each group in each segment: by the lattice if this effort uses it and it
    /// decides, and all faces otherwise.
    pub(crate) fn search(
        &self,
        segments: &[Vec<Curve<f64>>],
        effort: &SearchEffort,
        openness: Openness,
    ) -> Searched {
        let options = self.options(effort, openness.closure);
        let lattice = self.lattice(effort, openness);
        let along = lattice.and_then(|lattice| self.along_lattice(segments, options, lattice));
        along.unwrap_or_else(|| self.all_faces(segments, options))
    }

    /// Searches a planned motion by a lattice that is lent, if it decides, and all faces otherwise. Leaves the motion for
    /// one nearer to its path, which has more knots but tells more, if all faces of a large sheet that is torn would have
    /// to be searched (`torn_goes_nearer`), or the tears hide contact (`hides_contact`) and a search with a small budget
    /// does not decide.
    pub(crate) fn search_planned(
        &self,
        segments: &[Vec<Curve<f64>>],
        options: SweepOptions,
        lattice: Option<&Lattice>,
        torn_goes_nearer: bool,
        hides_contact: impl FnOnce() -> bool,
    ) -> Routed {
        let along = lattice.and_then(|lattice| self.along_lattice(segments, options, lattice));
        if let Some(along) = along {
            return Routed::Searched(along);
        }
        let is_large = lattice.is_some() && self.pattern.faces().len() > MAX_TORN_FACES;
        if is_large && torn_goes_nearer {
            return Routed::TooFar(SweepCounts::default());
        }
        if !hides_contact() {
            return Routed::Searched(self.all_faces(segments, options));
        }
        let few = options.with(|it| it.max_queries = it.max_queries.min(MAX_HIDDEN_QUERIES));
        let first = self.all_faces(segments, few);
        match first.verdict {
            SweepVerdict::Undecided { .. } => Routed::TooFar(first.counts),
            _ => Routed::Searched(first),
        }
    }

    /// Returns `true` if layers may touch on a motion with these angles at its knots, and the sheet may be torn by more
    /// than faces that touch may overlap: whether layers that move together pass through each other is then hard to tell.
    pub(crate) fn tears_hide_contact(
        &self,
        closure: Option<f64>,
        mut angles: impl Iterator<Item = f64>,
    ) -> bool {
        let tree = self.pattern.tree();
        let flat = core::f64::consts::PI - NEARLY_FOLDED_RAD;
        let touches = angles.any(|angle| angle.abs() >= flat);
        let holonomy = tree.holonomy(self.pattern).filter(|_| touches);
        let (Some(holonomy), Some(closure)) = (holonomy, closure) else {
            return false;
        };
        let length = tree.reach(self.pattern);
        let tears = holonomy.tears(closure).into_iter();
        let sum: f64 = tears.map(|tear| tear.shift + tear.turn * length).sum();
        sum > HIDING_RATIO * self.contact * self.pattern.median_edge()
    }

    /// Returns a search for the nearest faces on motions; `None` if it would take too long.
    pub(crate) fn nearest(&self, effort: &SearchEffort, openness: Openness) -> Option<Sweep<'_>> {
        let lattice = self.lattice(effort, openness);
        let affords = lattice.is_some() || self.pattern.faces().len() <= effort.max_faces;
        let options = self.options(effort, openness.closure);
        affords.then(|| self.sweep(options, lattice))
    }

    /// Returns `true` if a sheet with this gap, in median edges, may be torn by more than faces may lie across each other.
    /// Such a sheet may cross elsewhere than its path does.
    pub(crate) fn is_torn(&self, gap: f64) -> bool {
        gap.is_nan() || gap > self.contact
    }

    /// Returns the options of a search of this cost on a motion whose closure residuals are at most `closure`.
    pub(crate) fn options(&self, effort: &SearchEffort, closure: f64) -> SweepOptions {
        SweepOptions {
            closure,
            closure_as_contact: effort.closure_as_contact,
            contact: self.contact,
            max_queries: effort.max_queries,
            ..SweepOptions::default()
        }
    }

    /// Returns the lattice, if this effort uses it.
    fn lattice(&self, effort: &SearchEffort, openness: Openness) -> Option<&Lattice> {
        let large = self.pattern.faces().len() > effort.lattice_above_faces;
        let used = large && (effort.torn_lattice || !self.is_torn(openness.gap));
        // The lattice of faces is that of plates if each is one face, and if no tear moves points far from the hinges.
        let is_torn = self.is_torn(openness.gap);
        let is_lattice = |plates: &Arc<Plates>| plates.are_faces() && !is_torn;
        let used = used && self.plates.as_ref().is_none_or(is_lattice);
        let find = || Lattice::find(self.pattern, self.memberships);
        used.then(|| self.lattice.get_or_init(find).as_ref())?
    }

    /// Searches along a lattice. Returns `None` if faces may be far from where the lattice has them, or the lattice
    /// does not decide.
    fn along_lattice(
        &self,
        segments: &[Vec<Curve<f64>>],
        mut options: SweepOptions,
        lattice: &Lattice,
    ) -> Option<Searched> {
        let deviation = lattice.lattice_deviation(self.pattern, options.closure);
        if deviation.is_nan() || deviation >= SweepOptions::FAR_FROM_LATTICE_EDGES {
            return None;
        }
        // A deviation may be left out that is no deeper than exact sheets overlap in contact, whatever is contact here: it
        // adds to that.
        let torn = deviation > CROSSING_DEPTH_EDGES;
        if torn {
            options.lattice_deviation = deviation;
            options.lattice_turn = lattice.turn_deviation(self.pattern, options.closure);
        } else {
            options.left_out = deviation;
        }
        let searched = Searched::by(self.sweep(options, Some(lattice)), segments);
        let decided = match searched.verdict {
            SweepVerdict::Free(_) => true,
            // Too many cells may meet along the lattice, more than the pairs of faces that do meet.
            SweepVerdict::Undecided { faces: None, .. } => false,
            // On a torn sheet, faces that nearly touch along the lattice may not do so by the folding map.
            _ => !torn,
        };
        decided.then_some(searched)
    }

    fn all_faces(&self, segments: &[Vec<Curve<f64>>], options: SweepOptions) -> Searched {
        Searched::by(self.sweep(options, None), segments)
    }

    fn sweep<'s>(&'s self, options: SweepOptions, lattice: Option<&'s Lattice>) -> Sweep<'s> {
        let plates = self.plates.as_ref();
        Sweep::of_plates(self.pattern, self.memberships, options, lattice, plates)
            .watched(self.watch)
    }
}

/// Result of a search over a motion.
pub(crate) struct Searched {
    pub(crate) verdict: SweepVerdict,
    pub(crate) counts: SweepCounts,
}

/// Answer of a search over a motion that may be placed nearer to its path.
pub(crate) enum Routed {
    Searched(Searched),
    /// The nearer motion has to be searched instead. The counts are those of a search that did not decide.
    TooFar(SweepCounts),
}

impl Searched {
    fn by(mut sweep: Sweep<'_>, segments: &[Vec<Curve<f64>>]) -> Self {
        Self {
            verdict: sweep.sweep(segments),
            counts: sweep.counts(),
        }
    }
}
