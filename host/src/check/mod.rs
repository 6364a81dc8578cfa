//! Judges a path from its file alone, sharing no state with the planner.
//!
//! Closure is computed by folding matrices, where the planner uses quaternions. The shape is computed by the
//! folding map, and by the positions in the file if it has them. A path is more than its knots: the motion
//! between them, as the file has it interpolated, is judged. Its closure is bounded everywhere and, with the
//! closure, the deformation of the sheet. Assignments (letters) and the limit of half a turn are checked
//! everywhere; shapes are sampled. `majorant.rs` and `turns.rs` keep their own arithmetic of cubics, so that a mistake in
//! core's `bernstein`, on which the planner's bounds rest, does not go unseen here.

mod between;
mod claims;
mod clearance;
mod closure;
mod finding;
mod knots;
mod majorant;
mod merged_groups;
mod messages;
mod turns;

pub use claims::Rates;
pub(crate) use clearance::clearances_until_over;
pub use clearance::{Clearances, WorstPair, clearances};
pub use closure::SegmentClosure;
pub use finding::{Failure, GroupQuantity, Moment, RateLimit, SheetError, Undecided, WrongTurn};
pub(crate) use knots::differing_hinge;
pub use knots::measure;
pub(crate) use merged_groups::MergedGroups;

use core::time::Duration;

use crate::collision::{Crossing, SearchedSheet, Thickest};
use crate::folding::{DEFAULT_BOUND, Rigidity};
use crate::motion::Motion;
use crate::pattern::VertexId;
use crate::progress::{Progress, Stage, Watch};
use crate::util::clock::Instant;

/// Options of [`check`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CheckOptions {
    /// Bound on deformation and gap, a fraction.
    pub bound: f64,
    /// Depth up to which an overlap of faces is contact, in median edges; `None` for what the coordinates' precision
    /// explains: [`contact_tolerance`](crate::collision::contact_tolerance).
    pub contact: Option<f64>,
    /// Largest angle by which a panel may bend about a diagonal, radians.
    pub bend: f64,
    /// Number of shapes judged in each segment between its knots; with 0, knots alone are judged.
    pub samples: usize,
    /// `true` if crossings are searched for anywhere on the motion, not only in these shapes and at knots.
    pub sweep: bool,
    /// `true` to find how thick plates may be, if the path has plates.
    pub thickest: bool,
    /// Time after which judging stops; `None` for no limit. The verdict tells what was proved by then.
    pub timeout: Option<Duration>,
}

impl CheckOptions {
    /// Returns options that judge knots alone.
    #[must_use]
    pub fn knots_alone(bound: f64) -> Self {
        Self {
            bound,
            contact: None,
            bend: 0.0,
            samples: 0,
            sweep: false,
            thickest: false,
            timeout: None,
        }
    }
}

impl Default for CheckOptions {
    fn default() -> Self {
        Self {
            bound: DEFAULT_BOUND,
            contact: None,
            bend: 0.0,
            samples: 16,
            sweep: true,
            thickest: false,
            timeout: None,
        }
    }
}

crate::util::changed_one_by_one!(CheckOptions);

/// Difference of angles below which they are equal, radians: a hundred times the loss between radians and the
/// degrees of a file, a millionth of a visible difference.
const SAME_ANGLE_RAD: f64 = 1e-9;
/// A crossing, and the place on the path at which it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathCrossing {
    /// The deepest crossing at this place.
    pub crossing: Crossing,
    /// The knots between which it was found.
    pub between_knots: [usize; 2],
    /// Place between them, from 0 to 1.
    pub at: f64,
}

/// Measurements at one knot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Deformation, gap and twist. If the file has positions, these count as one more opinion on the position
    /// of each vertex.
    pub rigidity: Rigidity,
    /// Gap of the sheet as it is folded, over the median edge, whatever positions the file has.
    pub gap: f64,
    /// Largest closure residual of a real vertex, or twist of a hinge if that is larger.
    pub closure: f64,
    /// The vertex with the largest closure residual.
    pub vertex: Option<VertexId>,
}

/// A shape between two knots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Number of the knot before it.
    pub segment: usize,
    /// Place in the segment, from 0 to 1.
    pub at: f64,
    /// Deformation, gap and twist of the shape.
    pub rigidity: Rigidity,
}

/// The verdict on a path.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Verdict {
    /// Faults of the path.
    pub failures: Vec<Failure>,
    /// Questions left open.
    pub undecided: Vec<Undecided>,
    /// Measurements at each knot.
    pub knots: Vec<Measured>,
    /// Shapes judged between knots.
    pub samples: Vec<Sample>,
    /// The closure of each segment.
    pub segments: Vec<SegmentClosure>,
    /// Crossings found: the first one of the motion or, in samples, the deepest one of each segment.
    pub crossings: Vec<PathCrossing>,
    /// Smallest distance found between faces that share no vertex, in units of the sheet.
    pub min_clearance: Option<f64>,
    /// Depth up to which an overlap of faces counts as contact, in median edges.
    pub contact_tolerance: f64,
    /// Largest thickness of plates, if that is asked for.
    pub thickest: Option<Thickest>,
    /// Largest speed and acceleration of a hinge.
    pub rates: Rates,
    /// Largest angle by which a panel bends about a diagonal, radians: at knots, and between as far as looked at.
    pub max_bend: f64,
}

/// Answer of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Outcome {
    /// The path has no fault, and no question is open.
    Holds,
    /// The path has a fault.
    Fails,
    /// No fault was found, but a question is open.
    Undecided,
}

impl Outcome {
    /// Returns the name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "fails",
            Self::Undecided => "undecided",
        }
    }
}

