//! Large tessellations, and tessellations whose cells turn from step to step.

use foldpath::generate::{Miura, Waterbomb, Yoshimura};
use foldpath::pattern::Drawing;

use super::first_good;
use crate::Random;

/// Most creases of a sheet, so that a plan takes seconds.
const LARGEST: usize = 40_000;

/// Draws a Miura, Yoshimura or waterbomb sheet of some 300 to 20,000 faces. Yoshimura and waterbomb sheets roll up as
/// they fold: cells of theirs turn from step to step.
#[must_use]
pub fn lattice(random: &mut Random) -> Drawing {
    first_good(random, |random| {
        let mut lines = || random.log_uniform(12.0, 110.0);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "12 to 110"
        )]
        let [rows, columns] = [lines() as usize, lines() as usize];
        let drawing = match random.whole(0, 2) {
            0 => Miura {
                rows,
                columns,
                sector_angle: random.uniform(40.0, 80.0).to_radians(),
                fold: random.uniform(0.1, 0.9),
            }
            .drawing(),
            1 => Yoshimura {
                rows,
                columns,
                angle: random.uniform(25.0, 50.0).to_radians(),
                fold: random.log_uniform(0.005, 0.2),
            }
            .drawing(),
            _ => Waterbomb {
                rows: 2 * rows.div_ceil(2),
                columns: 2 * columns.div_ceil(2),
                fold: random.log_uniform(0.005, 0.3),
            }
            .drawing(),
        };
        drawing
            .ok()
            .filter(|drawing| drawing.edges.len() <= LARGEST)
    })
}
