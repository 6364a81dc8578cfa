//! Tests crease patterns that are drawings: SVG files with Origami Simulator's colours, and CP files.

use std::collections::BTreeSet;
use std::path::PathBuf;

use crate::common::folder;
use foldpath::pattern::{CreasePattern, Letter};
use foldpath::read::read_pattern;
use foldpath_test_support::{Random, numbers};
use serde_json::{Value, json};

/// Returns an SVG drawing of 10 by 10 with these elements.
fn svg(elements: &str) -> String {
    format!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 10 10\">\n{elements}</svg>")
}

/// Returns an SVG drawing of a square sheet with a crease from top to bottom that has these attributes.
fn creased(attributes: &str) -> String {
    svg(&format!(
        "<rect x=\"0\" y=\"0\" width=\"4\" height=\"4\" fill=\"none\" stroke=\"#000\"/>\n\
         <line x1=\"2\" y1=\"0\" x2=\"2\" y2=\"4\" {attributes}/>"
    ))
}

/// Returns a CP file with the border of a square from 0 to 4, and these lines.
fn cp(lines: &str) -> String {
    format!("1 0 0 4 0\n1 4 0 4 4\n1 4 4 0 4\n1 0 4 0 0\n{lines}")
}

fn read(name: &str, text: &str) -> CreasePattern {
    let folder = folder();
    folder.write(name, text);
    let file = read_pattern(&folder.path(name)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(file.title, name.split('.').next().unwrap());
    file.pattern
}

/// Returns the numbers of vertices, edges and faces.
fn counts(pattern: &CreasePattern) -> [usize; 3] {
    [
        pattern.vertices().len(),
        pattern.edges().len(),
        pattern.faces().len(),
    ]
}

/// Returns the letters and goal angles (degrees) of the edges between two faces.
fn inner(pattern: &CreasePattern) -> Vec<(char, Option<f64>)> {
    let edges = pattern.edges().iter();
    let inner = edges.filter(|edge| edge.inner_faces().is_some());
    inner
        .map(|edge| (edge.letter.code(), edge.goal.map(f64::to_degrees)))
        .collect()
}

#[test]
fn colours_are_letters() {
    for (colour, code, note) in [
        ("#f00", 'M', ""),
        ("red", 'M', ""),
        ("rgb(0, 0, 255)", 'V', ""),
        ("#FFFF00", 'F', ""),
        ("magenta", 'U', ""),
        (
            "#ED1C24",
            'M',
            "#ed1c24 taken as red (M), the nearest hue: 1",
        ),
        (
            "#0000FE",
            'V',
            "#0000fe taken as blue (V), the nearest hue: 1",
        ),
        (
            "#2E3192",
            'V',
            "#2e3192 taken as blue (V), the nearest hue: 1",
        ),
        (
            "#FFF200",
            'F',
            "#fff200 taken as yellow (F), the nearest hue: 1",
        ),
        (
            "#EC008C",
            'U',
            "#ec008c taken as magenta (U), the nearest hue: 1",
        ),
        (
            "cyan",
            'U',
            "#00ffff, which is none of red, blue, black, green, yellow and magenta, taken as U: 1",
        ),
        (
            "#808080",
            'U',
            "#808080, which is none of red, blue, black, green, yellow and magenta, taken as U: 1",
        ),
    ] {
        let pattern = read("colour.svg", &creased(&format!("stroke=\"{colour}\"")));
        assert_eq!(inner(&pattern), [(code, None)], "{colour}");
        let notes: Vec<String> = match note {
            "" => vec![],
            note => vec![format!("lines of colour {note}")],
        };
        assert_eq!(pattern.assumptions(), notes, "{colour}");
    }
}

#[test]
fn black_and_green_part_the_sheet() {
    for colour in ["black", "#231F20", "lime", "#00A651"] {
        let pattern = read("cut.svg", &creased(&format!("stroke=\"{colour}\"")));
        assert_eq!(
            (pattern.sheets(), pattern.creases().len()),
            (2, 0),
            "{colour}"
        );
        let said = pattern
            .assumptions()
            .iter()
            .any(|note| note.contains("green"));
        assert_eq!(said, !["black", "#231F20"].contains(&colour), "{colour}");
    }
}

#[test]
fn styles_and_transforms_are_resolved() {
    let plain = read("plain.svg", &creased("stroke=\"red\""));
    let styled = svg(
        "<style>.m { stroke: #f00 } .b { stroke: #000; fill: none }</style>\n\
         <g transform=\"translate(-4 0) scale(2)\"><path class=\"b\" d=\"M2 0h2v2h-2z\"/>\n\
         <polyline transform=\"rotate(90 3 1)\" class=\"m\" points=\"2,1 4,1\"/></g>",
    );
    let styled = read("styled.svg", &styled);
    assert_eq!(counts(&styled), counts(&plain));
    assert_eq!(inner(&styled), inner(&plain));
    for (a, b) in styled.vertices().iter().zip(plain.vertices()) {
        assert!((a - b).norm() < 1e-5, "{a} {b}");
    }
}

/// One square with one crease in many elements of SVG, and the notes about them.
#[test]
fn svg_in_other_words_is_the_same_drawing() {
    let plain = read("plain.svg", &creased("stroke=\"red\""));
    let border = "<path d=\"M0,0 4,0V4H0z\" stroke=\"rgb(0%,0%,0%)\" fill=\"none\"/>";
    let crease = "<path d=\"M2 0v4\" stroke=\"red\"/>";
    let curve = "<path d=\"M2 0c0 1 0 3 0 4\" stroke=\"red\"/>";
    let straightened = "curves that run straight taken as lines: 1";
    let left_out = "text, images and markers left out: 2";
    let clipped = "clip paths and masks not applied: what they hide counts: 1";
    for (elements, notes) in [
        (format!("{border}{crease}"), vec![]),
        (format!("{border}{curve}"), vec![straightened]),
        (
            format!("{border}<path d=\"M2 4Q2 2 2 0\" stroke=\"hsl(0,100%,50%)\"/>"),
            vec![straightened],
        ),
        // A symbol, nested uses and groups, and attributes that are inherited.
        (
            format!(
                "<defs><symbol id=\"s\" overflow=\"visible\"><line id=\"l\" y2=\"4\"/></symbol></defs>{border}\
                 <g stroke=\"red\"><g transform=\"matrix(1 0 0 1 1 0)\"><use href=\"#s\" x=\"1\"/></g></g>"
            ),
            vec![],
        ),
        // Rules of style sheets, by class, id, child and importance.
        (
            "<style>/* a comment, long */ .b,#b{stroke:black;fill:none} g > .m{stroke:#F00!important} \
             line{stroke:blue}</style><rect id=\"b\" width=\"4\" height=\"4\"/>\
             <g><line class=\"x m\" x1=\"2\" x2=\"2\" y2=\"4\" style=\"stroke:lime\"/></g>"
                .into(),
            vec![],
        ),
        // An inner `svg` element with a view of its own and relative units.
        (
            format!("<svg viewBox=\"0 0 10 10\" width=\"100%\" height=\"10px\">{border}{crease}</svg>"),
            vec![],
        ),
        // An ellipse that is only filled, text, a clip path that hides the crease, and elements that are not shown.
        (
            format!(
                "{border}<clipPath id=\"k\"><rect width=\"1\" height=\"1\"/></clipPath><g clip-path=\"url(#k)\">\
                 {crease}</g><ellipse rx=\"1\" ry=\"2\"/><text y=\"1\">7</text><image href=\"a.png\"/>\
                 <g display=\"none\"><path d=\"M0 1h4\" stroke=\"red\"/></g>\
                 <path d=\"M0 1h4\" stroke=\"red\" stroke-width=\"0\"/>"
            ),
            vec![left_out, clipped, "hidden shapes left out: 1"],
        ),
        // Arrows that mark the ends of a line and are no lines of the sheet.
        (
            format!(
                "<marker id=\"a\"><path d=\"M0 0h1\" stroke=\"red\"/></marker>{border}\
                 <path d=\"M2 0v4\" stroke=\"red\" marker-end=\"url(#a)\"/><text/>"
            ),
            vec![left_out],
        ),
    ] {
        let found = read("other.svg", &svg(&elements));
        assert_eq!(counts(&found), counts(&plain), "{elements}");
        assert_eq!(inner(&found), inner(&plain), "{elements}");
        assert_eq!(found.assumptions(), notes, "{elements}");
        for (a, b) in found.vertices().iter().zip(plain.vertices()) {
            assert!((a - b).norm() < 1e-5, "{elements}: {a} {b}");
        }
    }
    let bent = svg(&format!(
        "{border}<path d=\"M2 0c0.001 1 0 3 0 4\" stroke=\"red\"/>"
    ));
    let folder = folder();
    folder.write("bent.svg", &bent);
    let refused = folder.run("info bent.svg").with_status(2).stderr;
    assert!(
        refused.contains(
            "expected a straight crease, as rigid panels turn about a line, found a curve 4.0"
        ),
        "{refused}"
    );
}

/// The sheet is folded as the screen shows it: up stays up, so that y, which runs down in drawings, is negated.
#[test]
fn y_is_turned_round() {
    let svg = read("up.svg", &creased("stroke=\"red\""));
    let cp = read("up.cp", &cp("2 2 0 2 4\n"));
    for pattern in [svg, cp] {
        let low = pattern.vertices().iter().map(|v| v.y).fold(0.0, f64::min);
        let high = pattern.vertices().iter().map(|v| v.y).fold(-9.0, f64::max);
        assert!(
            (low + 4.0).abs() < 1e-12 && high.abs() < 1e-12,
            "{low} {high}"
        );
    }
}

/// Far from the origin, single precision leaves few digits. The tolerance grows with the digits that are lost.
#[test]
fn drawings_far_from_the_origin_are_read() {
    let far = |x: f64, y: f64| format!("{},{}", 1e6 + x, 2e6 + y);
    let square = [
        far(0.0, 0.0),
        far(100.0, 0.0),
        far(100.0, 100.3),
        far(0.3, 100.3),
    ]
    .join(" ");
    let crease = [far(50.1, 0.0), far(50.1, 100.3)].join(" ");
    let shapes = format!(
        "<g transform=\"translate(-1e6 -2e6)\"><polygon stroke=\"#000\" points=\"{square}\"/>\
         <polyline stroke=\"red\" points=\"{crease}\"/></g>"
    );
    let pattern = read("far.svg", &svg(&shapes));
    assert_eq!(counts(&pattern), [6, 7, 2], "{:?}", pattern.repairs());
}

#[test]
fn opacity_is_the_goal_angle() {
    for (attributes, goal) in [
        ("stroke=\"red\" opacity=\"0.5\"", ('M', Some(-90.0))),
        ("stroke=\"blue\" stroke-opacity=\"0.3\"", ('V', Some(54.0))),
        (
            "style=\"stroke:blue;opacity:.5;stroke-opacity:.5\"",
            ('V', Some(45.0)),
        ),
        ("stroke=\"red\" opacity=\"1\"", ('M', None)),
        ("stroke=\"magenta\" opacity=\"0.5\"", ('U', None)),
    ] {
        let pattern = read("opacity.svg", &creased(attributes));
        let [(letter, angle)] = inner(&pattern)[..] else {
            panic!("{attributes}");
        };
        assert_eq!(
            (letter, angle.is_some()),
            (goal.0, goal.1.is_some()),
            "{attributes}"
        );
        let error = angle.unwrap_or(0.0) - goal.1.unwrap_or(0.0);
        assert!(error.abs() < 1e-9, "{attributes}: {angle:?}");
        let said = pattern
            .assumptions()
            .iter()
            .any(|note| note.contains("opacity"));
        assert_eq!(said, goal.1.is_some(), "{attributes}");
    }
}

#[test]
fn fills_say_nothing_and_hidden_shapes_are_told() {
    let shapes = "stroke=\"red\"/>\n<circle r=\"3\" fill=\"blue\"/>\n\
         <line x1=\"0\" y1=\"2\" x2=\"4\" y2=\"2\" stroke=\"blue\" display=\"none\"/>\n\
         <line x1=\"0\" y1=\"3\" x2=\"4\" y2=\"3\" stroke=\"blue\" visibility=\"hidden\"";
    let pattern = read("fills.svg", &creased(shapes));
    assert_eq!(counts(&pattern), [6, 7, 2]);
    assert_eq!(pattern.assumptions(), ["hidden shapes left out: 2"]);
}

/// Layers are hidden in all the ways that SVG has; the elements that hide them are named.
#[test]
fn hidden_layers_are_told_by_name() {
    let layer = |hides: &str| {
        format!(
            "stroke=\"red\"/>\n<g id=\"folds\" {hides}><line x1=\"0\" y1=\"3\" x2=\"4\" y2=\"3\" \
             stroke=\"blue\"/></g>\n<style>.gone {{ display: none }}</style><line y2=\"0\" stroke=\"none\""
        )
    };
    for (hides, told) in [
        ("display=\"none\"", "hidden shapes left out: 1, in folds"),
        (
            "style=\"display : none\"",
            "hidden shapes left out: 1, in folds",
        ),
        (
            "visibility=\"hidden\"",
            "hidden shapes left out: 1, in folds",
        ),
        ("class=\"gone\"", "hidden shapes left out: 1"),
    ] {
        let pattern = read("hidden.svg", &creased(&layer(hides)));
        assert_eq!(counts(&pattern), [6, 7, 2], "{hides}");
        assert_eq!(pattern.assumptions(), [told], "{hides}");
    }
    let shown = read("shown.svg", &creased(&layer("")));
    assert!(shown.assumptions().is_empty());
}

/// A cut that ends inside a panel parts nothing: it is told, and is no line that ends in the open. A border that does not
/// meet its corner is one.
#[test]
fn slits_inside_a_panel_are_told() {
    let slit = "cuts that end inside a panel, and part nothing, left out:";
    let slits = [
        (
            "slit.svg",
            creased("stroke=\"red\"/><line x1=\"3\" y1=\"1\" x2=\"3\" y2=\"3\" stroke=\"#0f0\""),
            1,
        ),
        (
            "bent.svg",
            creased("stroke=\"red\"/><path d=\"M3 1v2h0.5\" stroke=\"#000\""),
            2,
        ),
        (
            "notch.svg",
            creased("stroke=\"red\"/><path d=\"M4 2h-1\" stroke=\"#0f0\""),
            1,
        ),
        ("slit.cp", cp("2 2 0 2 4\n1 3 1 3 3\n"), 1),
    ];
    for (name, text, count) in slits {
        let pattern = read(name, &text);
        let repairs = pattern.repairs();
        let told = format!("{slit} {count}, ");
        assert!(
            repairs.iter().any(|repair| repair.starts_with(&told)),
            "{name}: {repairs:?}"
        );
        assert!(pattern.lost_lines().is_none(), "{name}");
    }
    let crease = read("crease.cp", &cp("2 2 0 2 4\n3 3 1 3 3\n"));
    assert_eq!(crease.lost_lines().map(|lost| lost.count), Some(1));
    let border = read("border.cp", &cp("2 2 0 2 4\n1 4 2 3 2\n"));
    assert_eq!(border.lost_lines().map(|lost| lost.count), Some(1));
}

/// The alpha of a colour is the goal angle with all its digits, in all the ways that CSS writes it.
#[test]
fn alpha_counts_as_it_is_written() {
    let mut rng = Random::new(81);
    for _ in 0..60 {
        let alpha = (rng.uniform(0.01, 0.99) * 1e4).round() / 1e4;
        for (colour, goal) in [
            (format!("stroke=\"rgba(255,0,0,{alpha})\""), -alpha),
            (
                format!("style=\"stroke: rgba( 100%, 0%, 0%, {alpha} )\""),
                -alpha,
            ),
            (format!("stroke=\"RGB(0 0 255 / {alpha})\""), alpha),
            (
                format!("stroke=\"hsla(240, 100%, 50%, {alpha})\" stroke-opacity=\"0.5\""),
                alpha / 2.0,
            ),
        ] {
            let pattern = read("alpha.svg", &creased(&colour));
            let [(_, Some(angle))] = inner(&pattern)[..] else {
                panic!("{colour}");
            };
            assert!((angle / 180.0 - goal).abs() < 1e-9, "{colour}: {angle}");
        }
    }
}

/// CP files as other programs write them: with comments, empty lines, line ends of two bytes, exponents, commas in
/// place of decimal points, and types that are no crease.
#[test]
fn cp_files_of_all_kinds_are_read() {
    let plain = cp("3 2 0 2 4\n");
    let odd = "# a comment\r\n\r\n 1 0 0 4 0\r\n1\t4 0\t4 4 \r\n1 4e0 4,0 0 +4\r\n1 0 4 0 -0.0\r\n\
               3 2 1e-16 2 4\r\n0 0 0 4 4\r\n4 0 1 4 1\r\n5 0 1 4 1\r\n5 0 2 4 2";
    let (plain, odd) = (read("plain.cp", &plain), read("odd.cp", odd));
    assert_eq!(counts(&odd), counts(&plain));
    assert_eq!(inner(&odd), inner(&plain));
    assert_eq!(
        odd.assumptions(),
        [
            "lines of no type (type 0) left out: 1",
            "auxiliary lines (type 4) left out: 1",
            "lines of type 5, taken as auxiliary, left out: 2",
            "numbers with a comma for the point: 1",
        ]
    );
}

#[test]
fn auxiliary_lines_are_left_out() {
    let pattern = read("aux.cp", &cp("\n3 2 0 2 4\n4 0 2 4 2\n"));
    assert_eq!(counts(&pattern), [6, 7, 2]);
    assert_eq!(inner(&pattern), [('V', None)]);
    let note = "auxiliary lines (type 4) left out: 1";
    assert_eq!(pattern.assumptions(), [note]);
}

/// Each rule of repair, and its note.
#[test]
fn loose_lines_are_repaired_and_said() {
    let passes = |places: usize| {
        format!(
            "lines that pass a vertex within the tolerance 5.657e-4 split there: {places} places"
        )
    };
    let crossed = "crossings without a vertex, both lines split there: 1".to_string();
    let twice = |count: usize| {
        format!(
            "lines that lie on another left out: {count} (kept is a cut before M or V, before U, before a \
             border, before F)"
        )
    };
    let open =
        |rest: &str| format!("lines that end in the open, without faces between, left out: {rest}");
    let joined = "ends of lines within the tolerance 5.657e-4 of each other joined: ";
    for (lines, expected, repairs) in [
        // A crossing, and ends on the border.
        (
            "2 2 0 2 4\n3 0 2 4 2",
            [9, 12, 4],
            vec![crossed.clone(), passes(4)],
        ),
        // Ends a little beside the border, and ends a little beside each other.
        (
            "2 2 0.0003 2 2\n2 2.0003 2 2 3.9997\n3 0 2 4 2",
            [9, 12, 4],
            vec![format!("{joined}2, moved by 1.5e-4 at most"), passes(5)],
        ),
        // A line drawn twice, and a line that overlaps another.
        ("2 2 0 2 4\n2 2 4 2 0", [6, 7, 2], vec![passes(2), twice(1)]),
        ("2 2 0 2 3\n2 2 1 2 4", [8, 9, 2], vec![passes(4), twice(1)]),
        // Mountain and valley at one place.
        (
            "3 2 0 2 4\n2 2 0 2 4",
            [6, 7, 2],
            vec![
                passes(2),
                twice(1),
                "of them lettered M and V at one place, the first drawn kept: 1".into(),
            ],
        ),
        // A line without length, and lines that end in the open.
        (
            "2 2 0 2 4\n2 1 1 1 1",
            [6, 7, 2],
            vec![
                "lines shorter than the tolerance 5.657e-4 left out: 1".into(),
                passes(2),
            ],
        ),
        (
            "2 2 0 2 4\n3 3 1 3 2\n3 3 2 3.5 2",
            [6, 7, 2],
            vec![
                passes(2),
                open(
                    "2, up to 1.0e0 long, the first open end at (3, 1); no tolerance was found that keeps all lines",
                ),
            ],
        ),
        // A triangle inside a panel: a flap that three lines hold. The panel round it is three faces.
        (
            "2 2 0 2 4\n2 0.5 1 1.5 1\n1 1.5 1 1.5 3\n3 1.5 3 0.5 1",
            [9, 13, 5],
            vec![passes(2)],
        ),
        // A line that goes past the border.
        (
            "2 2 -0.05 2 4",
            [6, 7, 2],
            vec![
                crossed,
                passes(1).replace("5.657e-4", "5.692e-4"),
                open(
                    "1, up to 5.0e-2 long, the first open end at (2, -0.05); a tolerance of 0.051 keeps all lines",
                ),
            ],
        ),
        // A line that ends just short of the corner.
        (
            "2 0 0 3.992 3.99",
            [4, 5, 2],
            vec!["open ends joined to the one vertex near them: 1, moved by 1.3e-2 at most".into()],
        ),
    ] {
        let pattern = read("loose.cp", &cp(lines));
        assert_eq!(counts(&pattern), expected, "{lines}");
        assert_eq!(pattern.repairs(), repairs, "{lines}");
    }
    // The command reports the repairs.
    let folder = folder();
    folder.write("cross.CP", &cp("2 2 0 2 4\n3 0 2 4 2"));
    let info = folder.done("info cross.CP --json").json();
    assert_eq!(info["repairs"].as_array().map(Vec::len), Some(2), "{info}");
    assert_eq!(info["assumptions"], json!([]));
    let plan = folder.run("plan cross.CP");
    assert!(
        plan.stderr.contains("note: crossings without a vertex"),
        "{plan:?}"
    );
    assert_eq!(folder.done("info cross.CP --quiet").stderr, "");
}

/// A crease drawn over a border within the sheet stays a crease. A cut drawn over a crease stays a cut.
#[test]
fn the_letter_that_says_more_is_kept() {
    let line =
        |colour: &str| format!("<line x1=\"2\" y1=\"0\" x2=\"2\" y2=\"4\" stroke=\"{colour}\"/>\n");
    for (colours, letter) in [
        (["black", "red"], Letter::Mountain),
        (["magenta", "blue"], Letter::Valley),
        (["black", "magenta"], Letter::Unassigned),
        (["yellow", "magenta"], Letter::Unassigned),
        (["red", "lime"], Letter::Boundary),
        (["yellow", "black"], Letter::Boundary),
    ] {
        for order in [colours, [colours[1], colours[0]]] {
            let text = creased("stroke=\"none\"");
            let lines = order.map(line).concat();
            let pattern = read("over.svg", &text.replace("</svg>", &(lines + "</svg>")));
            let letters: Vec<Letter> = pattern.edges().iter().map(|edge| edge.letter).collect();
            assert!(letters.contains(&letter), "{order:?}: {letters:?}");
            let parted = letter == Letter::Boundary;
            assert_eq!(pattern.sheets(), if parted { 2 } else { 1 }, "{order:?}");
        }
    }
}

#[test]
fn bad_drawings_are_refused() {
    let two_lines = svg("<path d=\"M0 0h4v4\" stroke=\"red\"/>");
    let curve = svg("<g><path id=\"wing\" d=\"M0 0c1 1 2 2 3 0\" stroke=\"red\"/></g>");
    let apart = cp("1 1 1 3 1\n1 3 1 3 3\n1 3 3 1 1\n2 0 2 1.5 1.5\n");
    for (name, text, message) in [
        (
            "a.svg",
            "",
            "line 1, column 1: expected an SVG drawing, found no XML (*",
        ),
        (
            "a.svg",
            "<svg>\n<g></svg>",
            "line 2, column 4: expected an SVG drawing, found no XML (*",
        ),
        (
            "a.svg",
            "<html>\n</html>",
            "line 1: expected an SVG drawing, found <html>",
        ),
        (
            "a.svg",
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"0\" height=\"9\"/>",
            "line 1: expected an SVG drawing, found *",
        ),
        (
            "a.svg",
            &svg(""),
            "the drawing: expected lines that enclose faces, found 0 lines, none *",
        ),
        (
            "a.svg",
            &two_lines,
            "the drawing: expected lines that enclose faces, found 2 lines, *",
        ),
        (
            "a.svg",
            &curve,
            "stroked shape 1 id=\"wing\", stroke #ff0000: expected a straight crease, as rigid panels turn about a line, \
             found a curve *",
        ),
        (
            "a.cp",
            "",
            "the drawing: expected lines that enclose faces, found 0 lines, none of *",
        ),
        (
            "a.cp",
            "1 0 0 1 0\n2 1 2 3",
            "line 2: expected 5 fields, type x1 y1 x2 y2, found \"2 1 2 3\"",
        ),
        (
            "a.cp",
            "1 0 0 1 x\n",
            "line 1: expected a number, found \"x\"",
        ),
        (
            "a.cp",
            "1 0 0 1 inf\n",
            "line 1: expected a number, found \"inf\"",
        ),
        (
            "a.cp",
            "\nM 0 0 1 1",
            "line 2: expected a type, 1 contour, 2 mountain, 3 valley or 4 auxiliary, found \"M\"",
        ),
        (
            "a.cp",
            "1 0 0 1e51 0",
            "the drawing: expected coordinates from -1e50 to 1e50, found a larger one",
        ),
        (
            "a.cp",
            &apart,
            "the line from (0, 2) to (1.5, 1.5): expected different faces on its sides, found one face all *",
        ),
    ] {
        let folder = folder();
        folder.write(name, text);
        for command in ["info", "plan"] {
            let answer = folder.run(&format!("{command} {name}")).with_status(2);
            let good = match message.strip_suffix('*') {
                Some(start) => answer.begins(&format!("{name}: {start}")),
                None => answer.tells(&format!("{name}: {message}")),
            };
            assert!(good, "{text}\n  expected {message}\n  found    {answer:?}");
        }
    }
    let folder = folder();
    std::fs::write(folder.path("a.cp"), b"1 0 0\xff").unwrap();
    let answer = folder.run("info a.cp").with_status(2);
    let expected = "foldpath: a.cp: byte 5: expected text in UTF-8, found other bytes\n";
    assert_eq!(answer.stderr, expected);
}

/// Two sheets beside each other, one of them in a notch of the other, are both kept.
#[test]
fn sheets_beside_each_other_are_kept() {
    let notched = "1 0 0 4 0\n1 4 0 4 4\n1 4 4 3 4\n1 3 4 3 1\n1 3 1 1 1\n1 1 1 1 4\n1 1 4 0 4\n1 0 4 0 0\n\
         1 1.5 2 2.5 2\n1 2.5 2 2.5 3\n1 2.5 3 1.5 3\n1 1.5 3 1.5 2\n2 1.5 2 2.5 3";
    let pattern = read("notch.cp", notched);
    assert_eq!((pattern.sheets(), counts(&pattern)), (2, [12, 13, 3]));
    assert_eq!(pattern.repairs(), [""; 0]);
}

/// Returns the folder of patterns by other authors. Without one, prints that the test is skipped and returns `None`.
pub(crate) fn external() -> Option<PathBuf> {
    let folder = std::env::var_os("FOLDPATH_EXTERNAL_PATTERNS").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: FOLDPATH_EXTERNAL_PATTERNS is not set");
    }
    folder
}

