//! Options of planning and of reading, in the units of the command line.

use core::time::Duration;
use std::path::PathBuf;

use foldpath_core::{Interpolation, Objective};
use serde::{Serialize, Serializer};

use super::error::RequestError;
use super::names::{Frames, Switch, by_name};
use super::values::{DrivenEdge, LimitedEdge};
use crate::planner::{PlanOptions, Search, Solver, Symmetry, Timing, Vertices};
use crate::read::{ColourLetters, ReadOptions, Straighten};

/// Options of a plan, as the command line names them. They serialise to the `options` of the answer, in this order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanRequest {
    /// FOLD file of the same sheet whose fold angles are the goal.
    pub goal: Option<PathBuf>,
    /// Fraction of a half turn, 0 to 1, by which each crease is to fold as its letter says.
    pub fold: Option<f64>,
    /// Creases that are driven to an angle while the others follow.
    pub crease: Vec<DrivenEdge>,
    /// FOLD files of the same sheet with fold angles at which the path rests before the goal, in this order.
    pub via: Vec<PathBuf>,
    /// Largest distance of a crease from its goal angle at the end of the path, degrees.
    pub goal_tolerance: f64,
    /// Ranges of the angles of hinges.
    pub limit: Vec<LimitedEdge>,
    /// Largest deformation, gap and closure residual that the path may have.
    pub bound: f64,
    /// Largest angle by which panels may bend about their diagonals, degrees.
    pub bend: f64,
    /// `true` if the path is wanted as far as it goes, even if the answer is no.
    pub keep: bool,
    /// Depth up to which faces may overlap that touch, in median edges, at most 0.001; `None` for what the digits of the
    /// coordinates explain.
    pub contact: Option<f64>,
    /// Unknowns of the plan.
    #[serde(serialize_with = "by_name")]
    pub symmetry: Symmetry,
    /// Vertices whose closure conditions are solved.
    #[serde(serialize_with = "by_name")]
    pub vertices: Vertices,
    /// Search for faces that pass through each other.
    #[serde(serialize_with = "by_name")]
    pub collision: Switch,
    /// Interpolation between knots; `None` for the one that needs the fewest knots.
    #[serde(serialize_with = "by_name")]
    pub interpolation: Option<Interpolation>,
    /// Largest speed of a hinge, degrees per second.
    pub max_speed: f64,
    /// Largest acceleration of a hinge, degrees per second squared.
    pub max_accel: Option<f64>,
    /// Time law along the path.
    #[serde(serialize_with = "by_name")]
    pub pace: Timing,
    /// Largest number of knots of the path.
    pub max_knots: Option<usize>,
    /// Data that each knot of a written path stores.
    #[serde(serialize_with = "by_name")]
    pub frames: Frames,
    /// Solver that closes the sheet.
    #[serde(serialize_with = "by_name")]
    pub solver: Solver,
    /// Method by which the path is found.
    #[serde(serialize_with = "by_name")]
    pub search: Search,
    /// Objective by which the randomised search measures closure.
    #[serde(serialize_with = "by_name")]
    pub objective: Objective,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Seconds after which planning stops, reading included.
    pub timeout: Option<f64>,
    /// Options of reading the pattern.
    #[serde(flatten)]
    pub reading: ReadingRequest,
}

impl Default for PlanRequest {
    fn default() -> Self {
        Self {
            goal: None,
            fold: None,
            crease: Vec::new(),
            via: Vec::new(),
            goal_tolerance: 1.0,
            limit: Vec::new(),
            bound: 0.01,
            bend: 0.0,
            keep: false,
            contact: None,
            symmetry: Symmetry::default(),
            vertices: Vertices::default(),
            collision: Switch::default(),
            interpolation: None,
            max_speed: 45.0,
            max_accel: None,
            pace: Timing::default(),
            max_knots: None,
            frames: Frames::default(),
            solver: Solver::default(),
            search: Search::default(),
            objective: Objective::default(),
            seed: 0,
            timeout: None,
            reading: ReadingRequest::default(),
        }
    }
}

