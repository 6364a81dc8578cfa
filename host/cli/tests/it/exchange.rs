//! Tests the exports for robots and physics engines: rows at a fixed rate, ROS's trajectories, models of MuJoCo.

use core::f64::consts::PI;
use std::collections::HashMap;

use crate::common::{PATTERNS, folder, folder_with_path};
use foldpath::motion::Motion;
use foldpath::pattern::EdgeId;
use foldpath::read::fold::read_motion;
use foldpath_test_support::Folder;

fn motion(folder: &Folder, name: &str) -> Motion {
    read_motion(&folder.path(name)).unwrap()
}

/// Returns the fold angle (radians) of an edge at a time, by the curve of its segment.
fn angle(motion: &Motion, edge: usize, time: f64) -> f64 {
    let knots = &motion.knots;
    let segment = knots.windows(2).position(|pair| time <= pair[1].time);
    let segment = segment.unwrap_or(knots.len() - 2);
    let [from, to] = [segment, segment + 1].map(|knot| knots[knot].time);
    let curve = motion.curve(segment, EdgeId::new(edge));
    curve.angle(((time - from) / (to - from)).min(1.0))
}

/// Returns the header and the rows of a CSV file.
fn rows(text: &str) -> (Vec<&str>, Vec<Vec<f64>>) {
    let mut lines = text.lines();
    let header = lines.next().unwrap().split(',').collect();
    let numbers = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
    (header, lines.map(numbers).collect())
}

#[test]
fn rows_at_a_rate_show_every_hinge_or_group() {
    let folder = folder_with_path();
    let path = motion(&folder, "path.fold");
    let end = path.knots.last().unwrap().time;
    folder.done("export path.fold --to csv --rate 25 -o hinges.csv");
    let text = folder.read("hinges.csv");
    let (header, hinges) = rows(&text);
    let creases = path.pattern.creases().iter();
    let expected = creases.map(|edge| format!("edge_{edge}"));
    let expected: Vec<String> = ["t".to_string()].into_iter().chain(expected).collect();
    assert_eq!(header, expected);
    for (index, row) in hinges.iter().enumerate() {
        let last = index + 1 == hinges.len();
        let time = if last { end } else { index as f64 / 25.0 };
        assert!((row[0] - time).abs() < 1e-12, "{index}: {}", row[0]);
        for (degrees, edge) in row[1..].iter().zip(path.pattern.creases()) {
            let expected = angle(&path, edge.index(), time).to_degrees();
            assert!((degrees - expected).abs() < 1e-11, "{time} s, edge {edge}");
        }
    }
    // All rows at the rate before the end are there, and one for the end.
    let before_last = (hinges.len() - 2) as f64 / 25.0;
    assert!(before_last < end && end <= before_last + 1.0 / 25.0);

    folder.done("export path.fold --to csv --rate 25 --per group -o groups.csv");
    let text = folder.read("groups.csv");
    let (header, groups) = rows(&text);
    assert_eq!(header, ["t", "group_0", "group_1"]);
    for (row, hinges) in groups.iter().zip(&hinges) {
        for (edge, degrees) in path.pattern.creases().iter().zip(&hinges[1..]) {
            let member = path.members[edge.index()].unwrap();
            let of_group = member.apply(row[1 + member.group.index()]);
            assert!((of_group - degrees).abs() < 1e-11);
        }
    }
    // The end is one row, also where it lies on the grid but for rounding.
    folder.done(&format!(
        "export path.fold --to csv --rate {} -o few.csv",
        10.0 / end
    ));
    assert_eq!(folder.read("few.csv").lines().count(), 12);
    // Start and end are there however low the rate is.
    folder.done("export path.fold --to csv --rate 1e-9 -o ends.csv");
    let text = folder.read("ends.csv");
    let (_, ends) = rows(&text);
    assert_eq!(ends, [hinges[0].clone(), hinges[hinges.len() - 1].clone()]);
}

