//! Levenberg-Marquardt: finds a configuration near a given one in which every star closes.
//!
//! Implements the method of [Nielsen1999](crate#references) (damping adapted by the gain ratio) in the form of
//! [YamashitaFukushima2001](crate#references) for zero-residual problems: the damping is λ = ½μ‖r(v)‖² of the star or
//! loop that closes worst, with μ adapted as Nielsen adapts λ. This damping vanishes with the residual, so that
//! convergence stays quadratic although the Jacobian of a folding sheet is always rank deficient (the sheet has a
//! motion). The sum over all stars would make the damping grow with the sheet, although only two stars bind each hinge
//! on a sheet of any size. The sum is used only while the residual is acceptable: the rest may then be rounding, which
//! should move nothing.
//!
//! Differs from both sources in two ways. The length of each step is bounded, because undamped steps far from closing
//! were seen to wander off to multiples of 2π. And each step is kept within the [`Limits`].
//!
//! On large sheets factorisations are most of the cost. If [`Steps::Repeated`] allows it, a factor is used again for
//! steps -(J₀ᵀJ₀ + λI)⁻¹J₀ᵀr(x) with the rows of the point where the factor was made. One such step raises the order of
//! convergence to three, [Fan2012](crate#references), and more of them are worth their price as long as they leave
//! little (the chord method, chapter 5.4 of [Kelley1995](crate#references)). The matrix J₀ᵀ in front of r has to be the
//! old one too: with the current Jᵀ the step would have a part along the motion of J₀, which the inverse enlarges by
//! 1/λ. An unknown that reaches a limit is fixed for the rest of the step. It is taken out of the factor by a Schur
//! complement ([GillMurraySaundersWright1990](crate#references)), at the cost of one solve. With [`Steps::Rough`],
//! steps far from closing come from [`conjugate_gradients`](crate::conjugate_gradients) while the linear model lets
//! them close most of what is open.
//!
//! The last step of a run is often so short that the sheet closes for certain, by the residual of the linear model and
//! a bound on second derivatives. The residual is then not evaluated at the last point.

use crate::Scalar;
use crate::dense::dot;
use crate::least_squares::{
    ClosureProblem, Limits, NormalEquations, Options, Outcome, Report, Steps,
};

/// First μ. The damping starts at ½‖r(v)‖², below the curvature of any star that has more than a fraction of a radian
/// to close.
const FIRST_MU: f64 = 1.0;
/// Smallest μ, so that after a long run of good steps a bad one is soon damped again.
const MIN_MU: f64 = 1e-6;
/// Smallest damping, in precisions (ε) of the largest diagonal entry of JᵀJ; also the factor by which the damping grows
/// if the matrix is not positive definite.
const FLOOR: f64 = 16.0;
/// Largest number of times that one iteration computes its step, each time with more unknowns at their limits. Two or
/// three times are seen.
const ROUNDS: u32 = 8;
/// Closure residual down to which rough steps are made.
const ROUGH: f64 = 1e-2;
/// Fraction of ½‖r‖² that a rough step has to promise for another rough step to follow.
const ENOUGH: f64 = 0.9;
/// Fraction of the residual that a step may leave if another step with the same factor is to follow. A new factor costs
/// as much as six to ten such steps. Sheets of 50 to 1,700 unknowns are closed soonest with fractions of 0.1 to 0.5.
const LEFT: f64 = 0.25;
/// Number of times that the damped projection is applied. With fewer, rates in `f32` keep errors of 1e-4 where the
/// waterbomb's smallest singular value is a twelfth of the largest.
const PROJECTIONS: u32 = 4;

