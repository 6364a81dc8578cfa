//! DXF drawings: lines, polylines with bulges, round things, splines and blocks are read; letters come from layers and
//! colours; what is exported is read back.

use core::f64::consts::{FRAC_PI_8, PI};
use core::fmt::Write as _;

use serde_json::Value;

use crate::common::{PATTERNS, folder};

/// Returns a file with these blocks and entities, in a dialect and a unit ($INSUNITS).
fn file(dialect: &str, unit: u8, blocks: &str, entities: &str) -> String {
    let blocks = match blocks {
        "" => String::new(),
        blocks => format!("0\nSECTION\n2\nBLOCKS\n{blocks}0\nENDSEC\n"),
    };
    format!(
        "999\na comment\n0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\n{dialect}\n9\n$INSUNITS\n70\n{unit}\n0\nENDSEC\n{blocks}\
         0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n"
    )
}

fn entity(kind: &str, layer: &str, pairs: &[(u32, f64)]) -> String {
    let mut text = format!("0\n{kind}\n8\n{layer}\n");
    for (code, value) in pairs {
        // Whole numbers are flags and counts.
        writeln!(text, "{code}\n{value}").unwrap();
    }
    text
}

fn line(layer: &str, [x, y]: [f64; 2], [u, v]: [f64; 2]) -> String {
    entity("LINE", layer, &[(10, x), (20, y), (11, u), (21, v)])
}

/// Returns a closed polyline through places with bulges.
fn polyline(layer: &str, vertices: &[[f64; 3]]) -> String {
    let mut pairs = vec![(90, vertices.len() as f64), (70, 1.0)];
    for [x, y, bulge] in vertices {
        pairs.extend([(10, *x), (20, *y), (42, *bulge)]);
    }
    entity("LWPOLYLINE", layer, &pairs)
}

/// Returns the polyline as old versions have it, with an entity for each vertex.
fn old_polyline(layer: &str, vertices: &[[f64; 3]]) -> String {
    let mut text = entity("POLYLINE", layer, &[(66, 1.0), (70, 1.0)]);
    for [x, y, bulge] in vertices {
        text += &entity("VERTEX", layer, &[(10, *x), (20, *y), (42, *bulge)]);
    }
    text + "0\nSEQEND\n"
}

/// A sheet 100 by 60 with corners of radius 5.
fn rounded_sheet() -> Vec<[f64; 3]> {
    let bulge = (PI / 8.0).tan();
    let (w, h, r) = (100.0, 60.0, 5.0);
    vec![
        [r, 0.0, 0.0],
        [w - r, 0.0, bulge],
        [w, r, 0.0],
        [w, h - r, bulge],
        [w - r, h, 0.0],
        [r, h, bulge],
        [0.0, h - r, 0.0],
        [0.0, r, bulge],
    ]
}

/// Returns what `info` says of a file.
fn info(text: &str, options: &str) -> Value {
    let folder = folder();
    folder.write("a.dxf", text);
    folder.done(&format!("info a.dxf --json {options}")).json()
}

fn refused(text: &str, options: &str) -> String {
    let folder = folder();
    folder.write("a.dxf", text);
    let answer = folder.run(&format!("info a.dxf {options}"));
    answer.with_status(2).stderr
}

/// The area of all faces of what is read, from the pattern drawn as FOLD.
fn area(text: &str) -> f64 {
    let folder = folder();
    folder.write("a.dxf", text);
    folder.done("plan a.dxf --fold 0.5 -o path.fold");
    let path = folder.read_json("path.fold");
    let places: Vec<[f64; 2]> = path["vertices_coords"]
        .as_array()
        .unwrap()
        .iter()
        .map(|at| [at[0].as_f64().unwrap(), at[1].as_f64().unwrap()])
        .collect();
    let faces = path["faces_vertices"].as_array().unwrap();
    let of_face = |face: &Value| -> f64 {
        let corners: Vec<usize> = serde_json::from_value(face.clone()).unwrap();
        let next = corners.iter().cycle().skip(1);
        let cross = corners
            .iter()
            .zip(next)
            .map(|(&a, &b)| places[a][0] * places[b][1] - places[a][1] * places[b][0]);
        cross.sum::<f64>() / 2.0
    };
    faces.iter().map(of_face).sum()
}

