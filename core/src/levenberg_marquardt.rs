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
//! # Stopping tests
//!
//! With the step d of an iteration and the linear model m(d) = ½‖r + Jd‖²:
//!
//! | outcome | test |
//! |---|---|
//! | [`Converged`](Outcome::Converged) | max ‖r(v)‖ ≤ `tolerance` at x, or a bound on it at x + d |
//! | [`Stalled`](Outcome::Stalled) | max \|dᵢ\| ≤ ε |
//! | [`Stalled`](Outcome::Stalled) | max ‖r(v)‖ ≤ `acceptable`, and m(0) − m(d) < ½ m(0) |
//! | [`Stalled`](Outcome::Stalled) | λ or μ has grown to infinity |
//! | [`IterationLimit`](Outcome::IterationLimit) | `max_iterations` iterations are done |
//!
//! # Reuse of factors
//!
//! On large sheets factorisations are most of the cost. With [`FactorReuse::Chord`], a factor is used again for steps
//! -(J₀ᵀJ₀ + λI)⁻¹J₀ᵀr(x) with the rows of the point where the factor was made. One such step raises the order of
//! convergence to three, [Fan2012](crate#references), and more of them are worth their price as long as they leave
//! little (the chord method, chapter 5.4 of [Kelley1995](crate#references)). The matrix J₀ᵀ in front of r has to be the
//! old one too: with the current Jᵀ the step would have a part along the motion of J₀, which the inverse enlarges by
//! 1/λ. An unknown that reaches a limit is fixed for the rest of the step. It is taken out of the factor by a Schur
//! complement ([GillMurraySaundersWright1990](crate#references)), at the cost of one solve.

use crate::Scalar;
use crate::dense::{copy, dot};
use crate::least_squares::{
    ClosureProblem, Cost, FactorReuse, Limits, NormalEquations, Options, Outcome, Report, split,
};

/// First μ. The damping starts at ½‖r(v)‖², below the curvature of any star that has more than a fraction of a radian
/// to close.
const FIRST_MU: f64 = 1.0;
/// Smallest μ, so that after a long run of good steps a bad one is soon damped again.
const MIN_MU: f64 = 1e-6;
/// Smallest damping, in precisions (ε) of the largest diagonal entry of JᵀJ: with less, a factorisation cannot tell the
/// matrix from a singular one.
const MIN_DAMPING_EPSILONS: f64 = 16.0;
/// Factor by which the damping grows if the matrix is not positive definite.
const DAMPING_GROWTH: f64 = 16.0;
/// Largest number of times that one iteration computes its step, each time with more unknowns at their limits. Two or
/// three times are seen.
const MAX_ROUNDS: u32 = 8;
/// Fraction of the residual that a step may leave if another step with the same factor is to follow. A new factor costs
/// as much as six to ten such steps. Sheets of 50 to 1,700 unknowns are closed soonest with fractions of 0.1 to 0.5.
const MAX_CHORD_RESIDUAL_RATIO: f64 = 0.25;
/// Number of times that the damped projection is applied. With fewer, rates in `f32` keep errors of 1e-4 where the
/// waterbomb's smallest singular value is a twelfth of the largest.
const PROJECTIONS: u32 = 4;

/// Moves `x` (radians) to a configuration near it in which every star closes.
///
/// `workspace` needs 2n numbers. On return `x` is the best point found, whatever the outcome.
///
/// Cost of an iteration: one linearisation and one factorisation, and one more factorisation each time that more
/// unknowns reach their limits. With [`FactorReuse::Chord`] each unknown at a limit costs one solve instead, and some
/// iterations take several steps with one factor, each for an evaluation without derivatives.
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
    if equations.unknowns() == n
        && let Some([step, trial]) = split(workspace, n)
        && let Some(cost) = problem.start(x, limits, equations, &mut report)
    {
        let mut search = Search {
            problem,
            equations,
            limits,
            options,
            x,
            trial,
            step,
            cost,
            mu: T::lit(FIRST_MU),
            mu_growth: T::TWO,
            report,
        };
        search.report.outcome = search.run();
        report = search.report;
    }
    report
}

/// State of a search.
struct Search<'a, 'p, T, E> {
    problem: &'a mut ClosureProblem<'p, T>,
    equations: &'a mut E,
    limits: Limits<'a, T>,
    options: &'a Options<T>,
    /// Best point found, radians.
    x: &'a mut [T],
    /// Point to try next, and its distance from `x`, radians.
    trial: &'a mut [T],
    step: &'a mut [T],
    /// Residual at `x`.
    cost: Cost<T>,
    /// μ, and the factor by which the next rejected point raises it.
    mu: T,
    mu_growth: T,
    report: Report<T>,
}

/// Method by which a step is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Method {
    /// With a new factor of the matrix.
    NewFactor,
    /// With the last factor.
    LastFactor,
}

/// A step within the limits.
struct Step<T> {
    /// Reduction m(0) − m(d) of the linear model.
    predicted: T,
    /// `true` if the prediction holds to rounding: the factor was made for this step, and no unknown was clamped after
    /// it.
    exact: bool,
}

