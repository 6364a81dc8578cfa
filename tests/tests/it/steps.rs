//! How many iterations does Levenberg-Marquardt take to closure, and how many factorisations with each kind of
//! [`FactorReuse`]?

use foldpath::planner::SparseNormalEquations;
use foldpath_core::least_squares::{
    Accumulate, ClosureProblem, FactorReuse, Limits, NormalEquations, Options, Outcome,
};
use foldpath_core::{HalfAngle, LoopsView, Spoke, levenberg_marquardt};
use foldpath_tests::projection::{Family, Problem, residuals_by_iteration};
use nalgebra::Vector3;

/// Sparse equations that count their factorisations.
struct Counted {
    equations: SparseNormalEquations<'static>,
    factorisations: u32,
}

impl Accumulate<f64> for Counted {
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
        self.equations.add(star, spokes, columns, residual);
    }
}

impl NormalEquations<f64> for Counted {
    const KEEPS_ROWS: bool = SparseNormalEquations::KEEPS_ROWS;

    fn unknowns(&self) -> usize {
        self.equations.unknowns()
    }

    fn gradient(&self) -> &[f64] {
        self.equations.gradient()
    }

    fn max_diagonal(&mut self) -> f64 {
        self.equations.max_diagonal()
    }

    fn fix_unknown(&mut self, unknown: usize, by: f64) -> f64 {
        self.equations.fix_unknown(unknown, by)
    }

    fn fix_in_factor(&mut self, unknown: usize) -> bool {
        self.equations.fix_in_factor(unknown)
    }

    fn clear_residuals(&mut self) {
        self.equations.clear_residuals();
    }

    fn add_residual(&mut self, block: usize, spokes: &[Spoke<f64>], residual: &Vector3<f64>) {
        self.equations.add_residual(block, spokes, residual);
    }

    fn factorise(&mut self, damping: f64) -> bool {
        self.factorisations += 1;
        self.equations.factorise(damping)
    }

    fn solve(&mut self, right_side: &mut [f64]) {
        self.equations.solve(right_side);
    }
}

/// Returns the number of factorisations from `start` to closure, and the distance that the unknowns have moved.
fn close(problem: &Problem, start: &[f64], factor_reuse: FactorReuse) -> (u32, f64) {
    let (stars, n) = (problem.stars(), start.len());
    let mut half = vec![HalfAngle::default(); n];
    let mut columns = vec![Vector3::zeros(); stars.max_degree()];
    let mut closure = ClosureProblem::new(stars, &mut half, &mut columns).unwrap();
    let mut equations = Counted {
        equations: SparseNormalEquations::new(stars, LoopsView::none()).unwrap(),
        factorisations: 0,
    };
    let options = Options {
        factor_reuse,
        ..Options::default()
    };
    let (mut x, mut work) = (start.to_vec(), vec![0.0; 2 * n]);
    let limits = Limits::HalfTurn;
    let report = levenberg_marquardt::solve(
        &mut closure,
        &mut equations,
        limits,
        &options,
        &mut x,
        &mut work,
    );
    assert_eq!(report.outcome, Outcome::Converged, "{report:?}");
    assert!(problem.closure(&x) <= options.tolerance);
    assert!((0..n).all(|k| limits.clamp(k, x[k]).total_cmp(&x[k]).is_eq()));
    let moved = x.iter().zip(start).map(|(to, from)| (to - from).powi(2));
    (equations.factorisations, moved.sum::<f64>().sqrt())
}

/// Closing to rounding takes half the factorisations if factors are reused. The configuration found is hardly farther
/// away.
#[test]
fn large_sheets_close_nearby_with_half_the_factorisations() {
    for (family, rows, columns) in [
        (Family::Miura, 11, 11),
        (Family::Miura, 24, 24),
        (Family::Waterbomb, 12, 22),
        (Family::Yoshimura, 24, 24),
        (Family::Resch, 6, 6),
    ] {
        let problem = Problem::new(family, rows, columns, false);
        for start in problem.starts(5) {
            let ways = [FactorReuse::None, FactorReuse::Chord];
            let [none, chord] = ways.map(|reuse| close(&problem, &start, reuse));
            let what = format!("{}: {none:?} {chord:?}", problem.name());
            assert!(2 * chord.0 <= none.0 + 1, "{what}");
            assert!(chord.1 <= 1.05 * none.1, "{what}");
        }
    }
}

/// Hinges that reach a limit at half a turn, which are fixed in the factor instead of in a new one, and sheets that
/// close at the flat configuration.
#[test]
fn sheets_with_limits_close_too() {
    for (rows, columns) in [(3, 4), (5, 5), (11, 11)] {
        let problem = Problem::new(Family::Quad, rows, columns, false);
        for start in problem.starts(5) {
            let ways = [FactorReuse::None, FactorReuse::Chord];
            let [none, chord] = ways.map(|reuse| close(&problem, &start, reuse));
            let what = format!("{}: {none:?} {chord:?}", problem.name());
            assert!(2 * chord.0 <= none.0 + 2, "{what}");
        }
    }
}

/// From a residual of 1e-2 on, each iteration gains at least half as many digits again, and three iterations suffice
/// for 1e-14. A method of first order would take ten times as many.
#[test]
fn levenberg_marquardt_converges_quadratically() {
    for (family, rows, columns, symmetric) in [
        (Family::Miura, 3, 3, true),
        (Family::Miura, 3, 3, false),
        (Family::Miura, 11, 11, false),
        (Family::Waterbomb, 4, 6, true),
    ] {
        let problem = Problem::new(family, rows, columns, symmetric);
        for start in problem.starts(10) {
            let residuals = residuals_by_iteration(problem.stars(), &start);
            assert!(residuals.last().unwrap() <= &1e-14, "{residuals:?}");
            let near = residuals.iter().position(|&r| r <= 1e-2).unwrap();
            assert!(residuals.len() - 1 - near <= 3, "{residuals:?}");
            for pair in residuals[near..].windows(2) {
                let enough = pair[0].powf(1.5).max(1e-14);
                assert!(pair[1] <= enough, "{residuals:?}");
            }
        }
    }
}

/// A large sheet comes near closure in hardly more iterations than a small one: the damping does not grow with the
/// sheet.
#[test]
fn large_sheets_take_no_more_iterations() {
    for family in [Family::Miura, Family::Yoshimura] {
        let [small, large] = [3, 24].map(|size| {
            let problem = Problem::new(family, size, size, false);
            let near = problem.starts(5).into_iter().map(|start| {
                let residuals = residuals_by_iteration(problem.stars(), &start);
                residuals.iter().position(|&r| r <= 1e-2).unwrap()
            });
            near.max().unwrap()
        });
        assert!(large <= small + 1, "{}: {small}, {large}", family.name());
    }
}

/// A hinge that its limit stops at half a turn costs hardly an iteration, because the step of the other hinges takes
/// the stop into account.
#[test]
fn hinges_at_their_limits_cost_no_iterations() {
    let problem = Problem::new(Family::Quad, 11, 11, false);
    assert!(problem.folded() >= core::f64::consts::PI - 1e-9);
    for start in problem.starts(10) {
        let residuals = residuals_by_iteration(problem.stars(), &start);
        assert!(residuals.len() - 1 <= 9, "{residuals:?}");
    }
}
