//! Judges exported models by physics engines, MuJoCo and Drake. `tests/run` installs them for the Python that
//! `FOLDPATH_PHYSICS_PYTHON` names; without it these tests say that they are skipped.

use std::path::{Path, PathBuf};
use std::process::Command;

use foldpath::collision::{PlateError, Plates, Trims};
use foldpath::export::{ExportOptions, Format, Source, csv, mjcf};
use foldpath::generate::{Miura, Waterbomb, Yoshimura};
use foldpath::motion::{Motion, PlateOptions, PlateSides};
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, Letter, Unit};
use foldpath::planner::{Goal, Outcome, PlanOptions, PlateRequest, plan};
use foldpath::read::read_pattern;
use foldpath::sensitivity::{Conditions, Load, Loads, Sensitivity};
use foldpath_tests::meshes::Carton;
use nalgebra::Vector2;
use serde_json::Value;
use tempfile::TempDir;

/// Number of times at which loops are judged.
const TIMES: f64 = 201.0;
/// Rounding of the engine's kinematics, median edges.
const ROUNDING: f64 = 1e-12;
/// Largest distance from the goal of a sheet that is driven by few hinges, degrees.
const NEAR_DEG: f64 = 3.0;
/// Largest difference of a torque over the largest torque.
const EQUAL_TORQUE: f64 = 1e-5;
/// Number of times at which torques are judged at least.
const JUDGED_TIMES: usize = 51;

/// Returns the Python that has the package; prints that the test is skipped and returns `None` if there is none.
fn python(package: &str) -> Option<PathBuf> {
    let Some(python) = std::env::var_os("FOLDPATH_PHYSICS_PYTHON").map(PathBuf::from) else {
        println!("skipped: FOLDPATH_PHYSICS_PYTHON is not set");
        return None;
    };
    let import = Command::new(&python)
        .args(["-c", &format!("import {package}")])
        .output();
    if import.is_ok_and(|import| import.status.success()) {
        return Some(python);
    }
    println!("skipped: {} has no {package}", python.display());
    None
}

/// A planned sheet.
struct Planned {
    name: String,
    motion: Motion,
    /// Bound on deformation and gap over the whole motion, median edges.
    certified: f64,
}

/// Plans a pattern; `None` if the answer is no.
fn planned(name: &str, pattern: &CreasePattern) -> Option<Planned> {
    let goal = Goal::of_pattern(pattern).unwrap();
    let plan = plan(pattern, &goal, &PlanOptions::default());
    if plan.outcome != Outcome::Planned {
        println!("{name}: {}", plan.outcome.name());
        return None;
    }
    Some(Planned {
        name: name.into(),
        certified: plan.certified_deformation()?,
        motion: plan.motion?,
    })
}

/// Plans the patterns of the repository.
fn patterns() -> impl Iterator<Item = Planned> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../patterns");
    let files = std::fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().path());
    let files = files.filter(|file| file.extension().is_some_and(|ending| ending == "fold"));
    let mut files: Vec<PathBuf> = files.collect();
    files.sort();
    files.into_iter().filter_map(|file| {
        let name = file.file_stem().unwrap().to_string_lossy();
        planned(&name, &read_pattern(&file).unwrap().pattern)
    })
}

fn miura(rows: usize, columns: usize) -> Planned {
    let miura = Miura {
        rows,
        columns,
        sector_angle: 60_f64.to_radians(),
        fold: 0.9,
    };
    let pattern = CreasePattern::new(miura.drawing().unwrap()).unwrap();
    planned(&format!("miura-{rows}x{columns}"), &pattern).unwrap()
}

fn square_twist() -> Planned {
    patterns()
        .find(|planned| planned.name == "square-twist-1x1")
        .unwrap()
}

/// Writes the model of a sheet, with its motion at evenly spaced times.
fn exported(sheet: &Planned) -> (TempDir, mjcf::Model) {
    let folder = tempfile::tempdir().unwrap();
    let name = Path::new(&sheet.name);
    let model = mjcf::model(&sheet.motion, name).unwrap();
    let scene = String::from_utf8_lossy(&model.files[0].1);
    // A motion of the planner has no title, but a model needs a name.
    assert!(sheet.motion.title.is_empty() && scene.contains("model=\"sheet\""));
    for (file, content) in &model.files {
        std::fs::write(folder.path().join(file), content).unwrap();
    }
    let [first, .., last] = sheet.motion.knots.as_slice() else {
        panic!("{}: a motion has two knots", sheet.name);
    };
    let rate = (TIMES - 1.0) / (last.time - first.time);
    let rows = csv::sampled(&sheet.motion, name, rate, csv::Column::Hinge).unwrap();
    std::fs::write(folder.path().join("motion.csv"), rows).unwrap();
    (folder, model)
}

