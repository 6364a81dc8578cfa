//! How long two pieces that touch stay on two sides of a plane.
//!
//! At contact their distance says nothing of what may happen next: to first order all motion is
//! dangerous. So the plane of a side or of a piece is taken that parts them now, fixed to one piece, and
//! the heights of the corners of the other over it are followed to second order. With δ the turns of the
//! creases between, in their order from the fixed piece, the height changes by the sum of gradient times
//! δ, and by no more than ½ Σᵢⱼ |δᵢ δⱼ| times the distance from the farther of creases i and j.

use nalgebra::Vector3;

use super::crossing::ConvexPiece;

/// A crease between the pieces, seen from the fixed one: its line, and which way a positive group angle
/// turns what is beyond.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    pub(super) group: u32,
    pub(super) point: Vector3<f64>,
    /// The unit direction about which.
    pub(super) about: Vector3<f64>,
}

/// What a group angle does over a step: its change, and its largest distance from a straight line
/// there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    pub(super) by: f64,
    pub(super) off: f64,
}

/// A corner over a plane.
#[derive(Clone, Debug)]
struct Corner {
    height: f64,
    /// For each turn, change of height per radian and distance from the crease.
    gradients: Vec<f64>,
    reaches: Vec<f64>,
}

/// The corners of a piece over a plane that parts it from another.
#[derive(Clone, Debug)]
pub(super) struct Parted {
    turns: Vec<u32>,
    corners: Vec<Corner>,
}

/// The planes of a piece and of its sides, upright on it, that have it on one side and `other` on the
/// other, up to `tolerance`; the turns lead from it to the other. Where the other came from `above` the piece, or from
/// below, it must not go on there on its other side.
pub(super) fn parted(
    piece: &ConvexPiece<'_>,
    other: &ConvexPiece<'_>,
    turns: &[Turn],
    above: Option<bool>,
    tolerance: f64,
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
    let planes = flat.map(|(normal, _)| (normal, corners[0])).chain(outward);
    let heights = |(normal, point): &(Vector3<f64>, Vector3<f64>)| {
        let heights = other.corners.iter().map(|c| normal.dot(&(c - point)));
        heights.fold(f64::INFINITY, f64::min)
    };
    planes
        .filter(|plane| heights(plane) >= -tolerance)
        .map(|(normal, point)| Parted {
            turns: turns.iter().map(|turn| turn.group).collect(),
            corners: other
                .corners
                .iter()
                .map(|corner| over(normal, point, corner, turns))
                .collect(),
        })
        .collect()
}

fn over(normal: Vector3<f64>, point: Vector3<f64>, at: &Vector3<f64>, turns: &[Turn]) -> Corner {
    let rates = turns
        .iter()
        .map(|turn| turn.about.cross(&(at - turn.point)));
    let rates: Vec<_> = rates.collect();
    Corner {
        height: normal.dot(&(at - point)),
        gradients: rates.iter().map(|rate| normal.dot(rate)).collect(),
        reaches: rates.iter().map(Vector3::norm).collect(),
    }
}

impl Parted {
    /// Whether no corner comes lower than `-tolerance` while the groups make these changes.
    pub(super) fn holds(&self, changes: &[Change], tolerance: f64) -> bool {
        self.corners
            .iter()
            .all(|corner| self.lowest(corner, changes) >= -tolerance)
    }

    fn lowest(&self, corner: &Corner, changes: &[Change]) -> f64 {
        let change = |turn: usize| changes[self.turns[turn] as usize];
        let (mut along, mut off, mut curved) = (0.0, 0.0, 0.0);
        // From the moving piece inwards: how far the corner moves as seen from the creases before, and
        // the sum of the turns of those not yet passed.
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
