//! Tests the predictions of `info`: motions are counted by closed forms and by another decomposition.

use crate::common::{PATTERNS, folder};
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, FlatFlaw, Letter};
use foldpath::planner::{FirstStep, Foldability, Goal, Mobility, forecast, leave_flat};
use foldpath::progress::Watch;
use foldpath::read::read_pattern;
use foldpath::symmetry::{CreaseGroups, ReducedStars};
use foldpath_core::{HalfAngle, closure};
use nalgebra::{DMatrix, Vector2};

/// Returns a polygon with creases from its middle at these angles, degrees. All are valleys, except those in
/// `mountains`.
fn vertex(angles: &[f64], mountains: &[usize]) -> CreasePattern {
    let n = angles.len();
    let rim = angles
        .iter()
        .map(|a| Vector2::new(a.to_radians().cos(), a.to_radians().sin()));
    let spoke = |k: usize| DrawnEdge {
        ends: [n, k],
        letter: if mountains.contains(&k) {
            Letter::Mountain
        } else {
            Letter::Valley
        },
        goal: None,
    };
    let side = |k: usize| DrawnEdge {
        ends: [k, (k + 1) % n],
        letter: Letter::Boundary,
        goal: None,
    };
    let drawing = Drawing {
        vertices: rim.chain([Vector2::zeros()]).collect(),
        edges: (0..n).map(spoke).chain((0..n).map(side)).collect(),
        faces: None,
    };
    CreasePattern::new(drawing).unwrap()
}

/// Returns the Jacobian of the closure residuals of all vertices, by finite differences.
fn differences(stars: &ReducedStars, x: &[f64]) -> DMatrix<f64> {
    let residuals = |x: &[f64]| {
        let mut half_angles = vec![HalfAngle::default(); x.len()];
        closure::half_angles(x, &mut half_angles);
        let all = stars.view().iter().flat_map(|star| {
            let residual: [f64; 3] = closure::residual(star, &half_angles).into();
            residual
        });
        all.collect::<Vec<f64>>()
    };
    let step = 1e-5;
    let columns: Vec<_> = (0..x.len())
        .map(|unknown| {
            let at = |way: f64| {
                let mut moved = x.to_vec();
                moved[unknown] += way * step;
                nalgebra::DVector::from_vec(residuals(&moved))
            };
            (at(1.0) - at(-1.0)) / (2.0 * step)
        })
        .collect();
    DMatrix::from_columns(&columns)
}

/// Returns the number of singular values above the error of the finite differences.
fn rank(matrix: DMatrix<f64>) -> usize {
    let values = matrix.singular_values();
    values
        .iter()
        .filter(|value| **value > 1e-6 * values.max())
        .count()
}

/// A sheet with one vertex of n creases has n - 3 degrees of freedom.
#[test]
fn vertices_have_three_ways_to_move_less_than_creases() {
    for (angles, mountains) in [
        (&[0.0, 70.0, 180.0, 290.0][..], &[0][..]),
        (&[0.0, 60.0, 150.0, 200.0, 290.0], &[0, 2]),
        (&[0.0, 50.0, 110.0, 180.0, 250.0, 300.0], &[1, 4]),
    ] {
        let sheet = vertex(angles, mountains);
        let start: Vec<f64> = (0..angles.len())
            .map(|k| if mountains.contains(&k) { -0.4 } else { 0.4 })
            .collect();
        let left = leave_flat(&sheet, &start);
        assert!(
            left.closure < 1e-9 && left.fold_angles.iter().any(|a| a.abs() > 0.1),
            "{left:?}"
        );
        let motions = Mobility::at(&ReducedStars::of_creases(&sheet), &left.fold_angles).unwrap();
        assert_eq!(motions.drivers.len(), angles.len() - 3);
        assert_eq!(motions.moving.len(), angles.len());
    }
}

/// The number of driven hinges agrees with a singular value decomposition of finite differences. With these hinges
/// held, nothing moves any more.
#[test]
fn driven_hinges_decide_all_others() {
    for (name, ways) in [
        ("miura-5x5", Some(1)),
        ("square-twist-1x1", Some(1)),
        ("waterbomb-4x6", None),
        ("miura-3x3", Some(1)),
    ] {
        let sheet = read_pattern(format!("{PATTERNS}/{name}.fold").as_ref())
            .unwrap()
            .pattern;
        let goal = Goal::of_pattern(&sheet).unwrap();
        let x: Vec<f64> = goal
            .fold_angles
            .iter()
            .map(|angle| angle.unwrap())
            .collect();
        let stars = ReducedStars::of_creases(&sheet);
        let motions = Mobility::at(&stars, &x).unwrap();
        let jacobian = differences(&stars, &x);
        let free = x.len() - rank(jacobian.clone());
        assert_eq!(motions.drivers.len(), free, "{name}");
        assert!(ways.is_none_or(|ways| ways == free), "{name}: {free}");
        let held = jacobian.remove_columns_at(&{
            let mut drivers = motions.drivers.clone();
            drivers.sort_unstable();
            drivers
        });
        assert_eq!(rank(held), x.len() - free, "{name}: {motions:?}");
    }
}

