//! Decides whether a path ends at its goal, and which creases it leaves flat.

use crate::planner::lifting::lifted::Lifted;
use crate::planner::plan::Outcome;
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::Reason;
use crate::planner::vectors::fraction;
use crate::planner::{Goal, GoalKind};
use crate::symmetry::CreaseGroups;

/// Fraction of its goal by which a crease has to be turned to count for a path that ends near the goal.
const NEAR_RATIO: f64 = 0.1;

/// Returns the number of creases that a motion of these crease groups leaves flat. A motion that is planned, but does not
/// end at the goal, is [near it](Outcome::NearGoal).
pub(super) fn judge_arrival(
    problem: &PlanningProblem<'_>,
    groups: &CreaseGroups,
    lifted: &mut Lifted,
) -> usize {
    let goal = problem.goal;
    let end = lifted.knots.knots.last();
    let angles = end.map(|end| groups.expand(&end.angles));
    // Without a path, the sheet is flat.
    let angles = angles.unwrap_or_else(|| vec![0.0; goal.fold_angles.len()]);
    let flat: Vec<usize> = goal.flat(&goal.signs, &angles).collect();
    let count = flat.len();
    if lifted.outcome != Outcome::Planned {
        return count;
    }
    let tolerance = problem.options.goal_tolerance;
    let farthest = if goal.is_direction() {
        lacking(goal, &angles)
    } else {
        farthest(goal, &angles)
    };
    let farthest = farthest.filter(|(_, short)| *short > tolerance);
    let follows_letters = !goal.is_direction() || flat.is_empty();
    if farthest.is_none() && follows_letters {
        return count;
    }
    let edge = |crease: usize| problem.pattern.creases()[crease];
    lifted.outcome = if is_near(goal, &angles) {
        Outcome::NearGoal
    } else {
        Outcome::Partial
    };
    lifted.reached = if goal.is_direction() {
        fraction(&goal.fold_angles, &angles)
    } else {
        fraction(&goal.fold_angles, &mirrored(goal, angles))
    };
    lifted.reason = Some(Reason::NearGoal {
        goal: goal.source.clone(),
        farthest: farthest.map(|(crease, short)| (edge(crease), short)),
        flat: flat.into_iter().map(edge).collect(),
    });
    count
}

/// Returns fold angles in which creases that have turned too far lack as much of their goal instead.
fn mirrored(goal: &Goal, angles: Vec<f64>) -> Vec<f64> {
    let asked = goal.fold_angles.iter().zip(angles);
    let mirrored = asked.map(|(asked, angle)| match *asked {
        Some(asked) if angle * asked.signum() > asked.abs() => 2.0 * asked - angle,
        _ => angle,
    });
    mirrored.collect()
}

/// Returns `true` if at least half of the lettered creases are turned by a tenth of their goal. A crease that has no goal but
/// its letter, and is held flat, is not turned.
fn is_near(goal: &Goal, angles: &[f64]) -> bool {
    let asked = goal.signs.iter().zip(&goal.fold_angles).zip(angles);
    let asked = asked.filter_map(|((sign, asked), angle)| {
        let asked = asked.filter(|_| sign.abs() > 0.0)?;
        let is_held = asked.abs() <= 0.0 && goal.kind == GoalKind::Letters;
        Some(!is_held && angle * asked.signum() >= NEAR_RATIO * asked.abs())
    });
    let turned: Vec<bool> = asked.collect();
    let count = turned.iter().filter(|turned| **turned).count();
    2 * count >= turned.len()
}

/// Returns the crease whose angle is farthest from the one asked for, and the distance, radians.
fn farthest(goal: &Goal, angles: &[f64]) -> Option<(usize, f64)> {
    let asked = goal.fold_angles.iter().zip(angles).enumerate();
    let errors =
        asked.filter_map(|(crease, (asked, angle))| Some((crease, ((*asked)? - angle).abs())));
    errors.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Returns the lettered crease that has turned most its way, and what it lacks of the angle asked for, radians.
fn lacking(goal: &Goal, angles: &[f64]) -> Option<(usize, f64)> {
    let asked = goal.fold_angles.iter().zip(angles).enumerate();
    let lacks = asked.filter_map(|(crease, (asked, angle))| {
        let asked = (*asked)?;
        Some((crease, asked.abs() - angle * asked.signum()))
    });
    lacks.min_by(|a, b| a.1.total_cmp(&b.1))
}
