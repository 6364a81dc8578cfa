//! Tests the options of the `foldpath` commands: their defaults and their effects.

use crate::common::{folder, folder_with_path};
use foldpath_test_support::numbers;
use serde_json::{Value, json};

/// Returns the fold angles of all edges at the last knot, degrees.
fn last_angles(path: &Value) -> Vec<f64> {
    let frames = path["file_frames"].as_array().unwrap();
    numbers(&frames[frames.len() - 1]["edges_foldAngle"])
}

fn furthest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .fold(0.0, |max, (a, b)| f64::max(max, (a - b).abs()))
}

/// Asserts that each number of `b` is that of `a` times `factor`.
#[track_caller]
fn assert_scaled(a: &[f64], b: &[f64], factor: f64) {
    let scaled: Vec<f64> = a.iter().map(|a| factor * a).collect();
    let size = b.iter().fold(0.0, |max, b| f64::max(max, b.abs()));
    assert!(
        size > 0.0 && furthest(&scaled, b) <= 1e-12 * size,
        "{a:?} x {factor} is not {b:?}"
    );
}

#[test]
fn defaults_are_those_of_the_contract() {
    let folder = folder_with_path();
    for (family, explicit) in [
        ("miura --rows 4 --cols 4", "--angle 60 --fold 0.9"),
        ("waterbomb --rows 4 --cols 4", "--fold 0.5"),
    ] {
        folder.done(&format!("generate {family} -o default.fold"));
        folder.done(&format!("generate {family} {explicit} -o explicit.fold"));
        assert_eq!(
            folder.read("default.fold"),
            folder.read("explicit.fold"),
            "{family}"
        );
    }
    folder.done(
        "plan miura.fold -o explicit.fold --bound 0.01 --symmetry auto --vertices essential --reuse \
         auto --collision on --interpolation auto --pace optimal --max-speed 45 --frames full --solver lm",
    );
    assert_eq!(folder.read("explicit.fold"), folder.read("path.fold"));
}

#[test]
fn a_check_allows_a_hundredth_unless_told_otherwise() {
    let folder = folder_with_path();
    folder.done("plan miura.fold --interpolation linear -o path.fold");
    let mut path = folder.read_json("path.fold");
    let file = path.as_object_mut().unwrap();
    file.remove("foldpath:edges_group");
    // One hinge is off at one knot, and nothing in the file says what its angle should be.
    let angle = &mut path["file_frames"][3]["edges_foldAngle"][2];
    *angle = json!(angle.as_f64().unwrap() + 0.15);
    let frame = path["file_frames"][3].as_object_mut().unwrap();
    let motion = [
        "edges_foldAngle",
        "foldpath:edges_foldAngleRate",
        "foldpath:time",
    ];
    frame.retain(|key, _| motion.contains(&key.as_str()));
    // The hinge is also faster than the file claims.
    path.as_object_mut().unwrap().remove("foldpath:maxSpeed");
    folder.write("off.fold", &path.to_string());

    let check = folder.run("check off.fold --bound 1e-3 --json");
    let check = check.with_status(1).json();
    let closure = check["max_closure"].as_f64().unwrap();
    assert!(closure > 1e-3 && closure < 1e-2, "{check}");
    let reason = check["reason"].as_str().unwrap();
    assert!(reason.starts_with("knot 3: closure "), "{check}");
    assert!(reason.contains(" over the bound 1.000e-3"), "{check}");
    folder.done("check off.fold");
}

#[test]
fn quiet_stops_the_notes() {
    let folder = folder_with_path();
    for name in ["miura.fold", "path.fold"] {
        let text = folder.read(name).replacen("\"B\"", "\"Q\"", 1);
        folder.write(name, &text);
    }
    let note = "note: 1 edges lettered \"Q\", which FOLD does not know, taken as U\n";
    for arguments in ["info miura.fold", "plan miura.fold", "check path.fold"] {
        let loud = folder.done(arguments);
        assert!(loud.stderr.contains(note), "{arguments}: {}", loud.stderr);
        let quiet = folder.done(&format!("{arguments} --quiet"));
        assert_eq!(quiet.stderr, "", "{arguments}");
    }
    for arguments in [
        "generate miura --rows 2 --cols 2 -o a.fold",
        "view path.fold -o a.html",
        "plot path.fold -o a.svg",
        "export path.fold --to csv -o a.csv",
        "unfold path.fold -o b.fold",
        "completions bash",
    ] {
        let expected = folder.done(arguments).stdout;
        for quiet in [
            format!("{arguments} --quiet"),
            format!("--quiet {arguments}"),
        ] {
            let answer = folder.done(&quiet);
            assert_eq!(
                (answer.stdout, answer.stderr),
                (expected.clone(), String::new()),
                "{quiet}"
            );
        }
    }
    let assumptions = &folder.done("info miura.fold --json").json()["assumptions"];
    let assumptions = assumptions.as_array().unwrap();
    assert!(
        assumptions
            .iter()
            .any(|a| note.contains(a.as_str().unwrap())),
        "{assumptions:?}"
    );
}