/// Numbers of vertices, edges and faces of real drawings. Cuts have an edge on each side. In `birdbase.cp` one diagonal
/// is not drawn, which accounts for two edges and two faces of the bird base.
#[test]
fn real_drawings_are_read() {
    let Some(folder) = external() else { return };
    for (name, expected) in [
        ("origami-simulator/birdBase.svg", [13, 28, 16]),
        ("origami-simulator/cubeunwrapping.svg", [14, 19, 6]),
        ("origami-simulator/flappingBird.svg", [24, 47, 24]),
        ("origami-simulator/honeycombKiri.svg", [444, 774, 276]),
        ("origami-simulator/hypar.svg", [97, 284, 188]),
        ("origami-simulator/miura-ori.svg", [182, 337, 156]),
        (
            "origami-simulator/reschTriTessellation.svg",
            [243, 664, 422],
        ),
        ("origami-simulator/simpleVertex.svg", [9, 12, 4]),
        ("origami-simulator/singlesquaretwist.svg", [16, 24, 9]),
        ("origami-simulator/waterbomb.svg", [195, 524, 330]),
        ("oriedita/birdbase.cp", [13, 26, 14]),
    ] {
        let pattern = read_pattern(&folder.join(name)).unwrap().pattern;
        assert_eq!(
            counts(&pattern),
            expected,
            "{name}: {:?}",
            pattern.repairs()
        );
        assert_eq!(pattern.sheets(), 1, "{name}");
    }
}

