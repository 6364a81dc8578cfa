//! Lays the faces of a surface into the plane.

use std::collections::VecDeque;

use nalgebra::{Matrix2, Vector2};

use super::FoldedShape;
use super::angles::Creases;
use super::cuts;
use super::overlap::ConvexFaces;
use super::surface::{Side, Surface, SurfaceEdge};
use crate::pattern::{Drawing, DrawnEdge, Letter};
use crate::util::nan_max::diagonal;
use crate::util::union_find::UnionFind;

/// Largest number of rounds of fitting faces to vertices and vertices to faces. Each round spreads the shape's noise
/// over one more ring of faces.
const MAX_ROUNDS: usize = 200;

/// Largest movement that counts as none, as a fraction of the sheet's size.
const STILL_RATIO: f64 = 1e-15;

/// Space between parts, as a fraction of the sheet's size.
const SPACE_RATIO: f64 = 0.1;

/// Smallest overlap that is none, as a fraction of the sheet's size: errors of laying many faces one after the other.
const TOUCH_RATIO: f64 = 1e-9;

/// Largest tolerance of touching, as a fraction of the shortest edge.
const MAX_TOUCH_RATIO: f64 = 0.25;

/// Faces laid into the plane, and the edges that are whole.
pub(super) struct Layout {
    /// For each edge `true` if the sheet is whole across the edge.
    joined: Vec<bool>,
    /// For each corner the first corner at the same vertex of the flat sheet.
    points: Vec<usize>,
    /// Positions of these vertices at all corners.
    places: Vec<Vector2<f64>>,
    /// For each face the number of its piece. Different pieces share no edge of the flat sheet.
    pieces: Vec<usize>,
}

impl Layout {
    /// Lays the faces of each part, each across an edge, from a middle face outwards, by the number of the part's attempt.
    /// An edge that was not used stays whole if it ends a cut at a point without angle defect, or if both faces have its
    /// ends at the same places. The tolerance is `bound` (radians) times the length of the edge in parts without a
    /// boundary and parts with corners, where defects separate the faces. It is `bound` times the size of the sheet in
    /// other parts with a boundary, where noise adds up round a ring. In a plain sheet all edges stay whole.
    pub(super) fn new(
        shape: &FoldedShape,
        surface: &Surface,
        creases: &Creases,
        attempts: &[usize],
    ) -> Self {
        let (roots, levels) = levels(surface);
        let order = cuts::order(shape, surface, creases, &levels, attempts);
        let (laid, used) = lay(surface, &roots, &order);
        let closed_up = cuts::closed_up(surface, used);
        let size = diagonal(&laid);
        let joined = surface
            .edges
            .iter()
            .zip(closed_up)
            .map(|(edge, closed_up)| {
                let Some([a, b]) = edge.joint() else {
                    return false;
                };
                let part = surface.parts[a.face];
                let (a, b) = (surface.corners(a), surface.corners(b));
                let lever = if surface.closed[part] || surface.has_corners[part] {
                    (laid[a[1]] - laid[a[0]]).norm()
                } else {
                    size
                };
                closed_up || surface.is_plain(part) || meet(&laid, [a, b], surface.bound * lever)
            });
        Self::settled(surface, joined.collect(), surface.parts.clone(), laid)
    }

    /// Returns the depth to which faces may lie in each other and yet only touch.
    pub(super) fn touch(&self, surface: &Surface) -> f64 {
        let size = diagonal(&self.places);
        let errors = size * (TOUCH_RATIO + surface.noise()) + 4.0 * surface.length.unit();
        let lengths = surface.edges.iter().filter_map(|edge| {
            let [a, b] = surface.corners(edge.sides[0]?);
            Some((surface.local[b] - surface.local[a]).norm())
        });
        let shortest = lengths.fold(size, f64::min);
        errors.min(MAX_TOUCH_RATIO * shortest)
    }

    /// Returns two overlapping faces of a part.
    pub(super) fn overlap(
        &self,
        surface: &Surface,
        faces: &ConvexFaces,
        part: usize,
        touch: f64,
    ) -> Option<[usize; 2]> {
        let of_part = (0..surface.faces.len()).filter(|&face| surface.parts[face] == part);
        let overlaps = faces.overlaps(of_part, &self.places, touch, 1);
        overlaps.first().copied()
    }

