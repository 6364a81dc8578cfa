//! Closes configurations and projects directions on infinitesimal motions, by core's solvers with memory from the heap.

use core::ops::AddAssign;
use std::sync::{Arc, OnceLock};

use foldpath_core::least_squares::{
    Accumulate, ClosureProblem, Limits, NormalEquations, Options, Outcome, Report,
};
use foldpath_core::{
    DenseNormalEquations, HalfAngle, LoopsView, Objective, Scalar, Spoke, StarsView, gradient,
    levenberg_marquardt,
};
use nalgebra::Vector3;

use super::chord;
use super::sparse::{SparseNormalEquations, Structure};
use crate::planner::Solver;
use crate::planner::vectors::max_norm;
use crate::progress::Watch;
use crate::symmetry::ReducedStars;

/// Largest number of steps of the gradient solver, which converges linearly.
const MAX_GRADIENT_ITERATIONS: u32 = 20_000;
/// Number of steps after which the gradient solver looks at the clock.
const GRADIENT_STEPS_PER_LOOK: u32 = 500;

/// Number of iterations and evaluations so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Work {
    pub(crate) iterations: u64,
    pub(crate) evaluations: u64,
}

impl AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.iterations += other.iterations;
        self.evaluations += other.evaluations;
    }
}

/// Closure conditions of some stars and loops, with all memory that solving them needs.
pub(crate) struct ClosureSolver<'a> {
    stars: StarsView<'a, f64>,
    loops: LoopsView<'a, f64>,
    kind: Solver,
    /// Closure residual up to which a local minimum counts as closed.
    closure_tolerance: f64,
    /// Closure residual up to which a configuration counts as closed.
    pub(crate) tolerance: f64,
    /// Lower and upper bound of each unknown, radians; empty for half a turn each way.
    pub(crate) limits: Vec<(f64, f64)>,
    watch: Watch<'a>,
    /// Largest number of iterations of Levenberg-Marquardt for a configuration.
    pub(crate) max_iterations: u32,
    half_angles: Vec<HalfAngle<f64>>,
    columns: Vec<Vector3<f64>>,
    equations: Equations<'a>,
    workspace: Vec<f64>,
    pub(crate) work: Work,
}

impl<'a> ClosureSolver<'a> {
    /// Makes a solver. `structure` holds the sparse structure of these stars, once one solver has found it. Once the
    /// `watch` is over, no configuration closes any more.
    pub(crate) fn new(
        reduced: &'a ReducedStars,
        kind: Solver,
        closure_tolerance: f64,
        structure: &OnceLock<Option<Arc<Structure>>>,
        watch: Watch<'a>,
    ) -> Self {
        let (stars, loops) = (reduced.view(), reduced.loops());
        let n = stars.unknowns();
        Self {
            stars,
            loops,
            kind,
            closure_tolerance,
            tolerance: Options::<f64>::default().tolerance,
            limits: Vec::new(),
            watch,
            max_iterations: Options::<f64>::default().max_iterations,
            half_angles: vec![HalfAngle::default(); n],
            columns: vec![Vector3::zeros(); ClosureProblem::columns(stars, loops)],
            equations: Equations::new(stars, loops, structure, watch),
            workspace: vec![0.0; 3 * n],
            work: Work::default(),
        }
    }

    /// Returns `true` once the call is over.
    pub(crate) fn is_late(&self) -> bool {
        self.watch.is_over()
    }

    /// Returns the factor of `direction` by which `x` can go until an unknown reaches its limit, and that unknown.
    pub(crate) fn room(&self, x: &[f64], direction: &[f64]) -> (f64, usize) {
        let limits = Limits::Each(&self.limits);
        let tiny = SIDEWAYS_RATIO * max_norm(direction);
        let rooms = x.iter().zip(direction).enumerate();
        let rooms = rooms
            .filter(|(_, (_, d))| d.abs() > tiny)
            .map(|(k, (&x, &d))| {
                let (lower, upper) = limits.of(k);
                let room = if d > 0.0 { upper - x } else { lower - x };
                (room / d, k)
            });
        rooms.fold((f64::INFINITY, 0), |least, room| {
            if room.0 < least.0 { room } else { least }
        })
    }