#[test]
fn dialects_units_and_blocks_are_read() {
    let sheet = rounded_sheet();
    for (dialect, unit, name) in [
        ("AC1009", 4, "mm"),
        ("AC1015", 1, "in"),
        ("AC1032", 4, "mm"),
        ("AC1032", 1, "in"),
    ] {
        for outline in [polyline("CUT", &sheet), old_polyline("CUT", &sheet)] {
            let entities = outline + &line("CREASE", [40.0, 0.0], [40.0, 60.0]);
            let text = file(dialect, unit, "", &entities);
            let read = info(&text, "");
            assert_eq!(read["creases"], 1, "{read}");
            assert_eq!(read["faces"], 2, "{read}");
            let folder = folder();
            folder.write("a.dxf", &text);
            let told = folder.done("info a.dxf").stdout;
            assert!(told.contains(&format!("lengths in {name}")), "{told}");
            // The chords of the corners are within 0.06.
            let exact = 100.0 * 60.0 - (4.0 - PI) * 25.0;
            assert!((area(&text) - exact).abs() < 1.2, "{}", area(&text));
        }
    }
}

/// A block in a block, turned, mirrored and scaled, is the sheet that it holds.
#[test]
fn blocks_are_placed() {
    let outline = polyline("CUT", &rounded_sheet());
    let sheet = outline + &line("CREASE", [40.0, 0.0], [40.0, 60.0]);
    let block = format!("0\nBLOCK\n8\n0\n2\nSHEET\n10\n7\n20\n9\n{sheet}0\nENDBLK\n");
    let inner = "0\nINSERT\n8\n0\n2\nSHEET\n10\n3\n20\n4\n41\n-2\n42\n2\n43\n1\n50\n30\n";
    let outer = format!("0\nBLOCK\n8\n0\n2\nOUTER\n10\n0\n20\n0\n{inner}0\nENDBLK\n");
    let placed = "0\nINSERT\n8\n0\n2\nouter\n10\n-50\n20\n8\n50\n77\n230\n-1\n";
    let text = file("AC1015", 4, &(block.clone() + &outer), placed);
    let read = info(&text, "");
    assert_eq!(
        (&read["faces"], &read["creases"]),
        (&2.into(), &1.into()),
        "{read}"
    );
    let exact = 4.0 * (100.0 * 60.0 - (4.0 - PI) * 25.0);
    // The chords of the corners are within 0.12.
    assert!((area(&text) - exact).abs() < 5.0, "{}", area(&text));
    // An array is as many sheets as it has cells.
    let array = "0\nINSERT\n8\n0\n2\nSHEET\n10\n0\n20\n0\n70\n3\n71\n1\n44\n200\n45\n0\n";
    let read = info(&file("AC1015", 4, &block, array), "");
    assert_eq!(
        read["parts"].as_array().map(Vec::len).unwrap_or(3),
        3,
        "{read}"
    );
    let own = block.replace(
        "0\nENDBLK",
        "0\nINSERT\n8\n0\n2\nSHEET\n10\n0\n20\n0\n0\nENDBLK",
    );
    let said = refused(&file("AC1015", 4, &own, array), "");
    assert!(
        said.contains("at most 32 levels of blocks in blocks"),
        "{said}"
    );
    let missing = "0\nINSERT\n8\n0\n2\nNOWHERE\n10\n0\n20\n0\n";
    let said = refused(&file("AC1015", 4, &block, missing), "");
    assert!(
        said.contains("INSERT of NOWHERE") && said.contains("no block of this name"),
        "{said}"
    );
}