    /// Takes pieces of a layout, in which each face belongs to one, at their places `laid`. An edge between two faces of
    /// a piece is whole if they meet there.
    pub(super) fn of_pieces(
        surface: &Surface,
        pieces: Vec<usize>,
        laid: Vec<Vector2<f64>>,
        touch: f64,
    ) -> Self {
        let joined = surface.edges.iter().map(|edge| {
            edge.joint().is_some_and(|[a, b]| {
                let ends = [a, b].map(|side| surface.corners(side));
                let length = (laid[ends[0][1]] - laid[ends[0][0]]).norm();
                let near = touch.max(surface.bound * length);
                pieces[a.face] == pieces[b.face] && meet(&laid, ends, near)
            })
        });
        Self::settled(surface, joined.collect(), pieces, laid)
    }

    /// Moves faces laid at these places so that those that are joined meet, and sets the pieces side by side.
    fn settled(
        surface: &Surface,
        joined: Vec<bool>,
        pieces: Vec<usize>,
        mut places: Vec<Vector2<f64>>,
    ) -> Self {
        let points = surface.points_where(&joined);
        settle(surface, &points, &mut places);
        set_side_by_side(surface, &pieces, &mut places);
        Self {
            joined,
            points,
            places,
            pieces,
        }
    }

    /// Returns for each edge `true` if the sheet is whole across it, for each face the number of its piece, and the places
    /// of all corners.
    pub(super) fn laid(&self) -> (&[bool], &[usize], &[Vector2<f64>]) {
        (&self.joined, &self.pieces, &self.places)
    }

    /// Returns the flat sheet, and for each of its vertices the vertex of the shape.
    pub(super) fn drawing(&self, surface: &Surface, creases: &Creases) -> (Drawing, Vec<usize>) {
        let (names, sources) = self.vertices(surface);
        let name = |corner: usize| names[self.points[corner]];
        let corners = sources.iter().map(|&(_, corner)| self.places[corner]);
        let mut drawing = Drawing {
            vertices: corners.collect(),
            ..Drawing::default()
        };
        let mut second_sides = Vec::new();
        for (index, edge) in surface.edges.iter().enumerate() {
            let ends = |side: Side| surface.corners(side).map(name);
            let mut sides = edge.sides.into_iter().flatten().map(ends);
            let Some(ends) = sides.next() else { continue };
            let other = sides.next().filter(|other| *other != ends);
            let letter = match (edge.sides[1], other) {
                // A cut whose faces share both its ends is a hinge.
                (Some(_), None) if !self.joined[index] => Letter::Unassigned,
                (Some(_), None) => creases.letters[index],
                _ => Letter::Boundary,
            };
            drawing.edges.push(DrawnEdge {
                ends,
                letter,
                goal: letter.is_hinge().then(|| creases.angles[index]),
            });
            second_sides.extend(other);
        }
        let second_sides = second_sides.into_iter().map(DrawnEdge::boundary);
        drawing.edges.extend(second_sides);
        let faces = 0..surface.faces.len();
        let cycle = |face| surface.cycle(face).into_iter().map(name).collect();
        drawing.faces = Some(faces.map(cycle).collect());
        (drawing, sources.into_iter().map(|(v, _)| v).collect())
    }

    /// Numbers the vertices of the flat sheet: first one for each vertex of the shape, in the shape's order, then those
    /// that cuts add. Returns the number at the index of each vertex's first corner, and for each number the vertex of
    /// the shape and that first corner.
    fn vertices(&self, surface: &Surface) -> (Vec<usize>, Vec<(usize, usize)>) {
        let vertices = surface.corner_vertices().enumerate();
        let firsts = vertices.filter(|(corner, _)| self.points[*corner] == *corner);
        let mut sources: Vec<(usize, usize)> = firsts.map(|(corner, v)| (v, corner)).collect();
        sources.sort_unstable();
        let mut added = Vec::new();
        let mut before = None;
        sources.retain(|&(vertex, corner)| {
            let new = before != Some(vertex);
            before = Some(vertex);
            if !new {
                added.push((vertex, corner));
            }
            new
        });
        sources.append(&mut added);
        let mut names = vec![usize::MAX; self.points.len()];
        for (name, &(_, corner)) in sources.iter().enumerate() {
            names[corner] = name;
        }
        (names, sources)
    }

    /// Returns the number of edges that are whole in the file and cut in the layout.
    pub(super) fn cuts(&self, surface: &Surface) -> usize {
        self.cut_edges(surface).count()
    }

    fn cut_edges<'a>(&'a self, surface: &'a Surface) -> impl Iterator<Item = &'a SurfaceEdge> {
        let edges = surface.edges.iter().zip(&self.joined);
        let cut = edges.filter(|(edge, joined)| edge.joint().is_some() && !**joined);
        cut.map(|(edge, _)| edge)
    }

    /// Returns the number of pieces.
    pub(super) fn pieces(&self) -> usize {
        count_of(&self.pieces)
    }

