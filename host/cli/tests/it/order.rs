//! Hinges fold in the order that the user asks for.

use serde_json::{Value, json};

use crate::common::folder;

/// Returns a strip of panels with these lengths, whose hinges are valleys with these goal angles, degrees. The hinges are the
/// edges from 0 on.
fn strip(lengths: &[f64], goals: &[f64]) -> String {
    let mut x = vec![0.0];
    for length in lengths {
        x.push(x[x.len() - 1] + length);
    }
    let (count, last) = (x.len(), x.len() - 1);
    let lower = x.iter().map(|x| json!([x, 0]));
    let vertices: Vec<Value> = lower.chain(x.iter().map(|x| json!([x, 1]))).collect();
    let hinges = (1..last).map(|k| [k, count + k]);
    let sides = (0..last).flat_map(|k| [[k, k + 1], [count + k, count + k + 1]]);
    let ends = [[0, count], [last, count + last]];
    let edges: Vec<[usize; 2]> = hinges.chain(sides).chain(ends).collect();
    let letter = |k: usize| if k < goals.len() { "V" } else { "B" };
    let angle = |k: usize| goals.get(k).copied().unwrap_or(0.0);
    json!({
        "file_spec": 1.2,
        "vertices_coords": vertices,
        "edges_vertices": edges,
        "edges_assignment": (0..edges.len()).map(letter).collect::<Vec<_>>(),
        "edges_foldAngle": (0..edges.len()).map(angle).collect::<Vec<_>>(),
    })
    .to_string()
}

/// Plans in an order and returns the angles of the first hinges at the knots, degrees.
fn planned(text: &str, options: &str, hinges: usize) -> Vec<Vec<f64>> {
    let folder = folder();
    folder.write("a.fold", text);
    let plan = folder
        .command("plan a.fold -o path.fold --order")
        .arg(options)
        .output()
        .unwrap();
    assert!(
        plan.status.success(),
        "{}",
        String::from_utf8_lossy(&plan.stderr)
    );
    let path = folder.read_json("path.fold");
    let frames = path["file_frames"].as_array().unwrap().iter();
    let angles = frames.filter_map(|frame| frame["edges_foldAngle"].as_array());
    let angles = angles.map(|angles| {
        angles[..hinges]
            .iter()
            .map(|angle| angle.as_f64().unwrap())
            .collect()
    });
    angles.collect()
}

/// Returns the knots at which the hinges turn, and for each hinge the first and the last knot before and after which it rests.
fn turning(knots: &[Vec<f64>], hinge: usize) -> [usize; 2] {
    let turns = |k: &usize| (knots[*k][hinge] - knots[*k + 1][hinge]).abs() > 1e-9;
    let mut turning = (0..knots.len() - 1).filter(turns);
    let first = turning.next().unwrap();
    [first, turning.next_back().unwrap_or(first) + 1]
}

#[test]
fn hinges_turn_in_their_steps_alone() {
    let text = strip(&[1.0, 1.0, 1.0, 1.0, 1.0], &[60.0, 70.0, 80.0, 50.0]);
    let knots = planned(&text, "2 / 0,1", 4);
    let [first, second, third, last] = [2, 0, 1, 3].map(|hinge| turning(&knots, hinge));
    assert!(
        first[1] <= second[0] && second == third && third[1] <= last[0],
        "{knots:?}"
    );
    let end = knots.last().unwrap();
    for (angle, goal) in end.iter().zip([60.0, 70.0, 80.0, 50.0]) {
        assert!((angle - goal).abs() < 1e-9, "{end:?}");
    }
    // A range has borders in it, and a hinge that stands twice goes beyond its goal and returns.
    let knots = planned(&text, "0-1=100 / 0-9", 4);
    let most = |hinge: usize| knots.iter().map(|knot| knot[hinge]).fold(0.0, f64::max);
    assert!(
        (most(0) - 100.0).abs() < 1e-9 && (most(1) - 100.0).abs() < 1e-9,
        "{knots:?}"
    );
    assert!((knots.last().unwrap()[0] - 60.0).abs() < 1e-9);
}

/// A strip folds all at once, which is the one order that is listed. Hinges that meet inside the sheet have no order.
#[test]
fn an_order_is_listed_of_hinges_that_turn_freely() {
    let folder = folder();
    folder.write("a.fold", &strip(&[1.0, 1.0, 1.0, 1.0], &[60.0, 70.0, 50.0]));
    let listed = |options: &str| {
        folder.done(&format!("plan a.fold {options} --json")).json()["orders"].clone()
    };
    assert_eq!(listed("--orders 3"), json!(["0,1,2"]));
    assert_eq!(
        listed("--orders 3 --crease 0=30 --crease 1=20 --crease 2=10"),
        json!(["0=30,1=20,2=10"])
    );
    assert_eq!(listed(""), Value::Null);
    folder.done("generate miura --rows 3 --cols 3 -o a.fold");
    assert_eq!(listed("--orders 3"), json!([]));
}

/// Creases of other steps that meet those of a step move with them.
#[test]
fn creases_that_meet_move_together() {
    let folder = folder();
    folder.done("generate miura --rows 3 --cols 3 -o a.fold");
    let plan = folder
        .done("plan a.fold -o path.fold --json --order 4 --fold 0.5")
        .json();
    assert_eq!(plan["outcome"], "planned", "{plan}");
    assert_eq!(plan["options"]["order"], "4");
}

