//! Real patterns by other authors. They are tested if the environment variable FOLDPATH_EXTERNAL_PATTERNS names a
//! folder of them.

use std::path::{Path, PathBuf};

use foldpath::folding::align_rigid;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Outcome, PlanOptions};
use foldpath::read::fold::PatternFile;
use foldpath::read::read_pattern;
use foldpath::read::{ShapeFile, parse_shape, read_file};
use foldpath::unfold::{self, UnfoldOptions, Unfolding, unfold};
use foldpath_tests::{Animation, Planned, worst};

/// Returns the folder; prints that the test is skipped and returns `None` if there is none.
fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("FOLDPATH_EXTERNAL_PATTERNS").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: FOLDPATH_EXTERNAL_PATTERNS is not set");
    }
    folder
}

/// Numbers of vertices, edges, faces, creases and interior vertices of every FOLD file that is a flat sheet. Another
/// program counted them from the lists of the files; for a file without faces, Euler's formula gives their number.
#[test]
fn fold_files_are_read_whole() {
    let Some(folder) = folder() else { return };
    for (name, expected) in [
        ("report-authors/miura_8_8.fold", [81, 208, 128, 112, 49]),
        ("report-authors/wb_12_6.fold", [91, 234, 144, 162, 55]),
        (
            "report-authors/yoshimura_12_12.fold",
            [169, 456, 288, 276, 121],
        ),
        ("flat-folder/001_ku_Bad_Twist.fold", [16, 24, 9, 12, 4]),
        (
            "flat-folder/074_miuraoripa_Miura-ori.fold",
            [81, 152, 72, 120, 49],
        ),
        ("osbo/birdBase.fold", [13, 28, 16, 20, 5]),
        ("osbo/waterbombBase.fold", [9, 16, 8, 8, 1]),
    ] {
        let pattern = read_pattern(&folder.join(name)).unwrap().pattern;
        let found = [
            pattern.vertices().len(),
            pattern.edges().len(),
            pattern.faces().len(),
            pattern.creases().len(),
            pattern.real_vertices().count(),
        ];
        assert_eq!(found, expected, "{name}");
    }
    for name in ["fold/squaretwist.fold", "fold/box.fold"] {
        let error = read_pattern(&folder.join(name)).unwrap_err().to_string();
        assert!(error.contains("has to be unfolded first"), "{error}");
    }
}

/// The report authors' patterns reach their goals. The goals of the tube and the Yoshimura close only to 1e-3 and 1e-5;
/// their plans reach the nearest configuration that closes. No path has more knots than the authors' own.
#[test]
fn the_report_authors_patterns_are_planned() {
    let Some(folder) = folder() else { return };
    for (name, knots, degrees) in [
        ("miura_8_8", 74, 1e-3),
        ("wb_12_6", 63, 0.1),
        ("yoshimura_12_12", 162, 1.0),
    ] {
        let file = folder
            .join("report-authors")
            .join(name)
            .with_extension("fold");
        let plan = Planned::of(read_pattern(&file).unwrap(), &PlanOptions::default()).plan;
        let what = format!("{name}: {:?} {:?}", plan.reason, plan.errors.rigidity);
        assert_eq!(plan.outcome, Outcome::Planned, "{what}");
        assert!(
            plan.errors.rigidity.deformation <= 1e-6 && plan.errors.rigidity.gap <= 1e-6,
            "{what}"
        );
        assert!(plan.knots().len() <= knots, "{what}");
        assert!(
            plan.arrival.error.to_degrees() <= degrees,
            "{what}: {}",
            plan.arrival.error
        );
    }
}

/// FOLD files of other programs: a Miura folds by its assignments, a sheet with undriven hinges folds, and a twist that
/// is foldable locally but not globally is refused, with the vertex that stands in the way.
#[test]
fn files_of_other_programs_get_their_answers() {
    let Some(folder) = folder() else { return };
    for (name, outcome) in [
        (
            "flat-folder/074_miuraoripa_Miura-ori.fold",
            Outcome::Planned,
        ),
        ("flat-folder/001_ku_Bad_Twist.fold", Outcome::Partial),
        ("osbo/waterbombBase.fold", Outcome::Planned),
    ] {
        let file = read_pattern(&folder.join(name)).unwrap();
        let plan = Planned::of(file, &PlanOptions::default()).plan;
        assert_eq!(plan.outcome, outcome, "{name}: {:?}", plan.reason);
        let reason = plan
            .reason
            .map(|reason| reason.to_string())
            .unwrap_or_default();
        assert_eq!(
            reason.contains("vertex"),
            outcome != Outcome::Planned,
            "{name}: {reason}"
        );
    }
    let error = read_pattern(&folder.join("rtori/one_vertex.fold")).unwrap_err();
    assert!(error.to_string().contains("edges_vertices"), "{error}");
}

