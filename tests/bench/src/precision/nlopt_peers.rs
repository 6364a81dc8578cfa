//! Peers of NLopt: its local algorithms on the objective.

use core::time::Duration;
use std::time::Instant;

use foldpath_core::StarsView;
use nlopt::{Algorithm, Nlopt, Target};

use super::evaluator::Evaluator;
use super::method::{Run, Solver};

/// First step of algorithms without derivatives, radians: about half the distance to a solution.
const FIRST_STEP: f64 = 0.1;
/// Value that is returned instead of the objective to stop NLopt; the objective is never below 0.
const STOP: f64 = -1.0;

struct Peer<'a> {
    stars: StarsView<'a, f64>,
    algorithm: Algorithm,
    analytic: bool,
}

/// Returns one of NLopt's algorithms. An algorithm that uses a gradient gets the analytic one, or forward differences.
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
        // However NLopt has ended, the evaluator has the best configuration.
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
