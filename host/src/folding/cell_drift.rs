//! How far the cells of a folded tessellation can move against each other.

use nalgebra::Vector3;

use super::screw::Screw;

/// A bound on the motion of any face of a cell against any face of another one, while group angles change
/// by no more than given. Holds for all closed configurations that near, whatever way leads there.
///
/// Why. Each step in space, S, is a product of turns about the hinges k = 1 … n on the way to the next
/// cell. Let their angles change by at most δₖ, in proportion to time from 0 to 1. A point beyond the last
/// hinge moves with Σ δₖ aₖ × (x - pₖ), with aₖ, pₖ where the hinge is by then. That changes by no more
/// than Σⱼ Σₖ δⱼ δₖ L(max(j, k)) until time 1, where Lₖ is the way from hinge k to the point from pivot to
/// pivot, which no folding makes longer. So the point moves by at most the sum over the groups of change
/// times |Σ aₖ × (x - pₖ)| at the configuration at hand, and half that. In the sum over a group, mountains
/// and valleys cancel: in a Miura fold no step turns at all. The same without levers bounds the turn.
///
/// With S before and A after, Aⁿ x - Sⁿ x is the sum over m of Aⁿ⁻ᵐ (A S⁻¹ z - z) with z = Sᵐ x, which is
/// bounded by the motion of one point, the centre of the next cell, and the turn times the distance of z
/// from it. That distance is the cell's radius and how far m steps lead: no farther than m times the
/// first, nor than twice the distance from the axis of S and m times its pitch.
#[derive(Clone, Copy, Debug)]
pub struct CellDrift {
    /// Of a corner in the frame of its cell.
    pub(super) own: f64,
    /// Of a ball round a cell.
    pub(super) radius: f64,
    pub(super) ways: [Way; 2],
}

impl CellDrift {
    /// How far a face can move as seen from any face of the cell so many cells back, in the units of the
    /// sheet.
    #[must_use]
    pub fn between(&self, offset: [i32; 2]) -> f64 {
        let [i, j] = offset.map(|count| f64::from(count).abs());
        let [first, second] = &self.ways;
        let there = self.radius + second.reach(j);
        2.0 * self.own + second.drift(j, self.radius) + first.drift(i, there)
    }
}

/// A hinge in space.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedHinge {
    /// Its crease group; `None` if it stays flat.
    pub(super) group: Option<usize>,
    /// A point on it.
    pub(super) pivot: Vector3<f64>,
    /// Unit direction about which what is beyond turns if its group's angle grows.
    pub(super) axis: Vector3<f64>,
}

/// A step in space: how far it leads, and how far it can move.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Way {
    /// Of the centre of the next cell.
    shift: f64,
    /// Radians.
    turn: f64,
    /// From the centre of a cell to that of the next.
    length: f64,
    pitch: f64,
    /// Twice the distance of the centre from the axis.
    width: f64,
}

impl Way {
    pub(super) fn new(
        chain: &[PlacedHinge],
        step: &Screw,
        center: Vector3<f64>,
        changes: &[f64],
    ) -> Self {
        let next = step.motion().carry(&center);
        let change = |hinge: &PlacedHinge| {
            let change = hinge.group.and_then(|group| changes.get(group));
            change.map_or(0.0, |change| change.abs())
        };
        let mut rates = vec![(Vector3::zeros(), Vector3::zeros()); changes.len()];
        let (mut shift, mut turn) = (0.0, 0.0);
        // Ways to the point from behind.
        let (mut lever, mut before) = (0.0, next);
        let mut rest: f64 = chain.iter().map(change).sum();
        for hinge in chain.iter().rev() {
            lever += (hinge.pivot - before).norm();
            before = hinge.pivot;
            let change = change(hinge);
            rest -= change;
            turn += change * rest / 2.0;
            shift += change * lever * (rest + change / 2.0);
            if let Some((velocity, spin)) = hinge.group.and_then(|group| rates.get_mut(group)) {
                *velocity += hinge.axis.cross(&(next - hinge.pivot));
                *spin += hinge.axis;
            }
        }
        for (change, (velocity, spin)) in changes.iter().zip(rates) {
            shift += change.abs() * velocity.norm();
            turn += change.abs() * spin.norm();
        }
        Self {
            shift,
            turn,
            length: (next - center).norm(),
            pitch: step.pitch(),
            width: step.width(next - center),
        }
    }

    /// No less than the distance between the centres of cells so many steps apart.
    fn reach(&self, count: f64) -> f64 {
        let straight = count * self.length;
        straight.min(self.width + count * self.pitch)
    }

    /// No less than what so many steps of it move a point this far from the centre.
    fn drift(&self, count: f64, distance: f64) -> f64 {
        let sum = count * (count + 1.0) / 2.0;
        let straight = sum * self.length;
        let reaches = straight.min(count * self.width + sum * self.pitch);
        count * self.shift + self.turn * (count * distance + reaches)
    }
}

#[cfg(test)]
mod tests {
    use super::super::map::Pose;
    use super::*;
    use foldpath_core::Rotation;

    /// A step over hinges through the origin and beside it, each once there and once back, so that from
    /// flat nothing is of first order: two turns commute but for their product.
    #[test]
    fn what_is_of_second_order_is_bounded() {
        let (x, y) = (Vector3::x(), Vector3::y());
        let pivots = [Vector3::zeros(), x * 0.3, y * 0.2, Vector3::zeros()];
        for beside in [0.0, 1.0] {
            let hinge = |k: usize| PlacedHinge {
                group: Some(k % 2),
                pivot: pivots[k] * beside,
                axis: [x, y, -x, -y][k],
            };
            let chain = [0, 1, 2, 3].map(hinge);
            let center = Vector3::new(0.5, 0.4, 0.6);
            let flat = Screw::new(Pose::identity());
            for size in [1e-3, 0.03, 0.3, 1.0] {
                let way = Way::new(&chain, &flat, center, &[size, size]);
                for signs in [[1.0, 1.0], [1.0, -1.0], [-0.5, 1.0]] {
                    let moved = |point: Vector3<f64>| {
                        chain.iter().rev().fold(point, |point, hinge| {
                            let angle = size * signs[hinge.group.unwrap()];
                            let (sin, cos) = (angle / 2.0).sin_cos();
                            let (w, v) = (cos, hinge.axis * sin);
                            let turned = Rotation { w, v }.rotate(&(point - hinge.pivot));
                            turned + hinge.pivot
                        })
                    };
                    for way_off in [Vector3::zeros(), x * 5.0, y * -20.0] {
                        let point = center + way_off;
                        let off = (moved(point) - point).norm();
                        let bound = way.drift(1.0, way_off.norm());
                        assert!(off <= bound, "{size} {signs:?}: {off:e} {bound:e}");
                        assert!(off > 0.01 * bound, "of use: {off:e} {bound:e}");
                    }
                }
            }
        }
    }
}
