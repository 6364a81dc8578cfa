//! Edges have the names that a drawing gives to their lines: ids in SVG, layers in DXF.

use core::fmt::Write as _;
use std::collections::BTreeMap;

use serde_json::Value;

use crate::common::folder;

/// Widths of panels side by side, with a hinge between each two of them.
const WIDTHS: [f64; 4] = [30.0, 20.0, 30.0, 20.0];
const HEIGHT: f64 = 50.0;

/// Returns the places of the hinges along the strip, and behind them its end.
fn places() -> Vec<f64> {
    let mut place = 0.0;
    let places = WIDTHS.iter().map(|width| {
        place += width;
        place
    });
    places.collect()
}

/// Returns a strip as SVG. Each hinge is drawn as `hinge` returns it for its number and place.
fn svg(hinge: impl Fn(usize, f64) -> String) -> String {
    let places = places();
    let (length, hinges) = (places[3], &places[..3]);
    let drawn: String = hinges
        .iter()
        .enumerate()
        .map(|(number, at)| hinge(number, *at))
        .collect();
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{length}mm\" height=\"{HEIGHT}mm\" \
         viewBox=\"0 0 {length} {HEIGHT}\"><g id=\"cut\"><rect id=\"rim\" width=\"{length}\" height=\"{HEIGHT}\" \
         fill=\"none\" stroke=\"black\"/></g>\n<g id=\"walls\">{drawn}</g></svg>"
    )
}

/// Returns a vertical line.
fn line(id: &str, x: f64, from: f64, to: f64) -> String {
    format!("<path id=\"{id}\" d=\"M{x},{from}V{to}\" stroke=\"blue\"/>")
}

/// Returns the same strip as DXF, with each hinge on the layer of its number.
fn dxf(layers: [&str; 3]) -> String {
    let places = places();
    let length = places[3];
    let mut lines = vec![
        ("CUT", [0.0, 0.0, length, 0.0]),
        ("CUT", [length, 0.0, length, HEIGHT]),
        ("CUT", [length, HEIGHT, 0.0, HEIGHT]),
        ("CUT", [0.0, HEIGHT, 0.0, 0.0]),
    ];
    let hinges = layers.into_iter().zip(&places);
    lines.extend(hinges.map(|(layer, x)| (layer, [*x, 0.0, *x, HEIGHT])));
    let mut text = "0\nSECTION\n2\nENTITIES\n".to_string();
    for (layer, [x, y, u, v]) in lines {
        writeln!(
            text,
            "0\nLINE\n8\n{layer}\n62\n5\n10\n{x}\n20\n{y}\n11\n{u}\n21\n{v}"
        )
        .unwrap();
    }
    text + "0\nENDSEC\n0\nEOF\n"
}

/// Returns for each name the places along the strip of the edges that have it, as `info --edges` lists them.
fn named(file: &str, text: &str, options: &str) -> BTreeMap<String, Vec<f64>> {
    let folder = folder();
    folder.write(file, text);
    let info = folder
        .done(&format!("info {file} --edges --json {options}"))
        .json();
    let mut named: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for edge in info["edges"].as_array().unwrap() {
        let middle =
            (edge["ends"][0][0].as_f64().unwrap() + edge["ends"][1][0].as_f64().unwrap()) / 2.0;
        for name in edge["names"].as_array().unwrap() {
            named
                .entry(name.as_str().unwrap().into())
                .or_default()
                .push(middle);
        }
    }
    for places in named.values_mut() {
        places.sort_by(f64::total_cmp);
    }
    named
}

#[test]
fn edges_have_the_ids_of_their_shapes_and_groups() {
    let ids = ["lid", "back", "flap"];
    let whole = svg(|number, x| line(ids[number], x, 0.0, HEIGHT));
    let names = named("a.svg", &whole, "");
    assert_eq!(names["walls"], [30.0, 50.0, 80.0]);
    for (id, place) in ids.iter().zip([30.0, 50.0, 80.0]) {
        assert_eq!(names[*id], [place], "{names:?}");
    }
    // The border is split where hinges end on it.
    assert_eq!(names["rim"].len(), 10, "{names:?}");
    assert_eq!(names["cut"], names["rim"]);
    assert_eq!(names.len(), 6, "{names:?}");
    let by_layers = dxf(["lid", "back", "flap"]);
    let names = named("a.dxf", &by_layers, "");
    for (id, place) in ids.iter().zip([30.0, 50.0, 80.0]) {
        assert_eq!(names[*id], [place], "{names:?}");
    }
    assert_eq!(names["CUT"].len(), 10, "{names:?}");
}