#[test]
fn first_steps_tell_sheets_apart() {
    let step = |name: &str| {
        let sheet = read_pattern(format!("{PATTERNS}/{name}.fold").as_ref())
            .unwrap()
            .pattern;
        forecast(&sheet, &CreaseGroups::find(&sheet), Watch::default()).step
    };
    for name in [
        "miura-24x24",
        "waterbomb-8x10",
        "yoshimura-12x12",
        "square-twist-3x3",
    ] {
        match step(name) {
            FirstStep::Leaves {
                unturned: 0,
                symmetric: Some(motions),
                ..
            } => {
                assert_eq!(motions.drivers.len(), 1, "{name}");
            }
            other => panic!("{name}: {other:?}"),
        }
    }
    for name in ["square-twist-unfoldable", "kresling-2x6"] {
        let step = step(name);
        assert!(
            matches!(step, FirstStep::Stays | FirstStep::Bends),
            "{name}: {step:?}"
        );
    }
    // All creases are valleys: only straight lines through the whole sheet turn.
    let quad = step("quad-3x3");
    assert!(
        matches!(quad, FirstStep::Leaves { unturned: 1.., .. }),
        "{quad:?}"
    );
}

/// The theorems of Kawasaki and Maekawa, and an odd number of creases, on vertices that break one of them.
#[test]
fn vertices_that_cannot_fold_flat_are_named() {
    let flat = vertex(&[0.0, 60.0, 130.0, 250.0], &[0]);
    assert_eq!(flat.flat_flaws(), []);
    let [(at, FlatFlaw::Kawasaki(sum))] = vertex(&[0.0, 60.0, 130.0, 230.0], &[0]).flat_flaws()[..]
    else {
        panic!()
    };
    assert_eq!(at.index(), 4);
    // The sectors are 60, 70, 100 and 130 degrees.
    let sums = [160.0, 200.0];
    assert!(
        sums.iter()
            .any(|degrees: &f64| (sum - degrees.to_radians()).abs() < 1e-12),
        "{sum}"
    );
    let flaws = vertex(&[0.0, 60.0, 130.0, 250.0], &[0, 1]).flat_flaws();
    assert!(
        matches!(flaws[..], [(_, FlatFlaw::Maekawa(2, 2))]),
        "{flaws:?}"
    );
    let odd = vertex(&[0.0, 60.0, 150.0, 200.0, 290.0], &[0]).flat_flaws();
    assert!(matches!(odd[..], [(_, FlatFlaw::Odd(5))]), "{odd:?}");
}

