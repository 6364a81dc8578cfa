//! Judges a path file: `cargo run --release -p foldpath --example check_file -- path.fold`.

use core::error::Error;
use std::path::Path;

use foldpath::check::{CheckOptions, check};
use foldpath::read::fold::read_motion;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1);
    let file =
        file.ok_or("expected a path file, such as `foldpath plan` or the example `plan` writes")?;
    let motion = read_motion(Path::new(&file))?;
    let verdict = check(&motion, &CheckOptions::default());
    for failure in &verdict.failures {
        println!("fails: {failure}");
    }
    if verdict.failures.is_empty() {
        println!("holds");
    }
    let rigidity = verdict.rigidity();
    println!(
        "{} knots; at knots and between: deformation {:.1e}, gap {:.1e}, closure {:.1e}",
        motion.knots.len(),
        rigidity.deformation,
        rigidity.gap,
        verdict.closure()
    );
    Ok(())
}
