//! Tests malformed files and parameters: the status is 2, and a message names the file, the place and what was expected
//! there. Cases are tables of text: edits or a command, `=>`, and the message.

use crate::common::{folder, folder_with_path, pattern};
use foldpath_test_support::{Folder, edited};
use serde_json::{Value, json};

const PATTERN: [&str; 2] = ["info bad.fold", "plan bad.fold -o out.fold"];
const PLAN: [&str; 1] = ["plan bad.fold -o out.fold"];
const GOAL: [&str; 1] = ["plan miura.fold --goal bad.fold -o out.fold"];
const PATH: [&str; 2] = ["check bad.fold", "view bad.fold -o out.html"];

/// Returns the cases and messages of a table. After a backslash a message continues in the next line.
fn cases(table: &str) -> Vec<(String, String)> {
    let mut table = table.split("\\\n").map(str::trim_start);
    let first = table.next().unwrap();
    let table = table.fold(first.to_string(), |text, more| text + more);
    let lines = table.lines().map(str::trim).filter(|line| !line.is_empty());
    let cases = lines.map(|line| line.split_once(" => ").unwrap());
    cases
        .map(|(case, message)| (case.into(), message.into()))
        .collect()
}

/// Returns a report if a command is not refused with this message.
fn not_refused(folder: &Folder, command: &str, message: &str) -> Option<String> {
    let answer = folder.run(command);
    let good = answer.status == Some(2) && answer.stdout.is_empty() && answer.tells(message);
    (!good).then(|| format!("\n{command}\n  expected {message}\n  found    {answer:?}\n"))
}

/// Asserts that `commands` refuse `document` with the edits of each case of the table.
#[track_caller]
fn assert_edits_refused(document: &Value, commands: &[&str], table: &str) {
    let folder = folder_with_path();
    let mut wrong = Vec::new();
    for (edits, message) in cases(table) {
        folder.write("bad.fold", &edited(document, &edits).to_string());
        let message = format!("bad.fold: {message}");
        let found = commands
            .iter()
            .filter_map(|command| not_refused(&folder, command, &message));
        wrong.extend(found.map(|found| format!("\n{edits}{found}")));
    }
    assert!(wrong.is_empty(), "{}", wrong.concat());
    assert_eq!(
        folder.names(),
        ["bad.fold", "miura.fold", "path.fold"],
        "nothing written"
    );
}

/// Asserts that the command of each case of the table is refused.
#[track_caller]
fn assert_commands_refused(table: &str) {
    let folder = folder_with_path();
    let found = cases(table).into_iter();
    let found = found.filter_map(|(command, message)| not_refused(&folder, &command, &message));
    let wrong: Vec<_> = found.collect();
    assert!(wrong.is_empty(), "{}", wrong.concat());
    assert_eq!(
        folder.names(),
        ["miura.fold", "path.fold"],
        "nothing written"
    );
}

fn path() -> Value {
    folder_with_path().read_json("path.fold")
}

#[test]
fn text_that_is_no_fold_object() {
    let folder = folder();
    let deep = "[".repeat(5000);
    for (text, message) in [
        (
            "",
            ":1:0: expected a FOLD file, which is JSON: EOF while parsing a value",
        ),
        (
            "{\n\"a\":[1,",
            ":2:7: expected a FOLD file, which is JSON: EOF while parsing a value",
        ),
        (
            "{\"a\":NaN}",
            ":1:6: expected a FOLD file, which is JSON: expected value",
        ),
        (
            "{\"a\":1e400}",
            ":1:10: expected a FOLD file, which is JSON: number out of range",
        ),
        (
            "{} {}",
            ":1:4: expected a FOLD file, which is JSON: trailing characters",
        ),
        (
            &deep,
            ":1:128: expected a FOLD file, which is JSON: recursion limit exceeded",
        ),
        ("null", ": the file: expected a FOLD object, found null"),
        (
            "[1,2]",
            ": the file: expected a FOLD object, found a list of 2",
        ),
        (
            "\"text\"",
            ": the file: expected a FOLD object, found \"text\"",
        ),
        ("{}", ": vertices_coords: expected a list, found nothing"),
    ] {
        folder.write("bad.fold", text);
        for command in [PATTERN, PATH].as_flattened() {
            assert_eq!(
                not_refused(&folder, command, &format!("bad.fold{message}")),
                None
            );
        }
    }
}

