//! Simple folds: the part of the sheet on one side of a line turns about the line as a whole, in all layers or in some.
//! A sheet that is folded by hand along one line after the other has no other motions.
//!
//! Source: E. Arkin et al., "When can you fold a map?", 2004.

use std::collections::HashMap;

use nalgebra::Vector3;

use crate::pattern::{CreasePattern, EdgeId, FaceId};
use crate::util::union_find::UnionFind;

/// Largest distance of a crease from a line that it lies on, as a fraction of the length of the longer one.
const OFF_LINE_RATIO: f64 = 1e-3;
/// Largest difference of angles that count as equal, radians.
const UNLIKE_RAD: f64 = 1e-3;

/// Returns sets of creases on one line of the folded sheet that can turn together while all others stay: for each line
/// all its creases that have to turn, and those round each part of the sheet that turns against all other parts.
///
/// `shape` has the folded position of each vertex, `turns` the angle (radians) by which each crease has still to turn,
/// 0 if it stays. Cost: O(edges) for each line.
pub(crate) fn simple_folds(
    pattern: &CreasePattern,
    shape: &[Vector3<f64>],
    turns: &[f64],
) -> Vec<Vec<usize>> {
    let mut folds = Vec::new();
    for line in lines(pattern, shape, turns) {
        let joints = joints(pattern, shape, turns, &line);
        let mut parts: Vec<usize> = joints.iter().flat_map(|joint| joint.parts).collect();
        parts.sort_unstable();
        parts.dedup();
        if all_turn(&joints) {
            folds.push(line.clone());
        }
        for part in parts {
            let around = joints.iter().filter_map(|joint| joint.turn_of(part));
            let Some(first) = around.clone().next() else {
                continue;
            };
            if around.clone().all(|turn| (turn - first).abs() < UNLIKE_RAD) {
                let turning = line.iter().zip(&joints);
                let turning = turning.filter(|(_, joint)| joint.turn_of(part).is_some());
                folds.push(turning.map(|(&crease, _)| crease).collect());
            }
        }
    }
    folds
}

/// A crease on a line, as a hinge between parts of the sheet.
struct Joint {
    /// Parts to the left and to the right of the crease.
    parts: [usize; 2],
    /// Angle by which the left part turns about the line against the right one, radians.
    turn: f64,
}

impl Joint {
    /// Returns the angle by which a part turns against the other; `None` if both or neither are this part.
    fn turn_of(&self, part: usize) -> Option<f64> {
        match self.parts.map(|one| one == part) {
            [true, false] => Some(self.turn),
            [false, true] => Some(-self.turn),
            _ => None,
        }
    }
}

/// Returns the creases that have to turn, in one list for each line on which there are any.
fn lines(pattern: &CreasePattern, shape: &[Vector3<f64>], turns: &[f64]) -> Vec<Vec<usize>> {
    let ends = |crease: usize| ends(pattern, shape, pattern.creases()[crease]);
    let mut lines: Vec<Vec<usize>> = Vec::new();
    for crease in (0..turns.len()).filter(|&crease| turns[crease].abs() > 0.0) {
        let [a, b] = ends(crease);
        let lies_on = |line: &Vec<usize>| {
            let [from, to] = ends(line[0]);
            let along = (to - from).normalize();
            let most = OFF_LINE_RATIO * (to - from).norm().max((b - a).norm());
            [a, b]
                .iter()
                .all(|end| along.cross(&(end - from)).norm() <= most)
        };
        match lines.iter().position(lies_on) {
            Some(line) => lines[line].push(crease),
            None => lines.push(vec![crease]),
        }
    }
    lines
}

/// Returns the folded ends of an edge.
fn ends(pattern: &CreasePattern, shape: &[Vector3<f64>], edge: EdgeId) -> [Vector3<f64>; 2] {
    pattern.edge(edge).ends.map(|end| shape[end.index()])
}

/// Returns the creases of a line as hinges between the parts that all other edges join.
fn joints(
    pattern: &CreasePattern,
    shape: &[Vector3<f64>],
    turns: &[f64],
    line: &[usize],
) -> Vec<Joint> {
    let mut parts = UnionFind::new(pattern.faces().len());
    for edge in pattern.edges() {
        let turns = edge
            .crease
            .is_some_and(|crease| line.contains(&crease.index()));
        if let (Some(faces), false) = (edge.inner_faces(), turns) {
            parts.join(faces.map(FaceId::index));
        }
    }
    let [from, to] = ends(pattern, shape, pattern.creases()[line[0]]);
    let joint = |&crease: &usize| {
        let edge = pattern.creases()[crease];
        let [a, b] = ends(pattern, shape, edge);
        let faces = pattern
            .edge(edge)
            .inner_faces()
            .unwrap_or([FaceId::new(0); 2]);
        Joint {
            parts: faces.map(|face| parts.find(face.index())),
            turn: turns[crease] * (b - a).dot(&(to - from)).signum(),
        }
    };
    line.iter().map(joint).collect()
}

