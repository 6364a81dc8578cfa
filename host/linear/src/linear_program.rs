//! Solves linear programs whose variables all have bounds, by Mehrotra's predictor-corrector interior-point method.
//!
//! Source: J. Nocedal, S. Wright, "Numerical Optimization", 2006, algorithm 14.3. Differs from the source in that every
//! variable has an upper bound as well. An interior-point method is taken rather than the simplex method because it ends
//! inside the optimal face: the solution has as many variables away from their bounds as any solution has, and so does
//! the dual solution.
//!
//! It is made for very degenerate programs with a few entries a column.

use crate::cholesky::Factor;
use crate::gram::GramStructure;

/// Largest number of iterations; 15 to 40 are usual.
const MAX_ITERATIONS: usize = 100;
/// Mean complementarity of an accurate solution, in units of the cost. The normal equations cannot be solved below about
/// the square root of the rounding error: near the solution their matrix has entries of the size of the complementarity
/// and of its inverse.
const MAX_COMPLEMENTARITY_RATIO: f64 = 1e-8;
/// Largest error of a constraint, of the primal or the dual program, of an accurate solution.
const MAX_CONSTRAINT_ERROR: f64 = 1e-7;
/// Fraction of the way to the nearest bound that a step goes.
const STEP_RATIO: f64 = 0.995;

/// Number of rounds of iterative refinement for each system of equations.
const REFINEMENTS: usize = 2;

/// A variable of a linear program.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Its column of the matrix: rows, none twice, and values.
    pub column: Vec<(u32, f64)>,
    /// Its cost per unit.
    pub cost: f64,
    /// Its upper bound; the lower bound is 0.
    pub upper: f64,
    /// Value from which the search starts, between the bounds.
    pub start: f64,
}

/// A linear program: minimise c·x subject to A x = b and 0 ≤ x ≤ u.
#[derive(Clone, Debug, Default)]
pub struct LinearProgram {
    /// b.
    pub right_side: Vec<f64>,
    /// The columns of A with c and u.
    pub variables: Vec<Variable>,
}

/// The most accurate solution that the method came upon.
#[derive(Clone, Debug, Default)]
pub struct Solution {
    /// Values of the variables.
    pub x: Vec<f64>,
    /// Multipliers of the rows: the dual solution.
    pub y: Vec<f64>,
}

/// An iterate, in the notation of the source, with s = u - x and its multipliers v.
struct Iterate {
    x: Vec<f64>,
    s: Vec<f64>,
    z: Vec<f64>,
    v: Vec<f64>,
    y: Vec<f64>,
}

impl LinearProgram {
    /// Solves the program. Returns `None` if the matrix A Aᵀ is too large to be numbered.
    ///
    /// Cost: about 25 sparse factorisations of A Aᵀ.
    pub fn solve(&self) -> Option<Solution> {
        let mut normal = NormalMatrix::new(self)?;
        let mut at = self.start();
        let mut best = (f64::INFINITY, Solution::default());
        for _ in 0..MAX_ITERATIONS {
            let residuals = self.residuals(&at);
            let mean = at.complementarity();
            let error =
                (mean / MAX_COMPLEMENTARITY_RATIO).max(residuals.largest() / MAX_CONSTRAINT_ERROR);
            if error < best.0 {
                let (x, y) = (at.x.clone(), at.y.clone());
                best = (error, Solution { x, y });
            }
            let weights = at.weights();
            if best.0 <= 1.0
                || mean < MAX_COMPLEMENTARITY_RATIO * MAX_COMPLEMENTARITY_RATIO
                || !normal.factorise(self, &weights)
            {
                break;
            }
            // The slack to the upper bound moves against the variable.
            let second = |step: &Step, k: usize| (step.x[k] * step.z[k], -step.x[k] * step.v[k]);
            let aim = |centre: f64, predicted: Option<&Step>| -> (Vec<f64>, Vec<f64>) {
                let aims = (0..at.x.len()).map(|k| {
                    let (lower, upper) = predicted.map_or((0.0, 0.0), |step| second(step, k));
                    let [lower_product, upper_product] = [at.x[k] * at.z[k], at.s[k] * at.v[k]];
                    (
                        centre - lower_product - lower,
                        centre - upper_product - upper,
                    )
                });
                aims.unzip()
            };
            let affine = self.step(&at, &residuals, &aim(0.0, None), &weights, &mut normal);
            let reached = at.after(&affine, at.reach(&affine, 1.0)).complementarity();
            let centring = (reached / mean).powi(3).min(1.0);
            let aims = aim(centring * mean, Some(&affine));
            let step = self.step(&at, &residuals, &aims, &weights, &mut normal);
            let next = at.after(&step, at.reach(&step, STEP_RATIO));
            if !next.is_finite() {
                break;
            }
            at = next;
        }
        Some(best.1)
    }

