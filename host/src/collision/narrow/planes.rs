//! Bounds how long two pieces in contact stay on two sides of a plane.
//!
//! In contact, the distance of the pieces does not say what may happen next: to first order every motion is
//! dangerous. Therefore a plane is taken that separates the pieces now, either of a side or of a piece, fixed
//! to one piece, and the heights of the other piece's corners over it are followed to second order. With δ the
//! turns of the creases between, in their order from the fixed piece, the height changes by the sum of gradient
//! times δ, with an error of no more than ½ Σᵢⱼ |δᵢ δⱼ| times the distance from the farther of creases i and j. Creases of an
//! accordion undo each other's turns, in second order too: corners are then followed along parabolas, with an error of
//! third order. If one crease alone turns, the height is followed exactly, as that of a point on a circle.

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

/// Change of a group angle over a step (`by`), and its largest distance from the part of it that all groups of the step have
/// made (`off`), radians. This part grows with time, or as the angle of one group does, from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(in crate::collision) struct Change {
    pub(in crate::collision) by: f64,
    pub(in crate::collision) off: f64,
}

/// Bernstein coefficients of a polynomial of degree 2.
pub(super) type Quadratic = [Vector3<f64>; 3];

/// A corner of a piece that turns.
#[derive(Clone, Debug)]
pub(super) struct Moving {
    pub(super) at: Vector3<f64>,
    /// Change of position per radian of each turn.
    rates: Vec<Vector3<f64>>,
}

/// A corner over a step: where it is, up to an error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) at: Quadratic,
    pub(super) error: f64,
}

impl Moving {
    pub(super) fn new(at: &Vector3<f64>, turns: &[Turn]) -> Self {
        Self {
            at: *at,
            rates: turns.iter().map(|turn| turn.rate(at)).collect(),
        }
    }

    /// Returns the corner with its position relative to a point.
    pub(super) fn seen_from(self, origin: Vector3<f64>) -> Self {
        Self {
            at: self.at - origin,
            ..self
        }
    }

    /// Follows the corner over a step, given the change of each turn. With ω the direction of a turn times its change, the
    /// outer before the inner, the position changes by the sum of the ω × r, by the sum of the ω × (ω' × r) of two turns,
    /// half as much for one and the same, and by no more than a sixth of the product of three turns times the distance
    /// from the crease of the innermost.
    pub(super) fn step(&self, turns: &[Turn], changes: &[Change]) -> Step {
        let (mut by, mut bent) = (Vector3::zeros(), Vector3::zeros());
        let (mut error, mut moved) = (0.0, 0.0);
        let mut before: f64 = changes.iter().map(|change| change.by.abs()).sum();
        for ((turn, change), rate) in turns.iter().zip(changes).zip(&self.rates).rev() {
            let size = change.by.abs();
            // Turns move points rigidly, so that a point moves by at most the sum of the ways of all turns.
            let reach = rate.norm() + moved;
            moved += (size + change.off) * rate.norm();
            let rate = rate * change.by;
            bent += change.by * turn.about.cross(&(by + rate / 2.0));
            by += rate;
            before -= size;
            error += ((before + size).powi(3) - before.powi(3)) / 6.0 * reach;
            error += change.off * reach;
        }
        Step {
            at: [self.at, self.at + by / 2.0, self.at + by + bent],
            error,
        }
    }
}

/// A corner over a plane.
#[derive(Clone, Debug)]
struct Corner {
    moving: Moving,
    height: f64,
    /// For each turn: change of height per radian (`gradients`), and distance from the crease (`reaches`).
    gradients: Vec<f64>,
    reaches: Vec<f64>,
    /// Height of the corner over the line of the first crease.
    over_crease: f64,
}

/// The corners of a piece over a plane that separates it from another.
#[derive(Clone, Debug)]
pub(in crate::collision) struct Parted<'a> {
    /// The turns, in order from the fixed piece.
    turns: &'a [Turn],
    normal: Vector3<f64>,
    /// Angle between the pieces if the plane is that of the one; `None` if it is upright on it, so that what is beyond is
    /// within the piece.
    lean: Option<Lean>,
    corners: Vec<Corner>,
}

