//! Tests paths as controllers follow them: exported trajectories keep the limits for which the path was planned.

use crate::common::{PATTERNS, folder, folder_with_path};
use foldpath::read::read_pattern;
use foldpath::symmetry::ReducedStars;
use foldpath_core::acceptance::{Setpoint, SheetView};
use foldpath_core::follower::{CheckedOptions, Follower, FollowerPosition, State};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::trajectory_file::TrajectoryFile;
use foldpath_core::{HalfAngle, Interpolation, Objective, Scalar, Spoke, StarsView};
use foldpath_test_support::Folder;
use serde_json::{Value, json};

/// Speed (radians per second) and acceleration (radians per second squared) of `--max-speed 30 --max-accel 60`.
const LIMITS: [f64; 2] = [
    30.0 * core::f64::consts::PI / 180.0,
    core::f64::consts::PI / 3.0,
];

/// An exported trajectory, read back.
struct Exported {
    interpolation: Interpolation,
    groups: usize,
    spans: Vec<f64>,
    angles: Vec<f64>,
    rates: Vec<f64>,
    weights: Vec<[f64; 2]>,
    /// Speed and acceleration that the file allows, in radians and seconds.
    limits: [f64; 2],
    bytes: usize,
}

impl Exported {
    /// Reads `out.traj`.
    fn of(folder: &Folder) -> Self {
        let bytes = std::fs::read(folder.path("out.traj")).unwrap();
        let file = TrajectoryFile::read(&bytes).unwrap();
        let places = (0..file.len()).flat_map(|k| (0..file.groups()).map(move |g| (k, g)));
        let nodes: Vec<_> = places.map(|(k, g)| file.node(k, g).unwrap()).collect();
        let limits = file.limits(0).unwrap();
        let homogeneous = file.interpolation() == Interpolation::Homogeneous;
        let weighted = nodes.iter().filter(|_| homogeneous);
        Self {
            interpolation: file.interpolation(),
            groups: file.groups(),
            spans: (0..file.len())
                .map(|k| file.span(k).unwrap().to_f64())
                .collect(),
            angles: nodes.iter().map(|node| node.angle.to_f64()).collect(),
            rates: nodes.iter().map(|node| node.rate.to_f64()).collect(),
            weights: weighted
                .map(|node| node.weight.map(Scalar::to_f64))
                .collect(),
            limits: [limits.speed, limits.acceleration].map(Scalar::to_f64),
            bytes: bytes.len(),
        }
    }

