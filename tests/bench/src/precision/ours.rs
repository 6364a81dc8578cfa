//! foldpath's solvers with memory on the heap, as the planner calls them, and the random search.

use core::time::Duration;
use std::time::Instant;

use foldpath::planner::SparseNormalEquations;
use foldpath_core::least_squares::{
    ClosureProblem, FactorReuse, Limits, NormalEquations, Options, Outcome, Report,
};
use foldpath_core::sampling::random_near;
use foldpath_core::{
    DenseNormalEquations, HalfAngle, LoopsView, Scalar, Spoke, StarsView, gradient,
    levenberg_marquardt,
};
use foldpath_tests::projection::DENSE;
use nalgebra::Vector3;
use rand_pcg::Pcg64;

use super::evaluator::Evaluator;
use super::method::{Run, Solver};

/// Iterations of the gradient solver between two readings of the clock, as in the planner.
const SLICE: u32 = 500;
/// Failures in a row after which the radius of samples shrinks (`PATIENCE`), and factors of the radius after failures
/// and after a success. Same values as in the planner.
const PATIENCE: u32 = 5;
const NARROWER: f64 = 0.6;
const WIDER: f64 = 1.3;
/// First and least radius of samples, radians.
const FIRST_RADIUS: f64 = 0.1;
const LEAST_RADIUS: f64 = 1e-17;

/// Stars in any precision, with the memory of a solver.
struct Memory<T> {
    spokes: Vec<Spoke<T>>,
    ends: Vec<u32>,
    unknowns: usize,
    half: Vec<HalfAngle<T>>,
    columns: Vec<Vector3<T>>,
    workspace: Vec<T>,
}

impl<T: Scalar> Memory<T> {
    fn new(stars: StarsView<'_, f64>) -> Self {
        let mut spokes = Vec::new();
        let mut ends = Vec::new();
        for star in stars.iter() {
            spokes.extend(star.spokes.iter().map(|spoke| Spoke {
                group: spoke.group,
                negative: spoke.negative,
                direction: spoke.direction.map(T::lit),
            }));
            ends.push(u32::try_from(spokes.len()).expect("fewer spokes than that"));
        }
        let unknowns = stars.unknowns();
        Self {
            spokes,
            ends,
            unknowns,
            half: vec![HalfAngle::default(); unknowns],
            columns: vec![Vector3::repeat(T::zero()); stars.max_degree()],
            workspace: vec![T::zero(); 3 * unknowns],
        }
    }

    /// Returns the problem and the workspace.
    fn problem(&mut self) -> (ClosureProblem<'_, T>, &mut [T]) {
        let stars = StarsView::new(&self.spokes, &self.ends, self.unknowns).expect("stars");
        let problem = ClosureProblem::new(stars, &mut self.half, &mut self.columns);
        (problem.expect("memory enough"), &mut self.workspace)
    }
}

fn options<T: Scalar>(tolerance: f64) -> Options<T> {
    Options {
        tolerance: T::lit(tolerance),
        // The solver must not accept a residual above the tolerance.
        acceptable: T::zero(),
        ..Options::default()
    }
}

/// Levenberg-Marquardt with the linear algebra that the planner uses for this number of unknowns.
struct Lm<T> {
    memory: Memory<T>,
    equations: Equations<T>,
    factor_reuse: FactorReuse,
}

