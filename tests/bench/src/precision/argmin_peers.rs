//! Peers of crate `argmin`: L-BFGS, Gauss-Newton, and a trust region with the Gauss-Newton Hessian.

use core::cell::RefCell;
use core::time::Duration;
use std::rc::Rc;

use argmin::core::{
    ArgminFloat, CostFunction, Error, Executor, Gradient, Hessian, IterState, Jacobian, Operator,
    Solver as ArgminSolver,
};
use argmin::solver::gaussnewton::GaussNewton;
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use argmin::solver::trustregion::{Steihaug, TrustRegion};
use foldpath_core::StarsView;
use peer_nalgebra::{DMatrix, DVector};

use super::evaluator::{Evaluator, Stopped};
use super::method::{Run, Solver};

/// Number of steps that L-BFGS remembers.
const MEMORY: usize = 10;

/// One evaluator for all functions that argmin needs. It is shared so that it can be read after a run was stopped.
#[derive(Clone)]
struct Problem<'a> {
    evaluator: Rc<RefCell<Evaluator<'a>>>,
}

impl core::fmt::Display for Stopped {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("closed, or out of time")
    }
}

impl core::error::Error for Stopped {}

type Vector = DVector<f64>;

impl CostFunction for Problem<'_> {
    type Param = Vector;
    type Output = f64;

    fn cost(&self, x: &Vector) -> Result<f64, Error> {
        Ok(self.evaluator.borrow_mut().value(x.as_slice())?)
    }
}

impl Gradient for Problem<'_> {
    type Param = Vector;
    type Gradient = Vector;

    fn gradient(&self, x: &Vector) -> Result<Vector, Error> {
        let mut gradient = DVector::zeros(x.len());
        let out = gradient.as_mut_slice();
        self.evaluator.borrow_mut().gradient(x.as_slice(), out)?;
        Ok(gradient)
    }
}

impl Operator for Problem<'_> {
    type Param = Vector;
    type Output = Vector;

    fn apply(&self, x: &Vector) -> Result<Vector, Error> {
        let mut evaluator = self.evaluator.borrow_mut();
        let mut out = DVector::zeros(evaluator.rows());
        evaluator.residuals(x.as_slice(), out.as_mut_slice())?;
        Ok(out)
    }
}

impl Jacobian for Problem<'_> {
    type Param = Vector;
    type Jacobian = DMatrix<f64>;

    fn jacobian(&self, x: &Vector) -> Result<DMatrix<f64>, Error> {
        let mut evaluator = self.evaluator.borrow_mut();
        let mut out = DMatrix::zeros(evaluator.rows(), x.len());
        let add = |row, column, entry| out[(row, column)] += entry;
        evaluator.jacobian(x.as_slice(), add);
        Ok(out)
    }
}

impl Hessian for Problem<'_> {
    type Param = Vector;
    type Hessian = DMatrix<f64>;

    fn hessian(&self, x: &Vector) -> Result<DMatrix<f64>, Error> {
        let jacobian = self.jacobian(x)?;
        Ok(jacobian.tr_mul(&jacobian))
    }
}

struct Peer<'a, R> {
    stars: StarsView<'a, f64>,
    run: R,
}

impl<R: Fn(Problem<'_>, Vector)> Solver for Peer<'_, R> {
    fn run(&mut self, start: &[f64], tolerance: f64, limit: Duration) -> Run {
        let evaluator = Rc::new(RefCell::new(Evaluator::new(self.stars, tolerance)));
        let problem = Problem {
            evaluator: evaluator.clone(),
        };
        let x = DVector::from_column_slice(start);
        let began = evaluator.borrow_mut().start(limit);
        (self.run)(problem, x);
        let time = began.elapsed();
        let done = evaluator.borrow();
        Run {
            time,
            values: done.values,
            derivatives: done.derivatives,
            x: done.best.clone(),
        }
    }
}

/// Runs until the evaluator stops the solver, or the solver stops by itself.
fn execute<'a, S, G, J, H, R>(problem: Problem<'a>, solver: S, x: Vector)
where
    IterState<Vector, G, J, H, R, f64>: argmin::core::State<Param = Vector, Float = f64>,
    S: ArgminSolver<Problem<'a>, IterState<Vector, G, J, H, R, f64>>,
    f64: ArgminFloat,
{
    let executor = Executor::new(problem, solver);
    let executor = executor
        .configure(|state: IterState<Vector, G, J, H, R, f64>| state.param(x).max_iters(u64::MAX));
    // An error means that the evaluator stopped the run, or that the solver gave up.
    let _ = executor.ctrlc(false).run();
}

/// Returns L-BFGS with its own stopping tests switched off.
pub(super) fn lbfgs(stars: StarsView<'_, f64>) -> Box<dyn Solver + '_> {
    let run = |problem: Problem<'_>, x| {
        let solver = LBFGS::new(MoreThuenteLineSearch::new(), MEMORY)
            .with_tolerance_grad(0.0)
            .and_then(|solver| solver.with_tolerance_cost(0.0));
        execute::<_, Vector, (), (), ()>(problem, solver.expect("tolerances"), x);
    };
    Box::new(Peer { stars, run })
}

/// Returns Gauss-Newton, which inverts JᵀJ.
pub(super) fn gauss_newton(stars: StarsView<'_, f64>) -> Box<dyn Solver + '_> {
    let run = |problem: Problem<'_>, x| {
        let solver = GaussNewton::new().with_tolerance(f64::MIN_POSITIVE);
        execute::<_, (), DMatrix<f64>, (), Vector>(problem, solver.expect("a tolerance"), x);
    };
    Box::new(Peer { stars, run })
}

/// Returns the trust region. Each step takes at most as many conjugate-gradient iterations as there are unknowns.
pub(super) fn trust_region(stars: StarsView<'_, f64>) -> Box<dyn Solver + '_> {
    let iterations = stars.unknowns() as u64;
    let run = move |problem: Problem<'_>, x| {
        let inner = Steihaug::new().with_max_iters(iterations);
        let inner = inner.with_epsilon(f64::MIN_POSITIVE).expect("an epsilon");
        execute::<_, Vector, (), DMatrix<f64>, ()>(problem, TrustRegion::new(inner), x);
    };
    Box::new(Peer { stars, run })
}