    fn view(&self) -> TrajectoryView<'_, f64> {
        TrajectoryView::new(
            self.interpolation,
            self.groups,
            &self.spans,
            &self.angles,
            &self.rates,
            &self.weights,
        )
        .unwrap()
    }

    fn duration(&self) -> f64 {
        self.spans.iter().sum()
    }

    /// Returns the largest speed and acceleration of 10,000 samples per second, over the limits of the file: first by
    /// the derivatives of the curves, then by differences of angles.
    fn used(&self) -> [[f64; 2]; 2] {
        let view = self.view();
        let step = 1e-4;
        let mut used = [[0.0; 2]; 2];
        let mut raise = |by: usize, values: [f64; 2]| {
            for k in 0..2 {
                used[by][k] = f64::max(used[by][k], values[k].abs() / self.limits[k]);
            }
        };
        for (segment, &span) in self.spans.iter().skip(1).enumerate() {
            let samples = (0..).map(|k| f64::from(k) * step).take_while(|t| *t < span);
            for t in samples.chain([span]) {
                for group in 0..self.groups {
                    let curve = view.curve(segment, group).unwrap();
                    let [first, second] = curve.derivatives(t / span);
                    raise(0, [first / span, second / (span * span)]);
                }
            }
        }
        let mut latest = vec![vec![0.0; self.groups]; 3];
        let samples = (0..).map(|k| f64::from(k) * step);
        for t in samples.take_while(|t| *t < self.duration() + 2.0 * step) {
            latest.rotate_left(1);
            let place = FollowerPosition { knot: 0, into: t };
            view.sample(place, &mut latest[2]);
            for ((a, b), c) in latest[0].iter().zip(&latest[1]).zip(&latest[2]) {
                raise(1, [(c - b) / step, (c - 2.0 * b + a) / (step * step)]);
            }
        }
        used
    }

    /// Asserts that the motion keeps its limits, comes near one of them, and begins and ends at rest.
    #[track_caller]
    fn keeps_limits(&self, name: &str) {
        let [derivatives, differences] = self.used();
        assert!(
            derivatives.iter().all(|used| *used <= 1.0),
            "{name}: {derivatives:?}"
        );
        assert!(
            differences.iter().all(|used| *used <= 1.001),
            "{name}: {differences:?}"
        );
        assert!(
            derivatives.iter().any(|used| *used >= 0.9),
            "{name}: {derivatives:?}"
        );
        for (limit, asked) in self.limits.iter().zip(LIMITS) {
            assert!(*limit <= asked && *limit > asked * (1.0 - 1e-6), "{name}");
        }
        let (first, last) = (&self.rates[..self.groups], self.rates.len() - self.groups);
        let mut ends = first.iter().chain(&self.rates[last..]);
        assert!(ends.all(|rate| rate.abs() <= 0.0), "{name}");
        assert!(self.spans[0].abs() <= 0.0, "{name}");
    }
}

/// Returns a strip of unit squares with hinges between them that fold by these angles, degrees.
fn strip(goal: &[f64]) -> Value {
    let last = goal.len() + 1;
    let vertices: Vec<Value> = (0..=last)
        .flat_map(|x| [json!([x, 0]), json!([x, 1])])
        .collect();
    let along = (0..last).flat_map(|k| [[2 * k, 2 * k + 2], [2 * k + 1, 2 * k + 3]]);
    let across = (0..=last).map(|k| [2 * k, 2 * k + 1]);
    let angles = [0.0].into_iter().chain(goal.iter().copied()).chain([0.0]);
    let letter = |angle: f64| match angle {
        a if a > 0.0 => "V",
        a if a < 0.0 => "M",
        _ => "B",
    };
    let sides = vec![0.0; 2 * last];
    let angles: Vec<f64> = sides.into_iter().chain(angles).collect();
    json!({
        "file_spec": 1.2,
        "vertices_coords": vertices,
        "edges_vertices": along.chain(across).collect::<Vec<_>>(),
        "edges_assignment": angles.iter().map(|a| letter(*a)).collect::<Vec<_>>(),
        "edges_foldAngle": angles,
    })
}

/// Plans a pattern within `LIMITS` and exports its path.
fn exported(pattern: &Value, options: &str) -> Exported {
    let folder = folder();
    folder.write("pattern.fold", &pattern.to_string());
    let plan = "plan pattern.fold --max-speed 30 --max-accel 60 -o path.fold";
    folder.done(&format!("{plan} {options}"));
    folder.done("export path.fold --to traj -o out.traj");
    Exported::of(&folder)
}

fn generated(family: &str) -> Exported {
    let folder = folder();
    folder.done(&format!("generate {family} -o pattern.fold"));
    exported(&folder.read_json("pattern.fold"), "")
}

/// Returns the shortest time (seconds) in which a hinge turns by an angle (radians) from rest to rest.
fn fastest(angle: f64) -> f64 {
    let [speed, acceleration] = LIMITS;
    if angle > speed * speed / acceleration {
        angle / speed + speed / acceleration
    } else {
        2.0 * (angle / acceleration).sqrt()
    }
}

/// Asserts that a trajectory takes no less time than `least`, and at most 5 % more.
#[track_caller]
fn takes(exported: &Exported, least: f64, name: &str) {
    let duration = exported.duration();
    let part = duration / least;
    assert!((1.0 - 1e-6..=1.05).contains(&part), "{name}: {part}");
}