/// A point of a trajectory as its YAML has it.
struct Point {
    time: f64,
    positions: Vec<f64>,
    velocities: Vec<f64>,
}

/// Reads the YAML that the command writes: the names of the joints and the points.
fn trajectory(text: &str) -> (Vec<String>, Vec<Point>) {
    let numbers = |list: &str| -> Vec<f64> {
        let inner = list
            .trim()
            .strip_prefix('[')
            .unwrap()
            .strip_suffix(']')
            .unwrap();
        let numbers = inner.split(", ").filter(|number| !number.is_empty());
        numbers
            .map(|number| {
                assert!(
                    number.contains('.') && !number.contains('e'),
                    "{number} is no YAML 1.1 float"
                );
                number.parse().unwrap()
            })
            .collect()
    };
    let (mut joints, mut points) = (Vec::new(), Vec::new());
    for line in text.lines() {
        if let Some(list) = line.strip_prefix("- positions:") {
            let positions = numbers(list);
            points.push(Point {
                time: 0.0,
                positions,
                velocities: Vec::new(),
            });
        } else if let Some(list) = line.strip_prefix("  velocities:") {
            points.last_mut().unwrap().velocities = numbers(list);
        } else if let Some(time) = line.strip_prefix("  time_from_start: {sec: ") {
            let (sec, nanosec) = time
                .strip_suffix('}')
                .unwrap()
                .split_once(", nanosec: ")
                .unwrap();
            let [sec, nanosec]: [u32; 2] = [sec, nanosec].map(|n| n.parse().unwrap());
            assert!(nanosec < 1_000_000_000);
            points.last_mut().unwrap().time = f64::from(sec) + 1e-9 * f64::from(nanosec);
        } else if let Some(joint) = line.strip_prefix("- ") {
            joints.push(joint.to_string());
        }
    }
    (joints, points)
}

/// Returns the positions of all joints at a time as ROS's joint trajectory controller has them: between two points with
/// velocities it moves along the cubic with the coefficients of its `generate_powers`, and otherwise along a line.
fn followed(points: &[Point], time: f64) -> Vec<f64> {
    let after = points
        .partition_point(|point| point.time <= time)
        .clamp(1, points.len() - 1);
    let [a, b] = [&points[after - 1], &points[after]];
    let (span, t) = (b.time - a.time, time - a.time);
    let joints = 0..a.positions.len();
    let position = |joint: usize| {
        let (p, q) = (a.positions[joint], b.positions[joint]);
        if a.velocities.is_empty() {
            return p + t / span * (q - p);
        }
        let (v, w) = (a.velocities[joint], b.velocities[joint]);
        let square = (-3.0 * p + 3.0 * q - 2.0 * v * span - w * span) / span.powi(2);
        let cube = (2.0 * p - 2.0 * q + v * span + w * span) / span.powi(3);
        p + t * (v + t * (square + t * cube))
    };
    joints.map(position).collect()
}

/// Returns the largest difference (radians) between a trajectory as it is followed and the motion, at times between all
/// points.
fn difference(folder: &Folder, path: &str, yaml: &str) -> f64 {
    let motion = motion(folder, path);
    let text = folder.read(yaml);
    let (joints, points) = trajectory(&text);
    let creases = motion.pattern.creases();
    let names: Vec<String> = creases
        .iter()
        .map(|edge| format!("crease_{edge}"))
        .collect();
    assert_eq!(joints, names);
    assert!(points.windows(2).all(|pair| pair[0].time < pair[1].time));
    let mut worst = 0.0_f64;
    for pair in points.windows(2) {
        for part in 0..=11 {
            let time = pair[0].time + f64::from(part) / 11.0 * (pair[1].time - pair[0].time);
            let followed = followed(&points, time);
            for (edge, found) in creases.iter().zip(followed) {
                worst = worst.max((found - angle(&motion, edge.index(), time)).abs());
            }
        }
    }
    worst
}

