//! Are the promised errors kept, and is no extreme sheet answered wrongly?

use std::path::Path;

use foldpath_bench::stability::{PROMISE, Section, promised, section};

/// The sheet is a 24x24 Miura through 0 to 179.99 degrees.
#[test]
fn the_promised_sheet_keeps_its_deformation() {
    let motion = promised(40);
    let [double, single] = PROMISE;
    assert!(worst(motion.double) <= double, "{motion:?}");
    assert!(worst(motion.single) <= single, "{motion:?}");
    assert!(worst(motion.mixed) <= single, "{motion:?}");
    // The certified bound on rounding covers the rounding that is measured, and is no more than promised.
    assert!(worst(motion.double) <= motion.allowed[0] && motion.allowed[0] <= double);
    // Rounding in 24-bit numbers is visible.
    assert!(worst(motion.single) > 1e-7, "{motion:?}");
}

fn worst([deformation, gap]: [f64; 2]) -> f64 {
    if gap > deformation { gap } else { deformation }
}

#[test]
#[ignore = "takes a minute and a half of one core; `tests/run full` runs it"]
fn no_sheet_is_answered_wrongly() {
    let command = Path::new(env!("CARGO_BIN_EXE_foldpath-bench-command"));
    let Section { text, files, wrong } = section(command, true);
    assert_eq!(wrong, [""; 0]);
    assert!(text.contains("| first to break |"));
    // Ladders went on until something broke.
    let broken = files
        .iter()
        .find(|(name, _)| *name == "stability-breaks.csv");
    assert!(broken.is_some_and(|(_, csv)| csv.contains("the goal is the flat sheet")));
}
