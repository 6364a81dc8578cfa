//! Tests the results of the commands, and how runs end.

use core::time::Duration;
use std::fs::{self, File};
use std::process::Command;
use std::time::Instant;

use crate::common::{PATTERNS, folder, folder_with_path};
use serde_json::{Value, json};

#[test]
fn a_pattern_goes_from_generate_to_view() {
    for family in [
        "miura --rows 4 --cols 5",
        "waterbomb --rows 4 --cols 6",
        "yoshimura --rows 4 --cols 4",
        "square-twist",
    ] {
        let folder = folder();
        let steps = [
            (format!("generate {family} -o a.fold"), "written to a.fold"),
            ("info a.fold".into(), "closes"),
            ("plan a.fold -o path.fold".into(), "planned"),
            ("check path.fold".into(), "holds"),
            ("view path.fold -o path.html".into(), "written to path.html"),
        ];
        for (arguments, says) in steps {
            let answer = folder.done(&arguments);
            assert!(
                answer.stdout.contains(says),
                "{arguments}: {}",
                answer.stdout
            );
            assert_eq!(answer.stderr, "", "{arguments}");
        }
        assert_eq!(folder.names(), ["a.fold", "path.fold", "path.html"]);
        assert!(folder.read("path.html").starts_with("<!doctype html>"));
    }
}

/// `cargo run` at the root, as the README has it, names no program: only one of the default packages may have one.
#[test]
fn cargo_run_means_this_command() {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["metadata", "--no-deps", "--locked", "--format-version", "1"]);
    let output = cargo.output().unwrap();
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let default_members = metadata["workspace_default_members"].as_array().unwrap();
    let packages = metadata["packages"].as_array().unwrap().iter();
    let default_packages = packages.filter(|package| default_members.contains(&package["id"]));
    let targets = default_packages.flat_map(|package| package["targets"].as_array().unwrap());
    let programs = targets.filter(|target| target["kind"] == json!(["bin"]));
    let names: Vec<&Value> = programs.map(|program| &program["name"]).collect();
    assert_eq!(names, [&json!("foldpath")]);
}

#[test]
fn sizes_are_those_of_the_report() {
    // family, rows, columns, creases, real vertices, virtual edges, groups, essential vertices
    let cases = [
        ("miura", 3, 3, 12, 4, 9, 2, 1),
        ("miura", 5, 7, 4 * 7 + 5 * 6, 4 * 6, 35, 2, 1),
        ("miura", 11, 11, 220, 100, 121, 2, 1),
        ("miura", 24, 24, 1104, 529, 576, 2, 1),
        ("waterbomb", 4, 6, 50, 15, 12, 4, 3),
        ("waterbomb", 8, 10, 182, 63, 40, 4, 3),
        ("waterbomb", 12, 22, 626, 231, 758 - 626, 4, 3),
    ];
    let folder = folder();
    for (family, rows, columns, creases, real, virtual_edges, groups, essential) in cases {
        let case = format!("{family} --rows {rows} --cols {columns}");
        folder.done(&format!("generate {case} -o a.fold"));
        let info = folder.done("info a.fold --json").json();
        let expected = json!([creases, real, virtual_edges, groups, essential]);
        let keys = [
            "creases",
            "real_vertices",
            "virtual_edges",
            "groups",
            "essential_vertices",
        ];
        assert_eq!(json!(keys.map(|key| &info[key])), expected, "{case}");
        let points = (rows + 1) * (columns + 1);
        assert_eq!(info["vertices"], points, "{case}");
        assert_eq!(info["virtual_vertices"], points - real, "{case}");
        assert_eq!(info["edges"], creases + 2 * (rows + columns), "{case}");
        assert!(info["closure_goal"].as_f64().unwrap() < 1e-12, "{case}");

        let plan = folder.done("plan a.fold --json").json();
        let expected = json!([creases, real, groups, essential, groups]);
        let keys = [
            "creases",
            "real_vertices",
            "groups",
            "essential_vertices",
            "unknowns",
        ];
        assert_eq!(json!(keys.map(|key| &plan[key])), expected, "{case}");
    }
}

#[test]
fn two_runs_write_the_same_bytes() {
    let folder = folder();
    for command in [
        "generate waterbomb --rows 6 --cols 8 -o",
        "plan first.fold -o",
        "plan first.fold --symmetry off -o",
        "plan first.fold --solver gradient -o",
    ] {
        folder.done(&format!("{command} a.fold"));
        folder.done(&format!("{command} b.fold"));
        assert_eq!(folder.read("a.fold"), folder.read("b.fold"), "{command}");
        if !folder.path("first.fold").exists() {
            fs::rename(folder.path("a.fold"), folder.path("first.fold")).unwrap();
        }
    }
}

