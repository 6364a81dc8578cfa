//! Reads and writes FOLD 1.0 to 1.2: reads crease patterns, folded shapes and paths; writes crease patterns and paths.
//!
//! Source: E. Demaine, J. Ku, R. Lang, "A new file standard to represent folded structures"; the
//! specification at version 1.2.

mod animation;
mod document;
mod json;
mod keys;
mod measured;
mod pattern;
mod plane;
mod shape;
mod write;

pub(crate) use animation::interpolation_name;
pub use animation::{PathFile, PathKnot, parse_path, read_path};
pub(super) use pattern::parse_within;
pub use pattern::{PatternFile, parse_goal, parse_pattern, read_goal, read_pattern};
pub(super) use plane::{FLAT_PATTERN, NOT_FLAT, lay};
pub use shape::{parse_shape, read_shape};
pub use write::{PathWriter, pattern_text, write_pattern};

/// Largest size of a file, bytes: paths of a million faces have about one gigabyte.
pub(super) const LARGEST_FILE: u64 = 1 << 31;
