//! Does the page of `foldpath view` work in a real browser without a network?

use core::time::Duration;
use std::path::Path;
use std::thread::sleep;
use std::time::Instant;

use foldpath::check::check;
use foldpath::collision::{Plates, Trims};
use foldpath::folding::FoldingMap;
use foldpath::generate::{Letters, Miura, SquareTwist};
use foldpath::motion::PlateOptions;
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, EdgeId, Letter, Unit};
use foldpath::planner::{Goal, PlanOptions, PlateRequest, plan};
use foldpath::progress::Watch;
use foldpath::read::fold::PatternFile;
use foldpath::read::parse_pattern;
use foldpath::request::PatternInfo;
use foldpath::sensitivity::{Loads, Tolerance};
use foldpath::view::{Scene, page, pattern_page};
use foldpath_core::Interpolation;
use foldpath_tests::{Animation, Planned, path_file, strict};
use nalgebra::{Matrix3, Vector2, Vector3};
use serde_json::{Value, json};

use crate::chromium::{PATIENCE, SHIFT, View};
use crate::loads::load;

/// Returns the page's data for a planned path, which is written and read again.
fn scene(planned: &Planned) -> Scene {
    Scene::of_path(&path_file(&planned.text()).unwrap())
}

fn planned(name: &str) -> Planned {
    Planned::new(name, &PlanOptions::default())
}

fn miura(size: usize, fold: f64) -> PatternFile {
    let drawing = Miura {
        rows: size,
        columns: size,
        sector_angle: 60_f64.to_radians(),
        fold,
    };
    PatternFile {
        title: format!("Miura {size}x{size}"),
        pattern: CreasePattern::new(drawing.drawing().unwrap()).unwrap(),
    }
}

#[test]
fn sheet_follows_the_slider_the_play_button_and_the_mouse() {
    let scene = scene(&planned("miura-11x11"));
    let view = View::open(&scene, &[]);

    let states = ["0", "0.5", "1"].map(|fold| {
        view.run(&format!(
            "fold.value = {fold}; fold.dispatchEvent(new Event('input'))"
        ));
        assert_eq!(view.run("String(foldpath.position())"), fold);
        (view.drawn(), view.canvas())
    });
    for (a, b) in [(0, 1), (1, 2), (2, 0)] {
        assert_ne!(states[a].0, states[b].0, "drawn() at {a} and {b}");
        assert!(
            states[a].1 != states[b].1,
            "the same picture at {a} and {b}"
        );
    }
    view.run("foldpath.setPosition(0)");
    assert_eq!(
        view.drawn(),
        states[0].0,
        "the same position gives the same pixels"
    );

    view.click("#play");
    view.wait_for("foldpath.position() > 0.02");
    view.key(" "); // pauses
    let paused = view.run("foldpath.position()");
    sleep(Duration::from_millis(200));
    assert_eq!(view.run("foldpath.position()"), paused);

    view.run("foldpath.setPosition(0.5)");
    let before = (view.drawn(), view.canvas());
    view.drag("canvas", (60.0, -20.0));
    assert_ne!(view.drawn(), before.0);
    assert!(view.canvas() != before.1, "dragging left the picture alone");
    view.click("#reset");
    assert_eq!(view.drawn(), before.0);

    if let Some(path) = std::env::var_os("FOLDPATH_SCREENSHOT") {
        std::fs::write(path, view.screenshot()).unwrap();
    }
    view.assert_quiet();
}

#[test]
fn a_page_plays_once_by_itself() {
    let html = page(&scene(&planned("miura-3x3")));
    let view = View::open_page_for("no-preference", &html, &[]);
    view.wait_for("foldpath.position() > 0.01");
    assert_eq!(view.run("foldpath.playing()"), json!(true));
    view.run("foldpath.setPosition(0.99)"); // shortens the wait
    view.wait_for("!foldpath.playing()");
    assert_eq!(view.run("foldpath.position()"), json!(1));
    view.assert_quiet();
}

