//! Measures how deep two convex planar polygons pass through each other.
//!
//! Implements the interval overlap test of T. Möller, "A fast triangle-triangle intersection test", J. Graphics
//! Tools 2(2), 1997, for convex polygons. Differs from the source in that it returns a depth, so that contact
//! (layers, shared vertices) can be distinguished from crossing.

use nalgebra::Vector3;

use crate::collision::tolerances::{CLOSE_TO_PLANE_RATIO, MIN_LEAN};

/// A convex planar polygon in space.
#[derive(Clone, Copy, Debug)]
pub struct ConvexPiece<'a> {
    /// Corners in order.
    pub corners: &'a [Vector3<f64>],
    /// Unit normal of the plane.
    pub normal: Vector3<f64>,
}

impl ConvexPiece<'_> {
    /// Returns the positions of the corners relative to the plane of `other`.
    pub(in crate::collision) fn reach(&self, other: &Self, tolerance: f64) -> Reach {
        let offset = other.normal.dot(&other.corners[0]);
        let mut reach = Reach {
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            touching: 0,
            close: 0,
        };
        for corner in self.corners {
            let distance = other.normal.dot(corner) - offset;
            reach.low = reach.low.min(distance);
            reach.high = reach.high.max(distance);
            reach.touching += u32::from(distance.abs() <= tolerance);
            reach.close += u32::from(distance.abs() <= CLOSE_TO_PLANE_RATIO * tolerance);
        }
        reach
    }

    /// Returns the part of `piece` that lies over or under this one, seen along the normal of this one.
    /// Implements the clipping of I. Sutherland, G. Hodgman, "Reentrant polygon clipping", 1974.
    pub(in crate::collision) fn part_over(&self, piece: &Self) -> Vec<Vector3<f64>> {
        let mut part = piece.corners.to_vec();
        let next = self.corners.iter().cycle().skip(1);
        for (from, to) in self.corners.iter().zip(next) {
            let inward = self.normal.cross(&(to - from));
            let inside = |point: &Vector3<f64>| inward.dot(&(point - from));
            let mut kept = Vec::with_capacity(part.len() + 1);
            for (p, q) in part.iter().zip(part.iter().cycle().skip(1)) {
                let [here, next] = [inside(p), inside(q)];
                if here >= 0.0 {
                    kept.push(*p);
                }
                if here * next < 0.0 {
                    kept.push(p + (q - p) * (here / (here - next)));
                }
            }
            part = kept;
        }
        part
    }

    /// Returns the interval of the line along `direction` in which this piece meets the plane of `other`.
    fn section(&self, other: &Self, direction: &Vector3<f64>) -> [f64; 2] {
        let offset = other.normal.dot(&other.corners[0]);
        let mut section = [f64::INFINITY, f64::NEG_INFINITY];
        let last = self.corners.len() - 1;
        let mut from = &self.corners[last];
        let mut from_distance = other.normal.dot(from) - offset;
        for to in self.corners {
            let to_distance = other.normal.dot(to) - offset;
            if (from_distance < 0.0) != (to_distance < 0.0) {
                let s = from_distance / (from_distance - to_distance);
                let along = direction.dot(from) * (1.0 - s) + direction.dot(to) * s;
                section = [section[0].min(along), section[1].max(along)];
            }
            (from, from_distance) = (to, to_distance);
        }
        section
    }
}

/// Depth up to which an overlap of two pieces is contact, units of the sheet.
#[derive(Clone, Copy, Debug)]
pub(in crate::collision) struct Allowed {
    /// Depth within the planes of the pieces: they are free if they are so once both are smaller by this all round.
    pub(in crate::collision) within: f64,
    /// Distance across each other by which pieces may be elsewhere because the sheet does not quite close. Together with
    /// the depth within, it counts up to that depth.
    pub(in crate::collision) loose: f64,
    /// Distance, in any direction, by which pieces may be elsewhere than they are placed.
    pub(in crate::collision) shift: f64,
}

impl Allowed {
    /// No overlap is contact.
    pub(in crate::collision) const NOTHING: Self = Self {
        within: 0.0,
        loose: 0.0,
        shift: 0.0,
    };

    /// Returns what pieces may be in that keep a distance.
    pub(in crate::collision) fn apart(distance: f64) -> Self {
        Self {
            shift: -distance,
            ..Self::NOTHING
        }
    }

    /// Returns the extent up to which a piece may reach through the plane of another while the two planes enclose these
    /// angles.
    pub(in crate::collision) fn across(self, lean: Lean) -> f64 {
        self.part_across(lean.least())
    }

