//! Tests FOLD files that leave things out or state them in another way, and are read all the same.

use crate::common::{folder, folder_with_path, pattern};
use foldpath_test_support::{Folder, edited, numbers};
use serde_json::{Value, json};

/// Returns the answer of `foldpath info` to a document without its notes, and the notes.
fn info(document: &Value) -> (Value, Value) {
    let folder = folder();
    folder.write("odd.fold", &document.to_string());
    let mut info = folder.done("info odd.fold --json").json();
    let notes = info["assumptions"].take();
    (info, notes)
}

#[test]
fn what_is_said_in_other_words_is_the_same_pattern() {
    let (expected, _) = info(&pattern());
    assert_eq!(expected["faces"], 9);
    for edits in [
        "/faces_vertices =",
        "/faces_vertices = []",
        "/faces_vertices/0 = [5,1,0,4]",
        "/edges_foldAngle/0 = null",
        "/file_spec = 1; /file_creator =",
        "/frame_unit = \"mm\"; /vertices_edges = []; /foldpath:seed = 1",
        "/file_frames = [{\"frame_title\":\"no angles here\"}]",
    ] {
        assert_eq!(
            info(&edited(&pattern(), edits)),
            (expected.clone(), json!([])),
            "{edits}"
        );
    }
}

#[test]
fn what_is_left_out_or_unknown_is_assumed_and_said() {
    let odd = |edits: &str| info(&edited(&pattern(), edits));

    let (found, notes) = odd("/edges_assignment = ; /edges_foldAngle =");
    let missing = "edges_assignment is missing: all inner edges taken as free hinges (U)";
    assert!(
        notes.as_array().unwrap().contains(&json!(missing)),
        "{notes}"
    );
    assert_eq!(
        (&found["free_hinges"], &found["letters"]["U"]),
        (&json!(12), &json!(12))
    );
    assert_eq!(found["closure_goal"], Value::Null);

    let (found, notes) = odd("/edges_vertices = ; /edges_assignment = ; /edges_foldAngle =");
    let missing = "edges_vertices is missing: edges taken from the faces";
    assert!(
        notes.as_array().unwrap().contains(&json!(missing)),
        "{notes}"
    );
    assert_eq!(
        (&found["edges"], &found["creases"]),
        (&json!(24), &json!(12))
    );

    let (found, notes) = odd("/edges_assignment/2 = \"Q\"; /edges_assignment/4 = \"Q\"");
    let unknown = "2 edges lettered \"Q\", which FOLD does not know, taken as U";
    assert_eq!(notes, json!([unknown]));
    assert_eq!(found["free_hinges"], 2);

    let (expected, _) = info(&pattern());
    let small = "letters in edges_assignment that are written small, taken as capitals: 2";
    let found = odd("/edges_assignment/4 = \"m\"; /edges_assignment/0 = \"b\"");
    assert_eq!(found, (expected, json!([small])));
}

/// A note names unknown keys of the key frame and of all other frames, each key once and at most eight keys.
#[test]
fn keys_that_nobody_knows_are_left_alone_and_said() {
    let (expected, _) = info(&pattern());
    let many: Vec<String> = (0..10).map(|key| format!("/key{key} = {{}}")).collect();
    let long = format!("/a\u{e4}\u{1b}{} = 1", "x".repeat(50));
    for (edits, named) in [
        ("/unknown = [1,2]; /other:own = {\"in it\": 1}", "\"other:own\", \"unknown\"".into()),
        (
            "/foldpath:edges_groups = []; /file_frames = [{\"edges_foldangle\":[1]},{\"edges_foldangle\":[]}]",
            "\"edges_foldangle\", \"foldpath:edges_groups\"".into(),
        ),
        (
            &many.join("; "),
            "\"key0\", \"key1\", \"key2\", \"key3\", \"key4\", \"key5\", \"key6\", \"key7\" and 2 more".into(),
        ),
        (&long, format!("\"a\u{e4}\\u{{1b}}{}\"", "x".repeat(37))),
    ] {
        let said = format!("keys not known, and left alone: {named}");
        let found = info(&edited(&pattern(), edits));
        assert_eq!(found, (expected.clone(), json!([said])), "{edits}");
    }
    let letters = pattern()["edges_assignment"].to_string();
    let misspelt =
        format!("/edges_assignment = ; /edges_foldAngle = ; /edges_assignments = {letters}");
    let (_, notes) = info(&edited(&pattern(), &misspelt));
    let said = "keys not known, and left alone: \"edges_assignments\"";
    assert!(notes.as_array().unwrap().contains(&json!(said)), "{notes}");
    let folder = folder_with_path();
    let path = edited(&folder.read_json("path.fold"), "/file_frames/2/own = 1");
    folder.write("path.fold", &path.to_string());
    for command in ["check path.fold", "unfold path.fold -o again.fold"] {
        let told = folder.done(command).stderr;
        assert_eq!(
            told, "note: keys not known, and left alone: \"own\"\n",
            "{command}"
        );
    }
}

