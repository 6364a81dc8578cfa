//! The adaptive randomised search of [XiLien2015](foldpath_core#references), section 4.
//!
//! A random configuration round the current one, biased to the goal, is moved to a closed one. If the closed one is
//! nearer to the goal, feasible and within the objective's tolerance, it becomes the next knot. Differs from the source
//! in that Levenberg-Marquardt closes the configuration, and in how the radius of the samples adapts.

use foldpath_core::least_squares::Limits;
use foldpath_core::sampling::random_near;
use rand_pcg::Pcg64;

use super::follow::{Followed, REACHED_RAD, Rules, Waypoint, approach};
use crate::planner::PlanOptions;
use crate::planner::closing::solver::ClosureSolver;
use crate::planner::reason::Stop;
use crate::planner::vectors::{max_difference, max_norm, norm, way_to};

/// Spread of the random part of a step, as a fraction of the sampling radius.
const SPREAD_RATIO: f64 = 0.5;
/// Number of failures in a row after which the sampling radius shrinks.
const MAX_FAILURES: usize = 5;
/// Factor on the sampling radius after these failures.
const NARROWING_FACTOR: f64 = 0.6;
/// Factor on the sampling radius after a success.
const WIDENING_FACTOR: f64 = 1.3;
/// Sampling radius, as a fraction of the largest step, below which the search restarts with the largest step.
const MIN_RADIUS_RATIO: f64 = 1e-3;

/// Searches from flat to `asked`, or as near as it comes. `closed` is the closed configuration at the goal, if one is
/// known; `feasible` judges configurations that would become knots. Gives up after `most_restarts` restarts without a
/// success between them.
pub(crate) fn search(
    solver: &mut ClosureSolver<'_>,
    asked: &[Option<f64>],
    closed: Option<&[f64]>,
    most_restarts: usize,
    rules: Rules<'_>,
    options: &PlanOptions,
    feasible: &mut dyn FnMut(&[f64]) -> bool,
) -> Followed {
    let mut rng = Pcg64::new(u128::from(options.seed), 0);
    let mut knots = vec![vec![0.0; asked.len()]];
    let max_step = rules.max_step;
    let mut radius = SamplingRadius::new(max_step);
    let whole = norm(&way_to(asked, &knots[0]));
    let stop = loop {
        let here = &knots[knots.len() - 1];
        let way = way_to(asked, here);
        let (far, longest) = (norm(&way), max_norm(&way));
        rules.tell(far, whole);
        if far <= REACHED_RAD {
            break None;
        }
        let last = match closed {
            Some(closed) => {
                Some(closed.to_vec()).filter(|_| max_difference(closed, here) <= max_step)
            }
            None if longest <= max_step => {
                last_step(solver, here, asked, rules).filter(|it| feasible(it))
            }
            None => None,
        };
        if let Some(last) = last {
            knots.push(last);
            break None;
        }
        if solver.is_late() {
            break Some(Stop::Timeout);
        }
        if radius.restarts == most_restarts {
            break Some(Stop::Nearest);
        }
        let mut next = radius.sample(&mut rng, here, &way);
        let is_good = solver.closes(&mut next)
            && max_difference(&next, here) <= max_step
            && rules.allow(here, &next)
            && norm(&way_to(asked, &next)) < far
            && solver.objective(options.objective, &next) <= solver.objective_tolerance()
            && feasible(&next);
        radius.adapt(is_good);
        if is_good {
            knots.push(next);
        }
    };
    Followed {
        waypoints: polyline(&knots),
        stop,
    }
}

/// Returns the configuration with the angles asked for, if one step leads to it.
fn last_step(
    solver: &mut ClosureSolver<'_>,
    here: &[f64],
    asked: &[Option<f64>],
    rules: Rules<'_>,
) -> Option<Vec<f64>> {
    let last = approach(solver, here.to_vec(), asked);
    let is_last = norm(&way_to(asked, &last)) <= REACHED_RAD
        && max_difference(&last, here) <= rules.max_step
        && rules.allow(here, &last);
    is_last.then_some(last)
}

/// The radius round a configuration within which samples are drawn, which adapts to their success.
struct SamplingRadius {
    /// Radius, radians.
    size: f64,
    /// Largest radius.
    max: f64,
    /// Number of failures in a row.
    failures: usize,
    /// Number of restarts with the largest radius since the last success.
    restarts: usize,
}

impl SamplingRadius {
    fn new(max: f64) -> Self {
        Self {
            size: max,
            max,
            failures: 0,
            restarts: 0,
        }
    }

    /// Draws a configuration round the place at which a step of the radius along `way` ends.
    fn sample(&self, rng: &mut Pcg64, here: &[f64], way: &[f64]) -> Vec<f64> {
        let part = (self.size / max_norm(way)).min(1.0);
        let ahead: Vec<f64> = here.iter().zip(way).map(|(x, w)| x + part * w).collect();
        let mut next = ahead.clone();
        let spread = SPREAD_RATIO * self.size;
        random_near(rng, &ahead, spread, Limits::HalfTurn, &mut next);
        next
    }

    /// Widens the radius after a success, narrows it after several failures, and restarts if it becomes too small.
    fn adapt(&mut self, is_success: bool) {
        if is_success {
            self.size = (self.size * WIDENING_FACTOR).min(self.max);
            (self.failures, self.restarts) = (0, 0);
            return;
        }
        self.failures += 1;
        if self.failures == MAX_FAILURES {
            (self.size, self.failures) = (self.size * NARROWING_FACTOR, 0);
            if self.size < MIN_RADIUS_RATIO * self.max {
                self.size = self.max;
                self.restarts += 1;
            }
        }
    }
}

/// Makes waypoints of configurations that no motion joins. The tangent at each one is that of the chord between its
/// neighbours.
pub(crate) fn polyline(knots: &[Vec<f64>]) -> Vec<Waypoint> {
    let last = knots.len() - 1;
    let waypoint = |k: usize| {
        let (from, to) = (&knots[k.saturating_sub(1)], &knots[(k + 1).min(last)]);
        let chord: Vec<f64> = to.iter().zip(from).map(|(a, b)| a - b).collect();
        let length = norm(&chord).max(f64::MIN_POSITIVE);
        Waypoint::new(knots[k].clone(), chord.iter().map(|c| c / length).collect())
    };
    (0..knots.len()).map(waypoint).collect()
}
