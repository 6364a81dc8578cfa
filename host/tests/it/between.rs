//! Tests that the planner refuses a motion with a crossing strictly between knots.

use foldpath::collision::CollisionScene;
use foldpath::folding::FoldingMap;
use foldpath::generate::Waterbomb;
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};
use foldpath::planner::{Goal, Outcome, PlanOptions, Search, Strategy, plan};
use nalgebra::Vector2;

/// Returns a unit square with a flap of 0.55 on its left and another on its right. Folded over to 172 and 174 degrees,
/// one flap lies above the other. If both turn at once, they pass through each other for two degrees on the way.
fn flaps() -> CreasePattern {
    let xs = [-0.55, 0.0, 1.0, 1.55];
    let vertices = xs
        .iter()
        .flat_map(|&x| [0.0, 1.0].map(|y| Vector2::new(x, y)));
    let edge = |a: usize, b: usize, letter, goal: Option<f64>| DrawnEdge {
        ends: [a, b],
        letter,
        goal: goal.map(f64::to_radians),
    };
    let mut edges = vec![
        edge(0, 1, Letter::Boundary, None),
        edge(2, 3, Letter::Valley, Some(172.0)),
        edge(4, 5, Letter::Valley, Some(174.0)),
        edge(6, 7, Letter::Boundary, None),
    ];
    for left in 0..3 {
        for side in 0..2 {
            let (a, b) = (2 * left + side, 2 * left + 2 + side);
            edges.push(edge(a, b, Letter::Boundary, None));
        }
    }
    CreasePattern::new(Drawing {
        vertices: vertices.collect(),
        edges,
        ..Drawing::default()
    })
    .unwrap()
}

#[test]
fn flaps_that_cross_between_knots_are_refused_although_no_knot_crosses() {
    let pattern = flaps();
    let goal = Goal::of_pattern(&pattern).unwrap();
    let blind = PlanOptions::default().with(|it| it.collision = false);
    let unseen = plan(&pattern, &goal, &blind);
    assert_eq!(unseen.outcome, Outcome::Planned);
    let tree = pattern.tree();
    let mut scene = CollisionScene::new(&pattern);
    for knot in unseen.knots() {
        let member = |m: &foldpath_core::Membership| m.apply(knot.angles[m.group.index()]);
        let angles: Vec<f64> = unseen
            .motion
            .as_ref()
            .unwrap()
            .memberships()
            .iter()
            .map(member)
            .collect();
        let map = FoldingMap::new(&pattern, tree, &angles);
        assert!(scene.deepest_crossing(&map, 1e-6).is_none(), "{angles:?}");
    }

    // If the flaps turn one after the other they do not cross. A goal on the way leaves that search on.
    let in_turn = plan(&pattern, &goal, &PlanOptions::default());
    assert_eq!(in_turn.outcome, Outcome::Planned);
    let tried = in_turn.attempts.iter();
    let tried: Vec<_> = tried
        .map(|tried| (tried.strategy, tried.outcome.name()))
        .collect();
    let expected = [
        (Strategy::CreaseGroups, "crossing"),
        (Strategy::SplitPhases, "planned"),
    ];
    assert_eq!(tried, expected);
    let halves = goal.fold_angles.iter().map(|angle| angle.map(|a| a / 2.0));
    let half = Goal::chosen(&pattern, halves.collect(), "half the way".into());
    let goal = Goal {
        via: vec![half],
        ..goal
    };
    let in_turn = plan(&pattern, &goal, &PlanOptions::default());
    assert_eq!(in_turn.outcome, Outcome::Planned);
    let path = PlanOptions::default().with(|it| it.search = Search::Path);
    let seen = plan(&pattern, &goal, &path);
    let Outcome::Crossing(crossing) = seen.outcome else {
        panic!("{:?}", seen.outcome)
    };
    let [a, b] = crossing
        .faces
        .map(|face| pattern.faces()[face.index()].to_vec());
    assert!(a.iter().all(|corner| !b.contains(corner)), "{a:?} {b:?}");
    // The tips meet at 165.13 degrees of 174.
    assert!(
        (seen.reached - 165.13 / 174.0).abs() < 1e-3,
        "{}",
        seen.reached
    );
}

/// Twelve squares round close to a tube, edge on edge, if boundary lines turn by 60 degrees more than middle lines. The
/// smallest turn beyond that is a crossing, however much the certificate leaves open.
#[test]
fn a_tube_closes_and_no_further() {
    let turn = 15_f64.to_radians().tan();
    let t = (1.0 - (1.0 - 8.0 * turn * turn).sqrt()) / (4.0 * turn);
    let closed = 2.0 * (3.0 * t + 4.0 * t.powi(3)).atan() / core::f64::consts::PI;
    let outcome = |beyond: f64| {
        let tube = Waterbomb {
            rows: 12,
            columns: 22,
            fold: closed * (1.0 + beyond),
        };
        let pattern = CreasePattern::new(tube.drawing().unwrap()).unwrap();
        let goal = Goal::of_pattern(&pattern).unwrap();
        plan(&pattern, &goal, &PlanOptions::default()).outcome
    };
    assert_eq!(outcome(-1e-6), Outcome::Planned);
    for beyond in [1e-6, 1e-5, 1e-4] {
        assert!(
            matches!(outcome(beyond), Outcome::Crossing(_)),
            "{beyond:e}"
        );
    }
}
