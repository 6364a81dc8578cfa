//! Where the sheet is to go.

use thiserror::Error;

use crate::pattern::{CreaseId, CreasePattern};

/// Goal fold angles of the creases, radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// One for each crease; `None` for a free hinge, which goes where the others take it.
    pub fold_angles: Vec<Option<f64>>,
    /// How far a crease may be from its goal angle, radians, where that does not close. What is nearest
    /// beyond that is another goal.
    pub reach: f64,
    /// For each crease the way it turns (-1, 0 if that is not known, 1): of its letter.
    pub signs: Vec<f64>,
    /// Configurations to pass through before, in this order, each as a goal of its own.
    pub via: Vec<Goal>,
    /// What the angles mean.
    pub kind: GoalKind,
    /// For a driven crease the goal on whose way it turns, if the pattern names one.
    pub guide: Option<Box<Goal>>,
    /// Where they come from, in words.
    pub source: String,
}

/// What the angles of a [`Goal`] mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalKind {
    /// A configuration of the sheet.
    Configuration,
    /// As far that way as the sheet goes.
    Letters,
    /// One crease is driven, and the others follow from flat.
    Driven,
}

/// [`reach`](Goal::reach) of angles that somebody chose: eleven degrees cover measured goals.
pub const CHOSEN_REACH: f64 = 0.2;

/// Radians: a goal whose angles are all below this is flat.
const FLAT: f64 = 1e-9;

/// Why there is no goal.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GoalError {
    /// Nothing says which way to fold.
    #[error(
        "edges_assignment: no crease is lettered M or V and no goal angle is given; expected a goal \
         frame, edges_foldAngle or letters"
    )]
    NoDirection,
    /// The goal is the flat sheet itself.
    #[error("edges_foldAngle: the goal is the flat sheet; expected an angle other than 0")]
    Flat,
    /// A driven crease cannot go there.
    #[error(
        "--crease: edge {edge} is lettered {letter}, expected an angle its way, not 0 and at most 180 \
         degrees, found {degrees:.6}"
    )]
    Crease {
        /// The edge.
        edge: usize,
        /// Its letter.
        letter: char,
        /// The angle asked for.
        degrees: f64,
    },
    /// The fraction is not one.
    #[error("--fold: expected a fraction above 0 and at most 1, found {0}")]
    Fraction(f64),
}

impl Goal {
    /// Goal angles that somebody chose.
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

    /// One crease turned to `angle` (radians) from flat, the others following the way their letters
    /// say.
    ///
    /// # Errors
    /// If the angle is 0, beyond half a turn or against the crease's letter.
    pub fn of_crease(
        pattern: &CreasePattern,
        crease: CreaseId,
        angle: f64,
    ) -> Result<Self, GoalError> {
        let edge = pattern.creases()[crease.index()].index();
        let letter = pattern.edge(pattern.creases()[crease.index()]).letter;
        let degrees = angle.to_degrees();
        let against = angle * letter.sign() < 0.0;
        if !(angle.abs() > FLAT && angle.abs() <= core::f64::consts::PI) || against {
            return Err(GoalError::Crease {
                edge,
                letter: letter.code(),
                degrees,
            });
        }
        let mut fold_angles = vec![None; pattern.creases().len()];
        fold_angles[crease.index()] = Some(angle);
        let source = format!("edge {edge} at {degrees:.6} degrees");
        let mut goal = Self::chosen(pattern, fold_angles, source);
        goal.kind = GoalKind::Driven;
        goal.guide = Self::of_pattern(pattern).ok().map(Box::new);
        Ok(goal)
    }

    /// The pattern's own goal angles, or else its letters folded all the way.
    ///
    /// # Errors
    /// If neither says where to go.
    pub fn of_pattern(pattern: &CreasePattern) -> Result<Self, GoalError> {
        let goals = pattern.creases().iter().map(|&id| pattern.edge(id).goal);
        if goals.clone().all(|goal| goal.is_none()) {
            return Self::of_letters(pattern, 1.0);
        }
        let fold_angles: Vec<Option<f64>> = goals.collect();
        if fold_angles
            .iter()
            .flatten()
            .all(|angle| angle.abs() <= FLAT)
        {
            return Err(GoalError::Flat);
        }
        let source = "the pattern's goal angles".into();
        Ok(Self::chosen(pattern, fold_angles, source))
    }

    /// Each crease turned by `fraction` of a half turn, the way its letter says; unassigned ones free.
    ///
    /// # Errors
    /// If no letter says a way, or the fraction is not in 0..1.
    pub fn of_letters(pattern: &CreasePattern, fraction: f64) -> Result<Self, GoalError> {
        if !(fraction > 0.0 && fraction <= 1.0) {
            return Err(GoalError::Fraction(fraction));
        }
        let signs = letter_signs(pattern);
        let angle = fraction * core::f64::consts::PI;
        // A hinge whose letter says no way is free.
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
            // Letters say which way, not how far. All the way, though, is one configuration.
            goal.reach = core::f64::consts::PI;
        }
        Ok(goal)
    }
}

/// For each crease the sign of its letter.
fn letter_signs(pattern: &CreasePattern) -> Vec<f64> {
    let creases = pattern.creases().iter();
    creases.map(|&id| pattern.edge(id).letter.sign()).collect()
}
