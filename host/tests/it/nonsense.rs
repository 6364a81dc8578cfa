//! Tests the library's functions with numbers that are NaN or infinite, or too large or too small to mean anything.
//! Such numbers are refused or handled, and never taken for an answer. Files with bad contents are tested in
//! `bad_files.rs` and `hostile.rs`.

use core::f64::consts::PI;

use crate::common::path_text;
use foldpath::check::{CheckOptions, Failure, check};
use foldpath::collision::{CollisionScene, Sweep, SweepOptions, SweepVerdict};
use foldpath::folding::FoldingMap;
use foldpath::generate::Miura;
use foldpath::motion::Motion;
use foldpath::pattern::{CreaseId, CreasePattern, Drawing, PatternError, VertexId};
use foldpath::planner::{Goal, GoalError, HingeLimit, Outcome, Plan, PlanOptions, plan};
use foldpath::read::fold::parse_motion;
use foldpath::symmetry::{CreaseGroups, closure_of};
use foldpath_core::Curve;
use nalgebra::Vector2;

const NONE: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
/// Smallest number above 0.
const TINY: f64 = f64::from_bits(1);

fn drawing() -> Drawing {
    let miura = Miura {
        rows: 4,
        columns: 4,
        sector_angle: 1.0,
        fold: 0.5,
    };
    miura.drawing().unwrap()
}

fn sheet() -> (CreasePattern, Goal) {
    let pattern = CreasePattern::new(drawing()).unwrap();
    let goal = Goal::of_pattern(&pattern).unwrap();
    (pattern, goal)
}

#[test]
fn coordinates_are_numbers_within_bounds() {
    let beyond = [1.1e50, -1.1e50, f64::MAX, f64::MIN];
    for bad in NONE.into_iter().chain(beyond) {
        for axis in 0..2 {
            let mut drawing = drawing();
            drawing.vertices[7][axis] = bad;
            let refused = CreasePattern::new(drawing).unwrap_err();
            assert_eq!(refused, PatternError::NotFinite { vertex: 7 });
        }
    }
    // A change below rounding errors has no effect.
    for odd in [TINY, -TINY, 1e-300, f64::MIN_POSITIVE] {
        let mut drawing = drawing();
        for vertex in &mut drawing.vertices {
            vertex.x += odd;
            vertex.y -= odd;
        }
        let pattern = CreasePattern::new(drawing).unwrap();
        let plan = plan(
            &pattern,
            &Goal::of_pattern(&pattern).unwrap(),
            &PlanOptions::default(),
        );
        assert_eq!(plan.outcome, Outcome::Planned);
    }
    // If the whole sheet is this small, its edges have no length.
    for scale in [1e-60, 1e-200, 1e-310] {
        let mut drawing = drawing();
        for vertex in &mut drawing.vertices {
            *vertex *= scale;
        }
        let refused = CreasePattern::new(drawing).unwrap_err();
        assert!(
            matches!(refused, PatternError::NoLength { .. }),
            "{refused:?}"
        );
    }
}

/// A sheet far from the origin has all its faces, with the right side up, whether or not the drawing names faces. The
/// certificate is for the shape as rounding has changed it.
#[test]
fn a_sheet_far_from_the_origin_is_the_same_sheet() {
    let near = sheet().0;
    for far in [1e6, 1e8, 1e9, 1e10] {
        let mut drawing = drawing();
        for vertex in &mut drawing.vertices {
            *vertex += Vector2::new(far, -far);
        }
        for name_faces in [false, true] {
            let mut drawing = drawing.clone();
            if name_faces {
                let faces = near.faces().iter();
                let cycle = |face: &[VertexId]| face.iter().rev().map(|v| v.index()).collect();
                drawing.faces = Some(faces.map(cycle).collect());
            }
            let pattern = CreasePattern::new(drawing).unwrap();
            assert_eq!(pattern.faces(), near.faces(), "{far}");
            assert_eq!(pattern.creases(), near.creases());
            let goal = Goal::of_pattern(&pattern).unwrap();
            let plan = plan(&pattern, &goal, &PlanOptions::default());
            assert_eq!(plan.outcome, Outcome::Planned, "{far}: {:?}", plan.reason);
            let certified = plan.certified_deformation().unwrap();
            assert!(certified < 1e-12 * far, "{far}: {certified}");
        }
    }
}

