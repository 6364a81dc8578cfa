//! Finds a closed configuration near the measured hinge angles.
//!
//! After a reset without memory, or after hinges were moved by hand, the measured angles say where the sheet is, but
//! they close nowhere. The mean angle of each group, corrected by [Levenberg-Marquardt](crate::levenberg_marquardt), is
//! a configuration where a path may begin.

use crate::least_squares::{ClosureProblem, Limits, NormalEquations, Options, Report};
use crate::levenberg_marquardt;
use crate::objective::larger;
use crate::{Membership, Scalar};

/// Largest number of iterations of the solver. From a tenth of a radian off, four suffice if the sheet is not flat.
const MAX_ITERATIONS: u32 = 12;

/// Result of a projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection<T> {
    /// Report of the solver. The configuration closes only if the outcome is `Converged`.
    pub report: Report<T>,
    /// Largest change of a group angle, radians.
    pub moved: T,
}

/// Writes the mean of each group's measured hinge angles (radians), signs included, to `angles`.
///
/// Returns the largest distance of a hinge from the mean of its group, radians. `counts` is scratch of the length of
/// `angles`. Returns `None` if the length of `counts` differs, if a group has no hinge, or if a hinge has no group. A
/// measurement that is NaN makes the mean of its group and the distance NaN.
pub fn means<T: Scalar>(
    hinges: impl Iterator<Item = (Membership, T)> + Clone,
    angles: &mut [T],
    counts: &mut [T],
) -> Option<T> {
    if counts.len() != angles.len() {
        return None;
    }
    angles.fill(T::zero());
    counts.fill(T::zero());
    for (membership, measured) in hinges.clone() {
        let group = membership.group.index();
        *angles.get_mut(group)? += membership.apply(measured);
        *counts.get_mut(group)? += T::one();
    }
    for (angle, &count) in angles.iter_mut().zip(&*counts) {
        if count < T::one() {
            return None;
        }
        *angle /= count;
    }
    hinges
        .into_iter()
        .try_fold(T::zero(), |worst: T, (membership, measured)| {
            let mean = membership.apply(*angles.get(membership.group.index())?);
            Some(larger(worst, (measured - mean).abs()))
        })
}

/// Moves the group angles `x` (radians) to a configuration near them in which every star closes.
///
/// To first order, the result is the nearest closed configuration. `workspace` needs 3n numbers. Cost: at most twelve
/// linearisations and factorisations.
pub fn project<T: Scalar, E: NormalEquations<T>>(
    problem: &mut ClosureProblem<'_, T>,
    equations: &mut E,
    limits: Limits<'_, T>,
    tolerance: T,
    x: &mut [T],
    workspace: &mut [T],
) -> Projection<T> {
    let options = Options {
        tolerance,
        acceptable: tolerance,
        max_iterations: MAX_ITERATIONS,
        ..Options::default()
    };
    let Some((before, workspace)) = workspace.split_at_mut_checked(x.len()) else {
        return Projection {
            report: Report::capacity(),
            moved: T::zero(),
        };
    };
    before.copy_from_slice(x);
    let report = levenberg_marquardt::solve(problem, equations, limits, &options, x, workspace);
    let ways = x.iter().zip(&*before).map(|(&to, &from)| (to - from).abs());
    Projection {
        report,
        moved: ways.fold(T::zero(), T::max),
    }
}
