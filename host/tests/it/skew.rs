//! Tests the largest skew of a motion: figures of a second program, and bounds that hold for every motion of a sheet.

use foldpath::motion::Motion;
use foldpath::pattern::{CreasePattern, Drawing};
use foldpath::planner::{Goal, PlanOptions, plan};
use foldpath::sensitivity::{skew_bound, skew_residual, skew_residual_of_sheet};

use crate::common::{miura, waterbomb};

fn planned(drawing: Drawing) -> Motion {
    let pattern = CreasePattern::new(drawing).unwrap();
    let goal = Goal::of_pattern(&pattern).unwrap();
    let options = PlanOptions::default().with(|it| it.max_speed = 1.0);
    plan(&pattern, &goal, &options).motion.unwrap()
}

/// Figures of a second program, which tries all signs at 60 times with Jacobians in Python.
#[test]
fn a_miura_has_the_residual_of_its_axes() {
    for (fold, expected) in [(0.5, 1.256_733), (0.9, 1.337_977)] {
        let motion = planned(miura(2, 2, fold));
        let found = skew_residual(&motion).unwrap();
        assert!((found - expected).abs() < 1e-3, "{found} {expected}");
        let bound = skew_residual_of_sheet(&motion.pattern, 1.0).unwrap();
        assert!((bound - 2.0).abs() < 1e-15 && found <= bound + 1e-9);
        // Twice as fast is half the skew.
        let mut fast = motion.clone();
        for knot in &mut fast.knots {
            knot.time /= 2.0;
            knot.rates.iter_mut().for_each(|rate| *rate *= 2.0);
            knot.weights.iter_mut().for_each(|[_, rate]| *rate *= 2.0);
        }
        let twice = skew_residual(&fast).unwrap();
        assert!((twice / found - 2.0).abs() < 1e-9, "{twice} {found}");
    }
}

#[test]
fn a_waterbomb_bears_less_than_its_degrees_allow() {
    let motion = planned(waterbomb(4, 6, 0.5));
    let found = skew_residual(&motion).unwrap();
    let bound = skew_residual_of_sheet(&motion.pattern, 1.0).unwrap();
    assert!((bound - 3.0).abs() < 1e-15 && found <= bound, "{found}");
    assert!((found - 1.3208).abs() < 5e-3, "{found}");
    assert!((skew_bound(2.0, 50.0).unwrap() - 1e-4).abs() < 1e-18);
    assert_eq!(skew_bound(0.0, 50.0), None);
}
