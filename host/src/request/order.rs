//! The order in which hinges fold, as a user writes it: `0-3 / 8-11 / 5=135,lid / 5`.

use core::fmt;
use core::str::FromStr;

use super::error::RequestError;
use super::hints::nearest_name;
use super::plan::crease;
use crate::pattern::{CreaseId, CreasePattern, EdgeId, VertexId};
use crate::planner::Goal;

/// Steps of hinges that fold one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Order(Vec<Vec<Turn>>);

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
        let step = |step: &str| step.split(',').map(|part| turn(part.trim())).collect();
        text.split('/')
            .map(step)
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

fn turn(part: &str) -> Result<Turn, String> {
    let wrong = |expected: &str| format!("expected {expected}, found {part:?}");
    let (edges, degrees) = match part.rsplit_once('=') {
        Some((edges, degrees)) => {
            let degrees: Option<f64> = degrees.trim().parse().ok();
            let degrees = degrees.filter(|degrees| degrees.abs() <= 180.0);
            (
                edges,
                Some(degrees.ok_or_else(|| wrong("an angle from -180 to 180 degrees"))?),
            )
        }
        None => (part, None),
    };
    let edges = edges_of(edges.trim()).ok_or_else(|| {
        wrong("an edge such as 5, edges such as 0-3, a name of edges such as lid, or one of them with an angle such as 5=135")
    })?;
    Ok(Turn { edges, degrees })
}

/// Parses edges. A text of digits and hyphens alone is no name.
fn edges_of(text: &str) -> Option<Edges> {
    let is_number = |letter: char| letter.is_ascii_digit() || letter == '-' || letter == ' ';
    if !text.chars().all(is_number) {
        return Some(Edges::Named(text.into()));
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
            Edges::Named(name) => write!(f, "{name}")?,
        }
        self.degrees
            .map_or(Ok(()), |degrees| write!(f, "={degrees}"))
    }
}

impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let steps: Vec<String> = self.0.iter().map(|step| in_words(step)).collect();
        write!(f, "{}", steps.join(" / "))
    }
}

/// Writes a step as a user does.
fn in_words(step: &[Turn]) -> String {
    let turns: Vec<String> = step.iter().map(ToString::to_string).collect();
    turns.join(",")
}

impl Order {
    /// Returns the configurations after the steps, before the goal: the hinges of steps so far have their angles, all
    /// others rest as far as closure lets them.
    ///
    /// # Errors
    /// If an edge, a range of edges or a name has no hinge, or a hinge has neither an angle nor a goal.
    pub(super) fn stops(
        &self,
        pattern: &CreasePattern,
        goal: &Goal,
    ) -> Result<Vec<Goal>, RequestError> {
        // Creases that meet inside the sheet, or go round a hole, move with each other.
        let turns_alone = |ends: [VertexId; 2]| {
            pattern.holes().is_empty() && !ends.into_iter().any(|end| pattern.is_real(end))
        };
        let creases = pattern.creases().iter();
        let at_rest = creases.map(|&edge| turns_alone(pattern.edge(edge).ends).then_some(0.0));
        let mut angles: Vec<Option<f64>> = at_rest.collect();
        let mut stops = Vec::new();
        for (number, step) in self.0.iter().enumerate() {
            for turn in step {
                for hinge in turn.edges.hinges(pattern)? {
                    let own = goal.fold_angles[hinge.index()];
                    let angle = turn.degrees.map(f64::to_radians).or(own);
                    angles[hinge.index()] = Some(angle.ok_or_else(|| {
                        let edge = pattern.creases()[hinge.index()];
                        let problem = format!("edge {edge}: expected an angle, such as {edge}=90, as it has no goal angle");
                        RequestError::option("order", problem)
                    })?);
                }
            }
            stops.push(Goal::chosen(pattern, angles.clone(), self.step(number)));
        }
        // The last step is the goal itself if it leaves nothing for another.
        stops.pop_if(|last| last.fold_angles == goal.fold_angles);
        Ok(stops)
    }

    /// Describes the step with this number, from 0. After the last one follows that of the edges that are not named.
    pub(super) fn step(&self, number: usize) -> String {
        let step = self.0.get(number);
        let edges = step.map_or("the edges that are not named".into(), |step| {
            format!("edges {}", in_words(step))
        });
        format!("step {} of the order ({edges})", number + 1)
    }
}
