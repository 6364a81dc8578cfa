//! The edges that have the names of lines: repairs split lines, join their pieces and move their ends a little.

use std::collections::BTreeMap;

use nalgebra::Vector2;

use super::planar::{Looks, foot, grid_of_lines, line};
use crate::pattern::{CreasePattern, Drawing, EdgeId, EdgeNames};

/// Names with the ends of the lines that each stands for.
pub(in crate::read) type LineNames = BTreeMap<String, Vec<[Vector2<f64>; 2]>>;

/// Returns for each name the edges that lie on one of its lines, `aside` of it at most. Returns `None` if there are too many
/// edges near each other.
pub(super) fn edges_of_names(
    pattern: &CreasePattern,
    names: LineNames,
    aside: f64,
    looks: &mut Looks<'_>,
) -> Option<EdgeNames> {
    if names.is_empty() {
        return Some(EdgeNames::new());
    }
    let Drawing {
        vertices, edges, ..
    } = pattern.drawing();
    let (grid, covered) = grid_of_lines(&vertices, &edges, 2.0 * aside);
    let mut named = EdgeNames::new();
    for (name, lines) in names {
        let mut found = Vec::new();
        for named in lines {
            grid.along(named, aside, |cell| {
                looks.take(1 + covered[cell].len());
                let near = covered[cell].iter();
                let on_line = |edge: &&usize| {
                    lie_on_each_other(line(&vertices, &edges[**edge]), named, aside)
                };
                found.extend(near.filter(on_line).map(|&edge| EdgeId::new(edge)));
            });
            if looks.are_used_up() {
                return None;
            }
        }
        found.sort_unstable();
        found.dedup();
        if !found.is_empty() {
            named.insert(name, found);
        }
    }
    Some(named)
}

/// Returns `true` if more than half of the shorter line lies along the longer one, and its ends are within `aside` of it.
fn lie_on_each_other(one: [Vector2<f64>; 2], other: [Vector2<f64>; 2], aside: f64) -> bool {
    let length = |[a, b]: [Vector2<f64>; 2]| (b - a).norm();
    let [shorter, longer] = if length(one) <= length(other) {
        [one, other]
    } else {
        [other, one]
    };
    let feet = shorter.map(|end| foot(longer, end));
    let [from, to] = feet.map(|(along, _, length)| along.clamp(0.0, length));
    feet.iter().all(|(_, off, _)| *off <= aside) && (to - from).abs() > 0.5 * length(shorter)
}