/// If the corners of panels are only a billionth of a degree wide, rounding alone exceeds the bound as far as can be
/// proved, so there is no plan.
#[test]
fn what_is_not_certified_within_the_bound_is_not_planned() {
    for (sector, certified) in [(60.0, true), (1e-9, false)] {
        let sheared = |drawing: &mut Drawing| {
            let (sin, cos) = f64::to_radians(sector).sin_cos();
            for (index, vertex) in drawing.vertices.iter_mut().enumerate() {
                let [row, column] =
                    [index / 5, index % 5].map(|k| f64::from(u8::try_from(k).unwrap()));
                let lean = if index / 5 % 2 == 1 { cos } else { 0.0 };
                *vertex = Vector2::new(column + lean, row * sin);
            }
        };
        let mut drawing = drawing();
        sheared(&mut drawing);
        for edge in &mut drawing.edges {
            edge.goal = None;
        }
        let pattern = CreasePattern::new(drawing).unwrap();
        let plan = plan(
            &pattern,
            &Goal::of_letters(&pattern, 0.5).unwrap(),
            &PlanOptions::default(),
        );
        let proved = plan.certified_deformation().unwrap() <= PlanOptions::default().bound;
        assert_eq!(proved, certified);
        let reason = &plan.reason;
        let said = reason
            .as_ref()
            .is_some_and(|reason| reason.to_string().contains("certified only to"));
        assert_eq!(said, !certified, "{reason:?}");
        assert_eq!(plan.outcome == Outcome::Planned, certified, "{reason:?}");
    }
}

#[test]
fn goals_are_angles_that_hinges_have() {
    for bad in NONE.into_iter().chain([PI + 1e-9, -4.0, 1e300, f64::MAX]) {
        let mut drawing = drawing();
        let hinge = drawing.edges.iter().position(|e| e.goal.is_some()).unwrap();
        drawing.edges[hinge].goal = Some(bad);
        let refused = CreasePattern::new(drawing).unwrap_err();
        let range = matches!(refused, PatternError::GoalRange { edge, .. } if edge == hinge);
        assert!(range, "{bad}: {refused:?}");
    }
    for small in [0.0, -0.0, TINY, 1e-300] {
        let mut drawing = drawing();
        for edge in &mut drawing.edges {
            edge.goal = edge.goal.map(|goal| small.copysign(goal));
        }
        let pattern = CreasePattern::new(drawing).unwrap();
        assert_eq!(Goal::of_pattern(&pattern), Err(GoalError::Flat));
    }
    let (pattern, _) = sheet();
    let crease = pattern.edges().iter().find_map(|edge| edge.crease).unwrap();
    for bad in NONE.into_iter().chain([0.0, TINY, 4.0, 1e300]) {
        assert!(
            Goal::of_creases(&pattern, &[(crease, bad)]).is_err(),
            "{bad}"
        );
    }
    for bad in NONE.into_iter().chain([0.0, -1.0, 1.1]) {
        assert!(Goal::of_letters(&pattern, bad).is_err(), "{bad}");
    }
}

/// Asserts that a plan failed with a reason, and that all numbers of its path are finite.
fn assert_no(plan: &Plan, what: &str) {
    assert_ne!(plan.outcome, Outcome::Planned, "{what}");
    assert!(plan.reason.is_some(), "{what}");
    assert!((0.0..=1.0).contains(&plan.reached), "{what}");
    for knot in plan.knots() {
        let all = knot.angles.iter().chain(&knot.rates).chain([&knot.time]);
        assert!(all.into_iter().all(|x| x.is_finite()), "{what}");
    }
}

#[test]
fn a_goal_of_no_numbers_is_not_planned() {
    let (pattern, goal) = sheet();
    for bad in NONE.into_iter().chain([1e300, -1e300, 7.0]) {
        for which in [0, 5] {
            let mut wrong = goal.clone();
            wrong.fold_angles[which] = Some(bad);
            let plan = plan(&pattern, &wrong, &PlanOptions::default());
            assert_no(&plan, &format!("crease {which} at {bad}"));
        }
        let all = vec![Some(bad); pattern.creases().len()];
        let wrong = Goal::chosen(&pattern, all, "a test".into());
        assert_no(
            &plan(&pattern, &wrong, &PlanOptions::default()),
            &format!("all at {bad}"),
        );
        let via = Goal {
            via: vec![wrong],
            ..goal.clone()
        };
        assert_no(
            &plan(&pattern, &via, &PlanOptions::default()),
            &format!("by {bad}"),
        );
    }
}

