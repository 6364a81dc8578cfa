//! Bounds how long two pieces in contact stay on two sides of a plane.
//!
//! In contact, the distance of the pieces does not say what may happen next: to first order every motion is
//! dangerous. Therefore a plane is taken that separates the pieces now, either of a side or of a piece, fixed
//! to one piece, and the heights of the other piece's corners over it are followed to second order. With δ the
//! turns of the creases between, in their order from the fixed piece, the height changes by the sum of gradient
//! times δ, with an error of no more than ½ Σᵢⱼ |δᵢ δⱼ| times the distance from the farther of creases i and j. Creases of an
//! accordion undo each other's turns, in second order too: corners are then followed along parabolas, with an error of
//! third order. If one crease alone turns, the height is followed exactly, as that of a point on a circle.

use core::cell::OnceCell;
use core::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::crossing::{Allowed, ConvexPiece, Lean};
use crate::util::nan_max::largest;

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

/// Returns a bound on the angle by which turns take a piece over a step, radians, given the change of each. With ω the
/// direction of a turn times its change, it is the length of the sum of the ω, and half the sum of |ω × ω'| over pairs of
/// turns. Creases of a stack, which turn by opposite angles about parallel lines, turn a piece hardly at all.
pub(super) fn turned(turns: &[Turn], changes: &[Change]) -> f64 {
    let Some(first) = turns.first() else {
        return 0.0;
    };
    let mut whole = Vector3::zeros();
    // Parts of the ω along the first line and across it.
    let (mut along, mut across, mut off) = (0.0, 0.0, 0.0);
    for (turn, change) in turns.iter().zip(changes) {
        whole += turn.about * change.by;
        along += (turn.about.dot(&first.about) * change.by).abs();
        across += turn.about.cross(&first.about).norm() * change.by.abs();
        off += change.off;
    }
    let one_by_one: f64 = changes.iter().map(|change| change.by.abs()).sum();
    let together = whole.norm() + across * (along + across / 2.0) / 2.0;
    one_by_one.min(together) + off
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

/// A piece that turns relative to another.
pub(in crate::collision) struct Moved<'a> {
    /// The turns, in order from the other piece.
    turns: &'a [Turn],
    corners: Vec<Moving>,
}

impl<'a> Moved<'a> {
    pub(in crate::collision) fn new(corners: &[Vector3<f64>], turns: &'a [Turn]) -> Self {
        Self {
            turns,
            corners: corners
                .iter()
                .map(|corner| Moving::new(corner, turns))
                .collect(),
        }
    }

    /// Returns a bound on how far any point of the piece comes from where it is while the groups make these changes; no number
    /// if the changes are none.
    pub(in crate::collision) fn farthest(&self, changes: &[Change]) -> f64 {
        let changes = changes_of(self.turns, changes);
        largest(self.corners.iter().map(|corner| {
            let Step { at, error } = corner.step(self.turns, &changes);
            largest(at.map(|to| (to - corner.at).norm())) + error
        }))
    }

    /// Returns a bound on the angle by which the piece turns while the groups make these changes, radians.
    pub(in crate::collision) fn turned(&self, changes: &[Change]) -> f64 {
        turned(self.turns, &changes_of(self.turns, changes))
    }
}

/// Returns the change of each turn, given those of all groups.
pub(super) fn changes_of(turns: &[Turn], changes: &[Change]) -> Vec<Change> {
    let changes = turns.iter().map(|turn| changes[turn.group as usize]);
    changes.collect()
}

/// The planes that separate a piece from another, over which the corners of the other one are followed.
#[derive(Clone, Debug)]
pub(in crate::collision) struct Parted<'a> {
    /// The turns, in order from the fixed piece.
    turns: &'a [Turn],
    corners: Vec<Moving>,
    planes: Vec<Plane>,
}

