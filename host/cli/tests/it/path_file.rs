//! Tests the path file that `foldpath plan` writes, a FOLD animation with the keys of the contract.

use core::array;
use std::collections::BTreeSet;

use crate::common::folder;
use foldpath_test_support::numbers;
use serde_json::{Value, json};

/// A planned path beside its pattern.
struct Planned {
    name: &'static str,
    pattern: Value,
    path: Value,
}

impl Planned {
    fn frames(&self) -> &[Value] {
        self.path["file_frames"].as_array().unwrap()
    }

    /// Returns for each knot the angles, or rates, of all edges.
    fn knots(&self, key: &str) -> Vec<Vec<f64>> {
        self.frames()
            .iter()
            .map(|frame| numbers(&frame[key]))
            .collect()
    }

    fn list(&self, key: &str) -> &[Value] {
        self.path[key].as_array().unwrap()
    }

    fn times(&self) -> Vec<f64> {
        let times = self.frames().iter().map(|frame| &frame["foldpath:time"]);
        times.map(|time| time.as_f64().unwrap()).collect()
    }
}

/// Plans one path of each family.
fn planned() -> [Planned; 3] {
    planned_with("")
}

fn planned_with(options: &str) -> [Planned; 3] {
    let folder = folder();
    [
        "miura --rows 4 --cols 5",
        "waterbomb --rows 4 --cols 6",
        "yoshimura --rows 4 --cols 4",
    ]
    .map(|name| {
        folder.done(&format!("generate {name} -o pattern.fold"));
        folder.done(&format!("plan pattern.fold -o path.fold {options}"));
        let [pattern, path] = ["pattern.fold", "path.fold"].map(|file| folder.read_json(file));
        Planned {
            name,
            pattern,
            path,
        }
    })
}

fn keys(object: &Value) -> BTreeSet<&str> {
    object
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect()
}

#[test]
fn the_file_is_a_fold_animation_of_the_pattern() {
    for planned in planned() {
        let Planned {
            name,
            pattern,
            path,
        } = &planned;
        assert_eq!(path["file_spec"], 1.2, "{name}");
        assert_eq!(path["file_classes"], json!(["animation"]), "{name}");
        assert_eq!(path["frame_classes"], json!(["creasePattern"]), "{name}");
        let interpolation = path["foldpath:interpolation"].as_str().unwrap();
        assert!(["half-angle", "hermite"].contains(&interpolation), "{name}");
        for key in [
            "vertices_coords",
            "edges_vertices",
            "edges_assignment",
            "file_title",
        ] {
            assert_eq!(path[key], pattern[key], "{name}: {key}");
        }
    }
}

#[test]
fn frames_have_the_keys_of_the_contract() {
    for planned in planned() {
        let vertices = planned.list("vertices_coords").len();
        let edges = planned.list("edges_vertices").len();
        for frame in planned.frames() {
            let required = BTreeSet::from([
                "frame_classes",
                "frame_parent",
                "frame_inherit",
                "vertices_coords",
                "edges_foldAngle",
                "foldpath:time",
                "foldpath:edges_foldAngleRate",
                "foldpath:deformation",
                "foldpath:gap",
                "foldpath:closure",
                "foldpath:clearance",
            ]);
            assert!(
                required.is_subset(&keys(frame)),
                "{}: {frame}",
                planned.name
            );
            assert_eq!(frame["frame_classes"], json!(["foldedForm"]));
            assert_eq!(frame["frame_parent"], 0);
            assert_eq!(frame["frame_inherit"], true);
            let points = frame["vertices_coords"].as_array().unwrap();
            assert_eq!(points.len(), vertices);
            assert!(points.iter().all(|point| numbers(point).len() == 3));
            for key in ["edges_foldAngle", "foldpath:edges_foldAngleRate"] {
                assert_eq!(numbers(&frame[key]).len(), edges);
            }
            for key in ["foldpath:deformation", "foldpath:gap", "foldpath:closure"] {
                assert!(
                    frame[key].as_f64().unwrap() < 1e-9,
                    "{}: {key}",
                    planned.name
                );
            }
        }
    }
}

/// The key frame has the attribute `2D`, which says that all z are 0. Folded frames must not inherit it.
#[test]
fn folded_frames_do_not_inherit_that_they_are_flat() {
    for planned in planned() {
        for frame in planned.frames() {
            let attributes = frame
                .get("frame_attributes")
                .unwrap_or(&planned.path["frame_attributes"]);
            assert_ne!(*attributes, json!(["2D"]), "{}", planned.name);
        }
    }
}

#[test]
fn the_path_goes_from_flat_to_the_goal_in_few_knots() {
    for planned in planned() {
        let name = planned.name;
        let goal = numbers(&planned.pattern["edges_foldAngle"]);
        let knots = planned.knots("edges_foldAngle");
        assert!(knots[0].iter().all(|angle| angle.abs() <= 0.0), "{name}");
        let last = knots[knots.len() - 1].iter().zip(&goal);
        assert!(
            last.clone().all(|(a, b)| (a - b).abs() < 1e-9),
            "{name}: {last:?}"
        );
        assert!(knots.len() <= 12, "{name}: {}", knots.len());
        let times = planned.times();
        assert!(times[0].abs() <= 0.0, "{name}");
        assert!(
            times.windows(2).all(|pair| pair[0] < pair[1]),
            "{name}: {times:?}"
        );
    }
}