#[test]
fn a_plan_that_fails_writes_nothing() {
    let folder = folder_with_path();
    let crossing = format!("{PATTERNS}/waterbomb-12x22-crossing.fold");
    for (arguments, outcome) in [
        (format!("plan {crossing}"), "crossing"),
        ("plan miura.fold --timeout 0".into(), "timeout"),
        (
            "plan miura.fold --bound 1e-99".into(),
            "not_rigidly_foldable",
        ),
    ] {
        folder.write("kept.fold", "as it was");
        let before = folder.names();
        for output in ["new.fold", "kept.fold"] {
            let answer = folder
                .run(&format!("{arguments} -o {output}"))
                .with_status(1);
            assert!(answer.stdout.contains(outcome), "{answer:?}");
            assert!(answer.stdout.contains("nothing written"), "{answer:?}");
        }
        assert_eq!(folder.names(), before, "{arguments}");
        assert_eq!(folder.read("kept.fold"), "as it was", "{arguments}");
    }
}

#[test]
fn a_crossing_is_found_where_the_faces_meet() {
    let folder = folder();
    let pattern = format!("{PATTERNS}/waterbomb-12x22-crossing.fold");
    let plan = folder
        .run(&format!("plan {pattern} --bound 1e-6 --json"))
        .with_status(1)
        .json();
    assert_eq!(plan["outcome"], "crossing");
    let reached = plan["reached"].as_f64().unwrap();
    assert!(reached > 0.5 && reached < 1.0, "{plan}");
    let reason = plan["reason"].as_str().unwrap();
    let fraction = format!(
        "pass through each other beyond {:.2} % of the path",
        100.0 * reached
    );
    assert!(reason.contains(&fraction), "{reason}");

    let blind = folder
        .done(&format!(
            "plan {pattern} --bound 1e-6 --collision off -o path.fold --json"
        ))
        .json();
    assert_eq!(blind["outcome"], "planned");
    assert_eq!(blind["collision"]["pairs"], 0);
    let check = folder.run("check path.fold --json").with_status(1).json();
    let first = &check["crossings"][0];
    // Many pairs of faces meet at once. The tests with the oracle judge which of them is named.
    let [from, to] = [0, 1].map(|k| &first["between_knots"][k]);
    assert!(
        reason.contains(&format!("(between knots {from} and {to}: ")),
        "{reason}: {first}"
    );
    let at = first["at"].as_f64().unwrap();
    assert!(at > 0.0 && at < 1.0, "{first}");
    // The path up to this knot has no crossings.
    let mut path = folder.read_json("path.fold");
    let frames = path["file_frames"].as_array_mut().unwrap();
    frames.truncate(usize::try_from(from.as_u64().unwrap()).unwrap() + 1);
    folder.write("before.fold", &path.to_string());
    folder.done("check before.fold");
}