/// A plane that is fixed to a piece.
#[derive(Clone, Copy, Debug)]
struct Plane {
    normal: Vector3<f64>,
    point: Vector3<f64>,
    /// Angle between the pieces if the plane is that of the one; `None` if it is upright on it, so that what is beyond is
    /// within the piece.
    lean: Option<Lean>,
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
) -> Parted<'a> {
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
) -> Parted<'a> {
    let planes = planes.map(|(normal, point, lean)| Plane {
        normal,
        point,
        lean,
    });
    let parts = |plane: &Plane| {
        let heights = corners.iter().map(|corner| plane.height(corner));
        heights.fold(f64::INFINITY, f64::min) >= -plane.depth(allowed, 0.0)
    };
    let planes: Vec<_> = planes.filter(parts).collect();
    let corners = corners.iter().filter(|_| !planes.is_empty());
    Parted {
        turns,
        corners: corners.map(|corner| Moving::new(corner, turns)).collect(),
        planes,
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

impl Plane {
    fn height(&self, point: &Vector3<f64>) -> f64 {
        self.normal.dot(&(point - self.point))
    }

    /// Returns the depth up to which corners may be beyond the plane while the piece turns by `turn` radians at most.
    fn depth(&self, allowed: Allowed, turn: f64) -> f64 {
        self.lean
            .map_or(allowed.largest(), |lean| allowed.across(lean.turned(turn)))
    }

    /// Returns the smallest height of a corner while one crease alone turns. After a turn by δ, the height is that of the
    /// centre of the circle on which the corner moves, plus m cos δ + g sin δ, with m the height over the crease and g the
    /// gradient.
    fn lowest_on_circle(&self, corner: &Moving, turn: &Turn, Arc { ends }: &Arc) -> f64 {
        let away = corner.at - turn.point;
        let m = self
            .normal
            .dot(&(away - turn.about * turn.about.dot(&away)));
        let g = self.normal.dot(&corner.rates[0]);
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
        self.height(&corner.at) - m + lowest
    }

    /// Returns a bound on the height of a corner over a step, up to second order, given the change of each turn.
    fn lowest(&self, corner: &Moving, changes: &[Change]) -> f64 {
        let (mut along, mut off, mut curved) = (0.0, 0.0, 0.0);
        // From the moving piece inwards: `moved` bounds the motion of the corner due to the creases passed so
        // far, and `before` sums up the turns of the creases not yet passed.
        let sizes = changes.iter().map(|change| change.by.abs() + change.off);
        let (mut moved, mut before) = (0.0, sizes.sum::<f64>());
        for (change, rate) in changes.iter().zip(&corner.rates).rev() {
            let size = change.by.abs() + change.off;
            let (gradient, reach) = (self.normal.dot(rate), rate.norm());
            along += change.by * gradient;
            off += change.off * gradient.abs();
            before -= size;
            curved += size * (before + size / 2.0) * (reach + moved);
            moved += size * reach;
        }
        self.height(&corner.at) + f64::min(along, 0.0) - off - curved
    }

    /// Returns a bound on the height of a corner over a step, up to third order: where turns undo each other, their second
    /// order does so too.
    fn lowest_followed(&self, step: &Step) -> f64 {
        let heights = step.at.map(|at| self.height(&at));
        heights.into_iter().fold(f64::INFINITY, f64::min) - step.error
    }
}

impl Parted<'_> {
    /// Returns `true` if there is a plane over which no corner comes lower than contact allows while the groups make these
    /// changes.
    pub(in crate::collision) fn hold(&self, changes: &[Change], allowed: Allowed) -> bool {
        if self.planes.is_empty() {
            return false;
        }
        let changes = changes_of(self.turns, changes);
        let turned = turned(self.turns, &changes);
        let is_over = |plane: &Plane, lowest: f64| lowest >= -plane.depth(allowed, turned);
        let (mut planes, corners) = (self.planes.iter(), &self.corners);
        if let ([turn], [change]) = (self.turns, &changes[..]) {
            let arc = Arc::of(*change);
            return planes.any(|plane| {
                let lowest = |corner| plane.lowest_on_circle(corner, turn, &arc);
                corners.iter().all(|corner| is_over(plane, lowest(corner)))
            });
        }
        let steps: Vec<OnceCell<Step>> = vec![OnceCell::new(); corners.len()];
        planes.any(|plane| {
            corners.iter().zip(&steps).all(|(corner, step)| {
                let step = || step.get_or_init(|| corner.step(self.turns, &changes));
                is_over(plane, plane.lowest(corner, &changes))
                    || is_over(plane, plane.lowest_followed(step()))
            })
        })
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
            // The crease is the x axis, and a turn lifts the corner along y.
            let turn = Turn {
                group: 0,
                point: Vector3::zeros(),
                about: Vector3::x(),
            };
            let corner = Moving::new(&Vector3::new(0.0, g, m), &[turn]);
            let plane = Plane {
                normal: Vector3::z(),
                point: Vector3::z() * (m - height),
                lean: None,
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
            let lowest = plane.lowest_on_circle(&corner, &turn, &Arc::of(change));
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
            let (plane, corner) = (&parted.planes[0], &parted.corners[0]);
            let bounds = [
                plane.lowest(corner, &changes),
                plane.lowest_followed(&corner.step(&turns, &changes)),
            ];
            sharper[usize::from(is_accordion)] += u32::from(bounds[1] > bounds[0]);
            let moved = Moved::new(&[at], &turns);
            let [farthest, turned] = [moved.farthest(&changes), moved.turned(&changes)];
            let [by, off] = [|it: &Change| it.by.abs(), |it: &Change| it.off]
                .map(|part| changes.iter().map(part).sum::<f64>());
            assert!(turned <= by + off, "{case}: {turned} {by} {off}");
            if is_accordion {
                assert!(turned <= off + 1e-12, "{case}: {turned} {off}");
            }
            // If a change is not a number, neither are the bounds.
            let mut unknown = changes.clone();
            unknown[case % count].off = f64::NAN;
            assert!(moved.farthest(&unknown).is_nan() && moved.turned(&unknown).is_nan());
            let arrow = Vector3::new(noise(), noise(), noise()).normalize();
            for sample in 0..=40 {
                let part = f64::from(sample) / 40.0;
                let angle = |change: &Change| part * change.by + noise() * change.off;
                let angles: Vec<f64> = changes.iter().map(angle).collect();
                let [to, tip] = [at, at + arrow].map(|at| rotated(&turns, &angles, &at));
                let height = normal.dot(&(to - point));
                assert!((to - at).norm() <= farthest + 1e-12, "{case}: {farthest}");
                assert!(
                    (tip - to - arrow).norm() <= turned + 1e-12,
                    "{case}: {turned}"
                );
                let lowest = bounds[0].max(bounds[1]);
                assert!(height >= lowest - 1e-12, "{case}: {height} {bounds:?}");
            }
        }
        assert!(sharper[1] > 950 && sharper[0] > 100, "{sharper:?}");
    }
}