#[test]
fn info_says_what_will_be() {
    let folder = folder();
    let info = |file: &str| folder.done(&format!("info {file}")).stdout;
    let miura = info(&format!("{PATTERNS}/miura-5x5.fold"));
    assert!(
        miura.contains("will it fold        likely: it leaves flat"),
        "{miura}"
    );
    assert!(
        miura.contains("to drive            1 hinge, such as edge ")
            && miura.contains(": 39 follow\n"),
        "{miura}"
    );
    let waterbomb = info(&format!("{PATTERNS}/waterbomb-4x6.fold"));
    assert!(
        waterbomb.contains("hinges, such as edges")
            && waterbomb.contains("; 1 hinge, such as edge"),
        "{waterbomb}"
    );
    let locked = info(&format!("{PATTERNS}/square-twist-unfoldable.fold"));
    assert!(
        locked.contains("no: it is proved that no motion leaves flat"),
        "{locked}"
    );
    // The angles of this goal are written in radians.
    folder.done("generate miura --rows 3 --cols 3 -o miura.fold");
    let mut document = folder.read_json("miura.fold");
    for angle in document["edges_foldAngle"].as_array_mut().unwrap() {
        *angle = serde_json::json!(angle.as_f64().unwrap().to_radians());
    }
    folder.write("radians.fold", &document.to_string());
    for (command, said) in [("info", true), ("plan", true), ("info --quiet", false)] {
        let answer = folder.run(&format!("{command} radians.fold"));
        assert_eq!(
            answer.stderr.contains("if they are radians"),
            said,
            "{command}: {answer:?}"
        );
    }
    assert!(!folder.done("info miura.fold").stderr.contains("radians"));
    // One vertex with four creases that satisfies neither theorem. The file has letters, but no goal angles.
    for letter in ["V", "U"] {
        let text = format!(
            "{{\"vertices_coords\":[[1,0],[0,1],[-1,0.2],[0,-1],[0,0]],\
             \"edges_vertices\":[[0,1],[1,2],[2,3],[3,0],[4,0],[4,1],[4,2],[4,3]],\
             \"edges_assignment\":[\"B\",\"B\",\"B\",\"B\",\"{letter}\",\"{letter}\",\"{letter}\",\"{letter}\"]}}"
        );
        folder.write("star.fold", &text);
        let said = info("star.fold");
        let expected = if letter == "V" {
            "2 of 4 hinges do not turn at first"
        } else {
            "nothing says which way"
        };
        assert!(said.contains(expected), "{said}");
    }
    // No two creases are in line. If the one mountain is one of the two creases that can be the only mountain, all
    // creases turn.
    let star = folder
        .read("star.fold")
        .replacen("[0,1]", "[0.1,1]", 1)
        .replace("\"U\"", "\"V\"");
    let said = (0..4).map(|mountain| {
        let (head, letters) = star.split_at(star.find("\"V\"").unwrap() + 4 * mountain);
        folder.write(
            "one.fold",
            &(head.to_string() + &letters.replacen("\"V\"", "\"M\"", 1)),
        );
        info("one.fold")
    });
    let part = |said: &String| {
        said.contains("not all the way: ") && said.contains("vertex 4 at (0, 0): Kawasaki")
    };
    assert!(
        said.clone().any(|said| part(&said)),
        "{:?}",
        said.collect::<Vec<_>>()
    );
}

/// Returns `info --json` of a drawing.
fn info_of(drawing: &Drawing) -> serde_json::Value {
    let coordinates: Vec<_> = drawing.vertices.iter().map(|at| [at.x, at.y]).collect();
    let ends: Vec<_> = drawing.edges.iter().map(|edge| edge.ends).collect();
    let letters = drawing
        .edges
        .iter()
        .map(|edge| edge.letter.code().to_string());
    let document = serde_json::json!({
        "vertices_coords": coordinates, "edges_vertices": ends,
        "edges_assignment": letters.collect::<Vec<_>>(),
    });
    let folder = folder();
    folder.write("sheet.fold", &document.to_string());
    folder.done("info sheet.fold --json").json()
}

/// Makes the drawing of a polygon with creases from its middle at these angles, degrees, with these letters. The middle
/// is the last vertex, and its creases are the first edges.
fn star(angles: &[f64], letters: &str) -> Drawing {
    let n = angles.len();
    // A polygon of the corners of a square keeps the middle inside, however few creases there are.
    let corners = [10.0, 100.0, 190.0, 280.0];
    let mut at: Vec<f64> = angles.iter().chain(&corners).copied().collect();
    at.sort_by(f64::total_cmp);
    at.dedup_by(|a, b| (*a - *b).abs() < 1.0);
    let on_rim = |angle: &f64| Vector2::new(angle.to_radians().cos(), angle.to_radians().sin());
    let middle = Vector2::new(0.0, 0.0);
    let edge = |ends, letter: &str| DrawnEdge {
        ends,
        letter: Letter::from_code(letter).unwrap(),
        goal: None,
    };
    let place = |angle: &f64| {
        at.iter()
            .position(|other| (other - angle).abs() < 1.0)
            .unwrap()
    };
    let spokes = (0..n).map(|k| edge([at.len(), place(&angles[k])], &letters[k..=k]));
    let rim = (0..at.len()).map(|k| edge([k, (k + 1) % at.len()], "B"));
    Drawing {
        vertices: at.iter().map(on_rim).chain([middle]).collect(),
        edges: spokes.chain(rim).collect(),
        faces: None,
    }
}

