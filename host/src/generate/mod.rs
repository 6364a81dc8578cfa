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

/// Checks the numbers of rows and columns.
fn check_sizes(rows: usize, columns: usize, least: usize) -> Result<(), ParameterError> {
    check_size("rows", rows, least)?;
    check_size("cols", columns, least)
}

fn check_size(parameter: &'static str, size: usize, least: usize) -> Result<(), ParameterError> {
    let expected = match least {
        1 => "1 to 3000",
        _ => "2 to 3000",
    };
    let is_allowed = (least..=MAX_ROWS).contains(&size);
    check(is_allowed, parameter, number(size), expected)
}

#[allow(clippy::cast_precision_loss, reason = "for a message")]
fn number(size: usize) -> f64 {
    size as f64
}

/// Checks that a parameter is in its range.
fn check(
    is_allowed: bool,
    parameter: &'static str,
    found: f64,
    expected: &'static str,
) -> Result<(), ParameterError> {
    is_allowed.then_some(()).ok_or(ParameterError {
        parameter,
        expected,
        found,
    })
}

/// Checks a fraction of a half turn.
fn check_fold(fold: f64) -> Result<(), ParameterError> {
    let expected = "a fraction above 0 and at most 1";
    check(
        (f64::MIN_POSITIVE..=1.0).contains(&fold),
        "fold",
        fold,
        expected,
    )
}

/// Checks an angle (radians) between creases.
fn check_angle(angle: f64) -> Result<(), ParameterError> {
    let degrees = angle.to_degrees();
    let is_allowed = (1.0..=89.0).contains(&degrees);
    check(is_allowed, "angle", degrees, "1 to 89 degrees")
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
