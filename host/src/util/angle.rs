//! Angles between directions of the plane.

use core::f64::consts::TAU;

use nalgebra::Vector2;

/// Returns the counter-clockwise angle from one direction to another, radians, from 0 to a full turn.
pub(crate) fn turn_between(from: Vector2<f64>, to: Vector2<f64>) -> f64 {
    let angle = from.perp(&to).atan2(from.dot(&to));
    if angle < 0.0 { angle + TAU } else { angle }
}
