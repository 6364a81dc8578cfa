//! Does `check` believe what a file says of its motion? Each claim is spoilt, and hinges turn against their letter where
//! it is hard to see.

use foldpath::check::{Outcome, check};
use foldpath::planner::PlanOptions;
use foldpath_core::Interpolation;
use foldpath_tests::{Planned, Random, path_file, strict};
use serde_json::{Value, json};

/// Returns what a check finds against a path.
fn findings(path: &Value) -> Vec<String> {
    check(&path_file(&path.to_string()).unwrap(), &strict()).findings()
}

fn planned(interpolation: Interpolation, acceleration: Option<f64>) -> Value {
    let options = PlanOptions::default().with(|it| {
        it.interpolation = Some(interpolation);
        it.max_acceleration = acceleration;
        it.bound = strict().bound;
    });
    serde_json::from_str(&Planned::new("miura-5x5", &options).text()).unwrap()
}

/// A way to spoil a claim.
type Spoil = fn(&mut Value);

#[test]
fn claims_of_a_file_are_judged() {
    let good = planned(Interpolation::Hermite, Some(2.0));
    assert_eq!(findings(&good), [""; 0]);
    let cases: [(Spoil, &str); 5] = [
        (
            |path| path["foldpath:maxSpeed"] = json!(10.0),
            "the file claims a largest speed of 1.000e1 degrees per second, but it is ",
        ),
        (
            |path| path["foldpath:maxAcceleration"] = json!(10.0),
            "the file claims a largest acceleration of 1.000e1 degrees per second squared, but it is ",
        ),
        (
            |path| path["file_frames"][1]["foldpath:clearance"] = json!(1e3),
            "knot 1: the file claims a clearance of 1.000e3, but it is ",
        ),
        (
            |path| path["foldpath:bound"] = json!(1e-20),
            "the file says that it was planned within the bound 1.000e-20, but has errors of ",
        ),
        // Without signs, mountains and valleys of a group would turn alike.
        (
            |path| {
                path.as_object_mut().unwrap().remove("foldpath:edges_sign");
            },
            "are in group ",
        ),
    ];
    for (spoil, words) in cases {
        let mut path = good.clone();
        spoil(&mut path);
        let found = findings(&path);
        let said = found.iter().any(|finding| finding.contains(words));
        assert!(said, "{words}: {found:?}");
    }
}

/// Claims that are true hold: of a speed and a distance, and of groups whose hinges all turn the same way.
#[test]
fn true_claims_hold() {
    let mut path = planned(Interpolation::Hermite, Some(2.0));
    let judged = check(&path_file(&path.to_string()).unwrap(), &strict());
    path["foldpath:maxSpeed"] = json!(judged.rates.speed.to_degrees());
    let acceleration = judged.rates.acceleration.expect("begins and ends at rest");
    path["foldpath:maxAcceleration"] = json!(acceleration.to_degrees());
    path["file_frames"][1]["foldpath:clearance"] = json!(1e-9);
    assert_eq!(findings(&path), [""; 0]);
    // A path that is not called planned does not claim to keep the bound.
    path["foldpath:bound"] = json!(1e-20);
    path["foldpath:outcome"] = json!("not_rigidly_foldable");
    assert_eq!(findings(&path), [""; 0]);
}

/// A hinge that turns evenly from knot to knot changes its speed at once, so that no linear motion claims a largest
/// acceleration, and a claim of one is false.
#[test]
fn no_linear_motion_has_a_largest_acceleration() {
    let mut path = planned(Interpolation::Linear, Some(2.0));
    assert_eq!(findings(&path), [""; 0]);
    let judged = check(&path_file(&path.to_string()).unwrap(), &strict());
    assert_eq!(judged.rates.acceleration, None);
    path["foldpath:maxAcceleration"] = json!(1e6);
    let found = findings(&path);
    assert!(
        found[0].ends_with("hinges change their speed at once"),
        "{found:?}"
    );
}

/// Two panels whose hinge, lettered V, has a weight that falls from 1 to almost nothing. The sine of its half angle is
/// never below -1e-10, but nor is the cosine far from 0, so that the hinge swings far to the mountain side.
#[test]
fn a_hinge_whose_weights_nearly_vanish_is_seen_to_turn_against_its_letter() {
    let mut random = Random::new(5);
    for _ in 0..200 {
        let steep = random.uniform(2.9, 3.0);
        let back = 10.0_f64.powf(-random.uniform(5.0, 8.0));
        let last = 10.0_f64.powf(-random.uniform(15.0, 20.0));
        let frame = |time: f64, rate: f64, weight: f64, grows: f64| {
            let hinge = |value: f64, other: f64| {
                let mut list = vec![other; 7];
                list[5] = value;
                list
            };
            json!({
                "frame_classes": ["foldedForm"],
                "frame_parent": 0,
                "frame_inherit": true,
                "foldpath:time": time,
                "edges_foldAngle": vec![0.0; 7],
                "foldpath:edges_foldAngleRate": hinge(rate, 0.0),
                "foldpath:edges_weight": hinge(weight, 1.0),
                "foldpath:edges_weightRate": hinge(grows, 0.0),
            })
        };
        let mut path = json!({
            "file_spec": 1.2,
            "file_classes": ["animation"],
            "frame_classes": ["creasePattern"],
            "vertices_coords": [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]],
            "edges_vertices": [[0, 1], [1, 2], [4, 3], [5, 4], [0, 3], [1, 4], [2, 5]],
            "edges_assignment": ["B", "B", "B", "B", "B", "V", "B"],
            "faces_vertices": [[0, 1, 4, 3], [1, 2, 5, 4]],
            "foldpath:interpolation": "homogeneous",
            "file_frames": [frame(0.0, -back, 1.0, -steep), frame(1.0, back / last, last, 0.0)],
        });
        let verdict = check(&path_file(&path.to_string()).unwrap(), &strict());
        assert_eq!(verdict.outcome(), Outcome::Fails, "{path}");
        let found = verdict.findings();
        let against = |finding: &String| finding.contains("edge 5 is lettered V, but turns to -");
        assert!(found.iter().any(against), "{found:?}");
        // Lettered M, the hinge may turn like this. Its angle is not known where the weight is too small.
        path["edges_assignment"][5] = json!("M");
        let verdict = check(&path_file(&path.to_string()).unwrap(), &strict());
        assert_ne!(verdict.outcome(), Outcome::Fails, "{path}");
    }
}
