//! Where the sheet is to go.

use thiserror::Error;

use crate::pattern::CreasePattern;

/// Goal fold angles of the creases, radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// One for each crease; `None` for a free hinge, which goes where the others take it.
    pub fold_angles: Vec<Option<f64>>,
    /// How far a crease may be from its goal angle, radians, where that does not close. What is nearest
    /// beyond that is another goal.
    pub reach: f64,
    /// Where they come from, in words.
    pub source: String,
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
    /// The fraction is not one.
    #[error("--fold: expected a fraction above 0 and at most 1, found {0}")]
    Fraction(f64),
}

impl Goal {
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
        Ok(Self {
            fold_angles,
            reach: CHOSEN_REACH,
            source: "the pattern's goal angles".into(),
        })
    }

    /// Each crease turned by `fraction` of a half turn, the way its letter says; unassigned ones free.
    ///
    /// # Errors
    /// If no letter says a way, or the fraction is not in 0..1.
    pub fn of_letters(pattern: &CreasePattern, fraction: f64) -> Result<Self, GoalError> {
        if !(fraction > 0.0 && fraction <= 1.0) {
            return Err(GoalError::Fraction(fraction));
        }
        let signs = pattern
            .creases()
            .iter()
            .map(|&id| pattern.edge(id).letter.sign());
        let angle = fraction * core::f64::consts::PI;
        // A hinge whose letter says no way is free.
        let fold_angles: Vec<Option<f64>> = signs
            .map(|sign| (sign.abs() > 0.0).then_some(sign * angle))
            .collect();
        if fold_angles.iter().all(Option::is_none) {
            return Err(GoalError::NoDirection);
        }
        Ok(Self {
            fold_angles,
            // Letters say which way, not how far.
            reach: core::f64::consts::PI,
            source: format!("the letters at {:.4} of a half turn", fraction),
        })
    }
}
