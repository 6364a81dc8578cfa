//! Does `check` find what is wrong between knots although every knot is good? The motion is driven through all of its
//! configurations, so that good knots are not enough.

use foldpath::certificate::SegmentCertifier;
use foldpath::check::{CheckOptions, Verdict, check};
use foldpath::planner::PlanOptions;
use foldpath::symmetry::{CreaseGroups, ReducedStars};
use foldpath_core::{Curve, Interpolation, Membership};
use foldpath_tests::closed_form::{Waterbomb, miura_straight};
use foldpath_tests::{HandKnot, HandMade, Motion, Planned, Sheet, path_file, strict, worst};
use serde_json::{Value, json};

const KINDS: [&str; 4] = ["linear", "hermite", "half-angle", "homogeneous"];

fn verdict(path: &Value, options: &CheckOptions) -> Verdict {
    let mut path = path.clone();
    // The motions of these tests are spoilt, and not only faster than the file claims.
    for claim in ["foldpath:maxSpeed", "foldpath:maxAcceleration"] {
        path.as_object_mut().unwrap().remove(claim);
    }
    check(&path_file(&path.to_string()).unwrap(), options)
}

/// Returns the verdict on the whole motion. Asserts that the knots alone are good.
#[track_caller]
fn failures(path: &Value) -> Verdict {
    let knots_alone = CheckOptions::knots_alone(strict().bound);
    assert_eq!(verdict(path, &knots_alone).findings(), [""; 0]);
    verdict(path, &strict())
}

/// Returns the planned path of a pattern, with rates.
fn planned(name: &str) -> Value {
    let options = PlanOptions::default().with(|it| {
        it.interpolation = Some(Interpolation::Hermite);
        it.bound = 1e-3;
    });
    serde_json::from_str(&Planned::new(name, &options).text()).unwrap()
}

fn frames(path: &mut Value) -> &mut Vec<Value> {
    path["file_frames"].as_array_mut().unwrap()
}

/// Replaces the kind of motion between the knots. Weights differ from knot to knot, and have rates.
fn interpolated(mut path: Value, kind: &str) -> Value {
    path["foldpath:interpolation"] = json!(kind);
    if kind == "homogeneous" {
        for (knot, frame) in frames(&mut path).iter_mut().enumerate() {
            let edges = frame["edges_foldAngle"].as_array().unwrap().len();
            let weight = 1.0 + 0.1 * f64::from(u8::try_from(knot % 3).unwrap());
            frame["foldpath:edges_weight"] = json!(vec![weight; edges]);
            frame["foldpath:edges_weightRate"] = json!(vec![0.01; edges]);
        }
    }
    path
}

/// Keeps every n-th knot of a path, and the last one.
fn thinned(mut path: Value, n: usize) -> Value {
    let knots = frames(&mut path);
    let last = knots.len() - 1;
    let kept = knots.iter().enumerate();
    let kept = kept.filter(|(index, _)| index % n == 0 || *index == last);
    *knots = kept.map(|(_, knot)| knot.clone()).collect();
    path
}

/// The certificate of a segment is never below the residual at 1,000 points of it, by the format's formulas and
/// products of rotations, and not far above it.
#[test]
fn certificates_hold_what_is_sampled() {
    let bound = 10.0;
    for name in [
        "kresling-2x6",
        "miura-5x5",
        "resch-3x3",
        "square-twist-3x3",
        "waterbomb-4x6",
        "waterbomb-8x10",
        "yoshimura-12x12",
    ] {
        let path = planned(name);
        if path["file_frames"].as_array().unwrap().len() < 2 {
            continue;
        }
        for kind in KINDS {
            let last = path["file_frames"].as_array().unwrap().last().unwrap();
            let half_turn = |angle: &Value| angle.as_f64().unwrap().abs() >= 180.0;
            let flat_folded = last["edges_foldAngle"]
                .as_array()
                .unwrap()
                .iter()
                .any(half_turn);
            if kind == "half-angle" && flat_folded {
                continue;
            }
            let path = interpolated(thinned(path.clone(), 3), kind);
            let options = strict().with(|it| it.bound = bound);
            let found = verdict(&path, &options).segments;
            let (motion, sheet) = (Motion::of(&path).unwrap(), Sheet::of(&path).unwrap());
            let stars = sheet.stars();
            assert_eq!(found.len(), motion.segments());
            for (segment, found) in found.iter().enumerate() {
                let place = |k: u32| f64::from(k) / 1000.0;
                let closure = |k| sheet.closure_round(&stars, &motion.angles(segment, place(k)));
                let sampled = worst((0..=1000).map(closure));
                let at = format!("{name}, {kind}, segment {segment}: {sampled:e} {found:?}");
                assert!(sampled <= found.bound, "{at}");
                assert!(found.sampled <= found.bound, "{at}");
                assert!(found.bound <= 3.0 * sampled + 1e-10, "{at}");
                assert!(found.samples <= 1024, "{at}");
            }
        }
    }
}

