//! Sheets with cuts, with holes, and several in one file.

mod common;

use common::{Folder, edited, pattern};
use serde_json::{Value, json};

/// Plans, checks and shows a document; what the three said.
#[track_caller]
fn planned(document: &Value, options: &str) -> (Value, Value, Folder) {
    let folder = Folder::new();
    folder.write("sheet.fold", &document.to_string());
    let plan = folder.done(&format!("plan sheet.fold -o path.fold --json {options}"));
    let check = folder.done("check path.fold --json");
    folder.done("view path.fold -o path.html");
    let (plan, check) = (plan.json(), check.json());
    assert_eq!(plan["outcome"], "planned", "{plan}");
    assert_eq!(check["outcome"], "holds", "{check}");
    (plan, check, folder)
}

/// A cut from the border to a vertex: on both sides there is a border then, and the vertex at the border
/// is there twice.
#[test]
fn a_cut_parts_the_sheet_and_what_is_added_comes_last() {
    for letter in ["B", "C"] {
        let cut = edited(&pattern(), &format!("/edges_assignment/2 = {letter:?}"));
        let (plan, _, folder) = planned(&cut, "");
        assert_eq!(plan["creases"], 11);
        let path = folder.read_json("path.fold");
        let length = |key: &str| path[key].as_array().unwrap().len();
        assert_eq!(
            (length("vertices_coords"), length("edges_vertices")),
            (17, 25)
        );
        for (key, drawn) in [("vertices_coords", 16), ("edges_vertices", 24)] {
            let same = (0..drawn).filter(|&k| path[key][k] == cut[key][k]).count();
            assert!(same >= drawn - 2, "{key}: {same}");
        }
        let info = folder.done("info sheet.fold --json").json();
        let said =
            "the sheet is cut along edges lettered B or C between two faces: 1 (first: edge 2)";
        assert!(
            info["assumptions"]
                .as_array()
                .unwrap()
                .contains(&json!(said)),
            "{info}"
        );
    }
}

/// The document and, to its right, itself again: one drawing of two sheets.
fn side_by_side(document: &Value) -> Value {
    let mut both = document.clone();
    let count = document["vertices_coords"].as_array().unwrap().len();
    let list = |key: &str| document[key].as_array().unwrap().clone();
    let add = |both: &mut Value, key: &str, more: Vec<Value>| {
        both[key].as_array_mut().unwrap().extend(more);
    };
    let moved = list("vertices_coords");
    let moved = moved
        .iter()
        .map(|p| json!([p[0].as_f64().unwrap() + 10.0, p[1]]));
    add(&mut both, "vertices_coords", moved.collect());
    for key in ["edges_vertices", "faces_vertices"] {
        let shift = |v: &Value| json!(v.as_u64().unwrap() + count as u64);
        let shifted = |cycle: &Value| cycle.as_array().unwrap().iter().map(shift).collect();
        add(&mut both, key, list(key).iter().map(shifted).collect());
    }
    for key in ["edges_assignment", "edges_foldAngle"] {
        add(&mut both, key, list(key));
    }
    both
}

#[test]
fn two_sheets_in_one_file_fold_side_by_side() {
    let both = side_by_side(&pattern());
    for (options, unknowns) in [("", 2), ("--symmetry off", 24)] {
        let (plan, check, folder) = planned(&both, options);
        assert_eq!(
            (&plan["creases"], &plan["real_vertices"]),
            (&json!(24), &json!(8))
        );
        assert_eq!(plan["unknowns"], unknowns);
        assert!(check["max_gap"].as_f64().unwrap() < 1e-12, "{check}");
        let info = folder.done("info sheet.fold --json").json();
        assert_eq!(info["sheets"], 2);
        let said = "2 sheets that no edge joins: each stays where it is drawn, and faces of different \
                    sheets are not looked at for crossings";
        assert!(
            info["assumptions"]
                .as_array()
                .unwrap()
                .contains(&json!(said)),
            "{info}"
        );
        for command in ["plan sheet.fold", "check path.fold"] {
            assert!(folder.done(command).stderr.contains(said), "{command}");
        }
        // The face in the middle of each stays where it is drawn.
        let path = folder.read_json("path.fold");
        let last = &path["file_frames"].as_array().unwrap().last().unwrap()["vertices_coords"];
        for vertex in [5, 21] {
            let (flat, folded) = (&both["vertices_coords"][vertex], &last[vertex]);
            let place =
                |k: usize| (flat[k].as_f64().unwrap_or(0.0) - folded[k].as_f64().unwrap()).abs();
            assert!((0..3).all(|k| place(k) < 1e-9), "{flat} {folded}");
        }
    }
}
