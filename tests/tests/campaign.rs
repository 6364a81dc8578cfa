//! A short campaign: whatever becomes of a sheet, nothing panics, every answer that is not a path says
//! why, and the oracle agrees with every path.

use core::time::Duration;

use foldpath::planner::PlanOptions;
use foldpath_tests::campaign::{Family, Report, run};

/// Sheets of each family.
const EACH: u64 = 5;

#[test]
fn a_campaign_finds_no_wrong_path() {
    let options = PlanOptions {
        timeout: Some(Duration::from_secs(10)),
        ..PlanOptions::default()
    };
    let tallies = Family::ALL
        .iter()
        .map(|&family| (family, run(family, 1, EACH, &options)));
    let report = Report(tallies.collect());
    println!("{report}");
    for (family, tally) in &report.0 {
        let name = family.name;
        assert_eq!(tally.panics, [], "{name}");
        assert_eq!(tally.disagreements, [], "{name}");
        assert_eq!(tally.silent, [0; 0], "{name}");
        assert_eq!(tally.late, [0; 0], "{name}");
    }
}
