//! Is any sample of a motion worse than its plan certifies? The oracle samples the motions that the path files
//! describe: the patterns of `patterns/`, at three bounds.

use std::collections::HashSet;

use foldpath::planner::{Outcome, PlanOptions};
use foldpath_tests::{Motion, Planned, Sheet, worst};
use serde_json::Value;

/// All patterns that fold rigidly.
const PATTERNS: [&str; 11] = [
    "miura-3x3",
    "miura-5x5",
    "miura-11x11",
    "miura-24x24",
    "resch-3x3",
    "square-twist-1x1",
    "square-twist-3x3",
    "waterbomb-4x6",
    "waterbomb-8x10",
    "waterbomb-12x22",
    "yoshimura-12x12",
];
/// Number of points of a segment at which closure is evaluated.
const CLOSURES: u32 = 1000;
/// Largest number of faces that are folded for deformation and gap of a segment.
const FOLDED: usize = 2000;
/// Largest deformation that is certified if the bound allows more.
const CERTIFIED: f64 = 1e-3;
/// Rounding error of the oracle on sheets of hundreds of faces.
const ROUNDING: f64 = 1e-10;

/// Returns interior vertices, without duplicates. Duplicates have equal plane angles, to rounding, and creases that
/// turn by the same angles, bit by bit, at some points of each segment.
fn distinct_stars(sheet: &Sheet, motion: &Motion) -> Vec<(usize, Vec<usize>)> {
    let places = (0..motion.segments()).flat_map(|segment| [0.0, 0.3, 1.0].map(|s| (segment, s)));
    let shapes: Vec<Vec<f64>> = places.map(|(k, s)| motion.angles(k, s)).collect();
    let mut seen = HashSet::new();
    let mut stars = sheet.stars();
    stars.retain(|(vertex, star)| {
        let of_edge = |&edge: &usize| {
            let [a, b] = sheet.edges[edge];
            let way = (sheet.flat[a + b - vertex] - sheet.flat[*vertex]).normalize();
            let way = [way.x, way.y].map(|x| (1e9 * x).round().to_string());
            let angles: Vec<u64> = shapes.iter().map(|shape| shape[edge].to_bits()).collect();
            (way, angles)
        };
        seen.insert(star.iter().map(of_edge).collect::<Vec<_>>())
    });
    stars
}

/// Returns `count` fractions of a segment, evenly spaced inside it.
fn places(count: u32) -> impl Iterator<Item = f64> {
    (1..=count).map(move |k| f64::from(k) / f64::from(count + 1))
}

/// Returns the largest closure residual between knots.
fn most_open(sheet: &Sheet, motion: &Motion, stars: &[(usize, Vec<usize>)]) -> f64 {
    let of_segment = |segment| {
        let angles = places(CLOSURES).map(move |s| motion.angles(segment, s));
        worst(angles.map(|angles| sheet.closure_round(stars, &angles)))
    };
    worst((0..motion.segments()).map(of_segment))
}

/// Returns the largest deformation or gap between knots.
fn most_torn(sheet: &Sheet, motion: &Motion) -> f64 {
    let folded = u32::try_from((FOLDED / sheet.faces.len()).clamp(1, 50)).unwrap();
    let of_segment = |segment| {
        let poses = places(folded).map(move |s| sheet.fold(&motion.angles(segment, s)));
        let torn = |poses: Vec<_>| {
            let strain = sheet.deformation(&sheet.positions(&poses));
            worst([strain, sheet.gap(&poses)])
        };
        worst(poses.map(torn))
    };
    worst((0..motion.segments()).map(of_segment))
}

#[test]
fn no_sample_is_worse_than_certified() {
    for bound in [1e-2, 1e-4, 1e-6] {
        for name in PATTERNS {
            let options = PlanOptions::default().with(|it| {
                it.bound = bound;
                it.collision = false;
            });
            let planned = Planned::new(name, &options);
            let plan = &planned.plan;
            let what = format!("{name} within {bound:e}");
            assert_eq!(plan.outcome, Outcome::Planned, "{what}: {:?}", plan.reason);
            let [closure, deformation] = [plan.certified_closure(), plan.certified_deformation()];
            let [closure, deformation] = [closure, deformation].map(|c| c.expect("a certificate"));
            let most = bound.min(CERTIFIED) / 2.0;
            assert!(
                deformation <= most && closure <= most,
                "{what}: {deformation:e} {closure:e}"
            );
            let file: Value = serde_json::from_str(&planned.text()).unwrap();
            let (sheet, motion) = (Sheet::of(&file).unwrap(), Motion::of(&file).unwrap());
            let stars = distinct_stars(&sheet, &motion);
            let open = most_open(&sheet, &motion, &stars);
            let torn = most_torn(&sheet, &motion);
            println!(
                "{what}: {} knots, {} stars; closure {open:.2e} of {closure:.2e}, deformation and gap \
                 {torn:.2e} of {deformation:.2e}",
                motion.segments() + 1,
                stars.len()
            );
            assert!(open <= closure + ROUNDING, "{what}: closure {open:e}");
            assert!(torn <= deformation + ROUNDING, "{what}: {torn:e}");
        }
    }
}

/// With every other knot left out, the samples are worse than the certificate of the path with all knots.
#[test]
fn samples_see_a_motion_with_too_few_knots() {
    let options = PlanOptions::default().with(|it| it.bound = 1e-6);
    let planned = Planned::new("waterbomb-4x6", &options);
    let mut file: Value = serde_json::from_str(&planned.text()).unwrap();
    let mut index = 0;
    file["file_frames"].as_array_mut().unwrap().retain(|_| {
        index += 1;
        index % 2 == 1
    });
    let (sheet, motion) = (Sheet::of(&file).unwrap(), Motion::of(&file).unwrap());
    let stars = distinct_stars(&sheet, &motion);
    assert!(most_open(&sheet, &motion, &stars) > planned.plan.certified_closure().unwrap());
    assert!(most_torn(&sheet, &motion) > planned.plan.certified_deformation().unwrap());
}
