//! Plans a Miura fold and writes the path file: `cargo run --release -p foldpath --example plan`.

use core::error::Error;

use foldpath::export::fold::motion_text;
use foldpath::generate::Miura;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, PlanOptions, plan};

fn main() -> Result<(), Box<dyn Error>> {
    let miura = Miura {
        rows: 8,
        columns: 8,
        sector_angle: 60_f64.to_radians(),
        fold: 0.9,
    };
    let pattern = CreasePattern::new(miura.drawing()?)?;
    let goal = Goal::of_pattern(&pattern)?;
    let plan = plan(&pattern, &goal, &PlanOptions::default());
    println!("{}, {} knots", plan.outcome.name(), plan.knots().len());

    let Some(mut motion) = plan.motion else {
        // A sheet that does not fold is an answer: it says why, and what was tried.
        println!(
            "{}",
            plan.reason.map_or_else(String::new, |r| r.to_string())
        );
        for attempt in &plan.attempts {
            println!(
                "tried {}: {}",
                attempt.strategy.name(),
                attempt.outcome.name()
            );
        }
        return Ok(());
    };
    if let Some(deformation) = plan.certified_deformation {
        println!("deforms by at most {deformation:.1e} all along the motion");
    }
    motion.title = "Miura 8x8".into();
    let file = std::env::temp_dir().join("miura-8x8-path.fold");
    std::fs::write(&file, motion_text(&motion))?;
    println!("written to {}", file.display());
    Ok(())
}
