//! The adaptive randomised search of [XiLien2015](foldpath#references), section 4, with NLopt.
//!
//! It is as fast as it could be made: stars are products of quaternions, forward differences evaluate only the stars
//! that change, the folding map is foldpath's, and so is the collision scene, whose bounding-box hierarchy is refitted
//! from one configuration to the next. The report says neither how samples are biased nor how the search adapts. Here a
//! fraction of each step goes straight to the goal and the rest in a random direction. Several failures in a row shrink
//! the radius of samples. Within one step of the goal the goal itself is tried.

use core::f64::consts::PI;
use core::time::Duration;
use std::time::Instant;

use foldpath::collision::{CollisionScene, contact_tolerance};
use foldpath::folding::FoldingMap;
use nlopt::{FailState, Nlopt, Target};
use rand_core::Rng;
use rand_pcg::Pcg64;

use super::objective::ClosureObjective;
use super::sheet::Sheet;

/// NLopt's algorithms that are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    /// Linear approximations, no derivatives.
    Cobyla,
    /// The simplex of Nelder and Mead, no derivatives.
    NelderMead,
    /// Quadratic models, no derivatives.
    Bobyqa,
    /// Sequential quadratic programming, with forward differences.
    Slsqp,
    /// Limited-memory quasi-Newton, with forward differences.
    Lbfgs,
}

impl Algorithm {
    /// All algorithms.
    pub const ALL: [Self; 5] = [
        Self::Slsqp,
        Self::Lbfgs,
        Self::NelderMead,
        Self::Bobyqa,
        Self::Cobyla,
    ];

    /// Returns the name of the algorithm.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cobyla => "COBYLA",
            Self::NelderMead => "Nelder-Mead",
            Self::Bobyqa => "BOBYQA",
            Self::Slsqp => "SLSQP",
            Self::Lbfgs => "L-BFGS",
        }
    }

    fn of_nlopt(self) -> nlopt::Algorithm {
        match self {
            Self::Cobyla => nlopt::Algorithm::Cobyla,
            Self::NelderMead => nlopt::Algorithm::Neldermead,
            Self::Bobyqa => nlopt::Algorithm::Bobyqa,
            Self::Slsqp => nlopt::Algorithm::Slsqp,
            Self::Lbfgs => nlopt::Algorithm::Lbfgs,
        }
    }
}

/// Condition under which a configuration is rigid enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accept {
    /// The deformation is at most this: the report's bounded search.
    Deformation(f64),
    /// F(C) is below this, whatever the deformation: the search of the report's Figure 3.
    Objective(f64),
}

impl Accept {
    /// Returns the value of F below which minimisation may stop.
    fn enough(self) -> f64 {
        match self {
            Self::Deformation(bound) => 0.1 * bound,
            Self::Objective(bound) => 0.99 * bound,
        }
    }
}

/// Settings of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// NLopt's algorithm.
    pub algorithm: Algorithm,
    /// MI: largest number of evaluations of F that NLopt may take for a configuration.
    pub max_evaluations: u32,
    /// Condition under which a configuration is accepted.
    pub accept: Accept,
    /// `true` if configurations in which faces pass through each other are refused.
    pub collision: bool,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Time after which the search gives up.
    pub limit: Duration,
}

/// End of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The goal was reached.
    Reached,
    /// The goal itself deforms too much.
    GoalDeforms,
    /// At the goal faces pass through each other.
    GoalCrosses,
    /// Too many samples in a row were refused.
    Stuck,
    /// The time is over.
    Timeout,
}

/// Result of a search.
#[derive(Clone, Debug)]
pub struct Run {
    /// End of the search.
    pub end: End,
    /// Configurations of the unknowns (radians) from flat as far as the search came.
    pub knots: Vec<Vec<f64>>,
    /// Fraction of the distance to the goal that was reached.
    pub reached: f64,
    /// Time in all.
    pub time: Duration,
    /// Time in the search for crossings.
    pub collision: Duration,
    /// Number of samples.
    pub samples: u64,
}