/// Reads a folded shape and unfolds it.
fn unfolded(file: &Path) -> (ShapeFile, Unfolding) {
    let file = parse_shape(file, &read_file(file).unwrap(), None, None).unwrap();
    let unfolding = unfold(&file.shape, &UnfoldOptions::default()).unwrap();
    (file, unfolding)
}

/// The rigidly folded square twist, whose coordinates have six digits, folds back to itself. A box folded of a square,
/// with touching layers and coincident vertices, unfolds to that square with all its assignments. No motion from flat
/// has the signs of the box.
#[test]
fn folded_shapes_unfold_and_fold_again() {
    let Some(folder) = folder() else { return };
    let (file, twist) = unfolded(&folder.join("fold/squaretwist.fold"));
    assert_eq!(twist.outcome, unfold::Outcome::Unfolded);
    assert_eq!((twist.creases, twist.cuts), (12, 0));
    let defect = twist.max_angle_defect.to_degrees();
    assert!(defect > 1.2e-4 && defect < 1.3e-4, "{defect}");
    assert!(twist.max_closure.unwrap() < 2e-6, "{twist:?}");
    let pattern = CreasePattern::new(twist.drawing.unwrap()).unwrap();
    let title = file.title;
    let options = PlanOptions::default().with(|it| it.keep_vertices = true);
    let planned = Planned::of(PatternFile { title, pattern }, &options);
    assert_eq!(planned.plan.outcome, Outcome::Planned);
    // The goal, folded by the oracle.
    let path = Animation::parse(&planned.text()).unwrap();
    let goal = path.frames.last().unwrap();
    let folded = path.sheet.positions(&path.sheet.fold(&goal.angles));
    let shape = &file.shape.vertices;
    let apart = align_rigid(&folded, shape);
    let apart = worst(apart.iter().zip(shape).map(|(a, b)| (a - b).norm()));
    assert!(apart < 1e-6 * file.shape.size(), "{apart}");

    let (file, mut folded_box) = unfolded(&folder.join("fold/box.fold"));
    assert_eq!(folded_box.outcome, unfold::Outcome::Unfolded);
    let counts = [folded_box.vertices, folded_box.faces, folded_box.creases];
    assert_eq!((counts, folded_box.cuts), ([39, 42, 58], 0));
    assert!(folded_box.max_angle_defect.to_degrees() < 1e-12);
    assert!(folded_box.max_closure.unwrap() < 1e-12);
    assert!(folded_box.deviation.unwrap() < 1e-12);
    let drawing = folded_box.drawing.take().unwrap();
    for (edge, drawn) in file.shape.edges.iter().zip(&drawing.edges) {
        assert_eq!((edge.ends, edge.letter), (drawn.ends, Some(drawn.letter)));
    }
    let pattern = CreasePattern::new(drawing).unwrap();
    let title = file.title;
    let plan = Planned::of(PatternFile { title, pattern }, &PlanOptions::default()).plan;
    assert_eq!(plan.outcome, Outcome::Partial);
    let reason = plan.reason.unwrap().to_string();
    assert!(
        reason.contains("not all creases can turn with these signs"),
        "{reason}"
    );

    // The report's Yoshimura as its authors folded it; their waterbomb is not a folded sheet.
    let (_, yoshimura) = unfolded(&folder.join("report-authors/yoshimura_12_12.fold"));
    assert_eq!(yoshimura.outcome, unfold::Outcome::Unfolded);
    assert!(yoshimura.deviation.unwrap() < 1e-4);
    let (_, tube) = unfolded(&folder.join("report-authors/wb_12_6.fold"));
    assert_eq!(tube.outcome, unfold::Outcome::NotDevelopable);
    assert!(matches!(
        tube.reason,
        Some(unfold::Reason::AngleDefect { vertex: 73, .. })
    ));
}
