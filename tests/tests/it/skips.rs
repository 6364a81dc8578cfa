//! Does skipping pairs of faces leave the verdict of the search for crossings unchanged? It must only change the amount
//! of work.

use core::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use foldpath::generate::Waterbomb;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, Outcome, Plan, PlanOptions, Skips, plan};
use foldpath::read::read_pattern;

/// Largest number of faces of patterns that are tried with each switch alone.
const SMALL: usize = 60;
/// Largest number of faces of patterns that are tried in seconds.
const MIDDLE: usize = 300;

fn patterns() -> impl Iterator<Item = PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../patterns");
    let files = std::fs::read_dir(folder).unwrap();
    let files = files.map(|file| file.unwrap().path());
    files.filter(|file| file.extension().is_some_and(|ending| ending == "fold"))
}

const ALL: Skips = Skips {
    symmetry: true,
    motion: true,
    bounds: true,
    edges: true,
};

const NONE: Skips = Skips {
    symmetry: false,
    motion: false,
    bounds: false,
    edges: false,
};

/// Compares the plans of a file under these switches with its plan under all switches.
fn compare(file: &Path, switches: &[Skips]) {
    let pattern = read_pattern(file).unwrap().pattern;
    compare_pattern(&file.display().to_string(), &pattern, switches);
}

/// Compares plans as above, and returns the outcome.
fn compare_pattern(title: &str, pattern: &CreasePattern, switches: &[Skips]) -> Outcome {
    let goal = Goal::of_pattern(pattern).unwrap();
    let with = |skips| {
        let options = PlanOptions::default().with(|it| it.skips = skips);
        plan(pattern, &goal, &options)
    };
    let all = with(ALL);
    for &skips in switches {
        let some = with(skips);
        let name = format!("{title} {skips:?}");
        assert_eq!(some.outcome.name(), all.outcome.name(), "{name}");
        assert!((some.reached - all.reached).abs() < 1e-4, "{name}");
        let clearance = |plan: &Plan| plan.crossings.clearance.map(|clearance| clearance.distance);
        // More queries may find faces that are nearer to each other.
        match (clearance(&all), clearance(&some)) {
            (Some(all), Some(some)) => assert!(some <= all + 1e-9, "{name}: {some} {all}"),
            (all, some) => assert_eq!(all, some, "{name}"),
        }
        let counts = some.crossings.counts;
        let off = [
            (skips.symmetry, counts.skipped_symmetry),
            (skips.motion, counts.skipped_motion),
            (skips.bounds, counts.skipped_bounds),
            (skips.edges, counts.skipped_edges),
        ];
        assert!(
            off.iter().all(|(skips, count)| *skips || *count == 0),
            "{name}: {counts:?}"
        );
        let sum = counts.tested + off.iter().map(|(_, count)| count).sum::<u64>();
        assert_eq!(counts.pairs, sum, "{name}: {counts:?}");
    }
    all.outcome
}

fn faces_of(file: &Path) -> usize {
    read_pattern(file).unwrap().pattern.faces().len()
}

#[test]
fn verdicts_do_not_hang_on_what_is_skipped() {
    let one_off = [
        Skips {
            symmetry: false,
            ..ALL
        },
        Skips {
            motion: false,
            ..ALL
        },
        Skips {
            bounds: false,
            ..ALL
        },
        Skips {
            edges: false,
            ..ALL
        },
        NONE,
    ];
    let small: Vec<PathBuf> = patterns().filter(|file| faces_of(file) <= SMALL).collect();
    assert!(small.len() >= 5, "{small:?}");
    for file in small {
        compare(&file, &one_off);
    }
}

/// Switches for patterns that take long: without the skip by symmetry, and without all skips.
const FEW: [Skips; 2] = [
    Skips {
        symmetry: false,
        ..ALL
    },
    NONE,
];

/// Compares the plans of patterns with these numbers of faces.
fn compare_large(faces: RangeInclusive<usize>) {
    for file in patterns().filter(|file| faces.contains(&faces_of(file))) {
        println!("{}", file.display());
        compare(&file, &FEW);
    }
}

/// A tube of a fifth of the faces of `waterbomb-12x22-crossing.fold`, which the full tier compares.
#[test]
fn verdicts_on_a_tube_that_crosses_do_not_either() {
    let tube = Waterbomb {
        rows: 12,
        columns: 4,
        fold: 0.6,
    };
    let pattern = CreasePattern::new(tube.drawing().unwrap()).unwrap();
    let outcome = compare_pattern("tube", &pattern, &FEW);
    assert!(matches!(outcome, Outcome::Crossing(_)), "{outcome:?}");
}

#[test]
fn verdicts_of_large_patterns_do_not_either() {
    compare_large(SMALL + 1..=MIDDLE);
}

/// The long form, in the full tier.
#[test]
#[ignore = "takes a minute"]
fn verdicts_of_the_largest_patterns_do_not_either() {
    compare_large(MIDDLE + 1..=usize::MAX);
}
