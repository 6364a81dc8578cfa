//! Core's solvers with memory from the heap.

use foldpath_core::least_squares::{ClosureProblem, Limits, Options, Outcome, Report};
use foldpath_core::{
    DenseNormalEquations, HalfAngle, Scalar, StarsView, closure, gradient, levenberg_marquardt,
    norm,
};
use nalgebra::Vector3;

use super::sparse::SparseNormalEquations;
use super::{Solver, chord};

/// Steps that the gradient solver may take: it converges linearly.
const GRADIENT_ITERATIONS: u32 = 20_000;

/// Work done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Work {
    pub(super) iterations: u64,
    pub(super) evaluations: u64,
}

/// The closure of some stars, with all memory that solving it needs.
pub(super) struct ClosureSolver<'a> {
    stars: StarsView<'a, f64>,
    kind: Solver,
    /// Closure residual of a local minimum that still counts as closed.
    accepted: f64,
    half_angles: Vec<HalfAngle<f64>>,
    columns: Vec<Vector3<f64>>,
    equations: Equations,
    workspace: Vec<f64>,
    pub(super) work: Work,
}

impl<'a> ClosureSolver<'a> {
    pub(super) fn new(stars: StarsView<'a, f64>, kind: Solver, accepted: f64) -> Self {
        let n = stars.unknowns();
        Self {
            stars,
            kind,
            accepted,
            half_angles: vec![HalfAngle::default(); n],
            columns: vec![Vector3::zeros(); stars.max_degree()],
            equations: Equations::new(stars),
            workspace: vec![0.0; 3 * n],
            work: Work::default(),
        }
    }

    /// Moves `x` to the closed configuration near it.
    pub(super) fn close(&mut self, x: &mut [f64]) -> Report<f64> {
        let n = self.stars.unknowns();
        let Some(mut problem) =
            ClosureProblem::new(self.stars, &mut self.half_angles, &mut self.columns)
        else {
            unreachable!("memory for all unknowns and the largest star")
        };
        let mut options = Options {
            acceptable: self.accepted,
            ..Options::default()
        };
        let limits = Limits::HalfTurn;
        let work = &mut self.workspace;
        let report = match (self.kind, &mut self.equations) {
            (Solver::Gradient, _) => {
                options.max_iterations = GRADIENT_ITERATIONS;
                gradient::solve(&mut problem, limits, &options, x, work)
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

    /// Whether `x`, moved to the closed configuration near it, closes: to rounding, or, where rounded
    /// coordinates leave no configuration that does, as well as can be and within what is accepted.
    pub(super) fn closes(&mut self, x: &mut [f64]) -> bool {
        if self.closes_by_chord(x) {
            return true;
        }
        let report = self.close(x);
        match report.outcome {
            Outcome::Converged => true,
            Outcome::Stalled => report.residual <= self.accepted,
            _ => false,
        }
    }

    /// Tries the way that costs one factorisation. Not where rounded coordinates may leave nothing
    /// that closes: only damping keeps a step small there.
    fn closes_by_chord(&mut self, x: &mut [f64]) -> bool {
        let exact = self.accepted <= f64::CLOSURE_TOLERANCE;
        let (Solver::LevenbergMarquardt, Equations::Sparse(equations), true) =
            (self.kind, &mut self.equations, exact)
        else {
            return false;
        };
        let problem = ClosureProblem::new(self.stars, &mut self.half_angles, &mut self.columns);
        let Some(chord) = problem
            .and_then(|mut problem| chord::close(&mut problem, equations, x, &mut self.workspace))
        else {
            return false;
        };
        self.work.iterations += u64::from(chord.steps);
        self.work.evaluations += u64::from(chord.steps) + 1;
        chord.closed
    }

    /// Replaces `direction` by the nearest infinitesimal motion at `x`.
    pub(super) fn project_on_motions(&mut self, x: &[f64], direction: &mut [f64]) -> bool {
        self.work.evaluations += 1;
        let problem = ClosureProblem::new(self.stars, &mut self.half_angles, &mut self.columns);
        let Some(mut problem) = problem else {
            return false;
        };
        match &mut self.equations {
            Equations::Dense(memory) => {
                DenseNormalEquations::new(x.len(), memory).is_some_and(|mut equations| {
                    problem.linearise(x, &mut equations).is_some()
                        && levenberg_marquardt::project_on_motions(&mut equations, direction)
                })
            }
            Equations::Sparse(equations) => {
                problem.linearise(x, equations.as_mut()).is_some()
                    && levenberg_marquardt::project_on_motions(equations.as_mut(), direction)
            }
        }
    }
}

/// Unknowns up to which a dense matrix is the faster one.
const DENSE: usize = 40;

/// Memory of the normal equations.
enum Equations {
    Dense(Vec<f64>),
    Sparse(Box<SparseNormalEquations>),
}

impl Equations {
    fn new(stars: StarsView<'_, f64>) -> Self {
        let n = stars.unknowns();
        let sparse = (n > DENSE)
            .then(|| SparseNormalEquations::new(stars))
            .flatten();
        match sparse {
            Some(sparse) => Self::Sparse(Box::new(sparse)),
            None => Self::Dense(vec![0.0; DenseNormalEquations::<f64>::memory(n)]),
        }
    }
}

/// Largest closure residual of the stars at the group angles `x`.
pub(super) fn max_closure(stars: StarsView<'_, f64>, x: &[f64]) -> f64 {
    let mut half_angles = vec![HalfAngle::default(); x.len()];
    closure::half_angles(x, &mut half_angles);
    let residuals = stars
        .iter()
        .map(|star| norm(&closure::residual(star, &half_angles)));
    residuals.fold(0.0, |max, r| if r > max || r.is_nan() { r } else { max })
}
