//! Generated families whose answer is not a plain plan: sheets that do not fold, and why.

use foldpath::folding::{FoldingMap, Rigidity, SpanningTree};
use foldpath::generate::{Kresling, Letters, Quad, Resch, SquareTwist};
use foldpath::pattern::{CreasePattern, Drawing};
use foldpath::planner::{Goal, Outcome, PlanOptions, Symmetry, closure_of, plan};
use foldpath::symmetry::{CreaseGroups, ReducedStars};

/// A sheet that is closed, but for rounding.
const CLOSED: f64 = 1e-9;

fn pattern(drawing: Drawing) -> CreasePattern {
    CreasePattern::new(drawing).unwrap()
}

fn goal_angles(pattern: &CreasePattern) -> Vec<f64> {
    let goals = pattern.creases().iter().map(|&id| pattern.edge(id).goal);
    goals.map(Option::unwrap).collect()
}

fn closure_at(pattern: &CreasePattern, angles: &[f64]) -> f64 {
    let angles: Vec<_> = angles.iter().map(|&angle| Some(angle)).collect();
    closure_of(pattern, &angles).unwrap()
}

/// The answer with crease groups and without.
fn outcomes(pattern: &CreasePattern) -> [Outcome; 2] {
    let goal = Goal::of_pattern(pattern).unwrap();
    [Symmetry::Auto, Symmetry::Off].map(|symmetry| {
        let options = PlanOptions {
            symmetry,
            ..PlanOptions::default()
        };
        plan(pattern, &goal, &options).outcome
    })
}

/// The worst over twenty steps from flat to the goal, all angles scaled alike.
fn scaled_to_goal(pattern: &CreasePattern) -> Rigidity {
    let tree = SpanningTree::from_central_face(pattern);
    let goal = goal_angles(pattern);
    let steps = (0..=20).map(|step| {
        let angles: Vec<f64> = goal.iter().map(|g| g * f64::from(step) / 20.0).collect();
        FoldingMap::new(pattern, &tree, &angles).rigidity(pattern, &tree, &angles)
    });
    steps.fold(Rigidity::default(), Rigidity::worse)
}

fn quad(size: usize) -> CreasePattern {
    let quad = Quad {
        rows: size,
        columns: size,
        fold: 0.0675,
    };
    pattern(quad.drawing().unwrap())
}

/// The report's Quad: within 0.1 % on the essential crease pattern, over 400 % on 24x24.
#[test]
fn quad_deforms_with_its_size() {
    let (small, large) = (quad(3), quad(24));
    for sheet in [&small, &large] {
        let groups = CreaseGroups::find(sheet);
        assert_eq!(groups.len(), 3);
        assert_eq!(ReducedStars::all(sheet, &groups).essential().vertices().len(), 1);
    }
    let (small, large) = (scaled_to_goal(&small), scaled_to_goal(&large));
    println!("{small:?}\n{large:?}");
    assert!(small.deformation <= 1e-3, "{small:?}");
    assert!(large.deformation > 4.0, "{large:?}");
    assert_eq!(quad(4).creases().len(), 24 + 16);
}