#[test]
fn keys_turn_the_sheet_and_pick_hinges_where_it_has_the_focus() {
    let scene = scene(&planned("miura-3x3"));
    let view = View::open(&scene, &[]);
    sleep(Duration::from_millis(100));
    assert_eq!(view.run("foldpath.position()"), json!(0), "less motion");
    view.tab_to("document.activeElement === canvas");
    let start = view.run("JSON.stringify(foldpath.camera())");
    for key in ["ArrowLeft", "ArrowUp"] {
        view.key(key);
    }
    assert_ne!(view.run("JSON.stringify(foldpath.camera())"), start);
    assert_eq!(view.run("foldpath.position()"), json!(0));
    let hinges: Vec<usize> = (0..scene.turns.len())
        .filter(|&edge| scene.turns[edge] != 0)
        .collect();
    for (key, expected) in [
        ("n", hinges[0]),
        ("n", hinges[1]),
        ("p", hinges[0]),
        ("p", hinges[hinges.len() - 1]),
    ] {
        view.key(key);
        assert_eq!(view.run("foldpath.view.selected"), json!(expected));
    }
    view.run("element('letters').checked = false");
    view.key("n");
    let last = hinges[hinges.len() - 1];
    assert_eq!(view.run("foldpath.view.selected"), json!(last));
    view.tab_to("document.activeElement === play");
    view.key(" ");
    view.wait_for("foldpath.position() > 0");
    view.assert_quiet();
}

#[test]
fn nothing_on_the_page_lies_over_anything_else_at_any_width() {
    let mut scene = scene(&planned("waterbomb-8x10"));
    scene.title = "A sheet with a long name that has no place beside the figures".into();
    let view = View::open(&scene, &[]);
    view.run("select(scene.turns.findIndex(turn => turn))");
    for (width, height) in [(360, 640), (768, 1024), (1280, 480), (1280, 720)] {
        view.resize(width, height);
        for colours in ["letters", "groups", "deformation"] {
            view.run(&format!("setColours('{colours}')"));
            // Curves are drawn anew once their size is known.
            view.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))).then(() => { window.drawnAt = innerHeight; }); 0");
            view.wait_for("window.drawnAt === innerHeight");
            for selector in [
                "svg text",
                "#above > *, #below > *",
                "h1, h2, dt, dd, figcaption li",
            ] {
                assert_eq!(view.overlaps(selector), json!(""), "{selector} at {width}");
            }
            assert_eq!(
                view.run("document.documentElement.scrollWidth"),
                json!(width)
            );
        }
    }
    view.run("element('lines').style.marginTop = '-20px'");
    assert_eq!(view.overlaps("#below > *"), json!("pair over lines"));
    view.assert_quiet();
}

/// The page folds the sheet itself. Its angles between knots equal the oracle's, its shapes at knots the file's.
#[test]
fn panels_are_where_the_path_has_them() {
    let mut opened: Option<View> = None;
    for interpolation in [
        Interpolation::Linear,
        Interpolation::Hermite,
        Interpolation::HalfAngle,
        Interpolation::Homogeneous,
    ] {
        let options = PlanOptions::default().with(|it| it.interpolation = Some(interpolation));
        let planned = Planned::new("waterbomb-4x6", &options);
        let scene = scene(&planned);
        if let Some(view) = &opened {
            view.show(&scene);
        }
        let view = opened.get_or_insert_with(|| View::open(&scene, &[]));
        let Animation { frames, motion, .. } = Animation::parse(&planned.text()).unwrap();
        view.assert_shapes(frames.iter().map(|frame| (frame.time, &frame.vertices[..])));
        let between = frames.windows(2);
        let times = between.map(|pair| pair[0].time + 0.3 * (pair[1].time - pair[0].time));
        let times: Vec<f64> = times.collect();
        let angles = view.at_times(&times, "foldpath.angles()");
        for (segment, (time, angles)) in times.iter().zip(angles).enumerate() {
            let expected = motion.angles(segment, 0.3);
            assert_eq!(angles.len(), expected.len());
            for (edge, (a, b)) in angles.iter().zip(&expected).enumerate() {
                assert!(
                    (a - b).abs() < 1e-9,
                    "{time}: edge {edge} is at {a}, not {b}"
                );
            }
        }
        assert!(frames.len() > 1, "{interpolation:?}");
        view.assert_quiet();
    }
}

#[test]
fn a_path_of_angles_alone_and_without_groups_folds_as_well() {
    let planned = planned("miura-3x3");
    let mut file: Value = serde_json::from_str(&planned.text()).unwrap();
    let keys = file.as_object_mut().unwrap();
    keys.remove("foldpath:edges_group");
    keys.remove("foldpath:edges_sign");
    for frame in file["file_frames"].as_array_mut().unwrap() {
        frame.as_object_mut().unwrap().remove("vertices_coords");
    }
    let scene = Scene::of_path(&path_file(&file.to_string()).unwrap());
    assert_eq!(scene.motion.groups, 2, "hinges that turn alike");
    let view = View::open(&scene, &[]);
    let animation = Animation::parse(&planned.text()).unwrap();
    let frames = animation.frames.iter();
    view.assert_shapes(frames.map(|frame| (frame.time, &frame.vertices[..])));
    view.assert_quiet();
}