/// Repairs change lines, and names go along.
#[test]
fn repaired_lines_keep_their_names() {
    let hinge = |number: usize, x: f64| match number {
        // Drawn in pieces, as a perforation is; only some pieces have names.
        0 => (0..5)
            .map(|k| {
                let from = 10.0 * f64::from(k);
                line(if k % 2 == 0 { "lid" } else { "" }, x, from, from + 8.0)
                    .replace(" id=\"\"", "")
            })
            .collect(),
        // Drawn twice, under two names.
        1 => line("back", x, 0.0, HEIGHT) + &line("twin", x, HEIGHT, 0.0),
        // Ends a little short of the border.
        _ => line("flap", x + 0.002, 0.002, HEIGHT - 0.003),
    };
    let text = svg(hinge);
    for options in ["", "--unit mm", "--straighten on"] {
        let names = named("a.svg", &text, options);
        assert_eq!(names["lid"].len(), 1, "{options}: {names:?}");
        assert_eq!(names["back"], names["twin"], "{options}: {names:?}");
        assert_eq!(names["flap"].len(), 1, "{options}: {names:?}");
        let places = [&names["lid"], &names["back"], &names["flap"]].map(|places| places[0]);
        for (place, drawn) in places.iter().zip([30.0, 50.0, 80.0]) {
            assert!((place - drawn).abs() < 0.01, "{options}: {names:?}");
        }
    }
    // A line across the hinges parts each of them in two, which keep the names.
    let crossed = svg(|number, x| {
        let across = if number == 0 {
            "<path d=\"M0,25H100\" stroke=\"yellow\"/>"
        } else {
            ""
        };
        line(["lid", "back", "flap"][number], x, 0.0, HEIGHT) + across
    });
    let names = named("a.svg", &crossed, "");
    assert_eq!(names["lid"], [30.0, 30.0], "{names:?}");
    assert_eq!(names["walls"].len(), 6 + 4, "{names:?}");
}

/// Names that would be read as numbers, or that have signs of orders in them, stand in quotation marks.
#[test]
fn quoted_names_are_names() {
    let numbers = frames(
        "a.dxf",
        &dxf(["lid", "back", "flap"]),
        "flap / lid=70,back / lid",
    );
    for (layers, order) in [
        (["0", "a/b", "1-2"], "\"1-2\" / \"0\"=70,\"a/b\" / \"0\""),
        (
            ["x=1", "7,8", "3"],
            "\"3\" / \"x=1\" = 70, \"7,8\" / \"x=1\"",
        ),
        (["lid", "back", "flap"], "\"flap\" / \"lid\"=70,back / lid"),
    ] {
        assert_eq!(frames("a.dxf", &dxf(layers), order), numbers, "{order}");
    }
    let folder = folder();
    folder.write("a.dxf", &dxf(["0", "a/b", "1-2"]));
    for order in ["\"0", "\"\"", "\"0\"\"1-2\"", "0\""] {
        let mut command = folder.command("plan a.dxf --fold 0.3 --order");
        let answer = command.arg(order).output().unwrap();
        let said = String::from_utf8_lossy(&answer.stderr).into_owned();
        assert_eq!(answer.status.code(), Some(2), "{order}: {said}");
        assert!(
            said.contains("expected an edge such as 5"),
            "{order}: {said}"
        );
    }
    // The answer has the order as it can be asked for again.
    let mut command = folder.command("plan a.dxf --fold 0.3 --json --order");
    let answer = command.arg("\"0\" / \"a/b\"").output().unwrap();
    let answer: Value = serde_json::from_slice(&answer.stdout).unwrap();
    assert_eq!(answer["options"]["order"], "\"0\" / \"a/b\"");
}

