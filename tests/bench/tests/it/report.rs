//! Does the report's method do what it claims, and can the section be printed?

use core::f64::consts::FRAC_PI_2;
use core::time::Duration;

use foldpath::generate::Miura;
use foldpath_bench::report::{
    Accept, Algorithm, ClosureObjective, End, Extent, Freedom, Settings, Sheet, fold_by_matrices,
    print, search, straight_between,
};

fn miura(size: usize, freedom: Freedom) -> Sheet {
    let miura = Miura {
        rows: size,
        columns: size,
        sector_angle: 60_f64.to_radians(),
        fold: 170.0 / 180.0,
    };
    Sheet::new(miura.drawing(), freedom)
}

fn settings(algorithm: Algorithm) -> Settings {
    Settings {
        algorithm,
        max_evaluations: 100,
        accept: Accept::Deformation(0.05),
        collision: true,
        seed: 1,
        limit: Duration::from_secs(20),
    }
}

/// Returns the largest deformation at some configurations of the unknowns, by products of 4x4 matrices.
fn deformation(sheet: &Sheet, configurations: &[Vec<f64>]) -> f64 {
    let at = |angles: &Vec<f64>| {
        let creases = sheet.groups.expand(angles);
        fold_by_matrices(&sheet.pattern, sheet.pattern.tree(), &creases).deformation
    };
    configurations.iter().map(at).fold(0.0, f64::max)
}

#[test]
fn every_algorithm_finds_a_path_of_the_small_miura_within_the_bound() {
    for freedom in [Freedom::Groups, Freedom::Essential] {
        let sheet = miura(3, freedom);
        for algorithm in Algorithm::ALL {
            let run = search(&sheet, &settings(algorithm));
            assert_eq!(run.end, End::Reached, "{algorithm:?}");
            assert_eq!(run.knots[0], [0.0, 0.0]);
            assert_eq!(run.knots.last(), Some(&sheet.goal_angles));
            let at_knots = deformation(&sheet, &run.knots);
            assert!(at_knots <= 0.05 + 1e-12, "{algorithm:?}: {at_knots}");
            // Nothing keeps the bound between knots, but the path does not jump.
            let between = deformation(&sheet, &straight_between(&run.knots));
            assert!(between < 0.2, "{algorithm:?}: {between}");
        }
    }
}

#[test]
fn full_dof_is_found_by_differences() {
    let sheet = miura(3, Freedom::Full);
    let run = search(&sheet, &settings(Algorithm::Slsqp));
    assert_eq!(run.end, End::Reached);
    assert!(deformation(&sheet, &run.knots) <= 0.05 + 1e-12);
}

#[test]
fn each_run_is_as_its_seed_says() {
    let sheet = miura(3, Freedom::Essential);
    let run = |seed| {
        let settings = Settings {
            seed,
            ..settings(Algorithm::NelderMead)
        };
        search(&sheet, &settings).knots
    };
    assert_eq!(run(3), run(3));
    assert_ne!(run(3), run(4));
}

/// At a vertex only one crease turns, by a right angle: L is this rotation, and ‖L − I‖ is 2.
#[test]
fn the_objective_is_that_of_a_turn_done_by_hand() {
    let sheet = miura(2, Freedom::Full);
    let mut objective = ClosureObjective::new(&sheet.stars);
    let vertex = sheet.pattern.real_vertices().next().unwrap();
    let creases = sheet
        .pattern
        .creases()
        .iter()
        .zip(sheet.groups.memberships());
    // The sign of an unknown is that of its crease's assignment.
    let directions =
        creases.map(|(&edge, of)| of.apply(1.0) * sheet.pattern.direction(edge, vertex));
    let directions: Vec<_> = directions.collect();
    assert_eq!(directions.len(), 4);
    for crease in 0..4 {
        let mut angles = [0.0; 4];
        angles[crease] = FRAC_PI_2;
        assert!((objective.value(&angles) - 2.0).abs() < 1e-14);
        // ‖R(θ) − I‖ = 2√2 sin θ/2 has the derivative √2 cos θ/2, here 1. A rotation about an axis at the angle β to
        // this crease's axis contributes cos β times that.
        let mut gradient = [0.0; 4];
        let value = objective.value_and_gradient(&angles, &mut gradient);
        assert!((value - 2.0).abs() < 1e-14);
        for (other, slope) in gradient.into_iter().enumerate() {
            let cos = directions[crease].dot(&directions[other]);
            assert!(
                (slope - cos).abs() < 1e-6,
                "{crease} {other}: {slope} {cos}"
            );
        }
    }
}

/// Evaluating few stars again changes nothing: the gradient is that of one whole value for each unknown.
#[test]
fn differences_of_few_stars_are_those_of_all() {
    for (size, freedom) in [
        (5, Freedom::Full),
        (5, Freedom::Groups),
        (3, Freedom::Essential),
    ] {
        let sheet = miura(size, freedom);
        let mut objective = ClosureObjective::new(&sheet.stars);
        let count = sheet.goal_angles.len();
        let angles: Vec<f64> = (0_u32..)
            .take(count)
            .map(|k| f64::from(k * 7 % 11) / 11.0)
            .collect();
        let mut gradient = vec![0.0; count];
        let value = objective.value_and_gradient(&angles, &mut gradient);
        assert!((value - objective.value(&angles)).abs() < 1e-15);
        let step = 1.5e-8;
        let mut moved = 0;
        for (unknown, slope) in gradient.iter().enumerate() {
            let mut there = angles.clone();
            there[unknown] += step;
            let plain = (objective.value(&there) - value) / step;
            assert!((plain - slope).abs() < 1e-6, "{unknown}: {plain} {slope}");
            moved += usize::from(plain.abs() > 1e-3);
        }
        assert!(moved > 0);
    }
}

#[test]
fn the_short_section_has_both_tables_and_its_files() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("report-test");
    let mut text = Vec::new();
    print(Extent::Short, &mut text, &folder).unwrap();
    let text = String::from_utf8(text).unwrap();
    for part in [
        "### Table 1",
        "### Table 2",
        "### Bound 1e-9",
        "**Figure 3**",
        "**Figure 8**",
    ] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    assert!(text.contains("3x3 Miura | o/o | 2 | 5.0 %") && text.contains("planned"));
    for file in [
        "report-tables.csv",
        "report-tuning.csv",
        "report-figure-3.svg",
    ] {
        let written = std::fs::read_to_string(folder.join(file)).unwrap();
        assert!(written.lines().count() > 3, "{file}");
    }
}
