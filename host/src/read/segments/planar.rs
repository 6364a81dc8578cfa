//! Makes a planar drawing of lines: splits them at crossings, keeps duplicates once and joins open
//! ends.
//!
//! Crossings are found in a uniform grid and decided by exact orientation predicates (crate `robust`).

use std::collections::HashMap;

use nalgebra::Vector2;
use robust::{Coord, orient2d};

use super::grid::Grid;
use super::missing_border::missing_borders;
use super::near_lines::misses;
use super::open_ends::{
    LineReach, MAX_OF_DIAGONAL_RATIO, join_to_lines, join_to_vertices, remove_open,
};
use super::perforation::join_pieces;
use super::places::Places;
use super::repairs::Repairs;
use super::{MAX_LINES, Segment};
use crate::pattern::{Drawing, DrawnEdge, Letter};
use crate::progress::Watch;
use crate::straighten::{self, ROUNDING_RATIO};
use crate::util::csr::{Csr, group_by_key};
use crate::util::nan_max::{bounding_box, median};

/// Budget of proximity tests: the first number for each line, but in all at least the second. If all lines are in one
/// place, each is near all others. Tessellations need some hundreds for each line.
const MAX_LOOKS: [usize; 2] = [1 << 11, 1 << 28];

/// Largest number of rounds of splitting. A split moves lines by up to the tolerance, which may make them cross anew.
const MAX_SPLITTING_ROUNDS: usize = 8;

/// Largest number of rounds of joining open ends. An end that is joined may move a line to which another end was joined.
const MAX_JOINING_ROUNDS: usize = 4;

/// Precedence of a letter where lines lie on each other; the line of the highest precedence is kept. A border ranks
/// below creases: on the rim the faces alone show that it is a border, and inside the sheet the line drawn to be cut or
/// folded is the intended one.
pub(in crate::read) fn weight(letter: Letter) -> u8 {
    match letter {
        Letter::Cut => 4,
        Letter::Mountain | Letter::Valley => 3,
        Letter::Unassigned => 2,
        Letter::Boundary => 1,
        Letter::Flat | Letter::Join | Letter::Bend => 0,
    }
}

/// Makes a planar drawing of the segments and counts the repairs. `rounding` is the largest distance of an end from the
/// place where it was drawn; `asked` is the tolerance if the caller chose one. Returns `None` if there are too many lines
/// or the budget of proximity tests is used up.
pub(super) fn planar(
    segments: Vec<Segment>,
    rounding: f64,
    asked: Option<f64>,
    watch: Watch<'_>,
) -> Option<(Drawing, Repairs)> {
    if segments.len() > MAX_LINES {
        return None;
    }
    let ends = segments.iter().flat_map(|segment| segment.ends);
    let (low, high) = bounding_box(ends).unwrap_or_default();
    let diagonal = (high - low).norm();
    let usual = usual_tolerance(&segments, diagonal).max(4.0 * rounding);
    // Differences within rounding are no differences, whatever the caller chose.
    let least = (ROUNDING_RATIO * diagonal).max(4.0 * rounding);
    let tolerance = asked.map_or(usual, |asked| asked.max(least));
    let mut repairs = Repairs {
        tolerance,
        usual_tolerance: usual,
        ..Repairs::default()
    };
    let (mut places, mut pieces) =
        merged_ends(&segments, Places::new(tolerance, low), &mut repairs);
    drop(segments);
    deduplicate(&mut pieces, &mut repairs);
    let mut looks = Looks::for_lines(pieces.len(), watch);
    if tolerance > usual {
        // Ends are moved to lines: within so large a tolerance, lines split at ends beside them would be bent.
        let within = LineReach::Asked(tolerance);
        join_to_lines(
            &mut places,
            &mut pieces,
            usual,
            &within,
            &mut repairs,
            &mut looks,
        )?;
        pieces.retain(|piece| piece.ends[0] != piece.ends[1]);
    }
    cut_up(&mut places, &mut pieces, &mut repairs, &mut looks)?;
    if join_pieces(&mut places, &mut pieces, &mut repairs, &mut looks)? {
        deduplicate(&mut pieces, &mut repairs);
        cut_up(&mut places, &mut pieces, &mut repairs, &mut looks)?;
    }
    for _ in 0..MAX_JOINING_ROUNDS {
        let to_vertices =
            join_to_vertices(&mut places, &mut pieces, diagonal, &mut repairs, &mut looks)?;
        let within = LineReach::Only { diagonal };
        let to_lines = join_to_lines(
            &mut places,
            &mut pieces,
            tolerance,
            &within,
            &mut repairs,
            &mut looks,
        )?;
        if !to_vertices && !to_lines {
            break;
        }
        deduplicate(&mut pieces, &mut repairs);
        cut_up(&mut places, &mut pieces, &mut repairs, &mut looks)?;
    }
    // Each crossing has split at least two lines.
    repairs.passed = repairs.passed.saturating_sub(2 * repairs.crossings);
    repairs.missing_borders = missing_borders(
        &places.points,
        &pieces,
        2.0 * tolerance,
        MAX_OF_DIAGONAL_RATIO * diagonal,
    );
    [repairs.slits, repairs.removed] = remove_open(&places.points, &mut pieces);
    repairs.misses = misses(&places.points, &pieces, usual, &mut looks);
    Some((drawing(&places.points, pieces), repairs))
}

