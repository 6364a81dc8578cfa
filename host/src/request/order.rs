//! The order in which hinges fold: as a user writes it, `0-3 / 8-11 / 5=135,lid / 5`, or as the frames of a file. Names that
//! would be read otherwise stand in quotation marks, as in `"0" / "a-b"`.

use core::fmt;
use core::str::FromStr;
use std::path::{Path, PathBuf};

use super::error::RequestError;
use super::hints::nearest_name;
use super::plan::{NamedGoals, crease};
use crate::pattern::{CreaseId, CreasePattern, EdgeId, VertexId};
use crate::planner::{FoldOrder, Goal, GoalKind};

/// Largest distance at which a fold angle that was found is that of the goal, radians.
const SAME_ANGLE_RAD: f64 = 1e-6;

/// Steps of hinges that fold one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Order(Steps);

/// The steps, or the file that has them.
#[derive(Clone, Debug, PartialEq)]
enum Steps {
    /// Steps that are written out.
    Written(Vec<Vec<Turn>>),
    /// A step for each frame of a FOLD file that has fold angles.
    Keyframes(PathBuf),
}

/// Edges as a user writes them.
#[derive(Clone, Debug, PartialEq)]
enum Edges {
    /// The edges from `first` to `last`, both included.
    Numbered { first: usize, last: usize },
    /// The edges that have a name in the drawing.
    Named(String),
}

/// Hinges that turn in a step.
#[derive(Clone, Debug, PartialEq)]
struct Turn {
    edges: Edges,
    /// Fold angle at the end of the step, degrees; `None` for the goal angle.
    degrees: Option<f64>,
}

impl FromStr for Order {
    type Err = String;

    /// Returns what was expected, and the part of the text that is wrong.
    fn from_str(text: &str) -> Result<Self, String> {
        if text.trim().to_ascii_lowercase().ends_with(".fold") {
            return Ok(Self(Steps::Keyframes(text.trim().into())));
        }
        let step = |step: &str| -> Result<Vec<Turn>, String> {
            let parts = unquoted(step, ',').into_iter();
            parts.map(|part| turn(part.trim())).collect()
        };
        unquoted(text, '/')
            .into_iter()
            .map(step)
            .collect::<Result<_, _>>()
            .map(|steps| Self(Steps::Written(steps)))
    }
}

/// Splits a text at a separator, but for separators between quotation marks.
fn unquoted(text: &str, separator: char) -> Vec<&str> {
    let mut is_quoted = false;
    let split = |letter: char| {
        is_quoted ^= letter == '"';
        letter == separator && !is_quoted
    };
    text.split(split).collect()
}

fn turn(part: &str) -> Result<Turn, String> {
    let wrong = |expected: &str| format!("expected {expected}, found {part:?}");
    let (edges, degrees) = match unquoted(part, '=')[..] {
        [edges, degrees] => {
            let degrees: Option<f64> = degrees.trim().parse().ok();
            let degrees = degrees.filter(|degrees| degrees.abs() <= 180.0);
            (
                edges,
                Some(degrees.ok_or_else(|| wrong("an angle from -180 to 180 degrees"))?),
            )
        }
        _ => (part, None),
    };
    let edges = edges_of(edges.trim()).ok_or_else(|| {
        wrong("an edge such as 5, edges such as 0-3, a name of edges such as lid, or one of them with an angle such as 5=135")
    })?;
    Ok(Turn { edges, degrees })
}

/// Returns `true` if a text of an order has to be read as numbers of edges.
fn is_number(text: &str) -> bool {
    let is_of_number = |letter: char| letter.is_ascii_digit() || letter == '-' || letter == ' ';
    text.chars().all(is_of_number)
}

/// Parses edges. A text of digits and hyphens alone is a name only in quotation marks.
fn edges_of(text: &str) -> Option<Edges> {
    let quoted = text
        .strip_prefix('"')
        .and_then(|text| text.strip_suffix('"'));
    if let Some(name) = quoted {
        return (!name.is_empty() && !name.contains('"')).then(|| Edges::Named(name.into()));
    }
    if !is_number(text) {
        return (!text.contains('"')).then(|| Edges::Named(text.into()));
    }
    let number = |text: &str| text.trim().parse::<usize>().ok();
    let (first, last) = match text.split_once('-') {
        Some((first, last)) => number(first).zip(number(last))?,
        None => number(text).map(|edge| (edge, edge))?,
    };
    (first <= last).then_some(Edges::Numbered { first, last })
}

