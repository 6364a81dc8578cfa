//! A short campaign: whatever becomes of a sheet, nothing panics, every answer that is not a path says
//! why, and the oracle agrees with every path.

use core::time::Duration;

use foldpath::formats::fold::PathWriter;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, PlanOptions, plan};
use foldpath_tests::campaign::{Family, Report, run};
use foldpath_tests::{Animation, judge};

/// Sheets of each family.
const EACH: u64 = 20;

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
        // Every goal that could be reached is.
        let plans = tally.creases.len();
        assert_eq!(tally.planned + tally.crossed_goals, plans, "{name}");
        assert_eq!(tally.inexact, [0; 0], "{name}");
    }
}

/// The judge of campaigns agrees with a good path, and with none whose middle knot is off by a little.
#[test]
fn a_spoilt_path_finds_no_agreement() {
    const LITTLE: f64 = 1e-6;
    let options = PlanOptions::default();
    for family in Family::ALL {
        let drawing = family.sheet(1);
        let pattern = CreasePattern::new(drawing.clone()).unwrap();
        let goal = Goal::of_pattern(&pattern).unwrap();
        let plan = plan(&pattern, &goal, &options);
        let writer = PathWriter {
            title: family.name,
            pattern: &pattern,
            vertices: true,
            seed: 0,
            max_speed: options.max_speed,
            max_acceleration: options.max_acceleration,
        };
        let goal = drawing.edges.iter().map(|edge| edge.goal.unwrap_or(0.0));
        let goal: Vec<f64> = goal.collect();
        let mut path = Animation::parse(&writer.text(&plan.path)).unwrap();
        let good = judge(&path, &goal, &plan, options.bound);
        assert_eq!(good.disagreements, [""; 0], "{}", family.name);
        assert!(good.exact, "{}", family.name);
        let crease = goal.iter().position(|angle| angle.abs() > 0.0).unwrap();
        let middle = path.frames.len() / 2;
        path.frames[middle].angles[crease] += LITTLE;
        let spoilt = judge(&path, &goal, &plan, options.bound);
        assert!(!spoilt.disagreements.is_empty(), "{}", family.name);
        assert!(!spoilt.exact, "{}", family.name);
    }
}