/// The bird bases of two programs have the same lines, once the diagonal that only one of them has is drawn. Positions
/// are compared in twentieths of the sheet, because one of the programs puts them on a grid.
#[test]
fn both_bird_bases_are_one() {
    let Some(folder) = external() else { return };
    let lines = |pattern: &CreasePattern| {
        let points = pattern.vertices().iter();
        let low = points
            .clone()
            .fold(pattern.vertices()[0], |low, p| low.inf(p));
        let size = points.fold(low, |high, p| high.sup(p)) - low;
        let place = |end: foldpath::pattern::VertexId| {
            let place = 20.0 * (pattern.vertices()[end.index()] - low);
            [place.x / size.x, place.y / size.y].map(|c| format!("{c:.0}"))
        };
        let line = |edge: &foldpath::pattern::Edge| {
            let mut ends = edge.ends.map(place);
            ends.sort();
            (ends, edge.letter)
        };
        pattern.edges().iter().map(line).collect::<BTreeSet<_>>()
    };
    let svg = read_pattern(&folder.join("origami-simulator/birdBase.svg")).unwrap();
    let text = std::fs::read_to_string(folder.join("oriedita/birdbase.cp")).unwrap();
    let drawn = read("bird.cp", &text);
    let full = read("bird.cp", &(text + "\n3 -200 -200 0 0\n3 0 0 200 200\n"));
    assert_eq!(counts(&drawn), [13, 26, 14]);
    assert_eq!([counts(&full), counts(&svg.pattern)], [[13, 28, 16]; 2]);
    assert_eq!(lines(&full).len(), 28);
    assert_eq!(lines(&full), lines(&svg.pattern));
    assert!(lines(&drawn).is_subset(&lines(&full)));
}

