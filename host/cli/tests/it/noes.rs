//! Answers that are no: the kept path goes as far as the answer says, `check` finds no fault in it, and the answer names
//! what may help.

use crate::common::folder;
use foldpath_test_support::{Folder, Random};
use serde_json::{Value, json};

/// Number of sheets of each kind.
const SHEETS: u64 = 8;

/// A sheet of one strip whose panels have these widths. Each crease has a letter and may have a goal angle, degrees.
fn strip(widths: &[f64], creases: &[(&str, Option<f64>)]) -> Value {
    let mut places = vec![0.0];
    for width in widths {
        places.push(places[places.len() - 1] + width);
    }
    let count = places.len();
    let vertices: Vec<[f64; 2]> = [0.0, 1.0]
        .iter()
        .flat_map(|y| places.iter().map(|x| [*x, *y]))
        .collect();
    let mut edges = vec![json!([0, count]), json!([count - 1, 2 * count - 1])];
    for i in 1..count {
        edges.extend([json!([i - 1, i]), json!([count + i - 1, count + i])]);
    }
    let mut letters = vec!["B"; edges.len()];
    let mut angles = vec![None; edges.len()];
    for (i, (letter, angle)) in creases.iter().enumerate() {
        edges.push(json!([i + 1, count + i + 1]));
        letters.push(letter);
        angles.push(*angle);
    }
    json!({
        "file_spec": 1.1,
        "vertices_coords": vertices,
        "edges_vertices": edges,
        "edges_assignment": letters,
        "edges_foldAngle": angles,
    })
}

/// A vertex of four creases in general directions, with a goal angle (degrees) for each crease if there are any.
fn vertex(rng: &mut Random, letters: &[&str; 4], angles: Option<[f64; 4]>) -> Value {
    let directions: Vec<f64> = (0..4_u8)
        .map(|quarter| f64::from(quarter) * 90.0 + rng.uniform(-25.0, 25.0))
        .collect();
    let mut vertices: Vec<[f64; 2]> = directions
        .iter()
        .map(|degrees| [degrees.to_radians().cos(), degrees.to_radians().sin()])
        .collect();
    vertices.push([0.0, 0.0]);
    let mut edges: Vec<[usize; 2]> = (0..4).map(|i| [i, (i + 1) % 4]).collect();
    edges.extend((0..4).map(|i| [i, 4]));
    let mut assignment = vec!["B"; 4];
    assignment.extend(letters);
    let goal = (0..8).map(|edge: usize| Some(angles?[edge.checked_sub(4)?]));
    json!({
        "file_spec": 1.1,
        "vertices_coords": vertices,
        "edges_vertices": edges,
        "edges_assignment": assignment,
        "edges_foldAngle": goal.collect::<Vec<Option<f64>>>(),
    })
}

/// Plans `sheet.fold`, and returns the answer with the options that its hints name.
fn planned(folder: &Folder, options: &str) -> (Value, Vec<String>) {
    let answer = folder.run(&format!("plan sheet.fold --json {options}"));
    let hints = answer
        .stderr
        .lines()
        .filter(|line| line.starts_with("help: "));
    let named = hints.filter_map(|hint| Some(hint.split('`').nth(1)?.to_string()));
    let named = named.collect();
    (answer.json(), named)
}

/// Plans `sheet.fold` with options. If the answer is no, checks the path that is kept, and returns the hints.
fn no(folder: &Folder, options: &str) -> Option<(Value, Vec<String>)> {
    let (answer, hints) = planned(folder, &format!("{options} --keep -o kept.fold"));
    if answer["outcome"] == "planned" {
        return None;
    }
    let reached = answer["reached"].as_f64().unwrap();
    if answer["knots"].as_u64() > Some(0) {
        let kept = folder.read_json("kept.fold");
        let frames = kept["file_frames"].as_array().unwrap();
        let end = frames[frames.len() - 1]["edges_foldAngle"]
            .as_array()
            .unwrap();
        let turned = end.iter().filter_map(Value::as_f64);
        let most = turned.fold(0.0, |most: f64, angle| most.max(angle.abs()));
        assert_eq!(most > 0.01, reached > 1e-3, "{options}: {answer}");
        assert_eq!(kept["foldpath:reached"], answer["reached"]);
        let checked = folder.run("check kept.fold --json").json();
        assert_eq!(checked["outcome"], "holds", "{options}: {answer} {checked}");
    }
    Some((answer, hints))
}

