//! Section `scaling`: time and memory of whole plans against the number of hinges, with crease groups and with every
//! crease an unknown of its own.

mod fit;
pub mod measure;
mod picture;

use core::fmt::Write;

use fit::exponent;
use measure::{Measured, Work, measure};

/// A finished section and its files.
pub struct Section {
    /// Markdown of the section.
    pub text: String,
    /// Names and contents of the files.
    pub files: Vec<(&'static str, String)>,
}

/// Number of hinges from which on exponents are fitted. Below it the constant cost of a plan matters too.
const LARGE: f64 = 1_000.0;

/// Runs the section; if `short`, in seconds.
#[must_use]
pub fn section(short: bool) -> Section {
    let (symmetric, full): (&[_], &[_]) = if short {
        (&[(25, 3), (50, 3), (100, 1)], &[(11, 3), (24, 3), (48, 1)])
    } else {
        (
            &[
                (25, 21),
                (50, 15),
                (100, 9),
                (200, 5),
                (400, 3),
                (708, 1),
                (1000, 1),
            ],
            &[(11, 21), (24, 15), (48, 7), (96, 3), (200, 1), (400, 1)],
        )
    };
    let mut text = String::from(SYMMETRIC);
    text += "\n\n| faces | hinges | pattern | symmetry | solve | place | fold | collision | plan | certified deformation \
             | memory | bytes a hinge | runs |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    let groups: Vec<Measured> = symmetric
        .iter()
        .map(|&(size, runs)| {
            let found = measure(Work::Symmetric(size), runs);
            symmetric_row(&mut text, &found, runs);
            found
        })
        .collect();
    let _ok = writeln!(text, "\n{}", growth(&groups, "hinges"));
    let _ok = write!(text, "\n{FULL}\n\n{FULL_HEAD}");
    let waterbomb = measure(Work::FullWaterbomb, if short { 1 } else { 15 });
    full_row(
        &mut text,
        Work::FullWaterbomb,
        &waterbomb,
        if short { 1 } else { 15 },
    );
    let each: Vec<Measured> = full
        .iter()
        .map(|&(size, runs)| {
            let found = measure(Work::Full(size), runs);
            full_row(&mut text, Work::Full(size), &found, runs);
            found
        })
        .collect();
    let _ok = writeln!(text, "\n{}", growth(&each, "unknowns"));
    text += "\n![Time and memory of plans against hinges](tests/bench/results/scaling.svg)\n";
    let files = vec![
        ("scaling.csv", csv(&groups, &each)),
        ("scaling.svg", picture::picture(&groups, &each)),
    ];
    Section { text, files }
}

fn symmetric_row(text: &mut String, found: &Measured, runs: usize) {
    let at = |key| found.number(key);
    assert!(
        at("everywhere") > 0.0,
        "crossings looked for at the knots alone"
    );
    let _ok = writeln!(
        text,
        "| {} | {} | {:.4} | {:.4} | {:.5} | {:.4} | {:.4} | {:.4} | {:.4} | {:.1e} | {} | {:.0} | {runs} |",
        at("faces"),
        at("hinges"),
        at("pattern"),
        at("symmetry"),
        at("solve"),
        at("place"),
        at("fold"),
        at("collision"),
        at("total"),
        at("certified"),
        mebibytes(found.memory()),
        found.memory() / at("hinges"),
    );
}

fn full_row(text: &mut String, work: Work, found: &Measured, runs: usize) {
    let at = |key| found.number(key);
    let _ok = writeln!(
        text,
        "| {} | {} | {} | {} | {:.4} | {:.3} ms | {:.4} | {:.1e} | {} | {:.0} | {runs} |",
        work.sheet(),
        at("unknowns"),
        at("configurations"),
        at("knots"),
        at("total"),
        1e3 * at("total") / at("configurations"),
        at("solve"),
        at("closure"),
        mebibytes(found.memory()),
        found.memory() / at("hinges"),
    );
}

fn mebibytes(bytes: f64) -> String {
    format!("{:.1} MiB", bytes / f64::from(1 << 20))
}

/// Describes how time and memory grow.
fn growth(points: &[Measured], what: &str) -> String {
    let large = points.iter().filter(|p| p.number("hinges") >= LARGE);
    let points = |y: fn(&Measured) -> f64| -> Vec<_> {
        large.clone().map(|p| (p.number("hinges"), y(p))).collect()
    };
    format!(
        "From {LARGE} {what} on, time grows as {what}^{:.2}, memory as {what}^{:.2}.",
        exponent(&points(|p| p.number("total"))).0,
        exponent(&points(Measured::memory)).0,
    )
}

fn csv(groups: &[Measured], each: &[Measured]) -> String {
    let keys = [
        "faces",
        "hinges",
        "unknowns",
        "configurations",
        "knots",
        "pattern",
        "symmetry",
        "solve",
        "place",
        "fold",
        "collision",
        "total",
        "closure",
    ];
    let mut csv = format!("symmetry,{},memory\n", keys.join(","));
    for (name, points) in [("auto", groups), ("off", each)] {
        for point in points {
            let numbers = keys.map(|key| point.number(key).to_string());
            let _ok = writeln!(csv, "{name},{},{}", numbers.join(","), point.memory());
        }
    }
    csv
}

const SYMMETRIC: &str = "Miura sheets from flat to 170 degrees with crease groups (2 unknowns), certified and free of \
    crossings over the whole motion. Medians in seconds of plans without reading and writing; `pattern` is what comes \
    before, the making of the crease pattern from its drawing, and not in `plan`. Each size has a process of its own, of \
    which the peak of memory is taken, drawing and pattern included.";
const FULL: &str = "Every crease an unknown of its own, collision off: Miura sheets from flat to 150 degrees, and the \
    12x22 waterbomb. `each` is the time of a configuration that the motion was followed through.";
const FULL_HEAD: &str = "| sheet | unknowns | configurations | knots | plan | each | of it solve | closure | memory | \
    bytes a hinge | runs |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
