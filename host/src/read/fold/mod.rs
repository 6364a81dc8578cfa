//! Reads crease patterns, folded shapes and motions from FOLD 1.0 to 1.2.
//!
//! Source: E. Demaine, J. Ku, R. Lang, "A new file standard to represent folded structures"; the
//! specification at version 1.2.

mod document;
mod json;
mod keys;
mod measured;
mod motion;
mod pattern;
mod plane;
mod shape;

pub(crate) use document::A_DOCUMENT;
pub use motion::{parse_motion, read_motion};
pub(super) use pattern::parse_within;
pub use pattern::{GoalFrames, PatternFile, parse_goals};
pub(super) use plane::{FLAT_PATTERN, NOT_FLAT, lay};
pub use shape::parse_shape;

/// Largest size of a file, bytes: paths of a million faces have about one gigabyte.
pub(super) const MAX_FILE_BYTES: u64 = 1 << 31;
