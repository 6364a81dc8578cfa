//! Does `check` say what is wrong with a path? Good paths are spoilt in many ways. Paths that only look odd must hold.

use core::f64::consts::PI;

use foldpath::check::check;
use foldpath::generate::Miura;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Outcome, PlanOptions};
use foldpath::read::fold::PatternFile;
use foldpath_core::Interpolation;
use foldpath_tests::{HandKnot, HandMade, Motion, Planned, Random, Sheet, path_file, strict};
use nalgebra::{Rotation3, Vector3};
use serde_json::{Value, json};

const SHEETS: [&str; 2] = ["miura-5x5", "waterbomb-4x6"];

/// Returns the planned path of a pattern.
fn good(name: &str) -> Value {
    let options = PlanOptions::default().with(|it| {
        it.interpolation = Some(Interpolation::Hermite);
        it.bound = strict().bound;
    });
    let planned = Planned::new(name, &options);
    serde_json::from_str(&planned.text()).unwrap()
}

/// Returns the failures of a path; none if it holds.
fn failures(path: &Value) -> Vec<String> {
    match path_file(&path.to_string()) {
        Ok(path) => check(&path, &strict()).findings(),
        Err(error) => vec![error.to_string()],
    }
}

fn tell_a_crossing(failures: &[String]) -> bool {
    failures
        .iter()
        .any(|failure| failure.contains("pass through each other"))
}

/// Returns knots at these times, at which the hinges have these angles and rest.
fn at_rest(knots: impl IntoIterator<Item = (f64, Vec<f64>)>) -> Vec<HandKnot> {
    let knots = knots.into_iter().map(|(time, angles)| HandKnot {
        time,
        rates: vec![0.0; angles.len()],
        angles,
    });
    knots.collect()
}

/// Returns the middle knot, which is neither flat nor the goal.
fn frame(path: &mut Value) -> &mut Value {
    let knots = path["file_frames"].as_array().unwrap().len();
    &mut path["file_frames"][knots / 2]
}

fn number(value: &mut Value, change: impl Fn(f64) -> f64) {
    *value = json!(change(value.as_f64().unwrap()));
}

fn each_number(list: &mut Value, change: impl Fn(f64) -> f64) {
    for value in list.as_array_mut().unwrap() {
        number(value, &change);
    }
}

/// Returns the first edge with this assignment.
fn edge(path: &Value, letter: &str) -> usize {
    let letters = path["edges_assignment"].as_array().unwrap();
    letters.iter().position(|l| l == letter).unwrap()
}

/// Moves the vertices of a frame.
fn place(frame: &mut Value, to: impl Fn(Vector3<f64>) -> Vector3<f64>) {
    for vertex in frame["vertices_coords"].as_array_mut().unwrap() {
        let from: [f64; 3] = serde_json::from_value(vertex.clone()).unwrap();
        *vertex = json!(<[f64; 3]>::from(to(from.into())));
    }
}

/// Returns the first corner of face 0 in a frame, and the unit normal of that face.
fn corner_and_normal(path: &Value, frame: &Value) -> (usize, Vector3<f64>) {
    let corner = |k: usize| path["faces_vertices"][0][k].as_u64().unwrap();
    let corner = |k| usize::try_from(corner(k)).unwrap();
    let at = |k| -> Vector3<f64> {
        let place = frame["vertices_coords"][corner(k)].clone();
        serde_json::from_value::<[f64; 3]>(place).unwrap().into()
    };
    (
        corner(0),
        (at(1) - at(0)).cross(&(at(2) - at(0))).normalize(),
    )
}

fn each_rate(path: &mut Value, change: impl Fn(f64) -> f64) {
    for frame in path["file_frames"].as_array_mut().unwrap() {
        each_number(&mut frame["foldpath:edges_foldAngleRate"], &change);
    }
}

type Spoil = fn(&mut Value);

