//! Writes CSV files: the group angles of a path at its knots, or the angles of hinges or groups at a fixed rate.

use core::fmt::Write;
use std::path::Path;

use super::groups::HingeGroups;
use super::{Export, Made, Sink};
use crate::motion::Motion;
use crate::read::FileError;

/// Makes the file.
pub(super) fn made(export: &Export<'_>, sink: &mut Sink<'_>) -> Result<Made, FileError> {
    let (motion, name) = (export.motion()?, export.name);
    let (text, told) = match export.options.rate {
        None => (text(motion, name)?, format!("{} knots", motion.knots.len())),
        Some(rate) => {
            let text = sampled(motion, name, rate, export.options.per)?;
            let rows = text.lines().count() - 1;
            (text, format!("{rows} rows at {rate} Hz"))
        }
    };
    sink("", text.into_bytes())?;
    Ok(Made::told(told))
}

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

/// Meaning of a column of [`sampled`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Column {
    /// One hinge, named `edge_I` by the number I of its edge.
    #[default]
    Hinge,
    /// One crease group, named `group_G`.
    Group,
}

/// Largest number of numbers in a file of [`sampled`].
const MAX_NUMBERS: f64 = 1e8;

/// Returns a row each 1/`rate` seconds and one for the end of the motion: time `t` in seconds since the start, then the
/// fold angle of each hinge or group in degrees, valley positive. `rate` is in hertz, finite and above 0.
///
/// # Errors
/// If the file would have more than 10⁸ numbers, or if columns are groups and a hinge does not turn as its group does.
pub fn sampled(
    motion: &Motion,
    file: &Path,
    rate: f64,
    column: Column,
) -> Result<String, FileError> {
    let groups = match column {
        Column::Group => Some(HingeGroups::of(motion, file)?),
        Column::Hinge => None,
    };
    let creases = motion.pattern.creases();
    let columns = groups.as_ref().map_or(creases.len(), HingeGroups::len);
    let [start, end] =
        [motion.knots.first(), motion.knots.last()].map(|knot| knot.map_or(0.0, |knot| knot.time));
    #[allow(clippy::cast_precision_loss, reason = "of what fits in memory")]
    let numbers = ((end - start) * rate + 2.0) * (columns + 1) as f64;
    if numbers > MAX_NUMBERS {
        let expected = format!("at most {MAX_NUMBERS:e} numbers at {rate} Hz");
        let found = format!("{numbers:.1e}");
        return Err(FileError::expected(file, "the path", expected, found));
    }
    let mut text = String::from("t");
    // Writing to memory cannot fail.
    match &groups {
        Some(groups) => (0..groups.len()).for_each(|group| {
            let _complete = write!(text, ",group_{group}");
        }),
        None => creases.iter().for_each(|edge| {
            let _complete = write!(text, ",edge_{edge}");
        }),
    }
    // The last row at the rate is left out if it is the end of the motion but for rounding. The start never is.
    let later = (1_u32..).map(|row| f64::from(row) / rate);
    let later = later.take_while(|time| time + 1e-6 / rate < end - start);
    let rows = (start < end).then_some(0.0).into_iter().chain(later);
    for time in rows.chain([end - start]) {
        let now = motion.at_times([start + time]);
        let _complete = write!(text, "\n{time}");
        let mut angle = |radians: f64| {
            let _complete = write!(text, ",{}", radians.to_degrees() + 0.0);
        };
        match &groups {
            Some(groups) => groups.nodes(&now, 0).for_each(|node| angle(node.angle)),
            None => creases
                .iter()
                .for_each(|&edge| angle(now.node(0, edge).angle)),
        }
    }
    text.push('\n');
    Ok(text)
}
