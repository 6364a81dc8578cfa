//! One sheet gets one verdict, in whichever way it is drawn.

use core::time::Duration;

use foldpath_tests::campaign::Family;
use foldpath_tests::campaign::drawn::{families, run};

/// Time for a plan. A drawing whose plan takes longer is not compared.
const TIMEOUT: Duration = Duration::from_secs(10);

/// Draws `count` sheets of families with these names, or of all families, and compares the verdicts. The sheets have seeds
/// from `seed` on.
fn alike(names: &[&str], seed: u64, count: usize) {
    let is_asked = |family: &&Family| names.is_empty() || names.contains(&family.name);
    let families: Vec<&Family> = families().filter(is_asked).collect();
    let drawn = run(&families, seed, count, TIMEOUT);
    println!(
        "{} sheets, {} planned; {} drawings compared, {} ran out of time, {} differ",
        drawn.sheets,
        drawn.planned,
        drawn.drawings,
        drawn.late,
        drawn.differences.len()
    );
    for difference in &drawn.differences {
        println!("{difference}");
    }
    assert_eq!(drawn.differences, [""; 0]);
    assert!(2 * drawn.planned > drawn.sheets, "{drawn:?}");
}

#[test]
fn sheets_get_one_verdict_in_all_drawings() {
    alike(&[], 1, 18);
}

/// Sheets whose verdicts once hung on rounding: on whether a stop closes to 1e-14, on the derivatives of zero of a line
/// through the vertex that its creases share, and on whether hinges are parallel to the last digit.
#[test]
fn sheets_that_rounding_splits_get_one_verdict_in_all_drawings() {
    for (name, seed) in [
        ("simple-folds", 175),
        ("fan", 210),
        ("windows", 198),
        ("windows", 288),
    ] {
        alike(&[name], seed, 1);
    }
}

/// The long form, in the full tier.
#[test]
#[ignore = "takes minutes"]
fn many_sheets_get_one_verdict_in_all_drawings() {
    alike(&[], 1, 300);
}

#[test]
#[ignore = "takes minutes"]
fn many_folds_through_all_layers_get_one_verdict_in_all_drawings() {
    alike(&["simple-folds"], 1, 200);
}

#[test]
#[ignore = "takes minutes"]
fn many_nets_get_one_verdict_in_all_drawings() {
    alike(&["net"], 1, 60);
}
