//! Sees at the goal itself that no order of folds leads there.

use crate::collision::faces_without_order;
use crate::pattern::FaceId;
use crate::planner::following::reduction::CLOSED;
use crate::planner::problem::PlanningProblem;
use crate::symmetry::closure_of;

/// Returns faces that cannot be stacked at the goal, if every crease has a goal angle, and the sheet lies flat and closes
/// there; none if they can be, or if it is not known.
pub(crate) fn unstackable(problem: &PlanningProblem<'_>) -> Vec<FaceId> {
    let (pattern, goal) = (problem.pattern, &problem.goal.fold_angles);
    let angles: Option<Vec<f64>> = goal.iter().copied().collect();
    let angles = angles.filter(|angles| angles.len() == pattern.creases().len());
    let closes = || closure_of(pattern, goal).is_some_and(|residual| residual <= CLOSED);
    match angles {
        Some(angles) if problem.options.collision && closes() => {
            faces_without_order(pattern, &angles, problem.contact)
        }
        _ => Vec::new(),
    }
}