#[test]
fn what_is_solved_may_change_and_the_path_stays() {
    let folder = folder();
    folder.done("generate waterbomb --rows 4 --cols 6 -o a.fold");
    let plain = folder.done("plan a.fold -o plain.fold --json").json();
    assert_eq!(plain["unknowns"], 4);
    let goal = numbers(&folder.read_json("a.fold")["edges_foldAngle"]);
    for (options, unknowns) in [
        ("", 4),
        ("--symmetry off", 50),
        ("--vertices all", 4),
        ("--reuse off", 4),
        ("--solver gradient", 4),
        ("--symmetry off --vertices all", 50),
    ] {
        let plan = folder
            .done(&format!("plan a.fold -o path.fold --json {options}"))
            .json();
        assert_eq!(plan["outcome"], "planned", "{options}");
        assert_eq!(plan["unknowns"], unknowns, "{options}");
        assert_eq!(plan["groups"], unknowns, "{options}");
        assert!(plan["goal_error"].as_f64().unwrap() < 1e-9, "{options}");
        folder.done("check path.fold");
        assert!(
            furthest(&last_angles(&folder.read_json("path.fold")), &goal) < 1e-9,
            "{options}"
        );
    }
    let gradient = folder.done("plan a.fold --solver gradient --json").json();
    let iterations = |plan: &Value| plan["solver"]["iterations"].as_u64().unwrap();
    assert!(
        iterations(&gradient) > 2 * iterations(&plain),
        "linear convergence takes longer"
    );
}

#[test]
fn frames_of_angles_alone_are_folded_again_where_they_are_read() {
    let folder = folder_with_path();
    folder.done("plan miura.fold --frames angles -o angles.fold");
    let mut full = folder.read_json("path.fold");
    for frame in full["file_frames"].as_array_mut().unwrap() {
        // Without vertex positions, the frame has no attribute that calls it a shape in space.
        for key in ["vertices_coords", "frame_attributes"] {
            assert!(frame.as_object_mut().unwrap().remove(key).is_some());
        }
    }
    assert!(folder.read_json("angles.fold") == full);
    folder.done("check angles.fold");
    folder.done("view angles.fold -o angles.html");
}

#[test]
fn the_interpolation_asked_for_is_written() {
    let folder = folder_with_path();
    for (option, written) in [
        ("auto", "half-angle"),
        ("hermite", "hermite"),
        ("half-angle", "half-angle"),
        ("homogeneous", "homogeneous"),
        ("linear", "linear"),
    ] {
        folder.done(&format!(
            "plan miura.fold --interpolation {option} -o a.fold"
        ));
        let path = folder.read_json("a.fold");
        assert_eq!(path["foldpath:interpolation"], written);
        let weighted = |frame: &Value| {
            let weights = &frame["foldpath:edges_weight"];
            weights.is_array() && frame["foldpath:edges_weightRate"].is_array()
        };
        let frames = path["file_frames"].as_array().unwrap();
        let all = frames.iter().all(weighted);
        assert!(frames.iter().any(weighted) == all && all == (written == "homogeneous"));
        folder.done("check a.fold");
    }
    folder
        .run("plan miura.fold --interpolation spline")
        .with_status(2);
}

#[test]
fn speed_scales_times_and_rates() {
    let folder = folder_with_path();
    folder.done("plan miura.fold --max-speed 90 -o fast.fold");
    let [slow, fast] = ["path.fold", "fast.fold"].map(|name| {
        let path = folder.read_json(name);
        let frames = path["file_frames"].as_array().unwrap().iter();
        let times = frames
            .clone()
            .map(|frame| frame["foldpath:time"].as_f64().unwrap());
        let rates = frames.flat_map(|frame| numbers(&frame["foldpath:edges_foldAngleRate"]));
        (times.collect::<Vec<_>>(), rates.collect::<Vec<_>>())
    });
    assert_scaled(&slow.0, &fast.0, 0.5);
    assert_scaled(&slow.1, &fast.1, 2.0);
}

