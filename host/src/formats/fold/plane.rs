//! Flat sheets that lie anywhere in space.

use nalgebra::{Matrix3, Vector2, Vector3};

/// A sheet may leave its plane by this part of its size and still count as flat.
const FLAT: f64 = 1e-6;

/// The sheet in coordinates of its own plane, seen from +z (from +y, or else +x, if it stands
/// upright), and whether it lay in the xy-plane; `None` if it is not flat.
pub(super) fn flatten(points: &[Vector3<f64>]) -> Option<(Vec<Vector2<f64>>, bool)> {
    let project = |p: &Vector3<f64>| Vector2::new(p.x, p.y);
    #[allow(clippy::float_cmp, reason = "the usual case, written exactly")]
    let level = points.iter().all(|p| p.z == points[0].z);
    if level {
        return Some((points.iter().map(project).collect(), true));
    }
    #[allow(clippy::cast_precision_loss, reason = "a mean")]
    let center = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let centered = || points.iter().map(|p| p - center);
    let size = centered().fold(0.0, |size, p| f64::max(size, p.norm()));
    let scatter = centered().fold(Matrix3::zeros(), |sum: Matrix3<f64>, p| {
        sum + p * p.transpose()
    });
    let eigen = scatter.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let mut up = eigen.eigenvectors.column(least).into_owned();
    let [x, y, z] = [up.x, up.y, up.z].map(|c| if c.abs() < FLAT { 0.0 } else { c });
    let facing = [z, y, x].into_iter().find(|c| c.abs() > 0.0)?;
    up *= facing.signum();
    if centered().any(|p| p.dot(&up).abs() > FLAT * size) {
        return None;
    }
    // Keeps x where it was as far as the plane allows, so that standing sheets stay recognisable.
    let along = Vector3::x() - up * up.x;
    let right = if along.norm() > 0.5 {
        along.normalize()
    } else {
        (Vector3::y() - up * up.y).normalize()
    };
    let ahead = up.cross(&right);
    let place = |p: &Vector3<f64>| Vector2::new(p.dot(&right), p.dot(&ahead));
    Some((points.iter().map(place).collect(), false))
}
