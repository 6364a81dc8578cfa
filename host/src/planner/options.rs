//! Options of a plan, and the check that they are in range.

use core::f64::consts::PI;
use core::time::Duration;

use foldpath_core::{Interpolation, Objective};
use thiserror::Error;

use crate::pattern::CreaseId;

/// Use of crease groups.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Symmetry {
    /// Uses the groups that are found and that the closure of the whole sheet confirms.
    #[default]
    Auto,
    /// Makes every crease an unknown of its own.
    Off,
}

/// Vertices whose closure conditions the solver works on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Vertices {
    /// One vertex for each distinct condition.
    #[default]
    Essential,
    /// All real vertices. Stars that are equal in every bit are evaluated once.
    All,
}

/// Solver that closes the sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Solver {
    /// Levenberg-Marquardt.
    #[default]
    LevenbergMarquardt,
    /// The gradient solver.
    Gradient,
}

/// Method by which the path is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

/// Options of [`plan`](super::plan).
#[derive(Clone, Debug, PartialEq)]
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
    /// `true` if each knot keeps the folded positions of the vertices: 24 bytes for each vertex and knot.
    pub keep_vertices: bool,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self {
            bound: 0.01,
            goal_tolerance: 1_f64.to_radians(),
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
    /// Name of the option.
    pub option: &'static str,
    /// Range of the option.
    pub expected: &'static str,
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

/// Largest depth of contact that may be asked for, median edges.
const MAX_CONTACT_EDGES: f64 = 1e-3;
/// Smallest speed that may be asked for, radians per second: below it times become too large to tell knots apart.
const MIN_SPEED_RAD_PER_S: f64 = 1e-9;

impl PlanOptions {
    /// Checks that each option is in its range.
    ///
    /// # Errors
    /// The first option that is out of its range.
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
        if !(self.goal_tolerance > 0.0 && self.goal_tolerance <= PI) {
            return Err(OptionsError {
                option: "goal_tolerance",
                expected: "degrees above 0 and at most 180",
                found: self.goal_tolerance.to_degrees(),
            });
        }
        if let Some(found) = self
            .contact
            .filter(|c| !(0.0..=MAX_CONTACT_EDGES).contains(c))
        {
            return Err(OptionsError {
                option: "contact",
                expected: "median edges from 0 to 0.001",
                found,
            });
        }
        if !(0.0..=PI).contains(&self.bend) {
            return Err(OptionsError {
                option: "bend",
                expected: "degrees from 0 to 180",
                found: self.bend.to_degrees(),
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
        if self.max_speed < MIN_SPEED_RAD_PER_S {
            return Err(OptionsError {
                option: "max_speed",
                expected: "at least 1e-9 radians per second",
                found: self.max_speed,
            });
        }
        Ok(())
    }
}
