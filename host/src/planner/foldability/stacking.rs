//! Sees at the goal itself that no order of folds leads there.

use crate::collision::faces_without_order;
use crate::planner::following::reduction::CLOSED;
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::Note;

/// Returns a note on faces that cannot be stacked at the goal, if every crease has a goal angle, and the sheet lies flat
/// and closes there; none if all can be, or if it is not known.
pub(crate) fn note_no_layer_order(problem: &PlanningProblem<'_>) -> Option<Note> {
    let asks = problem.options.collision;
    let angles = asks.then(|| problem.closed_goal(problem.pattern, CLOSED))??;
    let faces = faces_without_order(problem.pattern, &angles, problem.contact);
    (!faces.is_empty()).then_some(Note::NoLayerOrder(faces))
}
