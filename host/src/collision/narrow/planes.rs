//! Bounds how long two pieces in contact stay on two sides of a plane.
//!
//! In contact, the distance of the pieces does not say what may happen next: to first order every motion is
//! dangerous. Therefore a plane is taken that separates the pieces now, either of a side or of a piece, fixed
//! to one piece, and the heights of the other piece's corners over it are followed to second order. With δ the
//! turns of the creases between, in their order from the fixed piece, the height changes by the sum of gradient
//! times δ, with an error of no more than ½ Σᵢⱼ |δᵢ δⱼ| times the distance from the farther of creases i and j. If one
//! crease alone turns, the height is followed exactly, as that of a point on a circle.

use core::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::crossing::{Allowed, ConvexPiece, Lean};

/// A crease between the pieces, seen from the fixed one: its line, and the direction in which a positive group
/// angle turns the part beyond.
#[derive(Clone, Copy, Debug)]
pub(in crate::collision) struct Turn {
    pub(in crate::collision) group: u32,
    pub(in crate::collision) point: Vector3<f64>,
    /// Unit direction of the axis of a positive turn.
    pub(in crate::collision) about: Vector3<f64>,
}

impl Turn {
    /// Returns the change of the position of a point beyond the crease, per radian.
    pub(super) fn rate(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.about.cross(&(point - self.point))
    }
}

/// Change of a group angle over a step (`by`), and its largest distance from a straight line in time (`off`), radians.
#[derive(Clone, Copy, Debug)]
pub(in crate::collision) struct Change {
    pub(in crate::collision) by: f64,
    pub(in crate::collision) off: f64,
}

/// A corner over a plane.
#[derive(Clone, Debug)]
struct Corner {
    height: f64,
    /// For each turn: change of height per radian (`gradients`), and distance from the crease (`reaches`).
    gradients: Vec<f64>,
    reaches: Vec<f64>,
    /// Height of the corner over the line of the first crease.
    over_crease: f64,
}

/// The corners of a piece over a plane that separates it from another.
#[derive(Clone, Debug)]
pub(in crate::collision) struct Parted {
    turns: Vec<u32>,
    /// Angle between the pieces if the plane is that of the one; `None` if it is upright on it, so that what is beyond is
    /// within the piece.
    lean: Option<Lean>,
    corners: Vec<Corner>,
}

/// Returns the planes that have `piece` on one side and `other` on the other, up to contact. Candidates are
/// the plane of `piece`, in both directions, and the planes upright on it through its sides. The turns lead
/// from `piece` to `other`. If `other` came from `above` the piece (or from below), the plane of `piece` counts
/// only with `other` on that side.
pub(in crate::collision) fn parted(
    piece: &ConvexPiece<'_>,
    other: &ConvexPiece<'_>,
    turns: &[Turn],
    above: Option<bool>,
    allowed: Allowed,
) -> Vec<Parted> {
    let corners = piece.corners;
    let next = corners.iter().cycle().skip(1);
    let outward = corners.iter().zip(next).map(|(from, to)| {
        let across = (to - from).cross(&piece.normal);
        (across.normalize(), *from)
    });
    let flat = [(piece.normal, true), (-piece.normal, false)];
    let flat = flat
        .into_iter()
        .filter(|&(_, side)| above.is_none_or(|above| above == side));
    let lean = Lean::of(piece, other, 0.0);
    let flat = flat.map(|(normal, _)| (normal, corners[0], Some(lean)));
    let planes = flat.chain(outward.map(|(normal, point)| (normal, point, None)));
    parted_by(planes, other.corners, turns, allowed)
}

/// Returns the planes, each given by its normal and a point, that have some corners ahead of them, up to contact. The planes
/// are fixed to a piece, and the turns lead from it to that with the corners.
pub(in crate::collision) fn parted_by(
    planes: impl Iterator<Item = (Vector3<f64>, Vector3<f64>, Option<Lean>)>,
    corners: &[Vector3<f64>],
    turns: &[Turn],
    allowed: Allowed,
) -> Vec<Parted> {
    let parts = |(normal, point, lean): &(Vector3<f64>, Vector3<f64>, Option<Lean>)| {
        let heights = corners.iter().map(|c| normal.dot(&(c - point)));
        heights.fold(f64::INFINITY, f64::min) >= -over_plane(allowed, *lean, 0.0)
    };
    planes
        .filter(parts)
        .map(|(normal, point, lean)| Parted {
            turns: turns.iter().map(|turn| turn.group).collect(),
            lean,
            corners: corners
                .iter()
                .map(|corner| over(normal, point, corner, turns))
                .collect(),
        })
        .collect()
}

/// Returns the depth up to which corners may be beyond a plane while the piece turns by `turn` radians at most.
fn over_plane(allowed: Allowed, lean: Option<Lean>, turn: f64) -> f64 {
    lean.map_or(allowed.largest(), |lean| allowed.across(lean.turned(turn)))
}

fn over(normal: Vector3<f64>, point: Vector3<f64>, at: &Vector3<f64>, turns: &[Turn]) -> Corner {
    let rates: Vec<_> = turns.iter().map(|turn| turn.rate(at)).collect();
    Corner {
        height: normal.dot(&(at - point)),
        gradients: rates.iter().map(|rate| normal.dot(rate)).collect(),
        reaches: rates.iter().map(Vector3::norm).collect(),
        over_crease: turns.first().map_or(0.0, |turn| {
            let away = at - turn.point;
            normal.dot(&(away - turn.about * turn.about.dot(&away)))
        }),
    }
}