#[test]
fn one_hinge_runs_a_trapezoid_or_a_triangle() {
    for interpolation in ["auto", "hermite", "half-angle", "homogeneous"] {
        for degrees in [10.0, -14.0, 90.0, 170.0] {
            let name = format!("{degrees} {interpolation}");
            let options = format!("--interpolation {interpolation}");
            let exported = exported(&strip(&[degrees]), &options);
            exported.keeps_limits(&name);
            takes(&exported, fastest(degrees.to_radians().abs()), &name);
        }
    }
}

#[test]
fn of_two_hinges_the_one_driven_further_rules() {
    for goal in [[60.0, 120.0], [150.0, -40.0], [9.0, 3.0]] {
        let exported = exported(&strip(&goal), "");
        let name = format!("{goal:?}");
        exported.keeps_limits(&name);
        let furthest = f64::max(goal[0].abs(), goal[1].abs());
        takes(&exported, fastest(furthest.to_radians()), &name);
    }
}

#[test]
fn sheets_keep_the_limits() {
    for family in ["miura --rows 5 --cols 5", "waterbomb --rows 4 --cols 6"] {
        generated(family).keeps_limits(family);
    }
}

/// The file of 24x24 panels with 1104 hinges has mostly five bytes for each hinge: group and sign, and the gap that it costs.
#[test]
fn a_large_sheet_is_a_small_file() {
    let exported = generated("miura --rows 24 --cols 24");
    let numbers = 4 * (1 + 2 * exported.groups) * exported.spans.len();
    // One vertex of degree four stands for all vertices.
    let vertices = 1 + 4 * 9 + 4;
    let head = 4 + 1 + 1 + 1 + 16 * exported.groups + 2 + 1104 + vertices + 1;
    println!("{} bytes, {} knots", exported.bytes, exported.spans.len());
    let cost = 4 + 2 + 4 * 1104;
    // The number of the path and the checksum.
    let bytes = head + numbers + cost + 4 + 4;
    assert_eq!((exported.groups, exported.bytes), (2, bytes));
}

#[test]
fn the_table_has_a_row_a_knot() {
    let folder = folder_with_path();
    folder.done("export path.fold --to csv -o out.csv");
    let path = folder.read_json("path.fold");
    let text = folder.read("out.csv");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("time_s,group_0_deg,group_1_deg"));
    let edge_of = |group: u64| {
        let groups = path["foldpath:edges_group"].as_array().unwrap();
        groups
            .iter()
            .position(|g| g.as_u64() == Some(group))
            .unwrap()
    };
    let signs = &path["foldpath:edges_sign"];
    let frames = path["file_frames"].as_array().unwrap();
    assert_eq!(lines.clone().count(), frames.len());
    for (line, frame) in lines.zip(frames) {
        let numbers: Vec<f64> = line.split(',').map(|n| n.parse().unwrap()).collect();
        let angle = |group| {
            let edge = edge_of(group);
            frame["edges_foldAngle"][edge].as_f64().unwrap() * signs[edge].as_f64().unwrap()
        };
        let expected = [frame["foldpath:time"].as_f64().unwrap(), angle(0), angle(1)];
        let near = numbers
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(near && numbers.len() == 3, "{line}: {expected:?}");
    }
}

/// A path without groups and limits, as another program may write it.
#[test]
fn without_groups_every_hinge_is_one_and_limits_are_the_largest_found() {
    let folder = folder_with_path();
    let mut path = folder.read_json("path.fold");
    let keys = path.as_object_mut().unwrap();
    for key in ["edges_group", "edges_sign", "maxSpeed", "maxAcceleration"] {
        assert!(keys.remove(&format!("foldpath:{key}")).is_some());
    }
    folder.write("path.fold", &path.to_string());
    folder.done("export path.fold --to traj -o out.traj");
    let bytes = std::fs::read(folder.path("out.traj")).unwrap();
    let file = TrajectoryFile::read(&bytes).unwrap();
    assert_eq!((file.groups(), file.hinges()), (12, 12));
    assert!(
        file.memberships()
            .zip(0..)
            .all(|(m, k)| m.group.0 == k && !m.negative)
    );
    let exported = Exported::of(&folder);
    let [speed, acceleration] = exported.limits;
    // The path was planned for 45 degrees per second.
    assert!((speed.to_degrees() - 45.0).abs() < 1e-3);
    assert!(acceleration.is_finite());
}

