//! Distance between two convex planar polygons: in space, and as an angle between sectors round a common corner.

use nalgebra::Vector3;

use super::crossing::ConvexPiece;
use crate::collision::tolerances::SIDE_ROUNDING_RATIO;
use crate::folding::FoldingMap;
use crate::pattern::{CreasePattern, FaceId};

/// Returns the distance between two pieces; 0 if they intersect.
///
/// Pieces that do not intersect are nearest to each other at two sides, or at a corner of one and the interior of the
/// other. A side that has all of the other piece behind it needs no test: the part of a piece nearest to a point is a
/// side that has the point ahead of it, or the interior if the point lies over or under it. Sides farther from the
/// other's plane than the distance found so far need no test either. Cost: O(product of corners).
#[must_use]
pub fn distance(a: &ConvexPiece<'_>, b: &ConvexPiece<'_>) -> f64 {
    let (ahead_of_a, over_a) = ahead(a, b);
    let (ahead_of_b, over_b) = ahead(b, a);
    let mut nearest = f64::INFINITY;
    for (over, corners, piece) in [(over_b, a, b), (over_a, b, a)] {
        if over {
            nearest = nearest.min(sides_to_inside(corners, piece));
        }
    }
    let mut squared = nearest * nearest;
    for (k, side) in sides(a).enumerate() {
        if !ahead_of_a.holds(k) || b.square_from_plane(side) >= squared {
            continue;
        }
        for (k, other) in sides(b).enumerate() {
            if ahead_of_b.holds(k) && a.square_from_plane(other) < squared {
                squared = squared.min(segments_squared(side, other));
            }
        }
    }
    squared.sqrt()
}

/// Returns the distance of two faces under a folding map, in units of the sheet; 0 if they intersect.
pub(crate) fn face_distance(pattern: &CreasePattern, map: &FoldingMap, faces: [FaceId; 2]) -> f64 {
    let placed = faces.map(|face| {
        let pose = &map.poses()[face.index()];
        let triangles = pattern.triangles()[face.index()].iter();
        let corners = triangles
            .map(|triangle| triangle.map(|vertex| pose.apply(pattern.vertices()[vertex.index()])));
        (corners.collect::<Vec<_>>(), pose.r_wf.rotate(&Vector3::z()))
    });
    let [a, b] = placed.each_ref().map(|(triangles, normal)| {
        let piece = |corners| ConvexPiece {
            corners,
            normal: *normal,
        };
        triangles.iter().map(move |corners| piece(&corners[..]))
    });
    let pairs = a.flat_map(|a| b.clone().map(move |b| distance(&a, &b)));
    pairs.fold(f64::INFINITY, f64::min)
}

impl ConvexPiece<'_> {
    /// Returns the squared distance of a segment from the plane of the piece.
    fn square_from_plane(&self, ends: [&Vector3<f64>; 2]) -> f64 {
        let [a, b] = ends.map(|end| self.normal.dot(&(end - self.corners[0])));
        if a * b <= 0.0 {
            return 0.0;
        }
        let least = a.abs().min(b.abs());
        least * least
    }
}

/// A set of sides by their positions; sides from the 64th on always belong to it.
#[derive(Clone, Copy)]
struct Sides(u64);

impl Sides {
    fn holds(self, side: usize) -> bool {
        side >= 64 || self.0 >> side & 1 == 1
    }
}

/// Returns the sides of a piece that have a corner of the other one ahead, and `true` if a part of the other
/// one may lie over or under the piece.
fn ahead(piece: &ConvexPiece<'_>, other: &ConvexPiece<'_>) -> (Sides, bool) {
    let (mut found, mut over) = (0, true);
    for (side, [from, to]) in sides(piece).enumerate() {
        let along = to - from;
        let outward = along.cross(&piece.normal);
        let limit = outward.dot(from);
        let [mut least, mut most] = [f64::INFINITY, f64::NEG_INFINITY];
        for corner in other.corners {
            let out = outward.dot(corner);
            least = if out < least { out } else { least };
            most = if out > most { out } else { most };
        }
        let slack = SIDE_ROUNDING_RATIO * (along.norm_squared() + limit.abs());
        if most >= limit - slack && side < 64 {
            found |= 1 << side;
        }
        over &= least <= limit + slack;
    }
    (Sides(found), over)
}

