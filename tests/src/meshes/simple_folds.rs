//! Squares folded by hand: along one line after the other, each through all layers.

use core::f64::consts::{PI, TAU};

use foldpath::pattern::Drawing;
use nalgebra::Vector2;

use super::{Canvas, first_good, heading};
use crate::Random;

/// Least distance of a line from all corners of the folded sheet, and half the length of the shortest crease.
const ROOM: f64 = 0.04;
/// Distance below which two points are the same.
const SAME: f64 = 1e-9;

/// Draws a square folded flat along 2 to 4 lines of any direction, up or down. Folded in this order it never crosses
/// itself; folded along all lines at once it often does.
#[must_use]
pub fn simple_folds(random: &mut Random) -> Drawing {
    first_good(random, |random| {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let corner = |[x, y]: [f64; 2]| Corner {
            flat: Vector2::new(x, y),
            folded: Vector2::new(x, y),
            goal: None,
        };
        let mut layers = vec![Layer {
            corners: square.map(corner).to_vec(),
            face_up: true,
        }];
        for _ in 0..random.whole(2, 4) {
            layers = fold(&layers, random)?;
        }
        Some(drawing(&layers))
    })
}

/// A face with its corners in order.
struct Layer {
    corners: Vec<Corner>,
    face_up: bool,
}

/// A corner, and the goal of the side that follows it; `None` at the border of the sheet.
#[derive(Clone, Copy)]
struct Corner {
    flat: Vector2<f64>,
    folded: Vector2<f64>,
    goal: Option<f64>,
}

/// Folds everything to the right of a random line over to its left. `None` if the line passes too near a corner.
fn fold(layers: &[Layer], random: &mut Random) -> Option<Vec<Layer>> {
    let through = &layers[random.whole(0, layers.len() - 1)].corners;
    let weights: Vec<f64> = through.iter().map(|_| random.uniform(0.0, 1.0)).collect();
    let mean = through.iter().zip(&weights).map(|(c, w)| c.folded * *w);
    let point = mean.sum::<Vector2<f64>>() / weights.iter().sum::<f64>();
    let along = heading(random.uniform(0.0, TAU));
    let up = random.chance(0.5);
    let height = |place: Vector2<f64>| along.perp(&(place - point));
    let corners = layers.iter().flat_map(|layer| &layer.corners);
    if corners.map(|c| height(c.folded).abs()).any(|h| h < ROOM) {
        return None;
    }
    let mut folded = Vec::new();
    for layer in layers {
        // Seen from its own upper side, a layer that lies face down is folded the opposite way.
        let goal = if up == layer.face_up { PI } else { -PI };
        for side in [1.0, -1.0] {
            let mut corners = part(&layer.corners, |place| side * height(place), goal)?;
            if side < 0.0 {
                for corner in &mut corners {
                    let off = corner.folded - point;
                    corner.folded = point + along * (2.0 * along.dot(&off)) - off;
                }
            }
            if !corners.is_empty() {
                let face_up = layer.face_up == (side > 0.0);
                folded.push(Layer { corners, face_up });
            }
        }
    }
    Some(folded)
}

/// Returns the part of a face where `height` is positive; the side along which it is cut gets this goal. `None` if that
/// side is too short.
fn part(
    corners: &[Corner],
    height: impl Fn(Vector2<f64>) -> f64,
    goal: f64,
) -> Option<Vec<Corner>> {
    let mut part: Vec<Corner> = Vec::new();
    let next = corners.iter().cycle().skip(1);
    let mut cut = Vec::new();
    for (from, to) in corners.iter().zip(next) {
        let [here, there] = [from, to].map(|corner| height(corner.folded));
        if here > 0.0 {
            part.push(*from);
        }
        if here * there < 0.0 {
            let s = here / (here - there);
            let leaves = here > 0.0;
            let corner = Corner {
                flat: from.flat.lerp(&to.flat, s),
                folded: from.folded.lerp(&to.folded, s),
                goal: if leaves { Some(goal) } else { from.goal },
            };
            cut.push(corner.flat);
            part.push(corner);
        }
    }
    let long = |cut: &[Vector2<f64>]| (cut[1] - cut[0]).norm() > 2.0 * ROOM;
    (cut.is_empty() || long(&cut)).then_some(part)
}

/// Returns the crease pattern of all layers, unfolded.
fn drawing(layers: &[Layer]) -> Drawing {
    let mut canvas = Canvas::default();
    let mut drawn = Vec::new();
    for layer in layers {
        let next = layer.corners.iter().cycle().skip(1);
        for (from, to) in layer.corners.iter().zip(next) {
            let [a, b] = [from, to].map(|corner| {
                let mut known = canvas.0.vertices.iter();
                let known = known.position(|place| (place - corner.flat).norm() < SAME);
                known.unwrap_or_else(|| canvas.vertex(corner.flat))
            });
            // Every crease is met twice, from both sides.
            if drawn.contains(&[b, a]) {
                continue;
            }
            drawn.push([a, b]);
            match from.goal {
                Some(goal) => canvas.crease([a, b], goal),
                None => canvas.boundary([a, b]),
            }
        }
    }
    canvas.0
}
