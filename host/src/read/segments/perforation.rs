//! Creases drawn in pieces, as a perforation is: pieces on one line, with gaps between them, become one line.

use std::collections::HashMap;

use nalgebra::Vector2;

use super::grid::Grid;
use super::open_ends::degrees;
use super::places::Places;
use super::planar::{Looks, grid_of_lines, line};
use super::repairs::Repairs;
use crate::pattern::DrawnEdge;

/// Largest gap between two pieces, in lengths of the longer of them.
const MAX_GAP_RATIO: f64 = 2.0;

/// Largest gap between the last piece and the line that it was meant to reach, in the largest gap between the pieces: a
/// perforation may end with any part of a gap.
const MAX_LAST_GAP_RATIO: f64 = 1.5;

/// Largest sine of the angle between two pieces, or between a piece and the gap.
const MAX_BEND_SINE: f64 = 0.02;

/// Number of pieces that became lines.
#[derive(Clone, Copy, Default)]
pub(super) struct Perforations {
    pub(super) pieces: usize,
    pub(super) lines: usize,
    pub(super) largest_gap: f64,
}

/// An end of a piece at which no other line ends.
struct OpenEnd {
    vertex: usize,
    piece: usize,
    at: Vector2<f64>,
    /// Unit direction out of the piece.
    out: Vector2<f64>,
    length: f64,
}

/// Joins pieces of creases with one letter and goal that lie on one line, the nearest ends first, and prolongs the joined
/// line at both ends over a last gap. Returns `true` if any pieces were joined, and `None` if the budget of proximity tests is
/// used up.
pub(super) fn join_pieces(
    places: &mut Places,
    pieces: &mut Vec<DrawnEdge>,
    repairs: &mut Repairs,
    looks: &mut Looks<'_>,
) -> Option<bool> {
    let ends = open_ends(&places.points, pieces);
    let links = links(&ends, pieces, places.tolerance, looks)?;
    if links.is_empty() {
        return Some(false);
    }
    let mut piece_at: HashMap<usize, usize> =
        ends.iter().map(|end| (end.vertex, end.piece)).collect();
    let mut gone = vec![false; pieces.len()];
    // For each piece the number of pieces in it and its largest gap.
    let mut joined = vec![(1, 0.0_f64); pieces.len()];
    for (gap, [one, other]) in links {
        let [Some(&kept), Some(&taken)] = [one, other].map(|end| piece_at.get(&end)) else {
            continue;
        };
        if kept == taken {
            continue;
        }
        let far = |piece: usize, end: usize| {
            let [a, b] = pieces[piece].ends;
            if a == end { b } else { a }
        };
        let ends = [far(kept, one), far(taken, other)];
        pieces[kept].ends = ends;
        if let Some(piece) = piece_at.get_mut(&ends[1]) {
            *piece = kept;
        }
        for end in [one, other] {
            piece_at.remove(&end);
            places.retire(end);
        }
        gone[taken] = true;
        let before = joined[taken];
        joined[kept].0 += before.0;
        joined[kept].1 = joined[kept].1.max(before.1).max(gap);
    }
    let mut index = 0;
    let kept = |_: &DrawnEdge| {
        index += 1;
        !gone[index - 1]
    };
    pieces.retain(kept);
    let joined = joined.into_iter().zip(gone).filter(|(_, gone)| !gone);
    let joined: Vec<(usize, f64)> = joined.map(|(joined, _)| joined).collect();
    for &(count, gap) in joined.iter().filter(|(count, _)| *count > 1) {
        repairs.perforations.pieces += count;
        repairs.perforations.lines += 1;
        repairs.perforations.largest_gap = repairs.perforations.largest_gap.max(gap);
    }
    prolong(places, pieces, &joined, looks)?;
    Some(true)
}