/// Returns the distance of the corners of `a` from the interior of `b` along the normal of `b`: infinite if no
/// corner lies over or under it, 0 if a side of `a` passes through `b`.
fn sides_to_inside(a: &ConvexPiece<'_>, b: &ConvexPiece<'_>) -> f64 {
    let offset = b.normal.dot(&b.corners[0]);
    let mut nearest = f64::INFINITY;
    let last = a.corners.len() - 1;
    let mut from = (&a.corners[last], b.normal.dot(&a.corners[last]) - offset);
    for corner in a.corners {
        let height = b.normal.dot(corner) - offset;
        if height.abs() < nearest && inside(b, corner) {
            nearest = height.abs();
        }
        if (from.1 < 0.0) != (height < 0.0) {
            let through = from.0 + (corner - from.0) * (from.1 / (from.1 - height));
            if inside(b, &through) {
                return 0.0;
            }
        }
        from = (corner, height);
    }
    nearest
}

/// Returns `true` if the point lies over or under the piece.
fn inside(piece: &ConvexPiece<'_>, point: &Vector3<f64>) -> bool {
    sides(piece).all(|[from, to]| (to - from).cross(&(point - from)).dot(&piece.normal) >= 0.0)
}

fn sides<'a>(piece: &ConvexPiece<'a>) -> impl Iterator<Item = [&'a Vector3<f64>; 2]> {
    let corners = piece.corners;
    (0..corners.len()).map(|k| {
        [
            &corners[k],
            &corners[if k + 1 == corners.len() { 0 } else { k + 1 }],
        ]
    })
}

/// Returns the squared distance of two segments.
///
/// Implements `ClosestPtSegmentSegment` of C. Ericson, "Real-time collision detection", 2005, 5.1.9.
fn segments_squared(a: [&Vector3<f64>; 2], b: [&Vector3<f64>; 2]) -> f64 {
    let (along_a, along_b, between) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (aa, bb) = (along_a.norm_squared(), along_b.norm_squared());
    let (ab, a_between) = (along_a.dot(&along_b), along_a.dot(&between));
    let b_between = along_b.dot(&between);
    let area = aa * bb - ab * ab;
    let mut s = if area > 0.0 {
        ((ab * b_between - a_between * bb) / area).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let mut t = (ab * s + b_between) / bb;
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = ((t * ab - a_between) / aa).clamp(0.0, 1.0);
    }
    (between + along_a * s - along_b * t).norm_squared()
}

/// The corner of a convex piece at a vertex, as an arc on the unit sphere round the vertex.
#[derive(Clone, Copy, Debug)]
pub(in crate::collision) struct Sector {
    /// Unit directions of the sides, counter-clockwise, at most half a turn apart.
    pub(in crate::collision) sides: [Vector3<f64>; 2],
    /// Unit normal of the piece.
    pub(in crate::collision) normal: Vector3<f64>,
}

impl Sector {
    /// Returns the sector of a piece at the corner with this position.
    pub(in crate::collision) fn of(piece: &ConvexPiece<'_>, corner: usize) -> Self {
        let (count, apex) = (piece.corners.len(), piece.corners[corner]);
        let [next, previous] = [corner + 1, corner + count - 1].map(|k| piece.corners[k % count]);
        Self {
            sides: [next, previous].map(|end| (end - apex).normalize()),
            normal: piece.normal,
        }
    }

    /// Returns `true` if the direction lies over or under the sector.
    fn holds(&self, direction: &Vector3<f64>) -> bool {
        let [right, left] = &self.sides;
        right.cross(direction).dot(&self.normal) >= 0.0
            && direction.cross(left).dot(&self.normal) >= 0.0
    }

    /// Returns a lower bound of the angle between a unit direction and the sector, radians: the sine of the
    /// angle, or its chord.
    fn below_angle(&self, direction: &Vector3<f64>) -> f64 {
        if self.holds(direction) {
            return self.normal.dot(direction).abs();
        }
        let [right, left] = self.sides.map(|side| (side - direction).norm());
        right.min(left)
    }