#[test]
fn files_that_are_not_there() {
    let folder = folder_with_path();
    let reading = [
        "info",
        "plan",
        "check",
        "view -o out.html",
        "plan miura.fold --goal",
    ];
    for (name, message) in [
        ("missing.fold", "No such file or directory (os error 2)"),
        (".", "Is a directory (os error 21)"),
    ] {
        for command in reading.map(|command| format!("{command} {name}")) {
            assert_eq!(
                not_refused(&folder, &command, &format!("{name}: {message}")),
                None
            );
        }
    }
}

#[test]
fn values_of_the_wrong_type() {
    assert_edits_refused(
        &pattern(),
        &PATTERN,
        r#"
        /vertices_coords = => vertices_coords: expected a list, found nothing
        /vertices_coords = {"a":1} => vertices_coords: expected a list, found an object
        /vertices_coords/3 = "a" => vertices_coords[3]: expected a list, found "a"
        /vertices_coords/3/1 = [1] => vertices_coords[3][1]: expected a number, found a list of 1
        /vertices_coords/3/1 = "NaN" => vertices_coords[3][1]: expected a number, found "NaN"
        /vertices_coords/3/1 = null => vertices_coords[3][1]: expected a number, found null
        /vertices_coords/3 = [1] => vertices_coords[3]: expected 2 or 3 coordinates, found a list of 1
        /vertices_coords/3 = [1,2,3,4] => vertices_coords[3]: expected 2 or 3 coordinates, found a list of 4
        /edges_vertices = 7 => edges_vertices: expected a list, found 7
        /edges_vertices = ; /faces_vertices = ; /edges_assignment = ; /edges_foldAngle = => \
            edges_vertices: expected a list (or faces_vertices, or vertices_vertices), found nothing
        /edges_vertices/3 = [1,2,3] => edges_vertices[3]: expected 2 vertices, or 4 of a curve, found a list of 3
        /edges_vertices/3/0 = "1" => edges_vertices[3][0]: expected a whole number from 0, found "1"
        /edges_vertices/3/0 = -1 => edges_vertices[3][0]: expected a whole number from 0, found -1
        /edges_vertices/3/0 = 1.5 => edges_vertices[3][0]: expected a whole number from 0, found 1.5
        /edges_vertices/3/0 = 5000000000 => edges_vertices[3][0]: expected a whole number from 0, found 5000000000
        /edges_assignment = ["B","V"] => edges_assignment: expected 24 entries, one for each edge, found 2
        /edges_assignment/3 = 3 => edges_assignment[3]: expected a string, found 3
        /edges_foldAngle = [1] => edges_foldAngle: expected 24 entries, one for each edge, found 1
        /edges_foldAngle/2 = "10" => edges_foldAngle[2]: expected a number, found "10"
        /faces_vertices/0 = 4 => faces_vertices[0]: expected a list, found 4
        /faces_vertices/0/1 = 0.5 => faces_vertices[0][1]: expected a whole number from 0, found 0.5
        /file_title = 7 => file_title: expected a string, found 7
        /file_frames = {} => file_frames: expected a list, found an object
        "#,
    );
}

#[test]
fn drawings_that_are_no_crease_pattern() {
    assert_edits_refused(
        &pattern(),
        &PATTERN,
        r#"
        /vertices_coords = [] => vertices_coords: expected at least 3 entries, found 0
        /edges_vertices = []; /edges_assignment = []; /edges_foldAngle = => edges_vertices: expected at least 3 entries, found 0
        /edges_vertices/3/0 = 99 => edges_vertices[3]: vertex 99 does not exist, expected 0 to 15
        /edges_vertices/3 = [2,2] => edges_vertices[3]: expected two vertices at different places
        /vertices_coords/1 = [0,0] => edges_vertices[1]: expected two vertices at different places
        /edges_vertices/3 = [1,0] => edges_vertices[3]: joins the same vertices as edge 1
        /edges_vertices/3 = [0,6] => edges_vertices[3]: crosses edge 2 where there is no vertex
        /edges_vertices/3 = [0,2] => edges_vertices[3]: passes through vertex 1 without ending there
        /vertices_coords/5 = [1.5,0.866,0.1] => vertices_coords: expected a flat crease pattern \
            (a folded shape has to be unfolded first), found vertices that lie in no common plane
        /edges_foldAngle/2 = 200 => edges_foldAngle[2]: expected -180 to 180 degrees, found 200
        /edges_foldAngle/2 = -10 => edges_foldAngle[2]: -10 degrees has the wrong sign for letter V; \
            expected valley positive, mountain negative
        /faces_vertices/0/0 = 44 => faces_vertices[0]: vertex 44 does not exist, expected 0 to 15
        /faces_vertices/0 = [4,0,2,5] => faces_vertices[0]: no edge joins its vertices 0 and 2
        /faces_vertices/0 = [4,0,5,1] => faces_vertices[0]: expected a simple polygon with an area
        /faces_vertices/0 = [4,0] => faces_vertices[0]: expected a simple polygon with an area
        /faces_vertices/9 = [4,0,1,5] => edges_vertices[0]: faces 0 and 9 lie on the same side of it
        /edges_vertices = => edges_vertices: expected a list, as edges_assignment speaks of edges, found nothing
        /edges_vertices = ; /edges_assignment = => \
            edges_vertices: expected a list, as edges_foldAngle speaks of edges, found nothing
        /faces_vertices = [[4,0,1,2,6,5]] => vertices_coords[1]: expected the faces round it not to \
            overlap, and no edge without faces between them
        "#,
    );
}

