//! The least moves of vertices that fulfil equations, by Gauss-Newton steps.

use nalgebra::Vector2;

use super::condition::{Condition, Equation};
use crate::progress::Watch;

/// Largest number of Gauss-Newton steps. Moves are small against edges, so that three or four are usual.
const MAX_STEPS: usize = 12;

/// Largest number of iterations of conjugate gradients in one step.
const MAX_ITERATIONS: usize = 1 << 11;

/// Largest number of terms of equations that are computed in the iterations for one drawing: some seconds.
const MAX_TERMS: usize = 1 << 30;

/// Ratio of the gradient's norm to that of the first iteration at which a step ends.
const STEP_RATIO: f64 = 1e-13;

/// Number of terms of equations that may still be computed in iterations, none once the caller cancels.
pub(super) struct Effort<'a> {
    left: usize,
    watch: Watch<'a>,
}

impl<'a> Effort<'a> {
    pub(super) fn new(watch: Watch<'a>) -> Self {
        let left = MAX_TERMS;
        Self { left, watch }
    }

    fn take(&mut self, terms: usize) -> Option<()> {
        self.left = self.left.checked_sub(terms)?;
        (!self.watch.is_over()).then_some(())
    }
}

/// Moves the points until the conditions hold within `exact` (a length), or further steps lead no nearer. Equations that
/// hold already do not move anything by themselves. Each step is the least (in the sum of squares) that fulfils the
/// linearised equations. Returns `None` if the effort is used up.
pub(super) fn fulfil(
    conditions: &[Condition],
    mut points: Vec<Vector2<f64>>,
    exact: f64,
    effort: &mut Effort<'_>,
) -> Option<Vec<Vector2<f64>>> {
    let mut best = (f64::INFINITY, points.clone());
    for _ in 0..MAX_STEPS {
        let mut equations: Vec<Equation> = Vec::new();
        equations.extend(conditions.iter().flat_map(|it| it.equations(&points)));
        for equation in equations.iter_mut().filter(|it| it.off.abs() <= exact) {
            equation.off = 0.0;
        }
        let most = equations
            .iter()
            .fold(0.0, |most, it| it.off.abs().max(most));
        if most >= best.0 / 2.0 {
            break;
        }
        best = (most, points.clone());
        if most <= 0.0 {
            break;
        }
        let step = least_step(&equations, points.len(), effort)?;
        points
            .iter_mut()
            .zip(step)
            .for_each(|(point, by)| *point += by);
    }
    Some(best.1)
}

/// Returns the least-squares solution of least norm of the linearised equations, by conjugate gradients on the normal
/// equations (CGLS; Å. Björck, "Numerical Methods for Least Squares Problems", 1996, section 7.4). It starts from zero,
/// so that it stays in the range of the transposed matrix, even if equations repeat each other. Returns `None` if the
/// effort is used up.
fn least_step(
    equations: &[Equation],
    points: usize,
    effort: &mut Effort<'_>,
) -> Option<Vec<Vector2<f64>>> {
    let terms = equations.iter().map(|it| it.gradient.len()).sum();
    let mut step = vec![Vector2::zeros(); points];
    let mut left: Vec<f64> = equations.iter().map(|it| -it.off).collect();
    let back = |left: &[f64]| {
        let mut gradient = vec![Vector2::zeros(); points];
        for (equation, left) in equations.iter().zip(left) {
            for (vertex, term) in &equation.gradient {
                gradient[*vertex] += term * *left;
            }
        }
        gradient
    };
    let mut gradient = back(&left);
    let mut direction = gradient.clone();
    let mut square = squared(&gradient);
    let least = STEP_RATIO * STEP_RATIO * square;
    for _ in 0..MAX_ITERATIONS {
        if square <= least {
            break;
        }
        effort.take(terms)?;
        let image = equations.iter().map(|equation| {
            let terms = equation.gradient.iter();
            terms
                .map(|(vertex, term)| term.dot(&direction[*vertex]))
                .sum()
        });
        let image: Vec<f64> = image.collect();
        let along = square / image.iter().map(|it: &f64| it * it).sum::<f64>();
        step.iter_mut()
            .zip(&direction)
            .for_each(|(step, by)| *step += by * along);
        left.iter_mut()
            .zip(&image)
            .for_each(|(left, by)| *left -= by * along);
        gradient = back(&left);
        let next = squared(&gradient);
        for (direction, gradient) in direction.iter_mut().zip(&gradient) {
            *direction = gradient + *direction * (next / square);
        }
        square = next;
    }
    Some(step)
}

fn squared(vectors: &[Vector2<f64>]) -> f64 {
    vectors.iter().map(Vector2::norm_squared).sum()
}