/// Asks an engine about a model.
fn ask(python: &Path, question: &str, folder: &TempDir) -> Value {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("physics/judge.py");
    let mut command = Command::new(python);
    command.arg(script).arg(question).arg(folder.path());
    // MuJoCo writes a log where it runs.
    let output = command.current_dir(folder.path()).output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let text = String::from_utf8(output.stdout).unwrap();
    serde_json::from_str(text.lines().last().unwrap()).unwrap()
}

/// Torques of the drives against those of MuJoCo: N^T qfrc_inverse at rest, with the motions N that the engine's own Jacobian
/// of the loops leaves free.
#[test]
fn torques_of_drives_are_those_of_mujoco() {
    let Some(python) = python("mujoco") else {
        return;
    };
    let gravities = [[0.0, 0.0, -9.81], [4.0, 0.0, 0.0], [1.0, -5.0, 3.0]];
    let wanted = [
        "miura-3x3",
        "miura-5x5",
        "square-twist-1x1",
        "waterbomb-4x6",
        "quad-3x3",
        "resch-3x3",
    ];
    let small = patterns().filter(|sheet| wanted.contains(&sheet.name.as_str()));
    let yoshimura = Yoshimura {
        rows: 4,
        columns: 4,
        angle: 30_f64.to_radians(),
        fold: 0.25,
    };
    let yoshimura = CreasePattern::new(yoshimura.drawing().unwrap()).unwrap();
    let yoshimura = planned("yoshimura-4x4", &yoshimura).unwrap();
    let more = [
        yoshimura,
        miura(4, 4),
        miura(2, 3),
        miura(3, 4),
        miura(5, 3),
    ];
    let mut judged = 0;
    for mut sheet in small.chain(more) {
        sheet.motion.measured_in(Unit::Metre);
        sheet.motion = sheet.motion.resampled(JUDGED_TIMES);
        let pattern = sheet.motion.pattern.clone();
        let (folder, model) = exported(&sheet);
        let edge = pattern.median_edge();
        // The mass of the model: 1 for each square of the median edge.
        let load = |gravity: [f64; 3]| Load {
            areal_density: 1.0 / (edge * edge),
            fixed: None,
            gravity: gravity.into(),
            spring: 0.0,
            springs: Vec::new(),
        };
        let drivers = model
            .actuators
            .iter()
            .map(|edge| pattern.edge(*edge).crease.unwrap());
        let drivers: Vec<_> = drivers.collect();
        // Hinges that drive the sheet near flat need not drive it all along.
        let of = |gravity| Loads::of(&sheet.motion, &load(gravity), &drivers);
        let found: Result<Vec<Loads>, _> = gravities.map(of).into_iter().collect();
        let found = match found {
            Ok(found) => found,
            Err(no) => {
                println!("{}: {no}", sheet.name);
                continue;
            }
        };
        // The engine gets the closed configurations.
        let conditions = Conditions::new(&pattern).unwrap();
        let chosen: Vec<usize> = (0..found[0].times.len()).collect();
        let mut table = String::from("t");
        for crease in pattern.creases() {
            table += &format!(",edge_{crease}");
        }
        for &k in &chosen {
            let time = found[0].times[k];
            table += &format!("\n{time}");
            let at = Sensitivity::of_motion(&conditions, &sheet.motion, time).unwrap();
            for angle in at.angles() {
                table += &format!(",{:e}", angle.to_degrees());
            }
        }
        std::fs::write(folder.path().join("motion.csv"), table).unwrap();
        let asked = serde_json::json!({"gravities": gravities, "drivers": model.actuators});
        std::fs::write(folder.path().join("loads.json"), asked.to_string()).unwrap();
        let answer = ask(&python, "loads", &folder);
        let mut worst = 0.0_f64;
        // A sheet that is held in its middle may be in balance: then the digits of the meshes are of the weight.
        let weight = pattern.faces().len() as f64 * 5.0 * edge;
        let peaks = found.iter().map(|found| found.peak.torque.abs());
        let peak = peaks.fold(0.1 * weight, f64::max);
        for (index, found) in found.iter().enumerate() {
            for (row, &k) in chosen.iter().enumerate() {
                for (driver, torque) in found.torques[k].iter().enumerate() {
                    let expected = answer[index][row][driver].as_f64().unwrap();
                    let off = (torque - expected).abs() / peak;
                    assert!(
                        off <= EQUAL_TORQUE,
                        "{}: {torque} {expected} at {}",
                        sheet.name,
                        found.times[k]
                    );
                    worst = worst.max(off);
                }
            }
        }
        println!(
            "{}: {} drivers, {} times, off by {worst:.1e} of the peak",
            sheet.name,
            drivers.len(),
            chosen.len()
        );
        judged += 1;
    }
    assert!(judged >= 8, "{judged}");
}