#[test]
fn flat_edges_are_no_creases() {
    for letter in ["F", "J"] {
        let edit = format!("/edges_assignment/10 = \"{letter}\"");
        let (found, _) = info(&edited(&pattern(), &edit));
        assert_eq!(
            (&found["creases"], &found["virtual_edges"]),
            (&json!(11), &json!(10))
        );
    }
}

/// Edges lettered F and borders do not turn. If some hinges have an angle, the hinges without one are free. If no hinge
/// has an angle, the letters are the goal.
#[test]
fn angles_are_for_hinges_and_hinges_may_have_none() {
    let said = "goal angles of edges that are no hinges left out: 2 (first: edge 0)";
    let edits = "/edges_assignment/10 = \"F\"; /edges_foldAngle/0 = -30; /edges_foldAngle/1 = 0";
    let (found, notes) = info(&edited(&pattern(), edits));
    assert_eq!(notes, json!([said]));
    assert_eq!(found["creases"], 11);

    let folder = folder();
    let goals = numbers(&pattern()["edges_foldAngle"]);
    let one: Vec<_> = (0..goals.len())
        .map(|edge| if edge == 4 { json!(-90) } else { Value::Null })
        .collect();
    for (angles, source) in [
        (json!(one), "the pattern's goal angles"),
        (
            json!(vec![Value::Null; goals.len()]),
            "the letters at 1.0000 of a half turn",
        ),
    ] {
        let mut document = pattern();
        document["edges_foldAngle"] = angles;
        folder.write("null.fold", &document.to_string());
        let plan = folder.done("plan null.fold -o path.fold");
        assert!(
            plan.stdout.contains(&format!("  goal         {source}\n")),
            "{plan:?}"
        );
        let frames = folder.read_json("path.fold")["file_frames"].take();
        let last = numbers(&frames.as_array().unwrap().last().unwrap()["edges_foldAngle"]);
        // All hinges turn as their letters say, also those without a goal angle.
        for (asked, found) in goals
            .iter()
            .zip(&last)
            .filter(|(asked, _)| asked.abs() > 0.0)
        {
            assert!(asked * found > 0.0, "{last:?}");
        }
    }
}

#[test]
fn a_sheet_may_stand_upright() {
    let mut upright = pattern();
    for point in upright["vertices_coords"].as_array_mut().unwrap() {
        *point = json!([point[0], 0, point[1]]);
    }
    let (found, notes) = info(&upright);
    let (expected, _) = info(&pattern());
    for key in [
        "faces",
        "creases",
        "real_vertices",
        "groups",
        "essential_vertices",
    ] {
        assert_eq!(found[key], expected[key], "{key}");
    }
    assert!(
        notes[0]
            .as_str()
            .unwrap()
            .contains("seen from its upper side"),
        "{notes}"
    );
}