/// One example of each kind of cause at a single vertex, with the creases that are locked.
#[test]
fn causes_name_the_vertex() {
    let cases: [(&[f64], &str, &str, &str, usize); 9] = [
        (&[0.0, 60.0, 130.0, 250.0], "MVVV", "likely", "", 0),
        (&[0.0, 60.0, 130.0, 230.0], "VMVV", "perhaps", "kawasaki", 0),
        (
            &[0.0, 60.0, 120.0, 180.0, 240.0, 300.0],
            "MVMVMV",
            "perhaps",
            "maekawa",
            0,
        ),
        (
            &[0.0, 60.0, 150.0, 200.0, 290.0],
            "MVVVV",
            "perhaps",
            "odd-degree",
            0,
        ),
        (&[0.0, 120.0, 240.0], "VVV", "no", "degree-3", 3),
        (&[0.0, 90.0, 180.0], "VVV", "perhaps", "degree-3", 1),
        (&[0.0, 150.0], "VV", "no", "degree-2", 2),
        (&[0.0, 179.0], "VV", "no", "not-in-line", 2),
        (&[0.0, 180.0], "MV", "no", "letters-change-on-a-line", 2),
    ];
    for (angles, letters, verdict, kind, locked) in cases {
        let drawing = star(angles, letters);
        let middle = drawing.vertices.len() - 1;
        let info = info_of(&drawing);
        let case = format!("{angles:?} {letters}: {info:#}");
        assert_eq!(info["verdict"], verdict, "{case}");
        assert_eq!(
            info["locked_creases"].as_array().unwrap().len(),
            locked,
            "{case}"
        );
        let causes = info["causes"].as_array().unwrap();
        assert_eq!(causes.len(), usize::from(!kind.is_empty()), "{case}");
        for cause in causes {
            assert_eq!(cause["kind"], kind, "{case}");
            assert_eq!(cause["vertices"], serde_json::json!([middle]), "{case}");
            assert_eq!(cause["at"], serde_json::json!([0.0, 0.0]), "{case}");
            let message = cause["message"].as_str().unwrap();
            assert!(
                message.starts_with(&format!("vertex {middle} at (0, 0): ")),
                "{case}"
            );
            if locked > 0 {
                assert_eq!(cause["edges"].as_array().unwrap().len(), locked, "{case}");
            }
        }
    }
}

/// Four valleys at a vertex that all lie in one half plane cannot turn: their rates are positive, and no positive sum of
/// their directions is zero. If they lie all round the vertex, there is such a sum, but the sheet would become a cone that does
/// not close.
#[test]
fn an_empty_cone_is_a_proof() {
    let half = [0.0, 60.0, 90.0, 130.0];
    let empty = info_of(&star(&half, "VVVV"));
    assert_eq!(empty["verdict"], "no", "{empty:#}");
    assert_eq!(empty["causes"][0]["kind"], "empty-cone");
    assert_eq!(empty["locked_creases"], serde_json::json!([0, 1, 2, 3]));
    assert_eq!(empty["flat_dof"], serde_json::Value::Null);
    // The third crease may now be a mountain, whose direction counts as the opposite one.
    let free = info_of(&star(&half, "VVUV"));
    assert_ne!(free["verdict"], "no", "{free:#}");
    assert_eq!(free["locked_creases"], serde_json::json!([]), "{free:#}");
    let round = info_of(&star(&[0.0, 60.0, 130.0, 250.0], "VVVV"));
    assert_eq!(round["verdict"], "no", "{round:#}");
    assert_eq!(round["causes"][0]["kind"], "second-order");
    assert_eq!(round["locked_creases"], serde_json::json!([0, 1, 2, 3]));
}

/// A line from border to border turns alone, while a vertex beside it is locked.
#[test]
fn a_line_turns_beside_a_locked_vertex() {
    let edge = |ends, code| DrawnEdge {
        ends,
        letter: Letter::from_code(code).unwrap(),
        goal: None,
    };
    let at = [
        [0.0, 0.0],
        [1.0, 0.0],
        [4.0, 0.0],
        [4.0, 4.0],
        [1.0, 4.0],
        [0.0, 4.0],
        [2.5, 2.25],
    ];
    let drawing = Drawing {
        vertices: at.map(Vector2::from).to_vec(),
        edges: vec![
            edge([1, 4], "V"),
            edge([6, 2], "V"),
            edge([6, 3], "V"),
            edge([6, 4], "M"),
            edge([0, 1], "B"),
            edge([1, 2], "B"),
            edge([2, 3], "B"),
            edge([3, 4], "B"),
            edge([4, 5], "B"),
            edge([5, 0], "B"),
        ],
        faces: None,
    };
    let info = info_of(&drawing);
    assert_eq!(info["verdict"], "perhaps", "{info:#}");
    assert_eq!(
        info["locked_creases"],
        serde_json::json!([1, 2, 3]),
        "{info:#}"
    );
    let cause = &info["causes"][0];
    assert_eq!(cause["kind"], "degree-3");
    assert_eq!(
        cause["message"],
        "vertex 6 at (2.5, 2.25): of three creases alone, these cannot turn: edges 1, 2, 3"
    );
}

