//! Fans: creases that meet at a corner of the sheet.

use core::f64::consts::PI;

use foldpath::pattern::Drawing;
use nalgebra::Vector2;

use super::{Canvas, heading};
use crate::Random;

/// Draws 3 to 8 sectors round a corner of the sheet, whose creases are folded flat. The sectors of half of the fans are
/// alike but for a random difference of 1e-5 to 0.1 of their angle, so that a sector that lies on its neighbour reaches a
/// little beyond it.
#[must_use]
pub fn fan(random: &mut Random) -> Drawing {
    let sectors = random.whole(3, 8);
    let difference = if random.chance(0.5) {
        random.log_uniform(1e-5, 0.1)
    } else {
        0.7
    };
    let widths: Vec<f64> = (0..sectors)
        .map(|_| 1.0 + difference * random.uniform(-1.0, 1.0))
        .collect();
    let unit = random.uniform(0.5, 1.2 * PI) / widths.iter().sum::<f64>();
    let mut canvas = Canvas::default();
    let corner = canvas.vertex(Vector2::zeros());
    let mut direction = 0.0;
    for ray in 0..=sectors {
        let rim = canvas.vertex(heading(direction) * random.uniform(0.7, 1.3));
        if let Some(width) = widths.get(ray) {
            direction += unit * width;
        }
        if ray == 0 || ray == sectors {
            canvas.boundary([corner, rim]);
        } else {
            canvas.crease([corner, rim], random.sign() * PI);
        }
    }
    for k in 1..=sectors {
        canvas.boundary([k, k + 1]);
    }
    canvas.0
}