#[test]
fn keys_and_buttons_drive_576_faces() {
    let scene = scene(&planned("miura-24x24"));
    // The faces are rhombi with sides of 1. Faces that share no vertex are separated by a row of faces.
    let clearance = scene.shapes[0].clearance.unwrap();
    assert!((clearance - 60_f64.to_radians().sin()).abs() < 1e-12);

    let view = View::open(&scene, &[]);
    view.key("End");
    assert_eq!(view.run("foldpath.position()"), json!(1));
    for (group, angle) in scene.motion.angles.iter().rev().take(2).rev().enumerate() {
        let text = format!("g{group} {:.1}°", angle.to_degrees());
        let legend = view.text("#angle-legend");
        assert!(legend.contains(&text), "{text} in {legend}");
    }
    view.key("ArrowLeft");
    assert_eq!(view.run("foldpath.position()"), json!(0.99));
    view.key("Home");
    view.key_with("ArrowRight", SHIFT);
    let knots = scene.motion.times.len();
    let readout = view.text("#readout");
    assert!(readout.contains(&format!("2 of {knots}")), "{readout}");

    view.run("foldpath.setPosition(0.5)");
    let colours = ["1", "2", "3", "4"].map(|key| {
        view.key(key);
        (view.drawn(), view.text("#lines"))
    });
    for (a, b) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
        assert_ne!(colours[a].0, colours[b].0, "colours {a} and {b}");
    }
    for (legend, text) in [(1, "g1"), (2, "valley"), (3, "worst: edge")] {
        assert!(colours[legend].1.contains(text), "{}", colours[legend].1);
    }
    let before = view.drawn();
    view.click("#pair input");
    assert_ne!(view.drawn(), before, "the nearest faces stand out");

    view.key("+");
    assert_eq!(view.run("foldpath.camera().zoom"), json!(1.25));
    view.key("-");
    assert_eq!(view.run("foldpath.camera().zoom"), json!(1));
    let start = view.run("JSON.stringify(foldpath.camera())");
    view.drag("canvas", (30.0, 30.0));
    assert_ne!(view.run("JSON.stringify(foldpath.camera())"), start);
    view.key("r");
    assert_eq!(view.run("JSON.stringify(foldpath.camera())"), start);

    view.run("help.returnValue = ''");
    view.key("?");
    assert_eq!(view.run("help.open"), json!(true));
    view.click("#help button");
    assert_eq!(view.run("help.open"), json!(false));

    assert_eq!(
        view.run("document.querySelectorAll('.curve').length"),
        json!(5)
    );
    view.click("#angles"); // its middle is a little before that of the path
    let position = view.run("foldpath.position()").as_f64().unwrap();
    assert!((0.4..0.5).contains(&position), "{position}");

    // The path takes at least four seconds. A tenth of its time at double speed is a fifth of the way.
    let part = 0.1 * view.run("SECONDS").as_f64().unwrap();
    view.run("speed.value = 2");
    for (repeat, from, expected) in [
        ("once", 0.5, [0.7, 1.0]),
        ("once", 0.9, [1.0, 0.0]),
        ("loop", 0.9, [0.1, 1.0]),
        ("back and forth", 0.9, [0.9, -1.0]),
    ] {
        let script = format!(
            "repeat.value = '{repeat}'; JSON.stringify(foldpath.advance({from}, {part}, 1))"
        );
        let found: [f64; 2] = serde_json::from_str(view.run(&script).as_str().unwrap()).unwrap();
        assert!(
            (found[0] - expected[0]).abs() < 1e-12,
            "{repeat}: {found:?}"
        );
        assert!(
            (found[1] - expected[1]).abs() < 1e-12,
            "{repeat}: {found:?}"
        );
    }
    view.assert_quiet();
}