impl Verdict {
    /// Returns the answer.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        if !self.failures.is_empty() {
            Outcome::Fails
        } else if self.undecided.is_empty() {
            Outcome::Holds
        } else {
            Outcome::Undecided
        }
    }

    /// Returns `true` if the path has no fault, and no question is open.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.outcome() == Outcome::Holds
    }

    /// Returns all faults and open questions in words; none if the path holds.
    #[must_use]
    pub fn findings(&self) -> Vec<String> {
        let failures = self.failures.iter().map(ToString::to_string);
        let undecided = self.undecided.iter().map(ToString::to_string);
        failures.chain(undecided).collect()
    }

    /// Returns the largest deformation, gap and twist, at knots and between.
    #[must_use]
    pub fn rigidity(&self) -> Rigidity {
        let samples = self.samples.iter().map(|sample| sample.rigidity);
        let shapes = self.knots.iter().map(|knot| knot.rigidity).chain(samples);
        shapes.fold(Rigidity::default(), Rigidity::worse)
    }

    /// Returns the largest closure residual found, at knots and between.
    #[must_use]
    pub fn closure(&self) -> f64 {
        let between = self.segments.iter().map(|segment| segment.sampled);
        let residuals = self.knots.iter().map(|knot| knot.closure).chain(between);
        residuals.fold(0.0, f64::max)
    }

    /// Returns an upper bound of all closure residuals of the whole motion.
    #[must_use]
    pub fn closure_bound(&self) -> f64 {
        let bounds = self.segments.iter().map(|segment| segment.bound);
        bounds.fold(self.closure(), f64::max)
    }

    /// Returns upper bounds of deformation, gap and twist over the whole motion; `None` if they are not known.
    #[must_use]
    pub fn certified(&self) -> Option<Rigidity> {
        let mut segments = self.segments.iter();
        segments.try_fold(self.rigidity(), |worst, segment| {
            Some(worst.worse(segment.rigidity?))
        })
    }
}

/// Judges a path.
#[must_use]
pub fn check(path: &Motion, options: &CheckOptions) -> Verdict {
    check_until_over(path, options, Watch::default())
}

/// Judges a path as [`check`] does, and reports its progress to `progress`. A call that is cancelled or out of time leaves
/// the questions open that it did not come to.
#[must_use]
pub fn check_watched(path: &Motion, options: &CheckOptions, progress: &Progress) -> Verdict {
    check_until_over(path, options, Watch::new(progress))
}

pub(crate) fn check_until_over(path: &Motion, options: &CheckOptions, watch: Watch<'_>) -> Verdict {
    let deadline = options
        .timeout
        .and_then(|time| Instant::now().checked_add(time));
    let watch = deadline.map_or(watch, |_| watch.until(deadline));
    watch.begin(Stage::Folding);
    let tree = path.pattern.tree();
    let mut verdict = Verdict {
        knots: measure(path, tree),
        ..Verdict::default()
    };
    if options.bound.is_nan() {
        verdict.failures.push(Failure::BoundIsNotANumber);
    }
    let claimed = path
        .answer
        .as_ref()
        .map_or(f64::INFINITY, |answer| answer.bend);
    let bend = options.bend.min(claimed);
    verdict.failures.extend(knots::wrong_angle(path, bend));
    verdict.failures.extend(knots::differing_hinge(path));
    let errors = knots::check_rigidity(path, options.bound, &verdict.knots);
    verdict.failures.extend(errors);
    let mut motion = MergedGroups::of(path);
    let memberships = motion.groups.memberships();
    let sheet = SearchedSheet::new(&path.pattern, memberships, options.contact, watch);
    verdict.contact_tolerance = sheet.contact;
    verdict.rates = Rates::of(path, &motion);
    verdict.max_bend = turns::largest_bend(&path.pattern, &motion);
    if options.samples == 0 && !options.sweep {
        motion.segments.clear();
    }
    let options = &CheckOptions {
        sweep: options.sweep && !motion.segments.is_empty(),
        ..*options
    };
    if verdict.failures.is_empty() {
        let (wrong, unknown) = turns::wrong_turn(&path.pattern, &motion, bend);
        verdict.failures.extend(wrong);
        verdict.undecided.extend(unknown);
    }
    let rates = claims::false_rates(path, verdict.rates);
    verdict.failures.extend(rates);
    // Numbers that overflow have been found by now.
    if motion.is_finite() {
        watch.begin(Stage::Closure);
        between::check_closure(path, tree, &motion, options, watch, &mut verdict);
        watch.begin(Stage::Folding);
        between::check_shapes(path, tree, &motion, options, watch, &mut verdict);
        if options.sweep {
            watch.begin(Stage::Crossings);
            let motion = (&motion, &sheet);
            between::check_crossings(path, tree, motion, options, &mut verdict);
            if let Some(plates) = &path.plates {
                between::check_plates(path, motion, (plates, options), &mut verdict, watch);
            }
        }
        let crossing = between::first_crossing(path, &verdict);
        verdict.failures.extend(crossing);
        let motion = (&motion, &sheet);
        let (wrong, unknown) = claims::judge_clearances(path, motion, &verdict.knots);
        verdict.failures.extend(wrong);
        verdict.undecided.extend(unknown);
        let bound = claims::false_bound(path, &verdict);
        verdict.failures.extend(bound);
    }
    if watch.is_over() {
        let judged = verdict
            .segments
            .iter()
            .filter(|segment| segment.is_judged());
        verdict.undecided.push(Undecided::Unfinished {
            judged: judged.count(),
            segments: motion.segments.len(),
        });
    }
    verdict
}

fn count(n: usize) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "of what fits in memory")]
    let count = n as f64;
    count
}