/// Returns the largest speed and acceleration of a hinge anywhere between the knots of a path, in degrees and seconds.
/// They are differences of the angles that `host/FORMAT.md` defines.
fn fastest(path: &Value) -> [f64; 2] {
    const PLACES: u32 = 200;
    let frames = path["file_frames"].as_array().unwrap();
    let mut most = [0.0; 2];
    for pair in frames.windows(2) {
        let span =
            pair[1]["foldpath:time"].as_f64().unwrap() - pair[0]["foldpath:time"].as_f64().unwrap();
        let step = span / f64::from(PLACES);
        let knots = [&pair[0], &pair[1]].map(|frame| {
            ["edges_foldAngle", "foldpath:edges_foldAngleRate"].map(|key| numbers(&frame[key]))
        });
        for edge in 0..knots[0][0].len() {
            let ends = knots
                .each_ref()
                .map(|[angles, rates]| [angles[edge], rates[edge]]);
            let angle = |k: u32| between(path, ends, span, f64::from(k) / f64::from(PLACES));
            for k in 1..PLACES {
                let [a, b, c] = [angle(k - 1), angle(k), angle(k + 1)];
                most[0] = f64::max(most[0], (b - a).abs() / step);
                most[1] = f64::max(most[1], (c - 2.0 * b + a).abs() / (step * step));
            }
        }
    }
    most
}

/// Returns the fold angle (degrees) of an edge at the fraction `s` of a segment. Each knot is given by its angle and
/// rate; the segment takes `span` seconds.
fn between(path: &Value, [[a, p], [b, q]]: [[f64; 2]; 2], span: f64, s: f64) -> f64 {
    let cubic = |a: f64, p: f64, b: f64, q: f64| {
        (2.0 * s - 3.0) * s * s * (a - b) + a + span * s * (1.0 - s) * ((1.0 - s) * p - s * q)
    };
    match path["foldpath:interpolation"].as_str().unwrap() {
        "hermite" => cubic(a, p, b, q),
        "half-angle" => {
            let tangent = |angle: f64| (angle.to_radians() / 2.0).tan();
            let (u, v) = (tangent(a), tangent(b));
            let rate = |u: f64, rate: f64| (1.0 + u * u) * rate.to_radians() / 2.0;
            2.0 * cubic(u, rate(u, p), v, rate(v, q)).atan().to_degrees()
        }
        other => panic!("{other}"),
    }
}

/// No hinge exceeds its limits anywhere on the motion, and somewhere a hinge comes close to one.
#[test]
fn hinges_are_as_fast_as_allowed_and_no_faster() {
    let folder = folder();
    for family in ["miura --rows 3 --cols 3", "waterbomb --rows 4 --cols 6"] {
        folder.done(&format!("generate {family} -o a.fold"));
        for kind in ["auto", "hermite"] {
            for (options, speed, acceleration) in [
                ("", 45.0, f64::INFINITY),
                ("--max-speed 90", 90.0, f64::INFINITY),
                ("--pace sparse", 45.0, f64::INFINITY),
                ("--max-accel 60", 45.0, 60.0),
                ("--max-accel 5", 45.0, 5.0),
            ] {
                let what = format!("{family} {kind} {options}");
                folder.done(&format!(
                    "plan a.fold -o p.fold --interpolation {kind} {options}"
                ));
                let [fast, abrupt] = fastest(&folder.read_json("p.fold"));
                assert!(fast <= speed * (1.0 + 1e-6), "{what}: {fast}");
                assert!(abrupt <= acceleration * (1.0 + 1e-3), "{what}: {abrupt}");
                let used = f64::max(fast / speed, (abrupt / acceleration).sqrt());
                assert!(used >= 0.97, "{what}: {fast} {abrupt}");
                folder.done("check p.fold");
            }
        }
    }
}

/// The path has at most the number of knots that is allowed, or there is no path.
#[test]
fn a_path_has_no_more_knots_than_allowed() {
    let folder = folder_with_path();
    let hermite = "plan miura.fold --interpolation hermite --json";
    let knots = folder.done(hermite).json()["knots"].as_u64().unwrap();
    let same = folder
        .done(&format!("{hermite} --max-knots {knots}"))
        .json();
    assert_eq!(same["knots"], knots);
    let answer = folder
        .run(&format!("{hermite} --max-knots 2 -o few.fold"))
        .with_status(1)
        .json();
    assert_eq!(answer["outcome"], "partial");
    assert!(
        answer["reason"]
            .as_str()
            .unwrap()
            .contains("more than 2 knots")
    );
    assert!(!folder.path("few.fold").exists());
}

