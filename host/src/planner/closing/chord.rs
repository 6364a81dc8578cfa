//! The chord method (simplified Newton method): closes configurations that nearly close with a single factorisation.
//!
//! JᵀJ is factorised once, at the predicted configuration, because factorising is most of the work on large sheets. Each
//! step then evaluates only the residual, as Levenberg-Marquardt does with
//! [`FactorReuse::Chord`](foldpath_core::least_squares::FactorReuse::Chord). It differs from that in two ways. Its damping
//! is that of the projection on motions, so that the projection can use the same factor. And its steps are neither
//! shortened nor moved to the limits: a step that would need either ends the attempt, and Levenberg-Marquardt, whose
//! loop would have given another configuration, takes over from the start.

use foldpath_core::least_squares::{ClosureProblem, Limits, NormalEquations};
use foldpath_core::levenberg_marquardt::projection_damping;

use super::sparse::SparseNormalEquations;

/// Largest closure residual (about radians) from which the chord method starts: from farther away only the damping of
/// Levenberg-Marquardt keeps a step short.
const MAX_START_RESIDUAL: f64 = 1e-2;
/// Largest fraction of the residual that a step may leave. If more is left, the factor does not fit this configuration
/// any more. On Miura sheets the first step leaves about 1e-5, later steps a hundredth.
const MAX_CONTRACTION_RATIO: f64 = 0.1;

/// Outcome of the chord method.
pub(crate) struct Chord {
    /// `true` if every star closes.
    pub(crate) closed: bool,
    /// Damping of the factor.
    pub(crate) damping: f64,
    /// Number of steps, each with one evaluation; one more evaluation was made at the start.
    pub(crate) steps: u32,
}

/// Moves `x` (radians) to the closed configuration near it; leaves `x` as it is if the residual does not shrink fast or
/// a limit is passed. `workspace` needs 2n numbers.
pub(crate) fn close(
    problem: &mut ClosureProblem<'_, f64>,
    equations: &mut SparseNormalEquations<'_>,
    limits: Limits<'_, f64>,
    tolerance: f64,
    x: &mut [f64],
    workspace: &mut [f64],
) -> Option<Chord> {
    let (step, trial) = workspace.get_mut(..2 * x.len())?.split_at_mut(x.len());
    let mut chord = Chord {
        closed: false,
        damping: 0.0,
        steps: 0,
    };
    let mut residual = problem.linearise(x, equations)?.max();
    if residual > MAX_START_RESIDUAL {
        return Some(chord);
    }
    if residual > tolerance {
        // The damping of the projection on motions: rounding, which is ε/λ, stays as small as λ itself.
        chord.damping = projection_damping(equations);
        if !equations.factorise(chord.damping) {
            return Some(chord);
        }
    }
    trial.copy_from_slice(x);
    while residual > tolerance {
        advance(equations, step, trial);
        let next = problem.update_residuals(trial, equations)?.max();
        chord.steps += 1;
        let shrinks = next <= tolerance || next <= MAX_CONTRACTION_RATIO * residual;
        if !shrinks || !limits.contain(trial) {
            return Some(chord);
        }
        residual = next;
    }
    // Small residuals add up over a large sheet, and one more step costs no evaluation.
    if chord.steps > 0 {
        advance(equations, step, trial);
    }
    if limits.contain(trial) {
        x.copy_from_slice(trial);
        chord.closed = true;
    }
    Some(chord)
}

/// Moves `trial` by the step that belongs to the last gradient.
fn advance(equations: &mut SparseNormalEquations<'_>, step: &mut [f64], trial: &mut [f64]) {
    equations.step(step);
    for (trial, step) in trial.iter_mut().zip(step) {
        *trial += *step;
    }
}

#[cfg(test)]
mod tests {
    use foldpath_core::{HalfAngle, Scalar};
    use nalgebra::Vector3;

    use super::*;
    use crate::generate::Miura;
    use crate::pattern::CreasePattern;
    use crate::planner::Goal;
    use crate::symmetry::{CreaseGroups, ReducedStars};

    /// Runs the chord method this far (radians) from a closed Miura sheet. Returns the outcome, the angles before and
    /// after, and the residual after.
    fn from(distance: f64) -> (Chord, Vec<f64>, Vec<f64>, f64) {
        let miura = Miura {
            rows: 6,
            columns: 7,
            sector_angle: 1.0,
            fold: 0.5,
        };
        let pattern = CreasePattern::new(miura.drawing().unwrap()).unwrap();
        let goal = Goal::of_pattern(&pattern).unwrap();
        let groups = CreaseGroups::trivial(&pattern);
        let stars = ReducedStars::all(&pattern, &groups);
        let before: Vec<f64> = groups
            .reduce(&goal.fold_angles)
            .iter()
            .map(|angle| angle.unwrap())
            .zip((0..7_u8).cycle())
            .map(|(angle, k)| angle + distance * (f64::from(k) / 3.0 - 1.0))
            .collect();
        let mut equations = SparseNormalEquations::new(stars.view(), stars.loops()).unwrap();
        let mut half_angles = vec![HalfAngle::default(); before.len()];
        let mut columns = vec![Vector3::zeros(); stars.view().max_degree()];
        let mut problem =
            ClosureProblem::new(stars.view(), &mut half_angles, &mut columns).unwrap();
        let mut after = before.clone();
        let mut workspace = vec![0.0; 2 * before.len()];
        let chord = close(
            &mut problem,
            &mut equations,
            Limits::HalfTurn,
            f64::CLOSURE_TOLERANCE,
            &mut after,
            &mut workspace,
        )
        .unwrap();
        let residual = stars.largest_residual(&after);
        (chord, before, after, residual)
    }

    #[test]
    fn what_nearly_closes_is_closed_nearby() {
        let (chord, before, after, residual) = from(1e-3);
        assert!(chord.closed && chord.steps > 1);
        assert!(residual <= 1e-15, "{residual:e}");
        let moved = before.iter().zip(&after).map(|(b, a)| (b - a).abs());
        assert!(moved.fold(0.0, f64::max) <= 0.01);
    }

    #[test]
    fn what_is_far_from_closing_is_left_as_it_is() {
        let (chord, before, after, _) = from(0.3);
        assert!(!chord.closed && chord.steps == 0);
        assert!(
            before
                .iter()
                .zip(&after)
                .all(|(b, a)| b.to_bits() == a.to_bits())
        );
    }
}