fn check_counts(name: &str, counts: &Value, model: &mjcf::Model) {
    for (key, expected) in [
        ("bodies", model.panels),
        ("joints", model.joints),
        ("loops", model.loops),
    ] {
        assert_eq!(counts[key], expected, "{name}: {key}");
    }
}

#[test]
fn loops_of_every_pattern_stay_closed_within_the_certificate() {
    let Some(python) = python("mujoco") else {
        return;
    };
    let mut judged = 0;
    for sheet in patterns().chain([miura(4, 4)]) {
        let (folder, model) = exported(&sheet);
        let answer = ask(&python, "loops", &folder);
        check_counts(&sheet.name, &answer, &model);
        assert_eq!(answer["times"], 201, "{}", sheet.name);
        let error = answer["error"].as_f64().unwrap() / sheet.motion.pattern.median_edge();
        println!(
            "{}: loop error {error:.1e}, certified {:.1e}",
            sheet.name, sheet.certified
        );
        assert!(
            error <= sheet.certified + ROUNDING,
            "{}: {error:e}",
            sheet.name
        );
        judged += 1;
    }
    assert!(judged >= 12, "{judged}");
}

/// Drives a sheet by the actuators of its model. Returns its distance from the goal in degrees.
fn driven(python: &Path, sheet: &Planned) -> f64 {
    let (folder, model) = exported(sheet);
    let answer = ask(python, "drive", &folder);
    assert!(model.drivers_known && answer["actuators"] == model.actuators.len());
    let degrees = answer["degrees"].as_f64().unwrap();
    let how = if answer["unstable"] == true {
        ", the simulation became unstable"
    } else {
        ""
    };
    println!(
        "{}: {} driven hinges of {}, {degrees:.2} degrees from the goal{how}",
        sheet.name,
        model.actuators.len(),
        model.joints
    );
    degrees
}

#[test]
fn few_driven_hinges_fold_a_small_sheet() {
    let Some(python) = python("mujoco") else {
        return;
    };
    for sheet in [miura(4, 4), square_twist()] {
        assert!(driven(&python, &sheet) <= NEAR_DEG, "{}", sheet.name);
    }
}

/// Sheets with one motion fold by one driven hinge. Those with more are told but not judged: hinges that are free to turn
/// otherwise leave the planned branch.
#[test]
#[ignore = "takes a minute; tests/run full runs it"]
fn few_driven_hinges_fold_large_sheets() {
    let Some(python) = python("mujoco") else {
        return;
    };
    for sheet in patterns() {
        let degrees = driven(&python, &sheet);
        if sheet.name == "miura-11x11" {
            assert!(degrees <= NEAR_DEG, "{degrees}");
        }
    }
}

#[test]
#[ignore = "needs a second engine, which tests/run full installs"]
fn another_engine_counts_the_same_loops() {
    let Some(python) = python("pydrake") else {
        return;
    };
    for sheet in patterns() {
        let (folder, model) = exported(&sheet);
        check_counts(&sheet.name, &ask(&python, "drake", &folder), &model);
    }
}

/// Depth, over the extent of a model, up to which meshes of single precision touch.
const TOUCHING: f64 = 1e-6;

/// Returns the least distance of two plates along a motion by the engine, over the extent of the model.
fn least_distance(python: &Path, motion: Motion) -> f64 {
    let sheet = Planned {
        name: "plates".into(),
        certified: 0.0,
        motion: motion.at_times((0..=200).map(|k| {
            let last = motion.knots.last().map_or(0.0, |knot| knot.time);
            last * f64::from(k) / 200.0
        })),
    };
    let (folder, _) = exported(&sheet);
    ask(python, "plates", &folder)["worst"].as_f64().unwrap()
}