/// The motion ρ = t² in 200 segments has the same acceleration everywhere, equal to the limit. Rounding an angle would
/// exceed the limit.
#[test]
fn rounding_passes_no_limit() {
    let folder = folder();
    folder.write("pattern.fold", &strip(&[90.0]).to_string());
    folder.done("plan pattern.fold --interpolation hermite -o path.fold");
    let mut path = folder.read_json("path.fold");
    let frame = path["file_frames"][0].clone();
    let frames = (0..=200).map(|k| {
        let t = f64::from(k) * 0.045;
        let mut frame = frame.clone();
        let hinge = frame["edges_foldAngle"].as_array().unwrap().len() - 2;
        frame["foldpath:time"] = json!(t);
        frame["edges_foldAngle"][hinge] = json!(t * t);
        frame["foldpath:edges_foldAngleRate"][hinge] = json!(2.0 * t);
        frame
    });
    path["file_frames"] = frames.collect();
    path["foldpath:maxAcceleration"] = json!(2.0);
    folder.write("path.fold", &path.to_string());
    folder.done("export path.fold --to traj -o out.traj");
    let exported = Exported::of(&folder);
    let [used, _] = exported.used();
    assert!(used.iter().all(|used| *used <= 1.0), "{used:?}");
    let stretch = exported.duration() / 9.0;
    // At both ends of each segment, rounding changes times near 8 s by 5e-7 s and angles near 1 by 6e-8. At 0.3 rad/s
    // and 0.045 s this is 4 % of an acceleration of 0.035 rad/s².
    assert!((1.0..1.02).contains(&stretch), "{stretch}");
}

