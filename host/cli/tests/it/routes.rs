//! Tests the ways to a goal: driven creases, phases, limits, bifurcations and the randomised search, and the answer if
//! no way leads to the goal. Planned paths are judged by `check`, which shares no state with the planner.

use crate::common::folder;
use foldpath::check::{CheckOptions, check};
use foldpath::read::fold::read_motion;
use foldpath_test_support::{Folder, numbers};
use serde_json::{Value, json};

/// Returns the plan's JSON object, whatever its outcome.
fn plan(folder: &Folder, arguments: &str) -> Value {
    folder
        .run(&format!("plan {arguments} --json --quiet"))
        .json()
}

/// Asserts that a path holds: its whole motion within the bound of `check`, and its knots to rounding errors.
#[track_caller]
fn holds(folder: &Folder, path: &str) {
    folder.done(&format!("check {path}"));
    let knots = check(
        &read_motion(&folder.path(path)).unwrap(),
        &CheckOptions::knots_alone(1e-9),
    );
    assert_eq!(knots.findings(), [""; 0]);
}

/// Returns the fold angles of an edge at all knots of the path, degrees.
fn angles_of(folder: &Folder, path: &str, edge: usize) -> Vec<f64> {
    let path = folder.read_json(path);
    let frames = path["file_frames"].as_array().unwrap();
    let angle = |frame: &Value| numbers(&frame["edges_foldAngle"])[edge];
    frames.iter().map(angle).collect()
}

/// Returns the knots at which phases of a path begin.
fn phases(path: &Value) -> Vec<usize> {
    serde_json::from_value(path["foldpath:phases"].clone()).unwrap()
}

fn miura(folder: &Folder, size: usize, fold: f64, name: &str) {
    folder.done(&format!(
        "generate miura --rows {size} --cols {size} --fold {fold} -o {name}"
    ));
}

/// Zigzag crease that the tests drive: edge 4, a mountain, is the first zigzag crease of the generated sheets.
const ZIGZAG: usize = 4;

#[test]
fn a_driven_crease_takes_the_others_along_with_and_without_symmetry() {
    let folder = folder();
    miura(&folder, 5, 0.9, "m.fold");
    for options in ["", "--symmetry off"] {
        let answer = plan(
            &folder,
            &format!("m.fold --crease {ZIGZAG}=-100 -o p.fold {options}"),
        );
        assert_eq!(answer["outcome"], "planned", "{answer}");
        holds(&folder, "p.fold");
        // A crease that follows anyway may be named as well.
        let letters = folder.read_json("p.fold")["edges_assignment"].clone();
        let letters = letters.as_array().unwrap();
        let valley = letters.iter().position(|letter| letter == "V").unwrap();
        let last = *angles_of(&folder, "p.fold", valley).last().unwrap();
        let both = format!("m.fold --crease {ZIGZAG}=-100 --crease {valley}={last}");
        let answer = plan(&folder, &format!("{both} -o both.fold {options}"));
        assert_eq!(answer["outcome"], "planned", "{answer}");
        holds(&folder, "both.fold");
        let driven = *angles_of(&folder, "p.fold", ZIGZAG).last().unwrap();
        assert!((driven + 100.0).abs() < 1e-9, "{driven}");
        // The closed form is tan(straight/2) = cos 60 tan(zigzag/2), on the branch of the letters.
        let file = folder.read_json("m.fold");
        let straight = 2.0 * (0.5 * 50_f64.to_radians().tan()).atan().to_degrees();
        for (edge, goal) in numbers(&file["edges_foldAngle"]).into_iter().enumerate() {
            let size = match goal.abs() {
                g if g < 1e-9 => 0.0,
                g if (g - 162.0).abs() < 1e-6 => 100.0,
                _ => straight,
            };
            let last = *angles_of(&folder, "p.fold", edge).last().unwrap();
            assert!(
                (last - size * goal.signum()).abs() < 1e-6,
                "edge {edge}: {last}"
            );
        }
    }
}

