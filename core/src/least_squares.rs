//! The least-squares problem that every solver here works on: the closure of a list of stars, and of
//! loops round holes, as a function of the group angles.
//!
//! With the residuals r(x) of all stars and loops, solvers minimise ½‖r‖². They hand their rows to an
//! [`Accumulate`]: a gradient alone needs O(n) memory, dense or sparse normal equations more.

use nalgebra::Vector3;

use crate::dense::dot;
use crate::objective::larger;
use crate::{HalfAngle, LoopsView, Scalar, Spoke, StarsView};
use crate::{closure, hole};

/// Roundings for each spoke in the residual of a star.
const ROUNDINGS: f64 = 4.0;
/// Roundings of the matrix by which a step with its factor may be off.
const FACTOR: f64 = 16.0;

/// So many, as a number.
pub(crate) fn count<T: Scalar>(things: usize) -> T {
    T::whole(u32::try_from(things).unwrap_or(u32::MAX))
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
    /// Largest ‖r(v)‖ of a star, or of the rotation or translation of a loop.
    #[must_use]
    pub fn max(&self) -> T {
        self.max_square.sqrt()
    }

    /// Whether the residual is defined everywhere.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.half_square.is_finite() && self.max_square.is_finite()
    }
}

/// Takes the rows of the linearised problem star by star, then loop by loop.
pub trait Accumulate<T: Scalar> {
    /// Forgets all rows.
    fn clear(&mut self);
    /// Adds the three rows of star number `star`: `columns[k]` is ∂r/∂(group angle of spoke k).
    /// Two spokes may belong to the same group. A loop counts as one more star and adds twice under its
    /// number: the rows of its rotation, then those of its translation.
    fn add(
        &mut self,
        star: usize,
        spokes: &[Spoke<T>],
        columns: &[Vector3<T>],
        residual: &Vector3<T>,
    );
}

/// Normal equations (JᵀJ + λI) x = b behind which dense, dual and sparse linear algebra look alike.
pub trait NormalEquations<T: Scalar>: Accumulate<T> {
    /// Whether the rows are kept, without which all steps are [exact](Steps::Exact).
    const KEEPS_ROWS: bool = false;
    /// Number of unknowns.
    fn unknowns(&self) -> usize;
    /// The gradient Jᵀr, one number for each unknown.
    fn gradient(&self) -> &[T];
    /// Largest diagonal entry of JᵀJ.
    fn max_diagonal(&mut self) -> T;
    /// Moves an unknown `by` so much (radians) and takes it out of the step: the residual becomes the one there, to
    /// first order, and the unknown's row, its column and its entry of the gradient become zero, and with any
    /// damping its step too. Returns by how much ½‖r‖² grows.
    fn hold(&mut self, unknown: usize, by: T) -> T;
    /// Takes a held unknown out of the last factor, too: what is solved after that are the equations of the others. `false`
    /// if rounding leaves too little of them, or this cannot be done: then the factor has to be made anew.
    fn amend(&mut self, _held: usize) -> bool {
        false
    }
    /// Forgets the residuals, but neither rows nor factor.
    fn clear_residuals(&mut self) {}
    /// Adds another residual for rows that are kept: those that were [added](Accumulate::add) as block number `block`.
    fn add_residual(&mut self, _block: usize, _spokes: &[Spoke<T>], _residual: &Vector3<T>) {}
    /// Approximates the step with this damping, without a factor, where rows are kept.
    fn rough_step(&mut self, _damping: T, _step: &mut [T]) {}
    /// Factorises JᵀJ + λI; `false` if it is not positive definite in this precision.
    fn factorise(&mut self, damping: T) -> bool;
    /// Solves with the last factor, in place.
    fn solve(&mut self, right_side: &mut [T]);
    /// Bound on what the linear model leaves, ‖r + J·step‖, rounding included. `halves` are ½‖r‖², and what a step with
    /// the last factor promises to leave of that: not to rounding, as the factor leaves the step off by some precisions
    /// of the matrix.
    fn left(&mut self, step: &[T], halves: [T; 2]) -> T {
        let [before, after] = halves;
        let trace = count::<T>(step.len()) * self.max_diagonal();
        let rounding = T::lit(FACTOR) * T::EPSILON * (before + trace * dot(step, step));
        (T::TWO * (after.max(T::zero()) + rounding)).sqrt()
    }
    /// The step -(JᵀJ + λI)⁻¹Jᵀr with the last factor, one number for each unknown.
    fn step(&mut self, step: &mut [T]) {
        for (step, &slope) in step.iter_mut().zip(self.gradient()) {
            *step = -slope;
        }
        self.solve(step);
    }
}