    /// Returns a point inside the bounds, with multipliers that make it a point of the central path.
    fn start(&self) -> Iterate {
        let x: Vec<f64> = self.variables.iter().map(|v| v.start).collect();
        let s: Vec<f64> = self.variables.iter().map(|v| v.upper - v.start).collect();
        let inverse = |values: &[f64]| values.iter().map(|value| 1.0 / value).collect();
        Iterate {
            z: inverse(&x),
            v: inverse(&s),
            y: vec![0.0; self.right_side.len()],
            x,
            s,
        }
    }

    fn residuals(&self, at: &Iterate) -> Residuals {
        let mut primal = self.right_side.clone();
        let mut dual = Vec::with_capacity(self.variables.len());
        for (k, variable) in self.variables.iter().enumerate() {
            let mut rest = variable.cost - at.z[k] + at.v[k];
            for &(row, value) in &variable.column {
                primal[row as usize] -= value * at.x[k];
                rest -= value * at.y[row as usize];
            }
            dual.push(rest);
        }
        Residuals { primal, dual }
    }

    /// Solves the linear equations of one Newton step.
    fn step(
        &self,
        at: &Iterate,
        residuals: &Residuals,
        (lower, upper): &(Vec<f64>, Vec<f64>),
        weights: &[f64],
        normal: &mut NormalMatrix,
    ) -> Step {
        let n = self.variables.len();
        let gradient: Vec<f64> = (0..n)
            .map(|k| residuals.dual[k] - lower[k] / at.x[k] + upper[k] / at.s[k])
            .collect();
        let mut y = residuals.primal.clone();
        for (k, variable) in self.variables.iter().enumerate() {
            for &(row, value) in &variable.column {
                y[row as usize] += value * weights[k] * gradient[k];
            }
        }
        normal.solve(&mut y);
        let along = |y: &[f64], k: usize| {
            let column = self.variables[k].column.iter();
            let along = column.map(|&(row, value)| value * y[row as usize]);
            weights[k] * (along.sum::<f64>() - gradient[k])
        };
        // Near the end the matrix is nearly singular. Refinement removes the error that its factor leaves.
        for _ in 0..REFINEMENTS {
            let mut rest = residuals.primal.clone();
            for (k, variable) in self.variables.iter().enumerate() {
                let dx = along(&y, k);
                for &(row, value) in &variable.column {
                    rest[row as usize] -= value * dx;
                }
            }
            normal.solve(&mut rest);
            for (y, rest) in y.iter_mut().zip(&rest) {
                *y += rest;
            }
        }
        let mut step = Step {
            x: Vec::with_capacity(n),
            z: Vec::with_capacity(n),
            v: Vec::with_capacity(n),
            y: Vec::new(),
        };
        for k in 0..n {
            let dx = along(&y, k);
            step.x.push(dx);
            step.z.push((lower[k] - at.z[k] * dx) / at.x[k]);
            step.v.push((upper[k] + at.v[k] * dx) / at.s[k]);
        }
        step.y = y;
        step
    }
}

/// Errors of the constraints of both programs.
struct Residuals {
    primal: Vec<f64>,
    dual: Vec<f64>,
}

impl Residuals {
    fn largest(&self) -> f64 {
        let all = self.primal.iter().chain(&self.dual);
        all.fold(0.0, |most, rest| f64::max(most, rest.abs()))
    }
}