fn open_ends(points: &[Vector2<f64>], pieces: &[DrawnEdge]) -> Vec<OpenEnd> {
    let degrees = degrees(points.len(), pieces);
    let creases = pieces.iter().enumerate();
    let creases = creases.filter(|(_, piece)| piece.letter.is_hinge());
    let ends = creases.flat_map(|(index, piece)| {
        let [a, b] = piece.ends;
        let open = [[a, b], [b, a]]
            .into_iter()
            .filter(|[end, _]| degrees[*end] == 1);
        open.map(move |[end, other]| {
            let along = points[end] - points[other];
            OpenEnd {
                vertex: end,
                piece: index,
                at: points[end],
                out: along.normalize(),
                length: along.norm(),
            }
        })
    });
    ends.collect()
}

/// Returns the pairs of ends between which a gap may be closed, each with the gap, from small to large.
fn links(
    ends: &[OpenEnd],
    pieces: &[DrawnEdge],
    tolerance: f64,
    looks: &mut Looks<'_>,
) -> Option<Vec<(f64, [usize; 2])>> {
    let points: Vec<_> = ends.iter().map(|end| end.at).collect();
    let (grid, cells) = Grid::of_points(&points, tolerance);
    let is_alike = |a: &DrawnEdge, b: &DrawnEdge| a.letter == b.letter && a.goal == b.goal;
    let mut links = Vec::new();
    for one in ends {
        let reach = MAX_GAP_RATIO * one.length;
        grid.along([one.at, one.at + one.out * reach], tolerance, |cell| {
            looks.take(1 + cells[cell].len());
            for other in cells[cell].iter().map(|&index| &ends[index]) {
                let gap = (other.at - one.at).norm();
                let aside = one.out.perp(&(other.at - one.at)).abs();
                let bend = MAX_BEND_SINE + tolerance / one.length.min(other.length);
                let faces = one.out.dot(&other.out) < 0.0
                    && one.out.perp(&other.out).abs() <= bend
                    && one.out.dot(&(other.at - one.at)) > 0.0
                    && aside <= tolerance + MAX_BEND_SINE * gap;
                if faces
                    && one.piece != other.piece
                    && gap <= reach
                    && is_alike(&pieces[one.piece], &pieces[other.piece])
                {
                    links.push((gap, [one.vertex, other.vertex]));
                }
            }
        });
        if looks.are_used_up() {
            return None;
        }
    }
    links.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    Some(links)
}

/// Prolongs joined lines whose ends are open to the first line in their way, if that is no farther than a last gap.
fn prolong(
    places: &mut Places,
    pieces: &mut [DrawnEdge],
    joined: &[(usize, f64)],
    looks: &mut Looks<'_>,
) -> Option<()> {
    let ends = open_ends(&places.points, pieces);
    let (grid, covered) = grid_of_lines(&places.points, pieces, 0.0);
    for end in ends {
        let (count, gap) = joined[end.piece];
        if count < 2 {
            continue;
        }
        let reach = MAX_LAST_GAP_RATIO * gap;
        let mut nearest = reach;
        let way = end.out * reach;
        grid.along([end.at, end.at + way], 0.0, |cell| {
            looks.take(1 + covered[cell].len());
            for &other in covered[cell].iter().filter(|&&other| other != end.piece) {
                let [a, b] = line(&places.points, &pieces[other]);
                let across = b - a;
                let turn = end.out.perp(&across);
                let [along, part] = [across, end.out].map(|by| (a - end.at).perp(&by) / turn);
                if (0.0..=1.0).contains(&part) && along > 0.0 && along < nearest {
                    nearest = along;
                }
            }
        });
        if looks.are_used_up() {
            return None;
        }
        if nearest < reach {
            let to = places.moved(end.vertex, end.at + end.out * nearest);
            let piece = &mut pieces[end.piece];
            let side = usize::from(piece.ends[0] != end.vertex);
            if piece.ends[1 - side] != to {
                piece.ends[side] = to;
            }
        }
    }
    Some(())
}
