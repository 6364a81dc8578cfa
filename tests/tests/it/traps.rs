//! Sheets on which a careless measure reports that all is well.

use foldpath::collision::CollisionScene;
use foldpath::folding::FoldingMap;
use foldpath::generate::Miura;
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};
use foldpath::planner::{Outcome, PlanOptions, Symmetry};
use foldpath::read::fold::PatternFile;
use foldpath_tests::Planned;
use nalgebra::Vector2;

/// Returns a drawing as a pattern. Edges with an angle, in degrees, are creases; the sign gives the assignment.
fn pattern(vertices: &[[f64; 2]], edges: &[([usize; 2], Option<f64>)]) -> CreasePattern {
    let letter = |angle: Option<f64>| match angle {
        None => Letter::Boundary,
        Some(angle) if angle < 0.0 => Letter::Mountain,
        Some(_) => Letter::Valley,
    };
    let edges = edges.iter().map(|&(ends, angle)| DrawnEdge {
        ends,
        letter: letter(angle),
        goal: angle.map(f64::to_radians),
    });
    let drawing = Drawing {
        vertices: vertices.iter().copied().map(Vector2::from).collect(),
        edges: edges.collect(),
        faces: None,
    };
    CreasePattern::new(drawing).unwrap()
}

fn plan(pattern: CreasePattern, options: &PlanOptions) -> foldpath::planner::Plan {
    let title = String::new();
    Planned::of(PatternFile { title, pattern }, options).plan
}

/// Returns a strip of panels between the x coordinates `x`, folded by `angles`, degrees.
fn strip(x: &[f64], angles: &[f64]) -> CreasePattern {
    let vertices: Vec<[f64; 2]> = x.iter().flat_map(|&x| [[x, 0.0], [x, 1.0]]).collect();
    let last = x.len() - 1;
    let mut edges = vec![([0, 1], None), ([2 * last, 2 * last + 1], None)];
    for k in 0..last {
        edges.extend([([2 * k, 2 * k + 2], None), ([2 * k + 1, 2 * k + 3], None)]);
    }
    edges.extend((1..last).map(|k| ([2 * k, 2 * k + 1], Some(angles[k - 1]))));
    pattern(&vertices, &edges)
}

/// The last panel comes back through the sheet exactly at a crease between two coplanar panels, so that it crosses
/// neither panel alone.
#[test]
fn a_panel_that_passes_through_a_crease_is_a_crossing() {
    let pattern = strip(&[-1.0, 0.0, 1.0, 2.0, 3.0, 5.0], &[0.0, 90.0, 90.0, 90.0]);
    let tree = pattern.tree();
    let crossing = |angles: [f64; 4]| {
        let map = FoldingMap::new(&pattern, tree, &angles.map(f64::to_radians));
        CollisionScene::new(&pattern).deepest_crossing(&map, 1e-6)
    };
    assert!(crossing([0.0, 90.0, 90.0, 90.0]).is_some());
    assert!(crossing([0.0, 90.0, 90.0, 90.1]).is_some());
    assert!(crossing([0.0, 90.0, 90.0, 20.0]).is_none());
    // A panel that stands on the crease from above, or lies on both panels, is in contact.
    assert!(crossing([0.0, 90.0, 90.0, 0.0]).is_none());
}