#[test]
fn phases_are_passed_in_order_and_at_rest() {
    let folder = folder();
    for (fold, name) in [(0.9, "m.fold"), (0.6, "far.fold"), (0.3, "near.fold")] {
        miura(&folder, 3, fold, name);
    }
    let answer = plan(&folder, "m.fold --via far.fold --via near.fold -o p.fold");
    assert_eq!(answer["outcome"], "planned", "{answer}");
    holds(&folder, "p.fold");
    let angles = angles_of(&folder, "p.fold", ZIGZAG);
    let at = |angle: f64| {
        angles
            .iter()
            .position(|a| (a + angle).abs() < 1e-6)
            .unwrap()
    };
    assert!(at(108.0) > 0 && angles[at(108.0)..].iter().any(|a| (a + 54.0).abs() < 1e-6));
    assert!((angles.last().unwrap() + 162.0).abs() < 1e-6);
    let path = folder.read_json("p.fold");
    let turns: Vec<f64> = phases(&path).into_iter().map(|knot| angles[knot]).collect();
    assert!(
        turns.len() == 2 && (turns[0] + 108.0).abs() < 1e-6 && (turns[1] + 54.0).abs() < 1e-6,
        "phases begin at {turns:?}"
    );
    let rates = &path["file_frames"][at(108.0)]["foldpath:edges_foldAngleRate"];
    assert!(
        numbers(rates).iter().all(|rate| rate.abs() < 1e-12),
        "turns back at speed"
    );
}

#[test]
fn a_phase_that_ends_on_a_straight_way_has_a_knot_and_no_rest() {
    let folder = folder();
    for (fold, name) in [(0.9, "m.fold"), (0.3, "near.fold")] {
        miura(&folder, 3, fold, name);
    }
    plan(&folder, "m.fold --via near.fold -o p.fold");
    holds(&folder, "p.fold");
    let path = folder.read_json("p.fold");
    let [knot] = phases(&path)[..] else {
        panic!("one phase before the goal's: {:?}", phases(&path))
    };
    assert!((angles_of(&folder, "p.fold", ZIGZAG)[knot] + 54.0).abs() < 1e-6);
    let rates = numbers(&path["file_frames"][knot]["foldpath:edges_foldAngleRate"]);
    assert!(rates[ZIGZAG].abs() > 1.0);
    plan(&folder, "m.fold -o q.fold");
    assert!(folder.read_json("q.fold").get("foldpath:phases").is_none());
}

#[test]
fn limits_hold_at_every_knot_and_a_goal_beyond_them_is_approached() {
    let folder = folder();
    miura(&folder, 5, 0.9, "m.fold");
    for options in ["", "--symmetry off"] {
        let answer = plan(
            &folder,
            &format!("m.fold --limit {ZIGZAG}=-90..10 {options}"),
        );
        assert_eq!(answer["outcome"], "partial", "{answer}");
        let reason = answer["reason"].as_str().unwrap();
        assert!(
            reason.contains("limit") && reason.contains(&format!(" {ZIGZAG}")),
            "{reason}"
        );
        let reached = answer["reached"].as_f64().unwrap();
        assert!(reached > 0.3 && reached < 0.6, "{reached}");
    }
    // A limit that the goal does not exceed changes nothing.
    folder.done("plan m.fold -o free.fold");
    folder.done(&format!(
        "plan m.fold --limit {ZIGZAG}=-170..0 -o limited.fold"
    ));
    assert_eq!(folder.read("free.fold"), folder.read("limited.fold"));
}

#[test]
fn bad_options_are_refused_with_what_was_expected() {
    let folder = folder();
    miura(&folder, 3, 0.9, "m.fold");
    for (options, expected) in [
        (
            "--crease 0=-90",
            "edge 0: expected a hinge between two faces, but it is lettered B",
        ),
        ("--crease 99=-90", "edges go from 0 to 23"),
        ("--crease 4=90", "edge 4 is lettered M"),
        ("--crease 4=-190", "at most 180 degrees"),
        ("--crease 4", "expected I=DEG"),
        ("--limit 4=10..20", "found 10"),
        ("--limit 4=-200..20", "found -200"),
        ("--limit 4=-20", "expected I=MIN..MAX"),
        ("--crease 4=-90 --fold 0.5", "cannot be used with"),
        ("--via nothing.fold", "nothing.fold"),
    ] {
        let output = folder.run(&format!("plan m.fold {options}"));
        assert_eq!(output.status, Some(2), "{options}");
        assert!(
            output.stderr.contains(expected),
            "{options}: {}",
            output.stderr
        );
    }
}

