//! Do the generated sheets close at their goals, and along the whole motion if it is known?

use foldpath::pattern::{CreasePattern, Letter};
use foldpath_tests::campaign::Family;
use foldpath_tests::{Closure, Random, meshes};

/// Largest closure residual of goals, in closed form or solved for.
const CLOSED: f64 = 1e-12;

#[test]
fn goals_close_and_letters_are_their_signs() {
    // Patterns of files are as their authors left them.
    for family in Family::ALL.iter().filter(|family| !family.real) {
        for seed in 0..20 {
            let drawing = family.sheet(seed);
            let name = family.name;
            let goal: Vec<f64> = drawing
                .edges
                .iter()
                .map(|e| e.goal.unwrap_or(0.0))
                .collect();
            let error = Closure::of(&drawing).error(&goal);
            assert!(error <= CLOSED, "{name}, seed {seed}: {error:e}");
            for edge in &drawing.edges {
                let expected = match edge.goal {
                    None => Letter::Boundary,
                    Some(goal) if goal < 0.0 => Letter::Mountain,
                    Some(_) => Letter::Valley,
                };
                assert_eq!(edge.letter, expected, "{name}, seed {seed}");
            }
            let pattern = CreasePattern::new(drawing);
            assert!(pattern.is_ok(), "{name}, seed {seed}: {pattern:?}");
        }
    }
}

/// Tangents of all half angles, scaled by one factor, close from flat to the goal and beyond.
#[test]
fn flat_foldable_meshes_close_along_the_whole_motion() {
    for seed in 0..20 {
        let drawing = meshes::flat_foldable(&mut Random::new(seed));
        let closure = Closure::of(&drawing);
        for part in [1e-3, 0.1, 0.5, 0.9, 2.0, 100.0] {
            let tangent = |goal: f64| 2.0 * (part * (goal / 2.0).tan()).atan();
            let angles: Vec<f64> = drawing
                .edges
                .iter()
                .map(|edge| edge.goal.map_or(0.0, tangent))
                .collect();
            let error = closure.error(&angles);
            assert!(error <= CLOSED, "seed {seed}, {part}: {error:e}");
        }
    }
}

/// Equal seeds give equal sheets, and different seeds different ones.
#[test]
fn seeds_make_sheets() {
    for family in Family::ALL {
        assert_eq!(family.sheet(3), family.sheet(3), "{}", family.name);
        assert_ne!(family.sheet(3), family.sheet(4), "{}", family.name);
    }
}
