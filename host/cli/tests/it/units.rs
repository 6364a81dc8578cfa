//! A drawing keeps its unit: places, tolerances, paths and models speak it.

use serde_json::{Value, json};

use crate::common::folder;

/// Returns an SVG drawing of a square of 40 user units with a valley in its middle, and a line that ends in the open,
/// from (50, 30) up to (50, 12). `head` has the attributes of the root, `inner` what is drawn inside of it.
fn svg(head: &str, group: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" {head}><g {group}>\n\
         <rect x=\"30\" y=\"10\" width=\"40\" height=\"20\" fill=\"none\" stroke=\"#000\"/>\n\
         <line x1=\"50\" y1=\"10\" x2=\"50\" y2=\"30\" stroke=\"#00f\"/>\n\
         <line x1=\"60\" y1=\"30\" x2=\"60\" y2=\"12\" stroke=\"#f00\"/></g></svg>"
    )
}

/// Returns the coordinates of the sheet in a path, and its unit.
fn sheet_of(path: &Value) -> (Vec<[f64; 2]>, Option<String>) {
    let coordinates = path["vertices_coords"].as_array().unwrap().iter();
    let places = coordinates.map(|at| [0, 1].map(|axis| at[axis].as_f64().unwrap()));
    let unit = path["frame_unit"].as_str().map(String::from);
    (places.collect(), unit)
}

/// Width and height with a unit give the drawing that unit; without them a drawing has user units. The view box moves
/// nothing.
#[test]
fn drawings_speak_their_unit() {
    for (head, group, length, unit) in [
        ("viewBox=\"0 0 100 60\"", "", 1.0, None),
        ("viewBox=\"25 5 100 60\"", "", 1.0, None),
        (
            "width=\"500\" height=\"300\" viewBox=\"0 0 100 60\"",
            "",
            1.0,
            None,
        ),
        (
            "width=\"100mm\" height=\"60mm\" viewBox=\"0 0 100 60\"",
            "",
            1.0,
            Some("mm"),
        ),
        (
            "width=\"100mm\" height=\"60mm\" viewBox=\"20 -7 100 60\"",
            "",
            1.0,
            Some("mm"),
        ),
        (
            "width=\"25cm\" height=\"15cm\" viewBox=\"0 0 100 60\"",
            "",
            0.25,
            Some("cm"),
        ),
        (
            "width=\"10in\" height=\"9in\" viewBox=\"0 0 100 60\"",
            "",
            0.1,
            Some("in"),
        ),
        (
            "width=\"200pt\" height=\"120pt\" viewBox=\"0 0 100 60\"",
            "",
            2.0,
            Some("pt"),
        ),
        (
            "width=\"100mm\" height=\"60mm\" viewBox=\"0 0 50 30\"",
            "transform=\"scale(0.5)\"",
            1.0,
            Some("mm"),
        ),
        // Without a view box user units are pixels, 96 to an inch.
        ("width=\"96in\" height=\"96in\"", "", 1.0 / 96.0, Some("in")),
    ] {
        let folder = folder();
        folder.write("drawing.svg", &svg(head, group));
        let info = folder.done("info drawing.svg --json").json();
        let repairs = info["repairs"].to_string();
        // As a place is told, with seven digits.
        let told = |length: f64| format!("{length:.6e}").parse::<f64>().unwrap();
        let end = format!(
            "first open end at ({}, {})",
            told(60.0 * length),
            told(12.0 * length)
        );
        assert!(repairs.contains(&end), "{head}: {repairs}");
        let plan = folder.done("plan drawing.svg --json -o path.fold").json();
        assert_eq!(plan["unit"], unit.map_or(Value::Null, |unit| json!(unit)));
        let (places, told) = sheet_of(&folder.read_json("path.fold"));
        assert_eq!(told.as_deref(), unit, "{head}");
        let widest = places
            .iter()
            .fold(f64::NEG_INFINITY, |most, at| most.max(at[0]));
        let lowest = places
            .iter()
            .fold(f64::INFINITY, |least, at| least.min(at[1]));
        assert!(
            (widest - 70.0 * length).abs() < 1e-6 * length,
            "{head}: {widest}"
        );
        assert!(
            (lowest + 30.0 * length).abs() < 1e-6 * length,
            "{head}: {lowest}"
        );
    }
}