/// Largest step of a hinge from a configuration to a sample, radians.
pub(super) const STEP: f64 = 0.22;
/// Least fraction of a step that goes straight to the goal.
const BIAS: f64 = 0.5;
/// First step of algorithms without derivatives, radians.
const FIRST_STEP: f64 = 0.05;
/// Relative change of the unknowns at which NLopt may stop, because it gains nothing more.
const STALLED: f64 = 1e-12;
/// Failures in a row after which the radius of samples shrinks (`PATIENCE`), factor by which it shrinks, and factor by
/// which it grows after a success.
const PATIENCE: u32 = 5;
const NARROWER: f64 = 0.6;
const WIDER: f64 = 1.3;
/// Radius below which the search begins again with the largest one, radians.
const NARROWEST: f64 = 1e-3 * STEP;
/// Failures in a row after which the search is stuck.
const MOST_FAILURES: u32 = 1000;

/// Searches a path from flat to the goal of the sheet.
///
/// # Panics
/// If NLopt refuses its settings, which would be a mistake here.
#[must_use]
pub fn search(sheet: &Sheet, settings: &Settings) -> Run {
    let start = Instant::now();
    let goal = &sheet.goal_angles;
    let mut rng = Pcg64::new(u128::from(settings.seed), 0);
    let mut pusher = pusher(sheet, settings);
    let mut judge = Judge::new(sheet, settings);
    let mut here = vec![0.0; goal.len()];
    let mut sample = here.clone();
    let mut knots = vec![here.clone()];
    let whole = distance(goal, &here);
    let (mut radius, mut failures, mut samples) = (STEP, 0, 0);
    let end = loop {
        let longest = goal.iter().zip(&here).map(|(g, h)| (g - h).abs());
        let longest = longest.fold(0.0, f64::max);
        if longest <= STEP {
            match judge.judge(goal, None) {
                Verdict::Good => knots.push(goal.clone()),
                Verdict::Deformed => break End::GoalDeforms,
                Verdict::Crossed => break End::GoalCrosses,
            }
            break End::Reached;
        }
        let Some(left) = settings.limit.checked_sub(start.elapsed()) else {
            break End::Timeout;
        };
        let bias = BIAS + (1.0 - BIAS) * uniform(&mut rng);
        for ((x, h), g) in sample.iter_mut().zip(&here).zip(goal) {
            let away = 2.0 * uniform(&mut rng) - 1.0;
            let step = bias * (g - h) / longest + (1.0 - bias) * away;
            *x = (h + radius * step).clamp(-PI, PI);
        }
        samples += 1;
        pusher.set_maxtime(left.as_secs_f64()).expect("a time");
        let value = match pusher.optimize(&mut sample) {
            Ok((_, value)) => Some(value),
            // NLopt has stopped at rounding, or as near as the algorithm comes.
            Err((FailState::RoundoffLimited | FailState::Failure, value)) => Some(value),
            Err((state, _)) => panic!("NLopt: {state:?}"),
        };
        let far = distance(goal, &here);
        if distance(goal, &sample) < far && judge.judge(&sample, value) == Verdict::Good {
            here.copy_from_slice(&sample);
            knots.push(here.clone());
            radius = (radius * WIDER).min(STEP);
            failures = 0;
            continue;
        }
        failures += 1;
        if failures == MOST_FAILURES {
            break End::Stuck;
        }
        if failures % PATIENCE == 0 {
            radius *= NARROWER;
            if radius < NARROWEST {
                radius = STEP;
            }
        }
    };
    Run {
        end,
        reached: match end {
            End::Reached => 1.0,
            _ => 1.0 - distance(goal, &here) / whole,
        },
        knots,
        time: start.elapsed(),
        collision: judge.collision,
        samples,
    }
}

