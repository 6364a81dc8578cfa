//! Goals of a plan: fold angles from the pattern, from the assignments (FOLD letters) of its creases, or chosen by a
//! user.

use core::f64::consts::PI;

use thiserror::Error;

use super::vectors::largest;
use crate::pattern::{CreaseId, CreasePattern, Digits, Precision};

/// Goal fold angles of the creases, and how they are to be reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// One angle for each crease, radians; `None` for a free hinge, which follows the others.
    pub fold_angles: Vec<Option<f64>>,
    /// Largest distance of a crease from its goal angle, radians, if the goal itself does not close. A closed
    /// configuration farther away is another goal.
    pub reach: f64,
    /// For each crease the direction in which it turns, from its assignment: -1, 1, or 0 if unknown.
    pub signs: Vec<f64>,
    /// Goals to pass through before this one, in this order.
    pub via: Vec<Goal>,
    /// Meaning of the angles.
    pub kind: GoalKind,
    /// For a driven crease, the goal that the pattern names, if there is one: the crease is first turned on the path to
    /// that goal.
    pub guide: Option<Box<Goal>>,
    /// Source of the angles, in words.
    pub source: String,
}

/// Meaning of the angles of a [`Goal`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalKind {
    /// A configuration of the sheet.
    Configuration,
    /// A direction: the sheet folds that way as far as it goes.
    Letters,
    /// The angles of driven creases: the other creases rest, or follow.
    Driven,
}

/// [`reach`](Goal::reach) of chosen angles, radians: eleven degrees cover measured goals.
pub const CHOSEN_REACH: f64 = 0.2;

/// Largest angle of a goal that counts as flat, radians.
const FLAT_RAD: f64 = 1e-9;
/// Angle from which a crease counts as turned by half a turn, radians: below π by rounding.
const HALF_TURN_RAD: f64 = PI - 1e-9;
/// Angle below which a lettered crease counts as flat at the end of a path to given angles, radians: one degree.
const FLAT_AT_END_RAD: f64 = PI / 180.0;
/// Fraction of the asked angle below which a lettered crease counts as flat at the end of a path along the letters.
const FLAT_AT_END_RATIO: f64 = 0.1;

/// Reason why there is no goal.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GoalError {
    /// No angle and no assignment says which way to fold.
    #[error(
        "edges_assignment: no crease is lettered M or V and no goal angle is given; expected a goal \
         frame, edges_foldAngle or letters"
    )]
    NoDirection,
    /// The goal is the flat sheet itself.
    #[error("edges_foldAngle: the goal is the flat sheet; expected an angle other than 0")]
    Flat,
    /// A driven crease cannot turn to the angle asked for.
    #[error(
        "edge {edge} is lettered {letter}, expected an angle its way, not 0 and at most 180 \
         degrees, found {degrees:.6}"
    )]
    Crease {
        /// The edge of the crease.
        edge: usize,
        /// FOLD letter of the edge's assignment.
        letter: char,
        /// The angle asked for, degrees.
        degrees: f64,
    },
    /// A driven crease is named twice.
    #[error("edge {edge} is named twice, expected each edge once")]
    CreaseTwice {
        /// The edge of the crease.
        edge: usize,
    },
    /// The fraction is out of its range.
    #[error("expected a fraction above 0 and at most 1, found {0}")]
    Fraction(f64),
}

impl Goal {
    /// Makes a goal of chosen angles.
    #[must_use]
    pub fn chosen(pattern: &CreasePattern, fold_angles: Vec<Option<f64>>, source: String) -> Self {
        Self {
            fold_angles,
            reach: CHOSEN_REACH,
            signs: letter_signs(pattern),
            via: Vec::new(),
            kind: GoalKind::Configuration,
            guide: None,
            source,
        }
    }

    /// Returns the precision of a pattern that folds to this goal: its angles count if they were measured or written, those
    /// of letters and of driven creases are meant as they are.
    pub(crate) fn precision(&self, pattern: &CreasePattern) -> Precision {
        let Precision { length, angle } = pattern.precision();
        let angle = if self.kind == GoalKind::Configuration {
            angle.coarser(Digits::of_angles(
                self.fold_angles.iter().flatten().copied(),
            ))
        } else {
            Digits::Exact
        };
        Precision { length, angle }
    }

