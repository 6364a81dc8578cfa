//! Judges the play that errors of the pattern need by sheets that are closed by nonlinear least squares over fold angles and
//! play, by the linkage of `tests/src/linkage.rs`.

use std::path::Path;

use foldpath::check::{CheckOptions, check};
use foldpath::generate::Yoshimura;
use foldpath::motion::Motion;
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};
use foldpath::planner::{Goal, Outcome, PlanOptions, plan};
use foldpath::progress::{Progress, Watch};
use foldpath::read::{parse_pattern, read_pattern};
use foldpath::sensitivity::{NoTolerance, PlayKind, Tolerance};
use foldpath_tests::linkage::Linkage;
use foldpath_tests::{Random, pattern_file};
use nalgebra::Vector2;

use crate::sensitivity::{miura, pattern, planned};

/// Error of each coordinate, median edges.
const ERROR_EDGES: f64 = 1e-4;
/// Part by which play may be above the bound: what first order leaves out.
const ABOVE: f64 = 1.02;
/// Part of the bound that the corner reaches which the bound names.
const REACHED: f64 = 0.95;
/// Part of the largest bound of the sheet below which second order decides.
const SMALL: f64 = 1e-2;
const SHEETS: usize = 200;

/// A motion with the bounds on its play.
struct Case {
    name: &'static str,
    motion: Motion,
    linkage: Linkage,
    tolerance: Tolerance,
}

impl Case {
    fn new(name: &'static str, pattern: CreasePattern) -> Self {
        let motion = planned(name, &pattern);
        Self {
            name,
            linkage: Linkage::of(&pattern),
            tolerance: Tolerance::of(&motion, Watch::default())
                .unwrap_or_else(|no| panic!("{name}: {no}")),
            motion,
        }
    }

    fn vertices(&self) -> &[Vector2<f64>] {
        self.motion.pattern.vertices()
    }

    /// The closed configuration at a time.
    fn at(&self, time: f64) -> Vec<f64> {
        let start = self.motion.at_times([time]).crease_angles(0);
        self.linkage.closed(self.vertices(), &start, &[])
    }

    /// The components of the play of each hinge, over the error, of a sheet whose vertices are off by these parts of the error.
    fn play(&self, time: f64, off: &[Vector2<f64>]) -> Vec<[f64; 5]> {
        let error = ERROR_EDGES * self.linkage.unit;
        let moved: Vec<_> = self
            .vertices()
            .iter()
            .zip(off)
            .map(|(v, by)| v + by * error)
            .collect();
        let start = self.at(time);
        let drivers = self.linkage.drivers(self.vertices(), &start);
        let shape = self.linkage.closed_with_play(&moved, &start, &drivers);
        let play = shape.play.into_iter();
        play.map(|play| play.map(|s| s.abs() / ERROR_EDGES))
            .collect()
    }

    fn largest(&self) -> f64 {
        self.tolerance.worst().unwrap().worst
    }
}

fn cases() -> Vec<Case> {
    let of_file = |name: &str| read_pattern(&pattern_file(name)).unwrap().pattern;
    let yoshimura = Yoshimura {
        rows: 4,
        columns: 3,
        angle: 35_f64.to_radians(),
        fold: 0.6,
    };
    vec![
        Case::new("miura 3x3, 60 degrees", miura(3, 3, 60.0)),
        Case::new("miura 3x3, 45 degrees", miura(3, 3, 45.0)),
        Case::new("miura 3x3, 80 degrees", miura(3, 3, 80.0)),
        Case::new("miura 3x4", miura(3, 4, 60.0)),
        Case::new("miura 4x3", miura(4, 3, 70.0)),
        Case::new("miura 4x4", miura(4, 4, 60.0)),
        Case::new("square twist", of_file("square-twist-1x1")),
        Case::new("yoshimura", pattern(yoshimura.drawing())),
    ]
}

#[test]
fn no_random_sheet_needs_more_play_than_the_bound() {
    judge_random_sheets(SHEETS);
}