/// Rounds the times of a path's knots to whole nanoseconds, which a trajectory of ROS can tell exactly.
fn with_whole_nanoseconds(folder: &Folder, from: &str, to: &str) {
    let mut document = folder.read_json(from);
    for frame in document["file_frames"].as_array_mut().unwrap() {
        let time = frame["foldpath:time"].as_f64().unwrap();
        frame["foldpath:time"] = ((time * 1e9).round() / 1e9).into();
    }
    folder.write(to, &document.to_string());
}

#[test]
fn ros_follows_a_hermite_motion_exactly() {
    let folder = folder();
    for (name, options) in [
        ("miura-3x3", "--max-accel 90"),
        ("waterbomb-4x6", ""),
        ("square-twist-1x1", "--max-accel 200"),
    ] {
        folder.done(&format!(
            "plan {PATTERNS}/{name}.fold --interpolation hermite {options} -o path.fold"
        ));
        with_whole_nanoseconds(&folder, "path.fold", "whole.fold");
        let said = folder
            .done("export whole.fold --to joint-trajectory -o a.yaml")
            .stdout;
        assert!(said.contains("exact"), "{said}");
        let error = difference(&folder, "whole.fold", "a.yaml");
        assert!(error < 1e-12, "{name}: {error:e}");
        // Times in general are rounded, which the file says.
        folder.done("export path.fold --to joint-trajectory -o a.yaml");
        let error = difference(&folder, "path.fold", "a.yaml");
        let told = rounding(&folder.read("a.yaml"));
        assert!(
            error < 1.1 * told + 1e-12 && told < 1e-9,
            "{name}: {error:e} {told:e}"
        );
    }
}

/// Returns the bounds that a trajectory states: of resampling, and of rounding the times.
fn stated(text: &str) -> [f64; 2] {
    let line = text
        .lines()
        .find(|line| line.contains("Resampling"))
        .unwrap();
    let words = line
        .split_whitespace()
        .filter_map(|word| word.trim_end_matches('.').parse().ok());
    words.collect::<Vec<f64>>().try_into().unwrap()
}

fn rounding(text: &str) -> f64 {
    stated(text)[1]
}

#[test]
fn ros_follows_other_motions_within_the_error_told() {
    let folder = folder();
    for kind in ["half-angle", "homogeneous", "linear"] {
        folder.done(&format!(
            "plan {PATTERNS}/miura-3x3.fold --interpolation {kind} -o path.fold"
        ));
        folder.done("export path.fold --to joint-trajectory -o a.yaml");
        let error = difference(&folder, "path.fold", "a.yaml");
        let [resampling, rounding] = stated(&folder.read("a.yaml"));
        assert!(resampling <= 1e-6, "{kind}: {resampling:e}");
        assert_eq!(kind == "linear", resampling <= 0.0, "{kind}");
        // The error is measured at 16 places of each cubic, and printed with two digits.
        let told = 1.1 * (resampling + rounding) + 1e-12;
        assert!(error <= told, "{kind}: {error:e} {told:e}");
    }
}

#[test]
fn a_trajectory_names_its_title_and_ends_where_the_path_does() {
    let folder = folder_with_path();
    folder.done("export path.fold --to joint-trajectory -o a.yaml");
    let text = folder.read("a.yaml");
    assert!(
        text.starts_with("# trajectory_msgs/JointTrajectory of Miura 3x3\n"),
        "{text}"
    );
    let (_, points) = trajectory(&text);
    let path = motion(&folder, "path.fold");
    let [start, end] = [&points[0], points.last().unwrap()];
    assert!(start.time.abs() < 1e-12 && (end.time - path.knots.last().unwrap().time).abs() < 1e-9);
    // Knots at the same nanosecond cannot be told apart.
    let mut document = folder.read_json("path.fold");
    document["file_frames"][1]["foldpath:time"] = 1e-11.into();
    folder.write("fast.fold", &document.to_string());
    let refused = folder
        .run("export fast.fold --to joint-trajectory -o b.yaml")
        .with_status(2);
    assert!(
        refused.begins("fast.fold: foldpath:time: expected knots that are at least a nanosecond"),
        "{refused:?}"
    );
    assert!(!folder.path("b.yaml").exists());
}