#[test]
fn a_click_picks_the_hinge_there_and_lights_its_group() {
    let scene = scene(&planned("miura-24x24"));
    let view = View::open(&scene, &[]);
    let hinges = || (0..scene.turns.len()).filter(|&edge| scene.turns[edge] != 0);
    let (first, last) = (hinges().next().unwrap(), hinges().next_back().unwrap());
    for edge in [first, hinges().nth(500).unwrap(), last] {
        let plain = view.drawn();
        view.click_edge(edge);
        assert_eq!(view.run("foldpath.view.selected"), json!(edge));
        assert_ne!(view.drawn(), plain);
        let text = view.text("#hinge");
        let letter = scene.letters.chars().nth(edge).unwrap();
        let group = scene.turns[edge].unsigned_abs() - 1;
        let sign = if scene.turns[edge] < 0 {
            "opposite"
        } else {
            "same"
        };
        for part in [
            edge.to_string(),
            format!("{letter}, "),
            format!("g{group}, {sign} sign"),
        ] {
            assert!(text.contains(&part), "{part} in {text}");
        }
        view.key("Escape");
        assert_eq!(view.drawn(), plain);
    }

    // Compares the text on the first hinge of each group at the goal with the scene.
    view.run("foldpath.setPosition(1)");
    let last_row = scene.motion.angles.len() - scene.motion.groups;
    for group in 0..scene.motion.groups {
        let turn = i64::try_from(group).unwrap() + 1;
        let edge = hinges().find(|&edge| scene.turns[edge].abs() == turn);
        let edge = edge.unwrap();
        view.run(&format!("select({edge})"));
        let sign = if scene.turns[edge] < 0 { -1.0 } else { 1.0 };
        let angle = sign * scene.motion.angles[last_row + group].to_degrees();
        let text = view.text("#hinge");
        assert!(text.contains(&format!("{angle:.2}°")), "{angle} in {text}");
        let range = [angle.min(0.0), angle.max(0.0)].map(|a| format!("{:.1}°", a + 0.0));
        assert!(text.contains(&range.join(" to ")), "{range:?} in {text}");
    }

    // There is no hinge beside the sheet.
    view.click_at(5.0, 300.0);
    assert_eq!(view.run("foldpath.view.selected"), json!(-1));
    assert_eq!(view.run("element('hinge').hidden"), json!(true));
    view.assert_quiet();
}

#[test]
fn the_picture_is_saved_as_an_image() {
    let view = View::open(&scene(&planned("miura-3x3")), &[]);
    let folder = tempfile::tempdir().unwrap();
    let to = json!({ "behavior": "allow", "downloadPath": folder.path() });
    view.call("Page.setDownloadBehavior", to);
    view.click("#save");
    let image = folder.path().join("Miura 3x3.png");
    let start = Instant::now();
    while !image.exists() {
        assert!(start.elapsed() < PATIENCE, "no image");
        sleep(Duration::from_millis(20));
    }
    let bytes = std::fs::read(image).unwrap();
    assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 5000);
}

/// Traces rays from the hinges of a tube to the eye. A hinge can be picked exactly if no face is in the way.
#[test]
fn hinges_behind_faces_are_not_picked() {
    let scene = scene(&planned("waterbomb-12x22"));
    let view = View::open(&scene, &[]);
    view.run("foldpath.setPosition(1)");
    let points = view.points("foldpath.vertices()");
    let eye = view.points("foldpath.eye()")[0];
    let at = |v: u32| points[v as usize];
    let (mut seen, mut hidden, mut hinges) = (0, 0, Vec::new());
    for (edge, ends) in scene.edges.iter().enumerate().step_by(3) {
        if scene.turns[edge] == 0 {
            continue;
        }
        let middle = (at(ends[0]) + at(ends[1])) / 2.0;
        let triangles = scene.faces.iter().flatten();
        let others = triangles.filter(|t| !ends.iter().all(|end| t.contains(end)));
        let before = others.map(|t| along_ray(middle, eye, t.map(at)));
        // Nothing is asserted of a hinge whose only obstructions lie right in front of it.
        let distances: Vec<f64> = before.flatten().collect();
        if distances.is_empty() {
            seen += 1;
            hinges.push((edge, true));
        } else if distances.iter().any(|&distance| distance > 0.2) {
            hidden += 1;
            hinges.push((edge, false));
        }
    }
    // One script asks for all: between two scripts the browser would draw the sheet.
    let edges: Vec<usize> = hinges.iter().map(|(edge, _)| *edge).collect();
    let found = view.run(&format!(
        "JSON.stringify({edges:?}.map(edge => foldpath.hingeAt(...foldpath.middleOf(edge)) === edge))"
    ));
    let found: Vec<bool> = serde_json::from_str(found.as_str().unwrap()).unwrap();
    for ((edge, in_sight), found) in hinges.into_iter().zip(found) {
        assert_eq!(found, in_sight, "hinge {edge}");
    }
    assert!(seen > 20 && hidden > 20, "{seen} in sight, {hidden} hidden");
    view.assert_quiet();
}

