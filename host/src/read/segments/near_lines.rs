//! Vertices that lie near a line which they do not meet. People who draw with few digits leave them where lines were meant
//! to meet.

use nalgebra::Vector2;

use super::grid::Grid;
use super::open_ends::distance;
use super::planar::{Looks, line};
use crate::pattern::DrawnEdge;

/// Largest distance of such a vertex from its line, in usual tolerances.
const MAX_TOLERANCES: f64 = 10.0;

/// Largest ratio of such a distance to the least in the drawing. Vertices that are farther away are drawn so on purpose.
const MAX_RATIO: f64 = 4.0;

/// Vertices that lie near a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Misses {
    pub(super) count: usize,
    /// Distance of the nearest from its line.
    pub(super) apart: f64,
    /// Place of the nearest.
    pub(super) at: Vector2<f64>,
    /// Distance within which vertices count as near.
    pub(super) within: f64,
}

/// Returns the vertices that lie near a line of a repaired drawing without being its ends, if the line or a line at the
/// vertex is a crease. Returns `None` if there are none, or the budget of proximity tests is used up.
pub(super) fn misses(
    points: &[Vector2<f64>],
    pieces: &[DrawnEdge],
    usual_tolerance: f64,
    looks: &mut Looks<'_>,
) -> Option<Misses> {
    let within = MAX_TOLERANCES * usual_tolerance;
    // Places at which no line ends any more do not count.
    let mut is_end = vec![false; points.len()];
    let mut is_crease_end = vec![false; points.len()];
    let is_crease = |piece: &DrawnEdge| !piece.letter.parts();
    for piece in pieces {
        for end in piece.ends {
            is_end[end] = true;
            is_crease_end[end] |= is_crease(piece);
        }
    }
    let (grid, cells) = Grid::of_points(points, within);
    let mut near = vec![f64::INFINITY; points.len()];
    for piece in pieces {
        let line = line(points, piece);
        grid.along(line, within, |cell| {
            looks.take(1 + cells[cell].len());
            for &vertex in &cells[cell] {
                let counts = is_end[vertex] && (is_crease(piece) || is_crease_end[vertex]);
                if counts && !piece.ends.contains(&vertex) {
                    near[vertex] = near[vertex].min(distance(line, points[vertex]));
                }
            }
        });
        if looks.are_used_up() {
            return None;
        }
    }
    let (at, apart) = near
        .iter()
        .copied()
        .enumerate()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, apart)| *apart <= within)?;
    let within = within.min(MAX_RATIO * apart);
    Some(Misses {
        count: near.iter().filter(|apart| **apart <= within).count(),
        apart,
        at: points[at],
        within,
    })
}