/// Returns the fold angles (degrees) at the end of the path that was kept.
fn kept_end(folder: &Folder) -> Vec<f64> {
    let kept = folder.read_json("kept.fold");
    let frames = kept["file_frames"].as_array().unwrap();
    let end = frames[frames.len() - 1]["edges_foldAngle"]
        .as_array()
        .unwrap();
    end.iter().filter_map(Value::as_f64).collect()
}

/// Two flaps of a gate meet where their tips touch: the kept path ends there, less than a hundredth of a degree before, and
/// a smaller fraction of a half turn is a plan.
#[test]
fn a_path_that_ends_at_a_crossing_is_kept_up_to_there() {
    for seed in 0..SHEETS {
        let mut rng = Random::stream(71, seed);
        // Equal flaps of width w at angle a meet where 1 + 2 w cos a = 0.
        // Wider than the panel between, they cannot fold one upon the other either.
        let width = rng.uniform(1.05, 1.6);
        let meet = (-0.5 / width).acos().to_degrees();
        let creases = [("V", None), ("V", None)];
        let folder = folder();
        folder.write(
            "sheet.fold",
            &strip(&[width, 1.0, width], &creases).to_string(),
        );
        let (answer, hints) = no(&folder, "").expect("a crossing");
        assert_eq!(answer["outcome"], "crossing");
        let reached = answer["reached"].as_f64().unwrap();
        assert!((180.0 * reached - meet).abs() < 0.01, "{reached} {meet}");
        for angle in kept_end(&folder).iter().filter(|angle| **angle != 0.0) {
            // Contact as deep as it may be is left, by a thousandth of a radian at most.
            assert!((angle - 180.0 * reached).abs() < 0.06, "{angle} {reached}");
        }
        // No order of the folds helps, and none is suggested.
        let notes = answer["notes"].as_array().unwrap();
        let mut notes = notes.iter().filter_map(Value::as_str);
        let no_order = "at the goal, which lies flat, faces 0, 1, 2 pass through each other";
        assert!(notes.any(|note| note.starts_with(no_order)), "{answer}");
        assert!(!hints.iter().any(|hint| hint == "--via FILE"), "{hints:?}");
        let fold = hints.iter().find(|hint| hint.starts_with("--fold"));
        let (less, _) = planned(&folder, fold.expect("a fraction"));
        assert_eq!(less["outcome"], "planned", "{less}");
    }
}