/// Returns the distance from a point to a triangle along the ray to the eye; `None` if the ray misses the triangle.
fn along_ray(from: Vector3<f64>, eye: Vector3<f64>, corners: [Vector3<f64>; 3]) -> Option<f64> {
    let way = eye - from;
    let [a, b, c] = corners;
    // from + t way = a + u (b - a) + v (c - a)
    let parts = Matrix3::from_columns(&[-way, b - a, c - a]).try_inverse()? * (from - a);
    let inside = parts.y > 0.0 && parts.z > 0.0 && parts.y + parts.z < 1.0;
    (inside && parts.x > 0.0).then(|| parts.x * way.norm())
}

#[test]
fn ten_thousand_faces_are_one_small_page_that_folds() {
    let planned = Planned::of(miura(100, 0.8), &PlanOptions::default());
    let scene = scene(&planned);
    assert_eq!(scene.faces.len(), 10_000);
    assert!(page(&scene).len() < 2_000_000);
    let view = View::open(&scene, &[]);
    let last = planned.plan.knots().last().unwrap();
    view.assert_shapes([(last.time, &last.vertices[..])].into_iter());
    let mut pictures = Vec::new();
    for position in ["0", "0.25", "0.5", "0.75", "1"] {
        view.run(&format!("foldpath.setPosition({position})"));
        let picture = view.drawn();
        assert!(!pictures.contains(&picture), "at {position} as before");
        pictures.push(picture);
    }
    view.run("foldpath.setPosition(0)");
    let middle = (0..scene.turns.len()).filter(|&edge| scene.turns[edge] != 0);
    view.run("for (let i = 0; i < 12; i++) zoom(1.25)");
    let edge = middle.min_by_key(|&edge| {
        let at = scene.edges[edge].map(|v| scene.vertices[v as usize]);
        let off = (at[0][0] - 50.0).abs() + (at[0][1] - 43.0).abs();
        #[allow(clippy::cast_possible_truncation, reason = "a rough distance")]
        let rough = (1e3 * off) as i64;
        rough
    });
    view.click_edge(edge.unwrap());
    assert_eq!(view.run("foldpath.view.selected"), json!(edge.unwrap()));
    view.assert_quiet();
}

#[test]
fn faces_that_pass_through_each_other_are_named_and_shown() {
    let options = PlanOptions::default().with(|it| it.collision = false);
    let planned = Planned::new("waterbomb-12x22-crossing", &options);
    let path = path_file(&planned.text()).unwrap();
    let verdict = check(&path, &strict());
    let [a, b] = verdict.crossings[0].crossing.faces;
    let view = View::open(&Scene::of_path(&path), &[]);
    let text = view.text("#pair");
    assert!(
        text.contains(&format!("{a} and {b} pass through each other")),
        "{text}"
    );
    view.click("#pair button");
    let lit = view.drawn();
    view.click("#pair input");
    assert_ne!(view.drawn(), lit);
    assert!(view.run("foldpath.position()").as_f64().unwrap() > 0.5);
    view.assert_quiet();
}

/// Plans a sheet to a fraction of half a turn along its letters, with panels that bend by this many radians.
fn along_letters(drawing: Drawing, fraction: f64, bend: f64) -> Planned {
    let pattern = CreasePattern::new(drawing).unwrap();
    let goal = Goal::of_letters(&pattern, fraction).unwrap();
    let options = PlanOptions::default().with(|it| it.bend = bend);
    let plan = plan(&pattern, &goal, &options);
    let title = "letters".to_owned();
    let file = PatternFile { title, pattern };
    Planned { file, plan }
}

/// A line from border to border turns beside two creases that are not in line, which cannot.
#[test]
fn what_is_in_the_way_of_a_path_that_falls_short_is_lit() {
    let at = [
        [0.0, 0.0],
        [1.0, 0.0],
        [2.5, 0.0],
        [4.0, 0.0],
        [4.0, 2.0],
        [2.5, 2.0],
        [1.0, 2.0],
        [0.0, 2.0],
        [3.0, 1.0],
    ];
    let border = (0..8).map(|k| ([k, (k + 1) % 8], Letter::Boundary));
    let creases = [[1, 6], [2, 8], [8, 5]].map(|ends| (ends, Letter::Valley));
    let drawing = Drawing {
        vertices: at.map(Vector2::from).to_vec(),
        edges: border
            .chain(creases)
            .map(|(ends, letter)| DrawnEdge {
                ends,
                letter,
                goal: None,
            })
            .collect(),
        faces: None,
    };
    let planned = along_letters(drawing, 0.5, 0.0);
    let scene = scene(&planned);
    let shortfall = scene.shortfall.as_ref().unwrap();
    assert_eq!(shortfall.outcome, "partial");
    let [cause] = &shortfall.causes[..] else {
        panic!("{:?}", shortfall.causes)
    };
    let view = View::open(&scene, &[]);
    let text = view.text("#shortfall");
    assert!(
        text.contains("partial") && text.contains(&cause.message),
        "{text}"
    );
    let lit = view.drawn();
    view.click("#shortfall button");
    assert_ne!(view.drawn(), lit);
    view.click("#shortfall button");
    assert_eq!(view.drawn(), lit);
    view.assert_quiet();
}