/// Returns the planes that have `piece` on one side and `other` on the other, up to contact. Candidates are
/// the plane of `piece`, in both directions, and the planes upright on it through its sides. The turns lead
/// from `piece` to `other`. If `other` came from `above` the piece (or from below), the plane of `piece` counts
/// only with `other` on that side.
pub(in crate::collision) fn parted<'a>(
    piece: &ConvexPiece<'_>,
    other: &ConvexPiece<'_>,
    turns: &'a [Turn],
    above: Option<bool>,
    allowed: Allowed,
) -> Vec<Parted<'a>> {
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
pub(in crate::collision) fn parted_by<'a>(
    planes: impl Iterator<Item = (Vector3<f64>, Vector3<f64>, Option<Lean>)>,
    corners: &[Vector3<f64>],
    turns: &'a [Turn],
    allowed: Allowed,
) -> Vec<Parted<'a>> {
    let parts = |(normal, point, lean): &(Vector3<f64>, Vector3<f64>, Option<Lean>)| {
        let heights = corners.iter().map(|c| normal.dot(&(c - point)));
        heights.fold(f64::INFINITY, f64::min) >= -over_plane(allowed, *lean, 0.0)
    };
    planes
        .filter(parts)
        .map(|(normal, point, lean)| Parted {
            turns,
            normal,
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
    let moving = Moving::new(at, turns);
    Corner {
        height: normal.dot(&(at - point)),
        gradients: moving.rates.iter().map(|rate| normal.dot(rate)).collect(),
        reaches: moving.rates.iter().map(Vector3::norm).collect(),
        moving,
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

impl Parted<'_> {
    /// Returns `true` if no corner comes lower than contact allows while the groups make these changes.
    pub(in crate::collision) fn holds(&self, changes: &[Change], allowed: Allowed) -> bool {
        let changes = self.turns.iter().map(|turn| changes[turn.group as usize]);
        let turn = changes.clone().map(|change| change.by.abs() + change.off);
        let depth = over_plane(allowed, self.lean, turn.sum());
        let mut corners = self.corners.iter();
        if let [_] = self.turns {
            let arcs: Vec<_> = changes.map(Arc::of).collect();
            return corners.all(|corner| corner.lowest_on_circle(&arcs[0]) >= -depth);
        }
        let changes: Vec<_> = changes.collect();
        corners.all(|corner| {
            corner.lowest(&changes) >= -depth || self.lowest_followed(corner, &changes) >= -depth
        })
    }

    /// Returns a bound on the height of a corner over a step, up to third order: where turns undo each other, their second
    /// order does so too.
    fn lowest_followed(&self, corner: &Corner, changes: &[Change]) -> f64 {
        let step = corner.moving.step(self.turns, changes);
        let risen = (step.at).map(|at| self.normal.dot(&(at - corner.moving.at)));
        corner.height + risen.into_iter().fold(f64::INFINITY, f64::min) - step.error
    }
}

impl Corner {
    /// Returns a bound on the height over a step, up to second order, given the change of each turn.
    fn lowest(&self, changes: &[Change]) -> f64 {
        let (mut along, mut off, mut curved) = (0.0, 0.0, 0.0);
        // From the moving piece inwards: `moved` bounds the motion of the corner due to the creases passed so
        // far, and `before` sums up the turns of the creases not yet passed.
        let sizes = changes.iter().map(|change| change.by.abs() + change.off);
        let (mut moved, mut before) = (0.0, sizes.sum::<f64>());
        for (turn, change) in changes.iter().enumerate().rev() {
            let size = change.by.abs() + change.off;
            along += change.by * self.gradients[turn];
            off += change.off * self.gradients[turn].abs();
            let reach = self.reaches[turn] + moved;
            moved += size * self.reaches[turn];
            before -= size;
            curved += size * (before + size / 2.0) * reach;
        }
        self.height + f64::min(along, 0.0) - off - curved
    }
}

/// Returns where the turns by these angles, radians, take a point.
#[cfg(test)]
pub(super) fn rotated(turns: &[Turn], angles: &[f64], point: &Vector3<f64>) -> Vector3<f64> {
    let inwards = turns.iter().zip(angles).rev();
    inwards.fold(*point, |at, (turn, angle)| {
        let about = nalgebra::Unit::new_normalize(turn.about);
        turn.point + nalgebra::Rotation3::from_axis_angle(&about, *angle) * (at - turn.point)
    })
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
                moving: Moving::new(&Vector3::zeros(), &[]),
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

    /// Corners beyond random chains of creases are never lower than the bounds say. Beyond an accordion, whose creases turn by
    /// opposite angles about parallel lines, the bound of third order is the sharper one.
    #[test]
    fn corners_beyond_chains_are_no_lower_than_their_bounds() {
        let mut random = Pcg64::new(56, 2);
        let mut noise = || f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0;
        let mut sharper = [0, 0];
        for case in 0..2000 {
            let is_accordion = case % 2 == 0;
            let count = 2 + 2 * (case % 4);
            let direction = Vector3::new(noise(), noise(), noise()).normalize();
            let turns: Vec<Turn> = (0..count)
                .map(|k| {
                    let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                    Turn {
                        group: u32::try_from(k).unwrap(),
                        point: Vector3::new(noise(), noise(), noise()),
                        about: if is_accordion {
                            sign * direction
                        } else {
                            Vector3::new(noise(), noise(), noise()).normalize()
                        },
                    }
                })
                .collect();
            let size = 10_f64.powf(-1.0 - 3.0 * noise().abs());
            let alike = size * noise();
            let changes: Vec<Change> = (0..count)
                .map(|_| Change {
                    by: if is_accordion { alike } else { size * noise() },
                    off: size.powi(3) * noise().abs(),
                })
                .collect();
            let [normal, point, at] = [(); 3].map(|()| Vector3::new(noise(), noise(), noise()));
            let normal = normal.normalize();
            let plane = [(normal, point, None)];
            let everything = Allowed {
                within: f64::INFINITY,
                ..Allowed::NOTHING
            };
            let parted = parted_by(plane.into_iter(), &[at], &turns, everything);
            let corner = &parted[0].corners[0];
            let bounds = [
                corner.lowest(&changes),
                parted[0].lowest_followed(corner, &changes),
            ];
            sharper[usize::from(is_accordion)] += u32::from(bounds[1] > bounds[0]);
            for sample in 0..=40 {
                let part = f64::from(sample) / 40.0;
                let angle = |change: &Change| part * change.by + noise() * change.off;
                let angles: Vec<f64> = changes.iter().map(angle).collect();
                let height = normal.dot(&(rotated(&turns, &angles, &at) - point));
                let lowest = bounds[0].max(bounds[1]);
                assert!(height >= lowest - 1e-12, "{case}: {height} {bounds:?}");
            }
        }
        assert!(sharper[1] > 950 && sharper[0] > 100, "{sharper:?}");
    }
}
