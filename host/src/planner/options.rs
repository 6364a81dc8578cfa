//! What the user may set.

use core::time::Duration;

use thiserror::Error;

use super::Interpolation;

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
    /// All real vertices.
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

/// Options of [`plan`](super::plan).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanOptions {
    /// Bound on deformation and gap of the whole sheet, a fraction.
    pub bound: f64,
    /// Whether to look for crease groups.
    pub symmetry: Symmetry,
    /// Which closure conditions to solve.
    pub vertices: Vertices,
    /// Whether to look for faces that pass through each other.
    pub collision: bool,
    /// How the motion between knots is made.
    pub interpolation: Interpolation,
    /// Which solver to use.
    pub solver: Solver,
    /// No hinge turns by more than this from one knot to the next, radians.
    pub max_step: f64,
    /// Speed of the fastest hinge, radians per second.
    pub max_speed: f64,
    /// Time after which planning stops; none by default.
    pub timeout: Option<Duration>,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self {
            bound: 0.01,
            symmetry: Symmetry::default(),
            vertices: Vertices::default(),
            collision: true,
            interpolation: Interpolation::default(),
            solver: Solver::default(),
            max_step: 10_f64.to_radians(),
            max_speed: 45_f64.to_radians(),
            timeout: None,
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
        positive("max_step", self.max_step)?;
        positive("max_speed", self.max_speed)?;
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