#[test]
#[ignore = "takes a minute: `tests/run full` runs it"]
fn none_of_ten_thousand_random_sheets_needs_more_play_than_the_bound() {
    judge_random_sheets(50 * SHEETS);
}

fn judge_random_sheets(count: usize) {
    for (seed, case) in (500..).zip(cases()) {
        let mut random = Random::new(seed);
        let mut most = 0.0_f64;
        for _ in 0..count {
            let time = case.tolerance.times[random.below(case.tolerance.times.len())];
            let off: Vec<_> = case
                .vertices()
                .iter()
                .map(|_| Vector2::new(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)))
                .collect();
            for (play, bound) in case.play(time, &off).iter().zip(&case.tolerance.hinges) {
                let play = play.iter().fold(0.0_f64, |a, b| a.max(*b));
                let bound = bound.worst.max(SMALL * case.largest());
                assert!(
                    play <= ABOVE * bound,
                    "{}: {play} above {bound} at {time}",
                    case.name
                );
                most = most.max(play / bound);
            }
        }
        println!(
            "{}: bound {:.3}, random sheets reach {most:.2} of it",
            case.name,
            case.largest()
        );
    }
}

#[test]
fn the_corner_that_the_bound_names_reaches_it() {
    for case in cases() {
        let mut judged = 0;
        let mut least = f64::INFINITY;
        for bound in &case.tolerance.hinges {
            if bound.worst < SMALL * case.largest() {
                continue;
            }
            let off: Vec<_> = bound
                .by_vertex
                .iter()
                .map(|by| by.map(f64::signum))
                .collect();
            let kind = PlayKind::ALL
                .iter()
                .position(|kind| *kind == bound.kind)
                .unwrap();
            let play = case.play(bound.at, &off)[bound.crease.index()][kind];
            least = least.min(play / bound.worst);
            assert!(
                play >= REACHED * bound.worst && play <= ABOVE * bound.worst,
                "{}: crease {} needs {play} of {}",
                case.name,
                bound.crease,
                bound.worst
            );
            judged += 1;
        }
        println!(
            "{}: {judged} corners reach {least:.3} of their bounds",
            case.name
        );
        assert!(judged > 0, "{}", case.name);
    }
}

/// A sheet with fewer conditions than creases closes whatever its errors are.
#[test]
fn a_sheet_that_always_closes_needs_no_play() {
    let case = Case::new("miura 2x2", miura(2, 2, 60.0));
    assert!(case.tolerance.worst().is_none());
    assert_eq!(case.tolerance.error_for(1.0), None);
    assert!(case.tolerance.redundant.is_empty());
    // The way round the slot beside a flap crosses its hinge twice, so that nothing closes there.
    let flap = "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 9 9'><path stroke='black' d='M0,0H9V9H0ZM3,6V3H6V6'/>\
                <path stroke='red' stroke-opacity='0.5' d='M3,6H6'/></svg>";
    let file = parse_pattern(Path::new("flap.svg"), flap.as_bytes()).unwrap();
    let case = Case::new("flap", file.pattern);
    assert!(case.tolerance.worst().is_none() && case.tolerance.redundant.is_empty());
}

#[test]
fn hinges_are_redundant_if_and_only_if_the_rest_holds_the_sheet() {
    let mut counts = [0, 0];
    for case in cases() {
        let times = &case.tolerance.times;
        let middle = case.at(times[times.len() / 2]);
        let freedom = |cut: &[usize]| case.linkage.freedom(case.vertices(), &middle, cut);
        for crease in 0..middle.len() {
            let named = case
                .tolerance
                .redundant
                .iter()
                .any(|id| id.index() == crease);
            let holds = freedom(&[crease]) == freedom(&[]);
            assert_eq!(named, holds, "{}: crease {crease}", case.name);
            counts[usize::from(named)] += 1;
        }
    }
    println!("{} hinges are needed, {} are not", counts[0], counts[1]);
    assert!(counts.iter().all(|count| *count > 0));
}

