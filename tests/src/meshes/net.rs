//! Nets of polyhedra: sheets without real vertices, each of whose hinges is free.

use core::f64::consts::TAU;

use foldpath::pattern::Drawing;
use foldpath::unfold::{FoldedShape, UnfoldOptions, unfold};
use nalgebra::Vector3;

use super::first_good;
use super::measured::rounded;
use crate::Random;

/// Places to which coordinates and goals are rounded: six digits, as files have them.
const UNIT: f64 = 1e-5;

/// Draws the net of a polyhedron of 8 to 200 triangles, rounded to six digits. Its corners lie in random directions from
/// the middle: on a sphere, or for every other net at random distances, so that the polyhedron is star-shaped.
#[must_use]
pub fn net(random: &mut Random) -> Drawing {
    first_good(random, |random| {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "6 to 102"
        )]
        let corners = random.log_uniform(6.0, 102.0) as usize;
        net_of(random, corners)
    })
}

/// Draws the net of a polyhedron with this many corners, and twice as many triangles less four. Returns `None` if the
/// triangles of the net would overlap.
#[must_use]
pub fn net_of(random: &mut Random, corners: usize) -> Option<Drawing> {
    let directions: Vec<_> = (0..corners).map(|_| direction(random)).collect();
    let nearest = if random.chance(0.5) { 1.0 } else { 0.6 };
    let shape = FoldedShape {
        faces: hull(&directions),
        vertices: directions
            .iter()
            .map(|direction| direction * random.uniform(nearest, 1.0))
            .collect(),
        edges: Vec::new(),
    };
    let unfolding = unfold(&shape, &UnfoldOptions::default()).ok()?;
    let mut net = unfolding.drawing.filter(|_| unfolding.pieces == 1)?;
    for goal in net.edges.iter_mut().filter_map(|edge| edge.goal.as_mut()) {
        *goal = (*goal / UNIT).round() * UNIT;
    }
    Some(rounded(net, UNIT))
}

/// Returns a direction, evenly distributed.
fn direction(random: &mut Random) -> Vector3<f64> {
    let (height, around) = (random.uniform(-1.0, 1.0), random.uniform(0.0, TAU));
    let radius = (1.0 - height * height).sqrt();
    Vector3::new(radius * around.cos(), radius * around.sin(), height)
}

/// Returns the triangles of the convex hull of points on a sphere, counter-clockwise from outside. Cost: O(n^4).
fn hull(points: &[Vector3<f64>]) -> Vec<Vec<usize>> {
    let mut faces = Vec::new();
    for a in 0..points.len() {
        for b in a + 1..points.len() {
            for c in b + 1..points.len() {
                let normal = (points[b] - points[a]).cross(&(points[c] - points[a]));
                let outside = |side: f64| {
                    let beyond = |(k, p): (usize, &Vector3<f64>)| {
                        ![a, b, c].contains(&k) && side * normal.dot(&(p - points[a])) > 0.0
                    };
                    points.iter().enumerate().any(beyond)
                };
                if !outside(1.0) {
                    faces.push(vec![a, b, c]);
                } else if !outside(-1.0) {
                    faces.push(vec![a, c, b]);
                }
            }
        }
    }
    faces
}
