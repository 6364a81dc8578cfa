//! Flat sheets that lie anywhere in space.

use nalgebra::{Matrix3, Vector2, Vector3};

use crate::folding::in_plane;
use crate::pattern::twice_area;

/// A sheet may leave its plane by this part of its size and still count as flat.
const FLAT: f64 = 1e-6;

/// What is expected where a sheet is not flat, and what was found.
pub(in crate::formats) const FLAT_PATTERN: &str =
    "a flat crease pattern (a folded shape has to be unfolded first)";
pub(in crate::formats) const NOT_FLAT: &str = "vertices that lie in no common plane";

/// The vertices of a flat sheet in its plane, seen from where its faces run counter-clockwise; `None` if it is
/// not flat. What was assumed is said in `notes`.
pub(in crate::formats) fn lay(
    points: &[Vector3<f64>],
    faces: Option<&[Vec<usize>]>,
    notes: &mut Vec<String>,
) -> Option<Vec<Vector2<f64>>> {
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
    Some(vertices)
}

/// Whether the faces, as far as their vertices exist, enclose a negative area.
fn winds_clockwise(vertices: &[Vector2<f64>], faces: &[Vec<usize>]) -> bool {
    let areas = faces.iter().map(|face| {
        let corners = face.iter().filter_map(|&vertex| vertices.get(vertex));
        twice_area(corners.copied())
    });
    areas.sum::<f64>() < 0.0
}

/// The sheet in coordinates of its own plane, seen from +z (from +y, or else +x, if it stands
/// upright), and whether it lay in the xy-plane; `None` if it is not flat.
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
    let [x, y, z] = [up.x, up.y, up.z].map(|c| if c.abs() < FLAT { 0.0 } else { c });
    let facing = [z, y, x].into_iter().find(|c| c.abs() > 0.0)?;
    up *= facing.signum();
    if centered().any(|p| p.dot(&up).abs() > FLAT * size) {
        return None;
    }
    Some((in_plane(points, &up), false))
}