/// The goal is that of the last folded frame, whichever frame has the crease pattern.
#[test]
fn pattern_and_goal_may_stand_in_frames() {
    let folder = folder();
    folder.write("plain.fold", &pattern().to_string());
    folder.done("plan plain.fold -o plain.path.fold");

    let mut flat = pattern();
    let goal = flat["edges_foldAngle"].take();
    let half: Vec<f64> = numbers(&goal).iter().map(|angle| angle / 2.0).collect();
    flat.as_object_mut().unwrap().remove("edges_foldAngle");
    let frame = |angles: Value, parent: u32| {
        json!({
            "frame_classes": ["foldedForm"], "frame_parent": parent, "frame_inherit": true,
            "edges_foldAngle": angles,
        })
    };
    let mut in_key_frame = flat.clone();
    in_key_frame["file_frames"] = json!([frame(json!(half), 0), frame(goal.clone(), 1)]);
    let in_frame =
        json!({"file_title": flat["file_title"].clone(), "file_frames": [flat, frame(goal, 1)]});
    for document in [in_key_frame, in_frame] {
        folder.write("framed.fold", &document.to_string());
        folder.done("plan framed.fold -o framed.path.fold");
        assert_eq!(
            folder.read("framed.path.fold"),
            folder.read("plain.path.fold")
        );
    }
}

/// `edges_foldAngle` was called `edges_foldAngles` before FOLD 1.1.
#[test]
fn goal_angles_of_fold_1_0_are_read() {
    let mut old = pattern();
    old["file_spec"] = json!(1);
    old["edges_foldAngles"] = old
        .as_object_mut()
        .unwrap()
        .remove("edges_foldAngle")
        .unwrap();
    let (found, _) = info(&old);
    assert!(
        found["closure_goal"]
            .as_f64()
            .is_some_and(|closure| closure < 1e-12),
        "{found}"
    );
}

/// Frames inherit from frames, including their classes. The goal is that of the last frame that is a folded form.
#[test]
fn frames_inherit_along_chains() {
    let (expected, _) = info(&pattern());
    let mut flat = pattern();
    let object = flat.as_object_mut().unwrap();
    let goal = object.remove("edges_foldAngle").unwrap();
    let letters = object.remove("edges_assignment").unwrap();
    let frame = |parent: u32| json!({"frame_parent": parent, "frame_inherit": true});
    let with = |mut frame: Value, key: &str, value: Value| {
        frame[key] = value;
        frame
    };
    let zeros = vec![0.0; numbers(&goal).len()];
    flat["frame_classes"] = json!(["graph"]);
    let frames = json!([
        with(
            with(frame(0), "edges_assignment", letters),
            "frame_classes",
            json!(["creasePattern"])
        ),
        with(
            with(frame(1), "edges_foldAngle", json!(zeros)),
            "frame_classes",
            json!(["foldedForm"])
        ),
        with(frame(2), "edges_foldAngle", goal),
        with(frame(3), "frame_title", json!("no angles of its own")),
    ]);
    flat["file_frames"] = frames.clone();
    assert_eq!(info(&flat), (expected.clone(), json!([])));
    // The order of the frames does not matter: the second and the fourth frame come before those from which they
    // inherit.
    let mut mixed = [1, 0, 3, 2].map(|index: usize| frames[index].clone());
    for (frame, parent) in mixed.iter_mut().zip([2, 0, 4, 1]) {
        frame["frame_parent"] = json!(parent);
    }
    flat["file_frames"] = json!(mixed);
    assert_eq!(info(&flat), (expected, json!([])));
}

/// Some programs list no edges, but for each vertex its neighbours.
#[test]
fn edges_may_be_given_by_the_neighbours_of_vertices() {
    let mut lists = pattern();
    let object = lists.as_object_mut().unwrap();
    object.remove("edges_assignment");
    object.remove("edges_foldAngle");
    object.remove("faces_vertices");
    let edges = object.remove("edges_vertices").unwrap();
    let count = lists["vertices_coords"].as_array().unwrap().len();
    let mut neighbours = vec![vec![]; count];
    for edge in edges.as_array().unwrap() {
        let [a, b] = [0, 1].map(|end| usize::try_from(edge[end].as_u64().unwrap()).unwrap());
        neighbours[a].push(b);
        neighbours[b].push(a);
    }
    lists["vertices_vertices"] = json!(neighbours);
    let (found, notes) = info(&lists);
    for (key, value) in [("edges", 24), ("faces", 9), ("free_hinges", 12)] {
        assert_eq!(found[key], value, "{key}");
    }
    let said = "edges_vertices is missing: edges taken from vertices_vertices";
    assert!(notes.as_array().unwrap().contains(&json!(said)), "{notes}");
}

