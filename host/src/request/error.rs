//! Requests that cannot be met.

use thiserror::Error;

use crate::generate::ParameterError;
use crate::planner::{GoalError, OptionsError};

/// A request that cannot be met. Options are named as on the command line.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RequestError {
    /// An option is out of its range.
    #[error("--{}: {}", .0.option, .0.problem())]
    Options(#[from] OptionsError),
    /// A parameter of a family is out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The pattern has no such goal.
    #[error("{file}: {source}")]
    Goal {
        /// The file with the pattern.
        file: String,
        /// The reason.
        source: GoalError,
    },
    /// An option has a value that it cannot have, or options exclude each other.
    #[error("{0}")]
    Usage(String),
    /// An option names an edge that is no hinge.
    #[error("{text}")]
    Hinge {
        /// The message.
        text: String,
        /// A hinge that may be meant.
        hint: Option<String>,
    },
}
