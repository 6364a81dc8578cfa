//! Lines that turn alone: creases in one line with one letter, from border to border. They close whatever their angle is,
//! while all other creases stay flat. A crease whose ends are both on the border is such a line.

use super::rows::Context;
use crate::pattern::{CreaseId, CreasePattern, EdgeId, VertexId};
use crate::planner::plan::{Attempt, Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::{Goal, GoalKind, HingeLimit, PlanOptions, Symmetry};

/// Largest sine of the angle between two creases that are in line.
const IN_LINE: f64 = 1e-6;

/// Plans the motion in which only lines that turn alone do, if there are such lines.
pub(crate) fn turn_lines_alone(context: &Context<'_>, attempts: &mut Vec<Attempt>) -> Option<Plan> {
    let asked = context.problem;
    let (goal, limits) = goal_of_lines(asked.pattern, asked.goal)?;
    pass_without_groups(context, &goal, limits, attempts)
}

/// Plans the motion in which the driven creases turn alone, if each is on a line that does: all other creases are at rest,
/// as in a goal that names their angles as 0.
pub(crate) fn turn_driven_alone(
    context: &Context<'_>,
    attempts: &mut Vec<Attempt>,
) -> Option<Plan> {
    let asked = context.problem;
    let goal = goal_of_driven_lines(asked.pattern, asked.goal)?;
    pass_without_groups(context, &goal, Vec::new(), attempts)
}

/// Plans the sheet to another goal, with more limits and without crease groups: a group may have a line and other creases.
fn pass_without_groups(
    context: &Context<'_>,
    goal: &Goal,
    limits: Vec<HingeLimit>,
    attempts: &mut Vec<Attempt>,
) -> Option<Plan> {
    let mut options = PlanOptions {
        symmetry: Symmetry::Off,
        ..context.problem.options.clone()
    };
    options.limits.extend(limits);
    let problem = PlanningProblem {
        goal,
        options: &options,
        ..*context.problem
    };
    context.pass(&problem, attempts)
}

/// Returns `true` if a plan turns the sheet's creases by more than another one, and nothing but its goal is in the way.
pub(crate) fn turns_more(new: &Plan, best: &Plan) -> bool {
    let ends_before = matches!(new.outcome, Outcome::NearGoal | Outcome::Partial);
    ends_before && turned(new) > turned(best)
}

/// Returns the sum of the angles by which creases are turned at the end of a path, radians.
fn turned(plan: &Plan) -> f64 {
    let end = (plan.motion.iter()).flat_map(|motion| motion.crease_angles(motion.knots.len() - 1));
    end.map(f64::abs).sum()
}

/// Returns letters as a goal in which only lines that turn alone do, with limits that hold the other creases flat.
/// Returns `None` if all lettered creases are in such lines, or none.
fn goal_of_lines(pattern: &CreasePattern, letters: &Goal) -> Option<(Goal, Vec<HingeLimit>)> {
    let turn = turning_lines(pattern);
    let lettered = |crease: usize| letters.signs[crease].abs() > 0.0;
    let held: Vec<usize> = (0..turn.len())
        .filter(|&crease| lettered(crease) && !turn[crease])
        .collect();
    let turns = (0..turn.len()).any(|crease| lettered(crease) && turn[crease]);
    if held.is_empty() || !turns {
        return None;
    }
    let mut goal = letters.clone();
    for &crease in &held {
        goal.fold_angles[crease] = Some(0.0);
    }
    let limits = held.into_iter().map(|crease| HingeLimit {
        crease: CreaseId::new(crease),
        lower: 0.0,
        upper: 0.0,
    });
    Some((goal, limits.collect()))
}

/// Returns the goal of driven creases with which each line that has one turns alone. Returns `None` if a driven crease is on
/// no such line, or two creases of a line are driven to different angles.
fn goal_of_driven_lines(pattern: &CreasePattern, driven: &Goal) -> Option<Goal> {
    let mut angles = vec![None; driven.fold_angles.len()];
    for (crease, asked) in driven.fold_angles.iter().enumerate() {
        let Some(asked) = *asked else { continue };
        for edge in line_of(pattern, pattern.creases()[crease])? {
            let angle = &mut angles[pattern.edge(edge).crease?.index()];
            if angle.is_some_and(|other: f64| other.to_bits() != asked.to_bits()) {
                return None;
            }
            *angle = Some(asked);
        }
    }
    Some(Goal {
        fold_angles: angles.into_iter().map(|it| it.or(Some(0.0))).collect(),
        kind: GoalKind::Configuration,
        guide: None,
        ..driven.clone()
    })
}

/// Returns for each crease `true` if it is on a line that turns alone.
pub(super) fn turning_lines(pattern: &CreasePattern) -> Vec<bool> {
    let edges = pattern.creases().iter();
    edges
        .map(|&edge| line_of(pattern, edge).is_some())
        .collect()
}

/// Returns the edges of the line that a crease is on, if that turns alone.
fn line_of(pattern: &CreasePattern, edge: EdgeId) -> Option<Vec<EdgeId>> {
    let mut line = vec![edge];
    for end in pattern.edge(edge).ends {
        line.extend(up_to_border(pattern, edge, end)?);
    }
    Some(line)
}

/// Follows the line of a crease through a vertex, and returns the edges beyond the crease. Returns `None` if the line ends
/// inside the sheet or its letter changes.
fn up_to_border(
    pattern: &CreasePattern,
    mut edge: EdgeId,
    mut at: VertexId,
) -> Option<Vec<EdgeId>> {
    let letter = pattern.edge(edge).letter;
    let mut beyond = Vec::new();
    // No line has more creases than the sheet.
    while pattern.is_real(at) && beyond.len() < pattern.creases().len() {
        let way = -pattern.direction(edge, at);
        let mut ahead = pattern.stars()[at.index()].iter().copied();
        edge = ahead.find(|&next| {
            let along = pattern.direction(next, at);
            let in_line = along.perp(&way).abs() < IN_LINE && along.dot(&way) > 0.0;
            in_line && pattern.edge(next).crease.is_some() && pattern.edge(next).letter == letter
        })?;
        at = pattern.edge(edge).other_end(at);
        beyond.push(edge);
    }
    Some(beyond)
}