    /// Returns by how much points of two pieces that do not overlap may pass each other until the segment that both share
    /// may be longer than contact allows: its two ends move by no more than that over the sine.
    pub(in crate::collision) fn until_shared(self, lean: Lean) -> f64 {
        self.part_across(lean.least() / 2.0)
    }

    /// Returns the extent up to which two pieces together may reach through a plane between them, given the sum of the
    /// sines of the angles that the plane encloses with theirs.
    pub(in crate::collision) fn across_both(self, lean: f64) -> f64 {
        self.part_across(lean.min(1.0))
    }

    /// Returns the least of these extents at any angle.
    fn least_across(self) -> f64 {
        self.part_across(MIN_LEAN)
    }

    fn part_across(self, part: f64) -> f64 {
        (self.within * part + self.loose).min(self.within) + self.shift
    }

    /// Returns the largest of these extents, which is also the longest segment that pieces may share.
    pub(in crate::collision) fn largest(self) -> f64 {
        self.within + self.shift
    }
}

/// Angles that the planes of two pieces enclose in some time, by their sines.
#[derive(Clone, Copy, Debug)]
pub(in crate::collision) struct Lean {
    from: f64,
    to: f64,
}

impl Lean {
    /// Returns the angles that two pieces take on while they turn by `turn` radians at most.
    pub(in crate::collision) fn of(a: &ConvexPiece<'_>, b: &ConvexPiece<'_>, turn: f64) -> Self {
        Self::at(a.normal.cross(&b.normal).norm()).turned(turn)
    }

    fn at(sine: f64) -> Self {
        Self {
            from: sine,
            to: sine,
        }
    }

    /// Returns these angles and those up to `turn` radians from them.
    pub(in crate::collision) fn turned(self, turn: f64) -> Self {
        Self {
            from: self.from - turn,
            to: self.to + turn,
        }
    }

    /// Returns the least ratio of an extent across a plane to the depth within the piece. Layers, which are parallel but
    /// for rounding, have none: their depth is what they are across each other.
    fn least(self) -> f64 {
        if self.to < MIN_LEAN {
            1.0
        } else {
            self.from.clamp(MIN_LEAN, 1.0)
        }
    }
}

/// Overlap of two pieces that reach through each other's planes.
#[derive(Clone, Copy, Debug)]
pub(in crate::collision) struct Overlap {
    /// Least extent of a piece on one side of the other's plane.
    across: f64,
    /// Length of the segment that both share, not positive if they share none.
    along: f64,
    /// Sine of the angle between the planes.
    lean: f64,
}

impl Overlap {
    /// Returns the overlap of two pieces, given their positions relative to each other's plane; `None` if one of them
    /// reaches through the other's plane by no more than is contact at any angle, or their planes are parallel.
    pub(in crate::collision) fn of(
        a: &ConvexPiece<'_>,
        b: &ConvexPiece<'_>,
        reaches: [Reach; 2],
        allowed: Allowed,
    ) -> Option<Self> {
        let across = reaches[0].depth().min(reaches[1].depth());
        if across <= allowed.least_across() {
            return None;
        }
        let direction = a.normal.cross(&b.normal);
        let lean = direction.norm();
        if lean <= 0.0 {
            return None;
        }
        let direction = direction / lean;
        let ([a_from, a_to], [b_from, b_to]) = (a.section(b, &direction), b.section(a, &direction));
        let along = a_to.min(b_to) - a_from.max(b_from);
        Some(Self {
            across,
            along,
            lean,
        })
    }

    /// Returns the depth of the crossing: the lesser of the two lengths; 0 if the overlap is contact.
    pub(in crate::collision) fn depth(self, allowed: Allowed) -> f64 {
        let across = allowed.across(Lean::at(self.lean));
        let crosses = self.across > across && self.along > allowed.largest();
        if crosses {
            self.across.min(self.along)
        } else {
            0.0
        }
    }

    /// Returns by how much points may approach each other at least until the overlap is no longer contact, while the
    /// planes enclose these angles.
    pub(in crate::collision) fn left(self, allowed: Allowed, lean: Lean) -> f64 {
        // The two ends of the segment move by no more than what points approach, over the sine.
        let along = lean.least() * (allowed.largest() - self.along) / 2.0;
        (allowed.across(lean) - self.across).max(along)
    }
}

