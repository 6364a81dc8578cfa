//! What the user may set.

use core::f64::consts::PI;
use core::time::Duration;

use foldpath_core::{Interpolation, Objective};
use thiserror::Error;

use crate::pattern::CreaseId;

/// Whether to look for crease groups.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Symmetry {
    /// Use the groups that are found and that the whole sheet's closure confirms.
    #[default]
    Auto,
    /// Every crease is an unknown of its own.
    Off,
}

/// Which vertices' closure conditions the solver works on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Vertices {
    /// One for each distinct condition.
    #[default]
    Essential,
    /// All real vertices, of which those that are alike in every bit are evaluated once.
    All,
}

/// Which solver closes the sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Solver {
    /// Levenberg-Marquardt.
    #[default]
    LevenbergMarquardt,
    /// The gradient solver.
    Gradient,
}

/// How the path is looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Search {
    /// Along the motion, from the goal or from flat.
    #[default]
    Path,
    /// The adaptive randomised search of [XiLien2015](foldpath_core#references), section 4.
    Random,
}

/// How time runs along a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timing {
    /// As fast as the limits of the hinges allow.
    #[default]
    Optimal,
    /// So that few knots suffice: in proportion to the tangent of one hinge's half angle, or to the way.
    Sparse,
}

/// What of a path is judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Judged {
    /// The whole motion: as few knots as keep it within the bound, certified between them.
    #[default]
    Motion,
    /// Configurations no farther than the largest step from each other, which become the knots, and nothing between
    /// them: sooner, for a first look. Hinges turn evenly from knot to knot, whatever interpolation and pace are asked
    /// for, and without a limit on their acceleration. A sheet without symmetry is closed between start and goal as far
    /// as a hundredth of the bound asks. Where the knots keep no vertices, errors there are bounded by how well the
    /// essential vertices close, if that is within the bound, rather than measured.
    Knots,
}

/// What the search for crossings skips. Each may be switched off to compare: the verdict stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Skips {
    /// Pairs of faces that move like another pair.
    pub symmetry: bool,
    /// Pairs that cannot have come together since they were looked at.
    pub motion: bool,
    /// Pairs whose bounding volumes are apart.
    pub bounds: bool,
    /// Pairs joined by an edge.
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

/// Fold angles that a hinge may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HingeLimit {
    /// The hinge.
    pub crease: CreaseId,
    /// Smallest fold angle, radians; at most 0, as the path begins flat.
    pub lower: f64,
    /// Largest fold angle, radians; at least 0.
    pub upper: f64,
}

/// Options of [`plan`](super::plan).
#[derive(Clone, Debug, PartialEq)]
pub struct PlanOptions {
    /// Bound on deformation and gap of the whole sheet, a fraction.
    pub bound: f64,
    /// Whether to look for crease groups.
    pub symmetry: Symmetry,
    /// Which closure conditions to solve.
    pub vertices: Vertices,
    /// What of the path is judged.
    pub judged: Judged,
    /// Whether to look for faces that pass through each other.
    pub collision: bool,
    /// What that search skips.
    pub skips: Skips,
    /// How the motion between knots is made; `None` for what needs the fewest knots.
    pub interpolation: Option<Interpolation>,
    /// How time runs along the path.
    pub pace: Timing,
    /// Which solver to use.
    pub solver: Solver,
    /// How to look for the path.
    pub search: Search,
    /// How the randomised search measures closure.
    pub objective: Objective,
    /// Seed of everything random.
    pub seed: u64,
    /// Hinges that may not turn as far as touching themselves.
    pub limits: Vec<HingeLimit>,
    /// No hinge turns by more than this in a step of the solver, radians.
    pub max_step: f64,
    /// Speed that no hinge exceeds, radians per second.
    pub max_speed: f64,
    /// Acceleration that no hinge exceeds, radians per second squared. With one the path begins and ends at
    /// rest.
    pub max_acceleration: Option<f64>,
    /// Knots that the path has at most.
    pub max_knots: Option<usize>,
    /// Time after which planning stops; none by default.
    pub timeout: Option<Duration>,
    /// Whether each knot keeps the folded positions of the vertices: 24 bytes a vertex and knot.
    pub keep_vertices: bool,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self {
            bound: 0.01,
            symmetry: Symmetry::default(),
            vertices: Vertices::default(),
            judged: Judged::default(),
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
            max_speed: 45_f64.to_radians(),
            max_acceleration: None,
            max_knots: None,
            timeout: None,
            keep_vertices: true,
        }
    }
}

/// An option outside its range.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{option}: {}", self.problem())]
pub struct OptionsError {
    /// The option.
    pub option: &'static str,
    /// Its range.
    pub expected: &'static str,
    /// The value given.
    pub found: f64,
}

impl OptionsError {
    /// What is wrong, without the option's name.
    #[must_use]
    pub fn problem(&self) -> String {
        format!("expected {}, found {}", self.expected, self.found)
    }
}

/// Radians per second: slower than this, times become too large to tell knots apart.
const SLOWEST: f64 = 1e-9;

impl PlanOptions {
    /// Checks that each option is in its range.
    ///
    /// # Errors
    /// The first one that is not.
    pub fn validate(&self) -> Result<(), OptionsError> {
        let positive = |option, found: f64| {
            let good = found > 0.0 && found.is_finite();
            good.then_some(()).ok_or(OptionsError {
                option,
                expected: "a number above 0",
                found,
            })
        };
        positive("bound", self.bound)?;
        if self.bound > 1.0 {
            return Err(OptionsError {
                option: "bound",
                expected: "a fraction of at most 1",
                found: self.bound,
            });
        }
        for limit in &self.limits {
            let flat = limit.lower <= 0.0 && limit.upper >= 0.0;
            if !flat || limit.lower < -PI || limit.upper > PI {
                return Err(OptionsError {
                    option: "limit",
                    expected: "MIN..MAX within -180..180 degrees and round 0, where the path begins",
                    found: if limit.lower > 0.0 || limit.lower < -PI {
                        limit.lower
                    } else {
                        limit.upper
                    }
                    .to_degrees(),
                });
            }
        }
        positive("max_step", self.max_step)?;
        positive("max_speed", self.max_speed)?;
        positive("max_acceleration", self.max_acceleration.unwrap_or(1.0))?;
        if let (Judged::Knots, Some(found)) = (self.judged, self.max_acceleration) {
            return Err(OptionsError {
                option: "max_acceleration",
                expected: "none where knots alone are judged, as they are joined straight",
                found: found.to_degrees(),
            });
        }
        if self.max_speed < SLOWEST {
            return Err(OptionsError {
                option: "max_speed",
                expected: "at least 1e-9 radians per second",
                found: self.max_speed,
            });
        }
        Ok(())
    }
}