#[test]
fn frames_that_cannot_be_read() {
    assert_edits_refused(
        &pattern(),
        &PATTERN,
        r#"
        /file_frames = [{"frame_parent":1,"frame_inherit":true}] => \
            file_frames[0].frame_parent: expected another frame than this, found 1
        /file_frames = [{"frame_parent":2,"frame_inherit":true},{"frame_parent":1,"frame_inherit":true}] => \
            file_frames[1].frame_parent: expected a frame that does not inherit from this, frame 2, found 1
        /file_frames = [{"frame_parent":2,"frame_inherit":true}] => \
            file_frames[0].frame_parent: expected the number of a frame, 0 to 1, found 2
        /file_frames = [{"frame_parent":"0","frame_inherit":true}] => \
            file_frames[0].frame_parent: expected the number of a frame, 0 to 1, found "0"
        /file_frames = [{"frame_inherit":true}] => \
            file_frames[0].frame_parent: expected the number of a frame, 0 to 1, found none
        /file_frames = [3] => file_frames[0]: expected a frame, found 3
        /frame_classes = ; /file_frames = [{"frame_classes":["creasePattern"],"frame_inherit":true,\
            "frame_parent":0,"faces_vertices":[[4,0,2,5]]}] => \
            file_frames[0].faces_vertices[0]: no edge joins its vertices 0 and 2
        /frame_classes = ; /file_frames = [{"frame_classes":["creasePattern"],"frame_inherit":true,\
            "frame_parent":0}]; /edges_vertices/3 = [2,2] => edges_vertices[3]: expected two vertices at different places
        "#,
    );
}

/// If the goal comes from a frame, the message names that frame.
#[test]
fn goal_frames_that_do_not_fit() {
    assert_edits_refused(
        &pattern(),
        &PATTERN,
        r#"
        /file_frames = [{"frame_classes":["foldedForm"],"edges_foldAngle":[1,2]}] => \
            file_frames[0].edges_foldAngle: expected 24 entries, one for each edge, found 2
        /file_frames = [{"frame_classes":["foldedForm"],"edges_foldAngle":["x"]}] => \
            file_frames[0].edges_foldAngle[0]: expected a number, found "x"
        /file_frames = [{"frame_classes":["foldedForm"],\
            "edges_foldAngle":[0,0,200,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]}] => \
            file_frames[0].edges_foldAngle[2]: expected -180 to 180 degrees, found 200
        "#,
    );
}

#[test]
fn sheets_that_cannot_be_planned() {
    assert_edits_refused(
        &pattern(),
        &PLAN,
        r#"
        /edges_foldAngle = ; /edges_assignment = \
            ["B","B","U","B","U","B","B","B","U","U","U","U","U","B","B","U","U","U","U","U","B","B","B","B"] => \
            edges_assignment: no crease is lettered M or V and no goal angle is given; \
            expected a goal frame, edges_foldAngle or letters
        "#,
    );
}

#[test]
fn goal_files_without_a_goal() {
    assert_edits_refused(
        &pattern(),
        &GOAL,
        r#"
        /edges_foldAngle = => edges_foldAngle: expected goal angles other than 0, found none
        /edges_foldAngle = [0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0] => \
            edges_foldAngle: expected goal angles other than 0, found none
        /edges_foldAngle = [1] => edges_foldAngle: expected 24 entries, one for each edge, found 1
        "#,
    );
}

/// A goal file is refused for the same reasons as the pattern's own goal: no hinge turns by more than half a turn, or
/// against its letter.
#[test]
fn goal_files_that_no_hinge_can_follow() {
    assert_edits_refused(
        &pattern(),
        &GOAL,
        r#"
        /edges_foldAngle/2 = 720 => edges_foldAngle[2]: expected -180 to 180 degrees, found 720
        /edges_foldAngle/2 = -10 => edges_foldAngle[2]: -10 degrees has the wrong sign for letter V; \
            expected valley positive, mountain negative
        "#,
    );
}

