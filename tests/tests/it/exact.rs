//! Compares the verdicts of the sweep with those of exact arithmetic.

use foldpath::collision::{Sweep, SweepOptions, SweepVerdict};
use foldpath_core::{GroupId, Membership};
use foldpath_test_support::Random;
use foldpath_tests::exact::{Hinge, Strip, TURNS, Truth, UNITS};

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

#[test]
fn sweeps_answer_as_exact_arithmetic_does() {
    let mut counts = [[0_u32; 3]; 3];
    let mut wrong = Vec::new();
    for seed in 0..1000 {
        let mut random = Random::stream(seed, 7);
        let hinges = random.whole(2, 4);
        let strip = if seed % 3 == 0 {
            let gap = random.log_uniform(1e-9, 1e-3) * random.sign();
            Strip::nearly_touching(&mut random, hinges, gap)
        } else {
            Strip::random(&mut random, hinges)
        };
        let contact = CONTACT_EDGES * strip.pattern().median_edge();
        let truth = strip.judge(contact);
        let verdict = swept(&strip);
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
    println!("free, touching, crossing, each said to be free, undecided, crossing: {counts:?}");
    assert!(wrong.is_empty(), "{wrong:#?}");
    // The queries are of all kinds, and hardly any that is free is not said to be.
    let [free, touching, crossing] = counts.map(|row| row.iter().sum::<u32>());
    assert!(free > 500 && touching > 20 && crossing > 50);
    assert!(100 * counts[0][1] <= free);
}