/// The planner's certificate and that of `check` bound the residual in two different ways. Neither is below the samples
/// of the other, and both are near them.
#[test]
fn both_certificates_agree() {
    for name in [
        "miura-5x5",
        "resch-3x3",
        "square-twist-3x3",
        "waterbomb-4x6",
    ] {
        for kind in ["linear", "hermite", "homogeneous"] {
            let path = path_file(&interpolated(planned(name), kind).to_string()).unwrap();
            let options = strict().with(|it| it.bound = 10.0);
            let found = check(&path, &options).segments;
            let groups = CreaseGroups::trivial(&path.pattern);
            let stars = ReducedStars::all(&path.pattern, &groups);
            let mut planner = SegmentCertifier::default();
            for (segment, found) in found.iter().enumerate() {
                let creases = path.pattern.creases().iter().zip(groups.memberships());
                let curve = |(&edge, part): (_, &Membership)| {
                    let curve = path.curve(segment, edge);
                    // The curve of a crease is that of its group, with the sign of its assignment.
                    match curve {
                        _ if !part.negative => curve,
                        Curve::Angle(angle) => Curve::Angle(angle.map(|b| -b)),
                        Curve::HalfAngle { cos, sin } => Curve::HalfAngle {
                            cos,
                            sin: sin.map(|b| -b),
                        },
                    }
                };
                let curves: Vec<_> = creases.map(curve).collect();
                let other = planner
                    .closure(stars.view(), stars.loops(), &curves)
                    .worst();
                let at = format!("{name}, {kind}, segment {segment}: {other:e} {found:?}");
                assert!(found.sampled <= other, "{at}");
                assert!(other <= 3.0 * found.sampled + 1e-10, "{at}");
                assert!(found.bound <= 2.0 * other + 1e-10, "{at}");
            }
        }
    }
}

/// Returns the bound on the closure residual of the whole motion, and the largest number of samples of a segment.
fn certified(path: &Value) -> (f64, usize) {
    let verdict = verdict(path, &strict());
    assert_eq!(verdict.findings(), [""; 0]);
    let samples = verdict.segments.iter().map(|segment| segment.samples);
    (verdict.closure_bound(), samples.max().unwrap())
}

/// Makes a path of one segment from flat. `start` and `end` hold rates at the start, and angles and rates at the end,
/// in degrees and per second.
fn one_segment(mut path: Value, kind: &str, start: &[f64], end: [&[f64]; 2]) -> Value {
    path["foldpath:interpolation"] = json!(kind);
    path["file_frames"] = json!([[&vec![0.0; start.len()][..], start], end].map(
        |[angles, rates]| json!({
            "frame_parent": 0,
            "frame_inherit": true,
            "foldpath:time": 1.0,
            "edges_foldAngle": angles,
            "foldpath:edges_foldAngleRate": rates,
        })
    ));
    frames(&mut path)[0]["foldpath:time"] = json!(0.0);
    path
}