/// Round a hole, two creases in one line must turn by equal angles. Positions do not show an error: turning a crease
/// moves neither of its ends.
#[test]
fn creases_round_a_hole_that_contradict_each_other_are_not_planned() {
    let vertices = [
        [0.0, 0.0],
        [1.5, 0.0],
        [3.0, 0.0],
        [3.0, 3.0],
        [1.5, 3.0],
        [0.0, 3.0],
        [1.0, 1.0],
        [1.5, 1.0],
        [2.0, 1.0],
        [2.0, 2.0],
        [1.5, 2.0],
        [1.0, 2.0],
    ];
    let ring = |from: usize, to: usize| ([from, to], None);
    let with = |first: f64, second: f64| {
        let mut edges: Vec<_> = (0..6).map(|k| ring(k, (k + 1) % 6)).collect();
        edges.extend((0..6).map(|k| ring(6 + k, 6 + (k + 1) % 6)));
        edges.push(([1, 7], Some(first)));
        edges.push(([10, 4], Some(second)));
        pattern(&vertices, &edges)
    };
    assert_eq!(with(40.0, 40.0).faces().len(), 2);
    assert_eq!(with(40.0, 40.0).real_vertices().count(), 0);
    let options = PlanOptions::default();
    assert_eq!(plan(with(40.0, 40.0), &options).outcome, Outcome::Planned);
    let contradicted = plan(with(90.0, -60.0), &options);
    assert_eq!(
        contradicted.outcome,
        Outcome::GoalNotClosed,
        "{contradicted:?}"
    );
    // A goal with a small contradiction is moved to the nearest consistent goal: the mean of the two angles.
    let nearly = plan(with(40.0, 41.0), &options);
    assert_eq!(nearly.outcome, Outcome::Planned, "{nearly:?}");
    assert!(
        (nearly.arrival.error.to_degrees() - 0.5).abs() < 1e-3,
        "{nearly:?}"
    );
    assert!(nearly.errors.closure < 1e-12);
}

/// A Miura vertex with one angle not given: the other angles determine it.
#[test]
fn a_free_hinge_goes_where_the_others_take_it() {
    let miura = Miura {
        rows: 2,
        columns: 2,
        sector_angle: 60_f64.to_radians(),
        fold: 0.5,
    };
    for free in 0..4 {
        let mut drawing = miura.drawing().unwrap();
        let creases = drawing.edges.iter_mut().filter(|edge| edge.goal.is_some());
        let hinge = creases.into_iter().nth(free).unwrap();
        let named = hinge.goal.take().unwrap();
        hinge.letter = Letter::Unassigned;
        let plan = plan(
            CreasePattern::new(drawing).unwrap(),
            &PlanOptions::default(),
        );
        assert_eq!(plan.outcome, Outcome::Planned, "{free}: {:?}", plan.reason);
        let last = plan.knots().last().unwrap();
        let member = plan.motion.as_ref().unwrap().memberships()[free];
        let reached = member.apply(last.angles[member.group.index()]);
        assert!((reached - named).abs() < 1e-9, "{free}: {reached} {named}");
    }
}

/// A goal that closes stays the goal, even if it is nearly symmetric.
#[test]
fn an_exact_goal_is_not_moved_to_a_symmetric_one() {
    let degree = 12_u32;
    let spoke = |k: u32| {
        let (sin, cos) = (f64::from(k) * core::f64::consts::TAU / f64::from(degree)).sin_cos();
        [cos, sin]
    };
    let mut vertices: Vec<[f64; 2]> = (0..degree).map(spoke).collect();
    vertices.push([0.0, 0.0]);
    let rim = |k: u32| ([k as usize, ((k + 1) % degree) as usize], None);
    let mut edges: Vec<_> = (0..degree).map(rim).collect();
    let angle = |k: u32| if k.is_multiple_of(2) { 30.0 } else { -20.0 };
    edges.extend((0..degree).map(|k| ([k as usize, degree as usize], Some(angle(k)))));
    // Closes the goal without symmetry first. Its own angles then close and are nearly symmetric.
    let free = PlanOptions::default().with(|it| it.symmetry = Symmetry::Off);
    let mut start: Vec<f64> = (0..degree).map(angle).collect();
    start[0] += 0.3;
    for (edge, &angle) in edges[degree as usize..].iter_mut().zip(&start) {
        edge.1 = Some(angle);
    }
    let closed = plan(pattern(&vertices, &edges), &free);
    let last = closed.knots().last().expect("a path");
    for (k, edge) in edges[degree as usize..].iter_mut().enumerate() {
        let member = closed.motion.as_ref().unwrap().memberships()[k];
        edge.1 = Some(member.apply(last.angles[member.group.index()]).to_degrees());
    }
    let exact = plan(pattern(&vertices, &edges), &PlanOptions::default());
    assert_eq!(exact.outcome, Outcome::Planned, "{:?}", exact.reason);
    assert!(
        exact.arrival.error < 1e-9,
        "{} {:?}",
        exact.arrival.error,
        exact.notes
    );
}
