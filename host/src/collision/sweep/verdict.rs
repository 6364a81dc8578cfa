//! Input and outcome of a sweep: options, verdict, clearance and counts.

use core::cmp::Ordering;
use core::ops::AddAssign;

use serde::Serialize;

use crate::collision::pairs::PairCounts;
use crate::collision::pieces::Pieces;
use crate::collision::scene::Crossing;
use crate::collision::tolerances::CROSSING_DEPTH_EDGES;
use crate::pattern::FaceId;

/// Options of a [`Sweep`](super::Sweep).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SweepOptions {
    /// Depth up to which an overlap is contact, in median edges: the
    /// [`contact_tolerance`](crate::collision::contact_tolerance). In front of a small face, at most a thousandth of the
    /// face counts.
    pub contact: f64,
    /// Upper bound of the closure residuals of all vertices and holes, all along the motion. It bounds how far the sheet
    /// is torn, and with it the motion of faces whose chain crosses a tear.
    pub closure: f64,
    /// Fraction of `closure` up to which layers that lie across each other are in contact, as if the sheet were torn by as
    /// much: 1 or less.
    pub closure_as_contact: f64,
    /// Distance by which faces may be elsewhere than the lattice has them that is not looked at otherwise, median edges.
    pub left_out: f64,
    /// Largest distance of a face from its position by the lattice, as seen from any other face, in median edges, if
    /// the motion tears the sheet. Faces without a common vertex that come this near to each other are not decided
    /// along the lattice.
    pub lattice_deviation: f64,
    /// Largest angle by which such a face is turned from its orientation by the lattice, radians.
    pub lattice_turn: f64,
    /// `true` if pairs are skipped while their motion cannot bring them together. If `false`, each pair is
    /// queried at every tabulated time.
    pub skip_motion: bool,
    /// `true` if pairs, and clusters of pairs together, are skipped while their bounding spheres are apart.
    pub skip_bounds: bool,
    /// `true` if pairs joined by an edge are never queried.
    pub skip_edges: bool,
    /// Number of queries of pairs after which the answer is [`SweepVerdict::Undecided`].
    pub max_queries: u64,
}

impl SweepOptions {
    /// Value of [`lattice_deviation`](Self::lattice_deviation) from which on the lattice says nothing of crossings.
    pub const FAR_FROM_LATTICE_EDGES: f64 = 0.25;
}

impl Default for SweepOptions {
    fn default() -> Self {
        Self {
            contact: CROSSING_DEPTH_EDGES,
            closure: 0.0,
            closure_as_contact: 1.0,
            left_out: 0.0,
            lattice_deviation: 0.0,
            lattice_turn: 0.0,
            skip_motion: true,
            skip_bounds: true,
            skip_edges: true,
            max_queries: 10_000_000,
        }
    }
}

crate::util::changed_one_by_one!(SweepOptions);

/// A place on a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The segment, from 0.
    pub segment: usize,
    /// Parameter in the segment, 0 to 1.
    pub s: f64,
}

impl Place {
    /// Returns `true` if this place comes before the place at which a sweep with this verdict ends.
    pub(super) fn is_before(&self, verdict: &SweepVerdict) -> bool {
        match verdict {
            SweepVerdict::Free(_) => true,
            SweepVerdict::Crossing { at, .. } | SweepVerdict::Undecided { at, .. } => {
                (self.segment, self.s) < (at.segment, at.s)
            }
        }
    }
}

/// The smallest distance found between two faces that share no vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Distance in units of the sheet.
    pub distance: f64,
    /// The faces, the smaller number first.
    pub faces: [FaceId; 2],
    /// Place on the motion.
    pub place: Place,
}

/// Outcome of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SweepVerdict {
    /// No two faces pass through each other by more than twice the tolerance. The clearance is the smallest
    /// distance found at any time that was queried; at the end of the motion no distance is smaller. `None` if
    /// all faces share vertices.
    Free(Option<Clearance>),
    /// Two faces pass through each other.
    Crossing {
        /// The faces, and the depth of their crossing at `at`.
        crossing: Crossing,
        /// The first place found at which they cross.
        at: Place,
        /// A place up to which no pair crosses; `None` if some pair crosses from the beginning.
        last_free: Option<Place>,
    },
    /// The budget is spent, the motion is not finite, too many cells of a lattice that turns may meet, or faces
    /// come too near to each other to be decided along the lattice of a torn sheet.
    Undecided {
        /// Faces that are not decided, if only some are not; those of a pair that was looked at last if the budget is spent.
        faces: Option<[FaceId; 2]>,
        /// Place up to which no pair crosses.
        at: Place,
    },
}

