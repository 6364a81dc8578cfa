//! Whole paths: the run time that a bound on deformation and gap costs, and the errors that it achieves.

use core::time::Duration;
use std::time::Instant;

use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, Outcome, Plan, PlanOptions, Search, Solver, Symmetry, plan};

use super::Family;
use super::measure::median;

/// Method by which a path is searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// Along the motion, closed by Levenberg-Marquardt.
    Motion,
    /// Along the motion, closed by the gradient solver.
    MotionByGradient,
    /// By the report's randomised search, with samples closed by Levenberg-Marquardt.
    Random,
}

impl Route {
    /// All routes.
    pub const ALL: [Self; 3] = [Self::Motion, Self::MotionByGradient, Self::Random];

    /// Returns the name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Motion => "motion, LM",
            Self::MotionByGradient => "motion, gradient",
            Self::Random => "random, LM",
        }
    }
}

/// Amount of work of a measurement.
#[derive(Clone, Copy, Debug)]
pub struct PathEffort {
    /// Largest number of plans.
    pub plans: usize,
    /// Time for all plans.
    pub budget: Duration,
    /// Time that one plan has.
    pub limit: Duration,
}

/// Result of planning at a bound.
#[derive(Clone, Debug)]
pub struct PathCell {
    /// Family and size.
    pub sheet: String,
    /// `true` if crease groups were used.
    pub symmetric: bool,
    /// Method by which the path was searched.
    pub route: Route,
    /// Bound on deformation and gap.
    pub bound: f64,
    /// Number of plans.
    pub plans: usize,
    /// Median time of a plan, seconds.
    pub seconds: f64,
    /// The last plan.
    pub plan: Plan,
}

impl PathCell {
    /// Returns `true` if the path reaches the goal within the bound.
    #[must_use]
    pub fn is_planned(&self) -> bool {
        self.plan.outcome == Outcome::Planned
    }

    /// Returns sheet and kind of unknowns as text.
    #[must_use]
    pub fn name(&self) -> String {
        let kind = if self.symmetric { "groups" } else { "full" };
        format!("{}, {kind}", self.sheet)
    }
}

/// Returns the bounds, 1e-1 to 1e-12.
#[must_use]
pub fn bounds() -> Vec<f64> {
    (1..=12).map(|power| 10_f64.powi(-power)).collect()
}

/// Plans the sheets at all bounds, without the search for crossings, whose time does not depend on the bound. A route
/// that runs out of time at a bound is not run at a finer one.
///
/// # Panics
/// If a generator of the library breaks its contract.
#[must_use]
pub fn measure_paths(sheets: &[(Family, usize, usize)], effort: &PathEffort) -> Vec<PathCell> {
    let mut cells = Vec::new();
    for &(family, rows, columns) in sheets {
        let pattern = CreasePattern::new(family.drawing(rows, columns)).expect("a pattern");
        let goal = Goal::of_pattern(&pattern).expect("a goal");
        for symmetric in [true, false] {
            let mut routes = Route::ALL.to_vec();
            for bound in bounds() {
                routes.retain(|&route| {
                    let options = options(route, symmetric, bound, effort.limit);
                    let (seconds, plan, plans) = plan_often(&pattern, &goal, &options, effort);
                    let in_time = plan.outcome != Outcome::Timeout;
                    cells.push(PathCell {
                        sheet: format!("{} {rows}x{columns}", family.name()),
                        symmetric,
                        route,
                        bound,
                        plans,
                        seconds,
                        plan,
                    });
                    in_time
                });
            }
        }
        eprintln!("paths of {} {rows}x{columns}", family.name());
    }
    cells
}

fn options(route: Route, symmetric: bool, bound: f64, limit: Duration) -> PlanOptions {
    let (search, solver) = match route {
        Route::Motion => (Search::Path, Solver::LevenbergMarquardt),
        Route::MotionByGradient => (Search::Path, Solver::Gradient),
        Route::Random => (Search::Random, Solver::LevenbergMarquardt),
    };
    PlanOptions::default().with(|it| {
        it.bound = bound;
        it.search = search;
        it.solver = solver;
        it.symmetry = if symmetric {
            Symmetry::Auto
        } else {
            Symmetry::Off
        };
        it.collision = false;
        it.timeout = Some(limit);
    })
}

/// Returns the median time in seconds, the last plan and the number of plans.
fn plan_often(
    pattern: &CreasePattern,
    goal: &Goal,
    options: &PlanOptions,
    effort: &PathEffort,
) -> (f64, Plan, usize) {
    let began = Instant::now();
    let mut times = Vec::new();
    loop {
        let start = Instant::now();
        let answer = plan(pattern, goal, options);
        times.push(start.elapsed().as_secs_f64());
        if times.len() >= effort.plans || began.elapsed() >= effort.budget {
            let plans = times.len();
            return (median(times), answer, plans);
        }
    }
}