/// A change of the iterate.
struct Step {
    x: Vec<f64>,
    z: Vec<f64>,
    v: Vec<f64>,
    y: Vec<f64>,
}

impl Iterate {
    /// Returns the mean of all products of a slack and its multiplier.
    fn complementarity(&self) -> f64 {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        #[allow(clippy::cast_precision_loss, reason = "a mean")]
        let count = 2.0 * self.x.len().max(1) as f64;
        (dot(&self.x, &self.z) + dot(&self.s, &self.v)) / count
    }

    /// Returns the diagonal of the inverse of the barrier's Hessian.
    fn weights(&self) -> Vec<f64> {
        let weight = |k: usize| 1.0 / (self.z[k] / self.x[k] + self.v[k] / self.s[k]);
        (0..self.x.len()).map(weight).collect()
    }

    /// Returns the fractions of the step, of the primal and the dual variables, that stay inside the bounds.
    fn reach(&self, step: &Step, fraction: f64) -> [f64; 2] {
        let to_bound = |values: &[f64], change: &[f64], sign: f64| {
            let pairs = values.iter().zip(change);
            let shrinking = pairs.filter(|(_, change)| sign * **change < 0.0);
            shrinking.fold(f64::INFINITY, |least: f64, (value, change)| {
                least.min(value / -(sign * change))
            })
        };
        let primal = to_bound(&self.x, &step.x, 1.0).min(to_bound(&self.s, &step.x, -1.0));
        let dual = to_bound(&self.z, &step.z, 1.0).min(to_bound(&self.v, &step.v, 1.0));
        [primal, dual].map(|reach| (fraction * reach).min(1.0))
    }

    /// Returns the iterate after these fractions of the step.
    fn after(&self, step: &Step, [primal, dual]: [f64; 2]) -> Self {
        let moved = |values: &[f64], change: &[f64], part: f64| {
            let pairs = values.iter().zip(change);
            pairs.map(|(value, change)| value + part * change).collect()
        };
        Self {
            x: moved(&self.x, &step.x, primal),
            s: moved(&self.s, &step.x, -primal),
            z: moved(&self.z, &step.z, dual),
            v: moved(&self.v, &step.v, dual),
            y: moved(&self.y, &step.y, dual),
        }
    }

    fn is_finite(&self) -> bool {
        let all = [&self.x, &self.s, &self.z, &self.v, &self.y];
        all.iter()
            .all(|values| values.iter().all(|value| value.is_finite()))
    }
}

/// The matrix A W Aᵀ of the normal equations and its factor.
struct NormalMatrix {
    /// The matrix, with a block for each variable.
    structure: GramStructure,
    factor: Factor,
    /// Entries of the lower triangle, column by column.
    values: Vec<f64>,
}

impl NormalMatrix {
    fn new(program: &LinearProgram) -> Option<Self> {
        let rows = program
            .variables
            .iter()
            .map(|variable| variable.column.iter());
        let rows = rows.map(|column| column.map(|(row, _)| *row)).collect();
        let structure = GramStructure::new(program.right_side.len(), &rows)?;
        Some(Self {
            factor: Factor::new(&structure.symbolic),
            values: vec![0.0; structure.entries],
            structure,
        })
    }

    /// Factorises A W Aᵀ for these weights. Returns `false` if that is not positive definite to rounding.
    fn factorise(&mut self, program: &LinearProgram, weights: &[f64]) -> bool {
        self.values.fill(0.0);
        for (k, variable) in program.variables.iter().enumerate() {
            let product = |(_, a): &(u32, f64), (_, b): &(u32, f64)| weights[k] * (a * b);
            let structure = &self.structure;
            structure.add(k, &variable.column, product, &mut self.values);
        }
        // Rounding makes the smallest pivots negative near the end; the least shift of the diagonal prevents that.
        let shift = self.structure.max_diagonal(&self.values) * f64::EPSILON * f64::EPSILON;
        let symbolic = &self.structure.symbolic;
        symbolic.factorise(&self.values, shift, &mut self.factor, &|| false)
    }

    fn solve(&mut self, right_side: &mut [f64]) {
        self.structure.symbolic.solve(&mut self.factor, right_side);
    }
}