#[test]
fn a_trajectory_that_ends_in_motion_says_so() {
    let folder = folder();
    for (options, rests) in [("", false), ("--max-accel 90", true)] {
        folder.done(&format!(
            "plan {PATTERNS}/miura-3x3.fold {options} -o path.fold"
        ));
        let said = folder
            .done("export path.fold --to joint-trajectory -o a.yaml")
            .stderr;
        let (_, points) = trajectory(&folder.read("a.yaml"));
        let speeds = points.last().unwrap().velocities.iter();
        let fastest = speeds.fold(0.0_f64, |most, speed| most.max(speed.abs()));
        assert_eq!(fastest < 1e-7, rests, "{fastest:e}");
        let note = format!("ends at {fastest:.1e} radians per second");
        assert_eq!(said.contains(&note), !rests, "{said}");
        folder.done("export path.fold --to ros2-control -o b.yaml");
        let line = format!("allow_nonzero_velocity_at_trajectory_end: {}\n", !rests);
        assert!(folder.read("b.yaml").contains(&line));
    }
    // Straight lines have no velocities, and the controller takes them.
    folder.done(&format!(
        "plan {PATTERNS}/miura-3x3.fold --interpolation linear -o path.fold"
    ));
    let said = folder.done("export path.fold --to joint-trajectory -o a.yaml");
    assert!(!said.stderr.contains("ends at"), "{}", said.stderr);
}

/// The joints are those asked for, by the names of the file, and move as they do in the trajectory of all hinges.
#[test]
fn joints_are_the_drivers_and_have_the_names_given() {
    let folder = folder_with_path();
    folder.done("export path.fold --to joint-trajectory -o all.yaml");
    let (all, whole) = trajectory(&folder.read("all.yaml"));
    let info = folder.done("info miura.fold --json").stdout;
    let info: serde_json::Value = serde_json::from_str(&info).unwrap();
    let drivers = info["drivers"].as_array().unwrap().iter();
    let drivers: Vec<String> = drivers.map(|edge| format!("crease_{edge}")).collect();
    assert!(!drivers.is_empty() && drivers.len() < all.len());
    folder.done("export path.fold --to joint-trajectory --joints drivers -o a.yaml");
    let (joints, points) = trajectory(&folder.read("a.yaml"));
    assert_eq!(joints, drivers);
    let names: Vec<String> = (0..all.len())
        .map(|hinge| format!("arm.{hinge}/on-y_"))
        .collect();
    folder.write(
        "names.txt",
        &format!("# the joints\n\n{}\n", names.join(" # one\n")),
    );
    folder.done(
        "export path.fold --to joint-trajectory --names names.txt --joints drivers -o b.yaml",
    );
    let (named, same) = trajectory(&folder.read("b.yaml"));
    folder.done("export path.fold --to ros2-control --names names.txt --joints drivers -o c.yaml");
    let controllers = folder.read("c.yaml");
    assert!(
        controllers.contains(&format!("    joints: [{}]\n", named.join(", "))),
        "{controllers}"
    );
    for (at, joint) in joints.iter().enumerate() {
        let hinge = all.iter().position(|name| name == joint).unwrap();
        assert_eq!(named[at], format!("'{}'", names[hinge]));
        for ((point, same), whole) in points.iter().zip(&same).zip(&whole) {
            for (found, expected) in [
                (&point.positions, &whole.positions),
                (&same.positions, &whole.positions),
                (&point.velocities, &whole.velocities),
            ] {
                assert!((found[at] - expected[hinge]).abs() <= 0.0);
            }
        }
    }
    for (text, complaint) in [
        (
            "a\n\na\n",
            "names.txt: line 3: expected another name, found a, as in line 1",
        ),
        (
            "a\nb c\n",
            "names.txt: line 2: expected a name of letters, digits and _ - . /, found b c",
        ),
        (
            "a\nb\n",
            "names.txt: the file: expected 12 names, one for each hinge, found 2",
        ),
        (
            &*(names.join("\n") + "\nmore"),
            "names.txt: line 13: expected 12 names, one for each hinge, found one more, more",
        ),
    ] {
        folder.write("names.txt", text);
        let refused = folder
            .run("export path.fold --to joint-trajectory --names names.txt -o d.yaml")
            .with_status(2);
        assert!(refused.begins(complaint), "{refused:?}");
        assert!(!folder.path("d.yaml").exists());
    }
    folder
        .run("export path.fold --to csv --names names.txt -o d.csv")
        .with_status(2);
}

