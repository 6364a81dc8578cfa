//! Sheets with a single vertex.

use core::f64::consts::{PI, TAU};

use foldpath::pattern::Drawing;
use nalgebra::Vector2;

use super::{Canvas, close, first_good, heading};
use crate::Random;

/// Largest sector, radians: short of half a turn, so that faces are convex.
const WIDEST: f64 = 0.95 * PI;

/// Draws a vertex with 4 to 8 creases in random directions. A third of the vertices of even degree are flat-foldable:
/// their alternate sectors add up to half a turn. The goal is the closed configuration that Newton's method finds from
/// random angles of random signs.
///
/// If its faces do not cross in the goal, the vertex can be folded flat so that no crease ever turns away from flat (I.
/// Streinu, W. Whiteley, "Single-vertex origami and spherical expansive motions", 2005).
#[must_use]
pub fn vertex(random: &mut Random) -> Drawing {
    of_lengths(random, |random| random.uniform(0.7, 1.3))
}

/// Draws such a vertex with creases of very different lengths.
#[must_use]
pub fn slender(random: &mut Random) -> Drawing {
    of_lengths(random, |random| random.log_uniform(1.0, 1e3))
}

fn of_lengths(random: &mut Random, length: fn(&mut Random) -> f64) -> Drawing {
    first_good(random, |random| {
        let degree = random.whole(4, 8);
        let directions = directions(random, degree)?;
        let largest = random.uniform(20.0, 150.0).to_radians();
        let mut canvas = Canvas::default();
        let centre = canvas.vertex(Vector2::zeros());
        for &direction in &directions {
            let rim = canvas.vertex(heading(direction) * length(random));
            canvas.crease([centre, rim], random_angle(random, largest));
        }
        for k in 0..degree {
            canvas.boundary([1 + k, 1 + (k + 1) % degree]);
        }
        close(canvas.0)
    })
}

/// Draws a fold angle for Newton's method to start from, radians.
pub(super) fn random_angle(random: &mut Random, largest: f64) -> f64 {
    random.sign() * largest * random.uniform(0.3, 1.0)
}

/// Draws directions of creases round a vertex, counter-clockwise, radians. `None` if a sector is too wide.
pub(super) fn directions(random: &mut Random, degree: usize) -> Option<Vec<f64>> {
    let mut sectors: Vec<f64> = (0..degree).map(|_| random.uniform(0.3, 1.0)).collect();
    let flat_foldable = degree.is_multiple_of(2) && random.chance(1.0 / 3.0);
    let sets = if flat_foldable { 2 } else { 1 };
    let wanted = if flat_foldable { PI } else { TAU };
    for first in 0..sets {
        let sum: f64 = sectors.iter().skip(first).step_by(sets).sum();
        let scale = wanted / sum;
        sectors
            .iter_mut()
            .skip(first)
            .step_by(sets)
            .for_each(|sector| *sector *= scale);
    }
    if sectors.iter().any(|&sector| sector > WIDEST) {
        return None;
    }
    let mut direction = random.uniform(0.0, TAU);
    let directions = sectors.iter().map(|sector| {
        direction += sector;
        direction
    });
    Some(directions.collect())
}