#[test]
fn expected_play_is_the_root_mean_square_of_random_sheets() {
    let case = Case::new("miura 3x3", miura(3, 3, 60.0));
    let bound = case.tolerance.worst().unwrap();
    let kind = PlayKind::ALL
        .iter()
        .position(|kind| *kind == bound.kind)
        .unwrap();
    let norm = bound
        .by_vertex
        .iter()
        .map(Vector2::norm_squared)
        .sum::<f64>()
        / 3.0;
    let mut random = Random::new(61);
    let mut square = 0.0;
    const DRAWS: usize = 400;
    for _ in 0..DRAWS {
        let off: Vec<_> = case
            .vertices()
            .iter()
            .map(|_| Vector2::new(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)))
            .collect();
        square += case.play(bound.at, &off)[bound.crease.index()][kind].powi(2) / DRAWS as f64;
    }
    // The relative error of a mean of 400 squares of nearly normal numbers is about 7 %, twice which is three deviations of
    // its root.
    let ratio = (square / norm).sqrt();
    assert!((ratio - 1.0).abs() < 0.12, "{ratio}");
    assert!(bound.expected >= norm.sqrt() * (1.0 - 1e-12));
    assert!(bound.expected < bound.worst);
}

#[test]
fn a_motion_that_stays_flat_has_no_tolerance() {
    let pattern = std::sync::Arc::new(miura(3, 3, 60.0));
    let flat = Motion::flat("flat", pattern);
    let cancelled = Progress::new();
    cancelled.cancel();
    let motion = Case::new("miura 2x2", miura(2, 2, 60.0)).motion;
    let none = Tolerance::of(&motion, Watch::new(&cancelled));
    assert_eq!(none.err(), Some(NoTolerance::Cancelled));
    assert_eq!(
        Tolerance::of(&flat, Watch::default()).err(),
        Some(NoTolerance::Flat)
    );
}

/// Hinges that end at the border are cut there; a cut along a single edge inside the sheet is a hinge still.
#[test]
fn a_sheet_without_a_redundant_hinge_is_planned_and_proved() {
    let mut proved = 0;
    for case in cases() {
        let pattern = &case.motion.pattern;
        let at_border = case.tolerance.redundant.iter().filter(|crease| {
            let ends = pattern.edge(pattern.creases()[crease.index()]).ends;
            ends.iter().any(|end| !pattern.is_real(*end))
        });
        for crease in at_border.take(2) {
            let cut = pattern.creases()[crease.index()];
            let edges = pattern
                .edges()
                .iter()
                .enumerate()
                .map(|(index, edge)| DrawnEdge {
                    ends: edge.ends.map(|end| end.index()),
                    letter: if index == cut.index() {
                        Letter::Cut
                    } else {
                        edge.letter
                    },
                    goal: edge.goal.filter(|_| index != cut.index()),
                });
            let faces = pattern
                .faces()
                .iter()
                .map(|face| face.iter().map(|v| v.index()).collect());
            let drawing = Drawing {
                vertices: pattern.vertices().to_vec(),
                edges: edges.collect(),
                faces: Some(faces.collect()),
            };
            let rest = CreasePattern::new(drawing).unwrap();
            assert_eq!(rest.creases().len() + 1, pattern.creases().len());
            let goal = Goal::of_pattern(&rest).unwrap();
            let plan = plan(&rest, &goal, &PlanOptions::default());
            assert_eq!(
                plan.outcome,
                Outcome::Planned,
                "{} without hinge {cut}",
                case.name
            );
            let motion = plan.motion.unwrap();
            let verdict = check(&motion, &CheckOptions::default());
            assert!(
                verdict.holds(),
                "{} without hinge {cut}: {:?}",
                case.name,
                verdict.failures
            );
            // The rest has no other motions than the whole sheet.
            let end = motion.knots.last().unwrap().time;
            let angles = motion.at_times([0.5 * end]).crease_angles(0);
            let linkage = Linkage::of(&rest);
            let closed = linkage.closed(rest.vertices(), &angles, &[]);
            assert_eq!(
                linkage.freedom(rest.vertices(), &closed, &[]),
                case.linkage
                    .freedom(case.vertices(), &case.at(case.tolerance.times[3]), &[]),
            );
            proved += 1;
        }
    }
    assert!(proved >= 8, "{proved}");
}
