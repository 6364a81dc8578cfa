//! A gradient solver with O(n) memory: closes stars on controllers without room for a matrix.
//!
//! Implements the first step length of [BarzilaiBorwein1988](crate#references), α = s·s / s·y, with the non-monotone
//! safeguard of [Raydan1997](crate#references): a step that does not improve on the worst of the last costs is halved.
//! Converges linearly, whereas Levenberg-Marquardt converges quadratically.

use crate::Scalar;
use crate::dense::{copy, dot};
use crate::least_squares::{ClosureProblem, Gradient, Limits, Options, Outcome, Report, split};

/// Number of past costs against which a step is judged. With 1 the descent would be monotone, which takes away what
/// makes the method fast.
const PAST_COSTS: usize = 8;
/// Fraction of the linear decrease that a step must reach (Armijo's condition).
const MIN_DECREASE_RATIO: f64 = 1e-4;

/// Moves `x` (radians) to a configuration near it in which every star closes.
///
/// `workspace` needs 3n numbers. On return `x` is the last point accepted, whatever the outcome. Cost of an iteration:
/// one linearisation. Expect hundreds of iterations where [`levenberg_marquardt`](crate::levenberg_marquardt) takes
/// five.
pub fn solve<T: Scalar>(
    problem: &mut ClosureProblem<'_, T>,
    limits: Limits<'_, T>,
    options: &Options<T>,
    x: &mut [T],
    workspace: &mut [T],
) -> Report<T> {
    let mut report = Report::capacity();
    let Some([gradient, trial, trial_gradient]) = split(workspace, problem.unknowns()) else {
        return report;
    };
    let Some(mut cost) = problem.start(x, limits, &mut Gradient(gradient), &mut report) else {
        return report;
    };
    let mut last_costs = [cost.half_square; PAST_COSTS];
    let mut length = T::one();
    let mut restarted = false;
    report.outcome = loop {
        report.residual = cost.max();
        if report.residual <= options.tolerance {
            break Outcome::Converged;
        }
        if report.iterations == options.max_iterations {
            break Outcome::IterationLimit;
        }
        report.iterations += 1;

        let steepest = gradient.iter().fold(T::zero(), |max, &g| max.max(g.abs()));
        if steepest <= T::zero() {
            break Outcome::Stalled;
        }
        length = length.min(options.max_step / steepest);
        let (mut decrease, mut moved) = (T::zero(), T::zero());
        for (index, ((&x, &g), trial)) in x.iter().zip(&*gradient).zip(&mut *trial).enumerate() {
            *trial = limits.clamp(index, x - g * length);
            decrease += g * (x - *trial);
            moved = moved.max((x - *trial).abs());
        }
        if moved <= T::EPSILON * T::EPSILON {
            // The length may have become too short to move at all: restart once from the first length.
            if restarted {
                break Outcome::Stalled;
            }
            restarted = true;
            length = T::one();
            continue;
        }
        let Some(new_cost) = problem.linearise(trial, &mut Gradient(trial_gradient)) else {
            break Outcome::Capacity;
        };
        report.evaluations += 1;
        let worst = last_costs.iter().fold(T::zero(), |max, &c| max.max(c));
        let enough = worst - T::lit(MIN_DECREASE_RATIO) * decrease;
        if !(new_cost.is_finite() && new_cost.half_square <= enough) {
            length *= T::HALF;
            continue;
        }
        restarted = false;
        length = barzilai_borwein(x, gradient, trial, trial_gradient, options.max_step);
        copy(trial, x);
        copy(trial_gradient, gradient);
        cost = new_cost;
        last_costs.rotate_left(1);
        if let Some(last) = last_costs.last_mut() {
            *last = cost.half_square;
        }
    };
    report
}

/// Returns s·s / s·y of the step s and the change y of the gradient, or the longest step allowed if the curvature along
/// s is not positive.
fn barzilai_borwein<T: Scalar>(
    x: &[T],
    gradient: &[T],
    new_x: &mut [T],
    new_gradient: &[T],
    longest: T,
) -> T {
    let (mut ss, mut sy) = (T::zero(), T::zero());
    for ((&x, &g), (&new_x, &new_g)) in x.iter().zip(gradient).zip(new_x.iter().zip(new_gradient)) {
        let s = new_x - x;
        ss += s * s;
        sy += s * (new_g - g);
    }
    let steepest = dot(new_gradient, new_gradient).sqrt();
    let longest = longest / steepest.max(T::EPSILON * T::EPSILON);
    if sy > T::zero() {
        (ss / sy).min(longest)
    } else {
        longest
    }
}
