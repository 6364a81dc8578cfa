//! Runs every method on every problem at every tolerance.

use core::time::Duration;
use std::time::Instant;

use super::{Method, Problem, Run};

/// Amount of work of a measurement.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Number of starts of each problem.
    pub starts: usize,
    /// Largest number of runs of each start.
    pub rounds: usize,
    /// Time that one method has for all starts at one tolerance.
    pub budget: Duration,
    /// Time that one run has.
    pub limit: Duration,
}

/// Result of a method on a problem at a tolerance.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Index of the problem.
    pub problem: usize,
    /// The method.
    pub method: Method,
    /// Tolerance of the closure residual.
    pub tolerance: f64,
    /// Number of runs.
    pub runs: usize,
    /// Number of runs that did not reach the tolerance.
    pub failures: usize,
    /// Median time of all runs, with an infinite time for a failure; `None` if half of the runs fail.
    pub seconds: Option<f64>,
    /// Median closure residual of all runs.
    pub closure: f64,
    /// Median number of evaluations without derivatives.
    pub values: u64,
    /// Median number of evaluations with derivatives.
    pub derivatives: u64,
}

/// Returns the tolerances, 1e-1 to 1e-13.
#[must_use]
pub fn tolerances() -> Vec<f64> {
    (1..=13).map(|power| 10_f64.powi(-power)).collect()
}

/// Runs all methods on all problems. A method that fails at half of the starts is not run at finer tolerances, which
/// would take it even longer. Methods take turns at each tolerance, so that all of them meet the same noise of the
/// machine.
#[must_use]
pub fn measure(problems: &[Problem], effort: &Effort) -> Vec<Cell> {
    let mut cells = Vec::new();
    for (index, problem) in problems.iter().enumerate() {
        let began = Instant::now();
        let starts = problem.starts(effort.starts);
        let methods = Method::ALL.into_iter();
        let fits = |method: &Method| problem.unknowns() <= method.most_unknowns();
        let mut solvers: Vec<_> = methods
            .filter(fits)
            .map(|method| (method, method.solver(problem)))
            .collect();
        for tolerance in tolerances() {
            solvers.retain_mut(|(method, solver)| {
                let mut runs = Vec::new();
                let began = Instant::now();
                for start in (0..effort.rounds).flat_map(|_| &starts) {
                    runs.push(solver.run(start, tolerance, effort.limit));
                    if began.elapsed() >= effort.budget {
                        break;
                    }
                }
                let cell = Cell::new(index, problem, *method, tolerance, &runs);
                let reached = cell.seconds.is_some();
                cells.push(cell);
                reached
            });
        }
        eprintln!(
            "{}: {} unknowns, folded by {:.2}, {:.1} s",
            problem.name(),
            problem.unknowns(),
            problem.folded(),
            began.elapsed().as_secs_f64()
        );
    }
    cells
}

impl Cell {
    fn new(index: usize, problem: &Problem, method: Method, tolerance: f64, runs: &[Run]) -> Self {
        let closures: Vec<f64> = runs.iter().map(|run| problem.closure(&run.x)).collect();
        let failures = closures.iter().filter(|&&c| c > tolerance).count();
        let times = runs.iter().zip(&closures).map(|(run, &closure)| {
            let reached = closure <= tolerance;
            if reached {
                run.time.as_secs_f64()
            } else {
                f64::INFINITY
            }
        });
        let seconds = median(times.collect());
        let count = |of: fn(&Run) -> u64| {
            let mut counts: Vec<u64> = runs.iter().map(of).collect();
            counts.sort_unstable();
            counts[counts.len() / 2]
        };
        Self {
            problem: index,
            method,
            tolerance,
            runs: runs.len(),
            failures,
            seconds: seconds.is_finite().then_some(seconds),
            closure: median(closures),
            values: count(|run| run.values),
            derivatives: count(|run| run.derivatives),
        }
    }
}

/// Returns the upper median.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
