//! Triangulates a face by ear clipping.

use nalgebra::Vector2;
use robust::{Coord, orient2d};

/// Returns the triangles of a simple counter-clockwise polygon, as positions in `polygon`, or `None` if the polygon is
/// not simple.
///
/// Clips the ear with the largest smallest angle first, which leaves no triangle without area where vertices lie on a
/// straight side. Cost: O(n²) for n corners.
pub(crate) fn triangulate(polygon: &[Vector2<f64>]) -> Option<Vec<[usize; 3]>> {
    let count = polygon.len();
    let mut open = vec![true; count];
    let mut tips: Vec<Tip> = (0..count)
        .map(|k| Tip::new(polygon, [(k + count - 1) % count, k, (k + 1) % count]))
        .collect();
    let mut triangles = Vec::with_capacity(count.saturating_sub(2));
    for _ in 3..count {
        let mut best: Option<(f64, [usize; 3])> = None;
        for k in (0..count).filter(|&k| open[k]) {
            let tip = &mut tips[k];
            if tip.is_ear(polygon, &open) && best.is_none_or(|(most, _)| tip.quality > most) {
                best = Some((tip.quality, tip.corners));
            }
        }
        let (_, [a, b, c]) = best?;
        triangles.push([a, b, c]);
        open[b] = false;
        let (before, behind) = (tips[a].corners[0], tips[c].corners[2]);
        tips[a] = Tip::new(polygon, [before, a, c]);
        tips[c] = Tip::new(polygon, [a, c, behind]);
    }
    let mut left = (0..count).filter(|&k| open[k]);
    let last = [left.next()?, left.next()?, left.next()?];
    (turn(polygon, last) > 0.0).then(|| {
        triangles.push(last);
        triangles
    })
}

/// A corner with its neighbours, a candidate for an ear.
struct Tip {
    corners: [usize; 3],
    quality: f64,
    turns_left: bool,
    /// Number of corners, counted from the first, that are outside the triangle or already cut off. They remain so, and
    /// the next test continues behind them.
    outside: usize,
}

impl Tip {
    fn new(polygon: &[Vector2<f64>], corners: [usize; 3]) -> Self {
        Self {
            corners,
            quality: quality(polygon, corners),
            turns_left: turn(polygon, corners) > 0.0,
            outside: 0,
        }
    }

    fn is_ear(&mut self, polygon: &[Vector2<f64>], open: &[bool]) -> bool {
        let [a, b, c] = self.corners;
        let outside = |k: usize| {
            !open[k]
                || [a, b, c].contains(&k)
                || [[a, b, k], [b, c, k], [c, a, k]]
                    .iter()
                    .any(|&corners| turn(polygon, corners) < 0.0)
        };
        while self.turns_left && self.outside < open.len() && outside(self.outside) {
            self.outside += 1;
        }
        self.turns_left && self.outside == open.len()
    }
}

/// Returns a positive number if the three corners turn left, and 0 if they lie on a line. The sign is exact.
fn turn(polygon: &[Vector2<f64>], corners: [usize; 3]) -> f64 {
    let [a, b, c] = corners.map(|k| Coord {
        x: polygon[k].x,
        y: polygon[k].y,
    });
    orient2d(a, b, c)
}

/// Returns about the sine of the smallest angle: twice the area over the squared longest side.
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
