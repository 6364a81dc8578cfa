//! Orders the edges of a surface for the spanning tree along which the surface is laid flat, in several ways.

use std::collections::{BinaryHeap, HashMap};

use nalgebra::Vector3;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

use super::FoldedShape;
use super::angles::Creases;
use super::surface::{Side, Surface};
use crate::util::csr::{Csr, group_by_key};
use crate::util::union_find::UnionFind;

/// Ratio by which a cut through a flat panel counts as longer than one along a fold.
const PANEL_RATIO: f64 = 1e3;

/// Range of the random factors of lengths in attempts that look for other short cuts.
const LENGTH_FACTORS: core::ops::Range<f64> = 1.0..3.0;

/// Step in which lengths are compared, as a fraction of the size of the shape.
const LENGTH_STEP_RATIO: f64 = 1e-9;

/// Returns the edges between two faces in the order in which they join faces (as in Kruskal's algorithm). An edge joins
/// its faces unless that closes a ring. `attempts` has for each part the number of its attempt, of which each cuts along
/// other edges.
///
/// Attempt 0 cuts a part with a boundary along the shortest tree that [`shortest`] finds. A closed part goes outwards from
/// the middle: of otherwise equal edges, those near the middle come first. In parts with a boundary, every second attempt
/// looks for a short tree with lengths that are multiplied by random factors. Every other attempt cuts for each vertex the
/// edge that rises most steeply in some direction (W. Schlickenrieder, "Nets of polyhedra", 1997), which on convex
/// polyhedra hardly ever gives an overlap. In all attempts, edges that are not folded come first, unless the shortest tree
/// goes along them.
pub(super) fn order(
    shape: &FoldedShape,
    surface: &Surface,
    creases: &Creases,
    levels: &[usize],
    attempts: &[usize],
) -> Vec<usize> {
    // Lengths are counted in steps, so that equal ones are equal however the shape is turned.
    let step = LENGTH_STEP_RATIO * shape.size();
    let folded = |index: usize| creases.angles[index].abs() > 0.0;
    let mut of_parts = vec![Vec::new(); surface.parts()];
    for (index, edge) in surface.edges.iter().enumerate() {
        if let Some(side) = edge.sides[0] {
            of_parts[surface.parts[side.face]].push(index);
        }
    }
    let mut cut = vec![false; surface.edges.len()];
    let mut through_panel = vec![false; surface.edges.len()];
    let mut steepest = Steepest::new(shape);
    let tree = Tree::new(surface);
    for (part, edges) in of_parts.iter().enumerate() {
        let attempt = attempts[part];
        if surface.is_plain(part) {
            continue;
        }
        let short = surface.has_corners[part] && !surface.closed[part];
        if short && attempt.is_multiple_of(2) {
            let mut random = random(attempt);
            let mut length = |index: usize| {
                let [a, b] = surface.edges[index].ends;
                let length = ((shape.vertices[b] - shape.vertices[a]).norm() / step).round();
                let core::ops::Range { start, end } = LENGTH_FACTORS;
                let factor = match attempt {
                    0 => 1.0,
                    _ => start + (end - start) * (number(&mut random) + 0.5),
                };
                length * factor * if folded(index) { 1.0 } else { PANEL_RATIO }
            };
            for index in tree.shortest(surface, edges, &mut length) {
                cut[index] = true;
                through_panel[index] = !folded(index);
            }
        } else if attempt > 0 {
            steepest.mark(surface, edges, attempt, &mut cut);
        }
    }
    let edges = surface.edges.iter().enumerate();
    let joints = edges.filter_map(|(index, edge)| Some((index, edge.joint()?)));
    let key = |(index, [a, b]): (usize, [Side; 2])| {
        let late = folded(index) && !surface.is_plain(surface.parts[a.face]);
        let level = levels[a.face] + levels[b.face];
        (late || through_panel[index], cut[index], level, index)
    };
    let mut keys: Vec<_> = joints.map(key).collect();
    keys.sort_unstable();
    keys.into_iter().map(|key| key.3).collect()
}

