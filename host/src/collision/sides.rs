//! Two pieces that share a side. On a sheet that closes they turn about it and meet nowhere else; on a torn sheet they may.
//!
//! Seen from one piece, a tear takes the other from where the common side has it to where it is: the side's ends move by a
//! shift, and everything turns by an angle. A point at a distance r from the side moves by at most shift + turn r, and
//! without the tear its distance from the first piece is at least lean r. So only points with r < shift / (lean - turn) can
//! be in the first piece, and they are no deeper in it than shift lean / (lean - turn): two shifts, if the turn is at most
//! half the lean. As in all pairs that share a vertex, the distance between the positions of a common vertex, here the
//! shift, is allowed, and pieces may be in each other by twice what is allowed until that is found.
//!
//! The lean follows from the angle φ that the pieces enclose at the side. The distance of a point from the half-plane of the
//! first piece is at least its height over the line of the side, times sin φ if φ is acute. The ratio of that height to r,
//! the `spread`, is 1 unless the point is beyond an end of the side, and is least at a corner.

use core::f64::consts::PI;

use nalgebra::Vector2;

use super::pieces::{Pieces, Placed};
use super::tolerances::SIDE_ROUNDING_RATIO;
use crate::pattern::VertexId;

/// Ratio of the lean of two pieces to the turn of their tear from which on the pieces are free.
pub(super) const LEAN_TO_TURN_RATIO: f64 = 2.0;

/// A side that two pieces share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// Positions of the side's ends in the list of corners: those of the first piece, and those of the second.
    ends: [[u32; 2]; 2],
    /// Length, units of the sheet.
    length: f64,
    /// Largest distance of a point from the side, of the piece that reaches less far, units of the sheet.
    pub(super) reach: f64,
    /// Least ratio of a point's height over the line of the side to its distance from the side, of the piece for which this
    /// is larger.
    spread: f64,
}

impl Side {
    /// Returns the side between two pieces, given the positions of their corners at each vertex that they share; `None` if
    /// they share a vertex at most.
    pub(super) fn of(pieces: &Pieces, pair: [u32; 2], shared: &[[u32; 2]]) -> Option<Self> {
        let starts = pair.map(|piece| pieces.list[piece as usize].corners().start);
        let place = |corners: [u32; 2]| pieces.flat[starts[0] + corners[0] as usize];
        // All shared vertices are on one line.
        let farthest = |from: [u32; 2]| {
            let away = |to: &[u32; 2]| (place(*to) - place(from)).norm_squared();
            let farthest = shared.iter().max_by(|a, b| away(a).total_cmp(&away(b)));
            farthest.copied().unwrap_or(from)
        };
        let end = farthest(*shared.first()?);
        let ends = [farthest(end), end];
        let line = ends.map(place);
        let (mut reach, mut spread) = (f64::INFINITY, 0.0_f64);
        for piece in pair {
            let corners = &pieces.flat[pieces.list[piece as usize].corners()];
            let (farthest, least) = extent(corners, line);
            reach = reach.min(farthest);
            spread = spread.max(least);
        }
        (shared.len() > 1).then(|| Self {
            ends: [0, 1].map(|k| ends.map(|end| VertexId::new(starts[k]).0 + end[k])),
            length: (line[1] - line[0]).norm(),
            reach,
            spread,
        })
    }

    /// Returns the angle between the directions that two placed pieces give the side, radians.
    pub(super) fn turn(&self, placed: &Placed<'_>) -> f64 {
        let [a, b] = self.ends.map(|ends| {
            let [from, to] = ends.map(|end| placed.folded[end as usize]);
            to - from
        });
        a.cross(&b).norm().atan2(a.dot(&b))
    }

    /// Returns the lean of two placed pieces.
    pub(super) fn lean(&self, placed: &Placed<'_>, pair: [u32; 2]) -> f64 {
        let [a, b] = pair.map(|piece| placed.normals[piece as usize]);
        if a.dot(&b) >= 0.0 {
            self.spread
        } else {
            self.spread * a.cross(&b).norm()
        }
    }

    /// Returns the least angle that the pieces have to enclose to be free, radians, if the sheet is torn at the side by at
    /// most `turn`; `None` if no angle is enough.
    pub(super) fn least_opening(&self, turn: f64) -> Option<f64> {
        let least = LEAN_TO_TURN_RATIO * turn / self.spread;
        (least <= 1.0).then(|| least.asin())
    }

    /// Returns `true` if the tear of two placed pieces may move a point of the smaller one by more than `depth`, in units of
    /// the sheet.
    pub(super) fn may_cross(&self, placed: &Placed<'_>, depth: f64) -> bool {
        let [a, b] = self.ends;
        let apart = |k: usize| placed.folded[a[k] as usize] - placed.folded[b[k] as usize];
        let shift = apart(0).norm().max(apart(1).norm());
        // Two shifts over the length are the sine of the turn at most.
        (1.0 + PI * self.reach / self.length) * shift > depth
    }
}

/// Returns the largest distance of a point of a piece from a side, and the least ratio of height over the line of the side
/// to that distance.
fn extent(corners: &[Vector2<f64>], [from, to]: [Vector2<f64>; 2]) -> (f64, f64) {
    let along = to - from;
    let length = along.norm();
    let each = corners.iter().map(|corner| {
        let away = corner - from;
        let height = (along.perp(&away) / length).abs();
        let foot = along.dot(&away) / length;
        let beyond = (-foot).max(foot - length);
        let beyond = if beyond > SIDE_ROUNDING_RATIO * length {
            beyond
        } else {
            0.0
        };
        (height.hypot(beyond), height)
    });
    each.fold((0.0, 1.0), |(reach, spread), (away, height)| {
        let ratio = if away > 0.0 { height / away } else { 1.0 };
        (f64::max(reach, away), f64::min(spread, ratio))
    })
}