/// Returns the drawing of a sheet of these faces, with the goal (radians) of each edge that two of them share, by its ends.
fn sheet_of(faces: &[Vec<[f64; 2]>], goal: impl Fn([Vector2<f64>; 2]) -> f64) -> Drawing {
    let mut vertices: Vec<Vector2<f64>> = Vec::new();
    let mut edges: Vec<([usize; 2], bool)> = Vec::new();
    for face in faces {
        let corners: Vec<usize> = face
            .iter()
            .map(|at| {
                let at = Vector2::from(*at);
                let known = vertices.iter().position(|it| (it - at).norm() < 1e-9);
                known.unwrap_or_else(|| {
                    vertices.push(at);
                    vertices.len() - 1
                })
            })
            .collect();
        for (&a, &b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            match edges.iter_mut().find(|(ends, _)| *ends == [b, a]) {
                Some((_, is_shared)) => *is_shared = true,
                None => edges.push(([a, b], false)),
            }
        }
    }
    let edge = |(ends, is_shared): ([usize; 2], bool)| {
        let goal = is_shared.then(|| goal(ends.map(|end| vertices[end])));
        DrawnEdge {
            ends,
            letter: match goal {
                None => Letter::Boundary,
                Some(goal) if goal > 0.0 => Letter::Valley,
                Some(goal) if goal < 0.0 => Letter::Mountain,
                Some(_) => Letter::Flat,
            },
            goal,
        }
    };
    Drawing {
        edges: edges.into_iter().map(edge).collect(),
        vertices,
        faces: None,
    }
}

/// Returns rectangles of unit height in rows and columns.
fn rectangles(columns: u32, rows: u32, height: f64) -> Vec<Vec<[f64; 2]>> {
    let all = (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row]));
    let rectangle = |[column, row]: [u32; 2]| {
        let ([x, y], top) = ([f64::from(column), f64::from(row) * height], height);
        vec![[x, y], [x + 1.0, y], [x + 1.0, y + top], [x, y + top]]
    };
    all.map(rectangle).collect()
}

/// Returns a band of `count` triangles up and down, with triangles below and above some of them.
fn triangles(count: u32, below: &[u32], above: &[u32]) -> Vec<Vec<[f64; 2]>> {
    let h = 0.75_f64.sqrt();
    let x = f64::from;
    let band = (0..count).flat_map(|k| {
        [
            vec![[x(k), 0.0], [x(k) + 1.0, 0.0], [x(k) + 0.5, h]],
            vec![[x(k) + 0.5, h], [x(k) + 1.0, 0.0], [x(k) + 1.5, h]],
        ]
    });
    let below = below
        .iter()
        .map(|&k| vec![[x(k), 0.0], [x(k) + 0.5, -h], [x(k) + 1.0, 0.0]]);
    let above = above
        .iter()
        .map(|&k| vec![[x(k) + 0.5, h], [x(k) + 1.5, h], [x(k) + 1.0, 2.0 * h]]);
    band.chain(below).chain(above).collect()
}

