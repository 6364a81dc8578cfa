//! Writes CSV files: the group angles of a path at its knots.

use core::fmt::Write;
use std::path::Path;

use super::groups::HingeGroups;
use crate::motion::Motion;
use crate::read::FileError;

/// Returns one row for each knot: time in seconds, then the fold angle of each crease group in degrees.
///
/// # Errors
/// If a hinge does not turn as its crease group does.
pub fn text(motion: &Motion, file: &Path) -> Result<String, FileError> {
    let groups = HingeGroups::of(motion, file)?;
    let mut text = String::from("time_s");
    // Writing to memory cannot fail.
    for group in 0..groups.len() {
        let _complete = write!(text, ",group_{group}_deg");
    }
    for (index, knot) in motion.knots.iter().enumerate() {
        let _complete = write!(text, "\n{}", knot.time);
        for node in groups.nodes(motion, index) {
            let _complete = write!(text, ",{}", node.angle.to_degrees() + 0.0);
        }
    }
    text.push('\n');
    Ok(text)
}