/// Ways to spoil a path, each with words of the failure that must be reported.
const SPOILT: &[(&str, Spoil, &str)] = &[
    (
        "one angle off by a degree",
        |path| {
            let valley = edge(path, "V");
            number(&mut frame(path)["edges_foldAngle"][valley], |a| a + 1.0);
        },
        "are in group",
    ),
    (
        "one angle off by a degree, groups left out",
        |path| {
            let valley = edge(path, "V");
            number(&mut frame(path)["edges_foldAngle"][valley], |a| a + 1.0);
            path.as_object_mut().unwrap().remove("foldpath:edges_group");
        },
        "fails to close",
    ),
    (
        "one angle off by a degree, groups and positions left out",
        |path| {
            let valley = edge(path, "V");
            number(&mut frame(path)["edges_foldAngle"][valley], |a| a + 1.0);
            path.as_object_mut().unwrap().remove("foldpath:edges_group");
            frame(path)
                .as_object_mut()
                .unwrap()
                .remove("vertices_coords");
        },
        "fails to close",
    ),
    (
        "one vertex moved",
        |path| number(&mut frame(path)["vertices_coords"][3][0], |x| x + 0.01),
        "over the bound",
    ),
    (
        "one vertex moved out of the plane of its face",
        |path| {
            let whole = path.clone();
            let frame = frame(path);
            let (corner, normal) = corner_and_normal(&whole, frame);
            for (k, along) in normal.iter().enumerate() {
                number(&mut frame["vertices_coords"][corner][k], |x| {
                    x + 0.01 * along
                });
            }
        },
        "over the bound",
    ),
    (
        "positions mirrored",
        |path| place(frame(path), |p| Vector3::new(p.x, p.y, -p.z)),
        "gap",
    ),
    (
        "positions of another knot",
        |path| {
            let next = path["file_frames"][1]["vertices_coords"].clone();
            frame(path)["vertices_coords"] = next;
        },
        "gap",
    ),
    (
        "positions twice as large",
        |path| place(frame(path), |p| 2.0 * p),
        "deformation",
    ),
    (
        "one sign flipped",
        |path| {
            let valley = edge(path, "V");
            number(&mut frame(path)["edges_foldAngle"][valley], |a| -a);
        },
        "wrong sign",
    ),
    (
        "all signs flipped at one knot",
        |path| each_number(&mut frame(path)["edges_foldAngle"], |a| -a),
        "wrong sign",
    ),
    (
        "all signs flipped throughout",
        |path| {
            for frame in path["file_frames"].as_array_mut().unwrap() {
                each_number(&mut frame["edges_foldAngle"], |a| -a);
                place(frame, |p| Vector3::new(p.x, p.y, -p.z));
            }
        },
        "wrong sign",
    ),
    (
        "a sign in its group flipped",
        |path| {
            let mountain = edge(path, "M");
            number(&mut path["foldpath:edges_sign"][mountain], |s| -s);
        },
        "are in group",
    ),
    (
        "a group mistaken",
        |path| {
            let groups = path["foldpath:edges_group"].as_array_mut().unwrap();
            let first = groups.iter().position(|group| group == 0).unwrap();
            groups[first] = json!(1);
        },
        "are in group",
    ),
    (
        "a boundary edge folded",
        |path| {
            let boundary = edge(path, "B");
            frame(path)["edges_foldAngle"][boundary] = json!(1.0);
        },
        "must stay flat",
    ),
    (
        "beyond half a turn",
        |path| {
            let valley = edge(path, "V");
            number(&mut frame(path)["edges_foldAngle"][valley], |a| a + 360.0);
        },
        "beyond half a turn",
    ),
    (
        "most knots left out",
        |path| {
            let knots = path["file_frames"].as_array_mut().unwrap();
            *knots = [knots.first(), knots.last()]
                .map(|k| k.unwrap().clone())
                .into();
        },
        "between knots 0 and 1",
    ),
    (
        "straight lines between knots",
        |path| path["foldpath:interpolation"] = json!("linear"),
        "fails to close",
    ),
    (
        "rates half as fast",
        |path| each_rate(path, |rate| 0.5 * rate),
        "fails to close",
    ),
    (
        "one rate off",
        |path| {
            let valley = edge(path, "V");
            number(
                &mut frame(path)["foldpath:edges_foldAngleRate"][valley],
                |r| 1.1 * r,
            );
            path.as_object_mut().unwrap().remove("foldpath:edges_group");
        },
        "fails to close",
    ),
    (
        "one rate off its group",
        |path| {
            let valley = edge(path, "V");
            number(
                &mut frame(path)["foldpath:edges_foldAngleRate"][valley],
                |r| 1.1 * r,
            );
        },
        "are in group",
    ),
    (
        "a boundary edge turning between knots",
        |path| {
            let boundary = edge(path, "B");
            frame(path)["foldpath:edges_foldAngleRate"][boundary] = json!(1.0);
        },
        "must stay flat",
    ),
    (
        "against the letters between knots",
        |path| {
            each_number(
                &mut path["file_frames"][0]["foldpath:edges_foldAngleRate"],
                |r| -r,
            )
        },
        "but turns to",
    ),
    (
        "rates beyond reason",
        |path| each_rate(path, |rate| 1e300 * rate),
        "between knots",
    ),
    (
        "less deformation claimed",
        |path| number(&mut frame(path)["vertices_coords"][3][0], |x| x + 1e-5),
        "claims a deformation",
    ),
    (
        "a smaller gap claimed",
        |path| number(&mut frame(path)["vertices_coords"][3][0], |x| x + 1e-5),
        "claims a gap",
    ),
    (
        "less closure claimed",
        |path| {
            let valley = edge(path, "V");
            number(&mut frame(path)["edges_foldAngle"][valley], |a| a + 1e-4);
        },
        "claims a closure",
    ),
    (
        "a coordinate beyond reason",
        |path| frame(path)["vertices_coords"][3][0] = json!(1e300),
        "vertices_coords[3][0]",
    ),
    (
        "all coordinates beyond reason",
        |path| place(frame(path), |p| p * 1e49),
        "over the bound",
    ),
    (
        "a flat coordinate beyond reason",
        |path| path["vertices_coords"][3][0] = json!(1e300),
        "vertices_coords[3][0]",
    ),
    (
        "an angle beyond reason",
        |path| {
            let valley = edge(path, "V");
            frame(path)["edges_foldAngle"][valley] = json!(1e300);
        },
        "beyond half a turn",
    ),
    (
        "no angle",
        |path| {
            let valley = edge(path, "V");
            frame(path)["edges_foldAngle"][valley] = Value::Null;
        },
        "expected a number",
    ),
    (
        "an angle too few",
        |path| {
            frame(path)["edges_foldAngle"].as_array_mut().unwrap().pop();
        },
        "one for each edge",
    ),
    (
        "a vertex too few",
        |path| {
            frame(path)["vertices_coords"].as_array_mut().unwrap().pop();
        },
        "one for each vertex",
    ),
    (
        "time runs backwards",
        |path| frame(path)["foldpath:time"] = json!(0.0),
        "foldpath:time",
    ),
    (
        "no knots",
        |path| path["file_frames"] = json!([]),
        "at least one knot",
    ),
];