/// Makes one vertex of ends within the tolerance of each other. Returns the vertices and the lines that have a length.
fn merged_ends(
    segments: &[Segment],
    mut places: Places,
    repairs: &mut Repairs,
) -> (Places, Vec<DrawnEdge>) {
    let pieces = segments.iter().map(|segment| DrawnEdge {
        ends: segment.ends.map(|end| places.at(end)),
        letter: segment.letter,
        goal: segment.goal,
    });
    let mut pieces: Vec<DrawnEdge> = pieces.collect();
    places.centre();
    for (segment, piece) in segments.iter().zip(&pieces) {
        for (end, vertex) in segment.ends.iter().zip(piece.ends) {
            let moved = (places.points[vertex] - end).norm();
            repairs.moved += usize::from(moved > 0.0);
            repairs.farthest = repairs.farthest.max(moved);
        }
    }
    pieces.retain(|piece| piece.ends[0] != piece.ends[1]);
    repairs.short = segments.len() - pieces.len();
    (places, pieces)
}

/// Number of proximity tests that are still allowed, none once the caller cancels.
pub(super) struct Looks<'a> {
    left: usize,
    watch: Watch<'a>,
}

impl<'a> Looks<'a> {
    /// Returns the budget for a drawing of `lines` lines.
    pub(super) fn for_lines(lines: usize, watch: Watch<'a>) -> Self {
        let left = MAX_LOOKS[1].max(MAX_LOOKS[0] * lines);
        Self { left, watch }
    }

    pub(super) fn take(&mut self, count: usize) {
        self.left = self.left.saturating_sub(count);
    }

    pub(super) fn are_used_up(&self) -> bool {
        self.left == 0 || self.watch.is_over()
    }
}

/// Splits lines where they cross and where they pass vertices, until no line does. Returns `None` if there are too many
/// pieces or the budget is used up.
fn cut_up(
    places: &mut Places,
    pieces: &mut Vec<DrawnEdge>,
    repairs: &mut Repairs,
    looks: &mut Looks<'_>,
) -> Option<()> {
    let tolerance = places.tolerance;
    for _ in 0..MAX_SPLITTING_ROUNDS {
        let before = places.points.len();
        for crossing in crossings(&places.points, pieces, tolerance, looks)? {
            places.at(crossing);
        }
        repairs.crossings += places.points.len() - before;
        let count = pieces.len();
        *pieces = split(places, pieces, looks)?;
        let splits = pieces.len() - count;
        if splits == 0 && places.points.len() == before {
            break;
        }
        repairs.passed += splits;
        deduplicate(pieces, repairs);
    }
    Some(())
}

