//! Lays flat sheets that lie anywhere in space into the plane.

use nalgebra::{Matrix3, Vector2, Vector3};

use crate::folding::in_plane;
use crate::pattern::{Digits, twice_area};

/// Largest distance of a flat sheet from its plane, as a fraction of the sheet's size.
const MAX_OFF_PLANE_RATIO: f64 = 1e-6;

/// Texts of the error for a sheet that is not flat: the expected and the found vertices.
pub(in crate::read) const FLAT_PATTERN: &str =
    "a flat crease pattern (a folded shape has to be unfolded first)";
pub(in crate::read) const NOT_FLAT: &str = "vertices that lie in no common plane";

/// Returns the vertices of a flat sheet in coordinates of its plane, seen from where the faces run counter-clockwise.
/// If they had to be turned into that plane, returns the precision of their coordinates as well.
/// Returns `None` if the sheet is not flat. Adds the assumptions made to `notes`.
pub(in crate::read) fn lay(
    points: &[Vector3<f64>],
    faces: Option<&[Vec<usize>]>,
    notes: &mut Vec<String>,
) -> Option<(Vec<Vector2<f64>>, Option<Digits>)> {
    let (mut vertices, level) = flatten(points)?;
    if !level {
        notes.push(
            "the sheet stands in space: seen from its upper side, or where faces are given from where they run counter-clockwise".into(),
        );
    }
    let clockwise = faces.is_some_and(|faces| winds_clockwise(&vertices, faces));
    if clockwise && level {
        notes
            .push("faces_vertices run clockwise: the sheet is seen from above all the same".into());
    } else if clockwise {
        vertices.iter_mut().for_each(|v| v.x = -v.x);
    }
    let written = || Digits::of_coordinates(points.iter().map(|&point| point.into()), |_| false);
    Some((vertices, (!level).then(written)))
}

/// Returns `true` if the signed areas of the faces sum to a negative area. Vertices that do not exist are skipped.
fn winds_clockwise(vertices: &[Vector2<f64>], faces: &[Vec<usize>]) -> bool {
    let areas = faces.iter().map(|face| {
        let corners = face.iter().filter_map(|&vertex| vertices.get(vertex));
        twice_area(corners.copied())
    });
    areas.sum::<f64>() < 0.0
}

/// Returns the sheet in coordinates of its own plane, seen from +z (from +y, or else +x, if the sheet stands upright),
/// and `true` if the sheet lies parallel to the xy-plane. Returns `None` if it is not flat. The normal is the
/// eigenvector of the smallest eigenvalue of the scatter matrix.
fn flatten(points: &[Vector3<f64>]) -> Option<(Vec<Vector2<f64>>, bool)> {
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
    let [x, y, z] = [up.x, up.y, up.z].map(|c| {
        if c.abs() < MAX_OFF_PLANE_RATIO {
            0.0
        } else {
            c
        }
    });
    let facing = [z, y, x].into_iter().find(|c| c.abs() > 0.0)?;
    up *= facing.signum();
    if centered().any(|p| p.dot(&up).abs() > MAX_OFF_PLANE_RATIO * size) {
        return None;
    }
    Some((in_plane(points, &up), false))
}
