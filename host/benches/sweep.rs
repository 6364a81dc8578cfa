//! Times the sweep of whole motions for crossings, with and without a lattice.
//!
//! `cargo bench -p foldpath --bench sweep`.

use core::time::Duration;
use std::path::Path;
use std::time::Instant;

use foldpath::collision::{Sweep, SweepOptions};
use foldpath::lattice::Lattice;
use foldpath::pattern::CreasePattern;
use foldpath::read::read_pattern;
use foldpath::symmetry::CreaseGroups;
use foldpath_core::{Curve, Membership};

const PATTERNS: [&str; 8] = [
    "miura-3x3",
    "miura-5x5",
    "miura-11x11",
    "miura-24x24",
    "waterbomb-4x6",
    "waterbomb-8x10",
    "waterbomb-12x22",
    "waterbomb-12x22-crossing",
];

/// Number of runs, of which the shortest counts.
const RUNS: usize = 11;

fn main() {
    let only = std::env::args()
        .nth(1)
        .filter(|name| !name.starts_with('-'));
    let fits = |name: &&&str| only.as_ref().is_none_or(|only| name.contains(only));
    for name in PATTERNS.iter().filter(fits) {
        let (pattern, memberships, motion) = read(name);
        let start = Instant::now();
        let lattice = Lattice::find(&pattern, &memberships);
        println!("{name}: lattice found in {:?}", start.elapsed());
        time(&pattern, &memberships, &motion, None);
        if let Some(lattice) = &lattice {
            time(&pattern, &memberships, &motion, Some(lattice));
        }
    }
}

/// Prints the shortest times of the runs: to set the sweep up, and to sweep the motion.
fn time(
    pattern: &CreasePattern,
    memberships: &[Membership],
    motion: &[Vec<Curve<f64>>],
    lattice: Option<&Lattice>,
) {
    let mut least = [Duration::MAX; 2];
    for run in 0..RUNS {
        let options = SweepOptions::default();
        let start = Instant::now();
        let mut sweep = Sweep::new(pattern, memberships, options, lattice);
        least[0] = least[0].min(start.elapsed());
        let start = Instant::now();
        let verdict = sweep.sweep(motion);
        least[1] = least[1].min(start.elapsed());
        if run + 1 == RUNS {
            let with = if lattice.is_some() { "with" } else { "without" };
            println!(
                "  {with} lattice {least:?}\n    {verdict:?}\n    {:?}",
                sweep.counts()
            );
        }
    }
}

/// Reads a pattern and makes its closed-form motion from flat to its goal. The tangents of half the fold angles keep
/// their ratios, except those of the waterbomb's boundary lines, which are 3t + 4t³.
fn read(name: &str) -> (CreasePattern, Vec<Membership>, Vec<Vec<Curve<f64>>>) {
    let path = format!("{}/../patterns/{name}.fold", env!("CARGO_MANIFEST_DIR"));
    let pattern = read_pattern(Path::new(&path)).unwrap().pattern;
    let groups = CreaseGroups::find(&pattern);
    let mut goals = vec![0.0_f64; groups.len()];
    for (&edge, member) in pattern.creases().iter().zip(groups.memberships()) {
        goals[member.group.index()] = member.apply(pattern.edge(edge).goal.unwrap());
    }
    let tangents: Vec<f64> = goals.iter().map(|goal| (goal / 2.0).tan()).collect();
    let least = tangents
        .iter()
        .fold(f64::MAX, |t, tangent| t.min(tangent.abs()));
    let most = tangents
        .iter()
        .fold(0.0_f64, |t, tangent| t.max(tangent.abs()));
    let scale = 1.0 / (1.0 + most);
    let curve = |&tangent: &f64| {
        if name.starts_with("miura") {
            let (cos, sin) = (scale, tangent * scale);
            Curve::HalfAngle {
                cos: [1.0, 2.0 / 3.0 + cos / 3.0, 1.0 / 3.0 + 2.0 * cos / 3.0, cos],
                sin: [0.0, sin / 3.0, 2.0 * sin / 3.0, sin],
            }
        } else {
            let cubic = if (tangent.abs() - most).abs() < 1e-9 {
                4.0 * least.powi(3)
            } else {
                0.0
            };
            let linear = tangent - cubic * tangent.signum();
            Curve::HalfAngle {
                cos: [1.0; 4],
                sin: [0.0, linear / 3.0, linear * 2.0 / 3.0, tangent],
            }
        }
    };
    let motion = vec![tangents.iter().map(curve).collect()];
    (pattern, groups.memberships().to_vec(), motion)
}
