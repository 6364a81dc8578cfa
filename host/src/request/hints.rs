//! Hints on common mistakes: angles in radians, edges that are no hinges, names that are misspelt.

use core::f64::consts::PI;

use crate::pattern::{CreasePattern, EdgeId};
use crate::planner::CLOSED;
use crate::symmetry::closure_of;

/// Largest distance from π at which the largest goal angle, read as degrees, seems to be half a turn in radians.
const SAME_ANGLE: f64 = 1e-3;
/// Largest closure residual of a goal that was given in rounded radians.
const NEARLY_CLOSED: f64 = 1e-3;

/// Returns a hint if the goal angles, which are taken as degrees and do not close, seem to be radians. `closure` is the
/// residual with which the goal closes, if it is known.
#[must_use]
pub fn radians_hint(pattern: &CreasePattern, closure: Option<f64>) -> Option<String> {
    let goals = pattern
        .creases()
        .iter()
        .map(|&edge| pattern.edge(edge).goal);
    let meant: Vec<Option<f64>> = goals.map(|goal| goal.map(f64::to_degrees)).collect();
    let largest = meant
        .iter()
        .flatten()
        .fold(0.0, |most: f64, goal| most.max(goal.abs()));
    let closed = closure.is_none_or(|closure| closure <= CLOSED);
    if closed || largest <= 0.0 || largest > PI + SAME_ANGLE {
        return None;
    }
    let closes = closure_of(pattern, &meant).is_some_and(|closure| closure <= NEARLY_CLOSED);
    (closes || (largest - PI).abs() <= SAME_ANGLE).then(|| {
        format!(
            "no goal angle is beyond {largest:.4} degrees, and they do not close: if they are radians, convert them, \
             as edges_foldAngle is in degrees"
        )
    })
}

/// Names the hinge nearest to an edge that is no hinge, in words. If the pattern has no such edge, names its first
/// hinge.
pub(super) fn nearest_hinge(pattern: &CreasePattern, edge: usize) -> Option<String> {
    let middle = |edge: EdgeId| {
        let [a, b] = pattern
            .edge(edge)
            .ends
            .map(|end| pattern.vertices()[end.index()]);
        (a + b) / 2.0
    };
    let here = (edge < pattern.edges().len()).then(|| middle(EdgeId::new(edge)));
    let far = |hinge: &&EdgeId| here.map_or(0.0, |here| (middle(**hinge) - here).norm());
    let hinges = pattern.creases().iter();
    let hinges = hinges.filter(|hinge| pattern.edge(**hinge).letter.sign().abs() > 0.0);
    let nearest = hinges.min_by(|a, b| far(a).total_cmp(&far(b)))?;
    let edge = format!(
        "edge {} ({})",
        nearest.index(),
        pattern.edge(*nearest).letter.code()
    );
    Some(match here {
        Some(_) => format!("the nearest hinge is {edge}"),
        None => format!("{edge} is a hinge"),
    })
}

/// Returns the name that the fewest changes of letters, large or small, make of `wanted` (Levenshtein 1966), the first of
/// several in alphabetical order.
pub(super) fn nearest_name<'a>(
    names: impl Iterator<Item = &'a str>,
    wanted: &str,
) -> Option<&'a str> {
    let letters = |text: &str| -> Vec<char> { text.to_lowercase().chars().collect() };
    let wanted = letters(wanted);
    let distance = |name: &&str| {
        let mut row: Vec<usize> = (0..=wanted.len()).collect();
        for letter in letters(name) {
            let mut diagonal = row[0];
            row[0] += 1;
            for (at, other) in wanted.iter().enumerate() {
                let replaced = diagonal + usize::from(letter != *other);
                diagonal = row[at + 1];
                row[at + 1] = replaced.min(diagonal + 1).min(row[at] + 1);
            }
        }
        row[wanted.len()]
    };
    names.min_by_key(distance)
}
