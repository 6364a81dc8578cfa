//! Convex hulls in the plane.

use nalgebra::Vector2;

/// Returns the corners of the convex hull, counter-clockwise (A. Andrew, "Another efficient algorithm for convex hulls in
/// two dimensions", 1979). Points within `near` of a side are no corners.
pub(crate) fn convex_hull(mut points: Vec<Vector2<f64>>, near: f64) -> Vec<Vector2<f64>> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = &Vector2<f64>>| {
        let mut hull: Vec<Vector2<f64>> = Vec::new();
        for &point in points {
            while let [.., a, b] = hull[..]
                && (b - a).perp(&(point - a)) <= near * (point - a).norm()
            {
                hull.pop();
            }
            hull.push(point);
        }
        hull.pop();
        hull
    };
    let mut hull = half(&mut points.iter());
    hull.extend(half(&mut points.iter().rev()));
    hull
}
