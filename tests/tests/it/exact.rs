//! Compares the verdicts of the sweep with those of exact arithmetic.

use std::time::Instant;

use foldpath::collision::{Sweep, SweepOptions, SweepVerdict};
use foldpath_core::{GroupId, Membership};
use foldpath_test_support::Random;
use foldpath_tests::exact::{Hinge, Strip, TURNS, Truth, UNITS};
use rayon::prelude::*;

/// Depth up to which panels may overlap, in median edges.
const CONTACT_EDGES: f64 = 1e-6;

/// Returns three unit squares in a row, whose hinges turn evenly in tan ρ/2 up to this angle (degrees).
fn tube(angle: f64) -> Strip {
    let (sin, cos) = (angle.to_radians() / 2.0).sin_cos();
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        reason = "41 bits"
    )]
    let [cos, sin] = [cos, sin].map(|part| (part * TURNS as f64).round() as i64);
    let hinge = |x: i64| Hinge {
        start: [x * UNITS, 0],
        along: [0, -1],
        length: 1,
        cos: [TURNS, cos],
        sin: [0, sin],
    };
    Strip {
        across: (0..4)
            .map(|x| [[x * UNITS, 0], [x * UNITS, UNITS]])
            .collect(),
        hinges: vec![hinge(1), hinge(2)],
    }
}

/// Sides of a triangular tube meet where each turns by 120 degrees.
#[test]
fn a_triangular_tube_closes_at_120_degrees() {
    for (angle, truth) in [
        (90.0, Truth::Free),
        (119.99999, Truth::Free),
        (120.00000000001, Truth::Touches),
        (120.001, Truth::Crosses),
        (170.0, Truth::Crosses),
        (-119.99999, Truth::Free),
        (-120.001, Truth::Crosses),
    ] {
        assert_eq!(tube(angle).judge(CONTACT_EDGES), truth, "{angle}");
    }
}

fn swept(strip: &Strip) -> SweepVerdict {
    let pattern = strip.pattern();
    let own = |group| Membership {
        group: GroupId(group),
        negative: false,
    };
    let memberships: Vec<_> = (0..).take(strip.hinges.len()).map(own).collect();
    let options = SweepOptions::default();
    Sweep::new(&pattern, &memberships, options, None).sweep(&[strip.curves()])
}

/// Seeds of strips that cross as they end, by little more than contact: the panels enclose small angles, so that they hardly
/// reach through each other's planes.
const NEARLY_FREE: [u64; 13] = [
    2133, 3231, 3333, 3492, 5067, 6210, 6663, 8052, 9309, 10332, 10617, 11061, 59286,
];

/// Verdict of a sweep on a strip, and of exact arithmetic.
struct Judged {
    truth: Truth,
    verdict: SweepVerdict,
    /// Seconds that the sweep took, and that exact arithmetic took.
    seconds: [f64; 2],
}

/// Judges the strip of a seed. A third of them end where two panels touch or miss each other by 1e-3 to 1e-9 radians.
fn judged(seed: u64) -> Judged {
    let mut random = Random::stream(seed, 7);
    let hinges = random.whole(2, 4);
    let strip = if seed.is_multiple_of(3) {
        let gap = random.log_uniform(1e-9, 1e-3) * random.sign();
        Strip::nearly_touching(&mut random, hinges, gap)
    } else {
        Strip::random(&mut random, hinges)
    };
    let start = Instant::now();
    let verdict = swept(&strip);
    let swept = start.elapsed();
    let contact = CONTACT_EDGES * strip.pattern().median_edge();
    let start = Instant::now();
    let truth = strip.judge(contact);
    Judged {
        truth,
        verdict,
        seconds: [swept, start.elapsed()].map(|time| time.as_secs_f64()),
    }
}

/// Judges strips with these seeds, and prints a table of the verdicts.
fn compare(seeds: Vec<u64>) {
    let judged: Vec<(u64, Judged)> = seeds
        .into_par_iter()
        .map(|seed| (seed, judged(seed)))
        .collect();
    let mut counts = [[0_usize; 3]; 3];
    let mut wrong = Vec::new();
    for (seed, Judged { truth, verdict, .. }) in &judged {
        let column = match verdict {
            SweepVerdict::Free(_) => 0,
            SweepVerdict::Undecided { .. } => 1,
            _ => 2,
        };
        let row = match truth {
            Truth::Free => 0,
            Truth::Touches => 1,
            Truth::Crosses => 2,
        };
        counts[row][column] += 1;
        if row.abs_diff(column) == 2 {
            wrong.push(format!("seed {seed}: {truth:?}, not {verdict:?}"));
        }
    }
    println!("| truth | said to be free | undecided | said to cross |");
    println!("|---|---|---|---|");
    for (row, name) in ["free", "between", "crosses"].into_iter().enumerate() {
        let [free, undecided, crosses] = counts[row];
        println!("| {name} | {free} | {undecided} | {crosses} |");
    }
    let median = |k: usize| {
        let mut seconds: Vec<f64> = judged.iter().map(|(_, it)| it.seconds[k]).collect();
        seconds.sort_by(f64::total_cmp);
        1e6 * seconds[seconds.len() / 2]
    };
    println!(
        "a query takes {:.0} µs (median), and {:.0} µs in exact arithmetic",
        median(0),
        median(1)
    );
    assert!(wrong.is_empty(), "{wrong:#?}");
    // The queries are of all kinds, and hardly any that is free is not said to be.
    let [free, touching, crossing] = counts.map(|row| row.iter().sum::<usize>());
    assert!(2 * free > judged.len() && 50 * touching > judged.len());
    assert!(20 * crossing > judged.len());
    assert!(100 * counts[0][1] <= free);
}

#[test]
fn sweeps_answer_as_exact_arithmetic_does() {
    compare((0..1000).chain(NEARLY_FREE).collect());
}

/// The long form, in the full tier.
#[test]
#[ignore = "takes a quarter of an hour"]
fn many_sweeps_answer_as_exact_arithmetic_does() {
    compare((0..100_000).collect());
}
