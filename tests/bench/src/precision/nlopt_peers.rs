//! NLopt's local algorithms on the objective.

use core::time::Duration;
use std::time::Instant;

use foldpath_core::StarsView;
use nlopt::{Algorithm, Nlopt, Target};

use super::evaluator::Evaluator;
use super::method::{Run, Solver};

/// Radians: the first step of what goes without derivatives, about half the way to go.
const FIRST_STEP: f64 = 0.1;
/// Returned instead of the objective, which is never below 0, to stop.
const STOP: f64 = -1.0;

struct Peer<'a> {
    stars: StarsView<'a, f64>,
    algorithm: Algorithm,
    analytic: bool,
}

/// NLopt with an algorithm; those that ask for a gradient get the analytic one, or forward differences.
pub(super) fn solver(
    stars: StarsView<'_, f64>,
    algorithm: Algorithm,
    analytic: bool,
) -> Box<dyn Solver + '_> {
    Box::new(Peer {
        stars,
        algorithm,
        analytic,
    })
}

impl Solver for Peer<'_> {
    fn run(&mut self, start: &[f64], tolerance: f64, limit: Duration) -> Run {
        let analytic = self.analytic;
        let objective = move |x: &[f64], gradient: Option<&mut [f64]>, on: &mut Evaluator<'_>| {
            let value = match gradient {
                None => on.value(x),
                Some(gradient) if analytic => on.gradient(x, gradient),
                Some(gradient) => on.differences(x, gradient),
            };
            value.unwrap_or(STOP)
        };
        let mut evaluator = Evaluator::new(self.stars, tolerance);
        let mut x = start.to_vec();
        evaluator.start(limit);
        let minimize = Target::Minimize;
        let mut nlopt = Nlopt::new(self.algorithm, x.len(), objective, minimize, evaluator);
        let half_turn = core::f64::consts::PI;
        let settings = [
            nlopt.set_lower_bound(-half_turn),
            nlopt.set_upper_bound(half_turn),
            nlopt.set_initial_step1(FIRST_STEP),
            nlopt.set_stopval(0.5 * STOP),
        ];
        assert!(
            settings.iter().all(Result::is_ok),
            "NLopt takes the settings"
        );
        let began = Instant::now();
        // However it ended: the evaluator knows the best configuration.
        let _ = nlopt.optimize(&mut x);
        let time = began.elapsed();
        let done = nlopt.recover_user_data();
        Run {
            time,
            values: done.values,
            derivatives: done.derivatives,
            x: done.best,
        }
    }
}