/// The page of a pattern lights the edges of a cause, a name and a crease group, and describes the edge that is clicked.
#[test]
fn a_pattern_is_a_page_whose_edges_are_described_and_lit() {
    // A square with a cross of two lines, whose letters alternate: no such vertex folds flat (Maekawa).
    let line = |id: &str, colour: &str, path: &str| {
        format!("<g id=\"{id}\"><path stroke=\"{colour}\" d=\"{path}\"/></g>")
    };
    let lines = [
        line("rim </script>", "black", "M0,0H100V100H0Z"),
        line("north", "red", "M50,50V0"),
        line("east", "blue", "M50,50H100"),
        line("south", "red", "M50,50V100"),
        line("west", "blue", "M50,50H0"),
    ];
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 100 100\" fill=\"none\">{}</svg>",
        lines.concat().replace(" </script>", " &lt;/script&gt;")
    );
    let file = parse_pattern(Path::new("cross.svg"), svg.as_bytes()).unwrap();
    let pattern = &file.pattern;
    let html = pattern_page(&file.title, pattern, Watch::default());
    let view = View::open_page(&html, &[]);
    let lit = || {
        let lit = view.run("JSON.stringify(foldpath.lit())");
        let lit: Vec<usize> = serde_json::from_str(lit.as_str().unwrap()).unwrap();
        lit
    };
    let press = |text: &str| {
        view.run(&format!(
            "[...document.querySelectorAll('button')].find((it) => it.textContent.includes('{text}')).click()"
        ));
    };
    let of_name = |name: &str| -> Vec<usize> {
        let edges = pattern.names()[name].iter();
        edges.map(|edge| edge.index()).collect()
    };
    let forecast = PatternInfo::of(pattern, Watch::default()).verdict;
    assert_eq!(view.text("aside h2"), format!("forecast: {forecast}"));
    press("Maekawa");
    let at_vertex: Vec<usize> = (0..pattern.edges().len())
        .filter(|&edge| pattern.edges()[edge].crease.is_some())
        .collect();
    assert_eq!(lit(), at_vertex);
    for name in ["north", "west", "rim"] {
        press(name);
        let name = if name == "rim" { "rim </script>" } else { name };
        assert_eq!(lit(), of_name(name), "{name}");
    }
    let east = of_name("east")[0];
    view.click(&format!("[data-edge=\"{east}\"]"));
    assert_eq!(lit(), [east]);
    let north = of_name("north")[0];
    view.run(&format!(
        "(it => {{ it.value = {north}; it.dispatchEvent(new Event('input')); }})(document.querySelector('input'))"
    ));
    assert_eq!(lit(), [north]);
    view.click(&format!("[data-edge=\"{east}\"]"));
    let said = view.text("aside p");
    assert!(
        said.starts_with(&format!("edge {east}: V")) && said.contains("names east"),
        "{said}"
    );
    view.assert_quiet();
}

#[test]
fn panels_that_bend_are_coloured_by_their_bend() {
    let twist = SquareTwist {
        rows: 1,
        columns: 1,
        angle: 0.5,
        letters: Letters::Unfoldable,
        fold: 1.0,
    };
    let planned = along_letters(twist.drawing().unwrap(), 0.4, 1.5);
    let view = View::open(&scene(&planned), &[]);
    let most = view.run("180 / Math.PI * largestBend").as_f64().unwrap();
    view.run("foldpath.setPosition(0.5)");
    let before = view.drawn();
    view.key("5");
    assert!(view.text("#lines").contains(&format!("{most:.1}°")));
    let half = view.drawn();
    assert_ne!(half, before);
    view.assert_quiet();
}