/// Programs on Windows may begin a text with a byte order mark.
#[test]
fn a_byte_order_mark_is_no_part_of_the_text() {
    let folder = folder();
    folder.write("marked.fold", &format!("\u{feff}{}", pattern()));
    assert_eq!(folder.done("info marked.fold --json").json()["faces"], 9);
}

/// Two lines that cross, one of them drawn twice, and a line along the border. Without faces in the file, the crossing
/// becomes a vertex, as in a drawing. If the file has faces, nothing is repaired.
#[test]
fn lines_without_faces_are_repaired_and_lines_of_faces_refused() {
    let loose = json!({
        "vertices_coords": [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [1, 2], [0, 1], [2, 1]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 4], [6, 7], [0, 4]],
        "edges_assignment": ["B", "B", "B", "B", "V", "V", "M", "B"],
        "edges_foldAngle": [0, 0, 0, 0, 30, 30, 0, 0],
    });
    let folder = folder();
    folder.write("loose.fold", &loose.to_string());
    let found = folder.done("info loose.fold --json").json();
    assert_eq!(
        [&found["faces"], &found["creases"], &found["real_vertices"]],
        [&json!(4), &json!(4), &json!(1)],
        "{found}"
    );
    assert!(!found["repairs"].as_array().unwrap().is_empty());
    let anew = json!("edges are counted anew, as lines were repaired");
    assert!(found["assumptions"].as_array().unwrap().contains(&anew));
    folder.done("plan loose.fold -o path.fold");
    folder.done("check path.fold");

    let faces = edited(&loose, "/faces_vertices = [[0,1,2,3]]");
    folder.write("faces.fold", &faces.to_string());
    folder.run("info faces.fold").with_status(2);
}

/// Returns the pattern with a folded frame in place of goal angles, and the goal angles. The frame has each vertex
/// where the goal of the pattern puts it, moved by `place`.
fn shown(place: impl Fn([f64; 3]) -> Vec<f64>) -> (Value, Value) {
    let folder = folder();
    folder.write("p.fold", &pattern().to_string());
    folder.done("plan p.fold -o path.fold");
    let path = folder.read_json("path.fold");
    let goal = path["file_frames"].as_array().unwrap().last().unwrap();
    let vertices = goal["vertices_coords"].as_array().unwrap();
    let vertices = vertices.iter().map(|vertex| {
        let at: [f64; 3] = serde_json::from_value(vertex.clone()).unwrap();
        json!(place(at))
    });
    let mut flat = edited(&pattern(), "/edges_foldAngle =");
    flat["file_frames"] = json!([{
        "frame_classes": ["foldedForm"],
        "frame_parent": 0,
        "frame_inherit": true,
        "vertices_coords": vertices.collect::<Vec<_>>(),
    }]);
    (flat, goal["edges_foldAngle"].clone())
}

