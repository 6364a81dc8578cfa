//! Reads a crease pattern from a FOLD, SVG, CP or OBJ file and says what was found and repaired:
//! `cargo run --release -p foldpath --example read_drawing -- drawing.svg`.

use core::error::Error;
use std::path::PathBuf;

use foldpath::read::read_pattern;
use foldpath::symmetry::{CreaseGroups, ReducedStars};

fn main() -> Result<(), Box<dyn Error>> {
    let waterbomb = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../patterns/waterbomb-8x10.fold"
    );
    let file = std::env::args().nth(1).unwrap_or_else(|| waterbomb.into());
    let file = read_pattern(&PathBuf::from(file))?;
    let pattern = &file.pattern;
    println!(
        "{}: {} vertices, {} faces, {} creases",
        file.title,
        pattern.vertices().len(),
        pattern.faces().len(),
        pattern.creases().len()
    );
    for repair in pattern.repairs() {
        println!("repaired: {repair}");
    }
    for assumption in pattern.assumptions() {
        println!("assumed: {assumption}");
    }
    // Creases that turn alike, and one vertex for each distinct closure condition.
    let groups = CreaseGroups::find(pattern);
    let essential = ReducedStars::all(pattern, &groups).essential();
    println!(
        "{} crease groups, {} essential vertices",
        groups.len(),
        essential.vertices().len()
    );
    Ok(())
}