#[test]
fn options_of_no_numbers_are_refused() {
    type Set = fn(&mut PlanOptions, f64);
    let settings: [(Set, &str); 5] = [
        (|o, x| o.bound = x, "bound"),
        (|o, x| o.max_step = x, "max_step"),
        (|o, x| o.max_speed = x, "max_speed"),
        (|o, x| o.max_acceleration = Some(x), "max_accel"),
        (
            |o, x| {
                o.limits = vec![HingeLimit {
                    crease: CreaseId(0),
                    lower: x,
                    upper: x,
                }];
            },
            "limit",
        ),
    ];
    for (set, name) in settings {
        for bad in NONE.into_iter().chain([-1.0]) {
            let mut options = PlanOptions::default();
            set(&mut options, bad);
            let refused = options.validate().map_err(|error| error.option);
            assert_eq!(refused, Err(name), "{bad}");
        }
    }
}

#[test]
fn folded_by_no_numbers_a_sheet_has_none() {
    let (pattern, _) = sheet();
    let tree = pattern.tree();
    let folded = |value: f64| {
        let angles = vec![value; pattern.creases().len()];
        let map = FoldingMap::new(&pattern, tree, &angles);
        (map.rigidity(&pattern, tree), map)
    };
    for bad in NONE {
        let (rigidity, map) = folded(bad);
        assert!(rigidity.worst().is_nan() && rigidity.gap.is_nan());
        // No call panics or runs without end.
        let mut scene = CollisionScene::new(&pattern);
        let _none = scene.deepest_crossing(&map, 1e-6);
        let open = vec![Some(bad); pattern.creases().len()];
        assert!(closure_of(&pattern, &open).unwrap().is_nan());
    }
    for odd in [TINY, 1e-300, -0.0] {
        let (rigidity, _) = folded(odd);
        assert!(rigidity.worst() < 1e-14, "{odd}: {rigidity:?}");
    }
    for huge in [1e3, 1e9, 1e300, f64::MAX] {
        let (sin, cos) = (huge / 2.0).sin_cos();
        let (same, rigidity) = (folded(2.0 * sin.atan2(cos)).0, folded(huge).0);
        assert!(rigidity.worst().is_finite());
        assert!((rigidity.gap - same.gap).abs() < 1e-12, "{huge}");
    }
}

#[test]
fn a_motion_of_no_numbers_is_never_free_of_crossings() {
    let (pattern, _) = sheet();
    let groups = CreaseGroups::find(&pattern);
    for bad in NONE.into_iter().chain([f64::MAX]) {
        let curves = [
            Curve::Angle([0.0, bad, 0.0, 0.0]),
            Curve::Angle([0.0, 0.0, 0.0, bad]),
            Curve::HalfAngle {
                cos: [1.0; 4],
                sin: [0.0, bad, 0.0, 0.0],
            },
            Curve::HalfAngle {
                cos: [1.0, bad, 1.0, 1.0],
                sin: [0.0; 4],
            },
        ];
        for curve in curves {
            let motion = vec![vec![curve; groups.len()]];
            let options = SweepOptions::default();
            let verdict = Sweep::new(&pattern, groups.memberships(), options, None).sweep(&motion);
            assert!(
                !matches!(verdict, SweepVerdict::Free(_)),
                "{curve:?}: {verdict:?}"
            );
        }
    }
}

fn path() -> Motion {
    let (pattern, goal) = sheet();
    let options = PlanOptions::default();
    let plan = plan(&pattern, &goal, &options);
    let text = path_text("a path", &plan);
    parse_motion("path.fold".as_ref(), text.as_bytes()).unwrap()
}

#[test]
fn a_path_of_no_numbers_does_not_hold() {
    type Spoil = fn(&mut Motion, usize, f64);
    let spoil: [(Spoil, &str); 5] = [
        (|p, group, x| p.knots[1].angles[group] = x, "angle"),
        (|p, _, x| p.knots[1].time = x, "time"),
        (|p, group, x| p.knots[1].rates[group] = x, "rate"),
        (|p, group, x| p.knots[1].weights[group][0] = x, "weight"),
        (|p, _, x| p.knots[1].vertices[9].y = x, "position"),
    ];
    let path = path();
    assert_eq!(check(&path, &CheckOptions::default()).findings(), [""; 0]);
    for (spoil, name) in spoil {
        for bad in NONE.into_iter().chain([f64::MAX]) {
            let mut path = path.clone();
            if name == "weight" && path.knots[1].weights.is_empty() {
                continue;
            }
            spoil(&mut path, 0, bad);
            let verdict = check(&path, &CheckOptions::default());
            assert!(!verdict.holds(), "{name} {bad}");
        }
    }
    let unbound = CheckOptions::default().with(|it| it.bound = f64::NAN);
    assert_eq!(
        check(&path, &unbound).failures,
        [Failure::BoundIsNotANumber]
    );
}
