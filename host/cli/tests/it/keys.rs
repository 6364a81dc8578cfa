//! Tests of keys: a controller that has one is moved by nobody else.

use foldpath::stream::{Ending, Options, Outcome, Pairing, Sim, StreamPath, Wish, pair};
use foldpath_core::wire::key::Key;
use foldpath_core::wire::sender::Failure;
use foldpath_test_support::Folder;

use crate::common::folder_with_path;
use crate::session;

const KEY: Key = Key::new([0x5a; Key::SIZE]);
const OTHER: Key = Key::new([0x5b; Key::SIZE]);

/// Returns a folder with a path for controllers.
fn folder() -> Folder {
    let folder = folder_with_path();
    folder.done("export path.fold --to traj -o path.traj");
    folder
}

#[test]
fn a_controller_that_was_paired_is_moved_by_nobody_else() {
    let folder = folder();
    let path = StreamPath::read(
        &std::fs::read(folder.path("path.traj")).unwrap(),
        &folder.path("path.traj"),
    )
    .unwrap();
    let mut sim = Sim::new();
    let stream = |sim: &mut Sim, id, key| {
        let options = Options::default().with(|it| {
            it.id = id;
            it.key = key;
        });
        session::session(sim, &path, options, &|_| Wish::Run).0
    };
    assert_eq!(pair(&mut sim, KEY, 1).unwrap(), Pairing::Paired);
    // A controller that is paired again keeps its key.
    assert_eq!(pair(&mut sim, KEY, 1 << 40).unwrap(), Pairing::Paired);
    assert_eq!(pair(&mut sim, OTHER, 2 << 40).unwrap(), Pairing::NoDevice);
    for key in [None, Some(OTHER)] {
        let summary = stream(&mut sim, 100, key);
        assert_eq!(summary.outcome, Outcome::NoDevice, "{summary:?}");
        let reason = Ending::NoSession(Failure::NoAnswer);
        assert_eq!(summary.reason, Some(reason));
        assert_eq!(summary.setpoints, 0);
    }
    assert_eq!(stream(&mut sim, 102, Some(KEY)).outcome, Outcome::Done);
}

#[test]
fn a_key_is_made_once_and_kept_from_others() {
    let folder = folder();
    let answer = folder.done("pair --to sim --key lab.key");
    assert!(answer.stdout.contains("lab.key, made"), "{answer:?}");
    let text = folder.read("lab.key");
    assert_eq!(text.len(), 33);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = std::fs::metadata(folder.path("lab.key")).unwrap();
        assert_eq!(mode.permissions().mode() & 0o777, 0o600);
    }
    let answer = folder.done("pair --to sim --key lab.key");
    assert!(!answer.stdout.contains("made"), "{answer:?}");
    assert_eq!(folder.read("lab.key"), text);
    folder.done("pair --to sim --key other.key");
    assert_ne!(folder.read("other.key"), text);

    let plain = folder.done("stream path.traj --to sim --json").json();
    let keyed = folder.done("stream path.traj --to sim --json --key lab.key");
    let keyed = keyed.json();
    assert_eq!(keyed["outcome"], "done");
    assert!(keyed["bytes_sent"].as_u64() > plain["bytes_sent"].as_u64());
    // Frames with tags take longer, so that telemetry tells other moments of the same motion.
    for answer in [&keyed, &plain] {
        let closure = answer["max_closure"].as_f64().unwrap();
        assert!(closure > 0.0 && closure < 1e-6, "{answer}");
        assert_eq!(answer["setpoints"], plain["setpoints"]);
    }
}

#[test]
fn a_key_is_32_digits() {
    let folder = folder();
    let digits = "0123456789abcdefABCDEF0123456789";
    folder.write("good.key", &format!("  {digits}\r\n"));
    folder.done("stream path.traj --to sim --key good.key");
    for (place, wrong) in [
        &digits[1..],
        &format!("{digits}0"),
        &format!("+{}", &digits[1..]),
        &format!("{}g", &digits[1..]),
        "",
    ]
    .iter()
    .enumerate()
    {
        let name = format!("wrong{place}.key");
        folder.write(&name, wrong);
        for command in ["stream path.traj", "pair"] {
            let answer = folder
                .run(&format!("{command} --to sim --key {name}"))
                .with_status(2);
            assert!(
                answer.stderr.contains("expected 32 hexadecimal digits"),
                "{answer:?}"
            );
        }
    }
}
