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
    let (mut radius, mut failures, mut restarts) = (max_step, 0, 0);
    let whole = norm(&way_to(asked, &knots[0]));
    let stop = loop {
        let here = &knots[knots.len() - 1];
        let way = way_to(asked, here);
        let (far, longest) = (norm(&way), max_norm(&way));
        rules.tell(far, whole);
        if far <= REACHED_RAD {
            break None;
        }
        if let Some(closed) = closed.filter(|closed| max_difference(closed, here) <= max_step) {
            knots.push(closed.to_vec());
            break None;
        }
        if closed.is_none() && longest <= max_step {
            let last = approach(solver, here.clone(), asked);
            let there = norm(&way_to(asked, &last)) <= REACHED_RAD;
            if there
                && max_difference(&last, here) <= max_step
                && rules.allow(here, &last)
                && feasible(&last)
            {
                knots.push(last);
                break None;
            }
        }
        if solver.is_late() {
            break Some(Stop::Timeout);
        }
        if restarts == most_restarts {
            break Some(Stop::Nearest);
        }
        let part = (radius / longest).min(1.0);
        let ahead: Vec<f64> = here.iter().zip(&way).map(|(x, w)| x + part * w).collect();
        let mut next = ahead.clone();
        random_near(
            &mut rng,
            &ahead,
            SPREAD_RATIO * radius,
            Limits::HalfTurn,
            &mut next,
        );
        let good = solver.closes(&mut next)
            && max_difference(&next, here) <= max_step
            && rules.allow(here, &next)
            && norm(&way_to(asked, &next)) < far
            && solver.objective(options.objective, &next) <= solver.objective_tolerance()
            && feasible(&next);
        if good {
            knots.push(next);
            radius = (radius * WIDENING_FACTOR).min(max_step);
            (failures, restarts) = (0, 0);
            continue;
        }
        failures += 1;
        if failures == MAX_FAILURES {
            (radius, failures) = (radius * NARROWING_FACTOR, 0);
            if radius < MIN_RADIUS_RATIO * max_step {
                radius = max_step;
                restarts += 1;
            }
        }
    };
    Followed {
        waypoints: polyline(&knots),
        stop,
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
