//! Planning with every crease an unknown of its own, collision off, for the same motion: Miura sheets
//! from flat to 150 degrees, and the 12x22 waterbomb.
//!
//! `cargo bench -p foldpath --bench full_dof`; `-- large` adds the 200x200 sheet of 79,600 hinges.

use core::time::Duration;

use foldpath::generate::{Miura, Waterbomb};
use foldpath::pattern::{CreasePattern, Drawing};
use foldpath::planner::{Goal, Outcome, PlanOptions, Symmetry, plan};

fn main() {
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let large = std::env::args().any(|argument| argument == "large");
    println!("Medians of whole plans without reading and writing, one core.\n");
    println!(
        "| sheet | unknowns | configurations | knots | plan | each | of it solve | closure | runs |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    run("waterbomb 12x22", 15, waterbomb());
    run("miura 11x11", 51, miura(11));
    let mut sizes = vec![(24, 31), (48, 11), (96, 5)];
    if large {
        sizes.push((200, 1));
    }
    let growth: Vec<_> = sizes
        .iter()
        .map(|&(size, runs)| run(&format!("miura {size}x{size}"), runs, miura(size)))
        .collect();
    println!(
        "\nTime per configuration from 24x24 on grows as unknowns^{:.2}.",
        exponent(&growth)
    );
}

/// Least-squares slope of ln y over ln x.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let sum = |term: fn(f64, f64) -> f64| -> f64 {
        let terms = points.iter().map(|(x, y)| term(x.ln(), y.ln()));
        terms.sum()
    };
    let n = sum(|_, _| 1.0);
    let (x, y) = (sum(|x, _| x), sum(|_, y| y));
    (n * sum(|x, y| x * y) - x * y) / (n * sum(|x, _| x * x) - x * x)
}

fn miura(size: usize) -> Drawing {
    let miura = Miura {
        rows: size,
        columns: size,
        sector_angle: 60_f64.to_radians(),
        fold: 150.0 / 180.0,
    };
    miura.drawing().unwrap()
}

fn waterbomb() -> Drawing {
    let waterbomb = Waterbomb {
        rows: 12,
        columns: 22,
        fold: 0.522_504_840_831_969,
    };
    waterbomb.drawing().unwrap()
}

/// Plans so many times; unknowns and seconds per configuration.
fn run(name: &str, runs: usize, drawing: Drawing) -> (f64, f64) {
    let pattern = CreasePattern::new(drawing).unwrap();
    let goal = Goal::of_pattern(&pattern).unwrap();
    let options = PlanOptions {
        symmetry: Symmetry::Off,
        collision: false,
        // Thirty configurations of the Miura sheets: at most 6.3 degrees between two.
        max_step: 6.3_f64.to_radians(),
        ..PlanOptions::default()
    };
    let plans: Vec<_> = (0..runs).map(|_| plan(&pattern, &goal, &options)).collect();
    assert!(plans.iter().all(|plan| plan.outcome == Outcome::Planned));
    let median = |time: fn(&foldpath::planner::Plan) -> Duration| {
        let mut times: Vec<_> = plans.iter().map(time).collect();
        times.sort_unstable();
        times[runs / 2].as_secs_f64()
    };
    let total = median(|p| p.times.symmetry + p.times.solve + p.times.place + p.times.fold);
    let (waypoints, knots) = (plans[0].waypoints, plans[0].path.knots.len());
    #[allow(clippy::cast_precision_loss, reason = "small counts")]
    let (each, unknowns) = (total / waypoints as f64, plans[0].unknowns as f64);
    println!(
        "| {name} | {} | {waypoints} | {knots} | {total:.4} s | {:.3} ms | {:.4} s | {:.1e} | {runs} |",
        plans[0].unknowns,
        1e3 * each,
        median(|p| p.times.solve),
        plans[0].max_closure,
    );
    (unknowns, each)
}
