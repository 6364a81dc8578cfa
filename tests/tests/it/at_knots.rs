//! Plans that are judged at their knots alone: does the oracle agree with them at the knots?

use foldpath::collision::CollisionScene;
use foldpath::folding::{FoldingMap, SpanningTree};
use foldpath::generate::Waterbomb;
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};
use foldpath::planner::{Goal, Judged, Outcome, PlanOptions, Symmetry, Undecided, Vertices, plan};
use foldpath::read::fold::read_pattern;
use foldpath_tests::{Motion, Planned, Sheet, pattern_file, worst};
use nalgebra::Vector2;

/// Rounding error of the oracle on sheets of hundreds of faces.
const ROUNDING: f64 = 1e-10;

fn options(symmetry: Symmetry, vertices: Vertices, keep_vertices: bool) -> PlanOptions {
    PlanOptions {
        judged: Judged::Knots,
        symmetry,
        vertices,
        keep_vertices,
        ..PlanOptions::default()
    }
}

#[test]
fn knots_are_as_good_as_is_said_and_no_step_is_too_long() {
    let freedoms = [
        (Symmetry::Auto, Vertices::Essential),
        (Symmetry::Auto, Vertices::All),
        (Symmetry::Off, Vertices::All),
    ];
    for name in [
        "miura-3x3",
        "miura-11x11",
        "resch-3x3",
        "square-twist-3x3",
        "waterbomb-8x10",
        "waterbomb-12x22",
        "yoshimura-12x12",
    ] {
        for (symmetry, vertices) in freedoms {
            for keep_vertices in [false, true] {
                let what = format!("{name} {symmetry:?} {vertices:?} {keep_vertices}");
                let options = options(symmetry, vertices, keep_vertices);
                let file = read_pattern(&pattern_file(name)).unwrap();
                let hinges = file.pattern.creases().len();
                let planned = Planned::of(file, &options);
                let plan = &planned.plan;
                assert_eq!(
                    plan.outcome,
                    Outcome::Undecided,
                    "{what}: {:?}",
                    plan.reason
                );
                assert_eq!(plan.certified_deformation, None, "{what}");
                assert!(plan.goal_error <= 1e-9, "{what}: {}", plan.goal_error);
                assert_eq!(plan.undecided, [Undecided::JudgedAtKnots]);
                let knots = plan.knots();
                for pair in knots.windows(2) {
                    let steps = pair[0].angles.iter().zip(&pair[1].angles);
                    let step = worst(steps.map(|(a, b)| (b - a).abs()));
                    assert!(step <= options.max_step * 1.000_001, "{what}: {step}");
                    let speed = step / (pair[1].time - pair[0].time);
                    assert!(speed <= options.max_speed * 1.000_001, "{what}: {speed}");
                }
                let file = serde_json::from_str(&planned.text()).unwrap();
                let (sheet, motion) = (Sheet::of(&file).unwrap(), Motion::of(&file).unwrap());
                for (index, knot) in knots.iter().enumerate().skip(1) {
                    let angles = motion.angles(index - 1, 1.0);
                    let poses = sheet.fold(&angles);
                    let placed = sheet.positions(&poses);
                    let closed = if plan.groups < hinges {
                        ROUNDING
                    } else {
                        0.01 * plan.essential_tolerance
                    };
                    let closure = sheet.closure(&angles);
                    assert!(closure <= closed, "{what}: {closure:e} {closed:e}");
                    for (name, found, said) in [
                        ("closure", closure, knot.claims.closure.unwrap()),
                        ("gap", sheet.gap(&poses), knot.claims.gap.unwrap()),
                        (
                            "deformation",
                            sheet.deformation(&placed),
                            knot.claims.deformation.unwrap(),
                        ),
                    ] {
                        // The oracle folds from another face, and so along another spanning tree.
                        let most = 10.0 * said + ROUNDING;
                        assert!(found <= most, "{what}: {name} {found:e} {said:e}");
                    }
                    assert!(sheet.crossings(&placed).is_empty(), "{what}");
                }
            }
        }
    }
}

/// The tube of twelve squares closes near b - m = 60°. Beyond that its faces cross.
#[test]
fn a_path_ends_before_the_first_knot_that_crosses() {
    let sheet = Waterbomb {
        rows: 12,
        columns: 22,
        fold: 0.6,
    };
    let pattern = CreasePattern::new(sheet.drawing().unwrap()).unwrap();
    let goal = Goal::of_pattern(&pattern).unwrap();
    let tree = SpanningTree::from_central_face(&pattern);
    let [along_lattice, among_all] = [true, false].map(|symmetry| {
        let mut options = options(Symmetry::Auto, Vertices::Essential, false);
        options.skips.symmetry = symmetry;
        let plan = plan(&pattern, &goal, &options);
        let Outcome::Crossing(crossing) = plan.outcome else {
            panic!("{:?}: {:?}", plan.outcome, plan.reason);
        };
        assert!(plan.reached > 0.5 && plan.reached < 1.0, "{}", plan.reached);
        let mut map = FoldingMap::flat(&pattern);
        for knot in plan.knots() {
            map.fold_groups(
                &pattern,
                &tree,
                &plan.motion.as_ref().unwrap().memberships(),
                &knot.angles,
            );
            let found = CollisionScene::new(&pattern).deepest_crossing(&map, 1e-6);
            assert_eq!(found, None);
        }
        (plan.knots().len(), crossing.depth)
    });
    assert_eq!(along_lattice.0, among_all.0);
    assert!((along_lattice.1 - among_all.1).abs() < 1e-9);
}

/// The strip has no lattice, so that all its faces are searched.
#[test]
fn the_whole_motion_of_a_large_sheet_is_searched() {
    let count = 4002_usize;
    let point = |k: usize| {
        let x = f64::from(u32::try_from(k / 2).unwrap());
        Vector2::new(x, if k.is_multiple_of(2) { 0.0 } else { 1.0 })
    };
    let edge = |ends, goal: Option<f64>| DrawnEdge {
        ends,
        letter: goal.map_or(Letter::Boundary, |goal| {
            if goal > 0.0 {
                Letter::Valley
            } else {
                Letter::Mountain
            }
        }),
        goal,
    };
    let across = (0..=count).map(|k| {
        let goal = if k.is_multiple_of(2) { 0.3 } else { -0.3 };
        let inner = k > 0 && k < count;
        edge([2 * k, 2 * k + 1], inner.then_some(goal))
    });
    let along = (0..2 * count).map(|k| edge([k, k + 2], None));
    let drawing = Drawing {
        vertices: (0..2 * count + 2).map(point).collect(),
        edges: across.chain(along).collect(),
        faces: None,
    };
    let pattern = CreasePattern::new(drawing).unwrap();
    let options = PlanOptions {
        symmetry: Symmetry::Off,
        keep_vertices: false,
        ..PlanOptions::default()
    };
    let plan = plan(&pattern, &Goal::of_pattern(&pattern).unwrap(), &options);
    assert_eq!(plan.outcome, Outcome::Planned, "{:?}", plan.reason);
    assert_eq!(plan.notes, []);
    let nearest = plan.clearance.expect("faces without a common vertex");
    assert!(nearest.distance > 0.5 && nearest.distance <= 1.0);
}
