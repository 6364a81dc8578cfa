//! Drawings as people make them: panels with windows and flaps, curved borders, perforated creases, creases that only their
//! dashes tell.

use core::fmt::Write as _;

use crate::common::folder;
use foldpath::pattern::{CreasePattern, VertexId};
use foldpath::read::read_pattern;
use serde_json::{Value, json};

/// Corners of a sheet of two panels, and of a flap in its right panel.
const PLACES: [[f64; 2]; 10] = [
    [0.0, 0.0],
    [50.0, 0.0],
    [100.0, 0.0],
    [100.0, 60.0],
    [50.0, 60.0],
    [0.0, 60.0],
    [70.0, 20.0],
    [90.0, 20.0],
    [90.0, 40.0],
    [70.0, 40.0],
];
/// Its lines: the border, a crease, and a flap that is cut out on three sides, with its hinge last.
const LINES: [[usize; 2]; 11] = [
    [0, 1],
    [1, 2],
    [2, 3],
    [3, 4],
    [4, 5],
    [5, 0],
    [1, 4],
    [6, 7],
    [7, 8],
    [8, 9],
    [9, 6],
];

/// Returns the sheet as a FOLD file with these faces.
fn flap_in_fold(faces: &Value) -> String {
    let mut file = json!({
        "file_spec": 1.2,
        "vertices_coords": PLACES,
        "edges_vertices": LINES,
        "edges_assignment": ["B", "B", "B", "B", "B", "B", "M", "C", "C", "C", "V"],
        "edges_foldAngle": [0, 0, 0, 0, 0, 0, -170, 0, 0, 0, 90],
    });
    if !faces.is_null() {
        file["faces_vertices"] = faces.clone();
    }
    file.to_string()
}

/// Returns the sheet as SVG, with cuts in this colour.
fn flap_in_svg(cut: &str) -> String {
    let line = |[a, b]: [usize; 2], stroke: &str| {
        let [[x1, y1], [x2, y2]] = [a, b].map(|place| PLACES[place]);
        format!("<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" {stroke}/>\n")
    };
    let lines = LINES.iter().enumerate().map(|(index, &ends)| match index {
        6 => line(ends, "stroke=\"red\" stroke-opacity=\".9\""),
        7..10 => line(ends, &format!("stroke=\"{cut}\"")),
        10 => line(ends, "stroke=\"blue\" stroke-opacity=\".5\""),
        _ => line(ends, "stroke=\"black\""),
    });
    svg([100.0, 60.0], &lines.collect::<String>())
}

fn flap_in_cp() -> String {
    let mut text = String::new();
    for (index, &ends) in LINES.iter().enumerate() {
        let [[x1, y1], [x2, y2]] = ends.map(|place| PLACES[place]);
        let kind = match index {
            6 => 2,
            10 => 3,
            _ => 1,
        };
        writeln!(text, "{kind} {x1} {y1} {x2} {y2}").unwrap();
    }
    text
}

fn svg([width, height]: [f64; 2], elements: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\">\n{elements}</svg>"
    )
}

/// Plans a file, checks the path, plans the path's own sheet again, and writes the path in all forms that have faces.
fn planned(name: &str, text: &str, options: &str) -> Value {
    let folder = folder();
    folder.write(name, text);
    let plan = folder
        .done(&format!("plan {name} --json -o path.fold {options}"))
        .json();
    assert_eq!(plan["outcome"], "planned", "{text}\n{plan}");
    let check = folder.done("check path.fold --json").json();
    assert_eq!(check["outcome"], "holds", "{text}\n{check}");
    let again = folder.done("plan path.fold --json").json();
    for key in ["outcome", "creases", "real_vertices", "groups"] {
        assert_eq!(again[key], plan[key], "{key}: {text}\n{again}");
    }
    for form in [
        "obj -o obj/",
        "mjcf -o mjcf",
        "glb -o path.glb",
        "svg -o path.svg",
    ] {
        folder.done(&format!("export path.fold --to {form}"));
    }
    folder.done("view path.fold -o page.html");
    plan
}

fn pattern(name: &str, text: &str) -> CreasePattern {
    let folder = folder();
    folder.write(name, text);
    read_pattern(&folder.path(name)).unwrap().pattern
}

