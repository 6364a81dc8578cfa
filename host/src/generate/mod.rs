//! Generates crease patterns of known families, with letters and a goal that closes. The goal of [`Quad`] cannot close.

mod grid;
mod kresling;
mod miura;
mod quad;
mod resch;
mod square_twist;
mod waterbomb;
mod yoshimura;

pub use kresling::Kresling;
pub use miura::Miura;
pub use quad::Quad;
pub use resch::Resch;
pub use square_twist::{Letters, SquareTwist};
pub use waterbomb::Waterbomb;
pub use yoshimura::Yoshimura;

use thiserror::Error;

use crate::pattern::{DrawnEdge, Letter};

/// A parameter outside its range.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[error("{parameter}: {}", self.problem())]
pub struct ParameterError {
    /// The parameter.
    pub parameter: &'static str,
    /// Its range.
    pub expected: &'static str,
    /// The value given.
    pub found: f64,
}

impl ParameterError {
    /// Returns the problem, without the parameter's name.
    #[must_use]
    pub fn problem(&self) -> String {
        format!("expected {}, found {}", self.expected, self.found)
    }
}

/// Largest number of rows or columns of a sheet: the largest sheets have a little more than 10⁷ edges.
const MAX_ROWS: usize = 3_000;

fn check_size(parameter: &'static str, size: usize, least: usize) -> Result<(), ParameterError> {
    #[allow(clippy::cast_precision_loss, reason = "for a message")]
    let found = size as f64;
    let expected = match least {
        1 => "1 to 3000",
        _ => "2 to 3000",
    };
    if (least..=MAX_ROWS).contains(&size) {
        Ok(())
    } else {
        Err(ParameterError {
            parameter,
            expected,
            found,
        })
    }
}

fn check_between(
    parameter: &'static str,
    value: f64,
    [low, high]: [f64; 2],
    expected: &'static str,
) -> Result<(), ParameterError> {
    if value >= low && value <= high {
        Ok(())
    } else {
        Err(ParameterError {
            parameter,
            expected,
            found: value,
        })
    }
}

fn check_fold(fold: f64) -> Result<(), ParameterError> {
    check_between(
        "fold",
        fold,
        [f64::MIN_POSITIVE, 1.0],
        "a fraction above 0 and at most 1",
    )
}

/// Makes a crease with this goal fold angle, radians, and the letter of its sign.
fn crease(ends: [usize; 2], goal: f64) -> DrawnEdge {
    DrawnEdge {
        ends,
        letter: if goal < 0.0 {
            Letter::Mountain
        } else {
            Letter::Valley
        },
        goal: Some(goal),
    }
}