/// Motions that are exact in half angles take one segment from flat to large angles, certified to 2e-11.
#[test]
fn exact_motions_are_certified_in_one_segment() {
    let degrees = |tangents: &[f64]| -> Vec<f64> {
        let angles = tangents.iter().map(|u| 2.0 * u.atan().to_degrees());
        angles.collect()
    };
    let slow = |tangents: &[f64], rates: &[f64]| -> Vec<f64> {
        let pairs = tangents.iter().zip(rates);
        let rates = pairs.map(|(u, rate)| (2.0 * rate / (1.0 + u * u)).to_degrees());
        rates.collect()
    };
    for name in ["miura-3x3", "miura-24x24", "waterbomb-8x10"] {
        let path = planned(name);
        let sheet = Sheet::of(&path).unwrap();
        let last = path["file_frames"].as_array().unwrap().last().unwrap();
        let goal: Vec<f64> = serde_json::from_value(last["edges_foldAngle"].clone()).unwrap();
        let tangent = |angle: &f64| (angle.to_radians() / 2.0).tan();
        let (tangents, [start, end]): (Vec<f64>, [Vec<f64>; 2]) = if name.starts_with("miura") {
            let sharp = worst(goal.iter().map(|angle| tangent(angle).abs()));
            // All tangents grow in proportion, up to 175 degrees.
            let far = tangent(&175.0) / sharp;
            let tangents: Vec<f64> = goal.iter().map(|angle| far * tangent(angle)).collect();
            (tangents.clone(), [tangents.clone(), tangents])
        } else {
            // t goes to 0.7. The tangents of the boundary lines are 3t + 4t³; the others are proportional to t.
            let t = 0.7;
            let closed = Waterbomb::at(t);
            let kinds: Vec<f64> = (sheet.edges.iter().zip(&goal))
                .map(|(ends, goal)| {
                    let ends = ends.map(|v| sheet.flat[v].xy().into());
                    if goal.abs() > 0.0 {
                        closed.of_crease(ends)
                    } else {
                        0.0
                    }
                })
                .collect();
            let tangents: Vec<f64> = kinds.iter().map(|angle| (angle / 2.0).tan()).collect();
            let cubic = (closed.boundary / 2.0).tan();
            let rates = |linear: f64, cube: f64| {
                let is_cubic = |u: f64| (u - cubic).abs() < 1e-9;
                let rate = |&u: &f64| {
                    if is_cubic(u) {
                        linear * 3.0 * t + cube * 12.0 * t.powi(3)
                    } else {
                        u
                    }
                };
                tangents.iter().map(rate).collect::<Vec<f64>>()
            };
            (tangents.clone(), [rates(1.0, 0.0), rates(1.0, 1.0)])
        };
        let (angles, rates) = (degrees(&tangents), slow(&tangents, &end));
        let start = slow(&vec![0.0; start.len()], &start);
        let path = one_segment(path, "half-angle", &start, [&angles, &rates]);
        let (bound, samples) = certified(&path);
        assert!(bound <= 2e-11, "{name}: {bound:e}");
        assert!(samples <= 1024, "{name}: {samples}");
    }
}

/// The segment c = 1 - s, n = k s goes from flat to flat-folded.
#[test]
fn the_whole_miura_is_one_homogeneous_segment() {
    let path = planned("miura-5x5");
    let last = path["file_frames"].as_array().unwrap().last().unwrap();
    let goal: Vec<f64> = serde_json::from_value(last["edges_foldAngle"].clone()).unwrap();
    let sharp = worst(goal.iter().map(|angle| angle.abs()));
    let straight = miura_straight(60_f64.to_radians(), sharp.to_radians()).to_degrees();
    let ratio = |angle: &f64| {
        let part = if (angle.abs() - straight).abs() < 1e-6 {
            0.5
        } else {
            1.0
        };
        if angle.abs() > 0.0 {
            part * angle.signum()
        } else {
            0.0
        }
    };
    let ratios: Vec<f64> = goal.iter().map(ratio).collect();
    let each = |f: &dyn Fn(f64) -> f64| {
        ratios
            .iter()
            .map(|&k| if k.abs() > 0.0 { f(k) } else { 0.0 })
            .collect::<Vec<f64>>()
    };
    // (c, n) goes from (1, 0) to (0, k), at the rate (-1, k).
    let start = each(&|k| (2.0 * k).to_degrees());
    let [angles, rates] = [
        each(&|k| 180.0 * k.signum()),
        each(&|k| (2.0 / k).to_degrees()),
    ];
    let mut path = one_segment(path, "homogeneous", &start, [&angles, &rates]);
    let hinge = |weight: f64, k: &f64| {
        if k.abs() > 0.0 {
            json!(weight)
        } else {
            Value::Null
        }
    };
    let weights =
        |at: &dyn Fn(f64) -> f64| ratios.iter().map(|k| hinge(at(*k), k)).collect::<Vec<_>>();
    for (frame, weight, grow) in [
        (0, weights(&|_| 1.0), weights(&|_| -1.0)),
        (1, weights(&f64::abs), weights(&f64::abs)),
    ] {
        let frame = &mut frames(&mut path)[frame];
        frame["foldpath:edges_weight"] = json!(weight);
        frame["foldpath:edges_weightRate"] = json!(grow);
    }
    let (bound, samples) = certified(&path);
    assert!(bound <= 2e-11, "{bound:e}");
    assert!(samples <= 512, "{samples}");
}

