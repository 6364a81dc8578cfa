//! Requests that cannot be met.

use thiserror::Error;

use crate::generate::ParameterError;
use crate::pattern::LostLines;
use crate::planner::{GoalError, OptionsError};

/// A request that cannot be met.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RequestError {
    /// An option, or a parameter of a family, has a value that it cannot have.
    #[error("{option}: {problem}")]
    Option {
        /// Name of the option, with `_` between its words.
        option: String,
        /// The problem: the value expected and the value found.
        problem: String,
        /// A value that may be meant.
        hint: Option<String>,
    },
    /// An option is given beside another that excludes it.
    #[error("{option}: expected without {other}")]
    Excluded {
        /// Name of the option, with `_` between its words.
        option: &'static str,
        /// Name of the other one.
        other: &'static str,
    },
    /// There is no option of this name.
    #[error("unexpected option {0}")]
    NoOption(String),
    /// The pattern has no such goal.
    #[error("{file}: {source}{}", after(lost.as_ref()))]
    Goal {
        /// The file with the pattern.
        file: String,
        /// The reason.
        source: GoalError,
        /// Lines of the drawing that were left out, which may be the reason.
        lost: Option<LostLines>,
    },
    /// Anything else.
    #[error("{0}")]
    Usage(String),
}

/// Returns a sentence about lines that were left out, to follow another.
fn after(lost: Option<&LostLines>) -> String {
    lost.map_or_else(String::new, |lost| format!("; {lost}"))
}

impl RequestError {
    pub(super) fn option(option: &str, problem: impl Into<String>) -> Self {
        Self::Option {
            option: option.into(),
            problem: problem.into(),
            hint: None,
        }
    }
}

impl From<OptionsError> for RequestError {
    fn from(error: OptionsError) -> Self {
        Self::option(error.option, error.problem())
    }
}

impl From<ParameterError> for RequestError {
    fn from(error: ParameterError) -> Self {
        Self::option(error.parameter, error.problem())
    }
}
