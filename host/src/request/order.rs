//! The order in which hinges fold, as a user writes it: `0-3 / 8-11 / 5=135,7 / 5`.

use core::fmt;
use core::str::FromStr;

use super::error::RequestError;
use super::plan::crease;
use crate::pattern::{CreasePattern, VertexId};
use crate::planner::Goal;

/// Steps of hinges that fold one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Order(Vec<Vec<Turn>>);

/// Hinges that turn in a step: those of the edges from `first` to `last`, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Turn {
    first: usize,
    last: usize,
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
    let (edges, degrees) = match part.split_once('=') {
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
    let number = |text: &str| text.trim().parse::<usize>().ok();
    let ends = match edges.split_once('-') {
        Some((first, last)) => number(first).zip(number(last)),
        None => number(edges).map(|edge| (edge, edge)),
    };
    let (first, last) = ends.filter(|(first, last)| first <= last).ok_or_else(|| {
        wrong("an edge such as 5, edges such as 0-3, or edges with an angle such as 5=135")
    })?;
    Ok(Turn {
        first,
        last,
        degrees,
    })
}

impl fmt::Display for Turn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.first)?;
        if self.last > self.first {
            write!(f, "-{}", self.last)?;
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
    /// If an edge or a range of edges has no hinge, or a hinge has neither an angle nor a goal.
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
                let hinges = pattern
                    .edges()
                    .iter()
                    .skip(turn.first)
                    .take(turn.last - turn.first + 1);
                let mut hinges: Vec<_> = hinges.filter_map(|edge| edge.crease).collect();
                if hinges.is_empty() || turn.last >= pattern.edges().len() {
                    hinges = vec![crease(pattern, "order", turn.last)?];
                }
                for hinge in hinges {
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