/// Returns `true` if all joints can turn at once, each by the angle by which it has to turn.
fn all_turn(joints: &[Joint]) -> bool {
    // Angle by which each part turns against the first.
    let mut turned = HashMap::from([(joints[0].parts[0], 0.0)]);
    for _ in joints {
        for Joint { parts, turn } in joints {
            match parts.map(|part| turned.get(&part).copied()) {
                [Some(left), None] => turned.insert(parts[1], left - turn),
                [None, Some(right)] => turned.insert(parts[0], right + turn),
                _ => None,
            };
        }
    }
    joints.iter().all(|Joint { parts, turn }| {
        let [left, right] = parts.map(|part| turned.get(&part));
        left.zip(right)
            .is_some_and(|(left, right)| (left - right - turn).abs() < UNLIKE_RAD)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folding::FoldingMap;
    use crate::pattern::{Drawing, DrawnEdge, Letter};
    use core::f64::consts::PI;
    use nalgebra::Vector2;

    /// Makes a map of columns and rows of unit squares.
    fn map(columns: usize, rows: usize) -> CreasePattern {
        let at = |x: usize, y: usize| x * (rows + 1) + y;
        let places = (0..=columns).flat_map(|x| (0..=rows).map(move |y| [x, y]));
        let up = places.clone().filter(|[_, y]| *y < rows);
        let up = up.map(|[x, y]| ([at(x, y), at(x, y + 1)], x % columns == 0));
        let right = places.clone().filter(|[x, _]| *x < columns);
        let right = right.map(|[x, y]| ([at(x, y), at(x + 1, y)], y % rows == 0));
        let edges = up.chain(right).map(|(ends, rim)| DrawnEdge {
            ends,
            letter: if rim {
                Letter::Boundary
            } else {
                Letter::Valley
            },
            goal: None,
        });
        #[allow(clippy::cast_precision_loss, reason = "small numbers")]
        let vertices = places.map(|[x, y]| Vector2::new(x as f64, y as f64));
        CreasePattern::new(Drawing {
            vertices: vertices.collect(),
            edges: edges.collect(),
            ..Drawing::default()
        })
        .unwrap()
    }

    /// Returns the simple folds of a sheet whose creases are at `from` and go to `to`.
    fn folds(pattern: &CreasePattern, from: &[f64], to: &[f64]) -> Vec<Vec<usize>> {
        let shape = FoldingMap::new(pattern, pattern.tree(), from);
        let turns: Vec<f64> = from.iter().zip(to).map(|(from, to)| to - from).collect();
        let mut folds = simple_folds(pattern, shape.vertices(), &turns);
        folds.sort();
        folds.dedup();
        folds
    }

    #[test]
    fn a_map_is_folded_one_way_and_then_the_other() {
        // Creases 0 and 1 lie on the line up, 2 and 3 on that across.
        let map = map(2, 2);
        let to = [PI, PI, PI, -PI];
        assert_eq!(folds(&map, &[0.0; 4], &to), [[0, 1]]);
        assert_eq!(folds(&map, &[PI, PI, 0.0, 0.0], &to), [[2, 3]]);
        // The line across is straight, but its halves turn against each other.
        assert_eq!(folds(&map, &[0.0; 4], &[0.0, 0.0, PI, -PI]), [[0; 0]; 0]);
        // The line across is not straight while the sheet is half folded.
        let half = [PI / 2.0, PI / 2.0, 0.0, 0.0];
        assert_eq!(folds(&map, &half, &to), [[0, 1]]);
    }

    #[test]
    fn pleats_on_one_line_fold_together_or_alone() {
        let strip = map(4, 1);
        let to = [PI, -PI, PI];
        assert_eq!(folds(&strip, &[0.0; 3], &to), [[0], [1], [2]]);
        // With the middle one folded, the others lie on each other: both turn the part between them against the rest.
        let both = folds(&strip, &[0.0, -PI, 0.0], &to);
        assert_eq!(both, [vec![0], vec![0, 2], vec![2]]);
    }
}
