//! A motion with all creases grouped together that turn exactly alike.

use std::collections::HashMap;

use foldpath_core::{Curve, GroupId, Membership};

use crate::motion::Motion;
use crate::pattern::EdgeId;
use crate::symmetry::CreaseGroups;

/// Largest difference, radians, of sectors of stars that are equal except for the rounding of coordinates.
/// Their actual difference is added to bounds.
const SAME_SECTOR_RAD: f64 = 1e-13;

/// The motion of all creases between knots, whatever groups the motion names.
pub(crate) struct MergedGroups {
    /// Groups of creases whose numbers are equal at all knots, or equal up to the sign, bit by bit.
    pub(crate) groups: CreaseGroups,
    /// For each group its first edge, whose sign is that of the group.
    pub(crate) leaders: Vec<EdgeId>,
    /// For each segment the curve of each group.
    pub(crate) segments: Vec<Vec<Curve<f64>>>,
}

impl MergedGroups {
    /// Groups the creases of a motion. Cost: O(knots · creases).
    pub(crate) fn of(path: &Motion) -> Self {
        let mut leaders: Vec<(EdgeId, bool)> = Vec::new();
        let mut groups: HashMap<Vec<u64>, u32> = HashMap::new();
        let mut numbers = Vec::with_capacity(4 * path.knots.len());
        let creases = path.pattern.creases().iter().map(|&edge| {
            let negative = numbers_of(path, edge, &mut numbers);
            let group = groups.get(&numbers).copied().unwrap_or_else(|| {
                let next = EdgeId::new(leaders.len()).0;
                leaders.push((edge, negative));
                groups.insert(numbers.clone(), next);
                next
            });
            let group = GroupId(group);
            let negative = negative != leaders[group.index()].1;
            Membership { group, negative }
        });
        let memberships = creases.collect();
        let leaders: Vec<EdgeId> = leaders.into_iter().map(|(edge, _)| edge).collect();
        let segment = |index: usize| {
            let curves = leaders.iter().map(|&edge| path.curve(index, edge));
            curves.collect()
        };
        let segments = (0..path.segments()).map(segment).collect();
        Self {
            groups: CreaseGroups::of_memberships(memberships, SAME_SECTOR_RAD / 4.0),
            leaders,
            segments,
        }
    }

    /// Returns `true` if all numbers of all curves are finite.
    pub(crate) fn is_finite(&self) -> bool {
        let finite = |cubic: &[f64; 4]| cubic.iter().all(|b| b.is_finite());
        self.segments.iter().flatten().all(|curve| match curve {
            Curve::Angle(angle) => finite(angle),
            Curve::HalfAngle { cos, sin } => finite(cos) && finite(sin),
        })
    }

    /// Returns a motion of one segment that stays at a knot of `shapes`, whose creases turn as these groups.
    pub(super) fn at_rest(&self, shapes: &Motion, knot: usize) -> Vec<Curve<f64>> {
        let angles = self.leaders.iter();
        let angles = angles.map(|&leader| shapes.node(knot, leader).angle);
        angles.map(|angle| Curve::Angle([angle; 4])).collect()
    }

    /// Returns the fold angles of the creases in a segment at `s`, radians.
    pub(super) fn angles(&self, segment: usize, s: f64) -> Vec<f64> {
        let curves = self.segments[segment].iter();
        self.groups
            .expand(&curves.map(|curve| curve.angle(s)).collect::<Vec<_>>())
    }
}

/// Collects the bits of all numbers that move an edge, with the sign that makes the first that is not 0
/// positive. Returns `true` if that is the other sign.
fn numbers_of(path: &Motion, edge: EdgeId, numbers: &mut Vec<u64>) -> bool {
    let nodes = || (0..path.knots.len()).map(|knot| path.node(knot, edge));
    let turns = nodes().flat_map(|node| [node.angle, node.rate]);
    let first = turns.clone().find(|turn| turn.abs() > 0.0);
    let negative = first.is_some_and(|first| first < 0.0);
    numbers.clear();
    // The sum turns -0 into 0, so that equal numbers have equal bits.
    numbers.extend(turns.map(|turn| (if negative { -turn } else { turn } + 0.0).to_bits()));
    numbers.extend(nodes().flat_map(|node| node.weight.map(f64::to_bits)));
    negative
}