/// Every real drawing gets an answer, with a reason if it is not planned. Some of the drawings fold.
#[test]
fn real_drawings_are_planned_or_say_why_not() {
    let Some(drawings) = external() else { return };
    let drawings = ["origami-simulator", "oriedita"].map(|name| drawings.join(name));
    let files = drawings.map(|folder| std::fs::read_dir(folder).unwrap());
    let mut files: Vec<PathBuf> = files
        .into_iter()
        .flatten()
        .map(|file| file.unwrap().path())
        .filter(|file| file.extension().is_some_and(|e| e == "svg" || e == "cp"))
        .collect();
    files.sort();
    let runs = folder();
    for file in files {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let output = runs.path(&name).with_extension("fold");
        let answer = runs
            .command("plan --timeout 10 --json")
            .arg(&file)
            .arg("-o")
            .arg(&output)
            .output()
            .unwrap();
        let plan: Value = serde_json::from_slice(&answer.stdout).unwrap_or_else(|error| {
            panic!(
                "{name}: {error}: {}",
                String::from_utf8_lossy(&answer.stderr)
            )
        });
        let outcome = plan["outcome"].as_str().unwrap();
        println!(
            "{name}: {outcome}, {} of the way in {} s; {}",
            plan["reached"], plan["time"]["total"], plan["reason"]
        );
        let planned = outcome == "planned";
        assert_eq!(
            answer.status.code(),
            Some(i32::from(!planned)),
            "{name}: {plan}"
        );
        assert_eq!(plan["reason"].is_string(), !planned, "{name}: {plan}");
        if ["miura-ori.svg", "cubeunwrapping.svg", "birdbase.cp"].contains(&name.as_str()) {
            assert!(planned, "{name}: {plan}");
        }
        if planned {
            let path = output.file_name().unwrap().to_string_lossy();
            runs.done(&format!("check {path}"));
        }
        if name == "cubeunwrapping.svg" {
            let path = runs.read_json("cubeunwrapping.fold");
            let last = path["file_frames"].as_array().unwrap().last().unwrap();
            let right_angles = numbers(&last["edges_foldAngle"]);
            let right_angles = right_angles.iter().filter(|a| (*a + 90.0).abs() < 1e-12);
            assert_eq!(right_angles.count(), 5);
        }
    }
}