#[test]
fn phases_have_buttons_that_go_there() {
    let file = miura(3, 0.9);
    let mut goal = Goal::of_pattern(&file.pattern).unwrap();
    goal.via = vec![Goal::of_pattern(&miura(3, 0.6).pattern).unwrap()];
    let plan = plan(&file.pattern, &goal, &PlanOptions::default());
    let scene = scene(&Planned { file, plan });
    let [knot] = scene.phases[..] else {
        panic!("phases {:?}", scene.phases)
    };
    let row = &scene.motion.angles[knot * scene.motion.groups..][..scene.motion.groups];
    assert!(
        row.iter()
            .any(|angle| (angle.abs().to_degrees() - 108.0).abs() < 1e-6),
        "{row:?}"
    );
    let view = View::open(&scene, &[]);
    let buttons = view.run("document.querySelectorAll('#phases button').length");
    assert_eq!(buttons, json!(2));
    view.click("#phases button:last-of-type");
    let readout = view.text("#readout");
    let knots = scene.motion.times.len();
    assert!(
        readout.contains(&format!("{} of {knots}", knot + 1)),
        "{readout}"
    );
    view.assert_quiet();
}

/// Plates are drawn where the library has them, and the page says of each thickness what is proved.
#[test]
fn plates_have_a_slider_that_tells_what_is_proved() {
    let file = miura(3, 0.8);
    let plates = PlateRequest::given(PlateOptions::of_thickness(0.2));
    let options = PlanOptions::default().with(|it| it.plates = Some(plates));
    let planned = Planned::of(file, &options);
    let motion = path_file(&planned.text()).unwrap();
    let view = View::open(&Scene::of_path(&motion), &[]);
    assert!(
        view.text("#plates")
            .contains("proved to fold: plates up to")
    );
    view.run("foldpath.setPosition(1)");
    let drawn = view.drawn();

    let options = motion.plates.unwrap();
    let plates = Plates::new(&motion.pattern, &Trims::of(&motion, &options), &options).unwrap();
    let angles = motion.crease_angles(motion.knots.len() - 1);
    let map = FoldingMap::new(&motion.pattern, motion.pattern.tree(), &angles);
    let mesh = plates.sheet_mesh(&motion.pattern);
    let expected = mesh.vertices.iter();
    let expected: Vec<_> = expected
        .map(|(face, at)| map.poses()[face.index()].carry(at))
        .collect();
    let numbers = |list: &str| -> Vec<Vector3<f64>> {
        let list = view.run(&format!("JSON.stringify(Array.from({list}))"));
        let list: Vec<f64> = serde_json::from_str(list.as_str().unwrap()).unwrap();
        list.chunks(3).map(Vector3::from_column_slice).collect()
    };
    let found = numbers("foldedPlates");
    assert_eq!(found.len(), expected.len());
    // The page lays the sheet elsewhere: distances from the vertices tell.
    for (vertex, place) in numbers("folded").into_iter().zip(map.vertices()) {
        for (found, expected) in found.iter().zip(&expected) {
            let [found, expected] = [(found - vertex).norm(), (expected - place).norm()];
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
    }

    let slide = |to: &str| {
        view.run(&format!(
            "(slider => {{ slider.value = {to}; slider.dispatchEvent(new Event('input')); }})(document.querySelector('#plates input'))"
        ));
    };
    slide("slider.max");
    assert!(view.text("#plates").contains("too thick: plates up to"));
    assert_ne!(view.drawn(), drawn);
    slide("0");
    assert!(view.text("#plates").contains("paper: plates up to"));
    let thin = Planned::of(miura(3, 0.8), &PlanOptions::default());
    view.assert_quiet();
    view.show(&scene(&thin));
    view.run("foldpath.setPosition(1)");
    assert_eq!(view.run("element('plates').hidden"), json!(true));
    view.assert_quiet();
}

/// Play colours the hinges and marks vertices; torques are a panel of curves; both are what the library tells.
#[test]
fn play_and_torques_are_shown_to_those_who_ask() {
    let mut motion = path_file(&planned("waterbomb-4x6").text()).unwrap();
    motion.measured_in(Unit::Millimetre);
    let tolerance = Tolerance::of(&motion, Watch::default()).unwrap();
    let load = load([0.0, 0.0, -9.81], 1e-9, None);
    let loads = Loads::least(&motion, &load, Watch::default()).unwrap();
    let plain = Scene::of_path(&motion);
    let error = 1e-3;
    let scene = (plain
        .clone()
        .with_tolerance(&motion, &tolerance, Some(error)))
    .with_torques(&motion, &loads);
    assert!(!page(&plain).contains("ranked"), "nobody asked");

    let view = View::open(&scene, &[]);
    let worst = tolerance.worst().unwrap();
    let edge = motion.pattern.creases()[worst.crease.index()];
    // The median edge is 1 mm.
    let play = format!("{:.4}", (error * worst.worst).to_degrees());
    let told = view.text("#tolerance");
    assert!(
        told.contains(&format!("need play of up to {play}° or ")),
        "{told}"
    );
    let costs = &tolerance.vertices;
    let costly = (0..costs.len()).max_by(|&a, &b| costs[a].total_cmp(&costs[b]).then(b.cmp(&a)));
    assert!(
        told.contains(&format!("vertex {}: ", costly.unwrap())),
        "{told}"
    );
    let width = |edge: EdgeId| {
        let width = view.run(&format!("lineStyles[{}]", 4 * edge.index() + 3));
        width.as_f64().unwrap() / 16.0
    };
    for hinge in &tolerance.hinges {
        let edge = motion.pattern.creases()[hinge.crease.index()];
        let expected = 1.0 + 2.0 * hinge.worst / worst.worst;
        assert!((width(edge) - expected).abs() < 0.07, "{edge}");
    }
    // The keys 5 and 6 are those of play, and the worst hinge is picked by its button, which goes to its time.
    let [worst_drawn, expected_drawn] = ["5", "6"].map(|key| {
        view.key(key);
        (view.drawn(), view.text("#lines"))
    });
    assert_ne!(worst_drawn.0, expected_drawn.0);
    assert!(
        worst_drawn.1.contains(&format!("{play}°")),
        "{}",
        worst_drawn.1
    );
    view.key("5");
    view.tab_to("document.activeElement.textContent.startsWith('hinge ')");
    view.key(" ");
    assert_eq!(view.run("foldpath.view.selected"), json!(edge.index()));
    let at = view.run("timeNow()").as_f64().unwrap();
    assert!((at - worst.at).abs() < 1e-9, "{at}");
    let hinge = view.text("#hinge");
    assert!(
        hinge.contains(worst.kind.name()) && hinge.contains("may be"),
        "{hinge}"
    );
    view.key("Escape");
    // Hinges that may be cut have a colour of their own, until a button takes it away.
    let redundant = tolerance.redundant.len();
    let button = view.text("#tolerance > button");
    assert!(
        button.starts_with(&format!("{redundant} hinges of which each may be cut")),
        "{button}"
    );
    let lit = view.drawn();
    view.click("#tolerance > button");
    assert_ne!(view.drawn(), lit);
    // A vertex that is picked has a mark in the colour of what is picked.
    let vertex = view.run("ranked[0].vertex").as_u64().unwrap();
    view.run("document.querySelectorAll('#tolerance ol')[1].querySelector('button').click()");
    let pixel = format!(
        "(() => {{
           picture.draw();
           const gl = canvas.getContext('webgl2'), at = onCanvas(canvas).slice(3 * {vertex}), pixel = new Uint8Array(4);
           gl.readPixels(at[0] * devicePixelRatio, canvas.height - at[1] * devicePixelRatio, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
           return Math.max(...rgb('--selected').map((part, i) => Math.abs(255 * part - pixel[i])));
         }})()"
    );
    assert!(
        view.run(&pixel).as_f64().unwrap() < 2.0,
        "{}",
        view.run(&pixel)
    );

    // Curves have the torques at the times of the shapes, and the marker of the present time stands where it is told.
    for (k, driver) in loads.drivers.iter().enumerate() {
        let edge = motion.pattern.creases()[driver.index()];
        let curve = format!("torqueCurves.find(it => it.name === 'hinge {edge}')");
        if view.run(&format!("{curve} === undefined")) == json!(true) {
            assert!(
                loads.drivers.len() > 12,
                "all are drawn that can be told apart"
            );
            continue;
        }
        for (time, torques) in loads.times.iter().zip(&loads.torques) {
            // A singular shape has the torques of a time beside it.
            if scene
                .shapes
                .iter()
                .all(|shape| (shape.time - time).abs() > 1e-12)
            {
                continue;
            }
            let told = view.run(&format!("foldpath.setTime({time}); {curve}.now()"));
            let torque = torques[k];
            assert!(
                (told.as_f64().unwrap() - torque).abs() <= 1e-9 * torque.abs(),
                "{told} {torque}"
            );
        }
    }
    assert_eq!(
        view.run("document.querySelectorAll('#torques .now').length"),
        json!(1)
    );
    let peak = view.text("figure:has(#torques) h2");
    assert!(peak.starts_with("Torques of"), "{peak}");
    view.assert_quiet();
}

#[test]
fn browser_without_webgl_is_told_and_still_gets_curves() {
    let view = View::open(&scene(&planned("miura-3x3")), &["--disable-3d-apis"]);
    let message = view.text("#message");
    assert!(message.contains("WebGL"), "{message}");
    view.wait_for("document.querySelectorAll('.curve').length === 5");
    assert_eq!(
        view.run("element('colours').checkVisibility()"),
        json!(false)
    );
    view.assert_quiet();
}
