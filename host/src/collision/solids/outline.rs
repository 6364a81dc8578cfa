//! Insets the sides of a polygon, each by a distance of its own.

use nalgebra::Vector2;

/// Sine of the angle between two sides below which they are in line.
const STRAIGHT_SINE: f64 = 1e-9;

/// A side of a polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// Its start.
    pub(super) from: Vector2<f64>,
    /// Unit direction, with the polygon to the left.
    pub(super) along: Vector2<f64>,
    /// Distance by which it moves inwards.
    pub(super) inset: f64,
}

impl Side {
    fn inward(&self) -> Vector2<f64> {
        Vector2::new(-self.along.y, self.along.x)
    }

    /// Returns a point of the inset line.
    fn point(&self) -> Vector2<f64> {
        self.from + self.inward() * self.inset
    }

    /// Returns the point in which the lines of this side and of another that follows it meet. If they are in line,
    /// the inner line counts.
    fn meet(&self, next: &Self) -> Vector2<f64> {
        if self.is_in_line(next) {
            return next.from + next.inward() * self.inset.max(next.inset);
        }
        let sine = self.along.perp(&next.along);
        let way = (next.point() - self.point()).perp(&next.along) / sine;
        self.point() + self.along * way
    }

    fn is_in_line(&self, next: &Self) -> bool {
        self.along.perp(&next.along).abs() <= STRAIGHT_SINE
    }
}

/// Returns the start and the end of each side of a simple counter-clockwise polygon after its sides have moved inwards. A side
/// may have no length: it then cuts a corner off.
///
/// Sides in line all get the largest of their insets, and at a reflex corner a side is not prolonged beyond it. A side that vanishes leaves its place to its neighbours, and its ends fall
/// together, if `may_vanish` says so.
///
/// # Errors
/// The number of a side that vanishes and may not; that of the largest inset if nothing of the polygon is left.
pub(super) fn inset(
    sides: &[Side],
    may_vanish: impl Fn(usize) -> bool,
) -> Result<Vec<[Vector2<f64>; 2]>, usize> {
    let sides = &levelled(sides);
    let count = sides.len();
    let most = (0..count).max_by(|&a, &b| sides[a].inset.total_cmp(&sides[b].inset));
    let most = most.unwrap_or(0);
    let mut left: Vec<usize> = (0..count).collect();
    let starts = loop {
        if left.len() < 3 {
            return Err(most);
        }
        // The start of each side that is left.
        let starts: Vec<Vector2<f64>> = (0..left.len())
            .map(|at| {
                let [side, before] = [left[at], left[(at + left.len() - 1) % left.len()]];
                // A corner whose sides stay keeps its place to the last digit.
                let stays = sides[before].inset.abs() <= 0.0 && sides[side].inset.abs() <= 0.0;
                if stays && (before + 1) % count == side {
                    sides[side].from
                } else {
                    sides[before].meet(&sides[side])
                }
            })
            .collect();
        let way = |at: usize| {
            let way = starts[(at + 1) % left.len()] - starts[at];
            sides[left[at]].along.dot(&way)
        };
        let shortest = (0..left.len()).min_by(|&a, &b| way(a).total_cmp(&way(b)));
        match shortest.filter(|&at| way(at) < 0.0) {
            None => break starts,
            Some(at) if may_vanish(left[at]) => drop(left.remove(at)),
            Some(at) => return Err(left[at]),
        }
    };
    if !is_simple(&starts) {
        return Err(most);
    }
    // A side that vanishes lies where the nearest sides that are left meet.
    let mut all = vec![[Vector2::zeros(); 2]; count];
    let mut at = 0;
    for (side, ends) in all.iter_mut().enumerate() {
        while at < left.len() && left[at] < side {
            at += 1;
        }
        let start = starts[at % left.len()];
        let is_left = left.get(at) == Some(&side);
        let end = if is_left {
            starts[(at + 1) % left.len()]
        } else {
            start
        };
        *ends = [start, end];
    }
    Ok(all)
}

