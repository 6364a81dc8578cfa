//! Writes Wavefront OBJ sequences: one file for each shape of a path, for renderers that load a sequence of meshes.

use core::fmt::Write;

use nalgebra::Vector3;

use super::{Export, Made, Sink};
use crate::folding::shapes;
use crate::motion::Motion;
use crate::read::FileError;

/// Makes a file for the shape at each frame, or at each knot if no number of frames is given.
pub(super) fn made(export: &Export<'_>, sink: &mut Sink<'_>) -> Result<Made, FileError> {
    let resampled = export.resampled()?;
    let motion = resampled.as_ref().map_or_else(|| export.motion(), Ok)?;
    for (index, (knot, shape)) in motion.knots.iter().zip(shapes(motion)).enumerate() {
        let text = frame_text(motion, knot.time, &shape);
        sink(&format!("{index:04}"), text.into_bytes())?;
    }
    let (frames, faces) = (motion.knots.len(), motion.pattern.faces().len());
    Ok(Made::told(format!("{frames} frames, {faces} faces")))
}

/// Formats one shape of the sheet: its vertices in the order and units of the pattern, and its faces as polygons,
/// counter-clockwise seen from the front of the paper.
fn frame_text(motion: &Motion, time: f64, shape: &[Vector3<f64>]) -> String {
    // A title may contain any character, but a comment must not contain a line break.
    let mut text = format!("# {}, {time} s\n", motion.title.escape_debug());
    // Writing to memory cannot fail.
    for p in shape {
        let _complete = writeln!(text, "v {} {} {}", p.x + 0.0, p.y + 0.0, p.z + 0.0);
    }
    for face in motion.pattern.faces().iter() {
        text.push('f');
        for vertex in face {
            let _complete = write!(text, " {}", vertex.index() + 1);
        }
        text.push('\n');
    }
    text
}
