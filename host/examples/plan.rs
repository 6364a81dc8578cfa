//! Plans a Miura fold and writes its path file.
//!
//! ```text
//! cargo run --release --example plan
//! ```

use core::error::Error;
use std::env::temp_dir;
use std::fs;

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
    // The generated pattern has goal angles. A pattern without them is folded all the way as its letters say.
    let goal = Goal::of_pattern(&pattern)?;
    let plan = plan(&pattern, &goal, &PlanOptions::default());

    println!("outcome                {}", plan.outcome.name());
    println!("knots                  {}", plan.knots().len());
    if let Some(bound) = plan.certified_deformation() {
        println!("certified deformation  {bound:.1e}");
    }
    for note in &plan.notes {
        println!("note: {note}");
    }
    if let Some(reason) = &plan.reason {
        println!("reason: {reason}");
        for attempt in &plan.attempts {
            let (strategy, outcome) = (attempt.strategy.name(), attempt.outcome.name());
            println!("tried {strategy}: {outcome} after {:.1} s", attempt.seconds);
        }
    }

    // Without a plan, the motion leads as far towards the goal as one was found.
    let mut motion = plan.motion.ok_or("no motion leaves the flat sheet")?;
    motion.title = "Miura 8 x 8".into();
    let file = temp_dir().join("miura-8x8-path.fold");
    fs::write(&file, motion_text(&motion))?;
    println!("wrote {}", file.display());
    Ok(())
}
