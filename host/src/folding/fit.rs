//! Rigid registration: moves one shape onto another with least squared distances (Kabsch 1976).

use nalgebra::{Matrix3, MatrixXx3, Rotation3, Vector3};

use crate::pattern::CreasePattern;

/// Aligns the shape `a` of a pattern's vertices with its shape `b`: moves each sheet rigidly on its own, with least
/// squared distances. Vertices without a face stay where they are.
#[must_use]
pub fn align_sheets(
    pattern: &CreasePattern,
    a: &[Vector3<f64>],
    b: &[Vector3<f64>],
) -> Vec<Vector3<f64>> {
    let mut laid = a.to_vec();
    for sheet in vertices_of_sheets(pattern) {
        let of = |shape: &[Vector3<f64>]| -> Vec<_> { sheet.iter().map(|&v| shape[v]).collect() };
        for (&vertex, point) in sheet.iter().zip(align_rigid(&of(a), &of(b))) {
            laid[vertex] = point;
        }
    }
    laid
}

/// Returns the rigid motion of the shape `a` of a pattern's vertices onto its shape `b`, as [`fit`] does. Vertices without a
/// face count for nothing.
pub(crate) fn fit_sheets(
    pattern: &CreasePattern,
    a: &[Vector3<f64>],
    b: &[Vector3<f64>],
) -> (Matrix3<f64>, [Vector3<f64>; 2]) {
    let used = |shape: &[Vector3<f64>]| -> Vec<Vector3<f64>> {
        let points = shape.iter().zip(pattern.corners().iter());
        let used = points.filter(|(_, faces)| !faces.is_empty());
        used.map(|(point, _)| *point).collect()
    };
    fit(&used(a), &used(b))
}

/// Returns for each sheet the positions of its vertices in the list of all vertices. Vertices without a face
/// belong to no sheet.
fn vertices_of_sheets(pattern: &CreasePattern) -> Vec<Vec<usize>> {
    let mut sheets = vec![Vec::new(); pattern.sheets()];
    for (vertex, faces) in pattern.corners().iter().enumerate() {
        if let Some(face) = faces.first() {
            sheets[pattern.sheet_of_faces()[face.index()] as usize].push(vertex);
        }
    }
    sheets
}

/// Aligns the points of `a` with those of `b`: moves all of them rigidly, with least squared distances.
#[must_use]
pub fn align_rigid(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let (r_ba, [a_center, b_center]) = fit(a, b);
    a.iter().map(|a| r_ba * (a - a_center) + b_center).collect()
}

/// Returns the rigid motion of the points of `a` onto those of `b` with least squared distances: a rotation,
/// and the centres of both point sets, the first of which the motion takes to the second.
///
/// Implements the method of W. Kabsch, "A solution for the best rotation to relate two sets of vectors", Acta
/// Cryst. A32, 1976. The method uses squares of lengths, which keep few digits of a slender shape's width.
/// Newton's method, which uses the remaining distances between the points, refines its answer. Points without a
/// partner count for nothing.
#[must_use]
pub fn fit(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> (Matrix3<f64>, [Vector3<f64>; 2]) {
    #[allow(clippy::cast_precision_loss, reason = "a mean")]
    let count = a.len().min(b.len()).max(1) as f64;
    let center =
        |p: &[Vector3<f64>]| p.iter().take(a.len().min(b.len())).sum::<Vector3<f64>>() / count;
    let (a_center, b_center) = (center(a), center(b));
    let pairs = || {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| (a - a_center, b - b_center))
    };
    let covariance: Matrix3<f64> = pairs().map(|(a, b)| a * b.transpose()).sum();
    let mut r_ba = rotation(&covariance);
    for _ in 0..NEWTON_STEPS {
        let (mut curvature, mut slope) = (Matrix3::zeros(), Vector3::zeros());
        for (a, b) in pairs() {
            let turned = r_ba * a;
            let lever = turned.cross_matrix();
            curvature -= lever * lever;
            slope += turned.cross(&(b - turned));
        }
        let least = curvature.trace() * f64::EPSILON;
        let Some(factor) = (curvature + Matrix3::from_diagonal_element(least)).cholesky() else {
            break;
        };
        r_ba = Rotation3::new(factor.solve(&slope)) * r_ba;
    }
    (r_ba, [a_center, b_center])
}

/// Number of Newton steps that refine a fit: if widths are a ten-thousandth of lengths, each step leaves a
/// ten-thousandth of the error.
const NEWTON_STEPS: usize = 2;

/// Returns the rotation of Kabsch's method.
fn rotation(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    // A matrix that is not finite has no decomposition, and the search for one would not end.
    if !covariance.iter().all(|entry| entry.is_finite()) {
        return Matrix3::identity();
    }
    // nalgebra's decomposition of 3x3 matrices squares the entries once more; its decomposition of other sizes
    // does not.
    let svd = MatrixXx3::from_column_slice(covariance.as_slice()).svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return Matrix3::identity();
    };
    let (u, v_t) = (u.as_slice(), v_t.as_slice());
    let [u, v_t] = [u, v_t].map(Matrix3::from_column_slice);
    let mut keep_hand = Matrix3::identity();
    // Singular values come in descending order: a reflection is avoided by reversing the weakest direction.
    keep_hand[(2, 2)] = (u * v_t).determinant().signum();
    v_t.transpose() * keep_hand * u.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moved_shape_is_laid_back_and_a_mirrored_one_is_not() {
        let shape = [[0., 0., 0.], [2., 0., 0.], [0., 1., 0.], [0., 0., 3.]].map(Vector3::from);
        let turn = Rotation3::from_euler_angles(0.4, -1.1, 2.0);
        let moved = shape.map(|p| turn * p + Vector3::new(5.0, -1.0, 0.5));
        let worst = |laid: Vec<Vector3<f64>>| {
            let distances = laid.iter().zip(&shape).map(|(a, b)| (a - b).norm());
            distances.fold(0.0, f64::max)
        };
        assert!(worst(align_rigid(&moved, &shape)) < 1e-14);
        let mirrored = moved.map(|p| Vector3::new(-p.x, p.y, p.z));
        assert!(worst(align_rigid(&mirrored, &shape)) > 0.1);
    }

    #[test]
    fn what_is_no_number_is_laid_nowhere() {
        let shape = [[0., 0., 0.], [1., 0., 0.], [0., f64::NAN, 0.]].map(Vector3::from);
        assert!(align_rigid(&shape, &shape).iter().any(|p| p.x.is_nan()));
    }

    #[test]
    fn slender_shapes_are_laid_back_to_rounding_of_their_length() {
        for length in [1e1, 1e3, 1e5, 1e6] {
            let shape = [
                [0., 0., 0.],
                [length, 0., 0.],
                [length, 1., 0.],
                [0., 1., 0.],
            ];
            let shape = shape.map(Vector3::from);
            let turn = Rotation3::from_euler_angles(0.4, -1.1, 2.0);
            let moved = shape.map(|p| turn * p + Vector3::new(5.0, -1.0, 0.5));
            for (laid, there) in align_rigid(&shape, &moved).iter().zip(&moved) {
                assert!((laid - there).norm() < 1e-15 * length, "{length:e}");
            }
        }
    }
}
