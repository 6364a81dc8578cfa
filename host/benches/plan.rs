//! Times whole plans, without reading and writing, and the stages of each plan.
//!
//! `cargo bench -p foldpath --bench plan` prints divan's table; with `-- stages` it prints the table of
//! `docs/benchmarks/plan.md`, with the median time of each stage over 101 plans.

use std::path::Path;

use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, Outcome, Plan, PlanOptions, plan};
use foldpath::read::read_pattern;

const PATTERNS: [&str; 8] = [
    "miura-3x3",
    "miura-5x5",
    "miura-11x11",
    "miura-24x24",
    "waterbomb-4x6",
    "waterbomb-8x10",
    "waterbomb-12x22",
    "yoshimura-12x12",
];

fn main() {
    if std::env::args().any(|argument| argument == "stages") {
        stages();
    } else {
        divan::main();
    }
}

fn read(name: &str) -> (CreasePattern, Goal) {
    let path = format!("{}/../patterns/{name}.fold", env!("CARGO_MANIFEST_DIR"));
    let pattern = read_pattern(Path::new(&path)).unwrap().pattern;
    let goal = Goal::of_pattern(&pattern).unwrap();
    (pattern, goal)
}

#[divan::bench(args = PATTERNS)]
fn whole_plan(bencher: divan::Bencher<'_, '_>, name: &str) {
    let (pattern, goal) = read(name);
    bencher.bench_local(|| plan(&pattern, &goal, &PlanOptions::default()));
}

#[divan::bench(args = PATTERNS)]
fn without_collision(bencher: divan::Bencher<'_, '_>, name: &str) {
    let (pattern, goal) = read(name);
    let options = PlanOptions::default().with(|it| it.collision = false);
    bencher.bench_local(|| plan(&pattern, &goal, &options));
}

fn stages() {
    println!("Medians of 101 plans, reading and writing left out.\n");
    println!(
        "| sheet | hinges | unknowns | knots | symmetry | solve | place | fold | collision | total | \
         certified deformation |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for name in PATTERNS {
        let (pattern, goal) = read(name);
        let plans: Vec<Plan> = (0..101)
            .map(|_| plan(&pattern, &goal, &PlanOptions::default()))
            .collect();
        assert!(plans.iter().all(|plan| plan.outcome == Outcome::Planned));
        let median = |stage: fn(&Plan) -> core::time::Duration| {
            let mut times: Vec<_> = plans.iter().map(stage).collect();
            times.sort_unstable();
            times[times.len() / 2].as_secs_f64() * 1e3
        };
        println!(
            "| {name} | {} | {} | {} | {:.3} ms | {:.3} ms | {:.3} ms | {:.2} ms | {:.2} ms | {:.2} ms | \
             {:.1e} |",
            pattern.creases().len(),
            plans[0].reduced.groups,
            plans[0].knots().len(),
            median(|p| p.effort.times.symmetry),
            median(|p| p.effort.times.solve),
            median(|p| p.effort.times.place),
            median(|p| p.effort.times.fold),
            median(|p| p.effort.times.collision),
            median(|p| p.effort.times.symmetry
                + p.effort.times.solve
                + p.effort.times.place
                + p.effort.times.fold
                + p.effort.times.collision),
            plans[0].certified_deformation().unwrap_or(f64::NAN),
        );
    }
}