impl Edges {
    /// Returns their hinges.
    ///
    /// # Errors
    /// If there are none.
    fn hinges(&self, pattern: &CreasePattern) -> Result<Vec<CreaseId>, RequestError> {
        let edges = pattern.edges();
        match self {
            &Self::Numbered { first, last } => {
                let some = edges.iter().skip(first).take(last - first + 1);
                let hinges: Vec<_> = some.filter_map(|edge| edge.crease).collect();
                if hinges.is_empty() || last >= edges.len() {
                    return Ok(vec![crease(pattern, "order", last)?]);
                }
                Ok(hinges)
            }
            Self::Named(name) => {
                let found = pattern.names().get(name).into_iter().flatten();
                let hinges: Vec<_> = found
                    .filter_map(|&edge| pattern.edge(edge).crease)
                    .collect();
                if hinges.is_empty() {
                    return Err(no_hinge(pattern, name));
                }
                Ok(hinges)
            }
        }
    }
}

/// Returns the error of a name that stands for no hinge.
fn no_hinge(pattern: &CreasePattern, name: &str) -> RequestError {
    let is_hinge = |&edge: &EdgeId| pattern.edge(edge).crease.is_some();
    let names = pattern.names();
    let of_hinges = names.iter().filter(|(_, edges)| edges.iter().any(is_hinge));
    let nearest = nearest_name(of_hinges.map(|(name, _)| &**name), name);
    let found = match (names.get(name), &nearest) {
        (Some(_), _) => "none of the edges of this name is one",
        (None, Some(_)) => "the drawing has no such name",
        (None, None) => "no hinge of the drawing has a name",
    };
    RequestError::Option {
        option: "order".into(),
        problem: format!("{name:?}: expected the name of a hinge between two faces, but {found}"),
        hint: nearest.map(|nearest| format!("the nearest name of a hinge is {nearest:?}")),
    }
}

impl fmt::Display for Turn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.edges {
            Edges::Numbered { first, last } if last > first => write!(f, "{first}-{last}")?,
            Edges::Numbered { first, .. } => write!(f, "{first}")?,
            Edges::Named(name) if is_number(name) || name.contains(['/', ',', '=']) => {
                write!(f, "\"{name}\"")?;
            }
            Edges::Named(name) => write!(f, "{name}")?,
        }
        self.degrees
            .map_or(Ok(()), |degrees| write!(f, "={degrees}"))
    }
}

impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Steps::Written(steps) => {
                let steps: Vec<String> = steps.iter().map(|step| in_words(step)).collect();
                write!(f, "{}", steps.join(" / "))
            }
            Steps::Keyframes(file) => write!(f, "{}", file.display()),
        }
    }
}

/// Writes a step as a user does.
fn in_words(step: &[Turn]) -> String {
    let turns: Vec<String> = step.iter().map(ToString::to_string).collect();
    turns.join(",")
}

impl Order {
    /// Returns an order that the planner found, as a user writes it. Angles that are those of the goal are left out.
    pub(super) fn of(found: &FoldOrder, pattern: &CreasePattern, goal: &Goal) -> Self {
        let turn = |&(hinge, angle): &(CreaseId, f64)| {
            // Driven hinges turn to angles of the request, which the pattern does not know.
            let own = goal.fold_angles[hinge.index()].filter(|_| goal.kind != GoalKind::Driven);
            let is_goal = own.is_some_and(|own| (own - angle).abs() < SAME_ANGLE_RAD);
            let edge = pattern.creases()[hinge.index()].index();
            Turn {
                edges: Edges::Numbered {
                    first: edge,
                    last: edge,
                },
                degrees: (!is_goal).then(|| (angle.to_degrees() * 1e6).round() / 1e6),
            }
        };
        let steps = found.steps.iter();
        Self(Steps::Written(
            steps.map(|step| step.iter().map(turn).collect()).collect(),
        ))
    }

