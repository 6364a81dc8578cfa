//! Several vertices joined by creases, without a closed loop of creases.

use foldpath::pattern::Drawing;
use nalgebra::Vector2;

use super::vertex::{directions, random_angle};
use super::{Canvas, close, first_good, heading, spacings};
use crate::Random;

/// Half the height of a chain.
const HALF_HEIGHT: f64 = 1.0;

/// Draws a strip with 2 to 5 vertices along its middle line, each joined to the next. Every vertex has 1 to 3 creases
/// up and 1 to 3 down to the sides of the strip. The goal is found as for [`vertex`](super::vertex()).
#[must_use]
pub fn chain(random: &mut Random) -> Drawing {
    first_good(random, |random| {
        let vertices = random.whole(2, 5);
        let largest = random.uniform(20.0, 100.0).to_radians();
        let x = spacings(random, vertices + 1);
        let mut canvas = Canvas::default();
        let spine: Vec<usize> = x
            .iter()
            .map(|&x| canvas.vertex(Vector2::new(x, 0.0)))
            .collect();
        for pair in spine.windows(2) {
            canvas.crease([pair[0], pair[1]], random_angle(random, largest));
        }
        for side in [HALF_HEIGHT, -HALF_HEIGHT] {
            let mut rim = vec![spine[0], canvas.vertex(Vector2::new(x[0], side))];
            for k in 1..=vertices {
                let count = random.whole(1, 3);
                // The part of the side that belongs to this vertex.
                let (from, to) = ((x[k - 1] + x[k]) / 2.0, (x[k] + x[k + 1]) / 2.0);
                let cells = spacings(random, count + 1);
                for cell in &cells[1..=count] {
                    let at = from + (to - from) * cell / cells[count + 1];
                    let end = canvas.vertex(Vector2::new(at, side));
                    canvas.crease([spine[k], end], random_angle(random, largest));
                    rim.push(end);
                }
            }
            rim.push(canvas.vertex(Vector2::new(x[vertices + 1], side)));
            rim.push(spine[vertices + 1]);
            for pair in rim.windows(2) {
                canvas.boundary([pair[0], pair[1]]);
            }
        }
        close(canvas.0)
    })
}

/// Draws a vertex of degree 4 or 5. One or more of its creases end in further vertices of degree 4 or 5. The goal is
/// found as for [`vertex`](super::vertex()).
#[must_use]
pub fn tree(random: &mut Random) -> Drawing {
    first_good(random, |random| {
        const RADIUS: f64 = 2.2;
        let degree = random.whole(4, 5);
        let arms = directions(random, degree)?;
        let largest = random.uniform(20.0, 100.0).to_radians();
        let mut canvas = Canvas::default();
        let centre = canvas.vertex(Vector2::zeros());
        let mut rim = Vec::new();
        let turn = core::f64::consts::TAU;
        for k in 0..degree {
            let [before, next] = [k + degree - 1, k + 1]
                .map(|other| (arms[other % degree] - arms[k]).rem_euclid(turn));
            if !(k == 0 || random.chance(0.6)) {
                let end = canvas.vertex(heading(arms[k]) * RADIUS);
                canvas.crease([centre, end], random_angle(random, largest));
                rim.push(end);
                continue;
            }
            let joint = canvas.vertex(heading(arms[k]) * random.uniform(0.8, 1.2));
            canvas.crease([centre, joint], random_angle(random, largest));
            // A fan of creases on both sides of the arm, within the arm's part of the sheet.
            let (low, high) = (-0.4 * (turn - before), 0.4 * next);
            let mut fan = vec![
                low * random.uniform(0.5, 1.0),
                random.uniform(0.3 * low, 0.3 * high),
                high * random.uniform(0.5, 1.0),
            ];
            if random.chance(0.5) {
                fan.insert(1, (fan[0] + fan[1]) / 2.0);
            }
            for offset in fan {
                let end = canvas.vertex(heading(arms[k] + offset) * RADIUS);
                canvas.crease([joint, end], random_angle(random, largest));
                rim.push(end);
            }
        }
        for k in 0..rim.len() {
            canvas.boundary([rim[k], rim[(k + 1) % rim.len()]]);
        }
        close(canvas.0)
    })
}