    /// Returns a lower bound of the angle between two sectors of the same apex, radians; 0 if they intersect
    /// outside the apex.
    pub(in crate::collision) fn separation(&self, other: &Self) -> f64 {
        let common = self.normal.cross(&other.normal);
        if [common, -common]
            .iter()
            .any(|line| self.holds(line) && other.holds(line))
            && common.norm() > 0.0
        {
            return 0.0;
        }
        let [a, b] = [
            self.sides.map(|side| other.below_angle(&side)),
            other.sides.map(|side| self.below_angle(&side)),
        ];
        a[0].min(a[1]).min(b[0].min(b[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use foldpath_core::{HalfAngle, Rotation};
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::Rng;

    /// Returns a random number between -1 and 1.
    fn noise(random: &mut Pcg64) -> f64 {
        #[allow(clippy::cast_precision_loss, reason = "a random number")]
        let part = (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        2.0 * part - 1.0
    }

    /// Returns a convex polygon inscribed in the unit circle, rotated and moved.
    fn polygon(random: &mut Pcg64, r_wf: Rotation<f64>, p_w: Vector3<f64>) -> Vec<Vector3<f64>> {
        let mut angles: Vec<_> = (0..3 + random.next_u64() % 4)
            .map(|_| core::f64::consts::PI * noise(random))
            .collect();
        angles.sort_by(f64::total_cmp);
        let corner = |angle: &f64| Vector3::new(angle.cos(), angle.sin(), 0.0);
        angles
            .iter()
            .map(|a| r_wf.rotate(&corner(a)) + p_w)
            .collect()
    }

    fn random_rotation(random: &mut Pcg64) -> Rotation<f64> {
        let [a, b, c] = [(); 3].map(|()| HalfAngle::of(3.0 * noise(random)));
        let turn = |half, direction| Rotation::about_crease(half, direction);
        turn(a, [1.0, 0.0]) * turn(b, [0.0, 1.0]) * turn(c, [1.0, 0.0])
    }

    /// Returns the point of a polygon nearest to `point`: its foot in the plane if this is inside, or else a
    /// point of a side.
    fn project(piece: &ConvexPiece<'_>, point: &Vector3<f64>) -> Vector3<f64> {
        let down = point - piece.normal * piece.normal.dot(&(point - piece.corners[0]));
        if inside(piece, &down) {
            return down;
        }
        let on_sides = sides(piece).map(|[from, to]| {
            let along = to - from;
            let s = along.dot(&(point - from)) / along.norm_squared();
            from + along * s.clamp(0.0, 1.0)
        });
        let nearer =
            |a: &Vector3<f64>, b: &Vector3<f64>| (a - point).norm().total_cmp(&(b - point).norm());
        on_sides.min_by(nearer).unwrap()
    }

    /// Alternating projections onto the two pieces never give points nearer than the distance, and in the end
    /// give points about as near.
    #[test]
    fn no_two_points_are_nearer_than_the_distance() {
        let mut random = Pcg64::new(11, 2);
        let (mut apart, mut met) = (0, 0);
        for round in 0..3000 {
            let first = random_rotation(&mut random);
            let shift = Vector3::from_fn(|_, _| 1.6 * noise(&mut random));
            // Some pairs lie over each other corner by corner, some are parallel, some lie in one plane.
            let (r_wf, shift) = match round % 4 {
                0 => (first, first.rotate(&Vector3::new(0.0, 0.0, shift.x))),
                1 => (first, shift),
                2 => (
                    first,
                    first.rotate(&Vector3::new(2.0 * shift.x, 2.0 * shift.y, 0.0)),
                ),
                _ => (random_rotation(&mut random), shift),
            };
            let a = polygon(&mut random, first, Vector3::zeros());
            let b = match round % 4 {
                0 => a.iter().map(|corner| corner + shift).collect(),
                _ => polygon(&mut random, r_wf, shift),
            };
            let [a, b] = [(&a, first), (&b, r_wf)].map(|(corners, turn)| ConvexPiece {
                corners,
                normal: turn.rotate(&Vector3::z()),
            });
            let found = distance(&a, &b);
            let mut point = a.corners[0];
            let mut nearest = f64::INFINITY;
            for _ in 0..2000 {
                let other = project(&b, &point);
                point = project(&a, &other);
                nearest = nearest.min((other - point).norm());
            }
            assert!(found <= nearest + 1e-12, "{round}: {found} {nearest}");
            assert!(nearest <= found + 2e-2, "{round}: {found} {nearest}");
            if found > 0.0 { apart += 1 } else { met += 1 }
        }
        assert!(apart > 1000 && met > 50, "{apart} {met}");
    }
}
