//! Options of a plan, and the check that they are in range.

use core::f64::consts::PI;
use core::time::Duration;

use foldpath_core::{Interpolation, Objective};
use thiserror::Error;

use crate::collision::CONTACT_EDGES;
use crate::folding::{BOUND, DEFAULT_BOUND};
use crate::motion::PlateOptions;
use crate::pattern::{BEND_DEG, CreaseId};
use crate::util::range::Range;

/// Use of crease groups.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Symmetry {
    /// Uses the groups that are found and that the closure of the whole sheet confirms.
    #[default]
    Auto,
    /// Makes every crease an unknown of its own.
    Off,
}

/// Vertices whose closure conditions the solver works on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Vertices {
    /// One vertex for each distinct condition.
    #[default]
    Essential,
    /// All real vertices. Stars that are equal in every bit are evaluated once.
    All,
}

/// Solver that closes the sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Solver {
    /// Levenberg-Marquardt.
    #[default]
    LevenbergMarquardt,
    /// The gradient solver.
    Gradient,
}

/// Method by which the path is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Search {
    /// Follows the motion, from the goal or from flat; in phases where faces would cross if all creases turned at once.
    #[default]
    Auto,
    /// Follows the motion with all creases turning at once.
    Path,
    /// The adaptive randomised search of [XiLien2015](foldpath_core#references), section 4.
    Random,
}

/// Time law along a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Timing {
    /// As fast as the limits of the hinges allow.
    #[default]
    Optimal,
    /// Few knots suffice: time is proportional to the tangent of one hinge's half angle, or to the path length.
    Sparse,
}

/// Pairs of faces that the search for crossings skips. Each kind may be looked at, to compare: the verdict stays the
/// same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Skips {
    /// `true` to skip pairs of faces that move like another pair.
    pub symmetry: bool,
    /// `true` to skip pairs that cannot have met since they were last looked at.
    pub motion: bool,
    /// `true` to skip pairs whose bounding volumes are apart.
    pub bounds: bool,
    /// `true` to skip pairs joined by an edge.
    pub edges: bool,
}

impl Default for Skips {
    fn default() -> Self {
        Self {
            symmetry: true,
            motion: true,
            bounds: true,
            edges: true,
        }
    }
}

/// Limits on the fold angle of a hinge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HingeLimit {
    /// The hinge.
    pub crease: CreaseId,
    /// Smallest fold angle, radians; at most 0, as the path begins flat.
    pub lower: f64,
    /// Largest fold angle, radians; at least 0.
    pub upper: f64,
}

/// Thickness of plates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Thickness {
    /// The thickness of the options.
    Given,
    /// The largest that is proved.
    Max,
}

/// Plates that are asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlateRequest {
    pub(super) thickness: Thickness,
    pub(super) plates: PlateOptions,
}

impl PlateRequest {
    /// Returns plates of this thickness.
    #[must_use]
    pub fn given(plates: PlateOptions) -> Self {
        Self {
            thickness: Thickness::Given,
            plates,
        }
    }

    /// Returns these plates with some of their options changed.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut PlateOptions)) -> Self {
        change(&mut self.plates);
        self
    }

    /// Returns plates as thick as the motion allows; the thickness of `plates` does not count.
    #[must_use]
    pub fn thickest(plates: PlateOptions) -> Self {
        Self {
            thickness: Thickness::Max,
            plates,
        }
    }
}

/// Options of [`plan`](super::plan).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PlanOptions {
    /// Bound on deformation and gap of the whole sheet, a fraction of lengths: above 0 and at most 1.
    pub bound: f64,
    /// Largest difference of a crease's angle at the end of the path from its goal with which the goal counts as reached,
    /// radians: above 0 and at most π.
    pub goal_tolerance: f64,
    /// Depth up to which an overlap of faces is contact, in median edges; `None` for what the coordinates' precision
    /// explains: [`contact_tolerance`](crate::collision::contact_tolerance).
    pub contact: Option<f64>,
    /// Largest angle by which panels may bend about their diagonals if the sheet does not fold with rigid panels, radians;
    /// 0 keeps them rigid.
    pub bend: f64,
    /// Use of crease groups.
    pub symmetry: Symmetry,
    /// Vertices whose closure conditions are solved.
    pub vertices: Vertices,
    /// `true` to look for faces that pass through each other.
    pub collision: bool,
    /// Pairs of faces that this search skips.
    pub skips: Skips,
    /// Interpolation between knots; `None` for the one that needs the fewest knots.
    pub interpolation: Option<Interpolation>,
    /// Time law along the path.
    pub pace: Timing,
    /// Solver that closes the sheet.
    pub solver: Solver,
    /// Method by which the path is found.
    pub search: Search,
    /// Objective by which the randomised search measures closure.
    pub objective: Objective,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Hinges that may not turn by half a turn each way, which is as far as panels let them.
    pub limits: Vec<HingeLimit>,
    /// Largest turn of a hinge from one configuration to the next while the motion is followed, radians.
    pub max_step: f64,
    /// Largest speed of a hinge, radians per second.
    pub max_speed: f64,
    /// Largest acceleration of a hinge, radians per second squared. With such a limit the path begins and ends at rest.
    pub max_acceleration: Option<f64>,
    /// Largest number of knots of the path.
    pub max_knots: Option<usize>,
    /// Time after which planning stops; none by default.
    pub timeout: Option<Duration>,
    /// Number of orders in which hinges that turn freely may fold, to list in the plan's [`orders`](super::Plan::orders).
    pub orders: usize,
    /// `true` if each knot keeps the folded positions of the vertices: 24 bytes for each vertex and knot.
    pub keep_vertices: bool,
    /// Plates of which the panels are to be made; `None` for panels without a thickness.
    pub plates: Option<PlateRequest>,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self {
            bound: DEFAULT_BOUND,
            goal_tolerance: DEFAULT_GOAL_TOLERANCE_DEG.to_radians(),
            contact: None,
            bend: 0.0,
            symmetry: Symmetry::default(),
            vertices: Vertices::default(),
            collision: true,
            skips: Skips::default(),
            interpolation: None,
            pace: Timing::default(),
            solver: Solver::default(),
            search: Search::default(),
            objective: Objective::default(),
            seed: 0,
            limits: Vec::new(),
            max_step: 10_f64.to_radians(),
            max_speed: DEFAULT_MAX_SPEED_DEG_PER_S.to_radians(),
            max_acceleration: None,
            max_knots: None,
            timeout: None,
            orders: 0,
            keep_vertices: true,
            plates: None,
        }
    }
}