/// The closure of stars and loops as a least-squares problem, with the scratch memory that it needs.
#[derive(Debug)]
pub struct ClosureProblem<'a, T> {
    stars: StarsView<'a, T>,
    loops: LoopsView<'a, T>,
    half_angles: &'a mut [HalfAngle<T>],
    columns: &'a mut [Vector3<T>],
}

impl<'a, T: Scalar> ClosureProblem<'a, T> {
    /// Lends the scratch: one half angle for each unknown, one column for each spoke of the largest
    /// star. Returns `None` if either is too small.
    pub fn new(
        stars: StarsView<'a, T>,
        half_angles: &'a mut [HalfAngle<T>],
        columns: &'a mut [Vector3<T>],
    ) -> Option<Self> {
        Self::with_loops(stars, LoopsView::none(), half_angles, columns)
    }

    /// The same with loops round holes, in the unknowns of the stars. There have to be
    /// [`columns`](Self::columns).
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

    /// Columns of scratch needed: one for each spoke of the largest star, two for each of the largest
    /// loop.
    #[must_use]
    pub fn columns(stars: StarsView<'_, T>, loops: LoopsView<'_, T>) -> usize {
        stars.max_degree().max(2 * loops.max_degree())
    }

    /// Number of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.stars.unknowns()
    }

    /// Residual at `x` (radians) without derivatives; `None` unless `x` has all unknowns.
    pub fn cost(&mut self, x: &[T]) -> Option<Cost<T>> {
        self.each_residual(x, |_, _| {})
    }

    /// The same, each block of three residuals handed to `each` with its spokes, in the order of
    /// [`linearise`](Self::linearise).
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

    /// The same, the residuals put in place of those of the rows last accumulated, where rows are kept.
    pub fn renew(&mut self, x: &[T], equations: &mut impl NormalEquations<T>) -> Option<Cost<T>> {
        equations.clear_residuals();
        let mut block = 0;
        self.each_residual(x, |spokes, residual| {
            equations.add_residual(block, spokes, residual);
            block += 1;
        })
    }

    /// Residual at `x` (radians), its rows handed to `rows`; `None` unless `x` has all unknowns.
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

    /// Bound on what a move by `step` (radians) adds to the residual of a star but its part to first order, with the
    /// rounding of an evaluation; of loops, whose edges have lengths, none is known.
    ///
    /// A turn by t δ of a quaternion has the derivative δ/2 by t, so that the second one of their product is at most
    /// (Σ|δ|/2)², that of r twice that, and half of it is what Taylor's theorem adds.
    pub(crate) fn bend(&self, step: &[T]) -> T {
        if !self.loops.is_empty() {
            return T::MAX;
        }
        let ways = self.stars.iter().map(|star| {
            let ways = star.spokes.iter().map(|spoke| spoke.fold_angle(step).abs());
            ways.fold(T::zero(), |sum, way| sum + way)
        });
        let half = ways.fold(T::zero(), T::max) * T::HALF;
        half * half + T::lit(ROUNDINGS) * T::EPSILON * count::<T>(self.columns.len())
    }

    fn set_half_angles(&mut self, x: &[T]) -> Option<()> {
        let complete = x.len() == self.half_angles.len();
        closure::half_angles(x, self.half_angles);
        complete.then_some(())
    }
}