/// A file without knots is a crease pattern, which `check` refuses and `view` draws.
#[test]
fn paths_without_knots() {
    assert_edits_refused(
        &path(),
        &PATH[..1],
        r#"
        /file_frames = => file_frames: expected at least one knot (of a path; `foldpath plan` makes one of a crease pattern), found none
        /file_frames = [] => file_frames: expected at least one knot (of a path; `foldpath plan` makes one of a crease pattern), found none
        "#,
    );
}

#[test]
fn frames_that_are_no_knots() {
    assert_edits_refused(
        &path(),
        &PATH,
        r#"
        /file_frames/3/edges_foldAngle = => file_frames[3].edges_foldAngle: expected a list, found nothing
        /file_frames/3/edges_foldAngle = [0] => file_frames[3].edges_foldAngle: expected 24 entries, one for each edge, found 1
        /file_frames/3/edges_foldAngle/2 = null => file_frames[3].edges_foldAngle[2]: expected a number, found null
        /file_frames/2/foldpath:time = 5; /file_frames/3/foldpath:time = 5 => \
            file_frames[3].foldpath:time: expected more than 5 seconds, found 5
        /file_frames/3/foldpath:time = "1" => file_frames[3].foldpath:time: expected a number, found "1"
        /file_frames/3/foldpath:gap = "1" => file_frames[3].foldpath:gap: expected a number, found "1"
        /file_frames/3/vertices_coords = [[0,0,0]] => \
            file_frames[3].vertices_coords: expected 16 entries, one for each vertex, found 1
        /file_frames/3/vertices_coords/2 = [0] => \
            file_frames[3].vertices_coords[2]: expected 2 or 3 coordinates, found a list of 1
        /file_frames/3/frame_parent = 4 => \
            file_frames[3].frame_parent: expected another frame than this, found 4
        /foldpath:interpolation = "spline" => \
            foldpath:interpolation: expected "linear", "hermite", "half-angle" or "homogeneous", found "spline"
        /foldpath:interpolation = 3 => foldpath:interpolation: expected a string, found 3
        /foldpath:phases = 2 => foldpath:phases: expected a list, found 2
        /foldpath:phases = [0] => foldpath:phases[0]: expected a knot after number 0 and before the last, found 0
        /foldpath:phases = [2, 1] => foldpath:phases[1]: expected a knot after number 2 and before the last, found 1
        /foldpath:phases = [99] => foldpath:phases[0]: expected a knot after number 0 and before the last, found 99
        "#,
    );
}

/// Each interpolation needs certain data at every knot.
#[test]
fn motions_that_lack_something() {
    let mut path = path();
    let edges = path["edges_vertices"].as_array().unwrap().len();
    for frame in path["file_frames"].as_array_mut().unwrap() {
        frame["foldpath:edges_foldAngleRate"] = json!(vec![1.0; edges]);
    }
    assert_edits_refused(
        &path,
        &PATH,
        r#"
        /foldpath:interpolation = "hermite"; /file_frames/1/foldpath:edges_foldAngleRate = => \
            file_frames[1].foldpath:edges_foldAngleRate: expected the rates that "hermite" needs, found nothing
        /foldpath:interpolation = "half-angle"; /file_frames/1/foldpath:edges_foldAngleRate = => \
            file_frames[1].foldpath:edges_foldAngleRate: expected the rates that "half-angle" needs, found nothing
        /foldpath:interpolation = "hermite"; /file_frames/1/foldpath:edges_foldAngleRate/3 = null => \
            file_frames[1].foldpath:edges_foldAngleRate[3]: expected a number, found null
        /foldpath:interpolation = "half-angle"; /file_frames/1/edges_foldAngle/3 = -180 => \
            file_frames[1].edges_foldAngle[3]: expected less than half a turn, for "half-angle", found -180
        /foldpath:interpolation = "homogeneous" => \
            file_frames[0].foldpath:edges_weight: expected the weights that "homogeneous" needs, found nothing
        "#,
    );
    path["foldpath:interpolation"] = json!("homogeneous");
    for frame in path["file_frames"].as_array_mut().unwrap() {
        frame["foldpath:edges_weight"] = json!(vec![1.0; edges]);
        frame["foldpath:edges_weightRate"] = json!(vec![0.0; edges]);
    }
    let letters = path["edges_assignment"].as_array().unwrap();
    let [hinge, rim] = ["M", "B"].map(|code| letters.iter().position(|l| l == code).unwrap());
    let table = r#"
        /file_frames/1/foldpath:edges_weightRate = => file_frames[1].foldpath:edges_weightRate: \
            expected the rates of weights that "homogeneous" needs, found nothing
        /file_frames/1/foldpath:edges_weight = [1] => \
            file_frames[1].foldpath:edges_weight: expected 24 entries, one for each edge, found 1
        /file_frames/1/foldpath:edges_weight/HINGE = 0 => \
            file_frames[1].foldpath:edges_weight[HINGE]: expected a number above 0, found 0
        /file_frames/1/foldpath:edges_weight/RIM = -1 => \
            file_frames[1].foldpath:edges_weight[RIM]: expected a number above 0, found -1
        /file_frames/1/foldpath:edges_weight/HINGE = null => \
            file_frames[1].foldpath:edges_weight[HINGE]: expected a number, found null
        /file_frames/1/foldpath:edges_weightRate/HINGE = null => \
            file_frames[1].foldpath:edges_weightRate[HINGE]: expected a number, found null
        "#;
    let table = table
        .replace("HINGE", &hinge.to_string())
        .replace("RIM", &rim.to_string());
    assert_edits_refused(&path, &PATH, &table);
}

