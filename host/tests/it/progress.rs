//! Tests long calls that are watched: their progress, and their answers after they are cancelled.

use core::time::Duration;

use crate::common::{miura, path_text};
use foldpath::check::{self, CheckOptions, Undecided, check, check_watched};
use foldpath::motion::Motion;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, Outcome, Plan, PlanOptions, plan_watched};
use foldpath::plot::Curves;
use foldpath::progress::{Progress, Stage};
use foldpath::read::fold::parse_motion;
use foldpath::read::{FileError, parse_pattern_watched, parse_shape};
use foldpath::unfold::{ShapeError, UnfoldOptions, unfold_watched};
use foldpath::view::{Scene, page};

/// Returns a small sheet and its plan.
fn planned(progress: &Progress) -> (CreasePattern, Plan) {
    let pattern = CreasePattern::new(miura(3, 3, 0.7)).unwrap();
    let goal = Goal::of_pattern(&pattern).unwrap();
    let plan = plan_watched(&pattern, &goal, &PlanOptions::default(), progress);
    (pattern, plan)
}

/// Returns a path as it is read from its file.
fn path() -> Motion {
    let (_, plan) = planned(&Progress::new());
    let text = path_text("a path", &plan);
    parse_motion("path.fold".as_ref(), text.as_bytes()).unwrap()
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
fn a_cancelled_check_is_undecided() {
    let (path, options) = (path(), CheckOptions::default());
    let watched = check_watched(&path, &options, &Progress::new());
    assert_eq!(watched, check(&path, &options));
    assert_eq!(watched.findings(), [""; 0]);
    let verdicts = [
        check_watched(&path, &options, &cancelled()),
        check(&path, &options.with(|it| it.timeout = Some(Duration::ZERO))),
    ];
    for verdict in verdicts {
        let segments = path.knots.len() - 1;
        let unfinished = Undecided::Unfinished {
            judged: 0,
            segments,
        };
        assert!(verdict.undecided.contains(&unfinished), "{verdict:?}");
        assert_eq!(verdict.outcome(), check::Outcome::Undecided);
        assert_eq!(verdict.certified(), None);
        assert!(verdict.closure_bound().is_infinite());
    }
    let long = options.with(|it| it.timeout = Some(Duration::MAX));
    assert_eq!(check(&path, &long), watched);
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

#[test]
fn a_cancelled_drawing_is_not_read() {
    // Two lines of the FOLD file cross, so that it is repaired.
    let crossed = r#"{"vertices_coords": [[0,0],[1,0],[1,1],[0,1]],
        "edges_vertices": [[0,1],[1,2],[2,3],[3,0],[0,2],[1,3]],
        "edges_assignment": ["B","B","B","B","M","V"]}"#;
    let lines = "1 0 0 1 0\n1 1 0 1 1\n1 1 1 0 1\n1 0 1 0 0\n2 0 0 1 1\n";
    let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9">
        <path d="M1 1H5V5H1Z" stroke="black" fill="none"/><path d="M1 1L5 5" stroke="red"/></svg>"#;
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
    for (name, text) in [
        ("a.fold", crossed),
        ("a.cp", lines),
        ("a.svg", svg),
        ("a.obj", obj),
    ] {
        let read =
            |progress: &Progress| parse_pattern_watched(name.as_ref(), text.as_bytes(), progress);
        read(&Progress::new()).unwrap_or_else(|error| panic!("{error}"));
        let error = read(&cancelled()).unwrap_err();
        assert!(matches!(error, FileError::Cancelled { .. }), "{error}");
        assert_eq!(error.to_string(), format!("{name}: reading was cancelled"));
    }
}

#[test]
fn a_cancelled_shape_is_not_unfolded() {
    let tent = "v 0 0 0\nv 2 0 0\nv 2 1 1\nv 0 1 1\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\nf 4 3 5 6\n";
    let shape = parse_shape("tent.obj".as_ref(), tent.as_bytes(), None, None).unwrap();
    let unfold =
        |progress: &Progress| unfold_watched(&shape.shape, &UnfoldOptions::default(), progress);
    assert!(unfold(&Progress::new()).unwrap().drawing.is_some());
    assert_eq!(unfold(&cancelled()).unwrap_err(), ShapeError::Cancelled);
}