/// Returns the random numbers of an attempt.
fn random(attempt: usize) -> Pcg64 {
    Pcg64::new(attempt as u128, 0)
}

/// Returns a random number from -0.5 to 0.5.
fn number(random: &mut Pcg64) -> f64 {
    f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5
}

/// Finds for each vertex the edge that rises most steeply in some direction.
struct Steepest<'a> {
    shape: &'a FoldedShape,
    /// For each vertex the slope of the steepest edge so far, and that edge.
    best: Vec<(f64, Option<usize>)>,
}

impl<'a> Steepest<'a> {
    fn new(shape: &'a FoldedShape) -> Self {
        Self {
            shape,
            best: vec![(f64::NEG_INFINITY, None); shape.vertices.len()],
        }
    }

    /// Marks for each vertex of the edges of a part the edge that rises most steeply in a direction drawn at random for
    /// the attempt.
    fn mark(&mut self, surface: &Surface, edges: &[usize], attempt: usize, cut: &mut [bool]) {
        let mut random = random(attempt);
        let mut number = || number(&mut random);
        let up = Vector3::new(number(), number(), number());
        for &index in edges {
            let [a, b] = surface.edges[index].ends;
            let [from, to] = [a, b].map(|end| self.shape.vertices[end]);
            let rise = (to - from).normalize().dot(&up);
            for (from, rise) in [(a, rise), (b, -rise)] {
                if rise > self.best[from].0 {
                    self.best[from] = (rise, Some(index));
                }
            }
        }
        for end in edges.iter().flat_map(|&index| surface.edges[index].ends) {
            if let (_, Some(index)) =
                core::mem::replace(&mut self.best[end], (f64::NEG_INFINITY, None))
            {
                cut[index] = true;
            }
        }
    }
}

/// Finds short trees of edges that join the corners of a part with its boundary.
struct Tree {
    /// For each point of the paper the edges there.
    at: Csr<usize>,
    /// For each point that is a corner or on the boundary the point that stands for its terminal: a corner itself, or all
    /// of a boundary.
    terminals: Vec<Option<usize>>,
}

impl Tree {
    fn new(surface: &Surface) -> Self {
        let count = surface.points.len();
        let mut boundaries = UnionFind::new(count);
        let mut terminals = vec![None; count];
        let mut at = Vec::new();
        for (index, edge) in surface.edges.iter().enumerate() {
            if edge.joint().is_some() {
                at.extend(points(surface, index).map(|point| (point, index)));
                continue;
            }
            for side in edge.sides.into_iter().flatten() {
                let ends = surface.corners(side).map(|corner| surface.points[corner]);
                boundaries.join_to_smaller(ends);
                terminals[ends[0]] = Some(ends[0]);
                terminals[ends[1]] = Some(ends[1]);
            }
        }
        for terminal in terminals.iter_mut().flatten() {
            *terminal = boundaries.find(*terminal);
        }
        for &corner in &surface.corners {
            terminals[corner] = Some(corner);
        }
        Self {
            at: group_by_key(count, at),
            terminals,
        }
    }

