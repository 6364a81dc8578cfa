//! Tests long calls that are watched: their progress, and their answers after they are cancelled.

use crate::common::{miura, path_text};
use foldpath::check::{CheckOptions, check, check_watched};
use foldpath::formats::fold::{PathFile, parse_path};
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, Outcome, Plan, PlanOptions, plan_watched};
use foldpath::plot::Curves;
use foldpath::progress::{Progress, Stage};
use foldpath::view::{Scene, page};

/// Returns a small sheet and its plan.
fn planned(progress: &Progress) -> (CreasePattern, Plan) {
    let pattern = CreasePattern::new(miura(3, 3, 0.7)).unwrap();
    let goal = Goal::of_pattern(&pattern).unwrap();
    let plan = plan_watched(&pattern, &goal, &PlanOptions::default(), progress);
    (pattern, plan)
}

/// Returns a path as it is read from its file.
fn path() -> PathFile {
    let (pattern, plan) = planned(&Progress::new());
    let text = path_text("a path", &pattern, &plan.path);
    parse_path("path.fold".as_ref(), text.as_bytes()).unwrap()
}

fn cancelled() -> Progress {
    let progress = Progress::new();
    progress.cancel();
    progress
}

#[test]
fn a_plan_ends_with_looking_for_crossings() {
    let progress = Progress::new();
    let (_, plan) = planned(&progress);
    assert_eq!(plan.outcome, Outcome::Planned);
    assert_eq!(progress.now().0, Stage::Crossings);
    assert!(!progress.is_cancelled());
}

#[test]
fn a_cancelled_plan_is_out_of_time() {
    let (_, plan) = planned(&cancelled());
    assert_eq!(plan.outcome, Outcome::Timeout);
}

#[test]
fn a_cancelled_check_fails_and_says_why() {
    let (path, options) = (path(), CheckOptions::default());
    let watched = check_watched(&path, &options, &Progress::new());
    assert_eq!(watched, check(&path, &options));
    assert_eq!(watched.failures, [""; 0]);
    let verdict = check_watched(&path, &options, &cancelled());
    let said = |failure: &String| failure.contains("cancelled");
    assert!(verdict.failures.iter().any(said), "{:?}", verdict.failures);
}

#[test]
fn cancelled_curves_and_scenes_lack_clearances() {
    let path = path();
    let curves = Curves::of_path_watched(&path, &Progress::new());
    assert!(!curves.clearance.is_empty());
    let curves = Curves::of_path_watched(&path, &cancelled());
    assert_eq!(curves.clearance, []);
    assert!(!curves.angles.is_empty());

    let scene = Scene::of_path_watched(&path, &Progress::new());
    assert_eq!(page(&scene), page(&Scene::of_path(&path)));
    let cancelled = Scene::of_path_watched(&path, &cancelled());
    assert_eq!(cancelled.shapes.len(), scene.shapes.len());
    assert!(cancelled.shapes.iter().all(|s| s.clearance.is_none()));
}
