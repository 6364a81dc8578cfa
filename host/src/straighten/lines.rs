//! Finds the straight lines of a pattern, and which of them are meant to be parallel.

use core::f64::consts::PI;
use std::collections::BTreeMap;

use nalgebra::Vector2;

use super::condition::Condition;
use crate::util::csr::group_by_key;

/// Largest angle (radians) between edges or lines that are meant to have one direction.
const MAX_BEND_RAD: f64 = 0.0175;

/// Largest distance of a vertex from the chord of its line, in reaches: both ends of the chord may be off too.
const MAX_SAGITTA_REACHES: f64 = 2.0;

/// A straight line of edges, one behind the other.
struct Line {
    /// Its vertices in their order along the line.
    vertices: Vec<usize>,
    /// Direction of the way from the first vertex to the last as an angle from 0 to π.
    angle: f64,
    length: f64,
}

impl Line {
    fn ends(&self) -> [usize; 2] {
        [self.vertices[0], self.vertices[self.vertices.len() - 1]]
    }
}

/// Returns the conditions that lines which are nearly straight are straight, and that those which are nearly parallel
/// are parallel. Nearly means that no end has to move farther than `reach`. Cost: O(n log n).
pub(super) fn conditions(
    points: &[Vector2<f64>],
    edges: &[[usize; 2]],
    reach: f64,
) -> Vec<Condition> {
    let mut conditions = Vec::new();
    for class in parallel_classes(chains(points, edges, reach), reach) {
        let lines = joined(points, class, reach);
        for line in &lines {
            let ends = line.ends();
            let inner = &line.vertices[1..line.vertices.len() - 1];
            conditions.extend(inner.iter().map(|&at| Condition::InLine {
                ends,
                at,
                creases: Vec::new(),
            }));
        }
        let longest = lines.iter().max_by(|a, b| a.length.total_cmp(&b.length));
        let Some(longest) = longest.map(Line::ends) else {
            continue;
        };
        let others = lines.iter().map(Line::ends).filter(|ends| *ends != longest);
        conditions.extend(others.map(|ends| Condition::Parallel {
            lines: [longest, ends],
        }));
    }
    conditions
}

/// Returns the chains of edges that run on nearly straight, each as long as possible. Chains that are bent all in all,
/// as circles of many short edges, are left out.
fn chains(points: &[Vector2<f64>], edges: &[[usize; 2]], reach: f64) -> Vec<Line> {
    let ends = edges.iter().enumerate();
    let ends = ends.flat_map(|(index, ends)| ends.map(|end| (end, index)));
    let stars = group_by_key(points.len(), ends);
    // For each edge the edges that prolong it beyond its two ends.
    let mut beyond = vec![[None; 2]; edges.len()];
    let other_end = |edge: usize, vertex: usize| {
        let [a, b] = edges[edge];
        if a == vertex { b } else { a }
    };
    let straightest = |edge: usize, vertex: usize| {
        let away = |edge: usize| points[other_end(edge, vertex)] - points[vertex];
        let own = away(edge);
        let bend = |&other: &usize| {
            let away = away(other);
            let area = own.perp(&away).abs();
            let sine = area / (own.norm() * away.norm());
            let is_straight =
                own.dot(&away) < 0.0 && sine <= MAX_BEND_RAD && area <= reach * (own - away).norm();
            is_straight.then_some((sine, other))
        };
        let straight = stars[vertex].iter().filter_map(bend);
        Some(straight.min_by(|a, b| a.0.total_cmp(&b.0))?.1)
    };
    for (index, ends) in edges.iter().enumerate() {
        for (side, &end) in ends.iter().enumerate() {
            let next = straightest(index, end);
            beyond[index][side] = next.filter(|&next| straightest(next, end) == Some(index));
        }
    }
    let mut used = vec![false; edges.len()];
    let mut chains = Vec::new();
    for start in 0..edges.len() {
        let Some(side) = beyond[start].iter().position(Option::is_none) else {
            continue;
        };
        let mut vertices = vec![edges[start][side]];
        let mut edge = Some(start).filter(|&start| !used[start]);
        while let Some(index) = edge {
            used[index] = true;
            let from = vertices[vertices.len() - 1];
            let to = other_end(index, from);
            vertices.push(to);
            let side = usize::from(edges[index][1] == to);
            edge = beyond[index][side].filter(|&next| !used[next]);
        }
        chains.extend(line(points, vertices, reach));
    }
    chains
}

