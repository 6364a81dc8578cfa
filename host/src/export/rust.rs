//! Writes Rust source: a path as constants for a controller without files. The source needs `foldpath-core` and no
//! `std`.

use core::fmt::{Display, Write};
use std::path::Path;

use foldpath_core::Interpolation;
use foldpath_core::trajectory_file::TrajectoryFile;

use super::traj::TrajFile;
use super::{Export, Made, Sink};
use crate::read::FileError;

/// Largest number of characters in a line of a list.
const MAX_LINE_CHARS: usize = 100;

/// Makes the file.
pub(super) fn made(export: &Export<'_>, sink: &mut Sink<'_>) -> Result<Made, FileError> {
    let motion = export.motion()?;
    let file = TrajFile::with(motion, export.name, export.options)?;
    let text = source(&file, &motion.title, export.name)?;
    sink("", text.into_bytes())?;
    Ok(Made {
        told: file.told(),
        notes: file
            .told_of_stuck_hinges(motion, export.options)
            .into_iter()
            .collect(),
    })
}

/// Formats the content of a `.traj` file as Rust constants; `title` goes into a comment.
///
/// # Errors
/// If the bytes are no valid trajectory file.
pub fn source(traj: &TrajFile, title: &str, file: &Path) -> Result<String, FileError> {
    let path = file.to_path_buf();
    let file = TrajectoryFile::read(&traj.bytes)
        .map_err(|source| FileError::Trajectory { path, source })?;
    let kind = match file.interpolation() {
        Interpolation::Linear => "Linear",
        Interpolation::Hermite => "Hermite",
        Interpolation::HalfAngle => "HalfAngle",
        Interpolation::Homogeneous => "Homogeneous",
    };
    let (groups, knots, hinges) = (traj.groups, traj.knots, traj.hinges);
    let nodes = || (0..knots).flat_map(|k| (0..groups).filter_map(move |g| file.node(k, g)));
    let weights = nodes().filter(|_| file.interpolation() == Interpolation::Homogeneous);
    let limits = (0..groups).filter_map(|g| file.limits(g));
    let ends = (1..).zip(file.spokes()).filter(|(_, (_, last))| *last);
    // A title may contain any character, but a comment must not contain a line break.
    let title = title.escape_debug();
    let mut text = format!(
        "// {title}: {knots} knots of {groups} groups, {hinges} hinges, {:.3} s. \
         Written by `foldpath export --to rust`.\n\n",
        traj.duration
    );
    let constants = [
        value("How the motion between knots is made", "INTERPOLATION", "foldpath_core::Interpolation",
            &format!("foldpath_core::Interpolation::{kind}")),
        value("Number of crease groups", "GROUPS", "usize", &groups),
        value("Largest closure residual of a commanded configuration", "CLOSURE", "f32", &number(file.closure())),
        value("Distance between a hinge and its command from which on the motion has to hold, radians", "MOST_LAG", "f32",
            &number(file.most_lag())),
        list("Seconds of the knots since the knot before, 0 at the first", "SPANS", "f32",
            (0..knots).filter_map(|k| file.span(k)).map(number)),
        list("Fold angles in radians, a row a knot", "ANGLES", "f32", nodes().map(|n| number(n.angle))),
        list("Their rates in radians per second", "RATES", "f32", nodes().map(|n| number(n.rate))),
        list("Weights and their rates, a row a knot; none unless the interpolation has them", "WEIGHTS", "[f32; 2]",
            weights.map(|n| pair(n.weight))),
        list("Limits of the groups", "LIMITS", "foldpath_core::GroupLimits", limits.map(|l| {
            let [lower, upper, speed, acceleration] =
                [l.lower, l.upper, l.speed, l.acceleration].map(number);
            format!("foldpath_core::GroupLimits {{ lower: {lower}, upper: {upper}, speed: {speed}, acceleration: {acceleration} }}")
        })),
        list("Group and sign of each hinge", "HINGES", "foldpath_core::Membership",
            file.memberships().map(|m| format!("hinge({}, {})", m.group.0, m.negative))),
        list("Spokes of the essential vertices", "SPOKES", "foldpath_core::Spoke<f32>",
            file.spokes().map(|(s, _)| format!("spoke({}, {}, {})", s.group.0, s.negative, pair(s.direction)))),
        list("Where the spokes of each vertex end", "ENDS", "u32", ends.map(|(end, _)| end.to_string())),
    ];
    text += &constants.concat();
    text.push('\n');
    text += FUNCTIONS;
    Ok(text)
}

/// A number may happen to be near π, for which clippy would suggest the constant.
const ALLOW: &str = "#[allow(clippy::approx_constant)]\n";

/// Constructors that keep the list entries short; unused if a path has no hinges or no vertices.
const FUNCTIONS: &str = "\
#[allow(dead_code)]
const fn hinge(group: u32, negative: bool) -> foldpath_core::Membership {
    foldpath_core::Membership { group: foldpath_core::GroupId(group), negative }
}

#[allow(dead_code)]
const fn spoke(group: u32, negative: bool, direction: [f32; 2]) -> foldpath_core::Spoke<f32> {
    foldpath_core::Spoke { group: foldpath_core::GroupId(group), negative, direction }
}
";

fn value(meaning: &str, name: &str, kind: &str, value: &impl Display) -> String {
    format!("/// {meaning}.\npub const {name}: {kind} = {value};\n")
}

/// Formats a constant list with as many entries in a line as fit.
fn list(meaning: &str, name: &str, kind: &str, entries: impl Iterator<Item = String>) -> String {
    let mut text = format!("/// {meaning}.\n{ALLOW}pub const {name}: &[{kind}] = &[");
    let mut column = MAX_LINE_CHARS;
    for entry in entries {
        if column + entry.len() + 2 > MAX_LINE_CHARS {
            text += "\n   ";
            column = 3;
        }
        column += entry.len() + 2;
        // Writing to memory cannot fail.
        let _complete = write!(text, " {entry},");
    }
    text += "\n];\n";
    text
}

/// Formats a literal that parses back to the same bits.
fn number(value: f32) -> String {
    if value.is_infinite() {
        "f32::INFINITY".into()
    } else {
        format!("{value:?}")
    }
}

fn pair(values: [f32; 2]) -> String {
    format!("[{}, {}]", number(values[0]), number(values[1]))
}