    /// Makes the goal of some creases turned to their angles (radians) from flat, while the others follow in the
    /// directions of their assignments.
    ///
    /// # Errors
    /// If an angle is 0, beyond half a turn or against the crease's assignment, or a crease has two angles.
    pub fn of_creases(
        pattern: &CreasePattern,
        driven: &[(CreaseId, f64)],
    ) -> Result<Self, GoalError> {
        let mut fold_angles = vec![None; pattern.creases().len()];
        let mut sources = Vec::new();
        for &(crease, angle) in driven {
            let edge = pattern.creases()[crease.index()];
            let (letter, degrees) = (pattern.edge(edge).letter, angle.to_degrees());
            let against = angle * letter.sign() < 0.0;
            if !(angle.abs() > FLAT_RAD && angle.abs() <= core::f64::consts::PI) || against {
                return Err(GoalError::Crease {
                    edge: edge.index(),
                    letter: letter.code(),
                    degrees,
                });
            }
            if fold_angles[crease.index()].replace(angle).is_some() {
                return Err(GoalError::CreaseTwice { edge: edge.index() });
            }
            sources.push(format!("edge {edge} at {degrees:.6} degrees"));
        }
        let mut goal = Self::chosen(pattern, fold_angles, sources.join(", "));
        goal.kind = GoalKind::Driven;
        goal.guide = Self::of_pattern(pattern).ok().map(Box::new);
        Ok(goal)
    }

    /// Makes the goal of the pattern's own goal angles, or else of its assignments folded all the way.
    ///
    /// # Errors
    /// If neither says where to go, or all goal angles are 0.
    pub fn of_pattern(pattern: &CreasePattern) -> Result<Self, GoalError> {
        let goals = pattern.creases().iter().map(|&id| pattern.edge(id).goal);
        if goals.clone().all(|goal| goal.is_none()) {
            return Self::of_letters(pattern, 1.0);
        }
        let fold_angles: Vec<Option<f64>> = goals.collect();
        if fold_angles
            .iter()
            .flatten()
            .all(|angle| angle.abs() <= FLAT_RAD)
        {
            return Err(GoalError::Flat);
        }
        let source = "the pattern's goal angles".into();
        Ok(Self::chosen(pattern, fold_angles, source))
    }

    /// Makes the goal of each crease turned by `fraction` of a half turn in the direction of its assignment; unassigned
    /// creases are free.
    ///
    /// # Errors
    /// If no assignment gives a direction, or the fraction is not above 0 and at most 1.
    pub fn of_letters(pattern: &CreasePattern, fraction: f64) -> Result<Self, GoalError> {
        if !(fraction > 0.0 && fraction <= 1.0) {
            return Err(GoalError::Fraction(fraction));
        }
        let signs = letter_signs(pattern);
        let angle = fraction * core::f64::consts::PI;
        // A hinge whose assignment gives no direction is free.
        let fold_angles: Vec<Option<f64>> = signs
            .iter()
            .map(|sign| (sign.abs() > 0.0).then_some(sign * angle))
            .collect();
        if fold_angles.iter().all(Option::is_none) {
            return Err(GoalError::NoDirection);
        }
        let source = format!("the letters at {fraction:.4} of a half turn");
        let mut goal = Self::chosen(pattern, fold_angles, source);
        goal.kind = GoalKind::Letters;
        if fraction < 1.0 {
            // Assignments give directions, not angles. Folded all the way, though, they are one configuration.
            goal.reach = core::f64::consts::PI;
        }
        Ok(goal)
    }

    /// Returns `true` if the goal is a direction rather than a configuration: the letters at less than a half turn.
    pub(crate) fn is_direction(&self) -> bool {
        self.kind == GoalKind::Letters && largest(&self.fold_angles) < HALF_TURN_RAD
    }

    /// Returns the angle below which a lettered crease counts as flat at the end of a path, radians.
    pub(crate) fn least_turn(&self) -> f64 {
        if self.is_direction() {
            FLAT_AT_END_RATIO * largest(&self.fold_angles)
        } else {
            FLAT_AT_END_RAD
        }
    }

    /// Returns which of some creases or crease groups, lettered by these signs and at these angles (radians), count as flat
    /// at the end of a path: those that have not turned their way.
    pub(crate) fn flat<'g>(
        &self,
        signs: &'g [f64],
        angles: &'g [f64],
    ) -> impl Iterator<Item = usize> + use<'g> {
        let least = self.least_turn();
        let turned = signs.iter().zip(angles).enumerate();
        let flat =
            turned.filter(move |(_, (sign, angle))| sign.abs() > 0.0 && *sign * *angle < least);
        flat.map(|(crease, _)| crease)
    }
}

/// Returns for each crease the sign of its assignment.
fn letter_signs(pattern: &CreasePattern) -> Vec<f64> {
    let creases = pattern.creases().iter();
    creases.map(|&id| pattern.edge(id).letter.sign()).collect()
}