/// A flap that is cut out inside a panel is a flap, in every format, and however the file names faces: not at all, as if
/// the panel had no window, or with a face that goes along a line to the flap and back.
#[test]
fn a_flap_inside_a_panel_folds() {
    let left = json!([0, 1, 4, 5]);
    let flap = json!([6, 7, 8, 9]);
    let without_window = json!([left, [1, 2, 3, 4], flap]);
    let mut bridged: Value = flap_in_fold(&Value::Null).parse().unwrap();
    bridged["edges_vertices"]
        .as_array_mut()
        .unwrap()
        .push(json!([2, 7]));
    bridged["edges_assignment"]
        .as_array_mut()
        .unwrap()
        .push(json!("F"));
    bridged["edges_foldAngle"]
        .as_array_mut()
        .unwrap()
        .push(json!(0));
    let mut keyhole = bridged.clone();
    keyhole["faces_vertices"] = json!([left, [1, 2, 7, 6, 9, 8, 7, 2, 3, 4], flap]);
    for (name, text) in [
        ("a.fold", flap_in_fold(&Value::Null)),
        ("a.fold", flap_in_fold(&without_window)),
        ("a.fold", bridged.to_string()),
        ("a.fold", keyhole.to_string()),
        ("a.svg", flap_in_svg("#0f0")),
        ("a.svg", flap_in_svg("black")),
        ("a.cp", flap_in_cp()),
    ] {
        let options = if name == "a.cp" { "--fold 0.9" } else { "" };
        let plan = planned(name, &text, options);
        assert_eq!(plan["creases"], 2, "{text}");
        let pattern = pattern(name, &text);
        assert_eq!((pattern.sheets(), pattern.holes().len()), (1, 1), "{text}");
    }
}

/// Windows and slots change no motion: they are told, and the sheet stays one. A piece with a crease that is cut out all
/// round is a sheet of its own.
#[test]
fn what_is_cut_out_falls_out() {
    let border = "1 0 0 9 0\n1 9 0 9 9\n1 9 9 0 9\n1 0 9 0 0\n2 3 0 3 9\n";
    let square = |low: f64, high: f64| {
        format!(
            "1 {low} {low} {high} {low}\n1 {high} {low} {high} {high}\n1 {high} {high} {low} {high}\n1 {low} {high} {low} {low}\n"
        )
    };
    let inner = "2 6 4 6 8\n";
    for (lines, sheets, holes) in [
        (square(4.0, 8.0), 1, 1),
        // A window in what falls out.
        (square(4.0, 8.0) + &square(5.0, 7.0), 1, 1),
        (square(4.0, 8.0) + inner, 2, 1),
        // A window that touches the crease with a corner, and one that touches the border.
        ("1 3 4 5 3\n1 5 3 5 5\n1 5 5 3 4\n".into(), 1, 1),
        ("1 9 4 7 3\n1 7 3 7 5\n1 7 5 9 4\n".into(), 1, 0),
    ] {
        let text = format!("{border}{lines}");
        let found = pattern("a.cp", &text);
        assert_eq!(
            (found.sheets(), found.holes().len()),
            (sheets, holes),
            "{text}"
        );
        planned("a.cp", &text, "--fold 0.5");
    }
    // A single cut inside a panel, and a cut along the same line twice.
    let slot = json!({
        "vertices_coords": [[0, 0], [3, 0], [9, 0], [9, 9], [3, 9], [0, 9], [5, 4], [6, 6], [7, 4]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4], [6, 7], [7, 8]],
        "edges_assignment": ["B", "B", "B", "B", "B", "B", "V", "C", "C"],
    });
    let found = pattern("a.fold", &slot.to_string());
    assert_eq!((found.sheets(), found.holes().len()), (1, 0));
    let said = found.assumptions().iter();
    assert!(
        said.clone().any(|it| it.contains("which part nothing")),
        "{:?}",
        found.assumptions()
    );
    assert_eq!(
        planned("a.fold", &slot.to_string(), "--fold 0.5")["creases"],
        1
    );
    let mut twice = slot;
    twice["vertices_coords"]
        .as_array_mut()
        .unwrap()
        .extend([json!([5, 4]), json!([6, 6])]);
    twice["edges_vertices"]
        .as_array_mut()
        .unwrap()
        .push(json!([9, 10]));
    twice["edges_assignment"]
        .as_array_mut()
        .unwrap()
        .push(json!("C"));
    assert_eq!(
        planned("a.fold", &twice.to_string(), "--fold 0.5")["creases"],
        1
    );
}

