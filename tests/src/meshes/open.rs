//! Shapes with a rim that no plane holds whole: trays, lampshades, houses without a floor, domes, and bent strips, which one
//! does.

use core::f64::consts::{FRAC_PI_2, TAU};

use foldpath::unfold::FoldedShape;
use nalgebra::{Rotation3, Vector3};

use crate::Random;

/// Draws the shape of this kind, of the five above, turned at random. All faces are convex.
#[must_use]
pub fn open_shape(random: &mut Random, kind: usize) -> FoldedShape {
    let mut shape = match kind % 5 {
        0 => tray(random),
        1 => shade(random),
        2 => house(random),
        3 => dome(random),
        _ => strip(random),
    };
    let turns = [0; 3].map(|_| random.uniform(0.0, TAU));
    let turn = Rotation3::from_euler_angles(turns[0], turns[1], turns[2]);
    for place in &mut shape.vertices {
        *place = turn * *place;
    }
    shape
}

/// Returns rings of vertices with these radii and heights, one above the other.
fn rings(sides: usize, rings: &[[f64; 2]]) -> Vec<Vector3<f64>> {
    #[allow(clippy::cast_precision_loss, reason = "a few sides")]
    let angle = |k: usize| TAU * k as f64 / sides as f64;
    let ring = |&[radius, height]: &[f64; 2]| {
        (0..sides)
            .map(move |k| Vector3::new(radius * angle(k).cos(), radius * angle(k).sin(), height))
    };
    rings.iter().flat_map(ring).collect()
}

/// Returns the walls between rings of vertices.
fn walls(sides: usize, rows: usize) -> Vec<Vec<usize>> {
    let wall = |row: usize, k: usize| {
        let (a, b) = (row * sides + k, row * sides + (k + 1) % sides);
        vec![a, b, b + sides, a + sides]
    };
    (0..rows)
        .flat_map(|row| (0..sides).map(move |k| wall(row, k)))
        .collect()
}

fn shape(vertices: Vec<Vector3<f64>>, faces: Vec<Vec<usize>>) -> FoldedShape {
    FoldedShape {
        vertices,
        faces,
        edges: Vec::new(),
    }
}

/// A floor with walls round it that lean in or out.
fn tray(random: &mut Random) -> FoldedShape {
    let sides = 3 + random.below(7);
    let (radius, height) = (random.uniform(1.0, 2.0), random.uniform(0.2, 2.5));
    let rim = radius * random.uniform(0.6, 1.6);
    let mut faces = walls(sides, 1);
    faces.push((0..sides).rev().collect());
    shape(rings(sides, &[[radius, 0.0], [rim, height]]), faces)
}

/// Rings of trapezoids.
fn shade(random: &mut Random) -> FoldedShape {
    let (sides, rows) = (4 + random.below(7), 1 + random.below(4));
    let mut profile = vec![[random.uniform(0.6, 1.8), 0.0]];
    for row in 0..rows {
        let [radius, height] = profile[row];
        let radius = (radius + random.uniform(-0.4, 0.4)).max(0.3);
        profile.push([radius, height + random.uniform(0.3, 1.0)]);
    }
    shape(rings(sides, &profile), walls(sides, rows))
}

/// Four walls and a roof with gables or hips.
fn house(random: &mut Random) -> FoldedShape {
    let [a, b] = [random.uniform(1.0, 2.0), random.uniform(1.0, 3.0)];
    let eaves = random.uniform(0.5, 2.0);
    let ridge = eaves + random.uniform(0.3, 1.2);
    let corners = |z: f64| [[0.0, 0.0, z], [a, 0.0, z], [a, b, z], [0.0, b, z]];
    let gabled = random.chance(0.5);
    let inset = if gabled { 0.0 } else { 0.45 * a.min(b) };
    let ridge = [[a / 2.0, inset, ridge], [a / 2.0, b - inset, ridge]];
    let places = [corners(0.0).as_slice(), &corners(eaves), &ridge].concat();
    let mut faces = vec![
        vec![1, 2, 6, 5],
        vec![3, 0, 4, 7],
        vec![5, 6, 9, 8],
        vec![4, 8, 9, 7],
    ];
    if gabled {
        faces.extend([vec![0, 1, 5, 8, 4], vec![2, 3, 7, 9, 6]]);
    } else {
        faces.extend([
            vec![0, 1, 5, 4],
            vec![2, 3, 7, 6],
            vec![4, 5, 8],
            vec![6, 7, 9],
        ]);
    }
    shape(places.into_iter().map(Vector3::from).collect(), faces)
}

/// The upper half of a globe.
fn dome(random: &mut Random) -> FoldedShape {
    let (sides, rows) = (5 + random.below(5), 2 + random.below(3));
    #[allow(clippy::cast_precision_loss, reason = "a few rows")]
    let angle = |row: usize| FRAC_PI_2 * row as f64 / rows as f64;
    let profile: Vec<[f64; 2]> = (0..rows)
        .map(|row| [angle(row).cos(), angle(row).sin()])
        .collect();
    let mut vertices = rings(sides, &profile);
    let mut faces = walls(sides, rows - 1);
    let (last, tip) = (vertices.len() - sides, vertices.len());
    vertices.push(Vector3::z());
    faces.extend((0..sides).map(|k| vec![last + k, last + (k + 1) % sides, tip]));
    shape(vertices, faces)
}

/// A chain of rectangles.
fn strip(random: &mut Random) -> FoldedShape {
    let (mut at, mut angle) = (Vector3::zeros(), 0.0_f64);
    let mut vertices = vec![at, at + Vector3::y()];
    let panels = 3 + random.below(10);
    for _ in 0..panels {
        angle += random.uniform(-1.0, 1.0);
        at += random.uniform(0.4, 1.0) * Vector3::new(angle.cos(), 0.0, angle.sin());
        vertices.extend([at, at + Vector3::y()]);
    }
    let panel = |k: usize| vec![2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1];
    shape(vertices, (0..panels).map(panel).collect())
}
