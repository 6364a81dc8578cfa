//! Writes CSV files: the group angles of a path at its knots.

use core::fmt::Write;
use std::path::Path;

use super::FileError;
use super::fold::PathFile;
use super::groups::GroupPath;

/// Returns one row for each knot: time in seconds, then the fold angle of each crease group in degrees.
///
/// # Errors
/// If a hinge does not turn as its crease group does.
pub fn path_text(path: &PathFile, file: &Path) -> Result<String, FileError> {
    let path = GroupPath::of(path, file)?;
    let mut text = String::from("time_s");
    // Writing to memory cannot fail.
    for group in 0..path.groups {
        let _complete = write!(text, ",group_{group}_deg");
    }
    for (index, time) in path.times.iter().enumerate() {
        let _complete = write!(text, "\n{time}");
        for angle in &path.angles[index * path.groups..][..path.groups] {
            let _complete = write!(text, ",{}", angle.to_degrees() + 0.0);
        }
    }
    text.push('\n');
    Ok(text)
}