/// Returns a number from 0 to 1 that depends on both arguments.
fn chance(seed: u32, part: u32) -> f64 {
    let x = (f64::from(seed) * 12.9898 + f64::from(part) * 78.233).sin() * 43_758.545_3;
    x - x.floor()
}

fn bezier([a, b, c, d]: [[f64; 2]; 4], t: f64) -> [f64; 2] {
    let s = 1.0 - t;
    core::array::from_fn(|k| {
        s * s * s * a[k] + 3.0 * s * s * t * b[k] + 3.0 * s * t * t * c[k] + t * t * t * d[k]
    })
}

/// Returns the cubic curves of a closed outline round (50, 50), counter-clockwise in a plane whose y points up.
fn outline(seed: u32) -> Vec<[[f64; 2]; 4]> {
    let count = 3 + seed % 6;
    let turn = core::f64::consts::TAU / f64::from(count);
    let knots: Vec<_> = (0..count)
        .map(|k| {
            let radius = 40.0 + 5.0 * chance(seed, k);
            let (sin, cos) = (f64::from(k) * turn).sin_cos();
            let handle =
                radius * 4.0 / 3.0 * (turn / 4.0).tan() * (0.9 + 0.2 * chance(seed, 50 + k));
            let at = [50.0 + radius * cos, 50.0 + radius * sin];
            (at, [-sin * handle, cos * handle])
        })
        .collect();
    let next = knots.iter().cycle().skip(1);
    let curves = knots.iter().zip(next).map(|((a, out), (d, back))| {
        let b = core::array::from_fn(|k| a[k] + out[k]);
        let c = core::array::from_fn(|k| d[k] - back[k]);
        [*a, b, c, *d]
    });
    curves.collect()
}

/// Returns the sum of the areas of all faces.
fn area(pattern: &CreasePattern) -> f64 {
    let corner = |vertex: VertexId| pattern.vertices()[vertex.index()];
    let triangles = pattern.triangles().items().iter();
    let twice = triangles.map(|t| {
        let [a, b, c] = t.map(corner);
        (b - a).perp(&(c - a))
    });
    twice.sum::<f64>() / 2.0
}

/// Sixty outlines of Bézier curves, each with a crease between two places on them. The chords keep the area within their
/// tolerance times the length of the outline, and the crease meets them: no line is lost.
#[test]
fn borders_of_curves_become_chords() {
    const PARTS: u32 = 1000;
    for seed in 0..60 {
        let curves = outline(seed);
        let half = curves.len() / 2;
        let ends = [(0, 1), (half, 2)]
            .map(|(curve, part)| bezier(curves[curve], 0.2 + 0.6 * chance(seed, 100 + part)));
        let mut path = String::new();
        for (index, [a, b, c, d]) in curves.iter().enumerate() {
            if index == 0 {
                write!(path, "M{} {}", a[0], a[1]).unwrap();
            }
            write!(
                path,
                "C{} {} {} {} {} {}",
                b[0], b[1], c[0], c[1], d[0], d[1]
            )
            .unwrap();
        }
        let [[x1, y1], [x2, y2]] = ends;
        let text = svg(
            [100.0, 100.0],
            &format!(
                "<path d=\"{path}Z\" stroke=\"black\" fill=\"none\"/>\n\
                 <line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" stroke=\"red\"/>"
            ),
        );
        let found = pattern("a.svg", &text);
        assert!(
            found.lost_lines().is_none(),
            "{text}\n{:?}",
            found.repairs()
        );
        assert_eq!(
            (found.creases().len(), found.faces().len()),
            (1, 2),
            "{text}"
        );
        let places = curves.iter().flat_map(|&curve| {
            (0..PARTS).map(move |k| bezier(curve, f64::from(k) / f64::from(PARTS)))
        });
        let places: Vec<_> = places.collect();
        let next = places.iter().cycle().skip(1);
        let (mut exact, mut length) = (0.0, 0.0);
        for (a, b) in places.iter().zip(next) {
            exact += (a[0] * b[1] - a[1] * b[0]) / 2.0;
            length += (a[0] - b[0]).hypot(a[1] - b[1]);
        }
        let said = found.assumptions().iter();
        let note = said
            .clone()
            .find(|it| it.starts_with("curves drawn as chords"));
        let note = note.unwrap_or_else(|| panic!("{:?}", found.assumptions()));
        let words: Vec<&str> = note.split_whitespace().collect();
        let number = |after: &str| -> f64 {
            let at = words.iter().position(|word| *word == after).unwrap();
            words[at + 1].trim_end_matches(',').parse().unwrap()
        };
        let (tolerance, chords) = (number("within"), number("by"));
        let difference = exact - area(&found);
        assert!(
            (0.0..tolerance * length).contains(&difference.abs()),
            "{difference}: {text}"
        );
        assert!(tolerance < 0.1 && chords < 200.0, "{note}");
        if seed % 6 == 0 {
            planned("a.svg", &text, "--fold 0.5");
        }
    }
}