/// Returns the path that a plan in an order writes.
fn frames(file: &str, text: &str, order: &str) -> Value {
    let folder = folder();
    folder.write(file, text);
    let mut command = folder.command(&format!("plan {file} --fold 0.3 -o path.fold --order"));
    let plan = command.arg(order).output().unwrap();
    let said = String::from_utf8_lossy(&plan.stderr);
    assert!(plan.status.success(), "{order}: {said}");
    folder.read_json("path.fold")["file_frames"].take()
}

#[test]
fn an_order_by_names_is_the_order_by_numbers() {
    let ids = ["lid", "back wall", "flap-2"];
    let drawn = svg(|number, x| line(ids[number], x, 0.0, HEIGHT));
    let by_layers = dxf(ids);
    for (file, text) in [("a.svg", &drawn), ("a.dxf", &by_layers)] {
        let folder = folder();
        folder.write(file, text);
        let info = folder.done(&format!("info {file} --edges --json")).json();
        let edges = info["edges"].as_array().unwrap().iter();
        let number = |name: &str| {
            let mut with_name = edges.clone().filter(|edge| {
                edge["names"]
                    .as_array()
                    .unwrap()
                    .iter()
                    .any(|it| it == name)
            });
            with_name.next().unwrap()["edge"].clone()
        };
        let [lid, back, flap] = ids.map(number);
        let by_numbers = frames(file, text, &format!("{flap} / {lid}=70,{back} / {lid}"));
        let by_names = frames(file, text, "flap-2 / lid=70,back wall / lid");
        assert_eq!(by_names, by_numbers, "{file}");
    }
    // The name of a group stands for all of its hinges, and a border has no part in it.
    let at_once = frames("a.svg", &drawn, "walls");
    assert_eq!(at_once, frames("a.svg", &drawn, "lid,back wall,flap-2"));
}

#[test]
fn a_name_that_is_not_there_names_the_nearest() {
    let drawn = svg(|number, x| line(["lid", "back", "flap"][number], x, 0.0, HEIGHT));
    let folder = folder();
    folder.write("a.svg", &drawn);
    for (order, words) in [
        (
            "led",
            "\"led\": expected the name of a hinge between two faces, but the drawing has no such name",
        ),
        ("led", "the nearest name of a hinge is \"lid\""),
        ("FLAPS=30", "the nearest name of a hinge is \"flap\""),
        ("lid / rim", "none of the edges of this name is one"),
    ] {
        let mut command = folder.command("plan a.svg --fold 0.3 --order");
        let answer = command.arg(order).output().unwrap();
        let said = String::from_utf8_lossy(&answer.stderr).into_owned();
        assert_eq!(answer.status.code(), Some(2), "{said}");
        assert!(said.contains(words), "{order}: {said}");
    }
}

/// The list has every edge, with the numbers of the file.
#[test]
fn edges_are_listed_as_the_file_has_them() {
    let folder = folder();
    folder.done("generate miura --rows 3 --cols 3 -o a.fold");
    let file = folder.read_json("a.fold");
    let info = folder.done("info a.fold --edges --json").json();
    let count = folder.done("info a.fold --json").json()["edges"].clone();
    let edges = info["edges"].as_array().unwrap();
    assert_eq!(count, edges.len());
    let text = folder.done("info a.fold --edges").stdout;
    for (number, edge) in edges.iter().enumerate() {
        assert_eq!(edge["edge"], number);
        assert_eq!(edge["vertices"], file["edges_vertices"][number]);
        assert_eq!(edge["letter"], file["edges_assignment"][number]);
        for end in 0..2 {
            let vertex = edge["vertices"][end].as_u64().unwrap();
            let vertex = usize::try_from(vertex).unwrap();
            for axis in 0..2 {
                let [told, written] = [
                    &edge["ends"][end][axis],
                    &file["vertices_coords"][vertex][axis],
                ]
                .map(|number| number.as_f64().unwrap());
                assert!((told - written).abs() < 1e-12);
            }
        }
        let row = format!("  {number:>5}  {}  ", edge["letter"].as_str().unwrap());
        assert!(text.contains(&row), "{text}");
        let goal = file["edges_foldAngle"][number].as_f64().unwrap();
        if goal != 0.0 {
            assert!((edge["goal"].as_f64().unwrap() - goal).abs() < 1e-9);
        }
    }
}
