//! Requests that cannot be met.

use thiserror::Error;

use crate::planner::{GoalError, OptionsError};

/// A request that cannot be met. Options are named as on the command line.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RequestError {
    /// An option is out of its range.
    #[error("--{}: {}", flag(.0), .0.problem())]
    Options(#[from] OptionsError),
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

/// Returns the name of an option on the command line.
fn flag(error: &OptionsError) -> String {
    match error.option {
        "max_acceleration" => "max-accel".into(),
        option => option.replace('_', "-"),
    }
}
