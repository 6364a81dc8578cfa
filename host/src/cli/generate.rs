//! `foldpath generate`.

use super::args::{Family, Generate};
use super::{Answer, print};
use crate::formats::fold::pattern_text;
use crate::formats::write_whole;
use crate::generate::{Miura, Waterbomb, Yoshimura};

pub(super) fn run(args: &Generate) -> Answer {
    let (name, size, drawing) = match &args.family {
        Family::Miura { size, angle, fold } => {
            let miura = Miura {
                rows: size.rows,
                columns: size.cols,
                sector_angle: angle.to_radians(),
                fold: *fold,
            };
            ("Miura", size, miura.drawing()?)
        }
        Family::Waterbomb { size, fold } => {
            let waterbomb = Waterbomb {
                rows: size.rows,
                columns: size.cols,
                fold: *fold,
            };
            ("Waterbomb", size, waterbomb.drawing()?)
        }
        Family::Yoshimura { size, angle, fold } => {
            let yoshimura = Yoshimura {
                rows: size.rows,
                columns: size.cols,
                angle: angle.to_radians(),
                fold: *fold,
            };
            ("Yoshimura", size, yoshimura.drawing()?)
        }
    };
    let title = format!("{name} {}x{}", size.rows, size.cols);
    write_whole(&size.output, pattern_text(&title, &drawing).as_bytes())?;
    print(&format!(
        "{title}: {} vertices, {} edges, written to {}\n",
        drawing.vertices.len(),
        drawing.edges.len(),
        size.output.display()
    ))?;
    Ok(true)
}
