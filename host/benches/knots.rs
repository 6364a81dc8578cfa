//! Number of knots that a path needs until the deformation of the whole sheet is certified, for each interpolation.
//!
//! `cargo bench -p foldpath --bench knots`. In the first table time runs so that few knots suffice, in the second as
//! fast as the speed of the hinges allows.

use core::f64::consts::PI;

use foldpath::generate::{Miura, Waterbomb};
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, Outcome, PlanOptions, Timing, plan};
use foldpath_core::Interpolation;

const BOUND: f64 = 1e-4;

fn main() {
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let kinds = [
        ("linear", Interpolation::Linear),
        ("hermite", Interpolation::Hermite),
        ("half-angle", Interpolation::HalfAngle),
        ("homogeneous", Interpolation::Homogeneous),
    ];
    for (name, pace) in [("sparse", Timing::Sparse), ("optimal", Timing::Optimal)] {
        println!(
            "\nKnots at {BOUND:.0e} certified deformation, `--pace {name}` (certificate, seconds):\n"
        );
        println!("| sheet | {} |", kinds.map(|(name, _)| name).join(" | "));
        println!("|---|---|---|---|---|");
        for (sheet, pattern) in sheets() {
            let goal = Goal::of_pattern(&pattern).expect("a goal");
            let cells = kinds.map(|(_, kind)| {
                let plan = plan(
                    &pattern,
                    &goal,
                    &PlanOptions::default().with(|it| {
                        it.bound = BOUND;
                        it.interpolation = Some(kind);
                        it.pace = pace;
                        it.collision = false;
                    }),
                );
                match (plan.outcome, plan.knots().last()) {
                    (Outcome::Planned, Some(last)) => format!(
                        "{} ({:.0e}, {:.1})",
                        plan.knots().len(),
                        plan.certified_deformation().unwrap_or(f64::NAN),
                        last.time
                    ),
                    _ => "none".into(),
                }
            });
            println!("| {sheet} | {} |", cells.join(" | "));
        }
    }
}

/// Returns the sheets with their goals: Miura to 170 degrees and folded flat, and the waterbomb near the tube.
fn sheets() -> Vec<(&'static str, CreasePattern)> {
    let miura = |degrees: f64| {
        let miura = Miura {
            rows: 24,
            columns: 24,
            sector_angle: PI / 3.0,
            fold: degrees / 180.0,
        };
        CreasePattern::new(miura.drawing().expect("a sheet")).expect("a pattern")
    };
    let waterbomb = Waterbomb {
        rows: 12,
        columns: 22,
        // b - m = 59 degrees.
        fold: 0.522_504_840_831_969,
    };
    let waterbomb = waterbomb.drawing().expect("a sheet");
    vec![
        ("miura 24x24, 0..170", miura(170.0)),
        ("miura 24x24, 0..180", miura(180.0)),
        (
            "waterbomb 12x22",
            CreasePattern::new(waterbomb).expect("a pattern"),
        ),
    ]
}