impl PlanRequest {
    /// Returns the planner's options, without limits of hinges, which need a pattern.
    ///
    /// # Errors
    /// If an option is out of its range, or options exclude each other.
    pub fn options(&self) -> Result<PlanOptions, RequestError> {
        let timeout = timeout(self.timeout)?;
        let usage = |text: String| Err(RequestError::Usage(text));
        let goals = [
            ("--goal", self.goal.is_some()),
            ("--fold", self.fold.is_some()),
            ("--crease", !self.crease.is_empty()),
        ];
        let mut given = goals.into_iter().filter(|(_, given)| *given);
        if let (Some((first, _)), Some((second, _))) = (given.next(), given.next()) {
            return usage(format!("{first}: expected without {second}"));
        }
        if !(self.max_speed >= 1e-6 && self.max_speed.is_finite()) {
            let found = self.max_speed;
            return usage(format!(
                "--max-speed: expected at least 1e-6 degrees per second, found {found}"
            ));
        }
        if let Some(found) = self
            .max_accel
            .filter(|most| !(*most > 0.0 && most.is_finite()))
        {
            return usage(format!(
                "--max-accel: expected degrees per second squared above 0, found {found}"
            ));
        }
        if !self.via.is_empty() && self.search == Search::Random {
            return usage(
                "--via: expected --search auto or path, as the randomised search knows no phases"
                    .into(),
            );
        }
        let options = PlanOptions {
            bound: self.bound,
            goal_tolerance: self.goal_tolerance.to_radians(),
            contact: self.contact,
            bend: self.bend.to_radians(),
            symmetry: self.symmetry,
            vertices: self.vertices,
            collision: self.collision == Switch::On,
            interpolation: self.interpolation,
            pace: self.pace,
            solver: self.solver,
            search: self.search,
            objective: self.objective,
            seed: self.seed,
            max_speed: self.max_speed.to_radians(),
            max_acceleration: self.max_accel.map(f64::to_radians),
            max_knots: self.max_knots,
            timeout,
            ..PlanOptions::default()
        };
        options.validate()?;
        Ok(options)
    }
}

/// Options of reading a drawing of lines, as the command line names them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReadingRequest {
    /// Distance within which lines of a drawing are meant to meet, in the drawing's own units.
    pub tolerance: Option<f64>,
    /// Moving of vertices, so that lines are straight or parallel and creases fold flat that nearly do.
    #[serde(serialize_with = "by_name")]
    pub straighten: Straighten,
    /// Letters of the colours of an SVG drawing.
    #[serde(serialize_with = "as_text")]
    pub colors: Option<ColourLetters>,
}

impl Default for ReadingRequest {
    fn default() -> Self {
        Self {
            tolerance: None,
            straighten: Straighten::Auto,
            colors: None,
        }
    }
}

impl ReadingRequest {
    /// Returns the reader's options.
    ///
    /// # Errors
    /// If the tolerance is no positive length.
    pub fn options(&self) -> Result<ReadOptions, RequestError> {
        let is_length = |tolerance: f64| tolerance > 0.0 && tolerance.is_finite();
        if let Some(found) = self.tolerance.filter(|tolerance| !is_length(*tolerance)) {
            return Err(RequestError::Usage(format!(
                "--tolerance: expected a finite length above 0, found {found}"
            )));
        }
        Ok(ReadOptions {
            format: None,
            tolerance: self.tolerance,
            straighten: self.straighten,
            colours: self.colors.clone().unwrap_or_default(),
        })
    }
}

/// Serialises letters of colours as their text.
#[allow(clippy::ref_option, reason = "serde passes the field so")]
fn as_text<S: Serializer>(value: &Option<ColourLetters>, serializer: S) -> Result<S::Ok, S::Error> {
    let text = value.as_ref().map(ToString::to_string);
    text.serialize(serializer)
}

/// Returns the time that `--timeout` allows, if it does.
///
/// # Errors
/// If the number of seconds is negative or not a number.
pub fn timeout(seconds: Option<f64>) -> Result<Option<Duration>, RequestError> {
    let timeout = seconds.map(|seconds| {
        // A number of seconds that is too large for a `Duration` is no timeout.
        let timeout = Duration::try_from_secs_f64(seconds).ok();
        (seconds >= 0.0).then_some(timeout).ok_or_else(|| {
            let text = format!("--timeout: expected seconds from 0, found {seconds}");
            RequestError::Usage(text)
        })
    });
    Ok(timeout.transpose()?.flatten())
}
