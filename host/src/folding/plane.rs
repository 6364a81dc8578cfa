//! Coordinates in a plane of space.

use nalgebra::{Vector2, Vector3};

/// Points in coordinates of a plane with this unit normal, seen from where it points to. The first axis is as
/// near to the x of space as the plane allows, so that standing shapes stay recognisable.
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