/// Arcs, circles, ellipses and rounded corners are curves as well, also of windows and cuts, and a crease may end on them.
#[test]
fn arcs_of_borders_and_windows_become_chords() {
    let crease = |x: f64, y1: f64, y2: f64| {
        format!("<line x1=\"{x}\" y1=\"{y1}\" x2=\"{x}\" y2=\"{y2}\" stroke=\"blue\"/>")
    };
    let chord = |x: f64| (40.0_f64.powi(2) - (x - 50.0).powi(2)).sqrt();
    for (elements, creases, holes) in [
        (
            format!(
                "<circle cx=\"50\" cy=\"50\" r=\"40\" stroke=\"black\" fill=\"none\"/>{}",
                crease(50.0, 10.0, 90.0)
            ),
            1,
            0,
        ),
        (
            format!(
                "<circle cx=\"50\" cy=\"50\" r=\"40\" stroke=\"black\" fill=\"none\"/>{}",
                crease(37.3, 50.0 - chord(37.3), 50.0 + chord(37.3))
            ),
            1,
            0,
        ),
        (
            format!(
                "<rect x=\"5\" y=\"5\" width=\"90\" height=\"60\" rx=\"8\" stroke=\"black\" fill=\"none\"/>\
                 <ellipse cx=\"75\" cy=\"35\" rx=\"9\" ry=\"5\" stroke=\"#0f0\" fill=\"none\"/>{}",
                crease(50.0, 5.0, 65.0)
            ),
            1,
            1,
        ),
        // A round flap: three quarters of a circle are cut, and a hinge joins the ends.
        (
            format!(
                "<rect x=\"5\" y=\"5\" width=\"90\" height=\"60\" stroke=\"black\" fill=\"none\"/>\
                 <path d=\"M70 30A10 10 0 1 1 70 45\" stroke=\"#0f0\" fill=\"none\"/>\
                 {}{}",
                crease(70.0, 30.0, 45.0),
                crease(50.0, 5.0, 65.0)
            ),
            2,
            1,
        ),
    ] {
        let text = svg([100.0, 100.0], &elements);
        let plan = planned("a.svg", &text, "--fold 0.5");
        assert_eq!(plan["creases"], creases, "{text}\n{plan}");
        let found = pattern("a.svg", &text);
        assert_eq!((found.sheets(), found.holes().len()), (1, holes), "{text}");
        assert!(found.lost_lines().is_none(), "{text}");
    }
}

/// A curved crease is refused with its place and length.
#[test]
fn a_curved_crease_is_refused() {
    let text = svg(
        [100.0, 100.0],
        "<rect width=\"100\" height=\"100\" stroke=\"black\" fill=\"none\"/>\n\
         <path d=\"M50 0A50 50 0 0 1 50 100\" stroke=\"red\" fill=\"none\"/>",
    );
    let folder = folder();
    folder.write("a.svg", &text);
    let refused = folder.run("info a.svg").with_status(2).stderr;
    // A quarter of the circle is the first of its curves: 78.54 long, and a little more as a Bézier curve.
    assert!(
        refused.contains("stroked shape 2, stroke #ff0000: expected a straight crease")
            && refused.contains("a curve 7.855e1 long from (50, 0) to (100, 50)"),
        "{refused}"
    );
}