impl<T: Scalar, E: NormalEquations<T>> Search<'_, '_, T, E> {
    /// Iterates until a stopping test holds.
    fn run(&mut self) -> Outcome {
        let tolerance = self.options.tolerance;
        loop {
            self.report.residual = self.cost.max();
            if self.report.residual <= tolerance {
                return Outcome::Converged;
            }
            if self.report.iterations == self.options.max_iterations {
                return Outcome::IterationLimit;
            }
            self.report.iterations += 1;

            self.fix_blocked_unknowns();
            let damping = self.damping();
            copy(self.x, self.trial);
            let Some(step) = self.bounded_step(damping, Method::NewFactor) else {
                return Outcome::Stalled;
            };
            let length = self.measure_step();
            if length <= T::EPSILON || self.is_drift(&step) {
                return Outcome::Stalled;
            }
            // Estimate of the residual that the step leaves: right in the median.
            let closes = length * length * T::HALF <= tolerance;
            if closes && self.closes_for_certain(&step) {
                copy(self.trial, self.x);
                return Outcome::Converged;
            }
            let repeatable = self.reuses_factors();
            let old_rows = repeatable || closes;
            let Some(cost) = self.evaluate_trial(old_rows) else {
                return Outcome::Capacity;
            };
            let reduction = self.cost.half_square - cost.half_square;
            let accepted = cost.is_finite() && reduction > T::zero();
            if accepted {
                let before = self.accept(cost);
                self.lower_mu(reduction, step.predicted);
                if repeatable {
                    self.take_old_factor_steps(damping, before);
                }
            }
            if !accepted || old_rows && self.cost.max() > tolerance {
                self.problem.linearise(self.x, self.equations);
                self.report.evaluations += 1;
            }
            if !accepted && !self.raise_mu() {
                return Outcome::Stalled;
            }
        }
    }

    /// Fixes the unknowns that descent would push past a limit. These are most of the unknowns that stay at their
    /// limits, found without a step that passes a limit.
    fn fix_blocked_unknowns(&mut self) {
        for (index, &value) in self.x.iter().enumerate() {
            let slope = self.equations.gradient().get(index).copied();
            if slope.is_some_and(|slope| self.limits.blocks(index, value, slope)) {
                self.equations.fix_unknown(index, T::zero());
            }
        }
    }

    /// Returns the damping λ.
    fn damping(&self) -> T {
        let square = if self.report.residual <= self.options.acceptable {
            self.cost.half_square
        } else {
            self.cost.max_square * T::HALF
        };
        self.mu * square
    }

    /// Returns `true` if several steps may share a factor.
    fn reuses_factors(&self) -> bool {
        E::KEEPS_ROWS && self.options.factor_reuse != FactorReuse::None
    }

    /// Moves `trial` by the damped step within the limits. Returns `None` if no damping makes the matrix positive
    /// definite.
    ///
    /// An unknown whose step would pass a limit is moved to the limit and fixed. The step of the others is then
    /// computed anew, because it relied on the part that was cut off. For that the unknown is
    /// [fixed in the factor](NormalEquations::fix_in_factor), unless factors are not reused.
    fn bounded_step(&mut self, mut damping: T, mut method: Method) -> Option<Step<T>> {
        let (mut growth, mut rounds) = (T::zero(), 0);
        loop {
            damping = self.compute_step(damping, method)?;
            rounds += 1;
            let scale = shortening(self.step, self.options.max_step);
            let gradient = self.equations.gradient();
            let predicted = predicted_reduction(self.step, gradient, damping, scale);
            let (mut cut, mut exact) = (false, method == Method::NewFactor);
            let mut fixed = self.reuses_factors();
            let ends = self.step.iter_mut().zip(&mut *self.trial);
            for (index, (step, trial)) in ends.enumerate() {
                let wanted = *trial + *step * scale;
                *step = self.limits.clamp(index, wanted);
                exact &= *step == wanted;
                if (wanted - *step).abs() > self.options.tolerance && rounds < MAX_ROUNDS {
                    growth += self.equations.fix_unknown(index, *step - *trial);
                    fixed = fixed && self.equations.fix_in_factor(index);
                    *trial = *step;
                    cut = true;
                }
            }
            if !cut {
                copy(self.step, self.trial);
                return Some(Step {
                    predicted: predicted - growth,
                    exact,
                });
            }
            method = if fixed {
                Method::LastFactor
            } else {
                Method::NewFactor
            };
        }
    }

    /// Computes the damped step and returns its damping, which grows until the matrix is positive definite; `None` if no
    /// damping makes it so.
    fn compute_step(&mut self, mut damping: T, method: Method) -> Option<T> {
        match method {
            Method::LastFactor => self.equations.step(self.step),
            Method::NewFactor => {
                let unit = self.equations.max_diagonal() * T::EPSILON;
                damping = damping.max(unit * T::lit(MIN_DAMPING_EPSILONS));
                while !self.equations.factorise(damping) {
                    damping *= T::lit(DAMPING_GROWTH);
                    if damping <= T::zero() || !damping.is_finite() {
                        return None;
                    }
                }
                self.equations.step(self.step);
            }
        }
        Some(damping)
    }