#[test]
fn the_goal_is_that_of_the_option() {
    let folder = folder_with_path();
    folder.done("generate miura --rows 3 --cols 3 --fold 0.4 -o goal.fold");
    let plan = folder
        .done("plan miura.fold --goal goal.fold -o a.fold --json")
        .json();
    assert!(plan["goal_error"].as_f64().unwrap() < 1e-9);
    let goal = numbers(&folder.read_json("goal.fold")["edges_foldAngle"]);
    assert!(furthest(&last_angles(&folder.read_json("a.fold")), &goal) < 1e-9);

    // Letters alone ask for equal angles, which do not close. The nearest angles that close are taken.
    let plan = folder
        .done("plan miura.fold --fold 0.5 -o a.fold --json")
        .json();
    let asked: Vec<f64> = goal
        .iter()
        .map(|angle| {
            if *angle == 0.0 {
                0.0
            } else {
                90.0 * angle.signum()
            }
        })
        .collect();
    let error = furthest(&last_angles(&folder.read_json("a.fold")), &asked);
    assert!(
        (plan["goal_error"].as_f64().unwrap() - error).abs() < 1e-9,
        "{error} {plan}"
    );
    assert!(error > 1.0 && error < 90.0, "{error}");

    folder
        .run("plan miura.fold --fold 0.5 --goal goal.fold")
        .with_status(2);
}

/// Edge 2 of the Miura fold is lettered V, edge 4 is lettered M.
#[test]
fn limits_that_leave_no_room_are_said() {
    let folder = folder_with_path();
    let free = folder.read("miura.fold").replace("\"V\"", "\"U\"");
    folder.write("free.fold", &free);
    let flat = "degrees leaves none: it stays flat";
    for (arguments, status, note) in [
        (
            "miura.fold --limit 4=0..10",
            1,
            format!(
                "edge 4, lettered M, turns to angles below 0, of which its limit of 0..10 {flat}"
            ),
        ),
        (
            "miura.fold --limit 2=-170..0",
            1,
            format!(
                "edge 2, lettered V, turns to angles above 0, of which its limit of -170..0 {flat}"
            ),
        ),
        (
            "free.fold --fold 0.5 --limit 4=0..0",
            1,
            format!(
                "edge 4, lettered M, turns to angles below 0, of which its limit of 0..0 {flat}"
            ),
        ),
        (
            "free.fold --limit 2=-10..0",
            1,
            format!(
                "edge 2, whose goal is 162.000000 degrees, turns to angles above 0, of which its limit of -10..0 {flat}"
            ),
        ),
        ("miura.fold --fold 0 --limit 4=0..10", 0, String::new()),
        ("miura.fold --limit 4=-170..10", 0, String::new()),
    ] {
        let answer = folder.run(&format!("plan {arguments}")).with_status(status);
        let told = answer
            .stderr
            .lines()
            .find(|line| line.contains("its limit of"));
        let expected = (!note.is_empty()).then(|| format!("note: {note}"));
        assert_eq!(told, expected.as_deref(), "{arguments}: {answer:?}");
    }
}

/// The path has one knot, or with `--via` all knots of the way to that configuration and back.
#[test]
fn the_flat_sheet_may_be_the_goal() {
    let folder = folder_with_path();
    for (options, knots) in [
        ("", 1..2),
        ("--search random --symmetry off", 1..2),
        ("--via miura.fold", 3..99),
    ] {
        let plan = format!("plan miura.fold --fold 0 -o flat.fold --json {options}");
        let plan = folder.done(&plan).json();
        assert_eq!(plan["outcome"], "planned");
        let count = plan["knots"].as_u64().unwrap();
        assert!(knots.contains(&count), "{options}: {plan}");
        let last = last_angles(&folder.read_json("flat.fold"));
        assert!(last.iter().all(|angle| *angle == 0.0), "{last:?}");
        folder.done("check flat.fold");
        for to in ["traj", "csv", "glb", "obj"] {
            folder.done(&format!("export flat.fold --to {to} -o flat.{to}"));
        }
        let streamed = folder.done("stream flat.traj --to sim --json").json();
        assert_eq!(streamed["outcome"], "done", "{streamed}");
    }
}