    /// Returns the first edge that is whole in the file and cut in the layout, by its ends.
    pub(super) fn first_cut(&self, surface: &Surface) -> Option<[usize; 2]> {
        self.cut_edges(surface).next().map(|edge| edge.ends)
    }

    /// Returns notes of the cuts and of separate parts.
    pub(super) fn notes(&self, surface: &Surface) -> Vec<String> {
        let mut notes = Vec::new();
        if let Some(first) = self.first_cut(surface) {
            notes.push(format!(
                "no plane holds the shape whole, so that it is cut along edges; their second sides come behind \
                 all other edges: {} (first: {})",
                self.cuts(surface),
                edge_name(first)
            ));
        }
        let pieces = self.pieces();
        if pieces > surface.parts() {
            notes.push(format!(
                "no way to cut was found that keeps each part whole and lies flat without an overlap: pieces, laid side \
                 by side: {pieces}"
            ));
        }
        if surface.parts() > 1 {
            notes.push(format!(
                "parts that no edge joins, laid side by side: {}",
                surface.parts()
            ));
        }
        notes
    }
}

/// Formats an edge for messages.
pub(super) fn edge_name([a, b]: [usize; 2]) -> String {
    format!("from vertex {a} to {b}")
}

/// Returns a middle face of each part, and for each face the number of edges on the shortest path from that middle
/// face.
fn levels(surface: &Surface) -> (Vec<usize>, Vec<usize>) {
    let neighbours = surface.neighbours();
    let count = surface.faces.len();
    let mut roots = Vec::new();
    let mut levels = vec![usize::MAX; count];
    let mut scratch = vec![usize::MAX; count];
    for start in 0..count {
        if levels[start] != usize::MAX {
            continue;
        }
        // The middle of a longest path, or a face near it. One end of the path is the face farthest from the first
        // face, the other end is the face farthest from that one.
        let far = last(&breadth_first(&neighbours, start, &mut scratch));
        let forth = breadth_first(&neighbours, far, &mut scratch);
        let mut middle = last(&forth);
        let depth = scratch[middle];
        while scratch[middle] > depth / 2 {
            let nearer = |(face, _): &&(usize, bool)| scratch[*face] < scratch[middle];
            match neighbours[middle].iter().find(nearer) {
                Some(&(face, _)) => middle = face,
                None => break,
            }
        }
        roots.push(middle);
        for face in breadth_first(&neighbours, middle, &mut scratch) {
            levels[face] = scratch[face];
        }
    }
    (roots, levels)
}

fn last(order: &[usize]) -> usize {
    order.last().copied().unwrap_or(0)
}

/// Returns the faces of a part in breadth-first order from `start`, and stores in `distance` each face's number of
/// steps.
fn breadth_first(
    neighbours: &[Vec<(usize, bool)>],
    start: usize,
    distance: &mut [usize],
) -> Vec<usize> {
    let mut order = vec![start];
    let mut next = 0;
    // Resets the distances that an earlier search of the part stored.
    let mut part = vec![start];
    distance[start] = usize::MAX;
    while let Some(face) = part.pop() {
        for &(other, _) in &neighbours[face] {
            if distance[other] != usize::MAX {
                distance[other] = usize::MAX;
                part.push(other);
            }
        }
    }
    distance[start] = 0;
    while let Some(&face) = order.get(next) {
        next += 1;
        for &(other, _) in &neighbours[face] {
            if distance[other] == usize::MAX {
                distance[other] = distance[face] + 1;
                order.push(other);
            }
        }
    }
    order
}

/// Returns the positions of all corners with each face laid across one edge, and marks these edges. Edges join faces in
/// the given order, as long as they close no ring.
fn lay(surface: &Surface, roots: &[usize], order: &[usize]) -> (Vec<Vector2<f64>>, Vec<bool>) {
    let count = surface.faces.len();
    let mut groups = UnionFind::new(count);
    let mut used = vec![false; surface.edges.len()];
    let mut beyond = vec![Vec::new(); count];
    for &index in order {
        let Some([a, b]) = surface.edges[index].joint() else {
            continue;
        };
        if groups.join([b.face, a.face]) {
            used[index] = true;
            beyond[a.face].push((a, b));
            beyond[b.face].push((b, a));
        }
    }
    let mut laid = surface.local.to_vec();
    let mut done = vec![false; count];
    for &root in roots {
        done[root] = true;
        let mut open = VecDeque::from([root]);
        while let Some(face) = open.pop_front() {
            for &(here, there) in &beyond[face] {
                if done[there.face] {
                    continue;
                }
                done[there.face] = true;
                open.push_back(there.face);
                let places = surface.corners(here).map(|corner| laid[corner]);
                let ends = surface.corners(there).map(|corner| surface.local[corner]);
                let motion = Motion::fit(ends.into_iter().zip(places));
                for corner in surface.corner_range(there.face) {
                    laid[corner] = motion.apply(surface.local[corner]);
                }
            }
        }
    }
    (laid, used)
}