/// Tolerances are lengths in the drawing's unit.
#[test]
fn tolerances_speak_the_unit() {
    let folder = folder();
    let head = "width=\"100mm\" height=\"60mm\" viewBox=\"0 0 100 60\"";
    folder.write("drawing.svg", &svg(head, ""));
    let creases = |options: &str| {
        let command = format!("info drawing.svg --json {options}");
        folder.done(&command).json()["creases"].clone()
    };
    assert_eq!(creases("--tolerance 1.9"), 1);
    assert_eq!(creases("--tolerance 2.1"), 2);
}

/// A unit that the file does not name is told, and never contradicts the file.
#[test]
fn a_unit_is_told_where_the_file_names_none() {
    let folder = folder();
    folder.write("plain.svg", &svg("viewBox=\"0 0 100 60\"", ""));
    folder.done("plan plain.svg --unit cm -o path.fold");
    assert_eq!(folder.read_json("path.fold")["frame_unit"], "cm");
    folder.run("info path.fold --unit cm").with_status(0);
    let refused = folder.run("plan path.fold --unit mm").with_status(2);
    assert!(refused.tells("path.fold: the unit of lengths: expected no unit, or mm, found cm"));
    // FOLD names units that are none of its own, or none at all.
    let mut path = folder.read_json("path.fold");
    for (named, note) in [
        (json!("furlong"), true),
        (json!("unit"), false),
        (Value::Null, false),
    ] {
        path["frame_unit"] = named.clone();
        folder.write("other.fold", &path.to_string());
        let info = folder.done("info other.fold --json").json();
        let noted = info["assumptions"].to_string().contains("furlong");
        assert_eq!(noted, note, "{named}: {info}");
    }
}

/// Models are in metres if the unit is known, drawings are as large as the sheet, and both come back.
#[test]
fn exports_speak_the_unit() {
    let folder = folder();
    let head = "width=\"100mm\" height=\"60mm\" viewBox=\"0 0 100 60\"";
    folder.write("drawing.svg", &svg(head, ""));
    folder.done("plan drawing.svg -o path.fold");
    folder.done("export path.fold --to mjcf -o model");
    let scene = folder.read("model/scene.xml");
    assert!(scene.contains("Lengths are in metres"), "{scene}");
    let hinge = scene.split("name=\"crease_").nth(1).unwrap();
    let place = hinge
        .split("pos=\"")
        .nth(1)
        .unwrap()
        .split(' ')
        .next()
        .unwrap();
    let x: f64 = place.parse().unwrap();
    assert!((x - 0.05).abs() < 1e-12, "{place}");
    folder.done("export path.fold --to svg -o again.svg");
    folder.done("plan again.svg -o again.fold");
    let [(first, unit), (second, again)] =
        ["path.fold", "again.fold"].map(|name| sheet_of(&folder.read_json(name)));
    assert_eq!(
        (unit.as_deref(), again.as_deref()),
        (Some("mm"), Some("mm"))
    );
    let size = |places: &[[f64; 2]], axis: usize| {
        let along = || places.iter().map(|at| at[axis]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    for axis in 0..2 {
        let sizes = [&first, &second].map(|places| size(places, axis));
        assert!((sizes[0] - sizes[1]).abs() < 1e-4, "{sizes:?}");
    }
}

/// A shape that names no unit gets the one that the command names, and keeps its own.
#[test]
fn a_shape_is_unfolded_in_its_unit() {
    let folder = folder();
    let tent = "v 0 0 0\nv 2 0 0\nv 2 1 1\nv 0 1 1\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\nf 4 3 5 6\n";
    folder.write("tent.obj", tent);
    folder.done("unfold tent.obj -o net.fold");
    assert_eq!(folder.read_json("net.fold").get("frame_unit"), None);
    folder.done("unfold tent.obj --unit mm -o net.fold");
    assert_eq!(folder.read_json("net.fold")["frame_unit"], "mm");
    folder.done("plan net.fold -o path.fold");
    folder.done("unfold path.fold -o again.fold");
    assert_eq!(folder.read_json("again.fold")["frame_unit"], "mm");
    let refused = folder.run("unfold path.fold --unit in -o again.fold");
    let text = "the unit of lengths: expected no unit, or in, found mm";
    assert!(refused.with_status(2).stderr.contains(text));
}
