//! Panels with windows, flaps, doors, slots and pop-ups: generated sheets are planned, and every path is judged by `check`
//! and by the oracle.

use core::time::Duration;

use foldpath::planner::PlanOptions;
use foldpath_tests::campaign::{Family, run};

#[test]
fn panels_with_things_cut_into_them_fold() {
    let family = Family::ALL.iter().find(|it| it.name == "windows").unwrap();
    let options = PlanOptions::default().with(|it| it.timeout = Some(Duration::from_secs(10)));
    let tally = run(*family, 1, 60, &options);
    println!("{tally:?}");
    assert_eq!(tally.panics, []);
    assert_eq!(tally.disagreements, []);
    assert_eq!(tally.silent, [0; 0]);
    assert_eq!(tally.late, [0; 0]);
    assert_eq!(tally.inexact, [0; 0]);
    // Every goal that can be reached is reached.
    assert_eq!(
        tally.planned + tally.crossed_goals,
        60,
        "{:?}",
        tally.others
    );
}
