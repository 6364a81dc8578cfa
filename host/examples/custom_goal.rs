//! Plans towards fold angles of your own, with a limit on one hinge. A goal gives some hinges an angle and leaves the
//! others free; the planner finds how the free hinges have to follow.
//!
//! ```text
//! cargo run --release --example custom_goal
//! ```

use core::error::Error;

use foldpath::generate::Miura;
use foldpath::pattern::{CreaseId, CreasePattern};
use foldpath::planner::{Goal, HingeLimit, PlanOptions, plan};

fn main() -> Result<(), Box<dyn Error>> {
    let miura = Miura {
        rows: 4,
        columns: 4,
        sector_angle: 60_f64.to_radians(),
        fold: 0.9,
    };
    let pattern = CreasePattern::new(miura.drawing()?)?;

    // The zigzag creases turn by 60 degrees the way of their letters. The straight creases, along x, are free.
    let zigzag = 60_f64.to_radians();
    let mut angles = Vec::new();
    for &id in pattern.creases() {
        let edge = pattern.edge(id);
        let [from, to] = edge.ends.map(|end| pattern.vertices()[end.index()]);
        let along_x = (to - from).y.abs() < 1e-9;
        angles.push((!along_x).then_some(edge.letter.sign() * zigzag));
    }
    let free = angles.iter().position(Option::is_none);
    let crease = CreaseId::new(free.ok_or("no crease is free")?);
    let goal = Goal::chosen(&pattern, angles, "zigzags at 60 degrees".into());

    // The closed form of the sheet turns the straight creases by 32 degrees: one limit allows that, the other does not.
    let straight = miura.straight(zigzag).to_degrees();
    println!("straight creases need {straight:.1} degrees");
    for limit in [40_f64, 20.0] {
        let options = PlanOptions::default().with(|it| {
            it.limits = vec![HingeLimit {
                crease,
                lower: -limit.to_radians(),
                upper: limit.to_radians(),
            }]
        });
        options.validate()?;
        let plan = plan(&pattern, &goal, &options);
        println!("limit of {limit} degrees: {}", plan.outcome.name());
        if let Some(reason) = &plan.reason {
            println!("  {reason}");
        }
        if let Some(motion) = &plan.motion {
            let turned = motion.crease_angles(motion.knots.len() - 1)[crease.index()];
            println!("  turned by {:.1} degrees", turned.to_degrees());
        }
    }
    Ok(())
}