    /// Moves `x` to the closed configuration near it, or to a local minimum of the residual.
    pub(crate) fn close(&mut self, x: &mut [f64]) -> Report<f64> {
        let n = self.stars.unknowns();
        let (half_angles, columns) = (&mut self.half_angles, &mut self.columns);
        let problem = ClosureProblem::with_loops(self.stars, self.loops, half_angles, columns);
        let Some(mut problem) = problem else {
            unreachable!("memory for all unknowns, the largest star and the largest loop")
        };
        let mut options = Options {
            acceptable: self.closure_tolerance,
            tolerance: self.tolerance,
            max_iterations: self.max_iterations,
            ..Options::default()
        };
        let limits = Limits::Each(&self.limits);
        let watch = self.watch;
        let work = &mut self.workspace;
        let report = match (self.kind, &mut self.equations) {
            (Solver::Gradient, _) => {
                options.max_iterations = GRADIENT_STEPS_PER_LOOK;
                let mut sum = gradient::solve(&mut problem, limits, &options, x, work);
                while sum.outcome == Outcome::IterationLimit
                    && sum.iterations < MAX_GRADIENT_ITERATIONS
                    && !watch.is_over()
                {
                    let report = gradient::solve(&mut problem, limits, &options, x, work);
                    sum = Report {
                        iterations: sum.iterations + report.iterations,
                        evaluations: sum.evaluations + report.evaluations,
                        ..report
                    };
                }
                sum
            }
            (Solver::LevenbergMarquardt, Equations::Dense(memory)) => {
                let Some(mut equations) = DenseNormalEquations::new(n, memory) else {
                    unreachable!("memory for n unknowns")
                };
                levenberg_marquardt::solve(&mut problem, &mut equations, limits, &options, x, work)
            }
            (Solver::LevenbergMarquardt, Equations::Sparse(equations)) => {
                let equations = equations.as_mut();
                levenberg_marquardt::solve(&mut problem, equations, limits, &options, x, work)
            }
        };
        self.work.iterations += u64::from(report.iterations);
        self.work.evaluations += u64::from(report.evaluations);
        report
    }

    /// Moves `x` to the closed configuration near it. Returns `true` if `x` then closes: to the tolerance or, if
    /// rounded coordinates leave no such configuration, at a local minimum of the residual within `closure_tolerance`.
    pub(crate) fn closes(&mut self, x: &mut [f64]) -> bool {
        if self.is_late() {
            return false;
        }
        if self.closes_by_chord(x) {
            return true;
        }
        let report = self.close(x);
        match report.outcome {
            Outcome::Converged => true,
            Outcome::Stalled => report.residual <= self.closure_tolerance,
            _ => false,
        }
    }

    /// Tries the chord method, which costs one factorisation. It is not tried if rounded coordinates may leave nothing
    /// that closes, as only damping keeps a step short then.
    fn closes_by_chord(&mut self, x: &mut [f64]) -> bool {
        let exact = self.closure_tolerance <= f64::CLOSURE_TOLERANCE;
        let (Solver::LevenbergMarquardt, Equations::Sparse(equations), true) =
            (self.kind, &mut self.equations, exact)
        else {
            return false;
        };
        let (half_angles, columns) = (&mut self.half_angles, &mut self.columns);
        let problem = ClosureProblem::with_loops(self.stars, self.loops, half_angles, columns);
        let (limits, work) = (Limits::Each(&self.limits), &mut self.workspace);
        let tolerance = self.tolerance;
        let chord = problem.and_then(|mut problem| {
            chord::close(&mut problem, equations, limits, tolerance, x, work)
        });
        let Some(chord) = chord else {
            return false;
        };
        self.work.iterations += u64::from(chord.steps);
        self.work.evaluations += u64::from(chord.steps) + 1;
        chord.closed
    }

    /// Returns the largest value of the objective that counts as closed: ‖L − I‖ is √2 times the residual.
    pub(crate) fn objective_tolerance(&self) -> f64 {
        self.tolerance.max(self.closure_tolerance) * core::f64::consts::SQRT_2
    }

    /// Returns the report's objective at `x`.
    pub(crate) fn objective(&mut self, objective: Objective, x: &[f64]) -> f64 {
        let value = objective.value(self.stars, x, &mut self.half_angles);
        value.unwrap_or(f64::NAN)
    }

    /// Replaces `direction` by the nearest infinitesimal motion at `x` that moves no unknown past its limit, by an
    /// active-set method. Returns the unknowns that are held for that, or `None` if there is no projection.
    pub(crate) fn project_on_motions(
        &mut self,
        x: &[f64],
        direction: &mut [f64],
    ) -> Option<Vec<usize>> {
        self.project_weighted(x, direction, None)
    }