#[test]
fn a_goal_may_be_shown() {
    let near = |found: &Value, expected: &Value, error: f64| {
        let pairs = numbers(found).into_iter().zip(numbers(expected));
        for (edge, (found, expected)) in pairs.enumerate() {
            assert!(
                (found - expected).abs() <= error,
                "{edge}: {found}, not {expected}"
            );
        }
    };
    let goal_of = |folder: &Folder, arguments: &str| {
        let answer = folder.done(arguments).json();
        assert_eq!(answer["outcome"], "planned", "{answer}");
        let path = folder.read_json("path.fold");
        path["file_frames"].as_array().unwrap().last().unwrap()["edges_foldAngle"].clone()
    };
    for (name, error, place) in [
        (
            "as it is",
            1e-6,
            (|at| at.to_vec()) as fn([f64; 3]) -> Vec<f64>,
        ),
        ("elsewhere, larger", 1e-6, |[x, y, z]| {
            vec![7.0 - 2.0 * y, 2.0 * x, 2.0 * z]
        }),
        ("from below", 1e-6, |[x, y, z]| vec![x, y, -z]),
        ("rounded", 0.01, |at| {
            at.map(|x| (x * 1e6).round() / 1e6).to_vec()
        }),
    ] {
        let (shown, expected) = shown(place);
        let folder = folder();
        folder.write("shown.fold", &shown.to_string());
        near(
            &goal_of(&folder, "plan shown.fold -o path.fold --json"),
            &expected,
            error,
        );
        let notes = folder.done("info shown.fold --json").json()["assumptions"].take();
        let said = json!(["the goal is measured on file_frames[0].vertices_coords"]);
        assert_eq!(notes, said, "{name}");
        // The goal may also be shown by another file.
        folder.write("flat.fold", &edited(&shown, "/file_frames =").to_string());
        let other = "plan flat.fold --goal shown.fold -o path.fold --json";
        near(&goal_of(&folder, other), &expected, error);
    }
}

#[test]
fn a_frame_that_shows_another_sheet_is_no_goal() {
    let (whole, _) = shown(|at| at.to_vec());
    for (edits, expected) in [
        (
            "/file_frames/0/vertices_coords = [[0,0,0]]",
            "16 entries, one for each vertex, found 1",
        ),
        (
            "/file_frames/0/vertices_coords/5 = [9,9,9]",
            "the sheet, its edges as long as in the crease pattern, found edge",
        ),
        ("/file_frames/0/vertices_coords/5/0 = \"x\"", "a number"),
    ] {
        let folder = folder();
        let odd = edited(&whole, edits);
        folder.write("odd.fold", &odd.to_string());
        let notes = folder.done("info odd.fold --json").json()["assumptions"].take();
        let note = notes[0].as_str().unwrap();
        assert!(
            note.contains("the folded frame is no goal"),
            "{edits}: {note}"
        );
        assert!(note.contains(expected), "{edits}: {note}");
        folder.write("flat.fold", &edited(&odd, "/file_frames =").to_string());
        let failed = folder.run("plan flat.fold --goal odd.fold").with_status(2);
        let line = failed.stderr.replace('\n', " ");
        assert!(line.contains(expected), "{edits}: {line}");
    }
}

/// A strip of two panels, with these letters and angles of its seven edges.
fn strip_of_two() -> Value {
    json!({
        "vertices_coords": [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4]],
        "edges_assignment": ["B", "B", "B", "B", "B", "B", "V"],
        "faces_vertices": [[0, 1, 4, 5], [1, 2, 3, 4]],
    })
}

/// Edges that are written twice are left out where a file has faces, as where it has none.
#[test]
fn doubled_edges_beside_faces_are_left_out() {
    let folder = folder();
    let mut file = strip_of_two();
    for (ends, letter) in [([1, 4], "F"), ([4, 1], "V"), ([2, 1], "M")] {
        file["edges_vertices"]
            .as_array_mut()
            .unwrap()
            .push(json!(ends));
        file["edges_assignment"]
            .as_array_mut()
            .unwrap()
            .push(json!(letter));
    }
    folder.write("a.fold", &file.to_string());
    let with_faces = folder.done("info a.fold --json").json();
    let said = with_faces["assumptions"].to_string();
    assert!(said.contains("left out: 3 (first: edge 7)"), "{said}");
    file.as_object_mut().unwrap().remove("faces_vertices");
    folder.write("b.fold", &file.to_string());
    let without = folder.done("info b.fold --json").json();
    for key in ["edges", "faces", "creases"] {
        assert_eq!(with_faces[key], without[key], "{key}");
    }
    assert_eq!(with_faces["letters"]["V"], 1);
}

