//! Tells whether two convex panels meet at one time.

use core::cmp::Ordering;

use super::Point;
use super::chain::Placed;
use super::polynomial::Number;

/// A point in homogeneous coordinates, with a weight above 0.
type Homogeneous<T, const N: usize> = [T; N];

/// Returns `true` if two convex panels meet. The second has the given pose, seen from the first. Panels in one plane lie
/// beside or on each other, and do not meet.
pub(super) fn meet<T: Number>(first: &[Point], second: &[Point], pose: &Placed<T>) -> bool {
    let placed: Vec<_> = second.iter().map(|point| placed(point, pose)).collect();
    let chord = chord(&placed);
    match chord.as_slice() {
        [] => false,
        [point] => meets_segment(first, [point, point]),
        [start, .., end] => meets_segment(first, [start, end]),
    }
}

/// Places a point as x, y, weight and height.
fn placed<T: Number>(point: &Point, pose: &Placed<T>) -> Homogeneous<T, 4> {
    let [x, y, weight] = point.map(T::of);
    let along = |k: usize| {
        dot(
            &[&x, &y, &weight],
            &[&pose.x[k], &pose.y[k], &pose.shift[k]],
        )
    };
    [along(0), along(1), weight.times(&pose.weight), along(2)]
}

fn dot<T: Number>(a: &[&T; 3], b: &[&T; 3]) -> T {
    let [x, y, z] = [0, 1, 2].map(|k: usize| a[k].times(b[k]));
    x.plus(&y).plus(&z)
}

/// Returns where a convex polygon meets the plane of height 0: nowhere, in a point, or in two ends of a segment. Returns
/// nothing for a polygon in that plane.
fn chord<T: Number>(corners: &[Homogeneous<T, 4>]) -> Vec<Homogeneous<T, 3>> {
    let height = |corner: &Homogeneous<T, 4>| corner[3].side();
    if corners.iter().all(|corner| height(corner).is_eq()) {
        return Vec::new();
    }
    let mut chord = Vec::new();
    for (k, a) in corners.iter().enumerate() {
        let b = &corners[(k + 1) % corners.len()];
        match (height(a), height(b)) {
            (Ordering::Equal, _) => chord.push([a[0].clone(), a[1].clone(), a[2].clone()]),
            (Ordering::Greater, Ordering::Less) => chord.push(between(a, b)),
            (Ordering::Less, Ordering::Greater) => chord.push(between(b, a)),
            _ => {}
        }
    }
    chord
}

/// Returns the point of height 0 between a point above and a point below.
fn between<T: Number>(above: &Homogeneous<T, 4>, below: &Homogeneous<T, 4>) -> Homogeneous<T, 3> {
    core::array::from_fn(|k| difference(&below[k], &above[3], &above[k], &below[3]))
}

/// Returns ab - cd.
fn difference<T: Number>(a: &T, b: &T, c: &T, d: &T) -> T {
    a.times(b).minus(&c.times(d))
}

/// Returns `true` if a segment in the plane of a convex polygon, whose corners are counter-clockwise, meets it.
///
/// Clips the segment by each side of the polygon (Cyrus and Beck 1978); `from` and `to` are fractions of its way.
fn meets_segment<T: Number>(polygon: &[Point], [start, end]: [&Homogeneous<T, 3>; 2]) -> bool {
    let mut from = [T::of(0), T::of(1)];
    let mut to = [T::of(1), T::of(1)];
    for (k, a) in polygon.iter().enumerate() {
        let [a, b] = [*a, polygon[(k + 1) % polygon.len()]].map(|point| point.map(T::of));
        let side: Homogeneous<T, 3> = core::array::from_fn(|k| {
            let [i, j] = [(k + 1) % 3, (k + 2) % 3];
            difference(&a[i], &b[j], &a[j], &b[i])
        });
        let [g, h] = [start, end].map(|point| dot(&side.each_ref(), &point.each_ref()));
        match (g.side().is_lt(), h.side().is_lt()) {
            (false, false) => {}
            (true, true) => return false,
            (false, true) => to = least(to, [g.clone(), g.minus(&h)]),
            (true, false) => from = most(from, [T::of(0).minus(&g), h.minus(&g)]),
        }
    }
    !is_above(&from, &to)
}

/// A number over a number above 0.
type Fraction<T> = [T; 2];

fn is_above<T: Number>(a: &Fraction<T>, b: &Fraction<T>) -> bool {
    difference(&a[0], &b[1], &b[0], &a[1]).side().is_gt()
}

fn least<T: Number>(a: Fraction<T>, b: Fraction<T>) -> Fraction<T> {
    if is_above(&a, &b) { b } else { a }
}

fn most<T: Number>(a: Fraction<T>, b: Fraction<T>) -> Fraction<T> {
    if is_above(&a, &b) { a } else { b }
}
