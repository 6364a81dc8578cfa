//! Triangulation of a face by cutting ears.

use nalgebra::Vector2;
use robust::{Coord, orient2d};

/// Triangles of a simple counter-clockwise polygon, as positions in `polygon`, or `None` if it is
/// not simple.
///
/// Cuts the ear with the largest smallest angle first, which leaves no flat triangle where vertices
/// lie on a straight side. O(n³) for n corners: faces have few.
pub(super) fn triangulate(polygon: &[Vector2<f64>]) -> Option<Vec<[usize; 3]>> {
    let mut open: Vec<usize> = (0..polygon.len()).collect();
    let mut triangles = Vec::with_capacity(polygon.len().saturating_sub(2));
    while open.len() > 3 {
        let count = open.len();
        let corners = |k: usize| {
            [
                open[(k + count - 1) % count],
                open[k],
                open[(k + 1) % count],
            ]
        };
        let best = (0..count)
            .filter(|&k| is_ear(polygon, &open, corners(k)))
            .map(|k| (k, quality(polygon, corners(k))))
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))?;
        triangles.push(corners(best.0));
        open.remove(best.0);
    }
    let last = [open[0], open[1], open[2]];
    (turn(polygon, last) > 0.0).then(|| {
        triangles.push(last);
        triangles
    })
}

/// Positive if the three corners turn left, 0 if they lie on a line. Exact.
fn turn(polygon: &[Vector2<f64>], corners: [usize; 3]) -> f64 {
    let [a, b, c] = corners.map(|k| Coord {
        x: polygon[k].x,
        y: polygon[k].y,
    });
    orient2d(a, b, c)
}

fn is_ear(polygon: &[Vector2<f64>], open: &[usize], [a, b, c]: [usize; 3]) -> bool {
    let inside = |&k: &usize| {
        turn(polygon, [a, b, k]) >= 0.0
            && turn(polygon, [b, c, k]) >= 0.0
            && turn(polygon, [c, a, k]) >= 0.0
    };
    let mut others = open.iter().filter(|k| ![a, b, c].contains(k));
    turn(polygon, [a, b, c]) > 0.0 && !others.any(inside)
}

/// Sine of the smallest angle, about: twice the area over the squared longest side.
fn quality(polygon: &[Vector2<f64>], [a, b, c]: [usize; 3]) -> f64 {
    let [a, b, c] = [polygon[a], polygon[b], polygon[c]];
    let longest = (b - a).norm_squared();
    let longest = longest
        .max((c - b).norm_squared())
        .max((a - c).norm_squared());
    (b - a).perp(&(c - a)) / longest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn areas(polygon: &[[f64; 2]]) -> Option<Vec<f64>> {
        let polygon: Vec<Vector2<f64>> = polygon.iter().map(|&p| p.into()).collect();
        let triangles = triangulate(&polygon)?;
        let area = |[a, b, c]: [usize; 3]| {
            (polygon[b] - polygon[a]).perp(&(polygon[c] - polygon[a])) / 2.0
        };
        Some(triangles.into_iter().map(area).collect())
    }

    #[test]
    fn a_vertex_on_a_straight_side_gives_no_flat_triangle() {
        let areas = areas(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0]]).unwrap();
        assert_eq!(areas, [0.5, 0.5]);
    }

    #[test]
    fn a_concave_polygon_is_covered() {
        let areas = areas(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]]).unwrap();
        assert_eq!(areas.len(), 3);
        assert!(areas.iter().all(|&a| a > 0.0));
        assert!((areas.iter().sum::<f64>() - 10.0).abs() < 1e-12);
    }

    #[test]
    fn a_polygon_that_crosses_itself_is_refused() {
        assert_eq!(
            areas(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]),
            None
        );
    }
}
