//! Patterns as other programs write them: rotated, with rounded coordinates. No configuration of such a sheet but the
//! flat one closes exactly.

use foldpath::check::check;
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge};
use foldpath::planner::{CHOSEN_REACH, Outcome, Plan, PlanOptions};
use foldpath::read::fold::PatternFile;
use foldpath::read::read_pattern;
use foldpath_tests::{Motion, Planned, Random, Sheet, path_file, pattern_file, strict, worst};
use nalgebra::{Rotation2, Vector2};

/// Returns the pattern rotated by 0.3 rad, its coordinates rounded to multiples of `unit`.
fn rounded(name: &str, unit: f64) -> Option<PatternFile> {
    let turn = Rotation2::new(0.3);
    redrawn(name, |p| (turn * p).map(|c| (c / unit).round() * unit))
}

/// Returns the pattern with moved vertices; `None` if the result is not a pattern.
fn redrawn(name: &str, place: impl FnMut(&Vector2<f64>) -> Vector2<f64>) -> Option<PatternFile> {
    let PatternFile { title, pattern } = read_pattern(&pattern_file(name)).unwrap();
    let edges = pattern.edges().iter().map(|edge| DrawnEdge {
        ends: edge.ends.map(|end| end.index()),
        letter: edge.letter,
        goal: edge.goal,
    });
    let drawing = Drawing {
        vertices: pattern.vertices().iter().map(place).collect(),
        edges: edges.collect(),
        faces: None,
    };
    let pattern = CreasePattern::new(drawing).ok()?;
    Some(PatternFile { title, pattern })
}

#[test]
fn rounding_keeps_the_groups_and_costs_its_own_size() {
    for (name, groups) in [
        ("miura-3x3", 2),
        ("miura-11x11", 2),
        ("miura-24x24", 2),
        ("waterbomb-12x22", 4),
        ("yoshimura-12x12", 2),
    ] {
        for unit in [1e-14, 1e-12, 1e-10, 1e-8] {
            let file = rounded(name, unit).unwrap();
            let plan = Planned::of(file, &PlanOptions::default()).plan;
            let what = format!(
                "{name} {unit:e}: {:?} {:?}",
                plan.reason, plan.errors.rigidity
            );
            assert_eq!(plan.outcome, Outcome::Planned, "{what}");
            assert_eq!(plan.reduced.groups, groups, "{what}");
            // A direction is off by the unit, and the errors of 24 cells in a row add up.
            let allowed = 1e3 * unit + 1e-12;
            assert!(plan.errors.rigidity.deformation <= allowed, "{what}");
            assert!(plan.errors.rigidity.gap <= allowed, "{what}");
            assert!(
                plan.arrival.error <= allowed,
                "{what}: {}",
                plan.arrival.error
            );
        }
    }
}

/// With coarser rounding the sheet may be rigid, but a plan must never lead to another goal.
#[test]
fn coarse_rounding_never_passes_for_another_goal() {
    for name in [
        "miura-3x3",
        "miura-11x11",
        "waterbomb-8x10",
        "yoshimura-12x12",
    ] {
        for unit in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.03] {
            let Some(file) = rounded(name, unit) else {
                continue;
            };
            let plan = Planned::of(file, &PlanOptions::default()).plan;
            if plan.outcome == Outcome::Planned {
                assert!(plan.arrival.error <= CHOSEN_REACH, "{name} {unit:e}");
                assert!(plan.errors.rigidity.deformation <= PlanOptions::default().bound);
            } else {
                assert!(plan.reason.is_some(), "{name} {unit:e}");
            }
        }
    }
}

/// Returns the plan of a rounded sheet, and its path as written.
fn planned(name: &str, unit: f64, options: &PlanOptions) -> (Plan, Sheet, Motion) {
    let planned = Planned::of(rounded(name, unit).unwrap(), options);
    let outcome = planned.plan.outcome;
    assert_eq!(
        outcome,
        Outcome::Planned,
        "{name}: {:?}",
        planned.plan.reason
    );
    let file = serde_json::from_str(&planned.text()).unwrap();
    let sheet = Sheet::of(&file).unwrap();
    (planned.plan, sheet, Motion::of(&file).unwrap())
}

/// On a coarsely rounded sheet some vertices close worse than the essential vertex that represents them.
#[test]
fn the_certified_closure_holds_of_every_vertex() {
    for name in ["miura-11x11", "waterbomb-8x10"] {
        let options = PlanOptions::default().with(|it| {
            it.bound = 1e-2;
            it.keep_vertices = false;
        });
        let (plan, sheet, motion) = planned(name, 1e-4, &options);
        let stars = sheet.stars();
        let certified = plan.certified_closure().unwrap();
        let places = (0..motion.segments()).flat_map(|k| (0..=100).map(move |i| (k, i)));
        let shapes = places.map(|(k, i)| motion.angles(k, f64::from(i) / 100.0));
        let open = worst(shapes.map(|angles| sheet.closure_round(&stars, &angles)));
        assert!(open <= certified, "{name}: {open:e} of {certified:e}");
        assert!(
            certified <= 10.0 * open,
            "{name}: {open:e} of {certified:e}"
        );
    }
}

/// The vertices of a measured sheet are off by up to a given distance in any direction. Near flat such a sheet can
/// follow the signs of its assignments only with a larger closure residual. Found by experiment.
fn measured_paths_hold(sheets: &[(&str, f64)], offs: &[f64], least: usize) {
    let mut planned = 0;
    for &(name, bound) in sheets {
        for &off in offs {
            let mut random = Random::new(1);
            let file = redrawn(name, |p| p.map(|c| c + random.uniform(-off, off)));
            let options = PlanOptions::default().with(|it| it.bound = bound);
            let found = Planned::of(file.unwrap(), &options);
            if found.plan.outcome != Outcome::Planned {
                continue;
            }
            planned += 1;
            let options = strict().with(|it| it.bound = bound);
            let failures = check(&path_file(&found.text()).unwrap(), &options).findings();
            assert_eq!(failures, [""; 0], "{name} {off} {bound}");
        }
    }
    println!("{planned} planned");
    assert!(planned > least);
}

#[test]
fn paths_of_measured_sheets_hold() {
    let sheets = [
        ("miura-5x5", 0.01),
        ("waterbomb-4x6", 0.05),
        ("waterbomb-8x10", 0.01),
        ("yoshimura-12x12", 0.05),
    ];
    measured_paths_hold(&sheets, &[1e-5, 1e-4, 1e-3], 6);
}

/// The long form, in the full tier.
#[test]
#[ignore = "takes a minute"]
fn paths_of_many_measured_sheets_hold() {
    let names = [
        "miura-5x5",
        "waterbomb-4x6",
        "waterbomb-8x10",
        "yoshimura-12x12",
    ];
    let sheets = names.map(|name| [(name, 0.01), (name, 0.05)]);
    let offs = [1e-5, 3e-5, 1e-4, 3e-4, 1e-3];
    measured_paths_hold(sheets.as_flattened(), &offs, 20);
}