enum Equations<T> {
    Dense(Vec<T>),
    /// Sparse equations, which exist in f64 only.
    Sparse(Box<SparseNormalEquations<'static>>),
}

impl<T: Scalar> Lm<T> {
    fn dense(stars: StarsView<'_, f64>) -> Self {
        let memory = DenseNormalEquations::<T>::memory(stars.unknowns());
        Self {
            memory: Memory::new(stars),
            equations: Equations::Dense(vec![T::zero(); memory]),
            factor_reuse: FactorReuse::None,
        }
    }
}

/// A solver in some precision.
trait Solve<T> {
    /// Moves `x` to closure in about the time `limit`. Returns the report, and the time without the creation of views.
    fn solve(
        &mut self,
        x: &mut [T],
        options: &Options<T>,
        limit: Duration,
    ) -> (Report<T>, Duration);
}

impl Lm<f64> {
    fn new(stars: StarsView<'_, f64>, factor_reuse: FactorReuse) -> Self {
        let sparse = (stars.unknowns() > DENSE)
            .then(|| SparseNormalEquations::new(stars, LoopsView::none()))
            .flatten();
        match sparse {
            None => Self::dense(stars),
            Some(sparse) => Self {
                memory: Memory::new(stars),
                equations: Equations::Sparse(Box::new(sparse)),
                factor_reuse,
            },
        }
    }
}

impl Solve<f64> for Lm<f64> {
    fn solve(
        &mut self,
        x: &mut [f64],
        options: &Options<f64>,
        _limit: Duration,
    ) -> (Report<f64>, Duration) {
        match &mut self.equations {
            Equations::Dense(dense) => solve_dense(&mut self.memory, dense, x, options),
            Equations::Sparse(sparse) => {
                let options = Options {
                    factor_reuse: self.factor_reuse,
                    ..*options
                };
                solve_with(&mut self.memory, sparse.as_mut(), x, &options)
            }
        }
    }
}

impl Solve<f32> for Lm<f32> {
    fn solve(
        &mut self,
        x: &mut [f32],
        options: &Options<f32>,
        _limit: Duration,
    ) -> (Report<f32>, Duration) {
        match &mut self.equations {
            Equations::Dense(dense) => solve_dense(&mut self.memory, dense, x, options),
            Equations::Sparse(_) => unreachable!("made for f64 alone"),
        }
    }
}

fn solve_dense<T: Scalar>(
    memory: &mut Memory<T>,
    dense: &mut [T],
    x: &mut [T],
    options: &Options<T>,
) -> (Report<T>, Duration) {
    let mut equations = DenseNormalEquations::new(x.len(), dense).expect("memory for all unknowns");
    solve_with(memory, &mut equations, x, options)
}

/// Solves without a check of the time, because the solver stops after a hundred iterations.
fn solve_with<T: Scalar>(
    memory: &mut Memory<T>,
    equations: &mut impl NormalEquations<T>,
    x: &mut [T],
    options: &Options<T>,
) -> (Report<T>, Duration) {
    let (mut problem, work) = memory.problem();
    let limits = Limits::HalfTurn;
    let began = Instant::now();
    let report = levenberg_marquardt::solve(&mut problem, equations, limits, options, x, work);
    (report, began.elapsed())
}

/// The gradient solver.
struct GradientSolver<T>(Memory<T>);

impl<T: Scalar> Solve<T> for GradientSolver<T> {
    fn solve(
        &mut self,
        x: &mut [T],
        options: &Options<T>,
        limit: Duration,
    ) -> (Report<T>, Duration) {
        let options = Options {
            max_iterations: SLICE,
            ..*options
        };
        let (mut problem, work) = self.0.problem();
        let began = Instant::now();
        let mut report = gradient::solve(&mut problem, Limits::HalfTurn, &options, x, work);
        while report.outcome == Outcome::IterationLimit && began.elapsed() < limit {
            let next = gradient::solve(&mut problem, Limits::HalfTurn, &options, x, work);
            report = Report {
                iterations: report.iterations + next.iterations,
                evaluations: report.evaluations + next.evaluations,
                ..next
            };
        }
        (report, began.elapsed())
    }
}

/// A solver that runs in precision T from starts in f64.
struct InPrecision<T, S> {
    solver: S,
    x: Vec<T>,
}

impl<T: Scalar, S: Solve<T>> Solver for InPrecision<T, S> {
    fn run(&mut self, start: &[f64], tolerance: f64, limit: Duration) -> Run {
        self.x.clear();
        self.x.extend(start.iter().map(|&x| T::lit(x)));
        let (report, time) = self.solver.solve(&mut self.x, &options(tolerance), limit);
        Run {
            time,
            x: self.x.iter().map(|x| x.to_f64()).collect(),
            values: 0,
            derivatives: report.evaluations.into(),
        }
    }
}

fn boxed<'a, T: Scalar, S: Solve<T> + 'a>(solver: S) -> Box<dyn Solver + 'a> {
    let x = Vec::new();
    Box::new(InPrecision { solver, x })
}

/// Returns Levenberg-Marquardt in f64, whose sparse equations reuse a factorisation.
pub(super) fn levenberg_marquardt_f64(stars: StarsView<'_, f64>) -> Box<dyn Solver> {
    boxed::<f64, _>(Lm::<f64>::new(stars, FactorReuse::Chord))
}

/// Returns Levenberg-Marquardt in f32, with dense matrices as on the controller.
pub(super) fn levenberg_marquardt_f32(stars: StarsView<'_, f64>) -> Box<dyn Solver> {
    boxed::<f32, _>(Lm::<f32>::dense(stars))
}

/// Returns the gradient solver in either precision.
pub(super) fn gradient<T: Scalar>(stars: StarsView<'_, f64>) -> Box<dyn Solver> {
    boxed::<T, _>(GradientSolver(Memory::new(stars)))
}

/// The randomised search without a solver; in the planner Levenberg-Marquardt closes the samples. A sample round the
/// best configuration replaces it if it closes better. The radius shrinks after failures and grows after a success.
struct RandomSearch<'a>(StarsView<'a, f64>);

/// Returns the random search.
pub(super) fn random_search(stars: StarsView<'_, f64>) -> Box<dyn Solver + '_> {
    Box::new(RandomSearch(stars))
}

impl Solver for RandomSearch<'_> {
    fn run(&mut self, start: &[f64], tolerance: f64, limit: Duration) -> Run {
        let mut evaluator = Evaluator::new(self.0, tolerance);
        let mut rng = Pcg64::new(2015, 4);
        let (mut here, mut sample) = (start.to_vec(), start.to_vec());
        let began = evaluator.start(limit);
        let (mut radius, mut failures) = (FIRST_RADIUS, 0);
        let mut best = evaluator.value(&here);
        while let (Ok(least), true) = (best, radius >= LEAST_RADIUS) {
            random_near(&mut rng, &here, radius, Limits::HalfTurn, &mut sample);
            match evaluator.value(&sample) {
                Ok(value) if value < least => {
                    here.copy_from_slice(&sample);
                    (best, failures) = (Ok(value), 0);
                    radius = (radius * WIDER).min(FIRST_RADIUS);
                }
                Ok(_) => {
                    failures += 1;
                    if failures == PATIENCE {
                        (radius, failures) = (radius * NARROWER, 0);
                    }
                }
                Err(stopped) => best = Err(stopped),
            }
        }
        Run {
            time: began.elapsed(),
            values: evaluator.values,
            derivatives: evaluator.derivatives,
            x: evaluator.best,
        }
    }
}