crate::util::changed_one_by_one!(PlanOptions);

/// An option outside its range.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[error("{option}: {}", self.problem())]
pub struct OptionsError {
    /// Name of the option.
    pub option: &'static str,
    /// Range of the option.
    pub expected: String,
    /// Value given.
    pub found: f64,
}

impl OptionsError {
    /// Returns the problem, without the option's name.
    #[must_use]
    pub fn problem(&self) -> String {
        format!("expected {}, found {}", self.expected, self.found)
    }
}

/// Tolerance of the goal.
pub const GOAL_TOLERANCE_DEG: Range = Range::above("degrees", 0.0).up_to(180.0);
/// The tolerance of the goal of those who choose none.
pub const DEFAULT_GOAL_TOLERANCE_DEG: f64 = 1.0;
/// Largest speed of a hinge. Times of slower hinges become too large to tell knots apart.
pub const MAX_SPEED_DEG_PER_S: Range = Range::from("degrees per second", 1e-6);
/// The largest speed of those who choose none.
pub const DEFAULT_MAX_SPEED_DEG_PER_S: f64 = 45.0;
/// Largest acceleration of a hinge.
pub const MAX_ACCELERATION_DEG_PER_S2: Range = Range::above("degrees per second squared", 0.0);
/// Largest step while the motion is followed.
const MAX_STEP_DEG: Range = Range::above("degrees", 0.0);

impl PlanOptions {
    /// Checks that each option is in its range.
    ///
    /// # Errors
    /// The first option that is out of its range.
    pub fn validate(&self) -> Result<(), OptionsError> {
        let numbers = [
            ("bound", BOUND, Some(self.bound)),
            ("contact", CONTACT_EDGES, self.contact),
        ];
        let angles = [
            (
                "goal_tolerance",
                GOAL_TOLERANCE_DEG,
                Some(self.goal_tolerance),
            ),
            ("bend", BEND_DEG, Some(self.bend)),
            ("max_step", MAX_STEP_DEG, Some(self.max_step)),
            ("max_speed", MAX_SPEED_DEG_PER_S, Some(self.max_speed)),
            (
                "max_accel",
                MAX_ACCELERATION_DEG_PER_S2,
                self.max_acceleration,
            ),
        ];
        let refused = |option, expected: &dyn ToString, found| OptionsError {
            option,
            expected: expected.to_string(),
            found,
        };
        for (option, range, found) in numbers {
            if let Some(found) = found.filter(|found| !range.contains(*found)) {
                return Err(refused(option, &range, found));
            }
        }
        for (option, range, found) in angles {
            if let Some(found) = found.filter(|found| !range.to_radians().contains(*found)) {
                return Err(refused(option, &range, found.to_degrees()));
            }
        }
        if let (Some(Interpolation::Linear), Some(most)) =
            (self.interpolation, self.max_acceleration)
        {
            let expected = "no limit, as a linear path changes the speed of hinges at once";
            return Err(refused("max_accel", &expected, most.to_degrees()));
        }
        for &HingeLimit { lower, upper, .. } in &self.limits {
            let lower_is_good = (-PI..=0.0).contains(&lower);
            if !lower_is_good || !(0.0..=PI).contains(&upper) {
                let expected =
                    "MIN..MAX within -180..180 degrees and round 0, where the path begins";
                let found = if lower_is_good { upper } else { lower };
                return Err(refused("limit", &expected, found.to_degrees()));
            }
        }
        Ok(())
    }
}
