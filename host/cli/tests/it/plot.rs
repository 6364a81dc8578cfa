//! Tests the pictures of `foldpath plot`, and the numbers that it draws.

use std::fs;

use crate::common::{PATTERNS, folder_with_path};
use foldpath::Vector3;
use foldpath::check::measure;
use foldpath::pattern::Unit;
use foldpath::plot::{Curves, Point, svg};
use foldpath::progress::Watch;
use foldpath::read::fold::read_motion;
use foldpath::sensitivity::{Load, Loads};
use foldpath_test_support::{Folder, edited};
use usvg::roxmltree::Document;

fn curves(folder: &Folder, name: &str) -> Curves {
    Curves::of_path(&read_motion(&folder.path(name)).unwrap())
}

fn at(curve: &[Point], time: f64) -> f64 {
    let nearest = |a: &&Point, b: &&Point| (a.0 - time).abs().total_cmp(&(b.0 - time).abs());
    let (found, value) = *curve.iter().min_by(nearest).unwrap();
    assert!((found - time).abs() < 1e-9, "{found}, {time}");
    value
}

/// The fold angles of a Miura fold satisfy tan(b/2) = cos(sector) tan(a/2) all along the path.
#[test]
fn curves_are_those_of_the_motion() {
    let folder = folder_with_path();
    let path = read_motion(&folder.path("path.fold")).unwrap();
    let curves = curves(&folder, "path.fold");
    assert!(curves.grouped);
    let [a, b] = curves.angles.as_slice() else {
        panic!("{} groups", curves.angles.len());
    };
    assert!(a.len() > 100, "{}", a.len());
    let tangent = |degrees: f64| (degrees.to_radians() / 2.0).tan().abs();
    for (a, b) in a.iter().zip(b) {
        let [low, high] = [a.1, b.1].map(tangent);
        let (low, high) = (low.min(high), low.max(high));
        assert!(
            (low - 0.5 * high).abs() < 1e-6 * (1.0 + high),
            "{a:?}, {b:?}"
        );
    }
    let tree = path.pattern.tree();
    for (knot, measured) in path.knots.iter().zip(measure(&path, tree)) {
        let found = at(&curves.deformation, knot.time);
        assert!((found - measured.rigidity.deformation).abs() <= 0.0);
        assert!((at(&curves.gap, knot.time) - measured.rigidity.gap).abs() <= 0.0);
    }
    for &(time, error) in curves.deformation.iter().chain(&curves.gap) {
        let mut bounds = curves
            .certified
            .iter()
            .filter(|(from, to, _)| *from <= time && time <= *to);
        assert!(bounds.any(|(.., most)| error <= *most), "{time}: {error:e}");
    }
    // The panels of a Miura fold come ever nearer to each other.
    let least = curves.clearance.last().unwrap().1;
    assert!(
        curves
            .clearance
            .windows(2)
            .all(|pair| pair[1].1 <= pair[0].1 + 1e-12)
    );
    assert!(
        (least - curves.min_clearance.unwrap()).abs() < 1e-9,
        "{least}"
    );
    let off = curves.measured.iter().map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-9);
    assert_eq!(curves.measured.len(), path.knots.len() * (12 + 9));
}

/// A vertex at the wrong place bends a panel, so that the measured angle of the panel's virtual edge is not 0.
#[test]
fn a_bent_panel_shows_in_the_angles_measured() {
    let folder = folder_with_path();
    let mut path = folder.read_json("path.fold");
    path["file_frames"][0]["vertices_coords"][0][2] = 0.2.into();
    folder.write("bent.fold", &path.to_string());
    let curves = curves(&folder, "bent.fold");
    let off = |p: &&Point| (p.1 - p.0).abs();
    let worst = curves
        .measured
        .iter()
        .max_by(|a, b| off(a).total_cmp(&off(b)));
    let &(assigned, measured) = worst.unwrap();
    assert!(
        assigned.abs() < 1e-9 && measured.abs() > 5.0,
        "{assigned}, {measured}"
    );
    let found = format!("differ by {:.1e} degrees", measured.abs());
    assert!(svg(&curves).contains(&found), "{found}");
}

fn texts(svg: &str) -> Vec<String> {
    let document = Document::parse(svg).unwrap();
    let texts = document
        .descendants()
        .filter(|node| node.has_tag_name("text"));
    texts
        .map(|node| node.text().unwrap_or_default().trim().to_string())
        .collect()
}