    /// Sets `step` to the distance of `trial` from `x`, and returns the largest move of an unknown, radians.
    fn measure_step(&mut self) -> T {
        let ends = self.trial.iter().zip(&*self.x);
        let steps = self.step.iter_mut().zip(ends);
        steps.fold(T::zero(), |largest, (step, (&trial, &x))| {
            *step = trial - x;
            largest.max(step.abs())
        })
    }

    /// Returns `true` if the residual is acceptable and the step hardly reduces it. Such a step would only drift along
    /// the motion.
    fn is_drift(&self, step: &Step<T>) -> bool {
        let acceptable = self.report.residual <= self.options.acceptable;
        acceptable && step.predicted < T::HALF * self.cost.half_square
    }

    /// Returns `true`, with the bound in the report, if the residual of the linear model and a bound on second
    /// derivatives prove that the sheet closes at `trial`. The last step of a run is often so short, and the residual is
    /// then not evaluated at the last point.
    fn closes_for_certain(&mut self, step: &Step<T>) -> bool {
        let tolerance = self.options.tolerance;
        if !step.exact {
            return false;
        }
        let remainder = self.problem.remainder_bound(self.step);
        if remainder > tolerance {
            return false;
        }
        let before = self.cost.half_square;
        let models = [before, before - step.predicted];
        let bound = remainder + self.equations.residual_bound(self.step, models);
        if bound <= tolerance {
            self.report.residual = bound;
        }
        bound <= tolerance
    }

    /// Evaluates the residual at `trial`. With `old_rows` no derivatives are computed: the point probably closes, or the
    /// factor may be used again.
    fn evaluate_trial(&mut self, old_rows: bool) -> Option<Cost<T>> {
        let cost = if old_rows {
            self.problem.update_residuals(self.trial, self.equations)
        } else {
            self.problem.linearise(self.trial, self.equations)
        }?;
        self.report.evaluations += 1;
        Some(cost)
    }

    /// Moves on to `trial`, whose residual is `cost`. Returns the residual of the point before.
    fn accept(&mut self, cost: Cost<T>) -> Cost<T> {
        copy(self.trial, self.x);
        core::mem::replace(&mut self.cost, cost)
    }

    /// Takes steps with the last factor and its rows as long as each leaves little of the residual of the point before.
    fn take_old_factor_steps(&mut self, damping: T, mut before: Cost<T>) {
        let enough = self.options.tolerance.max(self.options.acceptable);
        let ratio = T::lit(MAX_CHORD_RESIDUAL_RATIO);
        while self.cost.max() > enough && self.cost.max() <= ratio * before.max() {
            let step = self.bounded_step(damping, Method::LastFactor);
            let Some(next) = step.and_then(|_| self.evaluate_trial(true)) else {
                return;
            };
            if !next.is_finite() || next.half_square >= self.cost.half_square {
                return;
            }
            before = self.accept(next);
        }
    }

    /// Lowers μ by the gain ratio ρ = `reduction` / `predicted`, to max(⅓, 1 − (2ρ − 1)³) of its value.
    fn lower_mu(&mut self, reduction: T, predicted: T) {
        let excess = T::TWO * reduction / predicted.max(T::EPSILON * reduction) - T::one();
        let third = T::one() / (T::TWO + T::one());
        let factor = (T::one() - excess * excess * excess).max(third);
        self.mu = (self.mu * factor).max(T::lit(MIN_MU));
        self.mu_growth = T::TWO;
    }

    /// Raises μ after a rejected point, by twice the factor of the last time. Returns `true` if μ is still finite.
    fn raise_mu(&mut self) -> bool {
        self.mu *= self.mu_growth;
        self.mu_growth *= T::TWO;
        self.mu.is_finite()
    }
}

/// Returns the factor that shortens `step` so that no unknown moves by more than `max_step`.
fn shortening<T: Scalar>(step: &[T], max_step: T) -> T {
    let largest = step.iter().fold(T::zero(), |max, &d| max.max(d.abs()));
    if largest > max_step {
        max_step / largest
    } else {
        T::one()
    }
}

/// Returns the reduction m(0) − m(s·d) of the linear model for the damped step d and the factor s that shortens it:
/// -s g·d - ½ s² dᵀJᵀJd, where dᵀJᵀJd = -g·d - λ d·d.
fn predicted_reduction<T: Scalar>(step: &[T], gradient: &[T], damping: T, scale: T) -> T {
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
    if !equations.factorise(damping) {
        return false;
    }
    for _ in 0..PROJECTIONS {
        equations.solve(direction);
        for entry in direction.iter_mut() {
            *entry *= damping;
        }
    }
    direction.iter().all(|entry| entry.is_finite())
}

/// Returns the λ of [`project_on_motions`]: the square root of the precision, so that the rounding error ε/λ stays as
/// small as λ itself.
pub fn projection_damping<T: Scalar, E: NormalEquations<T>>(equations: &mut E) -> T {
    equations.max_diagonal().max(T::EPSILON) * T::EPSILON.sqrt()
}
