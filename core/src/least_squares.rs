//! The least-squares problem of every solver: the closure of a list of stars, and of loops round holes, as a function
//! of the group angles.
//!
//! With the residuals r(x) of all stars and loops, solvers minimise ½‖r‖². The problem hands the rows of its
//! linearisation to an [`Accumulate`]: a gradient alone needs O(n) memory, dense or sparse normal equations need more.

use nalgebra::Vector3;

use crate::dense::dot;
use crate::objective::larger;
use crate::{HalfAngle, LoopsView, Scalar, Spoke, StarsView};
use crate::{closure, hole};

/// Rounding errors in the residual of a star, in precisions (ε) per spoke.
const RESIDUAL_EPSILONS: f64 = 4.0;
/// Rounding error that a factor may leave in a step, in precisions (ε) of the matrix.
const FACTOR_EPSILONS: f64 = 16.0;

/// Returns a count as a floating-point number; counts above `u32::MAX` saturate.
pub(crate) fn count<T: Scalar>(things: usize) -> T {
    T::whole(u32::try_from(things).unwrap_or(u32::MAX))
}

/// Splits a workspace into `K` vectors of `n` numbers each; `None` if it is too small.
pub(crate) fn split<T, const K: usize>(workspace: &mut [T], n: usize) -> Option<[&mut [T]; K]> {
    let mut vectors = workspace.get_mut(..K * n)?.chunks_exact_mut(n.max(1));
    Some([(); K].map(|()| vectors.next().unwrap_or_default()))
}

/// Size of the residual at one configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost<T> {
    /// ½‖r‖² over all stars and loops.
    pub half_square: T,
    /// Largest ‖r(v)‖² of a star, or of the rotation or translation of a loop.
    pub(crate) max_square: T,
}

impl<T: Scalar> Cost<T> {
    /// Returns the largest ‖r(v)‖ of a star, or of the rotation or translation of a loop.
    #[must_use]
    pub fn max(&self) -> T {
        self.max_square.sqrt()
    }

    /// Returns `true` if the residual is finite at every star and loop.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.half_square.is_finite() && self.max_square.is_finite()
    }

    fn none() -> Self {
        Self {
            half_square: T::zero(),
            max_square: T::zero(),
        }
    }

    fn plus(self, residual: &Vector3<T>) -> Self {
        let square = residual.dot(residual);
        Self {
            half_square: self.half_square + square * T::HALF,
            max_square: larger(self.max_square, square),
        }
    }
}

/// Receives the rows of the linearised problem, star by star, then loop by loop.
pub trait Accumulate<T: Scalar> {
    /// Forgets all rows.
    fn clear(&mut self);
    /// Adds the three rows of star number `star`; `columns[k]` is ∂r/∂(group angle of spoke k).
    ///
    /// Two spokes may belong to the same group. A loop counts as one more star and takes two calls with its number: the
    /// first with the rows of its rotation, the second with those of its translation.
    fn add(
        &mut self,
        star: usize,
        spokes: &[Spoke<T>],
        columns: &[Vector3<T>],
        residual: &Vector3<T>,
    );
}

