//! Section `stability`: how large are errors on extreme sheets, against numbers of 192 bits, and which sheets break
//! first?

pub mod big;
pub mod command;
pub mod kernel;
pub mod ladder;
pub mod patterns;
pub mod reference;
pub mod sheets;
pub mod trees;

use core::fmt::Write;
use std::path::Path;

/// A finished section, its files, and the wrong answers.
pub struct Section {
    /// Markdown of the section.
    pub text: String,
    /// Names and contents of the files.
    pub files: Vec<(&'static str, String)>,
    /// Wrong answers; there should be none.
    pub wrong: Vec<String>,
}

/// Size of the sheet whose motion is promised, faces along a side.
const PROMISED: usize = 24;
/// Deformation that is promised for it through 0..179.99 degrees, in `f64` and in `f32`.
pub const PROMISE: [f64; 2] = [1e-11, 2e-4];

/// Returns the worst errors of the promised sheet through its motion, over an even grid of angles with `count` steps
/// and some extreme angles.
#[must_use]
pub fn promised(count: u32) -> sheets::Motion {
    let sheet = sheets::Sheet::new(PROMISED);
    let even = (0..=count).map(|k| 179.99 * f64::from(k) / f64::from(count));
    let zigzags: Vec<f64> = even.chain([1e-9, 1e-6, 1e-3, 179.9]).collect();
    sheets::motion(&sheet, &zigzags)
}

/// Runs the section; if `short`, in seconds. The program `command` is the `foldpath` command.
#[must_use]
pub fn section(command: &Path, short: bool) -> Section {
    let (sizes, stars, angles): (&[usize], _, _) = if short {
        (&[24], 20, 20)
    } else {
        (&[24, 100, 300, 1000], 300, 360)
    };
    let mut text = String::new();
    let mut files = Vec::new();
    let mut part =
        |title: &str, file: &'static str, make: &mut dyn FnMut(&mut String) -> String| {
            eprintln!("{title}");
            let mut csv = String::new();
            let table = make(&mut csv);
            files.push((file, csv));
            let _ok = writeln!(text, "{title}\n\n{table}");
        };
    let mut wrong = Vec::new();
    part(BREAKS, "stability-breaks.csv", &mut |csv| {
        let ladders = ladder::ladders(sizes, short);
        let (table, found) = ladder::table(command, &ladders, short, csv);
        wrong = found;
        table
    });
    part(MOTION, "stability-motion.csv", &mut |csv| {
        motion(angles, csv)
    });
    part(SIZES, "stability-sheets.csv", &mut |csv| {
        sheets::sizes(sizes, csv)
    });
    part(FOLDS, "stability-folds.csv", &mut kernel::fold_angles);
    part(SECTORS, "stability-sectors.csv", &mut kernel::sectors);
    part(DEGREES, "stability-degrees.csv", &mut |csv| {
        kernel::vertex_degrees(stars, csv)
    });
    Section { text, files, wrong }
}

fn motion(angles: u32, csv: &mut String) -> String {
    let found = promised(angles);
    let mut table = String::from(
        "| numbers | largest deformation | largest gap | promised |\n|---|---|---|---|\n",
    );
    csv.push_str("numbers,deformation,gap\n");
    for (name, [deformation, gap], promise) in [
        ("f64", found.double, Some(PROMISE[0])),
        (
            "f64: bound of the certificate on rounding",
            found.allowed,
            None,
        ),
        ("f32", found.single, Some(PROMISE[1])),
        ("angles in f32, folded in f64", found.mixed, None),
    ] {
        let promise = promise.map_or(String::new(), |p| format!("deformation {p:e}"));
        let _ok = writeln!(
            table,
            "| {name} | {deformation:.1e} | {gap:.1e} | {promise} |"
        );
        let _ok = writeln!(csv, "{name},{deformation:e},{gap:e}");
    }
    table
}

const BREAKS: &str = "What breaks first. A Miura sheet of 8x8 faces (60 degrees, folded to 150), or a disc of panels \
    round one vertex, is made more extreme step by step, written to a file, planned by `foldpath plan` and judged by \
    `foldpath check`; the knots of the path are folded again in 192-bit numbers, by 3x3 matrices. The first step at \
    which either says anything but yes is where the direction breaks.";
const MOTION: &str = "A Miura sheet of 24x24 faces (60 degrees) through 0 to 179.99 degrees, straight creases solved \
    for by core in the same precision:";
const SIZES: &str = "Size, spanning tree and precision: a Miura sheet (60 degrees) at 150 degrees, the angles of the \
    closed form rounded, folded along trees of several kinds; `corners` is the relative error of the distance between \
    opposite corners against the closed form in 192 bits. `depth` is the longest way from the root in faces.";
const FOLDS: &str = "Fold angle: the vertex of a Miura (60 degrees). Core's closure residual of the closed form's \
    angles, rounded; how far that residual is from the true one of the same numbers (192 bits); and how far the \
    straight crease's angle that core solves for is from the closed form (radians, and as part of the angle).";
const SECTORS: &str = "Sector angle: the same at a zigzag fold angle of 150 degrees.";
const DEGREES: &str = "Degree: stars with creases at random angles, at random fold angles. The largest error of core's \
    residual; core's solver closes each from there with all angles free, and the reference says how far they really \
    are from closing.";