/// Returns NLopt, set up for the sheet.
fn pusher(
    sheet: &Sheet,
    settings: &Settings,
) -> Nlopt<impl nlopt::ObjFn<ClosureObjective>, ClosureObjective> {
    let value = |x: &[f64], gradient: Option<&mut [f64]>, objective: &mut ClosureObjective| {
        match gradient {
            Some(gradient) => objective.value_and_gradient(x, gradient),
            None => objective.value(x),
        }
    };
    let mut pusher = Nlopt::new(
        settings.algorithm.of_nlopt(),
        sheet.goal_angles.len(),
        value,
        Target::Minimize,
        ClosureObjective::new(&sheet.stars),
    );
    let set = [
        pusher.set_lower_bound(-PI),
        pusher.set_upper_bound(PI),
        pusher.set_initial_step1(FIRST_STEP),
        pusher.set_stopval(settings.accept.enough()),
        pusher.set_maxeval(settings.max_evaluations),
        pusher.set_xtol_rel(STALLED),
    ];
    assert!(set.iter().all(Result::is_ok), "NLopt refuses its settings");
    pusher
}

/// Verdict on a configuration: it may be a knot, it deforms too much, or faces cross.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Good,
    Deformed,
    Crossed,
}

/// Judges configurations on the whole sheet.
struct Judge<'a> {
    sheet: &'a Sheet,
    accept: Accept,
    map: FoldingMap,
    /// Ends and squared lengths of edges and virtual edges.
    struts: Vec<([usize; 2], f64)>,
    scene: Option<CollisionScene>,
    objective: Option<ClosureObjective>,
    collision: Duration,
}

impl<'a> Judge<'a> {
    fn new(sheet: &'a Sheet, settings: &Settings) -> Self {
        let strut = |ends: [foldpath::pattern::VertexId; 2]| {
            let length = sheet.pattern.length(ends);
            (ends.map(|end| end.index()), length * length)
        };
        Self {
            sheet,
            accept: settings.accept,
            map: FoldingMap::flat(&sheet.pattern),
            struts: sheet.pattern.struts().map(strut).collect(),
            scene: settings
                .collision
                .then(|| CollisionScene::new(&sheet.pattern)),
            objective: matches!(settings.accept, Accept::Objective(_))
                .then(|| ClosureObjective::new(&sheet.stars)),
            collision: Duration::ZERO,
        }
    }

    /// Judges rigidity and crossings of a configuration; `value` is F at the configuration, if it is known.
    fn judge(&mut self, angles: &[f64], value: Option<f64>) -> Verdict {
        if let (Accept::Objective(bound), Some(objective)) = (self.accept, &mut self.objective) {
            let value = value.unwrap_or_else(|| objective.value(angles));
            if value >= bound {
                return Verdict::Deformed;
            }
        }
        let sheet = self.sheet;
        let memberships = sheet.groups.memberships();
        self.map
            .fold_groups(&sheet.pattern, sheet.pattern.tree(), memberships, angles);
        if let Accept::Deformation(bound) = self.accept
            && self.deformation().is_none_or(|worst| worst > bound)
        {
            return Verdict::Deformed;
        }
        let Some(scene) = &mut self.scene else {
            return Verdict::Good;
        };
        let start = Instant::now();
        let crossing = scene.deepest_crossing(&self.map, contact_tolerance(&sheet.pattern));
        self.collision += start.elapsed();
        match crossing {
            Some(_) => Verdict::Crossed,
            None => Verdict::Good,
        }
    }

    /// Returns the largest relative change of a length; `None` if a length is NaN.
    fn deformation(&self) -> Option<f64> {
        let vertices = self.map.vertices();
        let (mut least, mut greatest) = (1.0_f64, 1.0_f64);
        for &([a, b], square) in &self.struts {
            let ratio = (vertices[b] - vertices[a]).norm_squared() / square;
            if ratio.is_nan() {
                return None;
            }
            least = least.min(ratio);
            greatest = greatest.max(ratio);
        }
        Some((greatest.sqrt() - 1.0).max(1.0 - least.sqrt()))
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

/// Returns a random number from 0 to 1.
fn uniform(rng: &mut impl Rng) -> f64 {
    f64::from(rng.next_u32()) / f64::from(u32::MAX)
}