#[test]
fn groups_and_signs_that_cannot_be() {
    assert_edits_refused(
        &path(),
        &PATH,
        r#"
        /foldpath:edges_group = [0] => foldpath:edges_group: expected 24 entries, one for each edge, found 1
        /foldpath:edges_group/2 = -1 => foldpath:edges_group[2]: expected a whole number from 0, found -1
        /foldpath:edges_group/2 = 24 => foldpath:edges_group[2]: expected a group below 24, found 24
        /foldpath:edges_group/2 = 4000000000 => foldpath:edges_group[2]: expected a group below 24, found 4000000000
        /foldpath:edges_sign = [0] => foldpath:edges_sign: expected 24 entries, one for each edge, found 1
        /foldpath:edges_sign/2 = null => foldpath:edges_sign[2]: expected a number, found null
        /foldpath:edges_sign/2 = 0 => foldpath:edges_sign[2]: expected 1 or -1, found 0
        /foldpath:edges_sign/2 = 7 => foldpath:edges_sign[2]: expected 1 or -1, found 7
        "#,
    );
}

#[test]
fn parameters_out_of_range() {
    assert_commands_refused(
        "
        generate miura --rows 0 --cols 3 -o a => --rows: expected 1 to 3000, found 0
        generate miura --rows 3 --cols 3001 -o a => --cols: expected 1 to 3000, found 3001
        generate miura --rows 99999999999999 --cols 3 -o a => --rows: expected 1 to 3000, found 99999999999999
        generate miura --rows 3 --cols 3 --angle 90 -o a => --angle: expected 1 to 89 degrees, found 90
        generate miura --rows 3 --cols 3 --fold 2 -o a => --fold: expected a fraction above 0 and at most 1, found 2
        generate waterbomb --rows 1 --cols 4 -o a => --rows: expected 2 to 3000, found 1
        generate yoshimura --rows 2 --cols 4 --angle 0 -o a => --angle: expected 1 to 89 degrees, found 0
        plan miura.fold -o a --fold -0.1 => --fold: expected a fraction from 0 to 1, found -0.1
        plan miura.fold -o a --fold 1.5 => --fold: expected a fraction from 0 to 1, found 1.5
        plan miura.fold -o a --timeout=-1 => --timeout: expected seconds from 0, found -1
        check path.fold --bound 0 => --bound: expected a fraction above 0 and at most 1, found 0
        ",
    );
}

/// Messages name the options of `plan` as users type them.
#[test]
fn plan_options_out_of_range() {
    assert_commands_refused(
        "
        plan miura.fold -o a --bound 0 => --bound: expected a fraction above 0 and at most 1, found 0
        plan miura.fold -o a --max-speed 0 => --max-speed: expected degrees per second from 0.000001, found 0
        ",
    );
}

/// A line is drawn twice before a line that ends at a missing vertex. Fuzzing found this case.
#[test]
fn lines_that_end_nowhere_are_not_repaired() {
    let folder = folder();
    let pattern = json!({
        "file_spec": 1.2,
        "vertices_coords": [[0, 0], [6, 0], [6, 6], [0, 6]],
        "edges_vertices": [[0, 1], [0, 1], [2, 3], [3, 9]],
        "edges_assignment": ["B", "B", "B", "B"],
    });
    folder.write("a.fold", &pattern.to_string());
    let answer = folder.run("info a.fold").with_status(2);
    assert!(answer.stderr.contains("edges_vertices[1]"), "{answer:?}");
}
