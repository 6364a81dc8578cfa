//! Lines that turn alone: creases in one line with one letter, from border to border. They close whatever their angle is,
//! while all other creases stay flat.

use super::rows::Context;
use crate::pattern::{CreaseId, CreasePattern, EdgeId, VertexId};
use crate::planner::plan::{Attempt, Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::{Goal, HingeLimit, PlanOptions, Symmetry};

/// Largest sine of the angle between two creases that are in line.
const IN_LINE: f64 = 1e-6;

/// Plans the motion in which only lines that turn alone do, if there are such lines.
pub(crate) fn turn_lines_alone(context: &Context<'_>, attempts: &mut Vec<Attempt>) -> Option<Plan> {
    let asked = context.problem;
    let (goal, limits) = goal_of_lines(asked.pattern, asked.goal)?;
    let mut options = PlanOptions {
        // A group may have a line and other creases.
        symmetry: Symmetry::Off,
        ..asked.options.clone()
    };
    options.limits.extend(limits);
    let problem = PlanningProblem {
        goal: &goal,
        options: &options,
        ..*asked
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

/// Returns for each crease `true` if it is on a line that turns alone.
fn turning_lines(pattern: &CreasePattern) -> Vec<bool> {
    let mut turns = vec![true; pattern.creases().len()];
    for &edge in pattern.creases() {
        let mut ends = pattern.edge(edge).ends.into_iter();
        let whole = ends.all(|end| reaches_border(pattern, edge, end));
        if !whole && let Some(crease) = pattern.edge(edge).crease {
            turns[crease.index()] = false;
        }
    }
    turns
}

/// Follows the line of a crease through a vertex. Returns `false` if the line ends inside the sheet or its letter changes.
fn reaches_border(pattern: &CreasePattern, mut edge: EdgeId, mut at: VertexId) -> bool {
    let letter = pattern.edge(edge).letter;
    // No line has more creases than the sheet.
    for _ in 0..pattern.creases().len() {
        if !pattern.is_real(at) {
            return true;
        }
        let way = -pattern.direction(edge, at);
        let mut ahead = pattern.stars()[at.index()].iter().copied();
        let next = ahead.find(|&next| {
            let along = pattern.direction(next, at);
            let in_line = along.perp(&way).abs() < IN_LINE && along.dot(&way) > 0.0;
            in_line && pattern.edge(next).crease.is_some() && pattern.edge(next).letter == letter
        });
        let Some(next) = next else {
            return false;
        };
        edge = next;
        at = pattern.edge(edge).other_end(at);
    }
    false
}