/// Numbers of pairs that a sweep tested, and that it could skip; `pairs` is the sum of all others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SweepCounts {
    /// Pairs of pieces of the same sheet, times the configurations at which any pair was queried.
    pub pairs: u64,
    /// Queries that measured a distance or a depth.
    pub tested: u64,
    /// Pairs represented by another pair that moves alike.
    pub skipped_symmetry: u64,
    /// Pairs that could not have come together since their last query.
    pub skipped_motion: u64,
    /// Pairs whose bounding spheres, or those of clusters that hold them, were apart.
    pub skipped_bounds: u64,
    /// Pairs joined by an edge.
    pub skipped_edges: u64,
}

impl AddAssign for SweepCounts {
    fn add_assign(&mut self, other: Self) {
        self.pairs += other.pairs;
        self.tested += other.tested;
        self.skipped_symmetry += other.skipped_symmetry;
        self.skipped_motion += other.skipped_motion;
        self.skipped_bounds += other.skipped_bounds;
        self.skipped_edges += other.skipped_edges;
    }
}

impl SweepVerdict {
    /// Returns the faces that it names.
    pub(super) fn faces(&self) -> Option<[FaceId; 2]> {
        match self {
            Self::Free(clearance) => clearance.map(|clearance| clearance.faces),
            Self::Crossing { crossing, .. } => Some(crossing.faces),
            Self::Undecided { faces, .. } => *faces,
        }
    }
}

/// Findings of a sweep so far.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::collision) struct Found {
    pub(super) clearance: Option<Clearance>,
    pub(in crate::collision) counts: SweepCounts,
    /// Number of pairs found to share a side.
    pub(super) joined: u64,
}

impl Found {
    /// Returns the smallest distance; infinite if there is none.
    pub(in crate::collision) fn best(&self) -> f64 {
        let best = self.clearance.map(|clearance| clearance.distance);
        best.unwrap_or(f64::INFINITY)
    }

    /// Stores the distance of two pieces at a place if it is smaller than all others.
    pub(in crate::collision) fn note(
        &mut self,
        pieces: &Pieces,
        pair: [u32; 2],
        distance: f64,
        place: Place,
    ) {
        if distance <= self.best() {
            let [first, second] = pair.map(|piece| pieces.list[piece as usize].face);
            self.note_clearance(Clearance {
                distance,
                faces: [first.min(second), first.max(second)],
                place,
            });
        }
    }

    /// Stores a clearance if it is smaller than all others; of equal ones the first, and at one place that with the smallest
    /// numbers of faces.
    pub(super) fn note_clearance(&mut self, new: Clearance) {
        let key = |it: &Clearance| (it.distance, it.place.segment, it.place.s);
        let is_first = |old: &Clearance| match key(&new).partial_cmp(&key(old)) {
            Some(Ordering::Equal) => new.faces < old.faces,
            order => order == Some(Ordering::Less),
        };
        if self.clearance.as_ref().is_none_or(is_first) {
            self.clearance = Some(new);
        }
    }

    /// Completes the counts after `times` configurations, given those before and the numbers of pairs at each.
    pub(super) fn complete(
        &mut self,
        times: u64,
        before: &SweepCounts,
        pairs: &PairCounts,
        options: &SweepOptions,
    ) {
        let counts = &mut self.counts;
        if options.skip_edges {
            counts.skipped_edges += times * pairs.joined.unwrap_or(self.joined);
        }
        let handled = |c: &SweepCounts| c.tested + c.skipped_bounds + c.skipped_edges;
        let handled = handled(counts) - handled(before);
        // Without this skip, pairs are passed over only at times between the tabulated ones, at which only
        // pairs in contact are queried.
        let skipped_motion = if options.skip_motion {
            (times * pairs.representative).saturating_sub(handled)
        } else {
            0
        };
        let skipped_symmetry = times * (pairs.all - pairs.representative);
        counts.skipped_motion += skipped_motion;
        counts.skipped_symmetry += skipped_symmetry;
        counts.pairs += handled + skipped_motion + skipped_symmetry;
    }
}
