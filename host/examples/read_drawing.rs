//! Reads a crease pattern and prints what the reader repaired and assumed, and to how few unknowns symmetry reduces the
//! sheet. The file is FOLD, SVG, CP, OPX or OBJ; without one, a drawing of this repository is read.
//!
//! ```text
//! cargo run --release --example read_drawing -- pattern.svg
//! ```

use core::error::Error;
use std::env::args_os;
use std::path::Path;

use foldpath::read::read_pattern;
use foldpath::symmetry::{CreaseGroups, ReducedStars};

const DEFAULT: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../patterns/pictures/waterbomb-8x10.svg"
);

fn main() -> Result<(), Box<dyn Error>> {
    let file = args_os().nth(1).unwrap_or_else(|| DEFAULT.into());
    let read = read_pattern(Path::new(&file))?;
    let pattern = &read.pattern;

    println!("{}", read.title);
    for repair in pattern.repairs() {
        println!("repaired: {repair}");
    }
    for assumption in pattern.assumptions() {
        println!("assumed: {assumption}");
    }

    // Creases of a group turn by the same angle, up to sign. Vertices with the same closure condition count once.
    let groups = CreaseGroups::find(pattern);
    let essential = ReducedStars::all(pattern, &groups).essential();
    println!("creases             {}", pattern.creases().len());
    println!("crease groups       {}", groups.len());
    println!("real vertices       {}", pattern.real_vertices().count());
    println!("essential vertices  {}", essential.vertices().len());
    Ok(())
}
