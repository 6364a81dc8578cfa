//! Plans to fold angles of one's own, with a hinge that is limited:
//! `cargo run --release -p foldpath --example custom_goal`.

use core::error::Error;

use foldpath::generate::Miura;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, HingeLimit, PlanOptions, plan};

fn main() -> Result<(), Box<dyn Error>> {
    let miura = Miura {
        rows: 4,
        columns: 4,
        sector_angle: 70_f64.to_radians(),
        fold: 0.9,
    };
    let pattern = CreasePattern::new(miura.drawing()?)?;

    // The first crease goes a third of its way. `None` leaves the other hinges free to turn as they must.
    let mut angles = vec![None; pattern.creases().len()];
    angles[0] = pattern
        .edge(pattern.creases()[0])
        .goal
        .map(|goal| goal / 3.0);
    let goal = Goal::chosen(
        &pattern,
        angles,
        "a third of the first crease's angle".into(),
    );

    let crease = pattern
        .edge(pattern.creases()[0])
        .crease
        .ok_or("no crease")?;
    let options = PlanOptions {
        limits: vec![HingeLimit {
            crease,
            lower: -90_f64.to_radians(),
            upper: 90_f64.to_radians(),
        }],
        ..PlanOptions::default()
    };
    let plan = plan(&pattern, &goal, &options);
    println!("{}: {}", goal.source, plan.outcome.name());
    for note in &plan.notes {
        println!("{note}");
    }
    if let Some(motion) = &plan.motion {
        let last = motion.crease_angles(motion.knots.len() - 1);
        println!(
            "the first crease ends at {:.3} degrees",
            last[0].to_degrees()
        );
    }
    Ok(())
}