    /// Returns the file of keyframes, if the steps are those.
    pub(super) fn file(&self) -> Option<&PathBuf> {
        match &self.0 {
            Steps::Written(_) => None,
            Steps::Keyframes(file) => Some(file),
        }
    }

    /// Returns the configurations after the steps, before the goal, and the description of the last step: the hinges of
    /// steps so far have their angles, all others rest as far as closure lets them. `keyframes` reads the fold angles
    /// (radians) of the creases in each frame of a file.
    ///
    /// # Errors
    /// If edges, a range of edges or a name have no hinge, a hinge has neither an angle nor a goal, or a file cannot be read.
    pub(super) fn stops<E: From<RequestError>>(
        &self,
        pattern: &CreasePattern,
        goal: &Goal,
        keyframes: impl Fn(&Path) -> Result<NamedGoals, E>,
    ) -> Result<(Vec<Goal>, String), E> {
        let steps = match &self.0 {
            Steps::Written(steps) => {
                let steps = steps.iter().map(|step| {
                    let turns = turns(step, pattern, goal)?;
                    Ok((turns, format!("edges {}", in_words(step))))
                });
                steps.collect::<Result<Vec<_>, RequestError>>()?
            }
            Steps::Keyframes(file) => {
                let (name, frames) = keyframes(file)?;
                let frames = (1..).zip(frames);
                let steps = frames.map(|(number, angles)| {
                    let hinges = (0..).map(CreaseId).zip(angles);
                    let turns = hinges.filter_map(|(hinge, angle)| Some((hinge, angle?)));
                    (turns.collect(), format!("keyframe {number} of {name}"))
                });
                steps.collect()
            }
        };
        Ok(stops_after(steps, pattern, goal))
    }
}

/// Hinges that turn in a step, each to an angle in radians, and a description of the step.
type Step = (Vec<(CreaseId, f64)>, String);

/// Returns the hinges that turn in a step, each with its angle.
fn turns(
    step: &[Turn],
    pattern: &CreasePattern,
    goal: &Goal,
) -> Result<Vec<(CreaseId, f64)>, RequestError> {
    let mut turns = Vec::new();
    for turn in step {
        for hinge in turn.edges.hinges(pattern)? {
            let own = goal.fold_angles[hinge.index()];
            let angle = turn.degrees.map(f64::to_radians).or(own);
            let angle = angle.ok_or_else(|| {
                let edge = pattern.creases()[hinge.index()];
                let problem = format!(
                    "edge {edge}: expected an angle, such as {edge}=90, as it has no goal angle"
                );
                RequestError::option("order", problem)
            })?;
            turns.push((hinge, angle));
        }
    }
    Ok(turns)
}

/// Returns the configurations after the steps, before the goal, and the description of the last step.
fn stops_after(steps: Vec<Step>, pattern: &CreasePattern, goal: &Goal) -> (Vec<Goal>, String) {
    // Creases that meet inside the sheet, or go round a hole, move with each other.
    let turns_alone = |ends: [VertexId; 2]| {
        !pattern.has_hinged_holes() && !ends.into_iter().any(|end| pattern.is_real(end))
    };
    let creases = pattern.creases().iter();
    let at_rest = creases.map(|&edge| turns_alone(pattern.edge(edge).ends).then_some(0.0));
    let mut angles: Vec<Option<f64>> = at_rest.collect();
    let described = |number: usize, what: &str| format!("step {number} of the order ({what})");
    let mut last = described(steps.len() + 1, "the edges that are not named");
    let mut stops = Vec::new();
    for (number, (turns, what)) in (1..).zip(steps) {
        for (hinge, angle) in turns {
            angles[hinge.index()] = Some(angle);
        }
        stops.push(Goal::chosen(
            pattern,
            angles.clone(),
            described(number, &what),
        ));
    }
    // The last step is the goal itself if it leaves nothing for another.
    if let Some(whole) = stops.pop_if(|stop| stop.fold_angles == goal.fold_angles) {
        last = whole.source;
    }
    (stops, last)
}