/// Returns the values of an attribute in all elements of a kind.
fn attributes<'a>(scene: &'a str, element: &str, attribute: &str) -> Vec<&'a str> {
    let (element, attribute) = (format!("<{element} "), format!(" {attribute}=\""));
    let elements = scene
        .split('<')
        .map(|part| (part.len(), part))
        .filter_map(|(_, part)| {
            let part = part.strip_prefix(&element[1..])?;
            let found = part
                .find(&attribute)
                .map(|at| &part[at + attribute.len()..]);
            let found = found.or_else(|| part.strip_prefix(&attribute[1..]))?;
            found.split_once('"').map(|(value, _)| value)
        });
    elements.collect()
}

/// Returns the volume of a mesh in Wavefront OBJ, whose faces must be triangles that enclose it: each side of a triangle
/// is that of one other triangle, the other way round.
fn volume(text: &str) -> f64 {
    let of = |kind: &'static str| {
        let lines = text.lines().filter_map(move |line| line.strip_prefix(kind));
        lines.map(|line| line.split_whitespace().collect::<Vec<&str>>())
    };
    let place = |words: Vec<&str>| {
        let numbers: Vec<f64> = words.iter().map(|word| word.parse().unwrap()).collect();
        nalgebra::Vector3::from_column_slice(&numbers)
    };
    let places: Vec<nalgebra::Vector3<f64>> = of("v ").map(place).collect();
    let mut sides: HashMap<[usize; 2], i32> = HashMap::new();
    let mut volume = 0.0;
    for face in of("f ") {
        let corners: Vec<usize> = face
            .iter()
            .map(|corner| corner.parse::<usize>().unwrap() - 1)
            .collect();
        assert_eq!(corners.len(), 3);
        for k in 0..3 {
            let side = [corners[k], corners[(k + 1) % 3]];
            *sides.entry(side).or_default() += 1;
        }
        let [a, b, c] = [0, 1, 2].map(|k| places[corners[k]]);
        volume += a.dot(&b.cross(&c)) / 6.0;
    }
    assert!(
        sides
            .iter()
            .all(|(&[a, b], &count)| count == 1 && sides.get(&[b, a]) == Some(&1))
    );
    volume
}