    /// As [`project_on_motions`](Self::project_on_motions), with each unknown measured in units of its weight, above 0.
    pub(crate) fn project_weighted(
        &mut self,
        x: &[f64],
        direction: &mut [f64],
        weights: Option<&[f64]>,
    ) -> Option<Vec<usize>> {
        let mut held: Vec<usize> = Vec::new();
        let wanted = direction.to_vec();
        loop {
            direction.copy_from_slice(&wanted);
            if !self.project_holding(x, direction, weights, &held) {
                return None;
            }
            let limits = Limits::Each(&self.limits);
            let tiny = SIDEWAYS_RATIO * max_norm(direction);
            let blocked = direction.iter().zip(x).enumerate();
            let blocked = blocked.filter(|&(k, (&d, &x))| {
                d.abs() > tiny && limits.blocks(k, x, -d) && !held.contains(&k)
            });
            let blocked: Vec<usize> = blocked.map(|(k, _)| k).collect();
            if blocked.is_empty() {
                return Some(held);
            }
            held.extend(blocked);
        }
    }

    fn project_holding(
        &mut self,
        x: &[f64],
        direction: &mut [f64],
        weights: Option<&[f64]>,
        held: &[usize],
    ) -> bool {
        self.work.evaluations += 1;
        let (half_angles, columns) = (&mut self.half_angles, &mut self.columns);
        let problem = ClosureProblem::with_loops(self.stars, self.loops, half_angles, columns);
        let Some(mut problem) = problem else {
            return false;
        };
        match &mut self.equations {
            Equations::Dense(memory) => {
                DenseNormalEquations::new(x.len(), memory).is_some_and(|mut equations| {
                    project(&mut problem, &mut equations, x, direction, weights, held)
                })
            }
            Equations::Sparse(equations) => project(
                &mut problem,
                equations.as_mut(),
                x,
                direction,
                weights,
                held,
            ),
        }
    }
}

fn project(
    problem: &mut ClosureProblem<'_, f64>,
    equations: &mut impl NormalEquations<f64>,
    x: &[f64],
    direction: &mut [f64],
    weights: Option<&[f64]>,
    held: &[usize],
) -> bool {
    let linearised = match weights {
        None => problem.linearise(x, equations),
        Some(weights) => problem.linearise(x, &mut Weighted { equations, weights }),
    };
    if linearised.is_none() {
        return false;
    }
    // In units of the weights w, the direction d is d/w and the Jacobian J is J diag(w).
    let weights = weights.unwrap_or(&[]);
    for (entry, weight) in direction.iter_mut().zip(weights) {
        *entry /= weight;
    }
    for &unknown in held {
        equations.fix_unknown(unknown, 0.0);
        direction[unknown] = 0.0;
    }
    let projected = levenberg_marquardt::project_on_motions(equations, direction);
    for (entry, weight) in direction.iter_mut().zip(weights) {
        *entry *= weight;
    }
    projected
}

/// Accumulates the rows of a problem for unknowns in units of the weights.
struct Weighted<'a, E> {
    equations: &'a mut E,
    weights: &'a [f64],
}

impl<E: Accumulate<f64>> Accumulate<f64> for Weighted<'_, E> {
    fn clear(&mut self) {
        self.equations.clear();
    }

    fn add(
        &mut self,
        star: usize,
        spokes: &[Spoke<f64>],
        columns: &[Vector3<f64>],
        residual: &Vector3<f64>,
    ) {
        let pairs = spokes.iter().zip(columns);
        let scaled = pairs.map(|(spoke, column)| column * self.weights[spoke.group.index()]);
        let scaled: Vec<_> = scaled.collect();
        self.equations.add(star, spokes, &scaled, residual);
    }
}

/// Fraction of a direction's largest entry below which an entry is rounding and moves no unknown past its limit.
const SIDEWAYS_RATIO: f64 = 1e-6;

/// Largest number of unknowns for which a dense matrix is faster.
const MAX_DENSE_UNKNOWNS: usize = 40;

/// Workspace of the normal equations.
enum Equations<'a> {
    Dense(Vec<f64>),
    Sparse(Box<SparseNormalEquations<'a>>),
}

impl<'a> Equations<'a> {
    fn new(
        stars: StarsView<'_, f64>,
        loops: LoopsView<'_, f64>,
        structure: &OnceLock<Option<Arc<Structure>>>,
        watch: Watch<'a>,
    ) -> Self {
        let n = stars.unknowns();
        let find = || Structure::new(stars, loops).map(Arc::new);
        let structure = (n > MAX_DENSE_UNKNOWNS)
            .then(|| structure.get_or_init(find).clone())
            .flatten();
        match structure {
            Some(structure) => Self::Sparse(Box::new(SparseNormalEquations::of(structure, watch))),
            None => Self::Dense(vec![0.0; DenseNormalEquations::<f64>::memory(n)]),
        }
    }
}