/// Returns sheets that are made of plates.
fn sheets_of_plates() -> Vec<(&'static str, Drawing)> {
    let is_upright = |[a, b]: [Vector2<f64>; 2]| (a.x - b.x).abs() < 1e-9;
    let bent = |degrees: f64| move |_| degrees.to_radians();
    let all = [0, 1, 2, 3, 4];
    let [of_octahedron, of_icosahedron] = [-1.0 / 3.0, -(5.0_f64.sqrt()) / 3.0];
    let between = |cosine: f64| move |_| core::f64::consts::PI - cosine.acos();
    let mut cube = rectangles(4, 1, 1.0);
    cube.extend([1.0, -1.0].map(|y| vec![[1.0, y], [2.0, y], [2.0, y + 1.0], [1.0, y + 1.0]]));
    let miura = Miura {
        rows: 4,
        columns: 4,
        sector_angle: 60_f64.to_radians(),
        fold: 150.0 / 180.0,
    };
    let waterbomb = Waterbomb {
        rows: 4,
        columns: 6,
        fold: 0.5,
    };
    let yoshimura = Yoshimura {
        rows: 4,
        columns: 4,
        angle: 30_f64.to_radians(),
        fold: 0.25,
    };
    let carton = Carton {
        width: 60.0,
        depth: 30.0,
        height: 50.0,
        glue: 10.0,
        tuck: 8.0,
        step: 1.0,
    };
    vec![
        ("miura", miura.drawing().unwrap()),
        ("waterbomb", waterbomb.drawing().unwrap()),
        ("yoshimura", yoshimura.drawing().unwrap()),
        // The ends of a strip that is folded into a ring come near each other.
        ("ring", sheet_of(&rectangles(4, 1, 1.0), bent(84.0))),
        (
            "tube",
            sheet_of(&rectangles(6, 3, 1.0), |ends| {
                if is_upright(ends) {
                    bent(60.0)(ends)
                } else {
                    0.0
                }
            }),
        ),
        ("cube", sheet_of(&cube, bent(90.0))),
        (
            "octahedron",
            sheet_of(&triangles(3, &[0], &[0]), between(of_octahedron)),
        ),
        (
            "icosahedron",
            sheet_of(&triangles(5, &all, &all), between(of_icosahedron)),
        ),
        ("tuck carton", carton.drawing()),
        (
            "map",
            sheet_of(&rectangles(4, 4, 1.0), |ends| {
                let sign = if ends[0].y % 2.0 < 1e-9 { 1.0 } else { -1.0 };
                if is_upright(ends) {
                    0.0
                } else {
                    sign * bent(150.0)(ends)
                }
            }),
        ),
        (
            "accordion",
            sheet_of(&rectangles(8, 1, 2.0), |ends| {
                let sign = if ends[0].x % 2.0 < 1e-9 { 1.0 } else { -1.0 };
                sign * bent(150.0)(ends)
            }),
        ),
    ]
}

/// Plates as thick as is proved keep apart for the engine, too. The engine finds two plates in each
/// other, or a panel is used up, at 1.05 of the thickness that is refuted.
#[test]
fn plates_as_thick_as_is_proved_keep_apart() {
    let Some(python) = python("mujoco") else {
        return;
    };
    let (mut crossed, mut used_up) = (0, 0);
    for (name, drawing) in sheets_of_plates() {
        let pattern = CreasePattern::new(drawing).unwrap();
        let forms = [
            (0.5, PlateSides::Taper),
            (0.5, PlateSides::Inset),
            (0.0, PlateSides::Taper),
        ];
        let all_forms = ["miura", "ring"].contains(&name);
        for (plane, sides) in forms.into_iter().take(if all_forms { 3 } else { 1 }) {
            let plates = PlateOptions::of_thickness(0.0)
                .with(|it| (it.hinge_plane, it.sides) = (plane, sides));
            let options =
                PlanOptions::default().with(|it| it.plates = Some(PlateRequest::thickest(plates)));
            let plan = plan(&pattern, &Goal::of_pattern(&pattern).unwrap(), &options);
            let motion = plan.motion.unwrap();
            let [proved, refuted] = plan.max_thickness.unwrap();
            assert!(
                proved > 0.0 && refuted <= 1.01 * proved,
                "{name}: {proved} {refuted}"
            );
            let least = least_distance(&python, motion.clone());
            println!(
                "{name}, hinge plane {plane}, {sides:?}: {proved:.4}, {refuted:.4}; least distance {least:.1e}"
            );
            assert!(least >= -TOUCHING, "{name} {plane} {sides:?}: {least:e}");
            let mut thicker = motion;
            thicker.plates = thicker
                .plates
                .map(|it| it.with(|it| it.thickness = 1.05 * refuted));
            let trims = Trims::of(&thicker, &thicker.plates.unwrap());
            match Plates::new(&pattern, &trims, &thicker.plates.unwrap()) {
                Err(PlateError::UsedUp { .. }) => used_up += 1,
                made => {
                    made.unwrap();
                    let least = least_distance(&python, thicker);
                    assert!(least < -TOUCHING, "{name} {plane} {sides:?}: {least:e}");
                    crossed += 1;
                }
            }
        }
    }
    assert!(crossed >= 2 && used_up >= 2, "{crossed} {used_up}");
}