/// Positions of the corners of a piece relative to the plane of another.
#[derive(Clone, Copy, Debug)]
pub(in crate::collision) struct Reach {
    /// Lowest (`low`) and highest (`high`) signed distance.
    low: f64,
    high: f64,
    /// Number of corners in the plane, within the tolerance.
    touching: u32,
    /// Number of corners within `CLOSE_TO_PLANE_RATIO` tolerances of the plane.
    close: u32,
}

impl Reach {
    /// Returns the smaller of the piece's extents on the two sides of the plane, not positive if it is on one side.
    fn depth(self) -> f64 {
        self.high.min(-self.low)
    }

    /// Returns `true` if the piece is on one side of the plane and meets it in a corner at most. It then
    /// crosses nothing in the plane, and the other piece can stand on it in that corner only.
    pub(in crate::collision) fn is_clear(self, allowed: Allowed) -> bool {
        self.close <= 1 && self.depth() <= allowed.least_across()
    }

    /// Returns `true` if the piece is on one side of the plane and touches it in more than a corner. The sheet
    /// may then continue to the other side of the plane across one of the piece's sides.
    pub(in crate::collision) fn stands(self, tolerance: f64) -> bool {
        let Self {
            low,
            high,
            touching,
            ..
        } = self;
        touching > 1 && high - low > tolerance && low.abs().min(high.abs()) <= tolerance
    }
}

/// Returns the depth to which two pieces pass through each other; 0 if they would not if both were smaller by `tolerance`
/// all round.
///
/// The depth is the least of three lengths: each piece's smaller extent on the two sides of the other's plane,
/// and the length of the segment that both share.
#[must_use]
pub fn crossing_depth(a: &ConvexPiece<'_>, b: &ConvexPiece<'_>, tolerance: f64) -> f64 {
    let allowed = Allowed {
        within: tolerance,
        ..Allowed::NOTHING
    };
    let reaches = [a.reach(b, tolerance), b.reach(a, tolerance)];
    let overlap = Overlap::of(a, b, reaches, allowed);
    overlap.map_or(0.0, |overlap| overlap.depth(allowed))
}

/// Returns the depth to which two pieces joined along a `side` pass through `other` exactly at that side; 0 if
/// it does not exceed `tolerance`.
///
/// In this case neither piece crosses `other` on its own, but the side lies in `other`, and the pieces lie on
/// its two sides.
#[must_use]
pub fn side_crossing_depth(
    pieces: [&ConvexPiece<'_>; 2],
    side: [Vector3<f64>; 2],
    other: &ConvexPiece<'_>,
    tolerance: f64,
) -> f64 {
    let offset = other.normal.dot(&other.corners[0]);
    let off = |point: &Vector3<f64>| (other.normal.dot(point) - offset).abs();
    if side.iter().any(|end| off(end) > tolerance) {
        return 0.0;
    }
    let [a, b] = pieces.map(|piece| piece.reach(other, tolerance));
    let depth = a.high.min(-b.low).max(b.high.min(-a.low));
    if depth <= tolerance {
        return 0.0;
    }
    // In the plane of `other`: its extents on both sides of the line of `side`, and the interval in which it
    // meets that line.
    let along = (side[1] - side[0]).normalize();
    let across = other.normal.cross(&along);
    let mut reach = [0.0_f64; 2];
    let mut section = [f64::INFINITY, f64::NEG_INFINITY];
    let last = other.corners.len() - 1;
    let mut from = other.corners[last] - side[0];
    for corner in other.corners {
        let to = corner - side[0];
        let (from_off, to_off) = (across.dot(&from), across.dot(&to));
        reach = [reach[0].max(-to_off), reach[1].max(to_off)];
        if (from_off < 0.0) != (to_off < 0.0) {
            let s = from_off / (from_off - to_off);
            let place = along.dot(&from) * (1.0 - s) + along.dot(&to) * s;
            section = [section[0].min(place), section[1].max(place)];
        }
        from = to;
    }
    let length = along.dot(&(side[1] - side[0]));
    let shared = section[1].min(length) - section[0].max(0.0);
    let depth = depth.min(reach[0]).min(reach[1]).min(shared);
    if depth <= tolerance {
        return 0.0;
    }
    // Parts of the pieces beyond the border of `other` pass round it, not through it.
    let [a, b] = pieces.map(|piece| {
        let over = other.part_over(piece);
        let heights = over.iter().map(|corner| other.normal.dot(corner) - offset);
        heights.fold([0.0_f64; 2], |[low, high], h| [low.min(h), high.max(h)])
    });
    let depth = depth.min(a[1].min(-b[0]).max(b[1].min(-a[0])));
    if depth > tolerance { depth } else { 0.0 }
}