/// Returns a sheet of four squares round one vertex, like a map. Each of its two lines can fold only while the other is
/// flat or folded flat.
fn map() -> Value {
    json!({
        "vertices_coords": [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1], [0, 2], [1, 2], [2, 2]],
        "edges_vertices": [
            [0, 1], [1, 2], [3, 4], [4, 5], [6, 7], [7, 8], [0, 3], [3, 6], [1, 4], [4, 7], [2, 5], [5, 8]
        ],
        "edges_assignment": ["B", "B", "V", "V", "B", "B", "B", "B", "V", "M", "B", "B"],
        "edges_foldAngle": [0, 0, 180, 180, 0, 0, 0, 0, 90, -90, 0, 0],
    })
}

#[test]
fn a_bifurcation_is_crossed() {
    let folder = folder();
    folder.write("map.fold", &map().to_string());
    let answer = plan(&folder, "map.fold -o p.fold");
    assert_eq!(answer["outcome"], "planned", "{answer}");
    holds(&folder, "p.fold");
    let (first, second) = (
        angles_of(&folder, "p.fold", 2),
        angles_of(&folder, "p.fold", 8),
    );
    for (first, second) in first.iter().zip(&second) {
        assert!(
            second.abs() < 1e-6 || (first - 180.0).abs() < 1e-6,
            "{first} {second}"
        );
    }
}

/// Returns the pattern with every coordinate changed by up to `by`, differently for each `time`.
fn roughened(mut pattern: Value, by: f64, time: u32) -> Value {
    let vertices = pattern["vertices_coords"].as_array_mut().unwrap();
    let coordinates = vertices.iter_mut().flat_map(|p| p.as_array_mut().unwrap());
    for (coordinate, place) in coordinates.zip(1_u32..) {
        let off = by * f64::from(time * 31 + place * place).sin();
        *coordinate = json!(coordinate.as_f64().unwrap() + off);
    }
    pattern
}

/// If the lines of a cross are not quite straight, neither can turn without the other, and both can turn in one way
/// alone. The letters agree with that way only by luck.
#[test]
fn lines_that_hardly_bend_are_folded_as_straight_ones() {
    let folder = folder();
    for by in [1e-7, 1e-6, 1e-5, 1e-4] {
        for time in 0..4 {
            let mut cross = roughened(map(), by, time);
            for (edge, angle) in [(8, 180.0), (9, -180.0)] {
                cross["edges_foldAngle"][edge] = json!(angle);
            }
            folder.write("cross.fold", &cross.to_string());
            let answer = plan(&folder, "cross.fold -o p.fold");
            assert_eq!(answer["outcome"], "planned", "{by} {time}: {answer}");
            folder.done("check p.fold --bound 0.01");
        }
    }
}

/// Returns a strip whose panels have these widths. The creases between them are valleys with these goals, degrees.
fn strip(widths: &[f64], goals: &[f64]) -> Value {
    let ends = widths.iter().scan(0.0, |x, width| {
        *x += width;
        Some(*x)
    });
    let x: Vec<f64> = core::iter::once(0.0).chain(ends).collect();
    let last = x.len() - 1;
    let vertices: Vec<_> = x.iter().flat_map(|x| [[*x, 0.0], [*x, 1.0]]).collect();
    let across = (0..=last).map(|k| [2 * k, 2 * k + 1]);
    let along = (0..last).flat_map(|k| [[2 * k, 2 * k + 2], [2 * k + 1, 2 * k + 3]]);
    let edges: Vec<_> = across.chain(along).collect();
    let mut letters = vec!["B"; edges.len()];
    letters[1..last].fill("V");
    let mut angles = vec![0.0; edges.len()];
    angles[1..last].copy_from_slice(goals);
    json!({
        "file_spec": 1.2,
        "vertices_coords": vertices,
        "edges_vertices": edges,
        "edges_assignment": letters,
        "edges_foldAngle": angles,
    })
}

