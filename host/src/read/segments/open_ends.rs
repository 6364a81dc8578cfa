//! Open ends: ends of lines at which no other line ends. They are joined to the vertex or line that they were meant to
//! meet; lines whose ends stay open are removed.

use nalgebra::Vector2;

use super::grid::Grid;
use super::places::Places;
use super::planar::{Looks, foot, grid_of_lines, line};
use super::repairs::Repairs;
use crate::pattern::{DrawnEdge, Letter};
use crate::util::csr::group_by_key;
use crate::util::union_find::UnionFind;

/// Largest distance of an open end from the one vertex or line that it was meant to meet, as a fraction of its own
/// line.
const MAX_OF_LINE_RATIO: f64 = 0.05;

/// Largest distance of an open end from that vertex or line, as a fraction of the diagonal. Origami Simulator joins
/// points within 3 pixels, in drawings of about a thousand pixels.
pub(super) const MAX_OF_DIAGONAL_RATIO: f64 = 1.0 / 300.0;

/// Smallest ratio of the distances to the second and to the nearest candidate with which the nearest is the only one.
const MIN_APART_RATIO: f64 = 2.0;

/// Largest distance by which an open end of this line is moved in a drawing of this diagonal.
fn reach([a, b]: [Vector2<f64>; 2], diagonal: f64) -> f64 {
    (MAX_OF_LINE_RATIO * (b - a).norm()).min(MAX_OF_DIAGONAL_RATIO * diagonal)
}

/// Returns the number of lines that end at each vertex.
pub(super) fn degrees(vertices: usize, pieces: &[DrawnEdge]) -> Vec<usize> {
    let mut degrees = vec![0; vertices];
    for end in pieces.iter().flat_map(|piece| piece.ends) {
        degrees[end] += 1;
    }
    degrees
}

/// Joins each open end to the only vertex that it can have been meant to meet. The vertex must lie within a twentieth
/// of the line's length and within [`MAX_OF_DIAGONAL_RATIO`] of the diagonal, and the next vertex must be at least twice
/// as far. A line that goes too far past another leaves a short open end, which stays open and is left out later. Returns
/// `true` if any end was joined, and `None` if the budget of proximity tests is used up.
pub(super) fn join_to_vertices(
    places: &mut Places,
    pieces: &mut [DrawnEdge],
    diagonal: f64,
    repairs: &mut Repairs,
    looks: &mut Looks<'_>,
) -> Option<bool> {
    let degrees = degrees(places.points.len(), pieces);
    let (grid, cells) = Grid::of_points(&places.points, MAX_OF_DIAGONAL_RATIO * diagonal);
    let before = repairs.to_vertices.count;
    for piece in pieces {
        let reach = reach(line(&places.points, piece), diagonal);
        for side in 0..2 {
            let (end, other) = (piece.ends[side], piece.ends[1 - side]);
            if degrees[end] != 1 {
                continue;
            }
            let at = places.points[end];
            let mut near = Nearest::apart(MIN_APART_RATIO);
            grid.along([at; 2], 2.0 * reach, |cell| {
                looks.take(1 + cells[cell].len());
                for &vertex in &cells[cell] {
                    if degrees[vertex] >= 2 && vertex != other {
                        near.add((places.points[vertex] - at).norm(), vertex);
                    }
                }
            });
            if let Some((distance, vertex)) = near.only(reach) {
                piece.ends[side] = vertex;
                places.retire(end);
                repairs.to_vertices.add(distance, places.points[vertex]);
            }
        }
        if looks.are_used_up() {
            return None;
        }
    }
    Some(repairs.to_vertices.count > before)
}

/// Distances from an open end within which it is joined to a line.
pub(super) enum LineReach {
    /// The nearest line, within the tolerance that the caller asked for.
    Asked(f64),
    /// The only line near the end, in a drawing of this diagonal.
    Only { diagonal: f64 },
}

