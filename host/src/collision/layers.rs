//! Which of two pieces lies on the other. Where they touch all over neither is deep in the other, and yet one that came
//! from above must not leave below.

use nalgebra::Vector3;

use super::crossing::ConvexPiece;

/// Where pieces lie over each other, seen along the normal of each: how high the second is over the first, and the
/// first over the second, in the middle of what lies over them. `None` where no more than strips as narrow as
/// `tolerance` do.
pub(super) fn heights(
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