/// In drawings whose y points down, places are told with the drawing's own y.
#[test]
fn places_are_those_of_the_drawing() {
    let folder = folder();
    let lines = [
        ("black", [0, 0, 100, 0]),
        ("black", [100, 0, 100, 80]),
        ("black", [100, 80, 0, 80]),
        ("black", [0, 80, 0, 0]),
        ("red", [40, 30, 0, 0]),
        ("blue", [40, 30, 100, 0]),
        ("blue", [40, 30, 100, 80]),
    ];
    let lines = lines.map(|(colour, [a, b, c, d])| {
        format!("<line stroke=\"{colour}\" x1=\"{a}\" y1=\"{b}\" x2=\"{c}\" y2=\"{d}\"/>")
    });
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 100 80\">{}</svg>",
        lines.concat()
    );
    folder.write("three.svg", &svg);
    let info = folder.done("info three.svg --json").json();
    assert_eq!(info["causes"][0]["kind"], "degree-3", "{info:#}");
    assert_eq!(info["causes"][0]["at"], serde_json::json!([40.0, 30.0]));
    let text = folder.done("info three.svg").stdout;
    assert!(
        text.contains("at (40, 30): of three creases alone"),
        "{text}"
    );
}

/// The degrees of freedom and drivers are those of closed forms: a Miura has one, and a star of six creases three.
#[test]
fn degrees_of_freedom_are_counted() {
    let folder = folder();
    let miura = folder
        .done(&format!("info {PATTERNS}/miura-5x5.fold --json"))
        .json();
    assert_eq!(miura["verdict"], "likely", "{miura:#}");
    assert_eq!(
        (&miura["flat_dof"], &miura["goal_dof"]),
        (&1.into(), &1.into())
    );
    assert_eq!(miura["drivers"].as_array().unwrap().len(), 1);
    assert_eq!(
        (&miura["causes"], &miura["locked_creases"]),
        (&serde_json::json!([]), &serde_json::json!([]))
    );
    let star = info_of(&star(&[0.0, 60.0, 120.0, 180.0, 240.0, 300.0], "MVVMVV"));
    assert_eq!(star["flat_dof"], 3, "{star:#}");
    // Without time nothing is foreseen, and without a way neither.
    let late = folder
        .done(&format!(
            "info {PATTERNS}/miura-5x5.fold --json --timeout 0"
        ))
        .json();
    assert_eq!(
        (&late["verdict"], &late["flat_dof"]),
        (&"unknown".into(), &serde_json::Value::Null)
    );
    let assumptions = late["assumptions"].to_string();
    assert!(
        assumptions.contains("time ran out in the search for crease groups"),
        "{late:#}"
    );
    let refused = folder
        .run(&format!("info {PATTERNS}/miura-5x5.fold --timeout=-1"))
        .with_status(2);
    assert!(
        refused
            .stderr
            .contains("--timeout: expected seconds from 0"),
        "{refused:?}"
    );
}

/// Verdict and causes stay the same if every coordinate is rounded to five digits.
#[test]
fn rounding_makes_no_false_proof() {
    for (name, expected) in [
        ("miura-11x11", Foldability::Likely),
        ("square-twist-3x3", Foldability::Perhaps),
        ("square-twist-unfoldable", Foldability::No),
    ] {
        let folder = folder();
        let mut document: serde_json::Value = serde_json::from_str(
            &std::fs::read_to_string(format!("{PATTERNS}/{name}.fold")).unwrap(),
        )
        .unwrap();
        for at in document["vertices_coords"].as_array_mut().unwrap() {
            for x in at.as_array_mut().unwrap() {
                *x = format!("{:.4}", x.as_f64().unwrap())
                    .parse::<f64>()
                    .unwrap()
                    .into();
            }
        }
        folder.write("rounded.fold", &document.to_string());
        let info = folder.done("info rounded.fold --json").json();
        assert_eq!(info["verdict"], expected.name(), "{name}: {info:#}");
        let locked = info["locked_creases"].as_array().unwrap().len();
        assert_eq!(locked > 0, expected == Foldability::No, "{name}: {info:#}");
    }
}