/// Joins each open end to the line that it was meant to meet: prolongs its own line, or shortens it, up to the other
/// one, or moves the end to the nearest point of the other if both lines are nearly parallel. Ends within `close` of a
/// line count as joined already. Returns `true` if any end was moved, and `None` if the budget of proximity tests is
/// used up.
pub(super) fn join_to_lines(
    places: &mut Places,
    pieces: &mut [DrawnEdge],
    close: f64,
    within: &LineReach,
    repairs: &mut Repairs,
    looks: &mut Looks<'_>,
) -> Option<bool> {
    let mut degrees = degrees(places.points.len(), pieces);
    let is_open = |piece: &DrawnEdge| piece.ends.iter().any(|&end| degrees[end] == 1);
    if !pieces.iter().any(is_open) {
        return Some(false);
    }
    let least = match *within {
        LineReach::Asked(tolerance) => tolerance,
        LineReach::Only { diagonal } => MAX_OF_DIAGONAL_RATIO * diagonal,
    };
    let (grid, covered) = grid_of_lines(&places.points, pieces, least);
    let before = repairs.to_lines.count;
    for index in 0..pieces.len() {
        let own = line(&places.points, &pieces[index]);
        let (reach, apart) = match *within {
            LineReach::Asked(tolerance) => (tolerance, 0.0),
            LineReach::Only { diagonal } => (reach(own, diagonal), MIN_APART_RATIO),
        };
        for side in 0..2 {
            let ends = pieces[index].ends;
            let (end, other) = (ends[side], ends[1 - side]);
            if degrees.get(end) != Some(&1) {
                continue;
            }
            let [at, from] = [places.points[end], places.points[other]];
            let mut near = Nearest::apart(apart);
            grid.along([at; 2], MIN_APART_RATIO * reach, |cell| {
                looks.take(1 + covered[cell].len());
                for &candidate in &covered[cell] {
                    // A line from the other end is no goal: the end would be laid upon it.
                    let meets = pieces[candidate].ends;
                    if candidate != index && !meets.contains(&end) && !meets.contains(&other) {
                        let [a, b] = line(&places.points, &pieces[candidate]);
                        near.add(distance([a, b], at), candidate);
                    }
                }
            });
            if looks.are_used_up() {
                return None;
            }
            let Some((distance, found)) = near.only(reach) else {
                continue;
            };
            if distance <= close {
                continue;
            }
            let to = meeting([from, at], line(&places.points, &pieces[found]), reach);
            let vertex = places.moved(end, to);
            // A line no longer than the tolerance keeps its retired end, which is removed with the line.
            if vertex != other {
                pieces[index].ends[side] = vertex;
                degrees[vertex] += usize::from(vertex != end);
                repairs
                    .to_lines
                    .add((places.points[vertex] - at).norm(), to);
            }
        }
    }
    Some(repairs.to_lines.count > before)
}

/// Returns the distance of a point from a line.
pub(super) fn distance([a, b]: [Vector2<f64>; 2], point: Vector2<f64>) -> f64 {
    let (along, aside, length) = foot([a, b], point);
    if along <= 0.0 {
        (point - a).norm()
    } else if along >= length {
        (point - b).norm()
    } else {
        aside
    }
}

/// Returns the point of the line from `a` to `b` in which the line from `from` to `at` meets it, if that is within
/// `reach` of `at`; or else the point nearest to `at`.
fn meeting([from, at]: [Vector2<f64>; 2], [a, b]: [Vector2<f64>; 2], reach: f64) -> Vector2<f64> {
    let (own, along) = (at - from, b - a);
    // The fraction of the line from `a` to `b`; not finite if the lines are parallel.
    let part = (from - a).perp(&own) / along.perp(&own);
    let met = a + along * part;
    if (0.0..=1.0).contains(&part) && (met - at).norm() <= reach {
        return met;
    }
    let nearest = (at - a).dot(&along) / along.norm_squared();
    a + along * nearest.clamp(0.0, 1.0)
}

/// The nearest of several candidates, and the distance of the second.
struct Nearest {
    nearest: (f64, Option<usize>),
    second: f64,
    apart: f64,
}

impl Nearest {
    /// Accepts a candidate if the second is at least `apart` times as far.
    fn apart(apart: f64) -> Self {
        Self {
            nearest: (f64::INFINITY, None),
            second: f64::INFINITY,
            apart,
        }
    }