/// Returns `true` if the corners of two faces at the ends of their edge are no farther apart than `near`.
fn meet(laid: &[Vector2<f64>], [a, b]: [[usize; 2]; 2], near: f64) -> bool {
    let mut ends = a.into_iter().zip(b);
    ends.all(|(a, b)| (laid[a] - laid[b]).norm() <= near)
}

/// Moves corners of the same vertex to one place by alternating two fits: each vertex moves to the mean of its corners,
/// then each face moves rigidly to fit its vertices best.
fn settle(surface: &Surface, points: &[usize], laid: &mut [Vector2<f64>]) {
    let still = STILL_RATIO * diagonal(laid);
    let mut counts = vec![0.0; points.len()];
    for &point in points {
        counts[point] += 1.0;
    }
    for round in 0..=MAX_ROUNDS {
        let mut sums = vec![Vector2::zeros(); points.len()];
        for (&point, place) in points.iter().zip(laid.iter()) {
            sums[point] += place;
        }
        let mut moved = 0.0_f64;
        for (corner, &point) in points.iter().enumerate() {
            let mean = sums[point] / counts[point];
            moved = moved.max((mean - laid[corner]).norm());
            laid[corner] = mean;
        }
        if moved <= still || round == MAX_ROUNDS {
            return;
        }
        for face in 0..surface.faces.len() {
            let range = surface.corner_range(face);
            let local = &surface.local[range.clone()];
            let places = laid[range.clone()].iter().copied();
            let motion = Motion::fit(local.iter().copied().zip(places));
            for corner in range {
                laid[corner] = motion.apply(surface.local[corner]);
            }
        }
    }
}

/// Returns the number of pieces, given that of each face.
fn count_of(pieces: &[usize]) -> usize {
    pieces.iter().max().map_or(0, |last| last + 1)
}

/// Moves the pieces beside each other along x; the first piece stays. `pieces` has for each face the number of its piece.
fn set_side_by_side(surface: &Surface, pieces: &[usize], laid: &mut [Vector2<f64>]) {
    let count = count_of(pieces);
    if count < 2 {
        return;
    }
    let space = SPACE_RATIO * diagonal(laid);
    let mut bounds = vec![[f64::INFINITY, f64::NEG_INFINITY]; count];
    for (face, &piece) in pieces.iter().enumerate() {
        for corner in surface.corner_range(face) {
            let [low, high] = &mut bounds[piece];
            *low = low.min(laid[corner].x);
            *high = high.max(laid[corner].x);
        }
    }
    let mut shifts = vec![0.0; bounds.len()];
    let mut end = bounds[0][1];
    for (shift, [low, high]) in shifts.iter_mut().zip(&bounds).skip(1) {
        *shift = end + space - low;
        end = high + *shift;
    }
    for (face, &piece) in pieces.iter().enumerate() {
        for corner in surface.corner_range(face) {
            laid[corner].x += shifts[piece];
        }
    }
}

/// A rigid motion of the plane.
pub(super) struct Motion {
    rotation: Matrix2<f64>,
    from: Vector2<f64>,
    to: Vector2<f64>,
}

impl Motion {
    /// Returns the motion that takes the first points of the pairs to the second with the least sum of squared
    /// distances (rigid registration).
    pub(super) fn fit(pairs: impl Iterator<Item = (Vector2<f64>, Vector2<f64>)> + Clone) -> Self {
        let count = pairs.clone().fold(0.0, |count, _| count + 1.0);
        let sums = pairs.clone().fold(
            (Vector2::zeros(), Vector2::zeros()),
            |(from, to): (Vector2<f64>, Vector2<f64>), (a, b)| (from + a, to + b),
        );
        let (from, to) = (sums.0 / count, sums.1 / count);
        let turn = pairs.fold(Vector2::zeros(), |turn: Vector2<f64>, (a, b)| {
            let (a, b) = (a - from, b - to);
            turn + Vector2::new(a.dot(&b), a.perp(&b))
        });
        let turn = turn.try_normalize(0.0).unwrap_or_else(Vector2::x);
        Self {
            rotation: Matrix2::new(turn.x, -turn.y, turn.y, turn.x),
            from,
            to,
        }
    }

    pub(super) fn apply(&self, point: Vector2<f64>) -> Vector2<f64> {
        self.rotation * (point - self.from) + self.to
    }
}