/// Makes a line of vertices in their order, unless there is but one, or the line is bent.
fn line(points: &[Vector2<f64>], vertices: Vec<usize>, reach: f64) -> Option<Line> {
    let [first, last] = [vertices[0], vertices[vertices.len() - 1]].map(|end| points[end]);
    let along = last - first;
    let length = along.norm();
    let is_near = |&vertex: &usize| {
        let aside = along.perp(&(points[vertex] - first)).abs();
        aside <= MAX_SAGITTA_REACHES * reach * length
    };
    let is_line = vertices.len() > 1 && length > 0.0 && vertices.iter().all(is_near);
    is_line.then(|| Line {
        // Without the sign of -0, as classes are found by the bits of the angle.
        angle: along.y.atan2(along.x).rem_euclid(PI).abs(),
        vertices,
        length,
    })
}

/// Parts the lines into classes of nearly the same direction, each with its longest line first. A line that fits several
/// classes belongs to none of them.
fn parallel_classes(mut lines: Vec<Line>, reach: f64) -> Vec<Vec<Line>> {
    lines.sort_by(|a, b| b.length.total_cmp(&a.length));
    let mut classes: Vec<Vec<Line>> = Vec::new();
    // The classes by the direction of their longest line, whose bits are in the order of the angles.
    let mut by_angle: BTreeMap<u64, usize> = BTreeMap::new();
    for line in lines {
        // Turning the line about its middle by this angle moves its ends by the reach.
        let within = (2.0 * reach / line.length).min(MAX_BEND_RAD);
        let near = [-PI, 0.0, PI].into_iter().filter_map(|turn| {
            let [low, high] = [-within, within].map(|off| line.angle + turn + off);
            let from = |low: f64| low.max(0.0).abs().to_bits();
            (high >= 0.0).then(|| by_angle.range(from(low)..=from(high)))
        });
        let mut near: Vec<usize> = near.flatten().map(|(_, &class)| class).collect();
        near.sort_unstable();
        near.dedup();
        match near[..] {
            [class] => classes[class].push(line),
            [] => {
                by_angle.insert(line.angle.to_bits(), classes.len());
                classes.push(vec![line]);
            }
            _ => classes.push(vec![line]),
        }
    }
    classes
}

/// Joins those parallel lines that lie on one line, one behind the other with a gap between.
fn joined(points: &[Vector2<f64>], class: Vec<Line>, reach: f64) -> Vec<Line> {
    let (sin, cos) = class[0].angle.sin_cos();
    let along = Vector2::new(cos, sin);
    let position = |vertex: usize| along.dot(&points[vertex]);
    let offset = |line: &Line| {
        let [a, b] = line.ends().map(|end| along.perp(&points[end]));
        f64::midpoint(a, b)
    };
    let mut lines: Vec<(f64, Line)> = class.into_iter().map(|it| (offset(&it), it)).collect();
    lines.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut joined: Vec<Line> = Vec::new();
    let mut rest = lines.into_iter().peekable();
    while let Some((first, line)) = rest.next() {
        let mut group = vec![line];
        while let Some((_, line)) = rest.next_if(|(offset, _)| offset - first <= reach) {
            group.push(line);
        }
        let mut ordered: Vec<([f64; 2], Line)> = Vec::new();
        for line in group {
            let [a, b] = line.ends().map(position);
            ordered.push(([a.min(b), a.max(b)], line));
        }
        ordered.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
        let mut end = f64::NEG_INFINITY;
        let mut open: Option<Line> = None;
        for ([from, to], mut line) in ordered {
            line.vertices
                .sort_by(|&a, &b| position(a).total_cmp(&position(b)));
            match &mut open {
                Some(before) if from >= end - reach => {
                    before.vertices.append(&mut line.vertices);
                    before.vertices.dedup();
                    before.length += line.length;
                }
                _ => joined.extend(open.replace(line)),
            }
            end = end.max(to);
        }
        joined.extend(open);
    }
    joined
}
