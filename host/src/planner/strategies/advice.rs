//! Notes on what may help after a no, as far as the answer tells: contact, another order of the folds, less of the way.

use core::f64::consts::PI;

use super::lines::turning_lines;
use super::phase_samples::turns_freely;
use super::split_phases::splits_phases;
use super::stops::between;
use crate::collision::{CONTACT_EDGES, CROSSING_DEPTH_EDGES, CollisionScene, Crossing};
use crate::folding::FoldingMap;
use crate::motion::Motion;
use crate::pattern::{CreasePattern, EdgeId};
use crate::planner::GoalKind;
use crate::planner::foldability::certificate::{Locks, cannot_leave};
use crate::planner::plan::{Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{FirstSteps, Note, ProofOrder, Reason};
use crate::planner::vectors::largest;

/// Part of the way from which on a path nearly reaches its goal.
const NEARLY_REACHED: f64 = 0.999;
/// Ratio of the depth to which faces may be in each other on the way to a goal to that at the goal.
const OVERLAP_MARGIN: f64 = 1.5;
/// Largest closure residual of a goal of which it is told that faces cross there.
const NEARLY_CLOSED: f64 = 1e-3;
/// Number of parts of a half turn in which a part of the way is told.
const FRACTIONS: f64 = 1000.0;
/// Part of the largest angle by which every lettered crease has to be turned for a part of the way to be a plan.
const TURNED_RATIO: f64 = 0.1;
/// Smallest fold angle of a hinge that counts as turned, radians.
const TURNED_RAD: f64 = PI / 180.0;

/// Adds to a reason what is known of the first steps from flat, if the path does not leave flat. Cost: linear programs, less
/// than a second.
pub(crate) fn explain_first_steps(asked: &PlanningProblem<'_>, reason: &mut Reason) {
    match reason {
        Reason::GoalCrosses { path, .. } => explain_first_steps(asked, path),
        Reason::PathStops {
            at_flat: Some(steps),
            ..
        } => *steps = first_steps(asked),
        _ => {}
    }
}

/// Returns what is known of the first steps from flat along the letters, or else towards the goal.
fn first_steps(asked: &PlanningProblem<'_>) -> FirstSteps {
    let (pattern, goal) = (asked.pattern, asked.goal);
    let ways = goal.signs.iter().zip(&goal.fold_angles);
    let ways: Vec<f64> = ways
        .map(|(sign, angle)| match angle {
            Some(angle) if sign.abs() <= 0.0 => angle.signum() * f64::from(angle.abs() > 0.0),
            _ => *sign,
        })
        .collect();
    let moves = ways.iter().zip(&goal.fold_angles);
    let moves: Vec<bool> = moves
        .map(|(way, angle)| way.abs() > 0.0 && angle.is_none_or(|angle| angle.abs() > 0.0))
        .collect();
    if let Some(proofs) = cannot_leave(pattern, &ways, &moves) {
        let is_second = proofs.iter().any(|lock| lock.order == ProofOrder::Second);
        return FirstSteps::NoneProved(if is_second {
            ProofOrder::Second
        } else {
            ProofOrder::First
        });
    }
    let edges = |is_one: &dyn Fn(usize) -> bool| -> Vec<EdgeId> {
        let creases = (0..moves.len()).filter(|&crease| moves[crease] && is_one(crease));
        creases.map(|crease| pattern.creases()[crease]).collect()
    };
    let locks = Locks::find(pattern, &ways);
    let locked = locks.map_or_else(Vec::new, |locks| edges(&|crease| locks.locked[crease]));
    let turns = turning_lines(pattern);
    let free = edges(&|crease| turns[crease]);
    if locked.is_empty() && free.is_empty() {
        return FirstSteps::NotKnown;
    }
    FirstSteps::Some { locked, free }
}

/// Returns notes on what may help to get a plan.
pub(crate) fn what_may_help(asked: &PlanningProblem<'_>, plan: &Plan) -> Vec<Note> {
    let Some(motion) = &plan.motion else {
        return Vec::new();
    };
    let crossing = match plan.outcome {
        Outcome::Crossing(crossing) => note_crossing(asked, plan, motion, crossing),
        _ => None,
    };
    let is_short = matches!(
        plan.outcome,
        Outcome::Crossing(_) | Outcome::Partial | Outcome::NearGoal | Outcome::NotRigidlyFoldable
    );
    let part = is_short.then(|| note_part_way(asked, motion)).flatten();
    crossing.into_iter().chain(part).collect()
}

/// Returns a note on faces that cross: at the goal, or because hinges turn together.
fn note_crossing(
    asked: &PlanningProblem<'_>,
    plan: &Plan,
    motion: &Motion,
    crossing: Crossing,
) -> Option<Note> {
    // The path may be that of the straightened sheet.
    let pattern = &motion.pattern;
    if let Some(Crossing { faces, depth }) = goal_crossing(asked, pattern) {
        let depth = depth / pattern.median_edge();
        let most = CROSSING_DEPTH_EDGES + OVERLAP_MARGIN * depth;
        let can_be_contact = CONTACT_EDGES.contains(most);
        if plan.reached >= NEARLY_REACHED && can_be_contact {
            return Some(Note::OverlapsAtGoal(most));
        }
        if !can_be_contact {
            return Some(Note::GoalItselfCrosses { faces, depth });
        }
    }
    if plan.has_no_layer_order() || !splits_phases(asked, plan) {
        return None;
    }
    let goal = &asked.goal.fold_angles;
    let between = between(pattern, crossing.faces);
    let turned = between.ones().filter(|&crease| {
        let angle = goal.get(crease).copied().flatten();
        angle.is_none_or(|angle| angle.abs() > TURNED_RAD)
    });
    let edges: Vec<EdgeId> = turned.map(|crease| pattern.creases()[crease]).collect();
    (edges.len() > 1).then_some(Note::TurnTogether {
        faces: crossing.faces,
        edges,
    })
}

/// Returns the deepest crossing of the goal, if every crease has a goal angle and the goal closes.
pub(super) fn goal_crossing(
    asked: &PlanningProblem<'_>,
    pattern: &CreasePattern,
) -> Option<Crossing> {
    let angles = asked.closed_goal(pattern, NEARLY_CLOSED)?;
    let map = FoldingMap::new(pattern, pattern.tree(), &angles);
    let contact = asked.plates.map_or(0.0, |_| asked.contact);
    CollisionScene::of_plates(pattern, asked.plates).deepest_crossing(&map, contact)
}

/// Returns a note of how far a path leads along the letters, if a smaller fraction of a half turn would be a plan; of a net
/// without vertices inside, as cartons are, a note that no angles are named.
fn note_part_way(asked: &PlanningProblem<'_>, motion: &Motion) -> Option<Note> {
    let goal = asked.goal;
    if goal.kind != GoalKind::Letters || !goal.via.is_empty() {
        return None;
    }
    if !goal.is_direction() && turns_freely(asked.pattern) {
        return Some(Note::NoAngles);
    }
    let angles = end_angles(asked.pattern, motion);
    let lettered = goal.signs.iter().zip(&angles);
    let lettered = lettered.filter(|(sign, _)| sign.abs() > 0.0);
    let turned: Vec<f64> = lettered.map(|(sign, angle)| sign * angle).collect();
    let most = turned.iter().copied().fold(0.0, f64::max);
    if goal.is_direction() && most >= largest(&goal.fold_angles) - asked.options.goal_tolerance {
        return None;
    }
    let fraction = (most / PI * FRACTIONS).floor() / FRACTIONS;
    let least = TURNED_RATIO * most;
    let turn_all = most > TURNED_RAD && turned.iter().all(|angle| *angle >= least);
    (turn_all && fraction > 0.0 && fraction < 1.0).then_some(Note::PartWay(fraction))
}

/// Returns a note of the hinges that turned as it suited, while others were driven.
pub(crate) fn note_free_turns(asked: &PlanningProblem<'_>, plan: &Plan) -> Option<Note> {
    let (goal, motion) = (asked.goal, plan.motion.as_ref()?);
    if goal.kind != GoalKind::Driven || plan.outcome != Outcome::Planned {
        return None;
    }
    let angles = end_angles(asked.pattern, motion);
    let free =
        |crease: usize| goal.fold_angles[crease].is_none() && goal.signs[crease].abs() <= 0.0;
    let turned = |sign: f64| -> Vec<EdgeId> {
        let creases = (0..goal.fold_angles.len()).filter(|&crease| free(crease));
        let turned = creases.filter(|&crease| sign * angles[crease] > TURNED_RAD);
        turned
            .map(|crease| asked.pattern.creases()[crease])
            .collect()
    };
    let [mountains, valleys] = [-1.0, 1.0].map(turned);
    let is_any = !(mountains.is_empty() && valleys.is_empty());
    is_any.then_some(Note::TurnedFreely { mountains, valleys })
}

/// Returns the fold angles (radians) of the creases of a pattern at the end of a motion, whose own pattern may have panels
/// that bend in addition.
fn end_angles(pattern: &CreasePattern, motion: &Motion) -> Vec<f64> {
    let angles = motion.crease_angles(motion.knots.len() - 1);
    let crease = |edge: &EdgeId| motion.pattern.edge(*edge).crease;
    let of = |edge| crease(edge).map_or(0.0, |crease| angles[crease.index()]);
    pattern.creases().iter().map(of).collect()
}