#[test]
fn the_seed_is_echoed_and_written() {
    let folder = folder_with_path();
    for seed in [0, 7, u64::MAX] {
        let plan = folder
            .done(&format!("plan miura.fold --seed {seed} -o a.fold --json"))
            .json();
        assert_eq!(plan["seed"], seed);
        assert_eq!(folder.read_json("a.fold")["foldpath:seed"], seed);
    }
}

#[test]
fn a_timeout_longer_than_any_plan_is_none() {
    let folder = folder_with_path();
    for seconds in ["1e9", "1e19", "1e300"] {
        folder.done(&format!("plan miura.fold --timeout {seconds}"));
    }
}

/// A path whose times are too large for a number is not written.
#[test]
fn a_speed_close_to_nothing_is_refused() {
    let folder = folder_with_path();
    folder
        .run("plan miura.fold --max-speed 1e-308 -o slow.fold")
        .with_status(2);
}

/// A goal that does not close is reached within the goal tolerance, and otherwise only come near to.
#[test]
fn a_goal_is_reached_within_its_tolerance() {
    for turned in [6.0, -6.0] {
        goal_is_reached_within_its_tolerance(turned);
    }
}

/// Half of the hinges of one crease group are asked to turn this many degrees farther than the others.
fn goal_is_reached_within_its_tolerance(turned: f64) {
    let folder = folder_with_path();
    let mut goal = folder.read_json("miura.fold");
    let angles = goal["edges_foldAngle"].as_array_mut().unwrap();
    for angle in angles.iter_mut().skip(1).step_by(2) {
        let degrees = angle.as_f64().unwrap();
        if degrees.abs() > 0.0 {
            *angle = json!(degrees + turned * degrees.signum());
        }
    }
    folder.write("goal.fold", &goal.to_string());

    let near = folder.run("plan miura.fold --goal goal.fold -o near.fold --keep --json");
    let near = near.with_status(1).json();
    assert_eq!(near["outcome"], "near_goal", "{near}");
    // Hinges that turn too far make no whole way.
    let reached = near["reached"].as_f64().unwrap();
    assert!(reached > 0.9 && reached < 0.99, "{reached}");
    let error = near["goal_error"].as_f64().unwrap();
    assert!(error > 1.0 && error < 6.0, "{error}");
    let path = folder.read_json("near.fold");
    assert_eq!(path["foldpath:outcome"], "near_goal");
    assert_eq!(path["foldpath:reached"], near["reached"]);
    let off = furthest(&last_angles(&path), &numbers(&goal["edges_foldAngle"]));
    assert!((off - error).abs() < 1e-9, "{off} {error}");

    for (tolerance, status) in [(1.01 * error, 0), (0.99 * error, 1)] {
        let command = format!("plan miura.fold --goal goal.fold --goal-tolerance {tolerance}");
        let _answer = folder.run(&command).with_status(status);
    }
}

/// Letters at a fraction of a half turn are followed only if every lettered crease turns: here one line turns alone, and
/// a vertex of three creases is locked.
#[test]
fn letters_are_followed_only_if_all_creases_turn() {
    let folder = folder();
    let mut sheet = json!({
        "vertices_coords": [[0, 0], [1, 0], [4, 0], [4, 1], [4, 2], [1, 2], [0, 2], [3, 1]],
        "edges_vertices": [
            [0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 6], [6, 0], [1, 5], [7, 3], [7, 2], [7, 4],
        ],
        "edges_assignment": ["B", "B", "B", "B", "B", "B", "B", "V", "V", "V", "V"],
    });
    folder.write("locked.fold", &sheet.to_string());
    let locked = folder.run("plan locked.fold --fold 0.5 --json");
    let locked = locked.with_status(1).json();
    // One of four lettered creases turns: that is not near the goal.
    assert_eq!(locked["outcome"], "partial", "{locked}");
    assert_eq!(locked["flat_creases"], 3);
    let reason = locked["reason"].as_str().unwrap();
    assert!(
        reason.ends_with("3 lettered creases stay flat: edges 8, 9, 10"),
        "{reason}"
    );

    // Creases that need not turn stay flat without harm.
    for edge in 8..11 {
        sheet["edges_assignment"][edge] = json!("F");
    }
    folder.write("line.fold", &sheet.to_string());
    let line = folder.run("plan line.fold --fold 0.5 --json");
    let line = line.with_status(0).json();
    assert_eq!(
        (&line["outcome"], &line["flat_creases"]),
        (&json!("planned"), &json!(0))
    );
}
