//! Coordinates of points of space in a plane.

use nalgebra::{Vector2, Vector3};

/// Returns points in coordinates of a plane with this unit normal, seen from the side to which the normal
/// points. The first axis is as near to the x axis of space as the plane allows, so that standing shapes stay
/// recognisable; to the y axis if the normal is near the x axis.
pub(crate) fn in_plane<'a>(
    points: impl IntoIterator<Item = &'a Vector3<f64>>,
    up: &Vector3<f64>,
) -> Vec<Vector2<f64>> {
    let along = Vector3::x() - up * up.x;
    let right = if along.norm() > 0.5 {
        along.normalize()
    } else {
        (Vector3::y() - up * up.y).normalize()
    };
    let ahead = up.cross(&right);
    let place = |p: &Vector3<f64>| Vector2::new(p.dot(&right), p.dot(&ahead));
    points.into_iter().map(place).collect()
}