/// Three sheets are folded one part after the other. The two flaps of a letter are alike, but would cross. A roll
/// begins at its narrow end, because the other end would stick out into the way of the next panel. A lid folds before
/// the flap that goes over it.
#[test]
fn parts_are_folded_one_after_the_other_where_they_would_cross() {
    let folder = folder();
    let rolled = [1.0, 0.95, 0.9, 0.85, 0.8];
    for (name, widths, goals, stops) in [
        ("letter", &[0.9, 1.0, 0.9][..], &[180.0, 180.0][..], 1),
        ("roll", &rolled, &[180.0; 4], 3),
        ("lid", &[0.9, 1.0, 0.8], &[170.0, 179.0], 1),
    ] {
        folder.write("strip.fold", &strip(widths, goals).to_string());
        let answer = plan(&folder, "strip.fold -o p.fold");
        assert_eq!(answer["outcome"], "planned", "{name}: {answer}");
        holds(&folder, "p.fold");
        let path = folder.read_json("p.fold");
        assert_eq!(phases(&path).len(), stops, "{name}");
        let first = angles_of(&folder, "p.fold", 1);
        let last = angles_of(&folder, "p.fold", goals.len());
        let at_once = first.iter().zip(&last);
        let both =
            at_once.filter(|&(a, b)| *a % goals[0] > 0.0 && *b % goals[goals.len() - 1] > 0.0);
        assert_eq!(both.count(), 0, "{name}: {first:?} {last:?}");
        if name == "roll" {
            let mut angles = first.iter().zip(&last);
            assert!(
                angles.all(|(first, last)| first <= last),
                "{first:?} {last:?}"
            );
        }
    }
    // A sheet whose faces cross at the goal is not folded at all.
    let crossed = strip(&[0.9, 1.0, 0.9], &[178.0, 175.0]);
    folder.write("strip.fold", &crossed.to_string());
    let answer = plan(&folder, "strip.fold");
    assert_eq!(answer["outcome"], "crossing", "{answer}");
}

/// Two flaps have to turn one after the other. The flap at the other end may turn together with either of them.
#[test]
fn parts_that_may_turn_together_do() {
    let folder = folder();
    let letter = strip(&[0.9, 1.0, 0.9, 2.5, 0.4], &[180.0, 180.0, 0.0, 170.0]);
    folder.write("strip.fold", &letter.to_string());
    let answer = plan(&folder, "strip.fold -o p.fold");
    assert_eq!(answer["outcome"], "planned", "{answer}");
    holds(&folder, "p.fold");
    assert_eq!(phases(&folder.read_json("p.fold")).len(), 1);
}

/// One step leads from the flat sheet to the goal. The sheet closes at both ends of the step, but not on the straight
/// line between them.
#[test]
fn a_goal_one_step_away_is_not_gone_to_straight() {
    let folder = folder();
    folder.done("generate miura --rows 4 --cols 4 --fold 0.04 -o miura.fold");
    let answer = plan(&folder, "miura.fold");
    assert_eq!(answer["outcome"], "planned", "{answer}");
    assert!(
        answer["certified_deformation"].as_f64().unwrap() < 1e-9,
        "{answer}"
    );
}

/// A strip has one order in which it rolls up. The order is found however the file orders its lines.
#[test]
fn a_roll_is_found_however_its_creases_are_numbered() {
    let folder = folder();
    let widths = [1.0, 0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.55];
    for step in [7, 11, 13] {
        let mut roll = strip(&widths, &[180.0; 9]);
        for key in ["edges_vertices", "edges_assignment", "edges_foldAngle"] {
            let edges = roll[key].as_array().unwrap();
            let mixed = (0..edges.len()).map(|k| edges[(3 + step * k) % edges.len()].clone());
            roll[key] = mixed.collect();
        }
        folder.write("roll.fold", &roll.to_string());
        let answer = plan(&folder, "roll.fold -o p.fold");
        assert_eq!(answer["outcome"], "planned", "{step}: {answer}");
        holds(&folder, "p.fold");
    }
}