/// Returns a square in FOLD whose right side is a curve, with these faces; `bent` is the letter of the curve.
fn curve_in_fold(faces: &Value, bent: &str) -> Value {
    let mut file = json!({
        "vertices_coords": [[0, 0], [5, 0], [10, 0], [10, 10], [5, 10], [0, 10], [13, 3], [13, 7]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3, 6, 7], [3, 4], [4, 5], [5, 0], [1, 4]],
        "edges_assignment": ["B", "B", bent, "B", "B", "B", "M"],
        "edges_foldAngle": [0, 0, 0, 0, 0, 0, -120],
    });
    if !faces.is_null() {
        file["faces_vertices"] = faces.clone();
    }
    file
}

/// Four vertices of an edge are a Bézier curve. Other edges keep their numbers, and a file of the same edges is a goal.
#[test]
fn curves_in_fold_become_chords() {
    for faces in [
        Value::Null,
        json!([[0, 1, 4, 5], [1, 2, 3, 4]]),
        json!([[0, 1, 4, 5], [4, 3, 2, 1]]),
    ] {
        let text = curve_in_fold(&faces, "B").to_string();
        let plan = planned("a.fold", &text, "");
        assert_eq!(plan["creases"], 1, "{plan}");
        planned("a.fold", &text, "--goal a.fold");
        planned("a.fold", &text, "--crease 6=-90");
        let said = plan["notes"].to_string();
        assert!(said.contains("curves drawn as chords: 1, by "), "{said}");
        // The integral of x dy along the curve, 9 (9/20 + 24/30 + 9/20), is added to the square.
        let found = pattern("a.fold", &text);
        assert!((area(&found) - 115.3).abs() < 0.1, "{}", area(&found));
    }
    let folder = folder();
    folder.write("a.fold", &curve_in_fold(&Value::Null, "V").to_string());
    let refused = folder.run("info a.fold").with_status(2).stderr;
    assert!(
        refused.contains("edges_vertices[2]: expected a straight crease, as rigid panels turn about a line, found a curve 1.")
            && refused.contains("from (10, 0) to (10, 10)"),
        "{refused}"
    );
    folder.write(
        "a.fold",
        &curve_in_fold(&Value::Null, "B")
            .to_string()
            .replace("6,7", "6,9"),
    );
    let refused = folder.run("info a.fold").with_status(2).stderr;
    assert!(
        refused.contains("edges_vertices[2]: expected vertices from 0 to 7"),
        "{refused}"
    );
}

/// Pieces of a crease with gaps between them are one crease, whatever part of a gap it ends with.
#[test]
fn a_perforated_crease_is_one_crease() {
    let dashes = |from: [f64; 2], to: [f64; 2], start: f64, dash: f64, gap: f64, digits: usize| {
        let way = [to[0] - from[0], to[1] - from[1]];
        let length = way[0].hypot(way[1]);
        let place = |s: f64| way.map(|w| w * s / length);
        let mut lines = String::new();
        let mut s = start;
        while s < length - 1e-9 {
            let [a, b] = [s, (s + dash).min(length)].map(place);
            writeln!(
                lines,
                "<path d=\"M{:.digits$} {:.digits$}L{:.digits$} {:.digits$}\" stroke=\"red\"/>",
                from[0] + a[0],
                from[1] + a[1],
                from[0] + b[0],
                from[1] + b[1]
            )
            .unwrap();
            s += dash + gap;
        }
        lines
    };
    let border = "<rect width=\"120\" height=\"58\" stroke=\"black\" fill=\"none\"/>\n";
    let upright = |start, dash, gap| dashes([40.0, 0.0], [40.0, 58.0], start, dash, gap, 4);
    for (lines, creases) in [
        (upright(0.0, 3.0, 2.0), 1),
        (upright(2.0, 3.0, 2.0), 1),
        (upright(1.0, 2.0, 3.0), 1),
        (upright(0.5, 6.0, 1.0), 1),
        (dashes([20.0, 0.0], [70.0, 58.0], 1.0, 4.0, 3.0, 2), 1),
        // A line that crosses another one at a gap or a dash.
        (
            upright(0.0, 3.0, 2.0) + "<path d=\"M0 20H120\" stroke=\"blue\"/>",
            4,
        ),
        (
            upright(0.0, 3.0, 2.0) + "<path d=\"M0 24H120\" stroke=\"blue\"/>",
            4,
        ),
        (
            upright(1.0, 3.0, 2.0) + &dashes([80.0, 0.0], [80.0, 58.0], 0.0, 5.0, 4.0, 4),
            2,
        ),
    ] {
        let text = svg([120.0, 58.0], &format!("{border}{lines}"));
        let found = pattern("a.svg", &text);
        assert_eq!(
            found.creases().len(),
            creases,
            "{text}\n{:?}",
            found.repairs()
        );
        assert!(
            found.lost_lines().is_none(),
            "{text}\n{:?}",
            found.repairs()
        );
        let said = found.repairs().iter();
        assert!(
            said.clone().any(|it| it.starts_with("pieces of creases")),
            "{:?}",
            found.repairs()
        );
    }
    // Pieces in a FOLD file are edges that end in a panel.
    let pieces = json!({
        "vertices_coords": [[0, 0], [6, 0], [6, 6], [0, 6], [3, 0], [3, 1], [3, 2], [3, 3.5], [3, 4.5], [3, 6]],
        "edges_vertices": [[0, 4], [4, 1], [1, 2], [2, 9], [9, 3], [3, 0], [4, 5], [6, 7], [8, 9]],
        "edges_assignment": ["B", "B", "B", "B", "B", "B", "V", "V", "V"],
    });
    let found = pattern("a.fold", &pieces.to_string());
    assert_eq!(found.creases().len(), 1, "{:?}", found.repairs());
    // Two creases that end in the open far from each other are no perforation.
    let apart = svg(
        [120.0, 58.0],
        &format!("{border}<path d=\"M40 0V10M40 48V58M80 0V58\" stroke=\"red\"/>"),
    );
    let found = pattern("a.svg", &apart);
    assert_eq!(
        (
            found.creases().len(),
            found.lost_lines().map(|lost| lost.count)
        ),
        (1, Some(2))
    );
}

