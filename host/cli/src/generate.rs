//! Runs `foldpath generate`, which writes a crease pattern of a known family.

use crate::Answer;
use crate::args::{Family, Generate, Size, TwistLetters};
use crate::output::write_whole_with;
use crate::standard::{print_summary, shown};
use foldpath::export::fold::write_pattern;
use foldpath::generate::{
    Kresling, Letters, Miura, Quad, Resch, SquareTwist, Waterbomb, Yoshimura,
};

pub(crate) fn run(args: &Generate, quiet: bool) -> Answer {
    let (name, [rows, cols], output, drawing) = match &args.family {
        Family::Miura { size, angle, fold } => {
            let miura = Miura {
                rows: size.rows,
                columns: size.cols,
                sector_angle: angle.to_radians(),
                fold: *fold,
            };
            ("Miura", shape(size), &size.output, miura.drawing()?)
        }
        Family::Waterbomb { size, fold } => {
            let waterbomb = Waterbomb {
                rows: size.rows,
                columns: size.cols,
                fold: *fold,
            };
            ("Waterbomb", shape(size), &size.output, waterbomb.drawing()?)
        }
        Family::Yoshimura { size, angle, fold } => {
            let yoshimura = Yoshimura {
                rows: size.rows,
                columns: size.cols,
                angle: angle.to_radians(),
                fold: *fold,
            };
            ("Yoshimura", shape(size), &size.output, yoshimura.drawing()?)
        }
        Family::Quad {
            rows,
            cols,
            output,
            fold,
        } => {
            let quad = Quad {
                rows: *rows,
                columns: *cols,
                fold: *fold,
            };
            ("Quad", [*rows, *cols], output, quad.drawing()?)
        }
        Family::SquareTwist {
            rows,
            cols,
            output,
            angle,
            letters,
            fold,
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
            ("Square twist", [*rows, *cols], output, twist.drawing()?)
        }
        Family::Resch { rows, cols, output } => {
            let resch = Resch {
                rows: *rows,
                columns: *cols,
            };
            ("Resch", [*rows, *cols], output, resch.drawing()?)
        }
        Family::Kresling { rows, cols, output } => {
            let kresling = Kresling {
                rows: *rows,
                columns: *cols,
            };
            ("Kresling", [*rows, *cols], output, kresling.drawing()?)
        }
    };
    let title = format!("{name} {rows}x{cols}");
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

fn shape(size: &Size) -> [usize; 2] {
    [size.rows, size.cols]
}