#[test]
fn spoilt_paths_are_rejected() {
    for name in SHEETS {
        for (what, spoil, words) in SPOILT {
            let mut path = good(name);
            spoil(&mut path);
            let failures = failures(&path);
            let said = failures.iter().any(|failure| failure.contains(words));
            assert!(said, "{name}, {what}: {failures:#?}");
        }
    }
}

#[test]
fn good_paths_hold() {
    for name in SHEETS {
        assert_eq!(failures(&good(name)), [""; 0], "{name}");
    }
}

/// A path says nothing of the position of the sheet in space.
#[test]
fn paths_moved_in_space_hold() {
    let turn = Rotation3::new(Vector3::new(1.0, -2.0, 0.5));
    for name in SHEETS {
        let mut path = good(name);
        place(frame(&mut path), |p| {
            turn * p + Vector3::new(10.0, -3.0, 7.0)
        });
        assert_eq!(failures(&path), [""; 0], "{name}");
    }
}

#[test]
fn crossing_faces_are_rejected() {
    let blind = PlanOptions::default().with(|it| it.collision = false);
    let text = Planned::new("waterbomb-12x22-crossing", &blind).text();
    let verdict = check(&path_file(&text).unwrap(), &strict());
    let failures = verdict.findings();
    assert!(tell_a_crossing(&failures), "{failures:?}");
}

/// Returns a path in which the hinges turn to `goals` (degrees) together, in straight lines.
fn hand_made(sheet: &HandMade, goals: [f64; 2]) -> Value {
    let knots = (0..20).map(f64::from);
    let knots = knots.map(|k| (k, goals.map(|goal| goal * k / 19.0).into()));
    sheet.path("linear", &at_rest(knots))
}

#[test]
fn flaps_cross_just_beyond_where_they_meet() {
    let strip_meets = 180.0 - 0.25_f64.acos().to_degrees();
    let tangent = |degrees: f64| degrees.to_radians().tan();
    let fan_meets = 180.0 - (tangent(20.0) / tangent(70.0)).acos().to_degrees();
    let (strip, fan) = (HandMade::strip(), HandMade::fan());
    let both = |sheet, goal| hand_made(sheet, [goal, goal]);
    for (what, path, crosses) in [
        (
            "flaps before they meet",
            both(&strip, strip_meets - 0.1),
            false,
        ),
        (
            "flaps through each other",
            both(&strip, strip_meets + 0.1),
            true,
        ),
        (
            "flaps on both sides",
            hand_made(&strip, [170.0, -170.0]),
            false,
        ),
        (
            "a vertex shared, before they meet",
            both(&fan, fan_meets - 0.1),
            false,
        ),
        (
            "a vertex shared, through each other",
            both(&fan, fan_meets + 0.1),
            true,
        ),
    ] {
        let failures = failures(&path);
        let said = tell_a_crossing(&failures);
        assert_eq!(said, crosses, "{what}: {failures:?}");
        assert_eq!(failures.is_empty(), !crosses, "{what}: {failures:?}");
    }
}

