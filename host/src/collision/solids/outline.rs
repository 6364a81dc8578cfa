//! Insets the sides of a polygon, each by a distance of its own.

use nalgebra::Vector2;

/// Sine of the angle between two sides below which they are in line.
const STRAIGHT_SINE: f64 = 1e-9;

/// A side of a polygon, with its line once it is inset.
#[derive(Clone, Copy, Debug)]
struct Side {
    /// Unit direction, with the polygon to the left.
    along: Vector2<f64>,
    /// A point of the inset line.
    point: Vector2<f64>,
}

impl Side {
    /// Returns the point in which the lines of two successive sides meet; `corner` is theirs before the inset. Where sides are
    /// in line, the inner one of the two lines counts.
    fn meet(&self, next: &Self, corner: Vector2<f64>) -> Vector2<f64> {
        let sine = self.along.perp(&next.along);
        if sine.abs() > STRAIGHT_SINE {
            let way = (next.point - self.point).perp(&next.along) / sine;
            return self.point + self.along * way;
        }
        let inward = Vector2::new(-self.along.y, self.along.x);
        let depths = [self, next].map(|side| inward.dot(&(side.point - corner)));
        corner + inward * depths[0].max(depths[1])
    }
}

/// Returns the corners of a simple counter-clockwise polygon whose sides are moved inwards by these distances. Side k leads
/// from corner k to the next, and corners keep their numbers.
///
/// Sides in line get the larger of their insets. A side that vanishes leaves its place to its neighbours, and its two corners
/// fall together, if `may_vanish` says so.
///
/// # Errors
/// The number of a side that vanishes and may not; that of the narrowest place's side if nothing of the polygon is left.
pub(super) fn inset(
    corners: &[Vector2<f64>],
    insets: &[f64],
    may_vanish: impl Fn(usize) -> bool,
) -> Result<Vec<Vector2<f64>>, usize> {
    let count = corners.len();
    let next = |k: usize| if k + 1 < count { k + 1 } else { 0 };
    let sides: Vec<Side> = (0..count)
        .map(|k| {
            let along = (corners[next(k)] - corners[k]).normalize();
            let inward = Vector2::new(-along.y, along.x);
            let point = corners[k] + inward * insets[k];
            Side { along, point }
        })
        .collect();
    let most = (0..count)
        .max_by(|&a, &b| insets[a].total_cmp(&insets[b]))
        .unwrap_or(0);
    let mut left: Vec<usize> = (0..count).collect();
    let met = loop {
        if left.len() < 3 {
            return Err(most);
        }
        // The corner at the start of each side that is left.
        let met: Vec<Vector2<f64>> = (0..left.len())
            .map(|at| {
                let [side, before] = [left[at], left[(at + left.len() - 1) % left.len()]];
                // A corner whose sides stay keeps its place to the last digit.
                let moves = next(before) != side || insets[before].max(insets[side]) > 0.0;
                if moves {
                    sides[before].meet(&sides[side], corners[side])
                } else {
                    corners[side]
                }
            })
            .collect();
        let way = |at: usize| {
            sides[left[at]]
                .along
                .dot(&(met[(at + 1) % left.len()] - met[at]))
        };
        let shortest = (0..left.len()).min_by(|&a, &b| way(a).total_cmp(&way(b)));
        match shortest.filter(|&at| way(at) < 0.0) {
            None => break met,
            Some(at) if may_vanish(left[at]) => drop(left.remove(at)),
            Some(at) => return Err(left[at]),
        }
    };
    if !is_simple(&met) {
        return Err(most);
    }
    // A corner between sides that vanish is where the nearest sides that are left meet.
    let mut all = vec![Vector2::zeros(); count];
    let mut at = 0;
    for (corner, place) in all.iter_mut().enumerate() {
        while at < left.len() && left[at] < corner {
            at += 1;
        }
        *place = met[at % left.len()];
    }
    Ok(all)
}

/// Returns `true` if a closed polygon is counter-clockwise and no two of its sides cross.
fn is_simple(corners: &[Vector2<f64>]) -> bool {
    let count = corners.len();
    let side = |k: usize| [corners[k], corners[(k + 1) % count]];
    let area: f64 = (0..count).map(|k| side(k)[0].perp(&side(k)[1])).sum();
    let turn = |[from, to]: [Vector2<f64>; 2], at: Vector2<f64>| (to - from).perp(&(at - from));
    let cross = |a: [Vector2<f64>; 2], b: [Vector2<f64>; 2]| {
        turn(a, b[0]) * turn(a, b[1]) < 0.0 && turn(b, a[0]) * turn(b, a[1]) < 0.0
    };
    area > 0.0 && (0..count).all(|a| (a + 2..count).all(|b| !cross(side(a), side(b))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[[f64; 2]]) -> Vec<Vector2<f64>> {
        corners.iter().map(|&at| at.into()).collect()
    }

    #[test]
    fn a_rectangle_becomes_smaller_by_its_insets() {
        let corners = polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]]);
        let inner = inset(&corners, &[0.5, 0.25, 0.0, 1.0], |_| false).unwrap();
        assert_eq!(
            inner,
            polygon(&[[1.0, 0.5], [3.75, 0.5], [3.75, 2.0], [1.0, 2.0]])
        );
        // The insets of opposite sides meet: the sides between them vanish.
        assert!(inset(&corners, &[1.25, 0.0, 1.0, 0.0], |_| false).is_err());
        assert!(inset(&corners, &[1.25, 0.0, 1.0, 0.0], |_| true).is_err());
    }

    #[test]
    fn a_short_side_may_vanish() {
        let corners = polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [3.5, 3.5], [0.0, 3.5]]);
        let insets = [0.0, 1.0, 0.0, 0.0, 0.0];
        assert_eq!(inset(&corners, &insets, |side| side != 2), Err(2));
        let inner = inset(&corners, &insets, |_| true).unwrap();
        let whole = polygon(&[[0.0, 0.0], [3.0, 0.0], [3.0, 3.5], [3.0, 3.5], [0.0, 3.5]]);
        assert!(
            inner
                .iter()
                .zip(&whole)
                .all(|(a, b)| (a - b).norm() < 1e-12)
        );
    }

    #[test]
    fn sides_in_line_get_the_larger_inset() {
        let corners = polygon(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        let inner = inset(&corners, &[0.5, 0.25, 0.0, 0.0, 0.0], |_| false).unwrap();
        assert_eq!(inner[1], Vector2::new(1.0, 0.5));
    }

    #[test]
    fn a_reflex_corner_moves_inwards() {
        let corners = polygon(&[
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 1.0],
            [1.0, 1.0],
            [1.0, 4.0],
            [0.0, 4.0],
        ]);
        let inner = inset(&corners, &[0.0, 0.0, 0.25, 0.5, 0.0, 0.0], |_| false).unwrap();
        assert_eq!(inner[3], Vector2::new(0.5, 0.75));
    }
}