/// Windows: a circle, an ellipse, arcs seen from below, and splines of degree three and with weights.
#[test]
fn round_things_have_their_areas() {
    let sheet = polyline(
        "OUTLINE",
        &[
            [0.0, 0.0, 0.0],
            [200.0, 0.0, 0.0],
            [200.0, 100.0, 0.0],
            [0.0, 100.0, 0.0],
        ],
    ) + &line("FOLD-VALLEY", [100.0, 0.0], [100.0, 100.0]);
    let circle = entity("CIRCLE", "HOLES", &[(10, 30.0), (20, 30.0), (40, 10.0)]);
    let turn = 2.0 * PI;
    let ellipse = entity(
        "ELLIPSE",
        "HOLES",
        &[
            (10, 60.0),
            (20, 70.0),
            (11, 0.0),
            (21, 20.0),
            (40, 0.5),
            (41, 0.0),
            (42, turn),
        ],
    );
    // From below x points the other way.
    let half = entity(
        "ARC",
        "HOLES",
        &[
            (10, -150.0),
            (20, 30.0),
            (40, 20.0),
            (50, 0.0),
            (51, 180.0),
            (230, -1.0),
        ],
    ) + &line("HOLES", [130.0, 30.0], [170.0, 30.0]);
    // A quarter of a circle with a weight, and a straight spline with more control points.
    let weighted = |knots: &[f64], degree: f64, points: &[[f64; 3]]| {
        let mut pairs = vec![
            (71, degree),
            (72, knots.len() as f64),
            (73, points.len() as f64),
        ];
        pairs.extend(knots.iter().map(|knot| (40, *knot)));
        pairs.extend(points.iter().map(|point| (41, point[2])));
        for [x, y, _] in points {
            pairs.extend([(10, *x), (20, *y), (30, 0.0)]);
        }
        entity("SPLINE", "HOLES", &pairs)
    };
    let quarter = weighted(
        &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
        2.0,
        &[
            [160.0, 60.0, 1.0],
            [160.0, 80.0, 0.5_f64.sqrt()],
            [140.0, 80.0, 1.0],
        ],
    ) + &line("HOLES", [140.0, 80.0], [140.0, 60.0])
        + &line("HOLES", [140.0, 60.0], [160.0, 60.0]);
    // A parabola as a cubic: area 2/3 of its base times its height.
    let cubic = weighted(
        &[0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
        3.0,
        &[
            [20.0, 60.0, 1.0],
            [26.0, 72.0, 1.0],
            [32.0, 72.0, 1.0],
            [38.0, 60.0, 1.0],
        ],
    ) + &line("HOLES", [38.0, 60.0], [20.0, 60.0]);
    for (what, window, exact) in [
        ("circle", circle, PI * 100.0),
        ("ellipse", ellipse, PI * 200.0),
        ("half", half, PI * 200.0),
        ("quarter", quarter, PI * 100.0),
        ("cubic", cubic, 2.0 / 3.0 * 18.0 * 9.0),
    ] {
        let text = file("AC1032", 4, "", &(sheet.clone() + &window));
        let hole = 200.0 * 100.0 - area(&text);
        assert!(
            (hole - exact).abs() < 0.02 * exact,
            "{what}: {hole} {exact}"
        );
    }
}

#[test]
fn letters_come_from_options_names_and_colours() {
    let bulge = FRAC_PI_8.tan();
    let sheet = polyline(
        "Outer Contour",
        &[
            [0.0, 0.0, 0.0],
            [90.0, 0.0, 0.0],
            [90.0, 60.0, 0.0],
            [0.0, 60.0, 0.0],
        ],
    );
    let creases = |layers: [&str; 2]| {
        line(layers[0], [30.0, 0.0], [30.0, 60.0]) + &line(layers[1], [60.0, 0.0], [60.0, 60.0])
    };
    let letters = |text: &str, options: &str| {
        let folder = folder();
        folder.write("a.dxf", text);
        folder.done(&format!("export a.dxf --to svg -o a.svg {options}"));
        let svg = folder.read("a.svg");
        ["#ff0000", "#0000ff", "#ffff00", "#ff00ff"].map(|colour| svg.contains(colour))
    };
    let of = |layers| file("AC1015", 4, "", &(sheet.clone() + &creases(layers)));
    assert_eq!(
        letters(&of(["Mountain folds", "v"]), ""),
        [true, true, false, false]
    );
    assert_eq!(
        letters(&of(["CREASE", "score"]), ""),
        [false, true, false, false]
    );
    assert_eq!(
        letters(&of(["A", "B"]), "--layers a=M,B=F"),
        [true, false, true, false]
    );
    // Colours count where names say nothing, and before names where they are given letters.
    let red = creases(["A", "B"])
        .replace("8\nA\n", "8\nA\n62\n1\n")
        .replace("8\nB\n", "8\nB\n62\n170\n");
    let red = file("AC1015", 4, "", &(sheet.clone() + &red));
    assert_eq!(letters(&red, ""), [true, true, false, false]);
    assert_eq!(letters(&red, "--colors red=U"), [false, true, false, true]);
    let read = info(&of(["CREASE", "DIM"]), "--layers nowhere=V");
    let said = read["assumptions"].to_string();
    for note in [
        "lines of layer CREASE taken as V, by its name: 1",
        "lines of layer Outer Contour taken as B, by its name: 4",
        "lines on layers of notes left out: 1",
        "the layer nowhere was given the letter V, but no line is on it",
    ] {
        assert!(said.contains(note), "{note}: {said}");
    }
    let curved = sheet.clone()
        + &polyline("CREASE", &[[30.0, 0.0, bulge], [30.0, 60.0, 0.0]])
            .replace("70\n1\n", "70\n0\n");
    let said = refused(&file("AC1015", 4, "", &curved), "");
    assert!(
        said.contains("entity 2 (LWPOLYLINE), layer CREASE: expected a straight crease"),
        "{said}"
    );
    let said = refused(&of(["A", "B"]), "--layers A=X");
    assert!(
        said.contains("a letter, one of B, M, V, F, U, C and J"),
        "{said}"
    );
}

#[test]
fn what_is_no_flat_drawing_is_refused_with_its_place() {
    let square = polyline(
        "CUT",
        &[
            [0.0, 0.0, 0.0],
            [9.0, 0.0, 0.0],
            [9.0, 9.0, 0.0],
            [0.0, 9.0, 0.0],
        ],
    );
    let good = file(
        "AC1015",
        4,
        "",
        &(square.clone() + &line("V", [0.0, 4.0], [9.0, 4.0])),
    );
    let high = line("V", [0.0, 4.0], [9.0, 4.0]).replace("20\n4\n11", "20\n4\n30\n1\n11");
    let tilted = entity(
        "CIRCLE",
        "CUT",
        &[(10, 4.0), (20, 4.0), (40, 1.0), (210, 1.0), (230, 0.0)],
    );
    let number = good.replace("10\n9\n", "10\nnine\n");
    for (text, words) in [
        (good.replace("0\nEOF\n", ""), "EOF, after the last section"),
        (number, "a DXF drawing"),
        (
            file("AC1015", 4, "", &(square.clone() + &high)),
            "lines at heights from 0 to 1",
        ),
        (
            file("AC1015", 4, "", &(square.clone() + &tilted)),
            "the normal (1, 0, 0)",
        ),
        ("AutoCAD DXB 1.0\r\n".into(), "a DXB file"),
        (file("AC1015", 4, "", ""), "lines that enclose faces"),
    ] {
        let said = refused(&text, "");
        assert!(said.contains(words), "{words}: {said}");
    }
    let said = {
        let folder = folder();
        folder.write("a.cp", "1 0 0 1 1\n");
        folder.run("info a.cp --layers CUT=B").with_status(2).stderr
    };
    assert!(
        said.contains("letters of layers: expected a DXF drawing"),
        "{said}"
    );
}

/// Every pattern comes back with its verdict, and a drawing that was read back gives the same bytes. From a pipe as well.
#[test]
fn what_is_exported_is_read_back() {
    for pattern in [
        "miura-3x3.fold",
        "waterbomb-4x6.fold",
        "yoshimura-12x12.fold",
        "square-twist-1x1.fold",
    ] {
        let folder = folder();
        let source = format!("{PATTERNS}/{pattern}");
        folder.done(&format!("export {source} --to dxf -o a.dxf"));
        folder.done("export a.dxf --to dxf -o b.dxf");
        assert_eq!(folder.read("a.dxf"), folder.read("b.dxf"), "{pattern}");
        let verdicts = [&*source, "a.dxf"].map(|file| {
            let answer = folder.run(&format!("plan {file} --fold 0.4 --json")).json();
            (answer["outcome"].clone(), answer["creases"].clone())
        });
        assert_eq!(verdicts[0], verdicts[1], "{pattern}");
    }
}