impl<T: Scalar> Cost<T> {
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

/// Accumulates the gradient Jᵀr alone.
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
    /// A hinge cannot turn past touching itself: [-π, π] for each unknown.
    #[default]
    HalfTurn,
    /// Its own (lower, upper) for each unknown, in radians; unknowns past the end get [-π, π].
    Each(&'a [(T, T)]),
}

impl<T: Scalar> Limits<'_, T> {
    /// Lower and upper bound of unknown number `index`.
    #[inline]
    #[must_use]
    pub fn of(&self, index: usize) -> (T, T) {
        match self {
            Self::HalfTurn => None,
            Self::Each(limits) => limits.get(index).copied(),
        }
        .unwrap_or((-T::PI, T::PI))
    }

    /// `value` of unknown number `index`, moved to the nearest value allowed. A NaN stays one: the
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

    /// Whether every unknown of `x` is within its limits.
    #[must_use]
    pub fn contain(&self, x: &[T]) -> bool {
        x.iter().enumerate().all(|(index, &x)| {
            let (lower, upper) = self.of(index);
            x >= lower && x <= upper
        })
    }

    /// Whether descent along -`slope` would push unknown number `index` from `value` past a limit.
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
    /// Residual from which on a step is not worth taking that does not promise to halve ½‖r‖². Stars
    /// with rounded directions close nowhere: the least that is left then pulls the configuration far
    /// along the motion, at last to flat. Not above the tolerance: never.
    pub acceptable: T,
    /// Steps tried before giving up.
    pub max_iterations: u32,
    /// No unknown moves by more than this in one step, radians.
    pub max_step: T,
    /// How Levenberg-Marquardt makes its steps where the equations keep their rows.
    pub steps: Steps,
}

/// How steps are made on large sheets, where factorisations are most of the work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Steps {
    /// Each with a factor of its own: from where conditions lose rank, as in the flat sheet, that leads to the nearest
    /// configuration most surely.
    #[default]
    Exact,
    /// With a factor of which several are made as long as they leave little: half the factorisations, or fewer.
    Repeated,
    /// The same, but those far from closing roughly: that saves most of the time, and the configuration found is less surely
    /// the nearest one.
    Rough,
}

impl<T: Scalar> Default for Options<T> {
    fn default() -> Self {
        Self {
            tolerance: T::CLOSURE_TOLERANCE,
            acceptable: T::CLOSURE_TOLERANCE,
            max_iterations: 100,
            // A sixth of a turn: less than any fold angle's way to its mirror image far from flat.
            max_step: T::PI / (T::TWO + T::one()),
            steps: Steps::Exact,
        }
    }
}

/// How a solver ended. Not converging is an outcome, not an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Every star and loop closes within the tolerance.
    Converged,
    /// No step improves the residual any more, but it is above the tolerance.
    Stalled,
    /// The iterations allowed were used up.
    IterationLimit,
    /// The workspace, or the start, has not the length of the problem.
    Capacity,
    /// The start holds a NaN or an infinity, or the residual there is one.
    NotFinite,
}

/// What a solver did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report<T> {
    /// How it ended.
    pub outcome: Outcome,
    /// Steps tried.
    pub iterations: u32,
    /// Evaluations of the residual, with or without derivatives.
    pub evaluations: u32,
    /// Largest ‖r(v)‖ at the point returned, or a bound on it that is within the tolerance.
    pub residual: T,
}

impl<T: Scalar> Report<T> {
    /// Nothing done yet: what is reported if the memory lent does not suffice.
    pub(crate) fn capacity() -> Self {
        Self {
            outcome: Outcome::Capacity,
            iterations: 0,
            evaluations: 0,
            residual: T::MAX,
        }
    }
}
