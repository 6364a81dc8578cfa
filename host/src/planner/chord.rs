//! Newton's method with one factor: the chord method, for configurations that nearly close.
//!
//! Factorising is most of the work on large sheets. So JᵀJ is factorised once, at the configuration
//! predicted, and the steps -(J₀ᵀJ₀ + λI)⁻¹J₀ᵀr(x) keep that J₀ while only the residual is new. Both
//! factors of J₀ᵀr have to be old: with Jᵀ of now the step would have a part along the motion of J₀,
//! which (J₀ᵀJ₀ + λI)⁻¹ blows up by 1/λ. Chapter 5.4 of Kelley, *Iterative Methods for Linear and
//! Nonlinear Equations*, SIAM 1995, has the method for regular Jacobians.

use core::f64::consts::PI;

use foldpath_core::least_squares::{Accumulate, ClosureProblem, NormalEquations};
use foldpath_core::{Scalar, Spoke};
use nalgebra::Vector3;

use super::sparse::SparseNormalEquations;

/// Largest closure residual from which to start: further away the damping of Levenberg-Marquardt is
/// what keeps a step near.
const NEAR: f64 = 1e-2;
/// Part of the residual that a step may leave: more, and the factor is not that of this place any
/// more. Miura sheets are seen to leave 1e-5 at first, then a hundredth.
const CONTRACTION: f64 = 0.1;

/// What was done.
pub(super) struct Chord {
    /// Whether every star closes.
    pub(super) closed: bool,
    /// Steps, each with one evaluation; one more evaluation was at the start.
    pub(super) steps: u32,
}

/// Moves `x` (radians) to the closed configuration near it, or leaves it as it is if the residual
/// does not shrink fast. `workspace` needs 2n numbers.
pub(super) fn close(
    problem: &mut ClosureProblem<'_, f64>,
    equations: &mut SparseNormalEquations,
    x: &mut [f64],
    workspace: &mut [f64],
) -> Option<Chord> {
    let (step, trial) = workspace.get_mut(..2 * x.len())?.split_at_mut(x.len());
    let mut chord = Chord {
        closed: false,
        steps: 0,
    };
    let mut residual = problem.linearise(x, equations)?.max;
    // As in the projection on motions: rounding, which is ε/λ, stays as small as λ itself.
    let damping = equations.max_diagonal() * f64::EPSILON.sqrt();
    if residual > NEAR || residual > f64::CLOSURE_TOLERANCE && !equations.factorise(damping) {
        return Some(chord);
    }
    trial.copy_from_slice(x);
    while residual > f64::CLOSURE_TOLERANCE {
        advance(equations, step, trial);
        let next = problem.linearise(trial, &mut SameRows(equations))?.max;
        chord.steps += 1;
        let shrinks = next <= f64::CLOSURE_TOLERANCE || next <= CONTRACTION * residual;
        if !shrinks || trial.iter().any(|angle| angle.abs() > PI) {
            return Some(chord);
        }
        residual = next;
    }
    // Small residuals add up over a large sheet. One more step costs no evaluation.
    if chord.steps > 0 {
        advance(equations, step, trial);
    }
    x.copy_from_slice(trial);
    chord.closed = true;
    Some(chord)
}

/// Moves `trial` by the step for the gradient last made.
fn advance(equations: &mut SparseNormalEquations, step: &mut [f64], trial: &mut [f64]) {
    step.copy_from_slice(equations.gradient());
    equations.solve(step);
    for (trial, step) in trial.iter_mut().zip(step) {
        *trial -= *step;
    }
}

/// Makes the gradient J₀ᵀr of new residuals and the rows last accumulated in the equations.
struct SameRows<'a>(&'a mut SparseNormalEquations);

impl Accumulate<f64> for SameRows<'_> {
    fn clear(&mut self) {
        self.0.clear_gradient();
    }

    fn add(
        &mut self,
        star: usize,
        spokes: &[Spoke<f64>],
        _columns: &[Vector3<f64>],
        residual: &Vector3<f64>,
    ) {
        self.0.add_to_gradient(star, spokes, residual);
    }
}