/// Moves `x` (radians) to a configuration near it in which every star closes.
///
/// `workspace` needs 2n numbers. On return `x` is the best point found, whatever the outcome.
///
/// Cost of an iteration: one linearisation and one factorisation, and one more factorisation each time that more
/// unknowns reach their limits. With [`Steps::Repeated`] each unknown at a limit costs one solve instead, and some
/// iterations take several steps with one factor, each for an evaluation without derivatives. With [`Steps::Rough`]
/// some iterations make no factorisation.
pub fn solve<T: Scalar, E: NormalEquations<T>>(
    problem: &mut ClosureProblem<'_, T>,
    equations: &mut E,
    limits: Limits<'_, T>,
    options: &Options<T>,
    x: &mut [T],
    workspace: &mut [T],
) -> Report<T> {
    let n = problem.unknowns();
    let mut report = Report::capacity();
    let Some((step, rest)) = workspace.split_at_mut_checked(n) else {
        return report;
    };
    let Some(trial) = rest.get_mut(..n) else {
        return report;
    };
    if x.len() != n || equations.unknowns() != n {
        return report;
    }

    for (index, value) in x.iter_mut().enumerate() {
        *value = limits.clamp(index, *value);
    }
    let Some(mut cost) = problem.linearise(x, equations) else {
        return report;
    };
    report.evaluations += 1;
    // The cost does not show an unknown that is in no star, so the unknowns are checked as well.
    if !cost.is_finite() || !x.iter().all(|value| value.is_finite()) {
        report.outcome = Outcome::NotFinite;
        return report;
    }
    let repeated = E::KEEPS_ROWS && options.steps != Steps::Exact;
    let mut roughly = E::KEEPS_ROWS && options.steps == Steps::Rough;
    let (mut mu, mut growth) = (T::lit(FIRST_MU), T::TWO);
    report.outcome = loop {
        report.residual = cost.max();
        if report.residual <= options.tolerance {
            break Outcome::Converged;
        }
        if report.iterations == options.max_iterations {
            break Outcome::IterationLimit;
        }
        report.iterations += 1;

        // This finds most of the unknowns that stay at their limits without a step that passes a limit.
        for (index, &value) in x.iter().enumerate() {
            let slope = equations.gradient().get(index).copied();
            if slope.is_some_and(|slope| limits.blocks(index, value, slope)) {
                equations.hold(index, T::zero());
            }
        }
        let square = if report.residual <= options.acceptable {
            cost.half_square
        } else {
            cost.max_square * T::HALF
        };
        let damping = mu * square;
        trial.copy_from_slice(x);
        roughly &= report.residual > options.acceptable.max(T::lit(ROUGH));
        let by = if roughly { By::Rows } else { By::Factor };
        let made = bounded_step(equations, limits, options, damping, by, trial, step);
        let Some(Step {
            promised,
            by,
            exact,
        }) = made
        else {
            break Outcome::Stalled;
        };
        roughly &= by == By::Rows && promised >= T::lit(ENOUGH) * cost.half_square;
        if report.residual <= options.acceptable && promised < T::HALF * cost.half_square {
            break Outcome::Stalled;
        }
        let mut moved = T::zero();
        for ((step, &trial), &x) in step.iter_mut().zip(&*trial).zip(&*x) {
            *step = trial - x;
            moved = moved.max(step.abs());
        }
        if moved <= T::EPSILON {
            break Outcome::Stalled;
        }
        // Estimate of the residual that the step leaves: right in the median. If the new point probably closes, or if
        // the factor may be used again, derivatives are not needed there; if it closes for certain, no evaluation is
        // needed.
        let left = moved * moved * T::HALF;
        if exact && left <= options.tolerance {
            let bend = problem.bend(step);
            let within = |bound: &T| *bound <= options.tolerance;
            let halves = [cost.half_square, cost.half_square - promised];
            let bound = within(&bend).then(|| bend + equations.left(step, halves));
            if let Some(bound) = bound.filter(within) {
                x.copy_from_slice(trial);
                report.residual = bound;
                break Outcome::Converged;
            }
        }
        let again = repeated && by != By::Rows;
        let alone = again || left <= options.tolerance;
        let new_cost = if alone {
            problem.renew(trial, equations)
        } else {
            problem.linearise(trial, equations)
        };
        let Some(new_cost) = new_cost else {
            break Outcome::Capacity;
        };
        report.evaluations += 1;
        let gain = cost.half_square - new_cost.half_square;
        if new_cost.is_finite() && gain > T::zero() {
            x.copy_from_slice(trial);
            let mut before = core::mem::replace(&mut cost, new_cost);
            let bend = T::TWO * gain / promised.max(T::EPSILON * gain) - T::one();
            let third = T::one() / (T::TWO + T::one());
            mu = (mu * (T::one() - bend * bend * bend).max(third)).max(T::lit(MIN_MU));
            growth = T::TWO;
            let enough = options.tolerance.max(options.acceptable);
            while again && cost.max() > enough && cost.max() <= T::lit(LEFT) * before.max() {
                let by = By::LastFactor;
                let made = bounded_step(equations, limits, options, damping, by, trial, step);
                let next = made.and_then(|_| problem.renew(trial, equations));
                let Some(next) = next else {
                    break;
                };
                report.evaluations += 1;
                if !next.is_finite() || next.half_square >= cost.half_square {
                    break;
                }
                x.copy_from_slice(trial);
                before = core::mem::replace(&mut cost, next);
            }
            if alone && cost.max() > options.tolerance {
                problem.linearise(x, equations);
                report.evaluations += 1;
            }
        } else {
            problem.linearise(x, equations);
            report.evaluations += 1;
            mu *= growth;
            growth *= T::TWO;
            if !mu.is_finite() {
                break Outcome::Stalled;
            }
        }
    };
    report
}

/// Method by which a step is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum By {
    /// With a new factor of the matrix.
    Factor,
    /// With the last factor.
    LastFactor,
    /// Approximately, from the rows, without a factor.
    Rows,
}

