//! Other drawings of the same sheet.

use foldpath::pattern::{Drawing, DrawnEdge};
use nalgebra::Rotation2;

use crate::Random;

/// Returns the drawing scaled, rotated, perhaps mirrored and perhaps seen from its other side, with its vertices and
/// edges in another order. Every answer must be the same as before.
#[must_use]
pub fn variant(drawing: &Drawing, random: &mut Random) -> Drawing {
    let scale = random.log_uniform(1e-3, 1e3);
    let turn = Rotation2::new(random.uniform(0.0, core::f64::consts::TAU));
    let (mirror, side) = (random.sign(), random.sign());
    let vertices = drawing.vertices.iter().map(|place| {
        let mut place = turn * place * scale;
        place.x *= mirror;
        place
    });
    let edges = drawing.edges.iter().map(|edge| DrawnEdge {
        letter: if side < 0.0 {
            edge.letter.flipped()
        } else {
            edge.letter
        },
        goal: edge.goal.map(|goal| side * goal),
        ..*edge
    });
    let redrawn = Drawing {
        vertices: vertices.collect(),
        edges: edges.collect(),
        faces: None,
    };
    renumbered(&redrawn, random)
}

/// Returns the drawing with its vertices and edges in another order, some edges from end to start, without faces.
#[must_use]
pub fn renumbered(drawing: &Drawing, random: &mut Random) -> Drawing {
    let order = random.permutation(drawing.vertices.len());
    let mut vertices = drawing.vertices.clone();
    for (place, &at) in drawing.vertices.iter().zip(&order) {
        vertices[at] = *place;
    }
    let edges = random.permutation(drawing.edges.len());
    let edges = edges.iter().map(|&edge| {
        let DrawnEdge { ends, letter, goal } = drawing.edges[edge];
        let mut ends = ends.map(|end| order[end]);
        if random.chance(0.5) {
            ends.reverse();
        }
        DrawnEdge { ends, letter, goal }
    });
    Drawing {
        edges: edges.collect(),
        vertices,
        faces: None,
    }
}