/// Returns the sides with insets that are large enough at their corners: sides in line get the largest of their insets. At a
/// reflex corner, a side whose neighbour moves inwards follows it, so that it is not prolonged beyond the corner.
fn levelled(sides: &[Side]) -> Vec<Side> {
    let mut level = sides.to_vec();
    let count = level.len();
    // Twice round, so that a run of sides may pass the first one, and in both directions.
    let round = (0..2 * count).map(|k| k % count);
    for k in round.clone().chain(round.rev()) {
        let next = (k + 1) % count;
        let (along, next_along) = (level[k].along, level[next].along);
        if level[k].is_in_line(&level[next]) || along.perp(&next_along) < 0.0 {
            let cosine = along.dot(&next_along).max(0.0);
            let follows = |inset: f64, other: f64| {
                if other > 0.0 {
                    inset.max(other * cosine)
                } else {
                    inset
                }
            };
            let [inset, next_inset] = [level[k].inset, level[next].inset];
            level[k].inset = follows(inset, next_inset);
            level[next].inset = follows(next_inset, inset);
        }
    }
    level
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

    fn sides(corners: &[[f64; 2]], insets: &[f64]) -> Vec<Side> {
        let next = corners.iter().cycle().skip(1);
        let sides = corners.iter().zip(next).zip(insets);
        let sides = sides.map(|((&from, &to), &inset)| {
            let [from, to] = [from, to].map(Vector2::from);
            Side {
                from,
                along: (to - from).normalize(),
                inset,
            }
        });
        sides.collect()
    }

    fn starts(inner: &[[Vector2<f64>; 2]]) -> Vec<[f64; 2]> {
        inner.iter().map(|[start, _]| (*start).into()).collect()
    }

    #[test]
    fn a_rectangle_becomes_smaller_by_its_insets() {
        let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]];
        let inner = inset(&sides(&corners, &[0.5, 0.25, 0.0, 1.0]), |_| false).unwrap();
        assert_eq!(
            starts(&inner),
            [[1.0, 0.5], [3.75, 0.5], [3.75, 2.0], [1.0, 2.0]]
        );
        // The insets of opposite sides meet: the sides between them vanish.
        let narrow = sides(&corners, &[1.25, 0.0, 1.0, 0.0]);
        assert!(inset(&narrow, |_| false).is_err());
        assert!(inset(&narrow, |_| true).is_err());
    }

    #[test]
    fn a_short_side_may_vanish() {
        let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [3.5, 3.5], [0.0, 3.5]];
        let sides = sides(&corners, &[0.0, 1.0, 0.0, 0.0, 0.0]);
        assert_eq!(inset(&sides, |side| side != 2).err(), Some(2));
        let inner = inset(&sides, |_| true).unwrap();
        let whole = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.5], [3.0, 3.5], [0.0, 3.5]];
        let off = inner
            .iter()
            .zip(whole)
            .map(|([a, _], b)| (a - Vector2::from(b)).norm());
        assert!(off.fold(0.0, f64::max) < 1e-12);
    }

    #[test]
    fn sides_in_line_get_the_larger_inset() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let inner = inset(&sides(&corners, &[0.5, 0.25, 0.0, 0.0, 0.0]), |_| false).unwrap();
        assert_eq!(inner[1][0], Vector2::new(1.0, 0.5));
        assert_eq!(inner[1][1], Vector2::new(2.0, 0.5));
    }

    #[test]
    fn a_reflex_corner_moves_inwards() {
        let corners = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 1.0],
            [1.0, 1.0],
            [1.0, 4.0],
            [0.0, 4.0],
        ];
        let inner = inset(&sides(&corners, &[0.0, 0.0, 0.25, 0.5, 0.0, 0.0]), |_| {
            false
        })
        .unwrap();
        assert_eq!(inner[3][0], Vector2::new(0.5, 0.75));
    }

    #[test]
    fn a_side_is_not_prolonged_beyond_a_reflex_corner() {
        // The side at the bottom, a hinge, lies between two ears.
        let corners = [
            [0.0, 0.0],
            [1.0, 1.0],
            [3.0, 1.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
        ];
        let inner = inset(&sides(&corners, &[0.0, 0.5, 0.0, 0.0, 0.0, 0.0]), |_| false).unwrap();
        for (corner, place) in [(1, [1.0, 1.5]), (2, [3.0, 1.5]), (0, [0.0, 0.5])] {
            assert!((inner[corner][0] - Vector2::from(place)).norm() < 1e-12);
        }
    }

    #[test]
    fn a_side_without_length_cuts_a_corner() {
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let mut sides = sides(&corners, &[0.0; 4]);
        let inward = -Vector2::new(1.0, 1.0).normalize();
        let along = Vector2::new(inward.y, -inward.x);
        sides.insert(
            2,
            Side {
                from: Vector2::new(2.0, 2.0),
                along,
                inset: 0.0,
            },
        );
        assert_eq!(
            inset(&sides, |_| true).unwrap()[2],
            [Vector2::new(2.0, 2.0); 2]
        );
        sides[2].inset = 0.5_f64.sqrt();
        let [start, end] = inset(&sides, |_| true).unwrap()[2];
        assert!((start - Vector2::new(2.0, 1.0)).norm() < 1e-12);
        assert!((end - Vector2::new(1.0, 2.0)).norm() < 1e-12);
    }
}