/// Rates that are not those of the motion, and straight lines through few knots, tear the sheet between knots that are
/// good themselves.
#[test]
fn sheets_that_open_between_knots_are_refused() {
    for name in ["miura-5x5", "waterbomb-4x6"] {
        let mut slow = planned(name);
        for frame in frames(&mut slow) {
            for rate in frame["foldpath:edges_foldAngleRate"]
                .as_array_mut()
                .unwrap()
            {
                *rate = json!(0.5 * rate.as_f64().unwrap());
            }
        }
        let thin = interpolated(thinned(planned(name), 4), "linear");
        let thin_hermite = thinned(planned(name), 100);
        for path in [slow, thin, thin_hermite] {
            let verdict = failures(&path);
            let words = "fails to close by";
            assert!(
                verdict.findings()[0].contains(words),
                "{:?}",
                verdict.findings()
            );
            // The residual at the place that the verdict names is the residual that it names.
            let (motion, sheet) = (Motion::of(&path).unwrap(), Sheet::of(&path).unwrap());
            let segments = verdict.segments.iter().enumerate();
            let (index, worst) = segments
                .max_by(|a, b| a.1.sampled.total_cmp(&b.1.sampled))
                .unwrap();
            let residual = sheet.closure(&motion.angles(index, worst.at));
            assert!((residual - worst.sampled).abs() <= 1e-12);
            assert!(
                verdict.findings()[0].contains(&format!("between knots {index} and {}", index + 1))
            );
        }
    }
}

/// The reported bound, from the holonomy of the whole sheet, is not below the measured deformation.
#[test]
fn deformation_is_certified_for_the_whole_motion() {
    for name in ["miura-11x11", "waterbomb-8x10", "yoshimura-12x12"] {
        let path = planned(name);
        let (motion, sheet) = (Motion::of(&path).unwrap(), Sheet::of(&path).unwrap());
        let verdict = verdict(&path, &strict().with(|it| it.bound = 10.0));
        let certified = verdict.certified().unwrap().deformation;
        let strain = |segment: usize, s: f64| {
            let folded = sheet.positions(&sheet.fold(&motion.angles(segment, s)));
            let edges = sheet.edges.iter().map(|&[a, b]| {
                let flat = (sheet.flat[a] - sheet.flat[b]).norm();
                ((folded[a] - folded[b]).norm() / flat - 1.0).abs()
            });
            worst(edges)
        };
        let places = (0..motion.segments())
            .flat_map(|segment| (0..=20).map(move |k| (segment, f64::from(k) / 20.0)));
        let measured = worst(places.map(|(segment, s)| strain(segment, s)));
        assert!(measured <= certified, "{name}: {measured:e} {certified:e}");
        assert!(verdict.rigidity().deformation <= certified);
        assert!(measured > 1e-9, "{name}: nothing to bound");
    }
}

/// If the bound lies between the sampled and the certified deformation, the path may hold, but this is not proved.
#[test]
fn paths_that_only_seem_to_hold_are_not_certified() {
    let path = planned("miura-11x11");
    let at = |bound| verdict(&path, &strict().with(|it| it.bound = bound));
    let seen = at(1.0);
    let measured = seen.rigidity().gap.max(seen.closure());
    let failures = at(1.5 * measured).findings();
    assert!(
        matches!(&failures[..], [one] if one.starts_with("not certified: between knots")),
        "{failures:?}"
    );
    assert_eq!(at(1e-3).findings(), [""; 0]);
}