/// Dashes that are the only sign of a crease are named, and an option gives them a letter.
#[test]
fn dashes_are_creases_if_they_are_given_a_letter() {
    let text = svg(
        [300.0, 100.0],
        "<rect width=\"300\" height=\"100\" stroke=\"#000\" fill=\"none\"/>\n\
         <path d=\"M100 0V100M200 0V100\" stroke=\"#000\" stroke-dasharray=\"4 2\"/>",
    );
    let folder = folder();
    folder.write("a.svg", &text);
    let refused = folder.run("plan a.svg").with_status(2).stderr;
    assert!(refused.contains("`--dashes V`"), "{refused}");
    let info = folder.done("info a.svg --json").json();
    let named =
        "dashed lines that are no creases by their colour, where dashes were given no letter: 2";
    assert!(info["assumptions"].to_string().contains(named), "{info}");
    for (letter, sign) in [("V", 1.0), ("M", -1.0)] {
        let plan = planned("a.svg", &text, &format!("--dashes {letter} --fold 0.4"));
        assert_eq!(plan["creases"], 2);
        assert_eq!(plan["options"]["dashes"], letter);
        folder.done(&format!(
            "plan a.svg --dashes {letter} --fold 0.4 -o path.fold"
        ));
        let path = folder.read_json("path.fold");
        let last = path["file_frames"]
            .as_array()
            .unwrap()
            .last()
            .unwrap()
            .clone();
        let angles = last["edges_foldAngle"].as_array().unwrap();
        let turned = angles
            .iter()
            .filter_map(Value::as_f64)
            .filter(|angle| angle.abs() > 1.0);
        assert!(
            turned.clone().count() == 2 && turned.clone().all(|a| (a * sign - 72.0).abs() < 1.0),
            "{last}"
        );
    }
    let info = folder.done("info a.svg --json --dashes F").json();
    assert_eq!(info["creases"], 0, "{info}");
    folder.write("a.cp", &flap_in_cp());
    let refused = folder.run("info a.cp --dashes V").with_status(2).stderr;
    assert!(
        refused.contains("the letter of dashes: expected an SVG drawing or a DXF drawing"),
        "{refused}"
    );
    folder.write("b.svg", &flap_in_svg("black"));
    let info = folder.done("info b.svg --json --dashes V").json();
    let unused = "dashes were given the letter V, but no line is dashed";
    assert!(info["assumptions"].to_string().contains(unused), "{info}");
}