/// Returns the usual merging tolerance of a drawing of this diagonal.
fn usual_tolerance(segments: &[Segment], diagonal: f64) -> f64 {
    let lengths = segments.iter().map(|s| (s.ends[1] - s.ends[0]).norm());
    let median = median(lengths.filter(|length| *length > 0.0));
    median.map_or(0.0, |median| straighten::usual_tolerance(median, diagonal))
}

/// Keeps one of all lines between the same two vertices: the line of highest precedence, or else the first.
fn deduplicate(pieces: &mut Vec<DrawnEdge>, repairs: &mut Repairs) {
    let mut kept: Vec<DrawnEdge> = Vec::with_capacity(pieces.len());
    let mut at: HashMap<[usize; 2], usize> = HashMap::with_capacity(pieces.len());
    for piece in pieces.iter() {
        let [a, b] = piece.ends;
        let index = *at.entry([a.min(b), a.max(b)]).or_insert(kept.len());
        let Some(before) = kept.get_mut(index) else {
            kept.push(*piece);
            continue;
        };
        repairs.twice += 1;
        repairs.both_ways += usize::from(before.letter.sign() * piece.letter.sign() < 0.0);
        if weight(piece.letter) > weight(before.letter) {
            *before = *piece;
        }
    }
    *pieces = kept;
}

pub(super) fn line(points: &[Vector2<f64>], piece: &DrawnEdge) -> [Vector2<f64>; 2] {
    piece.ends.map(|end| points[end])
}

/// Returns the distance of the point's foot along the line, the distance of the point from the line, and the length of
/// the line.
pub(super) fn foot([a, b]: [Vector2<f64>; 2], point: Vector2<f64>) -> (f64, f64, f64) {
    let length = (b - a).norm();
    let unit = (b - a) / length;
    (
        (point - a).dot(&unit),
        (point - a).perp(&unit).abs(),
        length,
    )
}

/// Returns `true` if the point is on the line within the tolerance, between the line's ends.
fn passes(line: [Vector2<f64>; 2], point: Vector2<f64>, tolerance: f64) -> bool {
    let (along, aside, length) = foot(line, point);
    aside <= tolerance && along >= -tolerance && along <= length + tolerance
}

/// Makes a grid with about one line in each cell, cells at least `least` wide, and returns the lines in each cell.
pub(super) fn grid_of_lines(
    points: &[Vector2<f64>],
    pieces: &[DrawnEdge],
    least: f64,
) -> (Grid, Csr<usize>) {
    let lengths = pieces.iter().map(|piece| {
        let [a, b] = line(points, piece);
        (b - a).norm()
    });
    // So that a line covers few cells.
    #[allow(clippy::cast_precision_loss, reason = "a bound on work, not a result")]
    let wide = lengths.sum::<f64>() / (8.0 * pieces.len().max(1) as f64);
    let grid = Grid::new(points, pieces.len(), wide.max(least));
    let mut covered = Vec::new();
    for (index, piece) in pieces.iter().enumerate() {
        grid.along(line(points, piece), 0.0, |cell| covered.push((cell, index)));
    }
    let covered = group_by_key(grid.columns * grid.rows, &covered);
    (grid, covered)
}