/// A step within the limits.
struct Step<T> {
    /// Decrease of ½‖r‖² that the linear model promises.
    promised: T,
    /// Method of the last computation of the step.
    by: By,
    /// `true` if the promise holds to rounding: the factor was made for this step, and no unknown was clamped after it.
    exact: bool,
}

/// Moves `trial` by the damped step within the limits. Returns `None` if no damping makes the matrix positive definite.
///
/// An unknown whose step would pass a limit is moved to the limit and fixed. The step of the others is then computed
/// anew, because it relied on the part that was cut off. For that the factor is [amended](NormalEquations::amend),
/// unless steps are exact. A rough step is replaced by one with a factor as soon as it meets a limit.
fn bounded_step<T: Scalar, E: NormalEquations<T>>(
    equations: &mut E,
    limits: Limits<'_, T>,
    options: &Options<T>,
    mut damping: T,
    mut by: By,
    trial: &mut [T],
    step: &mut [T],
) -> Option<Step<T>> {
    let (mut growth, mut rounds) = (T::zero(), 0);
    loop {
        match by {
            By::Rows => equations.rough_step(damping, step),
            By::LastFactor => equations.step(step),
            By::Factor => {
                // With less damping the factorisation cannot tell the matrix from a singular one.
                let least = equations.max_diagonal() * T::EPSILON * T::lit(FLOOR);
                damping = damping.max(least);
                while !equations.factorise(damping) {
                    damping *= T::lit(FLOOR);
                    if damping <= T::zero() || !damping.is_finite() {
                        return None;
                    }
                }
                equations.step(step);
            }
        }
        rounds += 1;
        let scale = bound(step, options.max_step);
        let promised = promised(step, equations.gradient(), damping, scale);
        let (mut cut, mut exact) = (false, by == By::Factor);
        let mut amended = options.steps != Steps::Exact && by != By::Rows;
        for (index, (step, trial)) in step.iter_mut().zip(&mut *trial).enumerate() {
            let wanted = *trial + *step * scale;
            *step = limits.clamp(index, wanted);
            exact &= *step == wanted;
            if (wanted - *step).abs() > options.tolerance && rounds < ROUNDS {
                growth += equations.hold(index, *step - *trial);
                amended = amended && equations.amend(index);
                *trial = *step;
                cut = true;
            }
        }
        if !cut {
            trial.copy_from_slice(step);
            return Some(Step {
                promised: promised - growth,
                by,
                exact,
            });
        }
        by = if amended { By::LastFactor } else { By::Factor };
    }
}

/// Returns the factor that shortens `step` so that no unknown moves by more than `max_step`.
fn bound<T: Scalar>(step: &[T], max_step: T) -> T {
    let largest = step.iter().fold(T::zero(), |max, &d| max.max(d.abs()));
    if largest > max_step {
        max_step / largest
    } else {
        T::one()
    }
}

/// Returns the decrease of ½‖r‖² that the linear model promises for s·d, with the damped step d and the factor s that
/// shortens it: -s g·d - ½ s² dᵀJᵀJd, where dᵀJᵀJd = -g·d - λ d·d.
fn promised<T: Scalar>(step: &[T], gradient: &[T], damping: T, scale: T) -> T {
    let (slope, square) = (dot(gradient, step), dot(step, step));
    scale * (scale * T::HALF * (slope + damping * square) - slope)
}

/// Replaces `direction` by its projection on the null space of the Jacobian last accumulated: the infinitesimal motion
/// nearest to it.
///
/// λ(JᵀJ + λI)⁻¹d tends to the projection with λ → 0. Applied k times, it leaves (λ/σ²)ᵏ of the part of d that is no
/// motion, with σ the smallest singular value that is not zero. Returns `false` if the matrix with this λ is not
/// positive definite, or if the result is not finite.
pub fn project_on_motions<T: Scalar, E: NormalEquations<T>>(
    equations: &mut E,
    direction: &mut [T],
) -> bool {
    let damping = projection_damping(equations);
    equations.factorise(damping) && project_by_factor(equations, damping, PROJECTIONS, direction)
}

/// Returns the λ of [`project_on_motions`]: the square root of the precision, so that the rounding error ε/λ stays as
/// small as λ itself.
pub fn projection_damping<T: Scalar, E: NormalEquations<T>>(equations: &mut E) -> T {
    equations.max_diagonal().max(T::EPSILON) * T::EPSILON.sqrt()
}

/// Second half of [`project_on_motions`]: applies the damped projection `times` times with the last factor, which has
/// to have this `damping`. Returns `false` if the result is not finite.
pub fn project_by_factor<T: Scalar, E: NormalEquations<T>>(
    equations: &mut E,
    damping: T,
    times: u32,
    direction: &mut [T],
) -> bool {
    for _ in 0..times {
        equations.solve(direction);
        for entry in direction.iter_mut() {
            *entry *= damping;
        }
    }
    direction.iter().all(|entry| entry.is_finite())
}