    /// Adds a candidate; one that is added again changes nothing.
    fn add(&mut self, distance: f64, candidate: usize) {
        if self.nearest.1 == Some(candidate) {
            return;
        }
        if distance < self.nearest.0 {
            self.second = self.nearest.0;
            self.nearest = (distance, Some(candidate));
        } else if distance < self.second {
            self.second = distance;
        }
    }

    /// Returns the distance of the nearest candidate and the candidate, if it is within `reach` and the only one.
    fn only(&self, reach: f64) -> Option<(f64, usize)> {
        let (distance, candidate) = self.nearest;
        let is_only = distance <= reach && self.second >= self.apart * distance;
        candidate.filter(|_| is_only).map(|it| (distance, it))
    }
}

/// Lines that were removed because they end in the open.
#[derive(Default)]
pub(super) struct Removed {
    pub(super) count: usize,
    /// Place of the first open end.
    pub(super) open_end: Vector2<f64>,
    /// Length of the longest line.
    pub(super) longest: f64,
}

impl Removed {
    fn add(&mut self, [a, b]: [Vector2<f64>; 2], open_end: Vector2<f64>) {
        if self.count == 0 {
            self.open_end = open_end;
        }
        self.count += 1;
        self.longest = self.longest.max((b - a).norm());
    }
}

/// Removes lines with an end at which no other line ends, again and again. Returns the cuts among them that part nothing,
/// and the other lines.
pub(super) fn remove_open(
    points: &[Vector2<f64>],
    pieces: &mut Vec<DrawnEdge>,
) -> [Option<Removed>; 2] {
    let pairs: Vec<(usize, usize)> = pieces
        .iter()
        .enumerate()
        .flat_map(|(index, piece)| piece.ends.map(|end| (end, index)))
        .collect();
    let stars = group_by_key(points.len(), &pairs);
    let drawn: Vec<usize> = stars.iter().map(<[usize]>::len).collect();
    let mut degrees = drawn.clone();
    let mut open: Vec<usize> = (0..points.len()).filter(|&v| degrees[v] == 1).collect();
    let mut removed = vec![false; pieces.len()];
    while let Some(vertex) = open.pop() {
        for &index in stars[vertex].iter().filter(|_| degrees[vertex] == 1) {
            if removed[index] {
                continue;
            }
            removed[index] = true;
            for end in pieces[index].ends {
                degrees[end] -= 1;
                if degrees[end] == 1 && end != vertex {
                    open.push(end);
                }
            }
            break;
        }
    }
    let slits = slits(pieces, &removed, &degrees);
    let mut lines = [Removed::default(), Removed::default()];
    for (index, piece) in pieces
        .iter()
        .enumerate()
        .filter(|(index, _)| removed[*index])
    {
        let is_open = |end: &&usize| drawn[**end] == 1;
        let end = piece.ends.iter().find(is_open).unwrap_or(&piece.ends[0]);
        lines[usize::from(!slits[index])].add(line(points, piece), points[*end]);
    }
    let mut removed = removed.into_iter();
    pieces.retain(|_| !removed.next().unwrap_or_default());
    lines.map(|lines| (lines.count > 0).then_some(lines))
}

/// Tells which removed lines are slits: cuts, and borders that no line joins to what is left of the drawing or to a crease.
/// `degrees` has the number of lines that are left at each vertex.
fn slits(pieces: &[DrawnEdge], removed: &[bool], degrees: &[usize]) -> Vec<bool> {
    let gone = || {
        pieces
            .iter()
            .enumerate()
            .filter(|(index, _)| removed[*index])
    };
    let mut joined = UnionFind::new(degrees.len());
    for (_, piece) in gone() {
        joined.join(piece.ends);
    }
    let mut is_held = vec![false; degrees.len()];
    for (_, piece) in gone() {
        for end in piece.ends {
            let root = joined.find(end);
            is_held[root] |= !piece.letter.parts() || degrees[end] > 0;
        }
    }
    let mut slits = vec![false; pieces.len()];
    for (index, piece) in gone() {
        slits[index] = match piece.letter {
            Letter::Cut => true,
            Letter::Boundary => !is_held[joined.find(piece.ends[0])],
            _ => false,
        };
    }
    slits
}
