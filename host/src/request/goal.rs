//! Goal and limits that a request names, for a pattern.

use std::path::Path;

use super::error::RequestError;
use super::hints::nearest_hinge;
use super::options::PlanRequest;
use super::values::LimitedEdge;
use crate::pattern::{CreaseId, CreasePattern};
use crate::planner::{Goal, GoalError, HingeLimit, Search};

/// Angles (radians) of the creases of a pattern, read from a file, and the name of the file in messages.
pub(super) type NamedGoal = (String, Vec<Option<f64>>);

impl PlanRequest {
    /// Returns the goal. `name` is the name of the pattern's file, and `read_goal` reads a file that the request names.
    pub(super) fn goal_of<E: From<RequestError>>(
        &self,
        name: &Path,
        pattern: &CreasePattern,
        read_goal: impl Fn(&Path, &CreasePattern) -> Result<NamedGoal, E>,
    ) -> Result<Goal, E> {
        let bad = |source: GoalError| match source {
            GoalError::Crease { .. } | GoalError::CreaseTwice { .. } => {
                RequestError::option("crease", source.to_string())
            }
            GoalError::Fraction(_) => RequestError::option("fold", source.to_string()),
            _ => RequestError::Goal {
                file: name.display().to_string(),
                source,
            },
        };
        let chosen = |path: &Path| -> Result<Goal, E> {
            let (name, angles) = read_goal(path, pattern)?;
            Ok(Goal::chosen(
                pattern,
                angles,
                format!("the goal angles of {name}"),
            ))
        };
        if !self.via.is_empty() && self.search == Search::Random {
            let problem = "expected search auto or path, as the randomised search knows no phases";
            return Err(RequestError::option("via", problem).into());
        }
        let mut goal = match (&self.goal, self.fold, &self.crease[..]) {
            (Some(path), ..) => chosen(path)?,
            (None, Some(fraction), _) if fraction <= 0.0 => flat(pattern),
            (None, Some(fraction), _) => Goal::of_letters(pattern, fraction).map_err(bad)?,
            (None, None, []) => Goal::of_pattern(pattern).map_err(bad)?,
            (None, None, driven) => {
                let driven = driven.iter().map(|driven| {
                    let crease = crease(pattern, "crease", driven.edge)?;
                    Ok((crease, driven.degrees.to_radians()))
                });
                let driven: Vec<_> = driven.collect::<Result<_, RequestError>>()?;
                Goal::of_creases(pattern, &driven).map_err(bad)?
            }
        };
        let via = self.via.iter().map(|path| chosen(path));
        goal.via = via.collect::<Result<_, _>>()?;
        Ok(goal)
    }

    /// Returns the limits of the hinges.
    pub(super) fn limits_of(
        &self,
        pattern: &CreasePattern,
    ) -> Result<Vec<HingeLimit>, RequestError> {
        let limit = |limit: &LimitedEdge| {
            Ok(HingeLimit {
                crease: crease(pattern, "limit", limit.edge)?,
                lower: limit.lower.to_radians(),
                upper: limit.upper.to_radians(),
            })
        };
        self.limit.iter().map(limit).collect()
    }

    /// Returns a note for each limit that leaves its crease no room at all in the direction in which the crease is to
    /// turn. No outcome says so.
    pub(super) fn held_flat(&self, pattern: &CreasePattern, goal: &Goal) -> Vec<String> {
        let note = |limit: &LimitedEdge| {
            let edge = pattern.edges().get(limit.edge)?;
            let asked = goal.fold_angles[edge.crease?.index()];
            let (way, what) = match (edge.letter.sign(), asked) {
                (_, Some(asked)) if asked.abs() <= 0.0 => return None,
                (sign, _) if sign.abs() > 0.0 => (sign, format!("lettered {}", edge.letter.code())),
                (_, asked) => {
                    let asked = asked?;
                    (
                        asked,
                        format!("whose goal is {:.6} degrees", asked.to_degrees()),
                    )
                }
            };
            let (room, side) = if way < 0.0 {
                (limit.lower < 0.0, "below")
            } else {
                (limit.upper > 0.0, "above")
            };
            (!room).then(|| {
                format!(
                    "edge {}, {what}, turns to angles {side} 0, of which its limit of {}..{} degrees leaves none: it \
                     stays flat",
                    limit.edge, limit.lower, limit.upper
                )
            })
        };
        self.limit.iter().filter_map(note).collect()
    }
}

/// Returns the flat sheet as a goal. The path begins at the flat sheet, and with `via` it goes back to it.
fn flat(pattern: &CreasePattern) -> Goal {
    let angles = vec![Some(0.0); pattern.creases().len()];
    Goal::chosen(pattern, angles, "the flat sheet".into())
}

/// Returns the crease of an edge that an option names.
fn crease(pattern: &CreasePattern, option: &str, edge: usize) -> Result<CreaseId, RequestError> {
    let found = pattern.edges().get(edge);
    found.and_then(|edge| edge.crease).ok_or_else(|| {
        let found = match found {
            Some(edge) => format!("it is lettered {}", edge.letter.code()),
            None => format!("edges go from 0 to {}", pattern.edges().len() - 1),
        };
        RequestError::Option {
            option: option.into(),
            problem: format!("edge {edge}: expected a hinge between two faces, but {found}"),
            hint: nearest_hinge(pattern, edge),
        }
    })
}
