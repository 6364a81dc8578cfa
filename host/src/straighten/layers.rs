//! Finds creases of different layers that are meant to lie on one line once the sheet is folded flat.
//!
//! A fold through several layers makes a crease in each of them. At the vertices that such creases share, they are in line
//! if the vertices fold flat. Creases that share none, as where a layer ends before it meets another, are in line only if
//! they are drawn so.

use core::f64::consts::PI;

use nalgebra::{Matrix2, Vector2};

use super::Limits;
use super::condition::Condition;
use crate::pattern::{CreasePattern, Edge, FaceId};
use crate::util::union_find::UnionFind;

/// Largest number of edges of a pattern whose layers are compared: all pairs of creases are.
const MAX_EDGES: usize = 1 << 9;

/// Largest distance between the two places that the faces beside an edge give it if the sheet folds flat, as a fraction of
/// the reach.
const CLOSED_RATIO: f64 = 1e-6;

/// Returns the conditions that creases which nearly lie on one line of the sheet folded flat do so exactly. Nearly means
/// that no end has to move farther than the reach. There are none unless every vertex and hole folds flat. `ends` has the
/// ends of an edge among the `points`.
pub(super) fn conditions(
    pattern: &CreasePattern,
    points: &[Vector2<f64>],
    ends: impl Fn(&Edge) -> [usize; 2],
    limits: Limits,
) -> Vec<Condition> {
    let reach = limits.reach;
    if pattern.edges().len() > MAX_EDGES {
        return Vec::new();
    }
    let Some(folded) = Folded::new(pattern, points, &ends, reach) else {
        return Vec::new();
    };
    let hinges = pattern.edges().iter().filter(|edge| folds(edge));
    let mut creases: Vec<Crease> = hinges
        .filter_map(|edge| {
            let face = edge.inner_faces()?[0];
            let ends = ends(edge);
            let at = ends.map(|end| folded.place(face, points[end]));
            Some(Crease { face, ends, at })
        })
        .collect();
    creases.sort_by(|a, b| b.length().total_cmp(&a.length()));
    let mut lines = UnionFind::new(creases.len());
    let mut conditions = Vec::new();
    for (index, one) in creases.iter().enumerate() {
        for (other, crease) in creases.iter().enumerate().skip(index + 1) {
            if lines.are_joined([index, other]) || !one.is_beside(crease, reach) {
                continue;
            }
            let Some(between) = folded.creases_between([one.face, crease.face]) else {
                continue;
            };
            let on_line = crease.ends.map(|at| Condition::InLine {
                ends: one.ends,
                at,
                creases: between.clone(),
            });
            if !between.is_empty() && on_line.iter().all(|it| it.is_meant(points, limits)) {
                lines.join([index, other]);
                conditions.extend(on_line);
            }
        }
    }
    conditions
}

/// Returns `true` if an edge is folded by half a turn.
fn folds(edge: &Edge) -> bool {
    edge.crease.is_some() && edge.goal.unwrap_or(PI).abs() > PI / 2.0
}

/// A crease of a layer.
struct Crease {
    /// A face beside it.
    face: FaceId,
    ends: [usize; 2],
    /// Places of its ends in the folded sheet.
    at: [Vector2<f64>; 2],
}

impl Crease {
    fn length(&self) -> f64 {
        (self.at[1] - self.at[0]).norm()
    }

    /// Returns `true` if a shorter crease lies along this one, for a part of its length and within `reach`.
    fn is_beside(&self, other: &Self, reach: f64) -> bool {
        let [from, to] = self.at;
        let length = self.length();
        let along = (to - from) / length;
        let [a, b] = other.at.map(|end| end - from);
        let is_near = [a, b].iter().all(|end| along.perp(end).abs() <= reach);
        let [a, b] = [a, b].map(|end| along.dot(&end));
        is_near && a.min(b) < length - reach && a.max(b) > reach
    }
}

/// The sheet folded flat.
struct Folded {
    /// For each face, the turn and the shift that take it to its place.
    poses: Vec<(Matrix2<f64>, Vector2<f64>)>,
    /// For each face but the first of a sheet, the face from which it is reached, and the crease between, if that folds.
    parents: Vec<Option<(FaceId, Option<[usize; 2]>)>>,
    /// Number of faces on the way from the first of a sheet.
    depths: Vec<usize>,
}

impl Folded {
    /// Folds the sheet flat. Returns `None` if it does not close.
    fn new(
        pattern: &CreasePattern,
        points: &[Vector2<f64>],
        ends: impl Fn(&Edge) -> [usize; 2],
        reach: f64,
    ) -> Option<Self> {
        let tree = pattern.tree();
        let mut folded = Self {
            poses: vec![(Matrix2::identity(), Vector2::zeros()); tree.faces()],
            parents: vec![None; tree.faces()],
            depths: vec![0; tree.faces()],
        };
        for step in tree.steps() {
            let edge = pattern.edge(step.edge);
            let crease = folds(edge).then(|| ends(edge));
            let [face, parent] = [step.face, step.parent].map(FaceId::index);
            let (turn, shift) = folded.poses[parent];
            folded.poses[face] = crease.map_or((turn, shift), |crease| {
                let [a, b] = crease.map(|end| points[end]);
                let along = (b - a).normalize();
                let reflection = along * along.transpose() * 2.0 - Matrix2::identity();
                (turn * reflection, turn * (a - reflection * a) + shift)
            });
            folded.parents[face] = Some((step.parent, crease));
            folded.depths[face] = folded.depths[parent] + 1;
        }
        let closes = tree.loops().iter().all(|step| {
            let ends = ends(pattern.edge(step.edge)).map(|end| points[end]);
            ends.into_iter().all(|end| {
                let [one, other] = [step.face, step.parent].map(|face| folded.place(face, end));
                (one - other).norm() <= CLOSED_RATIO * reach
            })
        });
        closes.then_some(folded)
    }

    /// Returns the place of a point of a face in the folded sheet.
    fn place(&self, face: FaceId, point: Vector2<f64>) -> Vector2<f64> {
        let (turn, shift) = self.poses[face.index()];
        turn * point + shift
    }

    /// Returns the creases that fold on the way from one face to another; `None` if they belong to different sheets.
    fn creases_between(&self, [mut from, mut to]: [FaceId; 2]) -> Option<Vec<[usize; 2]>> {
        let (mut there, mut back) = (Vec::new(), Vec::new());
        while from != to {
            let is_deeper = self.depths[from.index()] >= self.depths[to.index()];
            let (face, way) = if is_deeper {
                (&mut from, &mut there)
            } else {
                (&mut to, &mut back)
            };
            let (parent, crease) = self.parents[face.index()]?;
            way.extend(crease);
            *face = parent;
        }
        back.reverse();
        there.append(&mut back);
        Some(there)
    }
}