/// Returns the volume of a plate between its outlines. Areas are quadratic between two heights, so that Simpson's rule is exact.
fn volume(plates: &Plates, plate: usize) -> f64 {
    let outlines = plates.list[plate].outlines.windows(2);
    let layers = plates.heights.windows(2).zip(outlines);
    let area = |outline: Vec<Vector2<f64>>| {
        let next = outline.iter().cycle().skip(1);
        outline
            .iter()
            .zip(next)
            .map(|(a, b)| a.perp(b))
            .sum::<f64>()
            / 2.0
    };
    layers
        .map(|(heights, outlines)| {
            let [lower, upper] = [0, 1].map(|k| outlines[k].concat());
            let pairs = lower.iter().zip(&upper);
            let middle = pairs.map(|(a, b)| (a + b) / 2.0).collect();
            let height = heights[1] - heights[0];
            height * (area(lower) + 4.0 * area(middle) + area(upper)) / 6.0
        })
        .sum()
}

/// Files for the workshop are closed solids with the volumes of the plates, and drawings without errors.
#[test]
fn files_for_the_workshop_are_read_by_other_programs() {
    let Some(python) = python("trimesh, ezdxf") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let mut sheets = Vec::new();
    for (name, drawing) in sheets_of_plates() {
        let pattern = CreasePattern::new(drawing).unwrap();
        let goal = Goal::of_pattern(&pattern).unwrap();
        for sides in PlateSides::ALL {
            let options = PlateOptions::of_thickness(0.1).with(|it| it.sides = sides);
            let options =
                PlanOptions::default().with(|it| it.plates = Some(PlateRequest::given(options)));
            let motion = plan(&pattern, &goal, &options).motion.unwrap();
            let files = folder.path().join(sheets.len().to_string());
            std::fs::create_dir(&files).unwrap();
            write_for_the_workshop(&motion, name, &files);
            let options = motion.plates.unwrap();
            let trims = Trims::of(&motion, &options);
            let plates = Plates::new(&motion.pattern, &trims, &options).unwrap();
            sheets.push((format!("{name}, {sides:?}"), plates));
        }
    }
    let answers = ask(&python, "shop", &folder);
    for ((name, plates), answer) in sheets.iter().zip(answers.as_array().unwrap()) {
        check_files(&format!("{name}: {answer}"), plates, answer);
    }
    assert_eq!(sheets.len(), answers.as_array().unwrap().len());
}

fn write_for_the_workshop(motion: &Motion, name: &str, folder: &Path) {
    for (format, options) in [
        ("stl", ExportOptions::default()),
        (
            "stl",
            ExportOptions::default().with(|it| it.assembled = true),
        ),
        ("dxf", ExportOptions::default().with(|it| it.kerf = 0.01)),
    ] {
        let made = Format::named(format).unwrap().make(
            Source::Motion(motion),
            Path::new(name),
            &options,
            &mut |file, content| {
                let file = if file.is_empty() { "cut.dxf" } else { file };
                std::fs::write(folder.join(file), content).unwrap();
                Ok(())
            },
        );
        made.unwrap();
    }
}

fn check_files(what: &str, plates: &Plates, answer: &Value) {
    let cut = &answer["drawings"]["cut.dxf"];
    assert_eq!(cut["errors"], 0, "{what}");
    assert_eq!(cut["layers"]["CUT"], plates.list.len(), "{what}");
    assert_eq!(cut["layers"]["TEXT"], plates.list.len(), "{what}");
    let mut judged = 0;
    for (file, solids) in answer["solids"].as_object().unwrap() {
        let solids = solids.as_array().unwrap();
        let panels: Vec<usize> = match file.strip_prefix("panel_") {
            Some(rest) => {
                let face: usize = rest.split('_').next().unwrap().parse().unwrap();
                vec![plates.of_face[face]]
            }
            None => (0..plates.list.len()).collect(),
        };
        assert_eq!(solids.len(), panels.len(), "{what}");
        let expected = panels.iter().map(|&plate| volume(plates, plate));
        let mut expected: Vec<f64> = expected.collect();
        assert!(solids.iter().all(|solid| solid["closed"] == true), "{what}");
        let found = solids.iter().map(|solid| solid["volume"].as_f64().unwrap());
        let mut found: Vec<f64> = found.collect();
        expected.sort_by(f64::total_cmp);
        found.sort_by(f64::total_cmp);
        for (found, expected) in found.iter().zip(&expected) {
            let is_same = (found - expected).abs() <= 1e-9 * expected;
            assert!(is_same, "{what}: {found} {expected}");
            judged += 1;
        }
    }
    assert!(judged > plates.list.len(), "{what}");
}
