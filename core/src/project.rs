//! From where hinges are measured to be, to a configuration near it that closes.
//!
//! After a reset without memory, or after hinges were moved by hand, the measured angles say where the sheet
//! is, but measured they close nowhere. Their means by group, moved on by
//! [Levenberg-Marquardt](crate::levenberg_marquardt), are where a path may begin.

use crate::least_squares::{ClosureProblem, Limits, NormalEquations, Options, Report};
use crate::levenberg_marquardt;
use crate::objective::larger;
use crate::{Membership, Scalar};

/// Steps tried at most: from a tenth of a radian off, four suffice where the sheet is not flat.
const STEPS: u32 = 12;

/// What a projection came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection<T> {
    /// How the solver ended: only if it converged, the configuration closes.
    pub report: Report<T>,
    /// Largest way of an angle, radians.
    pub moved: T,
}

/// Writes the mean of each group's measured hinges (radians), by their signs, and returns the largest distance of a
/// hinge from its mean.
///
/// `counts` is scratch of the length of `angles`. Returns `None` if it has another, or if a group has no hinge or
/// a hinge no group. A measurement that is no number makes the mean of its group none, and the distance.
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
/// To first order that is the nearest one. `workspace` needs 3n numbers. Cost: at most twelve linearisations and
/// factorisations.
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
        max_iterations: STEPS,
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