/// The flaps of the gate before, one of them with a notch: nothing is known of the order in which it is stacked, and another
/// order of the folds is suggested.
#[test]
fn where_another_order_may_help_it_is_suggested() {
    let folder = folder();
    let mut sheet = strip(&[1.2, 1.0, 1.2], &[("V", None), ("V", None)]);
    let mut push = |list: &str, value: Value| {
        let list = sheet[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    };
    let notch = push("vertices_coords", json!([0.3, 0.5]));
    push("edges_vertices", json!([0, notch]));
    push("edges_assignment", json!("B"));
    push("edges_foldAngle", Value::Null);
    sheet["edges_vertices"][0] = json!([notch, 4]);
    folder.write("sheet.fold", &sheet.to_string());
    let (answer, hints) = no(&folder, "").expect("a crossing");
    assert_eq!(answer["outcome"], "crossing");
    assert!(hints.iter().any(|hint| hint == "--via FILE"), "{hints:?}");
}

/// A limit that stops a hinge is named, with the angle, and the path is kept up to it.
#[test]
fn a_path_that_ends_at_a_limit_names_the_hinge() {
    for seed in 0..SHEETS {
        let mut rng = Random::stream(72, seed);
        let folder = folder();
        let angle = rng.uniform(40.0, 80.0);
        folder.done(&format!(
            "generate miura --rows 3 --cols 3 --angle {angle} -o sheet.fold"
        ));
        let sheet = folder.read_json("sheet.fold");
        let letters = sheet["edges_assignment"].as_array().unwrap();
        let hinges =
            (0..letters.len()).filter(|edge| ["M", "V"].map(Value::from).contains(&letters[*edge]));
        let hinges: Vec<usize> = hinges.collect();
        let edge = hinges[rng.below(hinges.len())];
        let most = rng.uniform(5.0, 60.0);
        let range = if letters[edge] == "M" {
            format!("{}..0", -most)
        } else {
            format!("0..{most}")
        };
        let limit = format!("--limit {edge}={range}");
        let (answer, hints) = no(&folder, &limit).expect("a limit");
        let reason = answer["reason"].as_str().unwrap();
        assert!(reason.contains("a hinge is at its limit of"), "{reason}");
        assert!((kept_end(&folder)[edge].abs() - most).abs() < 1e-6);
        assert_eq!(hints, [limit]);
    }
}

/// Letters at a vertex that cannot fold flat lead as far as a hinge is half a turn, or are proved or named as wrong.
#[test]
fn letters_that_lead_part_of_the_way_name_the_part() {
    let (mut followed, mut helped) = (0, 0);
    for seed in 0..3 * SHEETS {
        let mut rng = Random::stream(73, seed);
        let odd = rng.below(4);
        let letters = [0, 1, 2, 3].map(|crease| if crease == odd { "M" } else { "V" });
        let folder = folder();
        folder.write("sheet.fold", &vertex(&mut rng, &letters, None).to_string());
        let Some((answer, hints)) = no(&folder, "") else {
            continue;
        };
        for hint in &hints {
            let (less, _) = planned(&folder, hint);
            followed += 1;
            helped += usize::from(less["outcome"] == "planned");
        }
        let notes = answer["notes"].as_array().unwrap().iter();
        let mut notes = notes.filter_map(Value::as_str);
        assert!(!hints.is_empty() || notes.any(|note| note.starts_with("in the way")));
    }
    // The hint says that it may do.
    assert!(
        followed > 1 && 2 * helped >= followed,
        "{helped} of {followed}"
    );
}

/// A goal that does not close names the goal tolerance with which the configuration that was found will do.
#[test]
fn a_goal_that_does_not_close_names_the_tolerance() {
    let mut followed = 0;
    for seed in 0..3 * SHEETS {
        let mut rng = Random::stream(74, seed);
        let folder = folder();
        let right = ["V", "V", "V", "M"];
        folder.write("sheet.fold", &vertex(&mut rng, &right, None).to_string());
        let drive = format!("--crease 4={}", rng.uniform(20.0, 50.0));
        let (closed, _) = planned(&folder, &format!("{drive} --keep -o closed.fold"));
        if closed["outcome"] != "planned" {
            continue;
        }
        let path = folder.read_json("closed.fold");
        let frames = path["file_frames"].as_array().unwrap();
        let mut sheet = folder.read_json("sheet.fold");
        sheet["edges_foldAngle"] = frames[frames.len() - 1]["edges_foldAngle"].clone();
        for edge in 4..8 {
            let angle = sheet["edges_foldAngle"][edge].as_f64().unwrap();
            sheet["edges_foldAngle"][edge] = json!(angle * rng.uniform(0.85, 1.15));
        }
        folder.write("sheet.fold", &sheet.to_string());
        let Some((answer, hints)) = no(&folder, "") else {
            continue;
        };
        for hint in hints
            .iter()
            .filter(|hint| hint.starts_with("--goal-tolerance"))
        {
            let (near, _) = planned(&folder, hint);
            assert_eq!(near["outcome"], "planned", "{hint}: {answer} {near}");
            followed += 1;
        }
    }
    assert!(followed > 4, "{followed}");
}