#[test]
fn what_cannot_be_written_is_said() {
    let folder = folder_with_path();
    let before = folder.names();
    for command in [
        "generate miura --rows 3 --cols 3",
        "plan miura.fold",
        "view path.fold",
    ] {
        for output in ["missing/a.fold", "."] {
            let answer = folder.run(&format!("{command} -o {output}")).with_status(2);
            assert!(
                answer.stderr.starts_with(&format!("foldpath: {output}: ")),
                "{answer:?}"
            );
            assert_eq!(answer.stdout, "", "{command}");
        }
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn bad_usage_is_status_2() {
    let folder = folder_with_path();
    for arguments in [
        "",
        "unknown",
        "generate",
        "generate miura --rows 3 -o a.fold",
        "generate miura --rows three --cols 3 -o a.fold",
        "generate miura --rows 99999999999999999999 --cols 3 -o a.fold",
        "generate miura --rows 3 --cols 3",
        "generate kresling --cols 7 -o a.fold",
        "generate quad --fold 1 -o a.fold",
        "generate resch --rows 0 -o a.fold",
        "generate square-twist --angle 90 -o a.fold",
        "generate square-twist --letters some -o a.fold",
        "info",
        "info miura.fold more.fold",
        "plan miura.fold --unknown",
        "plan miura.fold --symmetry some",
        "plan miura.fold --bound",
        "plan miura.fold --bound one",
        "plan miura.fold --seed -1",
        "view path.fold",
    ] {
        let answer = folder.run(arguments).with_status(2);
        assert_eq!(answer.stdout, "", "{arguments}");
        assert!(!answer.stderr.is_empty(), "{arguments}");
    }
    for arguments in ["--help", "plan --help", "--version"] {
        assert!(
            folder.done(arguments).stdout.contains("foldpath"),
            "{arguments}"
        );
    }
}

#[test]
fn a_reader_that_goes_away_is_no_panic() {
    let folder = folder_with_path();
    for (arguments, status) in [
        ("info miura.fold", 0),
        ("plan miura.fold --json", 0),
        ("check path.fold", 0),
        ("info missing.fold", 2),
    ] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = folder.command(arguments);
        let status_seen = command
            .stdout(writer.try_clone().unwrap())
            .stderr(writer)
            .status()
            .unwrap();
        assert_eq!(status_seen.code(), Some(status), "{arguments}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn an_answer_that_does_not_fit_on_the_disk_is_an_error() {
    let folder = folder_with_path();
    let full = File::options().write(true).open("/dev/full").unwrap();
    let status = folder
        .command("info miura.fold --json")
        .stdout(full)
        .status()
        .unwrap();
    assert_eq!(
        status.code(),
        Some(2),
        "half an answer must not pass for one"
    );
}

/// As with a redirection, the file or pipe behind the name gets the result, and the name stays. A result sent to
/// /dev/null must not replace the device by a file.
#[test]
#[cfg(unix)]
fn links_and_pipes_are_written_to_not_replaced() {
    use std::os::unix::fs::FileTypeExt;

    let folder = folder_with_path();
    let [link, pipe] = ["link.fold", "pipe.fold"].map(|name| folder.path(name));
    folder.write("target.fold", "old");
    std::os::unix::fs::symlink("target.fold", &link).unwrap();
    folder.done("plan miura.fold -o link.fold");
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(folder.read("target.fold"), folder.read("path.fold"));

    let made = std::process::Command::new("mkfifo")
        .arg(&pipe)
        .status()
        .unwrap();
    assert!(made.success());
    // The pipe is open for reading and writing, so that the writer finds a reader. The output fits in the pipe's
    // buffer.
    let _reader = File::options().read(true).write(true).open(&pipe).unwrap();
    folder.done("generate miura --rows 3 --cols 3 -o pipe.fold");
    assert!(fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo());
}

/// Boards of a sheet that moves at half the speed may be twice as far apart in time, and those of a sheet of which no motion is
/// known less far.
#[test]
fn the_skew_is_that_of_the_motion() {
    let folder = folder();
    folder.done("generate miura --rows 4 --cols 4 -o miura.fold");
    folder.done("plan miura.fold --max-speed 45 -o path.fold");
    folder.done("plan miura.fold --max-speed 22.5 -o slow.fold");
    let [pattern, path, slow] = ["miura", "path", "slow"].map(|name| {
        let told = folder.done(&format!("info {name}.fold --json")).json();
        told["skew_bound"].as_f64().unwrap()
    });
    assert!(pattern < path && path < 2.0 * pattern, "{pattern} {path}");
    assert!((slow / path - 2.0).abs() < 1e-3, "{slow} {path}");
    // The bound of four hinges at 45 degrees a second, in any sheet.
    let amplification = folder.done("info miura.fold --json").json()["amplification"].as_f64();
    let expected = 0.01 / (amplification.unwrap() * 2.0 * 45_f64.to_radians());
    assert!((pattern - expected).abs() < 1e-12, "{pattern} {expected}");
    let said = folder.done("info path.fold").stdout;
    assert!(said.contains("s apart along this path"), "{said}");
}

/// A timeout that leaves no answer is a no, with its reason.
#[test]
fn loads_and_tolerance_end_at_their_timeout() {
    let folder = folder();
    folder.done("generate waterbomb --rows 8 --cols 10 -o waterbomb.fold");
    folder.done("plan waterbomb.fold -o path.fold");
    for (command, what) in [
        (
            "loads path.fold --areal-density 1 --unit mm",
            "torques were",
        ),
        ("tolerance path.fold --error 0.001", "the play was"),
    ] {
        let start = Instant::now();
        let answer = folder.run(&format!("{command} --timeout 0.01 --json"));
        assert!(start.elapsed() < Duration::from_millis(1500), "{command}");
        let text = format!("path.fold: time ran out before {what} found");
        assert_eq!(
            answer.with_status(1).json()["error"]["message"],
            text.as_str()
        );
    }
}
