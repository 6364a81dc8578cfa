//! The least moves of vertices that fulfil equations, by Levenberg-Marquardt steps.

use foldpath_linear::cholesky::Factor;
use foldpath_linear::gram::GramStructure;
use nalgebra::Vector2;

use super::condition::{Condition, Equation};
use crate::progress::Watch;
use crate::util::csr::Csr;

/// Largest number of steps. Moves are small against edges, so that three or four are usual.
const MAX_STEPS: usize = 24;

/// Least damping of the normal equations, as a fraction of their largest diagonal entry. Equations may repeat each other, so
/// that the matrix is singular without it.
const MIN_DAMPING_RATIO: f64 = 1e-12;

/// Moves the points until the conditions hold within `exact` (a length), or further steps lead no nearer. Equations that
/// hold already do not move anything by themselves. Each step is nearly the least (in the sum of squares) that fulfils
/// the linearised equations. Returns `None` once the watch is over, or if there are too many equations.
///
/// Some equations follow from others where all hold, as those of the vertices round a face. Beside that place their
/// gradients differ, by about the ratio of what is off to the length of an `edge`. Damping by the square of that ratio
/// keeps such differences from counting: without it, vertices would move by many times what is off.
pub(super) fn fulfil(
    conditions: &[Condition],
    mut points: Vec<Vector2<f64>>,
    exact: f64,
    edge: f64,
    watch: Watch<'_>,
) -> Option<Vec<Vector2<f64>>> {
    let equations_at = |points: &[Vector2<f64>]| -> Vec<Equation> {
        let equations = conditions.iter().flat_map(|it| it.equations(points));
        equations.collect()
    };
    let mut steps: Option<LeastSteps> = None;
    let mut best = (f64::INFINITY, points.clone());
    for _ in 0..MAX_STEPS {
        let mut equations = equations_at(&points);
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
        let steps = match &mut steps {
            Some(steps) => steps,
            steps => steps.insert(LeastSteps::new(&equations, points.len())?),
        };
        let damping = (most / edge).powi(2).max(MIN_DAMPING_RATIO);
        let step = steps.step(&equations, damping, watch)?;
        let steps = step.chunks_exact(2).map(|by| Vector2::new(by[0], by[1]));
        points
            .iter_mut()
            .zip(steps)
            .for_each(|(point, by)| *point += by);
    }
    Some(best.1)
}

/// Solves linearised equations with always the same terms, by the normal equations.
struct LeastSteps {
    gram: GramStructure,
    factor: Factor,
    values: Vec<f64>,
}

impl LeastSteps {
    fn new(equations: &[Equation], points: usize) -> Option<Self> {
        let terms = equations.iter().map(|equation| {
            let vertices = equation.gradient.iter().map(|(vertex, _)| vertex);
            let coordinates = vertices.flat_map(|vertex| [2 * vertex, 2 * vertex + 1]);
            coordinates
                .map(|it| u32::try_from(it).ok())
                .collect::<Option<Vec<_>>>()
        });
        let terms: Csr<u32> = terms.collect::<Option<Vec<_>>>()?.into_iter().collect();
        let gram = GramStructure::new(2 * points, &terms)?;
        Some(Self {
            factor: Factor::new(&gram.symbolic),
            values: vec![0.0; gram.entries],
            gram,
        })
    }

    /// Returns the least step, two coordinates for each point. `damping` is a fraction of the largest diagonal entry.
    fn step(&mut self, equations: &[Equation], damping: f64, watch: Watch<'_>) -> Option<Vec<f64>> {
        let Self {
            gram,
            factor,
            values,
        } = self;
        values.fill(0.0);
        let mut step = vec![0.0; gram.diagonal.len()];
        for (number, equation) in equations.iter().enumerate() {
            let terms = equation
                .gradient
                .iter()
                .flat_map(|(_, term)| [term.x, term.y]);
            let terms: Vec<f64> = terms.collect();
            gram.add(number, &terms, |a, b| a * b, values);
            for (vertex, term) in &equation.gradient {
                step[2 * vertex] -= term.x * equation.off;
                step[2 * vertex + 1] -= term.y * equation.off;
            }
        }
        let damping = damping * gram.max_diagonal(values);
        let is_over = || watch.is_over();
        if !gram.symbolic.factorise(values, damping, factor, &is_over) {
            return None;
        }
        gram.symbolic.solve(factor, &mut step);
        Some(step)
    }
}