/// Returns the points in which lines cross without an end of one on the other, or `None` if there are too many or the
/// budget is used up.
fn crossings(
    points: &[Vector2<f64>],
    pieces: &[DrawnEdge],
    tolerance: f64,
    looks: &mut Looks<'_>,
) -> Option<Vec<Vector2<f64>>> {
    let (grid, covered) = grid_of_lines(points, pieces, 0.0);
    let mut seen = vec![usize::MAX; pieces.len()];
    let mut found = Vec::new();
    for (index, piece) in pieces.iter().enumerate() {
        let one = line(points, piece);
        let mut too_many = false;
        grid.along(one, 0.0, |cell| {
            looks.take(1);
            for &other in covered[cell].iter().take_while(|&&other| other < index) {
                looks.take(1);
                if seen[other] == index {
                    continue;
                }
                seen[other] = index;
                if pieces[other]
                    .ends
                    .iter()
                    .any(|end| piece.ends.contains(end))
                {
                    continue;
                }
                found.extend(crossing(one, line(points, &pieces[other]), tolerance));
            }
            too_many |= found.len() > MAX_LINES || looks.are_used_up();
        });
        if too_many {
            return None;
        }
    }
    Some(found)
}

fn crossing(
    one: [Vector2<f64>; 2],
    other: [Vector2<f64>; 2],
    tolerance: f64,
) -> Option<Vector2<f64>> {
    let turn = |[a, b]: [Vector2<f64>; 2], c: Vector2<f64>| {
        let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
        orient2d(a, b, c)
    };
    let opposite = |line, [c, d]: [Vector2<f64>; 2]| {
        let (c, d) = (turn(line, c), turn(line, d));
        (c > 0.0 && d < 0.0) || (c < 0.0 && d > 0.0)
    };
    if !opposite(one, other) || !opposite(other, one) {
        return None;
    }
    // If an end lies on the other line, `split` splits that line at the end instead.
    let ends = other.iter().any(|&end| passes(one, end, tolerance))
        || one.iter().any(|&end| passes(other, end, tolerance));
    if ends {
        return None;
    }
    let (along, across) = (one[1] - one[0], other[1] - other[0]);
    let part = (other[0] - one[0]).perp(&across) / along.perp(&across);
    Some(one[0] + along * part.clamp(0.0, 1.0))
}

/// Splits each line at the vertices that it passes. Returns `None` if there are too many pieces or the budget is used
/// up.
fn split(places: &Places, pieces: &[DrawnEdge], looks: &mut Looks<'_>) -> Option<Vec<DrawnEdge>> {
    let (points, tolerance) = (&places.points, places.tolerance);
    let (grid, cells) = Grid::of_points(points, 4.0 * tolerance);
    let mut result = Vec::with_capacity(pieces.len());
    let mut stops: Vec<(f64, usize)> = Vec::new();
    for piece in pieces {
        let line = line(points, piece);
        stops.clear();
        grid.along(line, tolerance, |cell| {
            looks.take(1 + cells[cell].len());
            for &vertex in cells[cell].iter().filter(|v| !piece.ends.contains(v)) {
                let (along, aside, length) = foot(line, points[vertex]);
                let passes = aside <= tolerance && along > 0.0 && along < length;
                if passes && !places.retired.contains(&vertex) {
                    stops.push((along, vertex));
                }
            }
        });
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut from = piece.ends[0];
        for to in stops.iter().map(|(_, stop)| *stop).chain([piece.ends[1]]) {
            result.push(DrawnEdge {
                ends: [from, to],
                ..*piece
            });
            from = to;
        }
        if result.len() > MAX_LINES || looks.are_used_up() {
            return None;
        }
    }
    Some(result)
}

/// Makes the drawing from lines. Its vertices are the ends of lines, in the order in which lines first use them.
pub(super) fn drawing(points: &[Vector2<f64>], mut edges: Vec<DrawnEdge>) -> Drawing {
    let mut names = vec![None; points.len()];
    let mut vertices = Vec::new();
    for end in edges.iter_mut().flat_map(|edge| &mut edge.ends) {
        *end = *names[*end].get_or_insert_with(|| {
            vertices.push(points[*end]);
            vertices.len() - 1
        });
    }
    Drawing {
        vertices,
        edges,
        faces: None,
    }
}