/// Returns a path of three to five panels, triangles round a corner or a strip, whose hinges turn one after the other, to
/// flat or by half a turn. Sectors are whole degrees wide and panels whole tenths, so that one reaches beyond another by
/// one of these or not at all.
fn turned_layers(random: &mut Random) -> Value {
    let hinges = random.whole(2, 4);
    let mut ends = vec![0.0];
    for _ in 0..=hinges {
        let width = u32::try_from(random.whole(5, 40)).unwrap();
        ends.push(ends[ends.len() - 1] + f64::from(width));
    }
    let sheet = if random.chance(0.7) {
        let rays = ends.iter().map(|&end| (end, random.uniform(0.3, 1.5)));
        HandMade::sectors(&rays.collect::<Vec<_>>())
    } else {
        HandMade::panels(&ends.iter().map(|end| end / 10.0).collect::<Vec<_>>())
    };
    let mut angles = vec![0.0; hinges];
    let mut knots = vec![angles.clone()];
    for _ in 0..random.whole(2, 6) {
        angles[random.whole(0, hinges - 1)] = [-180.0, 0.0, 180.0][random.whole(0, 2)];
        knots.push(angles.clone());
    }
    sheet.path("hermite", &at_rest((0_u32..).map(f64::from).zip(knots)))
}

#[test]
fn layers_pass_through_each_other_as_the_oracle_says() {
    let mut crossed = 0;
    for seed in 0..500 {
        let path = turned_layers(&mut Random::new(seed));
        let failures = failures(&path);
        let found = tell_a_crossing(&failures);
        let (sheet, motion) = (Sheet::of(&path).unwrap(), Motion::of(&path).unwrap());
        // A hinge that turns by a whole turn is flat in the middle of its segment.
        let segments = 0..path["file_frames"].as_array().unwrap().len() - 1;
        let places = segments.flat_map(|segment| (0..=100).map(move |k| (segment, k)));
        let shapes =
            places.map(|(segment, k)| sheet.fold(&motion.angles(segment, f64::from(k) / 100.0)));
        let shapes: Vec<_> = shapes.collect();
        let crosses = shapes
            .iter()
            .any(|shape| !sheet.crossings(&sheet.positions(shape)).is_empty());
        let expected = crosses || !sheet.passed(&shapes, 0.0).is_empty();
        assert_eq!(found, expected, "seed {seed}: {failures:?}");
        crossed += u32::from(found);
    }
    assert!((100..200).contains(&crossed), "{crossed}");
}

/// The first of three sectors is folded over the second, the third under the second, and the first comes back and on below
/// the sheet. It meets the third if that is wider than the second. The sectors rest as they come to lie on each other, so that
/// their heights shrink with the square of time.
#[test]
fn a_sector_that_comes_back_meets_what_was_folded_under_the_sheet() {
    let mut random = Random::new(1);
    for _ in 0..300 {
        let widths = [
            random.uniform(15.0, 40.0),
            random.uniform(5.0, 25.0),
            random.uniform(5.0, 40.0),
        ];
        let mut direction = 0.0;
        let rays = [0.0].into_iter().chain(widths).map(|width| {
            direction += width;
            (direction, random.uniform(0.3, 1.5))
        });
        let fan = HandMade::sectors(&rays.collect::<Vec<_>>());
        let knots = [
            (0.0, [0.0, 0.0]),
            (4.0, [180.0, 0.0]),
            (8.0, [180.0, -180.0]),
            (12.0, [90.0, -180.0]),
            (14.0, [0.0, -180.0]),
            (16.0, [-20.0, -180.0]),
        ];
        let knots = at_rest(knots.map(|(time, angles)| (time, angles.to_vec())));
        let failures = failures(&fan.path("hermite", &knots));
        let crosses = tell_a_crossing(&failures);
        assert_eq!(crosses, widths[2] > widths[1], "{widths:?}: {failures:?}");
    }
}

