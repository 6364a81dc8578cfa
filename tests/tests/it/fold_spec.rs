//! Does foldpath write valid FOLD 1.2? The judge knows the specification and none of the project's code.

use foldpath::export::fold::{motion_text, pattern_text};
use foldpath::generate::{
    Kresling, Letters, Miura, Quad, Resch, SquareTwist, Waterbomb, Yoshimura,
};
use foldpath::pattern::Drawing;
use foldpath::planner::{Outcome, PlanOptions};
use foldpath::read::read_pattern;
use foldpath_tests::fold_spec::violations;
use foldpath_tests::{Planned, pattern_file};
use serde_json::{Value, json};

const NONE: [String; 0] = [];

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn every_generated_pattern_is_valid() {
    let twist = |letters| SquareTwist {
        rows: 2,
        columns: 3,
        angle: 1.0,
        letters,
        fold: 0.5,
    };
    let drawings: [(&str, Drawing); 8] = [
        (
            "miura",
            Miura {
                rows: 3,
                columns: 4,
                sector_angle: 1.0,
                fold: 0.5,
            }
            .drawing()
            .unwrap(),
        ),
        (
            "waterbomb",
            Waterbomb {
                rows: 4,
                columns: 6,
                fold: 0.5,
            }
            .drawing()
            .unwrap(),
        ),
        (
            "yoshimura",
            Yoshimura {
                rows: 4,
                columns: 4,
                angle: 0.5,
                fold: 0.25,
            }
            .drawing()
            .unwrap(),
        ),
        (
            "quad",
            Quad {
                rows: 3,
                columns: 3,
                fold: 0.05,
            }
            .drawing()
            .unwrap(),
        ),
        ("square twist", twist(Letters::Foldable).drawing().unwrap()),
        (
            "unfoldable twist",
            twist(Letters::Unfoldable).drawing().unwrap(),
        ),
        (
            "resch",
            Resch {
                rows: 3,
                columns: 3,
            }
            .drawing()
            .unwrap(),
        ),
        (
            "kresling",
            Kresling {
                rows: 2,
                columns: 6,
            }
            .drawing()
            .unwrap(),
        ),
    ];
    for (name, drawing) in drawings {
        assert_eq!(
            violations(&parsed(&pattern_text(name, &drawing))),
            NONE,
            "{name}"
        );
    }
}

#[test]
fn the_patterns_of_the_repository_are_valid() {
    let folder = pattern_file("x");
    let files = std::fs::read_dir(folder.parent().unwrap()).unwrap();
    let files = files.map(|entry| entry.unwrap().path());
    let files: Vec<_> = files
        .filter(|path| path.extension().is_some_and(|e| e == "fold"))
        .collect();
    assert!(files.len() > 10, "{files:?}");
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        assert_eq!(violations(&parsed(&text)), NONE, "{}", file.display());
    }
}

#[test]
fn every_planned_path_is_valid_with_positions_or_without() {
    for name in [
        "miura-5x5",
        "waterbomb-4x6",
        "yoshimura-12x12",
        "square-twist-3x3",
        "resch-3x3",
    ] {
        let planned = Planned::new(name, &PlanOptions::default());
        assert_eq!(planned.plan.outcome, Outcome::Planned, "{name}");
        assert_eq!(violations(&parsed(&planned.text())), NONE, "{name}");
        let mut motion = planned.motion();
        for knot in &mut motion.knots {
            knot.vertices.clear();
        }
        let angles = parsed(&motion_text(&motion));
        assert!(angles["file_frames"][0].get("vertices_coords").is_none());
        assert_eq!(violations(&angles), NONE, "{name} without positions");
    }
}

/// Cuts inside the sheet become two borders, and a vertex on a cut becomes several vertices.
#[test]
fn the_path_of_a_cut_sheet_is_valid() {
    let sheet = json!({
        "file_spec": 1.2,
        "vertices_coords": [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1], [0, 2], [1, 2], [2, 2]],
        "edges_vertices": [
            [0, 1], [1, 2], [2, 5], [5, 8], [8, 7], [7, 6], [6, 3], [3, 0],
            [1, 4], [4, 7], [3, 4], [4, 5],
        ],
        "edges_assignment": ["B", "B", "B", "B", "B", "B", "B", "B", "V", "V", "F", "C"],
        "edges_foldAngle": [0, 0, 0, 0, 0, 0, 0, 0, 90, 90, 0, 0],
    });
    assert_eq!(violations(&sheet), NONE);
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), sheet.to_string()).unwrap();
    let planned = Planned::of(read_pattern(file.path()).unwrap(), &PlanOptions::default());
    assert_eq!(
        planned.plan.outcome,
        Outcome::Planned,
        "{:?}",
        planned.plan.reason
    );
    let path = parsed(&planned.text());
    let edges = |file: &Value| file["edges_vertices"].as_array().unwrap().len();
    assert!(edges(&path) > edges(&sheet), "the cut has two sides");
    assert_eq!(violations(&path), NONE);
}