/// Angles in radians are read as degrees, as FOLD says, and a note tells of it. Small angles in degrees are not suspected.
#[test]
fn angles_that_look_like_radians_are_told() {
    let folder = folder();
    for (angle, is_told) in [
        (core::f64::consts::PI, true),
        (core::f64::consts::FRAC_PI_2, true),
        (2.5, false),
        (180.0, false),
        (3.0, false),
    ] {
        let mut file = strip_of_two();
        file["edges_foldAngle"] = json!([0, 0, 0, 0, 0, 0, angle]);
        folder.write("a.fold", &file.to_string());
        let said = folder.done("info a.fold --json").json()["assumptions"].to_string();
        assert_eq!(said.contains("radians"), is_told, "{angle}: {said}");
    }
}

/// A second pattern in a file is told, and `--frame` selects it with its goal.
#[test]
fn another_pattern_of_a_file_is_told_and_selected() {
    let folder = folder();
    let mut file = strip_of_two();
    let mut second = strip_of_two();
    second["vertices_coords"] = json!([[0, 0], [1, 0], [4, 0], [4, 1], [1, 1], [0, 1]]);
    second["edges_assignment"][6] = json!("M");
    second["edges_foldAngle"] = json!([0, 0, 0, 0, 0, 0, -90]);
    second["frame_classes"] = json!(["creasePattern"]);
    file["frame_classes"] = json!(["creasePattern"]);
    file["file_frames"] = json!([second]);
    folder.write("a.fold", &file.to_string());
    for (option, letter, other) in [
        ("", "V", "1"),
        ("--frame 0", "V", "1"),
        ("--frame 1", "M", "0"),
    ] {
        let answer = folder.done(&format!("info a.fold --json {option}")).json();
        assert_eq!(answer["letters"][letter], 1, "{option}: {answer}");
        let said = answer["assumptions"].to_string();
        assert!(
            said.contains(&format!("the key frame: {other}")),
            "{option}: {said}"
        );
    }
    folder.done("plan a.fold --frame 1 -o path.fold");
    let path = folder.read_json("path.fold");
    assert_eq!(path["vertices_coords"][2], json!([4.0, 0.0]));
    let refused = folder.run("info a.fold --frame 2").with_status(2);
    assert!(
        refused.tells("a.fold: file_frames[1]: expected a frame, found none"),
        "{}",
        refused.stderr
    );
    folder.write("a.cp", "1 0 0 1 0\n");
    let refused = folder.run("info a.cp --frame 1").with_status(2);
    assert!(
        refused.tells("a.cp: the frame: expected a FOLD file, which has frames, found a CP file"),
        "{}",
        refused.stderr
    );
    // A file with one pattern says nothing of others.
    folder.write("b.fold", &strip_of_two().to_string());
    let said = folder.done("info b.fold --json").json()["assumptions"].to_string();
    assert!(!said.contains("other crease patterns"), "{said}");
}

/// Files of other programs are refused with the way out, and comments in JSON are named.
#[test]
fn files_of_other_programs_are_refused_with_the_way_out() {
    let folder = folder();
    for (name, text, expected) in [
        (
            "a.ori",
            r#"{"version":"1.1.3","lineSegments":[]}"#,
            "export the drawing as CP or FOLD",
        ),
        ("a.orh", "<線分集合>\n", "export the drawing as CP or FOLD"),
        ("a.tmd5", "tree\n4.0\n", "TreeMaker"),
        ("a.pdf", "%PDF-1.4\n", "as SVG"),
        ("a.ply", "ply\nformat ascii 1.0\n", "as OBJ or STL"),
        (
            "line.fold",
            "{\n  // mine\n  \"vertices_coords\": []}",
            "JSON has no comments",
        ),
        (
            "block.fold",
            "{ /* mine */ \"vertices_coords\": []}",
            "JSON has no comments",
        ),
        (
            "behind.fold",
            "{\"vertices_coords\": [], // mine\n \"a\": 1}",
            "JSON has no comments",
        ),
        (
            "list.fold",
            "{\"vertices_coords\": [ // mine\n 1]}",
            "JSON has no comments",
        ),
    ] {
        folder.write(name, text);
        let refused = folder.run(&format!("info {name}")).with_status(2);
        assert!(
            refused.stderr.contains(expected),
            "{name}: {}",
            refused.stderr
        );
    }
}