/// A map, pleated and rolled up. The roll nearly closes, and would run into itself on the way.
#[test]
fn lines_of_a_map_are_folded_one_after_the_other_where_they_would_cross() {
    let folder = folder();
    let y = [0.0, 0.857, 2.028, 2.776, 4.112];
    let vertices: Vec<_> = (0..3).flat_map(|x| y.map(|y| [f64::from(x), y])).collect();
    let up = (0..3).flat_map(|x| (0..4).map(move |k| [5 * x + k, 5 * x + k + 1]));
    let right = (0..2).flat_map(|x| (0..5).map(move |k| [5 * x + k, 5 * x + k + 5]));
    let edges: Vec<_> = up.chain(right).collect();
    let goal = |[a, b]: [usize; 2]| match (a / 5, a % 5) {
        (1, _) if b == a + 1 => 180.0,
        (x, row @ 1..=3) if b == a + 5 => {
            // With so many digits no rounding explains the crossing.
            let angle = [140.180_000_000_001, 87.750_000_000_001, 111.870_000_000_001];
            angle[row - 1] * if x == 0 { 1.0 } else { -1.0 }
        }
        _ => 0.0,
    };
    let goals: Vec<f64> = edges.iter().map(|&ends| goal(ends)).collect();
    let letter = |goal: &f64| match goal {
        g if *g > 0.0 => "V",
        g if *g < 0.0 => "M",
        _ => "B",
    };
    let map = json!({
        "file_spec": 1.2,
        "vertices_coords": vertices,
        "edges_vertices": edges,
        "edges_assignment": goals.iter().map(letter).collect::<Vec<_>>(),
        "edges_foldAngle": goals,
    });
    folder.write("map.fold", &map.to_string());
    let answer = plan(&folder, "map.fold -o p.fold");
    assert_eq!(answer["outcome"], "planned", "{answer}");
    holds(&folder, "p.fold");
    assert!(!phases(&folder.read_json("p.fold")).is_empty());
}

/// Returns a waterbomb base whose goal is folded flat, except for 90 degrees along its valleys.
fn waterbomb_base() -> Value {
    let rim = [
        [6, 0],
        [6, 1],
        [5, 1],
        [5, 2],
        [7, 2],
        [7, 3],
        [4, 3],
        [4, 0],
    ];
    let spokes = [0, 2, 1, 3, 4, 5, 6, 7].map(|end| [8, end]);
    let edges = [rim, spokes].concat();
    let letters: Vec<_> = "BBBBBBBBMMMMVVVV".chars().map(String::from).collect();
    let angles = [[0.0; 4], [0.0; 4], [-180.0; 4], [90.0; 4]].concat();
    json!({
        "vertices_coords": [[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, 0], [1, 0], [0, -1], [0, 1], [0, 0]],
        "edges_vertices": edges,
        "edges_assignment": letters,
        "edges_foldAngle": angles,
    })
}

#[test]
fn groups_of_a_sheet_that_is_hardly_symmetric_are_dropped_where_less_is_proved_with_them() {
    let folder = folder();
    let mut dropped = 0;
    for time in 0..20 {
        let base = roughened(waterbomb_base(), 1e-6, time);
        folder.write("base.fold", &base.to_string());
        let output = folder.done("plan base.fold -o p.fold");
        dropped += u32::from(output.stderr.contains("less deformation is proved"));
        folder.done("check p.fold");
    }
    assert!(dropped > 0);
}