#[test]
fn the_picture_has_four_panels_with_units() {
    let folder = folder_with_path();
    folder.done("plan miura.fold --symmetry off --frames angles -o free.fold");
    let mut ungrouped = folder.read_json("path.fold");
    let key = ungrouped.as_object_mut().unwrap();
    key.remove("foldpath:edges_group");
    folder.write("ungrouped.fold", &ungrouped.to_string());
    folder.done(&format!(
        "plan {PATTERNS}/waterbomb-4x6.fold -o waterbomb.fold"
    ));
    for (file, caption) in [
        ("path.fold", "Miura 3x3: fold angles of 2 crease groups"),
        ("ungrouped.fold", "Miura 3x3: fold angles of 12 creases"),
        ("free.fold", "Miura 3x3: fold angles of 12 crease groups"),
        (
            "waterbomb.fold",
            "Waterbomb 4x6: fold angles of 4 crease groups",
        ),
    ] {
        let said = folder.done(&format!("plot {file} -o a.svg")).stdout;
        assert!(said.contains("picture written to a.svg"), "{said}");
        let texts = texts(&folder.read("a.svg"));
        let time = "time along the path, seconds (upright lines: knots)";
        assert_eq!(
            texts.iter().filter(|text| *text == time).count(),
            3,
            "{texts:?}"
        );
        for expected in [
            caption,
            "fold angle, degrees",
            "fold angle assigned, degrees",
            "fold angle measured, degrees",
            "deformation",
            "gap",
            "certified between knots",
            "distance, units of the sheet",
        ] {
            assert!(
                texts.iter().any(|text| text == expected),
                "{file}: {expected}: {texts:?}"
            );
        }
    }
}

/// Numbers in files are not limited, and nothing that a path claims need be true.
#[test]
fn absurd_paths_are_drawn_all_the_same() {
    let folder = folder_with_path();
    let path = folder.read_json("path.fold");
    for edits in [
        "/file_frames/1/edges_foldAngle/9 = 1e300; /foldpath:interpolation = \"hermite\"",
        "/file_frames/1/foldpath:edges_foldAngleRate/9 = 1e300",
        "/file_frames/1/vertices_coords/3/0 = 1e49; /file_title = \"a\\u0000<b\"",
        "/file_frames/0/foldpath:time = -1e300",
        "/file_frames/0/foldpath:time = -1e-300; /foldpath:interpolation = \"linear\"",
    ] {
        folder.write("absurd.fold", &edited(&path, edits).to_string());
        folder.done("plot absurd.fold -o a.svg");
        assert!(texts(&folder.read("a.svg")).len() > 20, "{edits}");
    }
    let mut still = path.clone();
    still["file_frames"].as_array_mut().unwrap().truncate(1);
    folder.write("still.fold", &still.to_string());
    folder.done("plot still.fold -o a.svg");
    assert!(texts(&folder.read("a.svg")).len() > 10);
}

#[test]
fn a_png_has_the_pixels_of_the_picture() {
    let folder = folder_with_path();
    folder.done("plot path.fold -o a.PNG");
    let bytes = fs::read(folder.path("a.PNG")).unwrap();
    assert_eq!(bytes[..8], *b"\x89PNG\r\n\x1a\n");
    let word = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!([word(16), word(20)], [1600, 2240]);
    // An empty white picture would be far smaller.
    assert!(bytes.len() > 40_000, "{}", bytes.len());
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let folder = folder_with_path();
    let before = folder.names();
    for (arguments, expected) in [
        (
            "path.fold -o a.pdf",
            "-o: expected a name that ends in .svg or .png, found a.pdf",
        ),
        (
            "miura.fold -o a.svg",
            "miura.fold: file_frames: expected at least one knot (of a path; `foldpath plan` makes one of a \
             crease pattern), found none",
        ),
    ] {
        let answer = folder.run(&format!("plot {arguments}")).with_status(2);
        assert!(answer.tells(expected), "{}", answer.stderr);
    }
    assert_eq!(folder.names(), before);
}

/// The torques that are drawn are those that `loads` tells.
#[test]
fn torques_are_those_of_loads() {
    let folder = folder_with_path();
    let load = "--areal-density 0.8 --unit mm --gravity 0,-9.81,0 --spring 0.001";
    folder.done(&format!("plot path.fold {load} -o torques.svg"));
    folder.done("plot path.fold -o plots.svg");
    let [more, usual] = ["torques.svg", "plots.svg"].map(|name| folder.read(name));
    let told = folder
        .done(&format!("loads path.fold {load} --json"))
        .json();
    let mut motion = read_motion(&folder.path("path.fold")).unwrap();
    motion.measured_in(Unit::Millimetre);
    let load = Load {
        areal_density: 0.8,
        fixed: None,
        gravity: Vector3::new(0.0, -9.81, 0.0),
        spring: 0.001,
        springs: Vec::new(),
    };
    let loads = Loads::least(&motion, &load, Watch::default()).unwrap();
    let curves = Curves::of_path(&motion).with_torques(&motion, &loads);
    assert_eq!(curves.torques.len(), 1);
    let (driver, points) = &curves.torques[0];
    assert_eq!(told["drivers"][0], driver.index());
    for (k, (time, torque)) in points.iter().enumerate() {
        assert_eq!(told["times"][k], *time);
        assert_eq!(told["torques"][k][0], *torque);
    }
    assert_eq!(svg(&curves), more);
    let peak = told["peak"]["torque"].as_f64().unwrap().abs();
    assert!(more.contains(&format!(
        "torques of the drivers, 1 of them: {peak:.3e} Nm at most"
    )));
    assert!(more.contains(&format!("hinge {driver}")) && !usual.contains("torque"));
    let refused = folder
        .run("plot path.fold --spring 0.1 -o plots.svg")
        .with_status(2);
    assert!(
        refused.stderr.contains("--areal-density"),
        "{}",
        refused.stderr
    );
}
