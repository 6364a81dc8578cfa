//! Judges exported models by physics engines, MuJoCo and Drake. `tests/run` installs them for the Python that
//! `FOLDPATH_PHYSICS_PYTHON` names; without it these tests say that they are skipped.

use std::path::{Path, PathBuf};
use std::process::Command;

use foldpath::collision::{PlateError, Plates, Trims};
use foldpath::export::{csv, mjcf};
use foldpath::generate::Miura;
use foldpath::motion::{Motion, PlateOptions, PlateSides};
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, Letter, Unit};
use foldpath::planner::{Goal, Outcome, PlanOptions, PlateRequest, plan};
use foldpath::read::read_pattern;
use foldpath::sensitivity::{Conditions, Load, Loads, Sensitivity};
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
        "yoshimura-12x12",
    ];
    let small = patterns().filter(|sheet| wanted.contains(&sheet.name.as_str()));
    let more = [miura(4, 4), miura(2, 3), miura(3, 4), miura(5, 3)];
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
        motion: motion.at_times((0..=40).map(|k| {
            let last = motion.knots.last().map_or(0.0, |knot| knot.time);
            last * f64::from(k) / 40.0
        })),
    };
    let (folder, _) = exported(&sheet);
    ask(python, "plates", &folder)["worst"].as_f64().unwrap()
}

/// Plates as thick as is proved keep apart for the engine, too. The engine finds two plates in each
/// other, or a panel is used up, at 1.05 of the thickness that is refuted.
#[test]
fn plates_as_thick_as_is_proved_keep_apart() {
    let Some(python) = python("mujoco") else {
        return;
    };
    let miura = Miura {
        rows: 4,
        columns: 4,
        sector_angle: 60_f64.to_radians(),
        fold: 150.0 / 180.0,
    };
    // The ends of a strip that is folded into a ring come near each other.
    let strip = Drawing {
        vertices: (0..10)
            .map(|k| Vector2::new(f64::from(k / 2), f64::from(k % 2)))
            .collect(),
        edges: (0..5)
            .map(|k| ([2 * k, 2 * k + 1], (1..4).contains(&k)))
            .chain((0..8).map(|k| ([k, k + 2], false)))
            .map(|(ends, folds)| DrawnEdge {
                ends,
                letter: if folds {
                    Letter::Valley
                } else {
                    Letter::Boundary
                },
                goal: folds.then_some(84_f64.to_radians()),
            })
            .collect(),
        faces: None,
    };
    let (mut crossed, mut used_up) = (0, 0);
    for (name, drawing) in [("miura", miura.drawing().unwrap()), ("strip", strip)] {
        let pattern = CreasePattern::new(drawing).unwrap();
        for (plane, sides) in [
            (0.5, PlateSides::Taper),
            (0.5, PlateSides::Inset),
            (0.0, PlateSides::Taper),
        ] {
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