#[test]
fn hinges_turn_no_way_of_their_own_between_knots() {
    let strip = HandMade::strip();
    let knot = |time, angle, rate| HandKnot {
        time,
        angles: vec![angle, -angle],
        rates: vec![rate, -rate],
    };
    // The hinge swings out by a quarter of the rate, and back.
    let swing = |angle, rate| {
        strip.path(
            "hermite",
            &[knot(0.0, angle, rate), knot(1.0, angle, -rate)],
        )
    };
    let over = |rate| swing(170.0, rate);
    assert_eq!(verdict(&over(39.9), &strict()).findings(), [""; 0]);
    let failures = failures(&over(40.1)).findings();
    assert!(
        failures[0].contains("between knots 0 and 1, at 0.500: edge 1 turns beyond half a turn"),
        "{failures:?}"
    );
    let mut lettered = swing(10.0, -40.1);
    lettered["edges_assignment"][1] = json!("V");
    let failures = verdict(&lettered, &strict()).findings();
    assert!(
        failures[0].contains("edge 1 is lettered V, but turns to -0.02"),
        "{failures:?}"
    );
}

/// Faces that meet between knots and part again are not seen at the knots. The faces that the verdict names cross from
/// the place that it names on, and no faces cross before.
#[test]
fn faces_that_pass_through_each_other_between_knots_are_found() {
    let there_and_back = |angle: f64, rate: f64| {
        [(0.0, rate), (1.0, -rate)].map(|(time, rate)| HandKnot {
            time,
            angles: vec![angle; 2],
            rates: vec![rate; 2],
        })
    };
    // A third knot makes the segment with the crossing the second one.
    let still = |knots: [HandKnot; 2]| {
        let [first, last] = knots;
        let start = HandKnot {
            time: -1.0,
            angles: vec![0.0; first.angles.len()],
            rates: first.rates.clone(),
        };
        [start, first, last]
    };
    let cells = 9;
    let tangents = HandMade::arch_tangents(cells);
    let arch = |t: f64, rate: f64| {
        let knot = |time, rate: f64| HandKnot {
            time,
            angles: tangents
                .iter()
                .map(|k| 2.0 * (k * t).atan().to_degrees())
                .collect(),
            rates: tangents
                .iter()
                .map(|k| (2.0 * k * rate / (1.0 + (k * t).powi(2))).to_degrees())
                .collect(),
        };
        [knot(0.0, rate), knot(1.0, -rate)]
    };
    let (strip, fan, curl) = (HandMade::strip(), HandMade::fan(), HandMade::arch(cells));
    for (what, path, meets) in [
        (
            "flaps",
            strip.path("hermite", &still(there_and_back(90.0, 120.0))),
            1,
        ),
        (
            "sectors of one vertex",
            fan.path("hermite", &still(there_and_back(80.0, 120.0))),
            1,
        ),
        (
            "a strip that curls up",
            curl.path("half-angle", &arch(0.1, 2.0)),
            0,
        ),
    ] {
        let verdict = failures(&path);
        assert_eq!(
            verdict.findings().len(),
            1,
            "{what}: {:?}",
            verdict.findings()
        );
        assert!(
            verdict.findings()[0].contains("pass through each other"),
            "{what}: {:?}",
            verdict.findings()
        );
        let [crossing] = verdict.crossings[..] else {
            panic!("{what}: {:?}", verdict.crossings);
        };
        assert_eq!(crossing.between_knots, [meets, meets + 1], "{what}");
        let (motion, sheet) = (Motion::of(&path).unwrap(), Sheet::of(&path).unwrap());
        let crossings =
            |s| sheet.crossings(&sheet.positions(&sheet.fold(&motion.angles(meets, s))));
        let named = crossing.crossing.faces.map(|face| face.index());
        // At the first crossing the faces are hardly more than in contact.
        let found = crossings(crossing.at + 0.005);
        assert!(found.contains(&named), "{what}: {named:?} {found:?}");
        let before = (0..20).map(|k| crossing.at * f64::from(k) / 20.0);
        assert!(
            before.into_iter().all(|s| crossings(s).is_empty()),
            "{what}"
        );
        assert!(
            crossings(0.0).is_empty() && crossings(1.0).is_empty(),
            "{what}"
        );
    }
}