#[test]
fn what_cannot_be_exported_is_said() {
    let folder = folder_with_path();
    let good = folder.read_json("path.fold");
    let hinge = good["foldpath:edges_group"].as_array().unwrap();
    let hinge = hinge.iter().rposition(|group| group.is_u64()).unwrap();
    type Edit<'a> = &'a dyn Fn(&mut Value);
    let cases: [(Edit<'_>, String); 5] = [
        (
            &|path| path["foldpath:maxSpeed"] = json!(30.0),
            "foldpath:maxSpeed: expected at least the path's".into(),
        ),
        (
            &|path| path["foldpath:maxSpeed"] = json!(-30.0),
            "foldpath:maxSpeed: expected a number above 0, or null for none".into(),
        ),
        (
            &|path| path["foldpath:maxAcceleration"] = json!("much"),
            "foldpath:maxAcceleration: expected a number".into(),
        ),
        (
            &|path| path["foldpath:edges_group"][hinge] = Value::Null,
            format!("foldpath:edges_group[{hinge}]: expected a group, as the edge is a hinge"),
        ),
        (
            &|path| path["file_frames"][1]["edges_foldAngle"][hinge] = json!(1.0),
            format!("file_frames[1].edges_foldAngle[{hinge}]: expected angle, rate and weight"),
        ),
    ];
    for (edit, message) in cases {
        let mut bad = good.clone();
        edit(&mut bad);
        folder.write("bad.fold", &bad.to_string());
        let answer = folder
            .run("export bad.fold --to traj -o out.traj")
            .with_status(2);
        assert!(answer.begins(&format!("bad.fold: {message}")), "{answer:?}");
        assert!(!folder.names().contains(&"out.traj".to_string()));
    }
    let answer = folder
        .run("export path.fold --to step -o out.step")
        .with_status(2);
    assert!(
        answer
            .stderr
            .contains("[possible values: traj, csv, rust, "),
        "{answer:?}"
    );
}

/// Follows an exported path as a controller does, in `f32`. Every real vertex of the sheet is checked against the
/// closure tolerance of the file. Returns the largest closure residual of a vertex, and that tolerance.
fn followed(name: &str, interpolation: &str) -> [f32; 2] {
    let folder = folder();
    let pattern = format!("{}/{name}.fold", PATTERNS);
    let plan = "--max-speed 30 --max-accel 60 --collision off -o path.fold --interpolation";
    folder.done(&format!("plan {pattern} {plan} {interpolation}"));
    folder.done("export path.fold --to traj -o out.traj");
    let bytes = std::fs::read(folder.path("out.traj")).unwrap();
    let file = TrajectoryFile::read(&bytes).unwrap();

    let pattern = read_pattern(pattern.as_ref()).unwrap().pattern;
    let stars = ReducedStars::of_creases(&pattern);
    let hinges: Vec<_> = file.memberships().collect();
    let (mut spokes, mut ends) = (Vec::new(), Vec::new());
    for star in stars.view().iter() {
        spokes.extend(star.spokes.iter().map(|spoke| {
            let hinge = hinges[spoke.group.index()];
            Spoke {
                group: hinge.group,
                negative: spoke.negative ^ hinge.negative,
                direction: spoke.direction.map(f32::lit),
            }
        }));
        ends.push(u32::try_from(spokes.len()).unwrap());
    }
    let stars = StarsView::new(&spokes, &ends, file.groups()).unwrap();
    let limits: Vec<_> = (0..file.groups())
        .map(|g| file.limits(g).unwrap())
        .collect();
    let sheet = SheetView {
        interpolation: file.interpolation(),
        limits: &limits,
        stars,
        closure: file.closure(),
    };
    let mut follower = Follower::<f32, 4, 64>::new(CheckedOptions::default());
    follower.load(&sheet, FollowerPosition::default()).unwrap();
    for knot in 0..file.len() {
        let nodes = (0..file.groups()).map(|group| file.node(knot, group).unwrap());
        let setpoint = Setpoint {
            number: u32::try_from(knot).unwrap(),
            span: file.span(knot).unwrap(),
            last: knot + 1 == file.len(),
            nodes: nodes.collect(),
        };
        let accepted = follower.accept(&sheet, setpoint);
        assert_eq!(accepted, Ok(()), "{name} {interpolation}: knot {knot}");
    }
    follower.confirm().unwrap();
    follower.start().unwrap();
    let mut worst = 0.0_f32;
    for now in (1..60_000).map(|tick| 1000 * tick) {
        follower.heard(now);
        follower.tick(stars, now);
        for (rate, limits) in follower.rates().iter().zip(&limits) {
            assert!(rate.abs() <= limits.speed, "{name} {interpolation}");
        }
        let mut scratch = [HalfAngle::default(); 4];
        let value = Objective::Max.value(stars, follower.angles(), &mut scratch);
        worst = worst.max(value.unwrap() / 2_f32.sqrt());
        if follower.state() == State::Done {
            return [worst, file.closure()];
        }
    }
    panic!("{name} {interpolation}: {:?}", follower.reason());
}

#[test]
fn a_controller_follows_what_is_exported() {
    for (name, interpolation, closure) in [
        ("miura-11x11", "half-angle", 4e-6),
        ("miura-11x11", "hermite", 1e-4),
        ("waterbomb-8x10", "half-angle", 1e-4),
        ("waterbomb-8x10", "hermite", 1e-4),
    ] {
        let [worst, told] = followed(name, interpolation);
        let fits = worst <= told && told <= closure;
        assert!(fits, "{name} {interpolation}: {worst:e}, {told:e}");
    }
}
