//! Sees at the goal itself that no order of folds leads there.

use crate::collision::faces_without_order;
use crate::planner::following::reduction::CLOSED;
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::Note;
use crate::symmetry::closure_of;

/// Returns a note on faces that cannot be stacked at the goal, if every crease has a goal angle, and the sheet lies flat
/// and closes there; none if all can be, or if it is not known.
pub(crate) fn note_no_layer_order(problem: &PlanningProblem<'_>) -> Option<Note> {
    let (pattern, goal) = (problem.pattern, &problem.goal.fold_angles);
    let angles: Vec<f64> = goal.iter().copied().collect::<Option<_>>()?;
    let is_whole = angles.len() == pattern.creases().len();
    let closes = || closure_of(pattern, goal).is_some_and(|residual| residual <= CLOSED);
    if !problem.options.collision || !is_whole || !closes() {
        return None;
    }
    let faces = faces_without_order(pattern, &angles, problem.contact);
    (!faces.is_empty()).then_some(Note::NoLayerOrder(faces))
}
