//! Sheets with freedom to spare are led round crossings: the oracle and `check` judge the paths.

use foldpath::check::check;
use foldpath::export::fold::motion_text;
use foldpath::generate::Resch;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, Outcome, PlanOptions, Search, Strategy, plan};
use foldpath_tests::{Animation, CONTACT, judge, path_file, strict};

#[test]
fn the_resch_pattern_of_six_stars_each_way_is_planned() {
    let resch = Resch {
        rows: 6,
        columns: 6,
    };
    let pattern = CreasePattern::new(resch.drawing().unwrap()).unwrap();
    let goal = Goal::of_pattern(&pattern).unwrap();
    let straight = PlanOptions::default().with(|it| it.search = Search::Path);
    let straight = plan(&pattern, &goal, &straight);
    assert!(matches!(straight.outcome, Outcome::Crossing(_)));
    let options = PlanOptions::default();
    let plan = plan(&pattern, &goal, &options);
    assert_eq!(plan.outcome, Outcome::Planned);
    let last = plan.attempts.last().unwrap();
    assert_eq!(last.strategy, Strategy::WayRound);
    let text = motion_text(plan.motion.as_ref().unwrap());
    let path = Animation::parse(&text).unwrap();
    let angles = pattern.edges().iter().map(|edge| edge.goal);
    let judged = judge(
        &path,
        &angles.collect::<Vec<_>>(),
        &plan,
        options.bound,
        CONTACT,
    );
    assert_eq!(judged.disagreements, [""; 0]);
    let verdict = check(&path_file(&text).unwrap(), &strict());
    assert_eq!(verdict.findings(), [""; 0]);
}
