//! Conjugate gradients: an approximate solution of a damped step without a factorisation.
//!
//! Far from closing, a step of Levenberg-Marquardt leaves a residual of about the square of the step, however exactly
//! the step is solved for. The system therefore need not be solved any better, and on a large sheet a few products with
//! the Jacobian cost less than its factor. Implements the method of [HestenesStiefel1952](crate#references) on
//! (JᵀJ + λI) d = -Jᵀr from d = 0, so that d has no part along a motion. The iteration ends by the test of
//! [NashSofer1990](crate#references): when the last step has added less to the reduction of the linear model than a
//! small fraction of an average step.

use crate::Scalar;
use crate::dense::dot;

/// Fraction of an average step's reduction of the linear model below which another step is not worth taking. Sheets of
/// 200 to 1,700 unknowns are closed soonest with 0.02 to 0.04.
const MIN_REDUCTION_RATIO: f64 = 0.03;
/// Largest number of steps. On a large sheet this many cost about as much as a factorisation.
const MAX_STEPS: u32 = 25;

/// Sets `step` to an approximate solution d of (A + λI) d = -g, with λ the `damping` and g the `gradient`.
///
/// `apply` sets its second argument to A times the first, and returns the dot product of the two; A is positive
/// semidefinite. `step` and the three vectors of scratch (residual, search direction, its image) are as long as the
/// gradient.
pub fn solve<T: Scalar>(
    mut apply: impl FnMut(&[T], &mut [T]) -> T,
    damping: T,
    gradient: &[T],
    step: &mut [T],
    [residual, direction, image]: [&mut [T]; 3],
) {
    step.fill(T::zero());
    for ((residual, direction), &slope) in residual.iter_mut().zip(&mut *direction).zip(gradient) {
        (*residual, *direction) = (-slope, -slope);
    }
    let (mut square, mut reduction, mut steps) = (dot(residual, residual), T::zero(), T::zero());
    for _ in 0..MAX_STEPS {
        let curvature = apply(direction, image) + damping * dot(direction, direction);
        let length = square / curvature;
        if !length.is_finite() {
            return;
        }
        for (step, &direction) in step.iter_mut().zip(&*direction) {
            *step += length * direction;
        }
        let added = length * square;
        reduction += added;
        steps += T::one();
        if steps * added <= T::lit(MIN_REDUCTION_RATIO) * reduction {
            return;
        }
        for ((residual, &image), &direction) in residual.iter_mut().zip(&*image).zip(&*direction) {
            *residual -= length * (image + damping * direction);
        }
        let before = core::mem::replace(&mut square, dot(residual, residual));
        for (direction, &residual) in direction.iter_mut().zip(&*residual) {
            *direction = residual + square / before * *direction;
        }
    }
}