#[test]
fn hinges_turn_the_way_of_their_letters() {
    for planned in planned() {
        let signs = planned
            .list("edges_assignment")
            .iter()
            .map(|letter| match letter.as_str() {
                Some("M") => -1.0,
                Some("V") => 1.0,
                other => {
                    assert_eq!(other, Some("B"));
                    0.0
                }
            });
        for angles in &planned.knots("edges_foldAngle")[1..] {
            for (edge, (angle, sign)) in angles.iter().zip(signs.clone()).enumerate() {
                let turns = angle * sign > 0.0;
                assert!(
                    turns || (sign == 0.0 && *angle == 0.0),
                    "{}: {edge} {angle}",
                    planned.name
                );
            }
        }
    }
}

#[test]
fn groups_and_signs_give_all_angles_and_rates() {
    for planned in planned() {
        let [groups, signs] =
            ["foldpath:edges_group", "foldpath:edges_sign"].map(|k| planned.list(k));
        let letters = planned.list("edges_assignment");
        assert_eq!((groups.len(), signs.len()), (letters.len(), letters.len()));
        for ((group, sign), letter) in groups.iter().zip(signs).zip(letters) {
            let crease = letter != "B";
            assert_eq!(group.is_u64(), crease, "{}", planned.name);
            assert_eq!(
                sign.as_i64().unwrap().abs(),
                i64::from(crease),
                "{}",
                planned.name
            );
        }
        for key in ["edges_foldAngle", "foldpath:edges_foldAngleRate"] {
            for values in planned.knots(key) {
                let mut of_group = std::collections::BTreeMap::new();
                for ((value, group), sign) in values.iter().zip(groups).zip(signs) {
                    let (Some(group), Some(sign)) = (group.as_u64(), sign.as_f64()) else {
                        continue;
                    };
                    let first = *of_group.entry(group).or_insert(value * sign);
                    assert!(
                        (first - value * sign).abs() <= 0.0,
                        "{}: group {group}",
                        planned.name
                    );
                }
            }
        }
    }
}

/// The trapezoidal rule over the rates gives the angles, up to the error of the rule within a step.
#[test]
fn rates_are_degrees_per_second() {
    for planned in planned_with("--interpolation hermite --bound 1e-7") {
        let (angles, rates) = (
            planned.knots("edges_foldAngle"),
            planned.knots("foldpath:edges_foldAngleRate"),
        );
        for (knot, times) in planned.times().windows(2).enumerate() {
            let seconds = times[1] - times[0];
            for edge in 0..angles[knot].len() {
                let turned = angles[knot + 1][edge] - angles[knot][edge];
                let expected = seconds * (rates[knot][edge] + rates[knot + 1][edge]) / 2.0;
                let name = planned.name;
                assert!(
                    (turned - expected).abs() < 0.1,
                    "{name}: {knot} {edge}: {turned} {expected}"
                );
            }
        }
    }
}

#[test]
fn edges_keep_their_length_in_the_units_of_the_key_frame() {
    let point = |points: &Value, vertex: usize| -> [f64; 3] {
        let point = numbers(&points[vertex]);
        array::from_fn(|k| point.get(k).copied().unwrap_or(0.0))
    };
    let length = |points: &Value, ends: &Value| -> f64 {
        let [a, b] = [0, 1].map(|k| usize::try_from(ends[k].as_u64().unwrap()).unwrap());
        let [a, b] = [a, b].map(|end| point(points, end));
        (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
    };
    for planned in planned() {
        for ends in planned.list("edges_vertices") {
            let flat = length(&planned.path["vertices_coords"], ends);
            for (knot, frame) in planned.frames().iter().enumerate() {
                let folded = length(&frame["vertices_coords"], ends);
                assert!(
                    (folded / flat - 1.0).abs() < 1e-9,
                    "{}: {knot} {ends}",
                    planned.name
                );
            }
        }
    }
}

/// A square with flaps of several lengths. At the tip of a long flap, every error of an angle is large.
#[test]
fn slender_panels_are_where_their_angles_have_them() {
    let folder = folder();
    for [length, height] in [[1e2, 157.0], [1e3, 0.0], [2e4, -1e4], [3e6, 4e6]] {
        let flap = json!({
            "file_spec": 1.2,
            "vertices_coords": [[0, 0], [1, 0], [length, height], [1, 1], [0, 1]],
            "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 0], [1, 3]],
            "edges_assignment": ["B", "B", "B", "B", "B", "V"],
            "edges_foldAngle": [0, 0, 0, 0, 0, 117],
        });
        folder.write("flap.fold", &flap.to_string());
        folder.done("plan flap.fold -o path.fold");
        folder.done("check path.fold");
    }
}