/// The judge finds errors: each edit of a valid path breaks one rule.
#[test]
fn a_file_that_breaks_a_rule_is_refused() {
    let planned = Planned::new("miura-3x3", &PlanOptions::default());
    let path = parsed(&planned.text());
    assert_eq!(violations(&path), NONE);
    let letters = path["edges_assignment"].as_array().unwrap();
    let mountain = letters.iter().position(|letter| letter == "M").unwrap();
    let border = letters.iter().position(|letter| letter == "B").unwrap();
    let mut backwards = path["faces_vertices"][0].clone();
    backwards.as_array_mut().unwrap().reverse();
    let faces = path["faces_vertices"].as_array().unwrap();
    let mut clockwise = faces.clone();
    clockwise
        .iter_mut()
        .for_each(|face| face.as_array_mut().unwrap().reverse());
    let cases = [
        ("/file_spec".to_string(), json!("1.2"), "file_spec"),
        ("/file_classes".into(), json!(["movie"]), "file_classes"),
        ("/file_title".into(), json!(3), "file_title is no text"),
        ("/note".into(), json!("x"), "unknown key note"),
        (
            "/file_frames/1/file_title".into(),
            json!("x"),
            "unknown key file_title",
        ),
        (
            "/file_frames/1/frame_parent".into(),
            json!(99),
            "frame_parent",
        ),
        (
            "/file_frames/1/frame_parent".into(),
            json!(2),
            "frame_parent",
        ),
        (
            "/file_frames/1/frame_inherit".into(),
            json!("yes"),
            "frame_inherit",
        ),
        (
            "/file_frames/1/frame_classes".into(),
            json!(["folded"]),
            "frame_classes",
        ),
        (
            "/frame_attributes".into(),
            json!(["flat"]),
            "frame_attributes",
        ),
        (
            "/file_frames/1/frame_attributes".into(),
            json!(["2D"]),
            "2D, with a z",
        ),
        ("/frame_attributes".into(), json!(["3D"]), "3D, without a z"),
        ("/edges_vertices/0/1".into(), json!(16), "edges_vertices"),
        ("/faces_vertices/0/1".into(), json!(16), "faces_vertices"),
        ("/faces_vertices/0/1".into(), json!(15), "is no edge"),
        ("/faces_vertices/0".into(), backwards, "of two faces"),
        ("/faces_vertices".into(), json!(clockwise), "is clockwise"),
        ("/edges_assignment/0".into(), json!("X"), "edges_assignment"),
        (
            format!("/edges_assignment/{mountain}"),
            json!("B"),
            "has 2 faces",
        ),
        (
            format!("/edges_assignment/{mountain}"),
            json!("F"),
            "degrees of F",
        ),
        (
            format!("/edges_assignment/{border}"),
            json!("U"),
            "has 1 faces",
        ),
        (
            format!("/edges_assignment/{mountain}"),
            json!("V"),
            "degrees of V",
        ),
        (
            format!("/file_frames/1/edges_foldAngle/{mountain}"),
            json!(-190),
            "-190 degrees of M",
        ),
        (
            format!("/file_frames/1/edges_foldAngle/{mountain}"),
            json!(-1),
            "written -1 degrees",
        ),
        (
            "/file_frames/1/edges_foldAngle/0".into(),
            Value::Null,
            "of another kind",
        ),
        (
            "/file_frames/1/edges_foldAngle".into(),
            json!([0]),
            "lengths of edges_",
        ),
        (
            "/file_frames/1/vertices_coords/0".into(),
            json!([0]),
            "of another kind",
        ),
        (
            "/file_frames/1/vertices_coords/0/2".into(),
            json!(9),
            "written",
        ),
    ];
    for (place, value, expected) in cases {
        let mut broken = path.clone();
        let (parent, key) = place.rsplit_once('/').unwrap();
        match broken.pointer_mut(parent).unwrap() {
            Value::Object(object) => drop(object.insert(key.into(), value)),
            list => list[key.parse::<usize>().unwrap()] = value,
        }
        let found = violations(&broken);
        let seen = found.iter().any(|violation| violation.contains(expected));
        assert!(seen, "{place}: expected {expected}, found {found:?}");
    }
}