/// The normal equations (JᵀJ + λI) x = b, an interface to dense and sparse linear algebra.
pub trait NormalEquations<T: Scalar>: Accumulate<T> {
    /// `true` if the rows of the Jacobian are kept. Without them [no factor is reused](FactorReuse::None).
    const KEEPS_ROWS: bool = false;
    /// Returns the number of unknowns.
    fn unknowns(&self) -> usize;
    /// Returns the gradient Jᵀr, one number for each unknown.
    fn gradient(&self) -> &[T];
    /// Returns the largest diagonal entry of JᵀJ.
    fn max_diagonal(&mut self) -> T;
    /// Moves an unknown by `by` (radians) and fixes it there for the rest of the step.
    ///
    /// The residual becomes that of the new point, to first order. The unknown's row and column of JᵀJ and its entry of
    /// the gradient become zero, so that its step is zero with any damping. Returns the growth of ½‖r‖².
    fn fix_unknown(&mut self, unknown: usize, by: T) -> T;
    /// Fixes a [fixed unknown](Self::fix_unknown) in the last factor as well (Schur complement), so that later solves
    /// are those of the remaining unknowns. Returns `false` if rounding leaves too little precision, or if this is not
    /// supported: the caller then has to factorise anew.
    fn fix_in_factor(&mut self, _unknown: usize) -> bool {
        false
    }
    /// Forgets the residuals, but neither the rows nor the factor.
    fn clear_residuals(&mut self) {}
    /// Adds a new residual for rows that are kept: those of the `block`-th call of [`add`](Accumulate::add), from 0.
    fn add_residual(&mut self, _block: usize, _spokes: &[Spoke<T>], _residual: &Vector3<T>) {}
    /// Factorises JᵀJ + λI; returns `false` if it is not positive definite in this precision.
    fn factorise(&mut self, damping: T) -> bool;
    /// Solves with the last factor, in place.
    fn solve(&mut self, right_side: &mut [T]);
    /// Returns an upper bound on ‖r + J·step‖, the residual that the linear model leaves, rounding included.
    ///
    /// `models` holds m(0) and m(step) of the linear model m(d) = ½‖r + Jd‖², the latter as predicted for a step with
    /// the last factor. The prediction is not exact to rounding: the factor leaves an error of a few precisions of the
    /// matrix in the step.
    fn residual_bound(&mut self, step: &[T], models: [T; 2]) -> T {
        let [before, after] = models;
        let trace = count::<T>(step.len()) * self.max_diagonal();
        let rounding = T::lit(FACTOR_EPSILONS) * T::EPSILON * (before + trace * dot(step, step));
        (T::TWO * (after.max(T::zero()) + rounding)).sqrt()
    }
    /// Computes the step -(JᵀJ + λI)⁻¹Jᵀr with the last factor, one number for each unknown.
    fn step(&mut self, step: &mut [T]) {
        for (step, &slope) in step.iter_mut().zip(self.gradient()) {
            *step = -slope;
        }
        self.solve(step);
    }
}

/// The closure of stars and loops as a least-squares problem, with borrowed scratch memory.
#[derive(Debug)]
pub struct ClosureProblem<'a, T> {
    stars: StarsView<'a, T>,
    loops: LoopsView<'a, T>,
    half_angles: &'a mut [HalfAngle<T>],
    columns: &'a mut [Vector3<T>],
}

impl<'a, T: Scalar> ClosureProblem<'a, T> {
    /// Creates the problem of these stars with borrowed scratch: one half angle for each unknown, one column for each
    /// spoke of the largest star. Returns `None` if either is too small.
    pub fn new(
        stars: StarsView<'a, T>,
        half_angles: &'a mut [HalfAngle<T>],
        columns: &'a mut [Vector3<T>],
    ) -> Option<Self> {
        Self::with_loops(stars, LoopsView::none(), half_angles, columns)
    }

    /// Creates the problem of these stars and of loops round holes, in the unknowns of the stars. `columns` needs
    /// [`ClosureProblem::columns`] entries.
    pub fn with_loops(
        stars: StarsView<'a, T>,
        loops: LoopsView<'a, T>,
        half_angles: &'a mut [HalfAngle<T>],
        columns: &'a mut [Vector3<T>],
    ) -> Option<Self> {
        let half_angles = half_angles.get_mut(..stars.unknowns())?;
        let columns = columns.get_mut(..Self::columns(stars, loops))?;
        Some(Self {
            stars,
            loops,
            half_angles,
            columns,
        })
    }

    /// Returns the number of scratch columns needed: one for each spoke of the largest star, or two for each spoke of
    /// the largest loop.
    #[must_use]
    pub fn columns(stars: StarsView<'_, T>, loops: LoopsView<'_, T>) -> usize {
        stars.max_degree().max(2 * loops.max_degree())
    }

