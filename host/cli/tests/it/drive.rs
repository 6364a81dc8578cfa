//! Tests of commissioning: hinges are watched and moved one by one, and the map is written.

use core::cell::Cell;
use core::fmt::Debug;
use core::time::Duration;
use std::path::Path;
use std::process::Stdio;
use std::thread::sleep;
use std::time::Instant;

use crate::common::folder;
use crate::stream::served;
use crate::ways::small;
use foldpath::stream::{Bench, BenchError, Channels, Jogged, Link, Options, Sim, Stands, Way};
use foldpath_core::follower::{Denial, State};
use serde_json::{Value, json};

fn lines(text: &str) -> Vec<Value> {
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

fn near(value: &Value, degrees: f64) -> bool {
    value
        .as_f64()
        .is_some_and(|value| (value - degrees).abs() < 1e-4)
}

/// Limits that were typed count at once, in the angles that the map has now, although the board has others.
#[test]
fn limits_that_were_typed_count_at_once() {
    let folder = folder();
    // From 10 degrees of the controller on, the hinge is at 0 of the map. With the other sign, -15 are 25 of the map.
    let begin = "drive --to sim --map map.csv --json channel 0 7 jog 0 to 10 zero 0 limits 0 -30 20 jog 0 to 25";
    for (ending, found) in [
        ("jog 0 to 31", Some("21.000")),
        ("jog 0 by 6", Some("21.000")),
        ("jog 0 by -56", Some("-41.000")),
        ("sign 0 - jog 0 to -15", Some("25.000")),
        ("jog 0 by 4.9 jog 0 to -19", None),
        ("sign 0 - jog 0 to -9.9 jog 0 to 39", None),
    ] {
        let answer = folder.run(&format!("{begin} {ending}"));
        let told = lines(&answer.stdout);
        let last = told.last().unwrap();
        std::fs::remove_file(folder.path("map.csv")).unwrap_or_default();
        let Some(found) = found else {
            assert_eq!(last["outcome"], "done", "{ending}: {last}");
            continue;
        };
        let why = format!(
            "hinge 0: expected an angle within its limits in the map, -30.000 to 20.000 degrees, found {found}"
        );
        assert_eq!(
            (&last["outcome"], &last["message"]),
            (&"denied".into(), &why.into())
        );
    }
}

#[test]
fn a_map_is_made_hinge_by_hinge() {
    let folder = folder();
    let commands = "channel 0 7 channel 1 3 jog 0 to 10 zero 0 jog 1 by -20 zero 1 sign 1 - limits 1 -90 45.5 show";
    let answer = folder.done(&format!("drive --to sim --map map.csv --json {commands}"));
    let told = lines(&answer.stdout);
    assert_eq!(told.len(), 9, "{}", answer.stdout);
    assert!(
        told.iter().all(|line| line["outcome"] == "done"),
        "{}",
        answer.stdout
    );
    assert_eq!(told[2]["command"], "jog 0 to 10");
    assert!(
        near(&told[2]["commanded"], 10.0) && near(&told[2]["measured"], 10.0),
        "{}",
        told[2]
    );
    assert!(near(&told[3]["channels"][0]["zero"], 10.0), "{}", told[3]);
    assert!(near(&told[4]["measured"], -20.0));
    // The map is written at the end, without `save`.
    let map = Channels::parse(&folder.read("map.csv"), Path::new("map.csv")).unwrap();
    let [first, second] = [0, 1].map(|hinge| map.get(hinge).unwrap());
    assert_eq!((first.channel, first.negative), (7, false));
    assert!((first.zero - 10_f32.to_radians()).abs() < 1e-6);
    assert_eq!((second.channel, second.negative), (3, true));
    assert!((second.zero + 20_f32.to_radians()).abs() < 1e-6);
    assert!((second.lower + 90_f32.to_radians()).abs() < 1e-6);
    assert!((second.upper - 45.5_f32.to_radians()).abs() < 1e-6);

    // Hinges that are not named stay, and so do comments.
    let text = folder.read("map.csv").replace("\n1,", "\n# the second\n1,");
    folder.write("map.csv", &text);
    folder.done("drive --to sim --map map.csv channel 0 8");
    assert_eq!(folder.read("map.csv"), text.replace("0,7,", "0,8,"));
    // The controller runs with the map as it was read: a zero counts from there, however often it is set.
    let commands = "watch 0 zero 0 zero 0 jog 0 to 5 zero 0 show";
    let answer = folder.done(&format!("drive --to sim --map map.csv {commands}"));
    let zeros = ["zero 10.000", "zero 10.000", "zero 15.000", "zero 15.000"];
    let mut rest = answer.stdout.as_str();
    for zero in zeros {
        rest = &rest[rest
            .find(zero)
            .unwrap_or_else(|| panic!("{zero}: {}", answer.stdout))
            + 1..];
    }
}

#[test]
fn lines_on_stdin_are_commands_and_only_save_writes() {
    let folder = folder();
    let said = b"# no command\n";
    let answer = folder.run_with("drive --to sim", said).with_status(2);
    assert!(
        answer.begins("expected a command (watch, jog, "),
        "{answer:?}"
    );
    let answer = folder.run_with("drive --to sim --map map.csv", b"channel 2 5\nquit\nsave\n");
    let answer = answer.with_status(0);
    assert!(
        answer.stderr.contains("changes of the map were not saved"),
        "{answer:?}"
    );
    assert!(!folder.names().contains(&"map.csv".into()));
    let answer = folder.run_with(
        "drive --to sim --map map.csv",
        b"channel 2 5\n\n save\nhelp\n",
    );
    let answer = answer.with_status(0);
    assert!(
        answer
            .stdout
            .contains("1 hinges written to map.csv; hinge 0 has no channel yet"),
        "{answer:?}"
    );
    assert!(answer.stdout.contains("jog HINGE to|by DEGREES"));
    assert!(
        folder
            .read("map.csv")
            .ends_with("\n2,5,0,+,-3.1415927,3.1415927\n")
    );
    // A command that is not done ends a script, and nothing is written.
    let before = folder.read("map.csv");
    let answer = folder
        .run("drive --to sim --map map.csv channel 3 6 channel 4 6 channel 5 9")
        .with_status(1);
    assert!(
        answer
            .stdout
            .contains("channel 4 6: denied: channel 6 is that of hinge 3"),
        "{answer:?}"
    );
    assert!(
        answer.stderr.contains("the map was not written"),
        "{answer:?}"
    );
    assert_eq!(folder.read("map.csv"), before);
    for (command, message) in [
        ("zero 7", "the map has no hinge 7; `channel 7 CHANNEL`"),
        ("save", "no map to write; start with --map FILE"),
        ("jog 40000 to 0", "expected a hinge below 16384"),
        (
            "jog 3 to 200",
            "expected a hinge below 16384, and an angle within the limits",
        ),
    ] {
        let answer = folder
            .run(&format!("drive --to sim {command}"))
            .with_status(1);
        assert!(answer.stdout.contains(message), "{command}: {answer:?}");
    }
    let answer = folder
        .run("drive --to tcp:1 --insecure --json watch 3")
        .with_status(1);
    assert_eq!(answer.json()["outcome"], "no_device", "{answer:?}");
}

/// The Rust source is written with the map, once the map has all hinges.
#[test]
fn a_board_is_built_with_the_map() {
    let folder = folder();
    let drive = "drive --to sim --map map.csv --rust channels.rs";
    let answer = folder.run(&format!("{drive} channel 1 5")).with_status(1);
    let why = "1 hinges written to map.csv; hinge 0 has no channel yet, and a board needs one for each hinge; \
               channels.rs was not written";
    assert!(answer.stderr.contains(why), "{answer:?}");
    assert!(!folder.names().contains(&"channels.rs".into()));
    let answer = folder.done(&format!("{drive} channel 0 7 limits 0 -180 90 save"));
    assert!(
        answer
            .stdout
            .contains("2 hinges written to map.csv and channels.rs"),
        "{answer:?}"
    );
    let source = folder.read("channels.rs") + "fn main() { println!(\"{CHANNELS:?}\"); }\n";
    // The compiler reads what the map means. The type stands in for that of the controller, which this test has not built.
    let channel = "mod foldpath_controller { #[derive(Debug)] #[allow(dead_code)] pub struct Channel { pub channel: u16, \
                   pub zero: f32, pub negative: bool, pub lower: f32, pub upper: f32 } }\n";
    folder.write("main.rs", &(channel.to_owned() + &source));
    let compiled = std::process::Command::new("rustc")
        .args(["--edition", "2024", "main.rs"])
        .current_dir(folder.path(""))
        .output()
        .unwrap();
    assert!(compiled.status.success(), "{compiled:?}");
    let told = std::process::Command::new(folder.path("main"))
        .output()
        .unwrap();
    let map = Channels::parse(&folder.read("map.csv"), Path::new("map.csv")).unwrap();
    let channels: Vec<_> = [0, 1].map(|hinge| map.get(hinge).unwrap()).into();
    assert_eq!(
        String::from_utf8(told.stdout).unwrap(),
        format!("{channels:?}\n")
    );
}

fn denied<T: Debug>(result: Result<T, BenchError>) -> (Denial, Option<State>) {
    match result {
        Err(BenchError::Denied { denial, state, .. }) => (denial, state),
        other => panic!("{other:?}"),
    }
}

fn turn(bench: &mut Bench<&mut Sim>, hinge: u16, degrees: f32) -> Jogged {
    bench
        .jog(hinge, None, Way::To(degrees.to_radians()), &|| false)
        .unwrap()
}

/// A hinge moves by 0.1 rad/s, and holds when it is asked.
#[test]
fn a_jog_is_slow_and_is_held() {
    let mut sim = Sim::bench();
    let mut bench = Bench::open(&mut sim, None, 7, 0).unwrap();
    let Jogged::There(seen) = turn(&mut bench, 5, 10.0) else {
        panic!("not there");
    };
    assert_eq!(
        seen.commanded.map(f32::to_bits),
        Some(10_f32.to_radians().to_bits())
    );
    let took = sim.now() as f64 / 1e6;
    let way = f64::from(10_f32.to_radians()) / 0.1;
    assert!((way..way + 1.0).contains(&took), "{took} {way}");
    let mut bench = Bench::open(&mut sim, None, 8, 0).unwrap();
    let asked = Cell::new(0);
    let stops = || {
        asked.set(asked.get() + 1);
        asked.get() > 2000
    };
    let held = bench.jog(5, None, Way::To(0.0), &stops).unwrap();
    let Jogged::Held(seen) = held else {
        panic!("{held:?}");
    };
    let held = seen.angle().unwrap().to_degrees();
    assert!((5.0..9.5).contains(&held), "{held}");
    for _ in 0..2000 {
        bench.round().unwrap();
    }
    assert_eq!(bench.watch(5).unwrap(), seen);
}

/// A sheet that hangs on the board is not torn by accident.
#[test]
fn a_hinge_of_a_sheet_that_is_known_moves_only_once_that_is_forgotten() {
    let path = crate::ways::read(&small(), "path.traj");
    let mut sim = Sim::bench();
    let options = Options::default().with(|it| {
        it.id = 1;
        it.stands = Stands::AtStart;
    });
    let (summary, _) =
        crate::session::session(&mut sim, &path, options, &|_| foldpath::stream::Wish::Run);
    assert_eq!(
        summary.outcome,
        foldpath::stream::Outcome::Done,
        "{summary:?}"
    );
    // Exact sensors: the largest lag is that of rounding.
    assert!(
        summary.lag.is_some_and(|lag| lag.angle < 1e-3),
        "{summary:?}"
    );
    let mut bench = Bench::open(&mut sim, None, 9, 0).unwrap();
    let reason = denied(bench.watch(3));
    assert_eq!(reason, (Denial::State, Some(State::Done)));
    bench.clear().unwrap();
    let there = turn(&mut bench, 3, 5.0);
    assert!(matches!(there, Jogged::There(_)), "{there:?}");
    assert_eq!(sim.device().follower().state(), State::Idle);
    assert!(!sim.device().follower().is_known());
}

#[test]
fn the_stop_line_ends_a_jog_until_it_is_let_go() {
    let mut sim = Sim::bench();
    sim.stop().unwrap();
    let mut bench = Bench::open(&mut sim, None, 9, 0).unwrap();
    let reason = denied(bench.jog(3, None, Way::By(0.1), &|| false));
    assert_eq!(reason.0, Denial::Held);
    assert_eq!(denied(bench.clear()).0, Denial::Held);
}

/// A controller behind TCP that measures nothing, in real time: what is not known is not moved, and Ctrl-C holds.
#[test]
#[cfg(unix)]
fn a_hinge_without_a_sensor_needs_a_word_and_ctrl_c_holds_it() {
    let folder = folder();
    let (port, _, thread) = served(
        2,
        |_| false,
        |device| device.follower_mut().forget().unwrap(),
    );
    let drive = format!("drive --to tcp:{port} --insecure --json");
    let answer = folder.run(&format!("{drive} jog 3 by 5")).with_status(1);
    assert!(
        answer.json()["message"]
            .as_str()
            .unwrap()
            .contains("add `from DEGREES`"),
        "{answer:?}"
    );
    let host = folder.command(&format!("{drive} jog 3 to 60 from 0"));
    let mut host = host;
    let host = host
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    // The hinge needs ten seconds.
    while begun.elapsed() < Duration::from_secs(2) {
        sleep(Duration::from_millis(10));
    }
    let id = host.id().to_string();
    assert!(
        std::process::Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap()
            .success()
    );
    let output = host.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let line: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&line["outcome"], &line["measured"]),
        (&json!("held"), &Value::Null),
        "{line}"
    );
    let held = line["commanded"].as_f64().unwrap();
    assert!(held > 0.0 && held < 60.0, "{line}");
    thread.join().unwrap();
}
