//! Patterns of files, drawn differently: the files of `patterns/`, and real ones if the environment variable
//! FOLDPATH_EXTERNAL_PATTERNS names a folder of them.

use std::fs::read_dir;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge};
use foldpath::planner::Goal;
use foldpath::read::read_pattern;
use nalgebra::Rotation2;

use super::variant;
use crate::Random;

/// Largest number of creases of a pattern that is used.
const LARGEST: usize = 400;

static FILES: LazyLock<Vec<(String, Drawing)>> = LazyLock::new(|| {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../patterns");
    let real = std::env::var_os("FOLDPATH_EXTERNAL_PATTERNS").map(PathBuf::from);
    let mut files = files(&own);
    files.extend(real.iter().flat_map(|folder| files_below(folder)));
    files
        .iter()
        .filter_map(|file| {
            Some((
                file.file_name()?.to_string_lossy().into_owned(),
                drawing(file)?,
            ))
        })
        .collect()
});

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let folders = entries(folder).into_iter().filter(|entry| entry.is_dir());
    folders.flat_map(|folder| files(&folder)).collect()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let pattern = |file: &PathBuf| {
        let ending = file.extension().and_then(|ending| ending.to_str());
        ending.is_some_and(|ending| ["fold", "svg", "cp"].contains(&ending))
    };
    entries(folder).into_iter().filter(pattern).collect()
}

/// Returns the entries of a folder, sorted by name.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = read_dir(folder).into_iter().flatten().flatten();
    let mut entries: Vec<_> = entries.map(|entry| entry.path()).collect();
    entries.sort();
    entries
}

/// Returns the pattern of a file if the oracle can judge it: one sheet of convex faces, with a goal.
fn drawing(file: &Path) -> Option<Drawing> {
    let pattern = read_pattern(file).ok()?.pattern;
    let fits = pattern.sheets() == 1
        && pattern.creases().len() <= LARGEST
        && convex(&pattern)
        && Goal::of_pattern(&pattern).is_ok();
    let edges = pattern.edges().iter().map(|edge| DrawnEdge {
        ends: edge.ends.map(|end| end.index()),
        letter: edge.letter,
        goal: edge.goal,
    });
    let drawing = Drawing {
        vertices: pattern.vertices().to_vec(),
        edges: edges.collect(),
        faces: None,
    };
    // Cuts part a sheet into vertices at the same point, which cannot be drawn again.
    let again = CreasePattern::new(drawing.clone()).is_ok();
    (fits && again).then_some(drawing)
}

/// Returns `true` if no face has a reflex corner.
pub(super) fn convex(pattern: &CreasePattern) -> bool {
    let at = pattern.vertices();
    pattern.faces().iter().all(|face| {
        let corners: Vec<_> = face.iter().map(|v| at[v.index()]).collect();
        let n = corners.len();
        (0..n).all(|k| {
            let [a, b, c] = [corners[k], corners[(k + 1) % n], corners[(k + 2) % n]];
            (b - a).perp(&(c - b)) >= -1e-9 * (b - a).norm() * (c - b).norm()
        })
    })
}

/// Returns the pattern of a random file: in half of all cases only rotated, else drawn differently in every way.
#[must_use]
pub fn file(random: &mut Random) -> Drawing {
    named_file(random).1
}

/// Returns such a pattern with the name of its file.
#[must_use]
pub fn named_file(random: &mut Random) -> (String, Drawing) {
    let (name, mut drawing) = FILES[random.whole(0, FILES.len() - 1)].clone();
    if random.chance(0.5) {
        return (name, variant(&drawing, random));
    }
    let turn = Rotation2::new(random.uniform(0.0, core::f64::consts::TAU));
    for place in &mut drawing.vertices {
        *place = turn * *place;
    }
    (name, drawing)
}