#[test]
fn the_step_that_fails_is_named() {
    let folder = folder();
    folder.write("a.fold", &strip(&[1.5, 1.0, 1.0], &[90.0, 90.0]));
    for (order, step) in [
        ("1 / 0=170 / 0", "step 2 of the order (edges 0=170)"),
        ("1 / 0=170", "step 2"),
    ] {
        let mut command = folder.command("plan a.fold --json --order");
        let answer = command.arg(order).output().unwrap();
        assert_eq!(answer.status.code(), Some(1));
        let plan: Value = serde_json::from_slice(&answer.stdout).unwrap();
        assert_eq!(plan["outcome"], "crossing", "{plan}");
        let notes = plan["notes"].to_string();
        assert!(
            notes.contains(&format!("the path ends in {step}")),
            "{notes}"
        );
        assert!(
            plan["reason"]
                .as_str()
                .unwrap()
                .starts_with("faces 0 and 2 pass through each other"),
            "{plan}"
        );
    }
    for (order, words) in [
        (
            "0 / x",
            "expected the name of a hinge between two faces, but no hinge of the drawing has a name",
        ),
        ("0 / 3-1", "expected an edge such as 5"),
        ("0=999", "expected an angle from -180 to 180 degrees"),
        ("", "expected an edge such as 5"),
        ("7", "edge 7: expected a hinge between two faces"),
        ("0-99", "edge 99: expected a hinge between two faces"),
    ] {
        let mut command = folder.command("plan a.fold --order");
        let answer = command.arg(order).output().unwrap();
        let said = String::from_utf8_lossy(&answer.stderr).into_owned();
        assert_eq!(answer.status.code(), Some(2), "{said}");
        assert!(
            said.contains("order") && said.contains(words),
            "{words}: {said}"
        );
    }
    folder.write(
        "b.fold",
        &strip(&[1.0, 1.0], &[90.0])
            .replace("\"V\"", "\"U\"")
            .replace("90.0", "null"),
    );
    let said = folder
        .run("plan b.fold --order 0 --fold 0.5")
        .with_status(2)
        .stderr;
    assert!(!said.is_empty());
}

/// Returns the strip with a frame for each list of angles of its hinges, degrees; `null` where the frame says nothing.
fn with_frames(strip: &str, frames: &[[Value; 2]]) -> String {
    let mut file: Value = serde_json::from_str(strip).unwrap();
    let others = file["edges_vertices"].as_array().unwrap().len() - 2;
    let frames = frames.iter().map(|angles| {
        let angles = angles.iter().cloned();
        let angles: Vec<Value> = angles.chain((0..others).map(|_| json!(0))).collect();
        json!({
            "frame_classes": ["foldedForm"], "frame_parent": 0, "frame_inherit": true,
            "edges_foldAngle": angles,
        })
    });
    file["file_frames"] = frames.collect();
    file.to_string()
}

/// Frames are steps as those that are written out: the same path comes of both.
#[test]
fn frames_of_a_file_are_steps() {
    let folder = folder();
    let text = strip(&[2.0, 1.0, 1.5], &[60.0, 70.0]);
    let frames = [
        [json!(0), json!(0)],
        [json!(null), json!(100)],
        [json!(60), json!(100)],
        [json!(60), json!(70)],
    ];
    folder.write("a.fold", &text);
    folder.write("steps.fold", &with_frames(&text, &frames));
    let mut paths = Vec::new();
    // The frame of the flat sheet is a step in which nothing turns.
    for (pattern, order) in [
        ("a.fold", "steps.fold"),
        ("steps.fold", "steps.fold"),
        ("a.fold", "0=0,1=0 / 1=100 / 0 / 1"),
    ] {
        let mut command = folder.command(&format!("plan {pattern} -o path.fold --json --order"));
        let answer = command.arg(order).output().unwrap();
        let plan: Value = serde_json::from_slice(&answer.stdout).unwrap();
        assert_eq!(plan["outcome"], "planned", "{order}: {plan}");
        assert_eq!(plan["options"]["order"], order);
        paths.push(folder.read_json("path.fold")["file_frames"].take());
    }
    assert_eq!(paths[0], paths[2]);
    assert_eq!(paths[1], paths[2]);
}

#[test]
fn a_frame_that_fails_is_named() {
    let folder = folder();
    let text = strip(&[1.5, 1.0, 1.0], &[90.0, 90.0]);
    folder.write("a.fold", &text);
    folder.write(
        "steps.fold",
        &with_frames(&text, &[[json!(0), json!(90)], [json!(170), json!(90)]]),
    );
    let answer = folder
        .run("plan a.fold --json --order steps.fold")
        .with_status(1);
    let plan = answer.json();
    assert_eq!(plan["outcome"], "crossing", "{plan}");
    let notes = plan["notes"].to_string();
    assert!(
        notes.contains("the path ends in step 2 of the order (keyframe 2 of steps.fold)"),
        "{notes}"
    );
    let few = with_frames(&text, &[[json!(0), json!(90)]]).replace(",0,0]", "]");
    for (file, words) in [
        (
            text.as_str(),
            "file_frames: expected frames with edges_foldAngle, found none",
        ),
        (
            &few,
            "file_frames[0].edges_foldAngle: expected 10 entries, one for each edge, found 8",
        ),
    ] {
        folder.write("steps.fold", file);
        let said = folder
            .run("plan a.fold --order steps.fold")
            .with_status(2)
            .stderr;
        assert!(said.contains(words), "{said}");
    }
    let said = folder
        .run("plan a.fold --order none.fold")
        .with_status(2)
        .stderr;
    assert!(said.contains("none.fold"), "{said}");
}