/// Flat-folded, all layers lie in one plane: this is contact, not a crossing.
#[test]
fn layers_in_contact_hold() {
    for sector_angle in [45.0_f64, 60.0, 80.0] {
        let miura = Miura {
            rows: 4,
            columns: 5,
            sector_angle: sector_angle.to_radians(),
            fold: 1.0,
        };
        let pattern = CreasePattern::new(miura.drawing().unwrap()).unwrap();
        let title = format!("Miura of {sector_angle} degrees");
        let options = PlanOptions::default().with(|it| it.bound = strict().bound);
        let planned = Planned::of(PatternFile { title, pattern }, &options);
        assert_eq!(
            planned.plan.outcome,
            Outcome::Planned,
            "{:?}",
            planned.plan.reason
        );
        let last = planned.plan.knots().last().unwrap();
        assert!(
            last.angles
                .iter()
                .all(|angle| (angle.abs() - PI).abs() <= 1e-9)
        );
        let path: Value = serde_json::from_str(&planned.text()).unwrap();
        assert_eq!(
            failures(&path),
            [""; 0],
            "sectors of {sector_angle} degrees"
        );
    }
}

/// A box whose lid goes too far in, 3e-4 into its floor. Vertices that the file displaces by nearly as much do not
/// excuse the crossing, because such a strip is never torn.
#[test]
fn positions_that_are_off_hide_no_crossing() {
    let strip = HandMade::panels(&[0.0, 2.0, 3.0, 5.0, 6.5]);
    for (lid, expected) in [(90.0, false), (90.02, true)] {
        let angles = [[0.0; 3], [90.0, 90.0, 0.0], [90.0, 90.0, lid]];
        let angles = angles.map(Vec::from);
        let mut path = strip.path("linear", &at_rest((0_u32..).map(f64::from).zip(angles)));
        let sheet = Sheet::of(&path).unwrap();
        let motion = Motion::of(&path).unwrap();
        let mut random = Random::new(1);
        for knot in 0..3 {
            let (segment, s) = if knot == 0 { (0, 0.0) } else { (knot - 1, 1.0) };
            let mut vertices = sheet.positions(&sheet.fold(&motion.angles(segment, s)));
            for x in vertices.iter_mut().flat_map(|place| place.iter_mut()) {
                *x += random.uniform(-1e-4, 1e-4);
            }
            let frame = &mut path["file_frames"][knot];
            frame["vertices_coords"] = vertices.iter().map(|p| [p.x, p.y, p.z]).collect();
        }
        let failures = failures(&path);
        let crosses = tell_a_crossing(&failures);
        assert_eq!(crosses, expected, "{failures:?}");
        assert_eq!(failures.len(), usize::from(expected), "{failures:?}");
    }
}

/// A strip of panels that become narrower, rolled up. From its narrow end each panel comes to lie on the panel before.
/// From its wide end the first panel lies on the second and sticks out over the third, which would have to leave
/// through it.
#[test]
fn layers_that_leave_through_each_other_are_rejected() {
    let strip = HandMade::panels(&[0.0, 1.0, 1.95, 2.85, 3.7]);
    let half = 180.0;
    for (order, crossed) in [([2, 1, 0], None), ([0, 1, 2], Some([0, 2]))] {
        let mut angles = vec![0.0; 3];
        let mut knots = vec![angles.clone()];
        for hinge in order {
            angles[hinge] = half;
            knots.push(angles.clone());
        }
        let path = strip.path("linear", &at_rest((0_u32..).map(f64::from).zip(knots)));
        let failures = failures(&path);
        let said = failures.iter().any(|failure| {
            failure.contains("between knots 1 and 2") && failure.contains("pass through each other")
        });
        assert_eq!(said, crossed.is_some(), "{order:?}: {failures:?}");
        assert_eq!(
            failures.is_empty(),
            crossed.is_none(),
            "{order:?}: {failures:?}"
        );
        // The oracle agrees, from shapes at knots and shortly before and after them.
        let (sheet, motion) = (Sheet::of(&path).unwrap(), Motion::of(&path).unwrap());
        let places = (0..3).flat_map(|segment| [0.0, 0.01, 0.99].map(|s| (segment, s)));
        let shapes = places.map(|(segment, s)| sheet.fold(&motion.angles(segment, s)));
        let shapes: Vec<_> = shapes.collect();
        for torn in [0.0, 1e-4] {
            let first = sheet.passed(&shapes, torn).first().copied();
            assert_eq!(first, crossed.map(|faces| (faces, 4)), "{order:?} {torn}");
        }
    }
}
