//! Judges the motion in a path file: closure, deformation, limits and crossings, at the knots and between them. Without
//! a file, judges a path that it plans.
//!
//! ```text
//! cargo run --release --example check_file -- path.fold
//! ```

use core::error::Error;
use std::env::args_os;
use std::path::Path;

use foldpath::check::{CheckOptions, check};
use foldpath::generate::Miura;
use foldpath::motion::Motion;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, PlanOptions, plan};
use foldpath::read::fold::read_motion;

fn main() -> Result<(), Box<dyn Error>> {
    let motion = match args_os().nth(1) {
        Some(file) => read_motion(Path::new(&file))?,
        None => planned()?,
    };
    let verdict = check(&motion, &CheckOptions::default());

    println!("{}: {} knots", motion.title, motion.knots.len());
    println!(
        "deformation            {:.1e}",
        verdict.rigidity().deformation
    );
    match verdict.certified() {
        Some(bound) => println!("certified deformation  {:.1e}", bound.deformation),
        None => println!("certified deformation  unknown"),
    }
    println!("closure residual       {:.1e}", verdict.closure());
    if let Some(clearance) = verdict.min_clearance {
        println!("smallest clearance     {clearance:.3}");
    }
    println!("the path {}", verdict.outcome().name());
    for finding in verdict.findings() {
        println!("  {finding}");
    }
    Ok(())
}

/// Plans a small Miura fold.
fn planned() -> Result<Motion, Box<dyn Error>> {
    let miura = Miura {
        rows: 4,
        columns: 4,
        sector_angle: 60_f64.to_radians(),
        fold: 0.9,
    };
    let pattern = CreasePattern::new(miura.drawing()?)?;
    let plan = plan(
        &pattern,
        &Goal::of_pattern(&pattern)?,
        &PlanOptions::default(),
    );
    let mut motion = plan.motion.ok_or("no motion leaves the flat sheet")?;
    motion.title = "Miura 4 x 4".into();
    Ok(motion)
}
