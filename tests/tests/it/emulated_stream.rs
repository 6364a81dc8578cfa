//! Does `foldpath stream --to qemu` work as a library? Streams a planned path to the controller's image. The emulator
//! must never outlive its host.

use std::fs;
use std::path::Path;

use crate::image::{image, turn};
use foldpath::export::traj::TrajFile;
use foldpath::planner::PlanOptions;
use foldpath::read::fold::read_motion;
use foldpath::stream::{
    Ending, Faulty, Link, Options, Outcome, Stands, StreamPath, Summary, Telemetry, Wish,
};
use foldpath_cli::link::Emulator;
use foldpath_core::follower::State;
use foldpath_core::trajectory_file::TrajectoryFile;
use foldpath_core::wire::key::Key;
use foldpath_firmware_sim::faults::Faults;
use foldpath_test_support::curve;
use foldpath_tests::Planned;

#[path = "../../../host/cli/tests/it/session.rs"]
pub(crate) mod session;

/// Returns the bytes of the `.traj` file of a planned Miura fold.
fn planned() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("path.fold");
    let planned = Planned::new("miura-11x11", &PlanOptions::default());
    fs::write(&file, planned.text()).unwrap();
    let path = read_motion(&file).unwrap();
    TrajFile::of(&path, &file).unwrap().bytes
}

/// Runs a session. Asserts that all telemetry lies on the path, bit by bit.
fn session(
    link: &mut impl Link,
    bytes: &[u8],
    host: (u32, bool),
    wish: &dyn Fn(&[Telemetry]) -> Wish,
) -> (Summary, Vec<Telemetry>) {
    let path = StreamPath::read(bytes, Path::new("path.traj")).unwrap();
    // In its first session an emulated board does not know where its hinges are.
    let (id, resume) = host;
    let options = Options::default().with(|it| {
        it.resume = resume;
        it.stands = if id == 1 {
            Stands::AtStart
        } else {
            Stands::Known
        };
        it.id = id;
        it.unattended = true;
    });
    let (summary, heard) = session::session(link, &path, options, wish);
    let file = TrajectoryFile::read(bytes).unwrap();
    for told in heard.iter().filter(|told| !told.angles.is_empty()) {
        let knot = told.place.knot as usize;
        let at = |group| match curve(&file, knot, group) {
            Some(curve) if told.place.into > 0.0 => {
                curve.angle(told.place.into / file.span(knot + 1).unwrap())
            }
            _ => file.node(knot, group).unwrap().angle,
        };
        let expected: Vec<u32> = (0..file.groups()).map(|g| at(g).to_bits()).collect();
        let found: Vec<u32> = told.angles.iter().map(|angle| angle.to_bits()).collect();
        assert_eq!(found, expected, "{told:?}");
    }
    (summary, heard)
}

/// Returns the identifiers of this process's children that run QEMU.
fn emulators() -> Vec<String> {
    let children = fs::read_dir("/proc/self/task").unwrap().flat_map(|thread| {
        let children = thread.unwrap().path().join("children");
        let text = fs::read_to_string(children).unwrap_or_default();
        text.split_whitespace()
            .map(String::from)
            .collect::<Vec<_>>()
    });
    let runs_qemu = |id: &String| {
        let name = fs::read_to_string(format!("/proc/{id}/comm")).unwrap_or_default();
        name.starts_with("qemu")
    };
    children.filter(runs_qemu).collect()
}

/// This is a single test so that no other test has emulators at the same time.
#[test]
fn a_board_follows_stops_goes_on_and_ends_with_its_host() {
    let (bytes, image) = (planned(), image("foldpath-mps2"));
    let _turn = turn();
    let faults = Faults {
        drop: 0.05,
        flip: 0.05,
        double: 0.05,
        ..Faults::default()
    };
    let mut board = Faulty::new(Emulator::start(&image, None).unwrap(), faults, 7);
    assert_eq!(emulators().len(), 1);
    let stop = |heard: &[Telemetry]| {
        let folds = heard.last().is_some_and(|told| told.place.knot >= 3);
        if folds { Wish::Stop } else { Wish::Run }
    };
    let (summary, heard) = session(&mut board, &bytes, (1, false), &stop);
    assert_eq!(summary.outcome, Outcome::Stopped, "{summary:?}");
    let stood = heard.last().unwrap().place;
    let (summary, heard) = session(&mut board, &bytes, (2, true), &|_| Wish::Run);
    assert_eq!(summary.outcome, Outcome::Done, "{summary:?}");
    let begin = heard
        .iter()
        .find(|told| told.state == State::Running)
        .unwrap();
    assert_eq!(begin.place.knot, stood.knot);
    assert!(begin.place.into >= stood.into && begin.place.into < stood.into + 0.05);
    assert!(summary.max_closure < 4e-6, "{summary:?}");
    drop(board);
    assert!(emulators().is_empty());

    // A board with a key follows the owner of the key alone.
    let key = Key::new(core::array::from_fn(|byte| u8::try_from(byte).unwrap()));
    let mut board = Emulator::start(&image, Some(key)).unwrap();
    for (id, key, outcome) in [(5, None, Outcome::NoDevice), (6, Some(key), Outcome::Done)] {
        let path = StreamPath::read(&bytes, Path::new("path.traj")).unwrap();
        let options = Options::default().with(|it| {
            it.stands = Stands::AtStart;
            it.id = id;
            it.key = key;
            it.unattended = true;
        });
        let (summary, _) = session::session(&mut board, &path, options, &|_| Wish::Run);
        assert_eq!(summary.outcome, outcome, "{summary:?}");
    }
    drop(board);

    let mut board = Emulator::start(&image, None).unwrap();
    let quit = |heard: &[Telemetry]| {
        let folds = heard.last().is_some_and(|told| told.place.knot >= 3);
        if folds { Wish::Quit } else { Wish::Run }
    };
    let (summary, heard) = session(&mut board, &bytes, (1, false), &quit);
    assert_eq!(summary.outcome, Outcome::Stopped, "{summary:?}");
    assert_eq!(summary.reason, Some(Ending::Quit { reported: true }));
    let braking = heard
        .iter()
        .rev()
        .take(20)
        .filter(|told| told.rate > 0.0 && told.rate < 1.0);
    assert_eq!(braking.count(), 0);
    let panics = std::panic::catch_unwind(move || {
        let _board = board;
        panic!("as in a bug");
    });
    assert!(panics.is_err());
    assert!(emulators().is_empty());

    // A file that is not an image runs, and says nothing.
    let folder = tempfile::tempdir().unwrap();
    let other = folder.path().join("other");
    fs::write(&other, [0; 64]).unwrap();
    let answer = Emulator::start(&other, None);
    let silent = answer.map(|mut board| session(&mut board, &bytes, (4, false), &|_| Wish::Run).0);
    assert!(silent.is_err() || silent.is_ok_and(|s| s.outcome == Outcome::NoDevice));
    assert!(emulators().is_empty());
}