    /// Returns the number of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.stars.unknowns()
    }

    /// Evaluates the residual at `x` (radians) without derivatives; `None` unless `x` has all unknowns.
    pub fn cost(&mut self, x: &[T]) -> Option<Cost<T>> {
        self.each_residual(x, |_, _| {})
    }

    /// Evaluates the residual as [`cost`](Self::cost) does, and hands each block of three residuals to `each` with its
    /// spokes, in the order of [`linearise`](Self::linearise).
    pub fn each_residual(
        &mut self,
        x: &[T],
        mut each: impl FnMut(&[Spoke<T>], &Vector3<T>),
    ) -> Option<Cost<T>> {
        self.set_half_angles(x)?;
        let half = &*self.half_angles;
        let stars = self.stars.iter();
        let stars = stars.map(|star| (star.spokes, closure::residual(star, half)));
        let loops = self.loops.iter().flat_map(|cycle| {
            let residuals = hole::residuals(cycle, half);
            residuals.map(|residual| (cycle.spokes, residual))
        });
        let cost = stars.chain(loops).fold(Cost::none(), |cost, (spokes, r)| {
            each(spokes, &r);
            cost.plus(&r)
        });
        Some(cost)
    }

    /// Evaluates the residual as [`cost`](Self::cost) does, and replaces the residuals of the rows last accumulated, if
    /// the equations keep rows. Rows and factor stay those of the earlier point.
    pub fn update_residuals(
        &mut self,
        x: &[T],
        equations: &mut impl NormalEquations<T>,
    ) -> Option<Cost<T>> {
        equations.clear_residuals();
        let mut block = 0;
        self.each_residual(x, |spokes, residual| {
            equations.add_residual(block, spokes, residual);
            block += 1;
        })
    }

    /// Evaluates residual and Jacobian at `x` (radians) and adds the rows to `rows`; `None` unless `x` has all
    /// unknowns.
    pub fn linearise(&mut self, x: &[T], rows: &mut impl Accumulate<T>) -> Option<Cost<T>> {
        self.set_half_angles(x)?;
        rows.clear();
        let mut cost = Cost::none();
        for (index, star) in self.stars.iter().enumerate() {
            let columns = self.columns.get_mut(..star.spokes.len())?;
            let residual = closure::residual_and_jacobian(star, self.half_angles, columns)?;
            rows.add(index, star.spokes, columns, &residual);
            cost = cost.plus(&residual);
        }
        for (index, cycle) in self.loops.iter().enumerate() {
            let index = self.stars.len() + index;
            let degree = cycle.spokes.len();
            let columns = self.columns.get_mut(..2 * degree)?;
            let residuals = hole::residuals_and_jacobian(cycle, self.half_angles, columns)?;
            let (turns, moves) = columns.split_at_checked(degree)?;
            for (residual, columns) in residuals.iter().zip([turns, moves]) {
                rows.add(index, cycle.spokes, columns, residual);
                cost = cost.plus(residual);
            }
        }
        Some(cost)
    }

    /// Bounds the change of a star's residual beyond first order for a move by `step` (radians), plus the rounding of
    /// an evaluation. Returns the largest number if there are loops: their edges have lengths, and no bound is known
    /// for them.
    ///
    /// A quaternion turned by t δ has the derivative δ/2 by t, so that the second derivative of a product of
    /// quaternions is at most (Σ|δ|/2)². The second derivative of r is at most twice as large, and Taylor's theorem
    /// takes half of it.
    pub(crate) fn remainder_bound(&self, step: &[T]) -> T {
        if !self.loops.is_empty() {
            return T::MAX;
        }
        let sums = self.stars.iter().map(|star| {
            let moves = star.spokes.iter().map(|spoke| spoke.fold_angle(step).abs());
            moves.fold(T::zero(), |sum, by| sum + by)
        });
        let half = sums.fold(T::zero(), T::max) * T::HALF;
        half * half + T::lit(RESIDUAL_EPSILONS) * T::EPSILON * count::<T>(self.columns.len())
    }

    /// Moves `x` within its limits and evaluates residual and Jacobian there, where a solver starts. Returns `None` if
    /// `x` does not have all unknowns, or if the start is not finite, which the report then says.
    pub(crate) fn start(
        &mut self,
        x: &mut [T],
        limits: Limits<'_, T>,
        rows: &mut impl Accumulate<T>,
        report: &mut Report<T>,
    ) -> Option<Cost<T>> {
        if x.len() != self.unknowns() {
            return None;
        }
        for (index, value) in x.iter_mut().enumerate() {
            *value = limits.clamp(index, *value);
        }
        let cost = self.linearise(x, rows)?;
        report.evaluations += 1;
        // The cost does not show an unknown that is in no star, so the unknowns are checked as well.
        if cost.is_finite() && x.iter().all(|value| value.is_finite()) {
            return Some(cost);
        }
        report.outcome = Outcome::NotFinite;
        None
    }

    fn set_half_angles(&mut self, x: &[T]) -> Option<()> {
        let complete = x.len() == self.half_angles.len();
        closure::half_angles(x, self.half_angles);
        complete.then_some(())
    }
}

/// Accumulates the gradient Jᵀr alone, in O(n) memory.
#[derive(Debug)]
pub struct Gradient<'a, T>(pub &'a mut [T]);

impl<T: Scalar> Accumulate<T> for Gradient<'_, T> {
    fn clear(&mut self) {
        self.0.fill(T::zero());
    }

    #[inline]
    fn add(
        &mut self,
        _star: usize,
        spokes: &[Spoke<T>],
        columns: &[Vector3<T>],
        residual: &Vector3<T>,
    ) {
        for (spoke, column) in spokes.iter().zip(columns) {
            if let Some(entry) = self.0.get_mut(spoke.group.index()) {
                *entry += column.dot(residual);
            }
        }
    }
}

