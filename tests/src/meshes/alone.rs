//! Sheets on which a line of creases turns alone: from border to border, or across a corner.

use foldpath::pattern::{Drawing, DrawnEdge, Letter};
use nalgebra::Vector2;

use super::{grid, letter, strips};
use crate::Random;

/// A sheet and the creases of a line on it.
pub struct LineAlone {
    /// The sheet, with the goal in which the line alone turns.
    pub drawing: Drawing,
    /// The edges of the line.
    pub line: Vec<usize>,
}

/// Draws a sheet with a line that turns alone by 30 to 150 degrees. Its other creases have letters too. They are those of a
/// grid whose inner vertices are moved, with random letters, which hardly ever folds, or of strips, which fold.
#[must_use]
pub fn line_alone(random: &mut Random) -> LineAlone {
    let angle = random.sign() * random.uniform(30.0, 150.0).to_radians();
    match random.below(3) {
        0 => across(random, angle),
        1 => {
            let sheet = moved_grid(random, None);
            with_corner(random, sheet, angle)
        }
        _ => {
            let sheet = strips(random);
            with_corner(random, sheet, angle)
        }
    }
}

/// Draws a moved grid with a straight column that is the line.
fn across(random: &mut Random, angle: f64) -> LineAlone {
    let column = random.whole(1, 2);
    let drawing = moved_grid(random, Some(column));
    #[allow(clippy::cast_precision_loss, reason = "a small number")]
    let x = column as f64;
    let is_on = |edge: &DrawnEdge| {
        let ends = edge.ends.map(|end| drawing.vertices[end]);
        edge.goal.is_some() && ends.iter().all(|end| (end.x - x).abs() < 1e-12)
    };
    let edges = drawing.edges.iter().enumerate();
    let line = edges.filter(|(_, edge)| is_on(edge));
    let line = line.map(|(index, _)| index).collect();
    resting(drawing, line, angle)
}

/// Draws a grid of 3 to 5 columns and rows with moved inner vertices, but for those of one column, which stays straight.
fn moved_grid(random: &mut Random, straight: Option<usize>) -> Drawing {
    let [columns, rows] = [(); 2].map(|()| random.whole(3, 5));
    #[allow(clippy::cast_precision_loss, reason = "small numbers")]
    let places: Vec<Vec<Vector2<f64>>> = (0..=columns)
        .map(|i| {
            let place = |j: usize| {
                let is_inner = (1..columns).contains(&i) && (1..rows).contains(&j);
                let most = if is_inner { 0.15 } else { 0.0 };
                let [x, y] = [(); 2].map(|()| random.uniform(-most, most));
                let x = if straight == Some(i) { 0.0 } else { x };
                Vector2::new(i as f64 + x, j as f64 + y)
            };
            (0..=rows).map(place).collect()
        })
        .collect();
    let mut drawing = grid(&places, |_, _| 0.0, |_, _| 0.0);
    for edge in &mut drawing.edges {
        if edge.goal.is_some() {
            edge.letter = letter(random.sign());
        }
    }
    drawing
}

/// Adds a line across the corner at vertex 0 of a grid, between its sides on the border.
fn with_corner(random: &mut Random, mut drawing: Drawing, angle: f64) -> LineAlone {
    let sides: Vec<usize> = (0..drawing.edges.len())
        .filter(|&edge| drawing.edges[edge].ends.contains(&0))
        .collect();
    let ends: Vec<usize> = sides
        .iter()
        .map(|&side| {
            let [a, b] = drawing.edges[side].ends;
            let part = random.uniform(0.3, 0.9);
            let [from, to] = [a, b].map(|end| drawing.vertices[end]);
            let between = drawing.vertices.len();
            drawing.vertices.push(from + part * (to - from));
            drawing.edges[side].ends = [a, between];
            drawing.edges.push(DrawnEdge {
                ends: [between, b],
                ..drawing.edges[side]
            });
            between
        })
        .collect();
    let line = drawing.edges.len();
    drawing.edges.push(DrawnEdge {
        ends: [ends[0], ends[1]],
        letter: Letter::Valley,
        goal: Some(0.0),
    });
    resting(drawing, vec![line], angle)
}

/// Turns a line to its angle, radians, and puts all other creases to rest.
fn resting(mut drawing: Drawing, line: Vec<usize>, angle: f64) -> LineAlone {
    for (index, edge) in drawing.edges.iter_mut().enumerate() {
        if edge.goal.is_some() {
            edge.goal = Some(0.0);
        }
        if line.contains(&index) {
            (edge.goal, edge.letter) = (Some(angle), letter(angle));
        }
    }
    LineAlone { drawing, line }
}
