//! Runs `foldpath generate`, which writes a crease pattern of a known family.

use crate::args::{Family, Generate, Size, TwistLetters};
use crate::output::write_whole_with;
use crate::standard::{print_summary, shown};
use crate::{Answer, CliError};
use foldpath::export::fold::write_pattern;
use foldpath::generate::{
    Kresling, Letters, Miura, Quad, Resch, SquareTwist, Waterbomb, Yoshimura,
};
use foldpath::pattern::Drawing;

pub(crate) fn run(args: &Generate, quiet: bool) -> Answer {
    let (title, drawing) = family_drawing(&args.family)?;
    let output = args.family.output();
    write_whole_with(output, |out| write_pattern(&title, &drawing, out))?;
    let text = format!(
        "{title}: {} vertices, {} edges, written to {}\n",
        drawing.vertices.len(),
        drawing.edges.len(),
        shown(output)
    );
    print_summary(Some(output), quiet, &text)?;
    Ok(true)
}

/// Returns title and drawing of a pattern of a family.
///
/// # Errors
/// If a parameter is out of its range.
pub(crate) fn family_drawing(family: &Family) -> Result<(String, Drawing), CliError> {
    let (name, [rows, cols], drawing) = match family {
        Family::Miura { size, angle, fold } => {
            let miura = Miura {
                rows: size.rows,
                columns: size.cols,
                sector_angle: angle.to_radians(),
                fold: *fold,
            };
            ("Miura", shape(size), miura.drawing()?)
        }
        Family::Waterbomb { size, fold } => {
            let waterbomb = Waterbomb {
                rows: size.rows,
                columns: size.cols,
                fold: *fold,
            };
            ("Waterbomb", shape(size), waterbomb.drawing()?)
        }
        Family::Yoshimura { size, angle, fold } => {
            let yoshimura = Yoshimura {
                rows: size.rows,
                columns: size.cols,
                angle: angle.to_radians(),
                fold: *fold,
            };
            ("Yoshimura", shape(size), yoshimura.drawing()?)
        }
        Family::Quad {
            rows, cols, fold, ..
        } => {
            let quad = Quad {
                rows: *rows,
                columns: *cols,
                fold: *fold,
            };
            ("Quad", [*rows, *cols], quad.drawing()?)
        }
        Family::SquareTwist {
            rows,
            cols,
            angle,
            letters,
            fold,
            ..
        } => {
            let twist = SquareTwist {
                rows: *rows,
                columns: *cols,
                angle: angle.to_radians(),
                letters: match letters {
                    TwistLetters::Foldable => Letters::Foldable,
                    TwistLetters::Unfoldable => Letters::Unfoldable,
                },
                fold: *fold,
            };
            ("Square twist", [*rows, *cols], twist.drawing()?)
        }
        Family::Resch { rows, cols, .. } => {
            let resch = Resch {
                rows: *rows,
                columns: *cols,
            };
            ("Resch", [*rows, *cols], resch.drawing()?)
        }
        Family::Kresling { rows, cols, .. } => {
            let kresling = Kresling {
                rows: *rows,
                columns: *cols,
            };
            ("Kresling", [*rows, *cols], kresling.drawing()?)
        }
    };
    Ok((format!("{name} {rows}x{cols}"), drawing))
}

fn shape(size: &Size) -> [usize; 2] {
    [size.rows, size.cols]
}
