//! Writes Wavefront OBJ sequences: one file for each shape of a path, for renderers that load a sequence of meshes.

use core::fmt::Write;
use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use crate::folding::shapes;
use crate::motion::Motion;

/// Returns the name of file `index` of a sequence called `output`: `fold.obj` gives `fold-0000.obj`, `fold-0001.obj`
/// and so on beside `output`; a folder gives `frame-0000.obj` and so on inside it.
#[must_use]
pub fn frame_path(output: &Path, folder: bool, index: usize) -> PathBuf {
    if folder {
        return output.join(format!("frame-{index:04}.obj"));
    }
    let is_obj = |ending: &std::ffi::OsStr| ending.eq_ignore_ascii_case("obj");
    let stem = if output.extension().is_some_and(is_obj) {
        output.file_stem()
    } else {
        output.file_name()
    };
    let mut name = stem.unwrap_or_default().to_os_string();
    name.push(format!("-{index:04}.obj"));
    output.with_file_name(name)
}

/// Returns the name and content of each file of a sequence, one file for the shape at each knot of the path.
pub fn files(
    motion: &Motion,
    output: &Path,
    folder: bool,
) -> impl Iterator<Item = (PathBuf, Vec<u8>)> {
    let frames = motion.knots.iter().zip(shapes(motion)).enumerate();
    frames.map(move |(index, (knot, shape))| {
        let text = frame_text(motion, knot.time, &shape);
        (frame_path(output, folder, index), text.into_bytes())
    })
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
