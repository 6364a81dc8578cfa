//! What a sweep is asked and what it answers.

use crate::collision::pieces::CROSSING;
use crate::collision::scene::Crossing;
use crate::pattern::FaceId;

/// Options of a [`Sweep`](super::Sweep).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepOptions {
    /// A crossing deeper than this part of the median edge counts; what is less is contact.
    pub tolerance: f64,
    /// Largest gap (over the median edge) that the motion tears into the sheet: pairs that meet in a
    /// vertex may cross by as much more. Where it tears, the bounds on motion hold up to the gaps along
    /// the chains of faces.
    pub gap: f64,
    /// How much deeper (over the median edge) pairs that meet nowhere may cross: [`rounding`](crate::collision::rounding)
    /// of a gap.
    pub rounding: f64,
    /// How far (over the median edge) a face may be, as seen from any other, from where the lattice has it
    /// if the motion tears the sheet. Faces without a common vertex that come so near to each other are
    /// not decided along the lattice.
    pub astray: f64,
    /// Pairs are passed over while their motion cannot bring them together. Without, each is looked at at
    /// every tabulated time.
    pub skip_motion: bool,
    /// Pairs are passed over, and clusters of them together, where bounding spheres are apart.
    pub skip_bounds: bool,
    /// Pairs joined by an edge are never looked at.
    pub skip_edges: bool,
    /// Looks at pairs until the answer is [`SweepVerdict::Undecided`].
    pub max_looks: u64,
}

impl SweepOptions {
    /// Where faces may go [`astray`](Self::astray) as far, their lattice says nothing of crossings.
    pub const FAR_ASTRAY: f64 = 0.25;
}

impl Default for SweepOptions {
    fn default() -> Self {
        Self {
            tolerance: CROSSING,
            gap: 0.0,
            rounding: 0.0,
            astray: 0.0,
            skip_motion: true,
            skip_bounds: true,
            skip_edges: true,
            max_looks: 10_000_000,
        }
    }
}

/// A place on a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The segment, from 0.
    pub segment: usize,
    /// Where in it, 0 to 1.
    pub s: f64,
}

impl Place {
    /// Whether a motion that has another verdict goes on until here.
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
    /// In the units of the sheet.
    pub distance: f64,
    /// The faces, the smaller first.
    pub faces: [FaceId; 2],
    /// Where on the motion.
    pub place: Place,
}

/// What a sweep found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SweepVerdict {
    /// No pair passes through each other, but for twice the tolerance. The clearance is the smallest
    /// distance at any time that was looked at, and the smallest of all at the end of the motion; `None` if
    /// all faces share vertices.
    Free(Option<Clearance>),
    /// A pair passes through each other.
    Crossing {
        /// The faces, and how deep they cross at that place.
        crossing: Crossing,
        /// The first place found where they do.
        at: Place,
        /// A place up to which no pair crosses; `None` if some do from the beginning.
        last_free: Option<Place>,
    },
    /// The budget is spent, the motion is not finite, or too many cells of a lattice that turns may meet.
    Undecided {
        /// The pair that was looked at last, if any.
        faces: Option<[FaceId; 2]>,
        /// No pair crosses up to here.
        at: Place,
    },
}

/// What a sweep looked at, and what it did not need to: `pairs` is the sum of all others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SweepCounts {
    /// Pairs of pieces of the same sheet, times the configurations at which any pair was looked at.
    pub pairs: u64,
    /// Looks that measured a distance or a depth.
    pub tested: u64,
    /// Pairs for which another stood that moves alike.
    pub skipped_symmetry: u64,
    /// Pairs that could not have come together since their last look.
    pub skipped_motion: u64,
    /// Pairs whose bounding spheres, or those of clusters that hold them, were apart.
    pub skipped_bounds: u64,
    /// Pairs joined by an edge.
    pub skipped_edges: u64,
}
