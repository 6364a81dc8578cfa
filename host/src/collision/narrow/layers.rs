//! Finds out which of two stacked pieces lies on top. Pieces in contact over an area have no crossing depth,
//! and yet a piece that came from above must not leave below.

use nalgebra::Vector3;

use super::crossing::ConvexPiece;

/// Returns the signed heights of `b` over the plane of `a` and of `a` over the plane of `b`. Each height is
/// measured along the normal of the plane, in the middle of the part of the piece that lies over or under the
/// other one. Returns `None` if such a part is empty, or no more than a strip about as narrow as `tolerance`.
pub(in crate::collision) fn heights(
    a: &ConvexPiece<'_>,
    b: &ConvexPiece<'_>,
    tolerance: f64,
) -> Option<[f64; 2]> {
    Some([height(a, b, tolerance)?, height(b, a, tolerance)?])
}

fn height(under: &ConvexPiece<'_>, piece: &ConvexPiece<'_>, tolerance: f64) -> Option<f64> {
    let over = under.part_over(piece);
    let first = *over.first()?;
    let sides = over.iter().zip(over.iter().cycle().skip(1));
    let (mut area, mut around) = (Vector3::zeros(), 0.0);
    for (from, to) in sides {
        area += (from - first).cross(&(to - first)) / 2.0;
        around += (to - from).norm();
    }
    #[allow(clippy::cast_precision_loss, reason = "a few corners")]
    let middle = over.iter().sum::<Vector3<f64>>() / over.len() as f64;
    let wide = under.normal.dot(&area).abs() > tolerance * around;
    wide.then(|| under.normal.dot(&(middle - under.corners[0])))
}