#[test]
fn a_model_of_mujoco_has_a_body_for_each_panel_and_a_joint_or_loop_for_each_crease() {
    let folder = folder();
    // Resch's pattern has panels of several faces or none; a cut sheet has faces with hinges that are not lettered.
    for name in [
        "miura-3x3",
        "square-twist-1x1",
        "waterbomb-4x6",
        "resch-3x3",
    ] {
        folder.done(&format!("plan {PATTERNS}/{name}.fold -o path.fold"));
        folder.done("export path.fold --to mjcf -o model");
        let path = motion(&folder, "path.fold");
        let scene = folder.read("model/scene.xml");
        let bodies = attributes(&scene, "body", "name");
        let joints = attributes(&scene, "joint", "name");
        let loops = attributes(&scene, "connect", "name");
        assert_eq!(joints.len() + 1, bodies.len(), "{name}: one tree");
        assert_eq!(
            joints.len() + loops.len() / 2,
            path.pattern.creases().len(),
            "{name}"
        );
        assert_eq!(
            scene.matches("<body").count(),
            scene.matches("</body>").count()
        );
        let keys = attributes(&scene, "key", "qpos");
        let names = attributes(&scene, "key", "name");
        // One for each knot, and one a little off flat.
        assert_eq!(keys.len(), path.knots.len() + 1);
        assert_eq!(names[path.knots.len()], "start");
        for (knot, key) in keys.iter().take(path.knots.len()).enumerate() {
            for (joint, angle) in joints.iter().zip(key.split(' ')) {
                let edge: usize = joint.strip_prefix("crease_").unwrap().parse().unwrap();
                let expected = path.node(knot, EdgeId::new(edge)).angle;
                let angle: f64 = angle.parse().unwrap();
                assert!(
                    (angle - expected).abs() < 1e-15 && angle.abs() <= PI,
                    "{name}: {joint}"
                );
            }
        }
        let actuators = attributes(&scene, "position", "joint");
        assert!(!actuators.is_empty() && actuators.iter().all(|joint| joints.contains(joint)));
        // The model has as many actuators as `info` names drivers. The choice may differ, because several would do.
        let info = folder
            .done(&format!("info {PATTERNS}/{name}.fold --json"))
            .json();
        assert_eq!(
            actuators.len(),
            info["drivers"].as_array().unwrap().len(),
            "{name}"
        );

        let meshes = attributes(&scene, "mesh", "file");
        assert_eq!(meshes.len(), bodies.len());
        let volumes: f64 = meshes
            .iter()
            .map(|mesh| volume(&folder.read(&format!("model/{mesh}"))))
            .sum();
        let places = path.pattern.vertices();
        let areas = path.pattern.triangles().items().iter().map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| places[vertex.index()]);
            (b - a).perp(&(c - a)) / 2.0
        });
        let expected = areas.sum::<f64>() * 0.002 * path.pattern.median_edge();
        assert!(
            (volumes / expected - 1.0).abs() < 1e-9,
            "{name}: {volumes} {expected}"
        );
    }
}

/// Faces that are joined by an edge that stays flat are one panel, and a title may have any characters.
#[test]
fn a_model_has_one_panel_for_faces_that_stay_flat() {
    let folder = folder();
    let sheet = serde_json::json!({
        "file_title": "<\"a\" & b>",
        "vertices_coords": [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4], [0, 4]],
        "edges_assignment": ["B", "B", "B", "B", "B", "B", "V", "F"],
    });
    folder.write("sheet.fold", &sheet.to_string());
    folder.done("plan sheet.fold --fold 0.5 -o path.fold");
    folder.done("export path.fold --to mjcf -o model/");
    let scene = folder.read("model/scene.xml");
    assert_eq!(attributes(&scene, "body", "name").len(), 2);
    assert_eq!(attributes(&scene, "joint", "name"), ["crease_6"]);
    assert_eq!(attributes(&scene, "connect", "name").len(), 0);
    assert!(
        scene.contains("<mujoco model=\"&lt;&quot;a&quot; &amp; b&gt;\">"),
        "{scene}"
    );
    assert_eq!(folder.names(), ["model", "path.fold", "sheet.fold"]);
    let volumes = attributes(&scene, "mesh", "file")
        .into_iter()
        .map(|mesh| volume(&folder.read(&format!("model/{mesh}"))));
    let volumes: Vec<f64> = volumes.collect();
    assert!(
        volumes.iter().all(|volume| (volume - 0.002).abs() < 1e-12),
        "{volumes:?}"
    );
}
