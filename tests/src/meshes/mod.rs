//! Seeded crease patterns that fold although they have little or no symmetry. Each has assignments and a goal that
//! closes to rounding, by a closed form or by the Newton's method of this package.

mod alone;
mod carton;
mod fan;
mod file;
mod flat_foldable;
mod lattice;
mod maps;
mod measured;
mod moved;
mod net;
mod open;
mod simple_folds;
mod strips;
mod tree;
mod variant;
mod vertex;
mod windows;

use foldpath::pattern::{Drawing, DrawnEdge, Letter};
use nalgebra::Vector2;

pub use alone::{LineAlone, line_alone};
pub use carton::Carton;
pub use fan::fan;
pub use file::{file, named_file};
pub use flat_foldable::flat_foldable;
pub use lattice::lattice;
pub use maps::{gate, map, roll};
pub use measured::{measured, rounded};
pub use moved::{moved_waterbomb, moved_yoshimura};
pub use net::{net, net_of};
pub use open::open_shape;
pub use simple_folds::simple_folds;
pub use strips::{strips, wide_strips};
pub use tree::{chain, tree};
pub use variant::{renumbered, variant};
pub use vertex::{slender, vertex};
pub use windows::windows;

use crate::{Closure, Random};

/// Smallest goal of a crease, radians, so that its assignment means something.
const LEAST: f64 = 0.03;
/// Largest goal of a crease, radians, short of half a turn.
const MOST: f64 = 2.9;
/// Largest number of drawings that are tried until one is good.
const TRIES: usize = 10_000;

/// A drawing under construction.
#[derive(Default)]
struct Canvas(Drawing);

impl Canvas {
    fn vertex(&mut self, place: Vector2<f64>) -> usize {
        self.0.vertices.push(place);
        self.0.vertices.len() - 1
    }

    fn boundary(&mut self, ends: [usize; 2]) {
        self.0.edges.push(DrawnEdge {
            ends,
            letter: Letter::Boundary,
            goal: None,
        });
    }

    /// Adds a crease with this goal, radians.
    fn crease(&mut self, ends: [usize; 2], goal: f64) {
        self.0.edges.push(DrawnEdge {
            ends,
            letter: letter(goal),
            goal: Some(goal),
        });
    }
}

/// Returns a grid of (columns + 1) x (rows + 1) vertices at `places[column][row]`, joined by creases with the goals
/// `up(column, row)` and `right(column, row)`, radians.
fn grid(
    places: &[Vec<Vector2<f64>>],
    up: impl Fn(usize, usize) -> f64,
    right: impl Fn(usize, usize) -> f64,
) -> Drawing {
    let (columns, rows) = (places.len() - 1, places[0].len() - 1);
    let mut canvas = Canvas::default();
    for place in places.iter().flatten() {
        canvas.vertex(*place);
    }
    let index = |column: usize, row: usize| column * (rows + 1) + row;
    for i in 0..=columns {
        for j in 0..=rows {
            let here = index(i, j);
            if j < rows {
                let ends = [here, index(i, j + 1)];
                if i == 0 || i == columns {
                    canvas.boundary(ends);
                } else {
                    canvas.crease(ends, up(i, j));
                }
            }
            if i < columns {
                let ends = [here, index(i + 1, j)];
                if j == 0 || j == rows {
                    canvas.boundary(ends);
                } else {
                    canvas.crease(ends, right(i, j));
                }
            }
        }
    }
    canvas.0
}

fn letter(goal: f64) -> Letter {
    if goal < 0.0 {
        Letter::Mountain
    } else {
        Letter::Valley
    }
}

/// Gives the creases the closed configuration that Newton's method finds from their goals, and its assignments. `None`
/// if there is no such configuration, or if a crease turns too little or too far.
fn close(mut drawing: Drawing) -> Option<Drawing> {
    let start: Vec<f64> = drawing
        .edges
        .iter()
        .map(|e| e.goal.unwrap_or(0.0))
        .collect();
    let closed = Closure::of(&drawing).solve(&start)?;
    for (edge, angle) in drawing.edges.iter_mut().zip(closed) {
        if edge.goal.is_some() {
            edge.goal = Some(angle);
            edge.letter = letter(angle);
        }
    }
    turns_well(&drawing).then_some(drawing)
}

/// Returns `true` if every crease turns by at least `LEAST` and at most `MOST`.
fn turns_well(drawing: &Drawing) -> bool {
    let goals = drawing.edges.iter().filter_map(|edge| edge.goal);
    goals.map(f64::abs).all(|a| (LEAST..=MOST).contains(&a))
}

/// Returns the first good drawing of `draw`.
fn first_good(random: &mut Random, draw: impl Fn(&mut Random) -> Option<Drawing>) -> Drawing {
    (0..TRIES)
        .find_map(|_| draw(random))
        .expect("good drawings are not that rare")
}

/// Returns the unit vector at this angle from +x, radians.
fn heading(angle: f64) -> Vector2<f64> {
    Vector2::new(angle.cos(), angle.sin())
}

/// Returns the positions of the lines between `count` panels of random width, from 0.
fn spacings(random: &mut Random, count: usize) -> Vec<f64> {
    let mut at = 0.0;
    let mut places = vec![at];
    for _ in 0..count {
        at += random.uniform(0.6, 1.6);
        places.push(at);
    }
    places
}

/// Returns 1 for even columns, -1 for odd ones.
fn alternating(column: usize) -> f64 {
    if column.is_multiple_of(2) { 1.0 } else { -1.0 }
}