/// The turns by which one crease may have turned over a step.
struct Arc {
    /// Least and greatest turn, radians, with sine and cosine.
    ends: [(f64, [f64; 2]); 2],
}

impl Arc {
    fn of(Change { by, off }: Change) -> Self {
        let ends = [by.min(0.0) - off, by.max(0.0) + off];
        Self {
            ends: ends.map(|turn| (turn, turn.sin_cos().into())),
        }
    }
}

impl Corner {
    /// Returns the smallest height while one crease alone turns. After a turn by δ, the height is that of the centre of the
    /// circle on which the corner moves, plus m cos δ + g sin δ, with m the height over the crease and g the gradient.
    fn lowest_on_circle(&self, Arc { ends }: &Arc) -> f64 {
        let (m, g) = (self.over_crease, self.gradients[0]);
        let over_centre = ends.map(|(_, [sin, cos])| m * cos + g * sin);
        let rising = ends.map(|(_, [sin, cos])| g * cos - m * sin >= 0.0);
        let [least, most] = ends.map(|(turn, _)| turn);
        // Over half a circle, heights have a lowest point inside if they fall at first and rise at last.
        let passes_lowest = if most - least <= PI {
            !rising[0] && rising[1]
        } else {
            let lowest_at = f64::atan2(-g, -m);
            lowest_at + ((least - lowest_at) / TAU).ceil() * TAU <= most
        };
        let lowest = if passes_lowest {
            -m.hypot(g)
        } else {
            over_centre[0].min(over_centre[1])
        };
        self.height - m + lowest
    }
}

impl Parted {
    /// Returns `true` if no corner comes lower than contact allows while the groups make these changes.
    pub(in crate::collision) fn holds(&self, changes: &[Change], allowed: Allowed) -> bool {
        let turns = self.turns.iter().map(|&turn| changes[turn as usize]);
        let turn = turns.map(|change| change.by.abs() + change.off).sum();
        let depth = over_plane(allowed, self.lean, turn);
        let mut corners = self.corners.iter();
        if let [turn] = self.turns[..] {
            let arc = Arc::of(changes[turn as usize]);
            return corners.all(|corner| corner.lowest_on_circle(&arc) >= -depth);
        }
        corners.all(|corner| self.lowest(corner, changes) >= -depth)
    }

    fn lowest(&self, corner: &Corner, changes: &[Change]) -> f64 {
        let change = |turn: usize| changes[self.turns[turn] as usize];
        let (mut along, mut off, mut curved) = (0.0, 0.0, 0.0);
        // From the moving piece inwards: `moved` bounds the motion of the corner due to the creases passed so
        // far, and `before` sums up the turns of the creases not yet passed.
        let sizes = (0..self.turns.len()).map(|turn| change(turn).by.abs() + change(turn).off);
        let (mut moved, mut before) = (0.0, sizes.clone().sum::<f64>());
        for (turn, size) in sizes.enumerate().collect::<Vec<_>>().into_iter().rev() {
            along += change(turn).by * corner.gradients[turn];
            off += change(turn).off * corner.gradients[turn].abs();
            let reach = corner.reaches[turn] + moved;
            moved += size * corner.reaches[turn];
            before -= size;
            curved += size * (before + size / 2.0) * reach;
        }
        corner.height + f64::min(along, 0.0) - off - curved
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::FRAC_PI_2;
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::Rng;

    #[test]
    fn the_lowest_place_of_a_circle_is_that_of_its_samples() {
        let mut random = Pcg64::new(56, 1);
        let mut noise = || f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0;
        let mut inside = 0;
        for case in 0..2000 {
            let (m, g, height) = (noise(), noise(), noise());
            // Turns up to a full one, quarters among them.
            let by = match case % 4 {
                0 => FRAC_PI_2 * f64::from(case % 7 - 3),
                _ => TAU * noise(),
            };
            let change = Change {
                by,
                off: if case % 3 == 0 {
                    0.0
                } else {
                    0.1 * noise().abs()
                },
            };
            let corner = Corner {
                height,
                gradients: vec![g],
                reaches: vec![m.hypot(g)],
                over_crease: m,
            };
            let [least, most] = [by.min(0.0) - change.off, by.max(0.0) + change.off];
            let mut heights = (0..=4000).map(|k| {
                let turn = least + (most - least) * f64::from(k) / 4000.0;
                height + m * (turn.cos() - 1.0) + g * turn.sin()
            });
            let sampled = heights.clone().fold(f64::INFINITY, f64::min);
            let ends = [heights.next(), heights.next_back()].map(Option::unwrap);
            let ends = ends[0].min(ends[1]);
            inside += u32::from(sampled < ends);
            let lowest = corner.lowest_on_circle(&Arc::of(change));
            assert!(lowest <= sampled + 1e-12, "{case}: {lowest} {sampled}");
            assert!(lowest >= sampled - 1e-5, "{case}: {lowest} {sampled}");
        }
        assert!((500..1800).contains(&inside), "{inside}");
    }
}
