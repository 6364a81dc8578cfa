//! The peer of crate `levenberg-marquardt`: MINPACK's Levenberg-Marquardt on dense matrices.

use core::cell::RefCell;
use core::time::Duration;

use foldpath_core::StarsView;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use peer_nalgebra::{DMatrix, DVector, Dyn, VecStorage};

use super::evaluator::Evaluator;
use super::method::{Run, Solver};

struct Peer<'a>(StarsView<'a, f64>);

/// Returns the solver, with its own stopping tests at the machine precision and without a limit of iterations.
pub(super) fn solver(stars: StarsView<'_, f64>) -> Box<dyn Solver + '_> {
    Box::new(Peer(stars))
}

struct Residuals<'a> {
    evaluator: RefCell<Evaluator<'a>>,
    x: DVector<f64>,
    /// Number of residuals. MINPACK needs at least as many residuals as unknowns; missing ones are 0.
    rows: usize,
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Residuals<'_> {
    type ResidualStorage = VecStorage<f64, Dyn, peer_nalgebra::U1>;
    type JacobianStorage = VecStorage<f64, Dyn, Dyn>;
    type ParameterStorage = VecStorage<f64, Dyn, peer_nalgebra::U1>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.x.copy_from(x);
    }

    fn params(&self) -> DVector<f64> {
        self.x.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let mut out = DVector::zeros(self.rows);
        let mut evaluator = self.evaluator.borrow_mut();
        let evaluated = evaluator.residuals(self.x.as_slice(), out.as_mut_slice());
        evaluated.ok().map(|()| out)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let mut out = DMatrix::zeros(self.rows, self.x.len());
        let add = |row, column, entry| out[(row, column)] += entry;
        self.evaluator.borrow_mut().jacobian(self.x.as_slice(), add);
        Some(out)
    }
}

impl Solver for Peer<'_> {
    fn run(&mut self, start: &[f64], tolerance: f64, limit: Duration) -> Run {
        let mut evaluator = Evaluator::new(self.0, tolerance);
        let solver = LevenbergMarquardt::new()
            .with_tol(f64::EPSILON)
            .with_patience(usize::MAX >> 12);
        let rows = evaluator.rows().max(start.len());
        let x = DVector::from_column_slice(start);
        let began = evaluator.start(limit);
        let problem = Residuals {
            evaluator: RefCell::new(evaluator),
            x,
            rows,
        };
        let (problem, _) = solver.minimize(problem);
        let time = began.elapsed();
        let done = problem.evaluator.into_inner();
        Run {
            time,
            values: done.values,
            derivatives: done.derivatives,
            x: done.best,
        }
    }
}