#[test]
fn the_randomised_search_keeps_the_bound_and_its_seed() {
    let folder = folder();
    miura(&folder, 3, 0.9, "m.fold");
    for objective in ["max", "sum"] {
        for symmetry in ["auto", "off"] {
            let options = format!("--search random --objective {objective} --symmetry {symmetry}");
            let answer = plan(&folder, &format!("m.fold {options} --seed 7 -o p.fold"));
            assert_eq!(answer["outcome"], "planned", "{options}: {answer}");
            folder.done("check p.fold --bound 0.01");
            folder.done(&format!("plan m.fold {options} --seed 7 -o again.fold"));
            folder.done(&format!("plan m.fold {options} --seed 8 -o other.fold"));
            assert_eq!(
                folder.read("p.fold"),
                folder.read("again.fold"),
                "{options}"
            );
            assert_ne!(
                folder.read("p.fold"),
                folder.read("other.fold"),
                "{options}"
            );
        }
    }
}

#[test]
fn the_randomised_search_ends_with_its_time() {
    let folder = folder();
    miura(&folder, 24, 0.9, "m.fold");
    let answer = plan(
        &folder,
        "m.fold --search random --symmetry off --timeout 0.05",
    );
    assert_eq!(answer["outcome"], "timeout", "{answer}");
    assert!(answer["reason"].is_string());
}

/// Returns a square twist whose four pleats all turn the same way round. It is locally flat-foldable, but locked.
fn locked_twist() -> Value {
    let (mut vertices, mut edges) = (Vec::new(), Vec::new());
    let mut letters = Vec::new();
    // The square is turned by 20 degrees. From each corner two pleat creases go to the border, along the axes.
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    for corner in 0..4 {
        let turn = |x: f64, y: f64| match corner {
            0 => [x, y],
            1 => [-y, x],
            2 => [-x, -y],
            _ => [y, -x],
        };
        let [x, y] = [0.5 * (cos - sin), 0.5 * (cos + sin)];
        vertices.push(turn(x, y));
        vertices.push(turn(2.0, y));
        vertices.push(turn(x, 2.0));
    }
    for corner in 0..4 {
        let (this, next) = (3 * corner, 3 * ((corner + 1) % 4));
        edges.extend([[this, next], [this, this + 1], [this, this + 2]]);
        letters.extend(["M", "V", "M"]);
        edges.extend([[this + 1, this + 2], [this + 2, next + 1]]);
        letters.extend(["B", "B"]);
    }
    json!({"vertices_coords": vertices, "edges_vertices": edges, "edges_assignment": letters})
}

#[test]
fn a_locked_sheet_is_answered_with_vertex_and_creases() {
    let folder = folder();
    folder.write("twist.fold", &locked_twist().to_string());
    let answer = plan(&folder, "twist.fold");
    assert_eq!(answer["outcome"], "partial", "{answer}");
    let reason = answer["reason"].as_str().unwrap();
    assert!(
        reason.contains("vertex") && reason.contains("creases: edges"),
        "{reason}"
    );
    assert!(answer["reached"].as_f64().unwrap() < 0.05, "{answer}");
}

#[test]
fn letters_alone_fold_a_waterbomb_sheet_to_where_it_is_singular() {
    let folder = folder();
    folder.done("generate waterbomb --rows 4 --cols 6 -o w.fold");
    let mut file = folder.read_json("w.fold");
    file.as_object_mut().unwrap().remove("edges_foldAngle");
    file.as_object_mut().unwrap().remove("file_frames");
    folder.write("letters.fold", &file.to_string());
    let answer = plan(&folder, "letters.fold -o p.fold");
    assert_eq!(answer["outcome"], "planned", "{answer}");
    holds(&folder, "p.fold");
    assert!(answer["goal_error"].as_f64().unwrap() < 1e-9, "{answer}");
    assert!(answer["knots"].as_u64().unwrap() < 60, "{answer}");
}

#[test]
fn a_sheet_that_only_its_essential_pattern_allows_is_not_rigidly_foldable() {
    let folder = folder();
    folder.done("generate quad --rows 24 --cols 24 -o quad.fold");
    let answer = plan(&folder, "quad.fold");
    assert_eq!(answer["outcome"], "not_rigidly_foldable", "{answer}");
    assert!(
        answer["max_deformation"].as_f64().unwrap() > 4.0,
        "{answer}"
    );
    let reason = answer["reason"].as_str().unwrap();
    for words in [
        "the whole sheet deforms by 4.",
        "its essential crease pattern by 1.",
    ] {
        assert!(reason.contains(words), "{reason}");
    }
}