    /// Returns the edges of a short tree that joins all corners and boundaries of a part, of whose edges `length` tells the
    /// lengths. The tree is at most twice as long as the shortest one (K. Mehlhorn, "A faster approximation algorithm for
    /// the Steiner problem in graphs", 1988).
    fn shortest(
        &self,
        surface: &Surface,
        edges: &[usize],
        length: &mut impl FnMut(usize) -> f64,
    ) -> Vec<usize> {
        let lengths: HashMap<usize, f64> =
            edges.iter().map(|&index| (index, length(index))).collect();
        // The way of each point to the nearest terminal: its length, the first edge and the terminal.
        let mut ways = HashMap::new();
        let mut open = BinaryHeap::new();
        for point in edges.iter().flat_map(|&index| points(surface, index)) {
            if let Some(terminal) = self.terminals[point] {
                open.push(Way {
                    length: 0.0,
                    point,
                    edge: None,
                    terminal,
                });
            }
        }
        while let Some(way) = open.pop() {
            if ways.contains_key(&way.point) {
                continue;
            }
            for &index in &self.at[way.point] {
                let [a, b] = points(surface, index);
                let point = if a == way.point { b } else { a };
                let length = way.length + lengths[&index];
                open.push(Way {
                    length,
                    point,
                    edge: Some(index),
                    ..way
                });
            }
            ways.insert(way.point, way);
        }
        let mut bridges: Vec<(f64, usize)> = edges
            .iter()
            .filter_map(|&index| {
                let [a, b] = points(surface, index).map(|point| ways.get(&point));
                let (a, b) = (a?, b?);
                let joint = surface.edges[index].joint().is_some();
                (joint && a.terminal != b.terminal)
                    .then(|| (a.length + lengths[&index] + b.length, index))
            })
            .collect();
        bridges.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut joined = UnionFind::new(self.terminals.len());
        let mut tree = Vec::new();
        for (_, index) in bridges {
            let ends = points(surface, index);
            if !joined.join(ends.map(|point| ways[&point].terminal)) {
                continue;
            }
            tree.push(index);
            for mut point in ends {
                while let Some(index) = ways[&point].edge {
                    tree.push(index);
                    let [a, b] = points(surface, index);
                    point = if a == point { b } else { a };
                }
            }
        }
        tree
    }
}

/// Returns the points of the paper at the ends of an edge.
fn points(surface: &Surface, index: usize) -> [usize; 2] {
    let side = surface.edges[index].sides[0];
    side.map_or([0; 2], |side| {
        surface.corners(side).map(|corner| surface.points[corner])
    })
}

/// A way from a point to a terminal. The shortest way is the greatest, as a heap wants it.
#[derive(Clone, Copy)]
struct Way {
    length: f64,
    point: usize,
    edge: Option<usize>,
    terminal: usize,
}

impl Ord for Way {
    fn cmp(&self, other: &Self) -> core::cmp::Ordering {
        let by_length = other.length.total_cmp(&self.length);
        by_length.then((other.point, other.edge).cmp(&(self.point, self.edge)))
    }
}

impl PartialOrd for Way {
    fn partial_cmp(&self, other: &Self) -> Option<core::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Way {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Way {}

/// Returns for each edge `true` if the sheet is whole across it: edges that join faces, `used`, and edges of cuts that end
/// at a point inside the paper without angle defect. Such a cut closes up again, edge by edge.
pub(super) fn closed_up(surface: &Surface, used: Vec<bool>) -> Vec<bool> {
    let mut whole = used;
    let mut ends = vec![false; surface.points.len()];
    for point in surface.inner_points() {
        ends[point] = true;
    }
    for &corner in &surface.corners {
        ends[corner] = false;
    }
    let mut cuts = vec![Vec::new(); surface.points.len()];
    for (index, edge) in surface.edges.iter().enumerate() {
        if edge.joint().is_some() && !whole[index] {
            for point in points(surface, index) {
                cuts[point].push(index);
            }
        }
    }
    let is_end = |point: usize, cuts: &[Vec<usize>]| ends[point] && cuts[point].len() == 1;
    let mut open: Vec<usize> = (0..cuts.len())
        .filter(|&point| is_end(point, &cuts))
        .collect();
    while let Some(point) = open.pop() {
        if !is_end(point, &cuts) {
            continue;
        }
        let index = cuts[point][0];
        whole[index] = true;
        for point in points(surface, index) {
            cuts[point].retain(|other| *other != index);
            if is_end(point, &cuts) {
                open.push(point);
            }
        }
    }
    whole
}