/// Bounds on the unknowns.
#[derive(Clone, Copy, Debug, Default)]
pub enum Limits<'a, T> {
    /// [-π, π] for each unknown: a hinge cannot turn past touching itself.
    #[default]
    HalfTurn,
    /// A pair (lower, upper) for each unknown, radians; unknowns past the end get [-π, π].
    Each(&'a [(T, T)]),
}

impl<T: Scalar> Limits<'_, T> {
    /// Returns the lower and the upper bound of unknown number `index`, radians.
    #[inline]
    #[must_use]
    pub fn of(&self, index: usize) -> (T, T) {
        match self {
            Self::HalfTurn => None,
            Self::Each(limits) => limits.get(index).copied(),
        }
        .unwrap_or((-T::PI, T::PI))
    }

    /// Returns `value` of unknown number `index`, moved to the nearest value allowed. A NaN stays a NaN, because the
    /// solver has to see it.
    #[inline]
    #[must_use]
    pub fn clamp(&self, index: usize, value: T) -> T {
        let (lower, upper) = self.of(index);
        if value < lower {
            lower
        } else if value > upper {
            upper
        } else {
            value
        }
    }

    /// Returns `true` if every unknown of `x` is within its limits.
    #[must_use]
    pub fn contain(&self, x: &[T]) -> bool {
        x.iter().enumerate().all(|(index, &x)| {
            let (lower, upper) = self.of(index);
            x >= lower && x <= upper
        })
    }

    /// Returns `true` if descent along -`slope` would push unknown number `index` from `value` past a limit.
    #[inline]
    #[must_use]
    pub fn blocks(&self, index: usize, value: T, slope: T) -> bool {
        let (lower, upper) = self.of(index);
        value <= lower && slope > T::zero() || value >= upper && slope < T::zero()
    }
}

/// Options of the solvers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options<T> {
    /// Largest closure residual ‖r(v)‖ that counts as closed.
    pub tolerance: T,
    /// Residual at or below which a step is only taken if it promises to halve ½‖r‖². Stars with rounded directions
    /// close at no configuration; without this rule, what is left of their residual pulls the configuration far along
    /// the motion, and in the end to flat. A value that is not above the tolerance switches the rule off.
    pub acceptable: T,
    /// Largest number of iterations.
    pub max_iterations: u32,
    /// Largest change of an unknown in one step, radians.
    pub max_step: T,
    /// Reuse of factors by Levenberg-Marquardt, if the equations keep their rows.
    pub factor_reuse: FactorReuse,
}

/// Reuse of factors by Levenberg-Marquardt. On large sheets factorisations are most of the work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FactorReuse {
    /// Each step has a factor of its own. This is the surest way to the nearest configuration from points at which the
    /// conditions lose rank, such as the flat sheet.
    #[default]
    None,
    /// Several steps share a factor as long as they leave little of the residual (chord method): this saves at least
    /// half the factorisations.
    Chord,
}

impl<T: Scalar> Default for Options<T> {
    fn default() -> Self {
        Self {
            tolerance: T::CLOSURE_TOLERANCE,
            acceptable: T::CLOSURE_TOLERANCE,
            max_iterations: 100,
            // A sixth of a turn. Far from flat, every fold angle is farther than this from its mirror image.
            max_step: T::PI / (T::TWO + T::one()),
            factor_reuse: FactorReuse::None,
        }
    }
}

/// Result of a solver. Not converging is an outcome, not an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Every star and loop closes within the tolerance.
    Converged,
    /// No step improves the residual any more, but the residual is above the tolerance.
    Stalled,
    /// All allowed iterations were used.
    IterationLimit,
    /// The workspace or the start does not have the length that the problem needs.
    Capacity,
    /// The start, or the residual at the start, holds a NaN or an infinity.
    NotFinite,
}

/// Outcome of a solver and the work that it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report<T> {
    /// Why the solver ended.
    pub outcome: Outcome,
    /// Number of iterations.
    pub iterations: u32,
    /// Number of evaluations of the residual, with or without derivatives.
    pub evaluations: u32,
    /// Largest ‖r(v)‖ at the point returned, or an upper bound on it that is within the tolerance.
    pub residual: T,
}

impl<T: Scalar> Report<T> {
    /// Returns the report of a solver that has done nothing, because the memory lent does not suffice.
    pub(crate) fn capacity() -> Self {
        Self {
            outcome: Outcome::Capacity,
            iterations: 0,
            evaluations: 0,
            residual: T::MAX,
        }
    }
}