#[test]
fn small_folds_along_letters_are_not_the_flat_sheet() {
    let folder = folder();
    folder.done("generate resch -o r.fold");
    let answer = plan(&folder, "r.fold --fold 0.2 -o p.fold");
    assert_eq!(answer["outcome"], "planned", "{answer}");
    holds(&folder, "p.fold");
    let turned = (0..116).map(|edge| angles_of(&folder, "p.fold", edge).last().unwrap().abs());
    assert!(turned.fold(0.0, f64::max) > 10.0);
}

/// Many motions lead away from flat. A driven crease follows the motion to the sheet's own goal.
#[test]
fn a_driven_crease_goes_the_way_of_the_sheets_goal_and_no_hinge_against_its_letter() {
    let folder = folder();
    for (size, degrees) in [("--rows 2 --cols 2", 90.0), ("--rows 1 --cols 1", 180.0)] {
        folder.done(&format!("generate resch {size} -o r.fold"));
        let answer = plan(&folder, &format!("r.fold --crease 0={degrees} -o p.fold"));
        assert_eq!(answer["outcome"], "planned", "{answer}");
        assert!(answer["goal_error"].as_f64().unwrap() < 1e-6, "{answer}");
        holds(&folder, "p.fold");
    }
}

#[test]
fn hinges_without_an_angle_keep_their_letters() {
    let folder = folder();
    let mut vertices = vec![[0.0, 0.0]];
    vertices.extend(
        [0.0_f64, 70.0, 160.0, 270.0].map(|a| [a.to_radians().cos(), a.to_radians().sin()]),
    );
    let mut sheet = json!({
        "vertices_coords": vertices,
        "edges_vertices": [[0, 1], [0, 2], [0, 3], [0, 4], [1, 2], [2, 3], [3, 4], [4, 1]],
        "edges_assignment": ["V", "M", "V", "V", "B", "B", "B", "B"],
        "edges_foldAngle": [null, -60, null, null, 0, 0, 0, 0],
    });
    let mut planned = 0;
    for (edge, angle) in [(0, 60), (1, -60), (2, 60), (3, 60)] {
        sheet["edges_foldAngle"] = json!([null, null, null, null, 0, 0, 0, 0]);
        sheet["edges_foldAngle"][edge] = json!(angle);
        folder.write("v.fold", &sheet.to_string());
        if plan(&folder, "v.fold -o p.fold")["outcome"] == "planned" {
            holds(&folder, "p.fold");
            planned += 1;
        }
    }
    assert!(planned >= 3, "{planned}");
}

/// Without phases, what folds in phases crosses.
#[test]
fn phases_are_looked_for_unless_all_creases_are_to_turn_at_once() {
    let folder = folder();
    // A strip of three panels: the flaps at its ends overlap where they lie on the middle.
    let strip = serde_json::json!({
        "file_spec": 1.2,
        "vertices_coords": [[0, 0], [3, 0], [7, 0], [10, 0], [10, 1], [7, 1], [3, 1], [0, 1]],
        "edges_vertices": [
            [0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 6], [6, 7], [7, 0], [1, 6], [2, 5]
        ],
        "edges_assignment": ["B", "B", "B", "B", "B", "B", "B", "B", "V", "V"],
        "edges_foldAngle": [0, 0, 0, 0, 0, 0, 0, 0, 180, 180],
    });
    std::fs::write(folder.path("strip.fold"), strip.to_string()).unwrap();
    let at_once = folder
        .run("plan strip.fold --search path --json")
        .with_status(1)
        .json();
    assert_eq!(at_once["outcome"], "crossing", "{at_once:#}");
    let phases = folder.done("plan strip.fold --json").json();
    assert_eq!(phases["outcome"], "planned", "{phases:#}");
    let tried = phases["attempts"].as_array().unwrap();
    assert_eq!(
        tried[1]["strategy"], "phases split at crossings",
        "{tried:?}"
    );
}
