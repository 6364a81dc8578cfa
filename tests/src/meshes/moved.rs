//! Triangulated sheets of known families, with moved vertices.

use foldpath::generate::{Waterbomb, Yoshimura};
use foldpath::pattern::{Drawing, Letter};
use nalgebra::Vector2;

use super::{close, first_good};
use crate::Random;

/// Draws a waterbomb sheet with moved vertices.
#[must_use]
pub fn moved_waterbomb(random: &mut Random) -> Drawing {
    first_good(random, |random| {
        let waterbomb = Waterbomb {
            rows: 2 * random.whole(1, 3),
            columns: 2 * random.whole(1, 3),
            fold: random.uniform(0.15, 0.5),
        };
        moved(random, waterbomb.drawing().ok()?)
    })
}

/// Draws a Yoshimura sheet with moved vertices.
#[must_use]
pub fn moved_yoshimura(random: &mut Random) -> Drawing {
    first_good(random, |random| {
        let yoshimura = Yoshimura {
            rows: random.whole(2, 6),
            columns: random.whole(2, 6),
            angle: random.uniform(25.0, 50.0).to_radians(),
            fold: random.uniform(0.1, 0.4),
        };
        moved(random, yoshimura.drawing().ok()?)
    })
}

/// Moves the vertices by up to a twentieth of an edge. A triangulated sheet stays flexible: it has about three degrees
/// of freedom less than creases end on its boundary. The goal is the closed configuration that Newton's method finds
/// from the old goal, with the same assignments. Vertices within a crease stay within it, and the boundary stays in
/// place.
fn moved(random: &mut Random, mut drawing: Drawing) -> Option<Drawing> {
    let reach = random.log_uniform(1e-4, 0.05);
    let letters: Vec<Letter> = drawing.edges.iter().map(|edge| edge.letter).collect();
    let mut neighbours = vec![Vec::new(); drawing.vertices.len()];
    let mut inner = vec![true; drawing.vertices.len()];
    for edge in &drawing.edges {
        let [a, b] = edge.ends;
        neighbours[a].push(b);
        neighbours[b].push(a);
        if edge.letter == Letter::Boundary {
            (inner[a], inner[b]) = (false, false);
        }
    }
    for (place, (inner, neighbours)) in drawing
        .vertices
        .iter_mut()
        .zip(inner.iter().zip(&neighbours))
    {
        if *inner && neighbours.len() > 2 {
            *place += Vector2::new(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)) * reach;
        }
    }
    for vertex in 0..inner.len() {
        if let ([a, b], true) = (&neighbours[vertex][..], inner[vertex]) {
            drawing.vertices[vertex] = (drawing.vertices[*a] + drawing.vertices[*b]) / 2.0;
        }
    }
    let closed = close(drawing)?;
    let kept = closed.edges.iter().map(|edge| edge.letter).eq(letters);
    kept.then_some(closed)
}
