//! FOLD 1.0 to 1.2: crease patterns in, crease patterns and animations out.
//!
//! Source: E. Demaine, J. Ku, R. Lang, "A new file standard to represent folded structures"; the
//! specification at version 1.2.

mod animation;
mod document;
mod json;
mod pattern;
mod plane;
mod shape;
mod write;

pub use animation::{PathFile, PathKnot, read_path};
pub use pattern::{PatternFile, read_goal, read_pattern};
pub(super) use plane::{FLAT_PATTERN, NOT_FLAT, lay};
pub use shape::read_shape;
pub use write::{PathWriter, pattern_text, write_pattern};
