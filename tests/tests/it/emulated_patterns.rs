//! Does the emulated board fold every pattern that plans, from start to end, and does it command what the same code
//! commands on this machine, bit by bit? `tests/run full` folds them all on a Cortex-M4F, and one on a Cortex-M7.

use std::fs;
use std::path::Path;
use std::time::Instant;

use foldpath::export::fold::motion_text;
use foldpath::export::traj::TrajFile;
use foldpath::planner::{Outcome, PlanOptions};
use foldpath::read::read_pattern;
use foldpath::stream::StreamPath;
use foldpath_core::acceptance::{Setpoint, SheetView};
use foldpath_core::follower::{CheckedOptions, Follower, FollowerPosition};
use foldpath_core::trajectory_file::TrajectoryFile;
use foldpath_core::wire::driver::Persistence;
use foldpath_tests::{Planned, path_file, pattern_file};

use crate::image::board::Board;
use crate::image::rig::{IMAGE, Rig, Told};
use crate::image::{image, turn};

/// Most groups of a pattern here: the image's.
const GROUPS: usize = 256;

/// The names of all patterns, in order.
fn names() -> Vec<String> {
    let folder = pattern_file("miura-3x3").parent().unwrap().to_owned();
    let files = fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().path());
    let patterns = files.filter(|file| file.extension().is_some_and(|end| end == "fold"));
    let mut names: Vec<_> = patterns
        .map(|file| file.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    names.sort();
    names
}

/// Returns the bytes of the `.traj` file of the plan of a pattern, as `plan` and `export --to traj` make it; `None` if it
/// has no plan that reaches the goal.
fn planned(name: &str) -> Option<Vec<u8>> {
    let file = read_pattern(&pattern_file(name)).unwrap();
    let planned = Planned::of(file, &PlanOptions::default());
    if planned.plan.outcome != Outcome::Planned {
        return None;
    }
    let path = path_file(&motion_text(planned.plan.motion.as_ref()?)).unwrap();
    Some(TrajFile::of(&path, Path::new("path.fold")).unwrap().bytes)
}

/// Returns the angles that the follower on this machine commands at a place.
fn follow(path: &StreamPath, file: &TrajectoryFile<'_>, place: FollowerPosition<f32>) -> Vec<f32> {
    let sheet = SheetView {
        interpolation: file.interpolation(),
        limits: path.limits(),
        stars: path.stars().unwrap(),
        closure: path.closure(),
    };
    let mut follower = Box::new(Follower::<f32, GROUPS, 2>::new(CheckedOptions::default()));
    follower.load(&sheet, place).unwrap();
    for knot in (place.knot as usize..file.len()).take(2) {
        let nodes = (0..file.groups()).map(|group| file.node(knot, group).unwrap());
        let setpoint = Setpoint {
            number: u32::try_from(knot).unwrap(),
            span: file.span(knot).unwrap(),
            last: knot + 1 == file.len(),
            nodes: nodes.collect(),
        };
        follower.accept(&sheet, setpoint).unwrap();
    }
    follower.confirm().unwrap();
    follower.start().unwrap();
    follower.angles().to_vec()
}

/// Folds a path on an emulated board, and compares all that it tells with this machine. Returns what it told.
fn fold(machine: &str, name: &str, bytes: &[u8], nonce: u64) -> Vec<Told> {
    let path = StreamPath::read(bytes, Path::new(name)).unwrap();
    let file = TrajectoryFile::read(bytes).unwrap();
    let start = Instant::now();
    let mut rig = Rig::new(Board::fast(machine, IMAGE, nonce, false));
    // Resumes if the time of this machine stood still for so long that the board took its host for gone.
    rig.greet(path.items().unwrap(), Persistence::Always, true);
    rig.finish();
    let took = start.elapsed();
    let told: Vec<_> = rig
        .told
        .iter()
        .filter(|told| !told.angles.is_empty())
        .cloned()
        .collect();
    for told in &told {
        let bits = |angles: &[f32]| {
            angles
                .iter()
                .map(|angle| angle.to_bits())
                .collect::<Vec<_>>()
        };
        let expected = follow(&path, &file, told.place);
        assert_eq!(
            bits(&told.angles),
            bits(&expected),
            "{name} {:?}",
            told.place
        );
        assert!(
            path.residual(&told.angles) <= path.closure().into(),
            "{name} {:?}",
            told.place
        );
    }
    let last = told.last().unwrap();
    assert_eq!(last.place.knot as usize + 1, file.len(), "{name}");
    println!(
        "{name}: {} groups, {} hinges, {} knots, {:.1} s, told {} times, {:.1} s of this machine",
        file.groups(),
        file.hinges(),
        file.len(),
        path.times().last().unwrap(),
        told.len(),
        took.as_secs_f64()
    );
    // Telemetry comes every 20 ms.
    let moments = path.times().last().unwrap() / 0.02;
    assert!(told.len() as f64 > 0.5 * moments, "{name}: {}", told.len());
    told
}

#[test]
#[ignore = "takes half a minute: `tests/run full` runs it"]
fn every_pattern_that_plans_folds_on_the_board_with_the_bits_of_the_host() {
    image(IMAGE);
    let paths: Vec<_> = names()
        .into_iter()
        .filter_map(|name| planned(&name).map(|bytes| (name, bytes)))
        .collect();
    let _turn = turn();
    let mut most = 0;
    for (nonce, (name, bytes)) in (1..).zip(&paths) {
        let told = fold("mps2-an386", name, bytes, nonce);
        most = most.max(told[0].angles.len());
        if name == "waterbomb-4x6" {
            // A Cortex-M7 commands the same bits.
            fold("mps2-an500", name, bytes, 100 + nonce);
        }
    }
    // Resch's pattern is planned with each crease on its own.
    assert!(most == 94 && paths.len() == 11, "{most} {}", paths.len());
}
