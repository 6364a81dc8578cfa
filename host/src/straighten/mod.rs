//! Straightens a pattern: moves its vertices by so little that nobody sees it, so that lines that are nearly straight or
//! parallel are so exactly, and so that vertices and holes that nearly fold flat do.
//!
//! People draw to about a thousandth of a line, and programs write a few digits. Creases that miss each other by so
//! little lock a sheet of rigid panels. The moves are the least, in the sum of their squares, that fulfil all conditions
//! at once. A fold through several layers is one line of the folded sheet: once every vertex folds flat, creases that
//! nearly lie on one such line are laid on it as well.
//!
//! `symmetry` also restores stars whose coordinates are rounded. It turns the spokes of one star, for a planner that
//! solves a sheet of its own; here the pattern itself changes, so that all stars and holes share their vertices.

mod condition;
mod layers;
mod least_moves;
mod lines;

use core::f64::consts::PI;
use core::fmt::{Display, Formatter, Result};
use std::collections::HashSet;

use nalgebra::Vector2;

use self::condition::Condition;
use self::least_moves::fulfil;
use crate::pattern::{CreasePattern, Digits, Edge, EdgeId, Letter, VertexId, places, rounded};
use crate::progress::Watch;
use crate::util::nan_max::diagonal;

/// Usual tolerance of a drawing as a fraction of its median line. Drawing programs write about seven digits and people
/// snap to a grid, while the closest distinct vertices of a tessellation are a tenth of a line apart.
const MEDIAN_RATIO: f64 = 1e-3;

/// Upper bound of the usual tolerance, as a fraction of the sheet's diagonal, for drawings whose lines run right across the
/// sheet.
const DIAGONAL_RATIO: f64 = 1e-4;

/// Lower bound of the usual tolerance, as a fraction of the diagonal: smaller differences are rounding alone.
pub(crate) const ROUNDING_RATIO: f64 = 1e-9;

/// Largest unit of rounded coordinates that widens the tolerance, as a fraction of the median edge.
const MAX_UNIT_RATIO: f64 = 1e-2;

/// Farthest move of a vertex, in tolerances: two lines that lie within the tolerance of a third are twice as far from
/// each other.
const REACH_TOLERANCES: f64 = 2.0;

/// Length within which a condition holds, as a fraction of the drawing's diagonal or of the largest coordinate, whichever is
/// more: some roundings of a coordinate.
const EXACT_RATIO: f64 = 1e-14;

/// Length within which a condition counts as fulfilled after the moves, as a multiple of the length within which it holds.
const FULFILLED_RATIO: f64 = 10.0;

/// Largest difference between a goal and half a turn, or flat, that is rounding, radians.
const SAME_ANGLE_RAD: f64 = 1e-3;

/// Largest number of times that conditions which contradict each other are given up.
const MAX_ROUNDS: usize = 12;

/// Largest length of an edge that counts as none once the pattern is straightened, as a fraction of the tolerance.
const NO_LENGTH_RATIO: f64 = 1e-6;

/// Largest number of edges of a pattern that is straightened.
const MAX_EDGES: usize = 1 << 14;

/// Description of the moves that straightened a pattern. `Display` makes a sentence of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Straightened {
    /// Number of vertices that were moved.
    pub moved: usize,
    /// Length of the longest move, in the drawing's units.
    pub farthest: f64,
    /// The place at which it began, in the drawing's own coordinates.
    pub at: [f64; 2],
}

impl Display for Straightened {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let Self {
            moved,
            farthest,
            at,
        } = self;
        let [x, y] = at.map(rounded);
        write!(
            f,
            "straightened: {moved} vertices moved, by {farthest:.1e} at most, from ({x}, {y})"
        )
    }
}

/// Returns the tolerance within which ends of lines are one place, for a drawing with this median length of its lines and
/// this diagonal.
pub(crate) fn usual_tolerance(median: f64, diagonal: f64) -> f64 {
    let most = DIAGONAL_RATIO * diagonal;
    (MEDIAN_RATIO * median)
        .min(most)
        .max(ROUNDING_RATIO * diagonal)
}

/// Returns how far lines of a pattern may be off: the usual tolerance, or the unit to which coordinates are rounded.
pub(crate) fn tolerance(pattern: &CreasePattern) -> f64 {
    let median = pattern.median_edge();
    let unit = pattern.precision().length.unit();
    let usual = usual_tolerance(median, diagonal(pattern.vertices()));
    usual.max(unit.min(MAX_UNIT_RATIO * median))
}

/// Straightens a pattern whose lines may be off by `tolerance`. No vertex moves farther than twice as far. Vertices, edges
/// and faces keep their numbers, unless edges of no length are left out. The new pattern counts as rounded to the longest
/// move. Returns `None` if nothing has to be moved, no moves within the tolerance are found, or creases and faces would not
/// stay what they are.
pub(crate) fn straightened(
    pattern: &CreasePattern,
    tolerance: f64,
    watch: Watch<'_>,
) -> Option<(CreasePattern, Straightened)> {
    if pattern.edges().len() > MAX_EDGES {
        return None;
    }
    let reach = REACH_TOLERANCES * tolerance;
    // Both sides of a cut move alike.
    let places = places(pattern.vertices());
    let points = least_moves(pattern, &places, reach, watch)?;
    let mut drawing = pattern.drawing();
    let drawn = core::mem::take(&mut drawing.vertices);
    drawing.vertices = places.iter().map(|&place| points[place]).collect();
    let moves = drawing
        .vertices
        .iter()
        .zip(&drawn)
        .map(|(a, b)| (a - b).norm());
    let moves: Vec<f64> = moves.collect();
    let moved = moves.iter().enumerate();
    let moved = moved
        .filter(|(vertex, by)| places[*vertex] == *vertex && **by > 0.0)
        .count();
    let farthest = moves.into_iter().enumerate();
    let (vertex, farthest) = farthest.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))?;
    let mut ends = drawing
        .edges
        .iter()
        .map(|edge| edge.ends.map(|end| drawing.vertices[end]));
    let no_length = |[a, b]: [Vector2<f64>; 2]| (b - a).norm() <= NO_LENGTH_RATIO * tolerance;
    let mut straight = if ends.any(no_length) {
        pattern.contracted(drawing, no_length, watch)?
    } else {
        pattern.redrawn(drawing, watch).ok()?
    };
    let count = |pattern: &CreasePattern| [pattern.creases().len(), pattern.faces().len()];
    if count(&straight) != count(pattern) {
        return None;
    }
    let mut precision = pattern.precision();
    precision.length = precision.length.coarser(Digits::of_unit(farthest));
    straight.written_with(precision);
    let at = pattern.drawn_place(VertexId::new(vertex));
    Some((
        straight,
        Straightened {
            moved,
            farthest,
            at,
        },
    ))
}

/// Returns the places of the vertices of a pattern after the least moves, none of them beyond `reach`, that fulfil as many of
/// the conditions as can be fulfilled at once. `places` has for each vertex the first one at its place, which alone
/// moves. Returns `None` if nothing has to be moved, or no such moves are found.
fn least_moves(
    pattern: &CreasePattern,
    places: &[usize],
    reach: f64,
    watch: Watch<'_>,
) -> Option<Vec<Vector2<f64>>> {
    let drawn = pattern.vertices();
    let ends = |edge: &Edge| edge.ends.map(|end| places[end.index()]);
    let coordinates = drawn.iter().map(|point| point.amax());
    let limits = Limits {
        reach,
        edge: pattern.median_edge(),
        exact: EXACT_RATIO * coordinates.fold(diagonal(drawn), f64::max),
    };
    let mut known = HashSet::new();
    let edges = (0..).map(EdgeId).zip(pattern.edges());
    let lines = edges.filter(|(edge, _)| !pattern.joins_parts(*edge));
    let lines = lines.map(|(_, edge)| ends(edge));
    let lines = lines.filter(|&[a, b]| known.insert([a.min(b), a.max(b)]));
    let mut conditions = lines::conditions(drawn, &lines.collect::<Vec<_>>(), reach);
    let folds_flat = pattern.edges().iter().all(folds_flat);
    if folds_flat {
        conditions.extend(flat_foldings(pattern, ends));
    } else {
        // The designer of such a sheet turned lines on purpose, but not by less than coordinates tell.
        let told = Limits {
            reach: reach.min(pattern.precision().length.unit()),
            ..limits
        };
        conditions.retain(|it| !it.is_parallel() || it.is_meant(drawn, told));
    }
    conditions.retain(|it| it.is_meant(drawn, limits));
    let moved = moved(drawn, conditions, limits, watch)?;
    if !folds_flat {
        return moved.vertices;
    }
    let vertices = moved.vertices.as_deref().unwrap_or(drawn);
    let layers = layers::conditions(pattern, vertices, ends, limits);
    if layers.is_empty() {
        return moved.vertices;
    }
    with_layers(drawn, &moved, &layers, limits, watch).or(moved.vertices)
}

/// Returns the places of vertices after the least moves that lay creases of different layers on one line as well. If lines
/// that are parallel by chance are in the way, they are given up.
fn with_layers(
    drawn: &[Vector2<f64>],
    before: &Moved,
    layers: &[Condition],
    limits: Limits,
    watch: Watch<'_>,
) -> Option<Vec<Vector2<f64>>> {
    let all = before.conditions.iter();
    let without = all.clone().filter(|it| !it.is_parallel());
    let tries: [Vec<&Condition>; 2] = [all.collect(), without.collect()];
    let mut first = None;
    for conditions in tries {
        let conditions = conditions.into_iter().chain(layers).cloned().collect();
        let Some(tried) = moved(drawn, conditions, limits, watch) else {
            continue;
        };
        if layers.iter().all(|layer| tried.conditions.contains(layer)) {
            return tried.vertices;
        }
        first = first.or(tried.vertices);
    }
    first
}

/// Lengths that limit how vertices are moved.
#[derive(Clone, Copy)]
struct Limits {
    /// Farthest move of a vertex.
    reach: f64,
    /// Length of an edge, to which moves are small.
    edge: f64,
    /// Length within which a condition holds.
    exact: f64,
}

/// Vertices that were moved, and the conditions that hold then.
struct Moved {
    /// `None` if nothing had to be moved.
    vertices: Option<Vec<Vector2<f64>>>,
    conditions: Vec<Condition>,
}

/// Moves vertices by the least, none of them beyond the reach, so that as many of the conditions hold as can at once. Returns
/// `None` if no such moves are found.
fn moved(
    drawn: &[Vector2<f64>],
    mut conditions: Vec<Condition>,
    Limits { reach, edge, exact }: Limits,
    watch: Watch<'_>,
) -> Option<Moved> {
    let is_off = |it: &Condition, points: &[Vector2<f64>], within: f64| {
        let equations = it.equations(points);
        equations.iter().any(|equation| equation.off.abs() > within)
    };
    for _ in 0..MAX_ROUNDS {
        if !conditions.iter().any(|it| is_off(it, drawn, exact)) {
            return Some(Moved {
                vertices: None,
                conditions,
            });
        }
        let vertices = fulfil(&conditions, drawn.to_vec(), exact, edge, watch)?;
        let moves: Vec<f64> = vertices
            .iter()
            .zip(drawn)
            .map(|(a, b)| (a - b).norm())
            .collect();
        // Conditions that stay open, or move a vertex too far, contradict others.
        let contradicts = |it: &Condition| {
            is_off(it, &vertices, FULFILLED_RATIO * exact)
                || is_off(it, drawn, exact) && it.vertices().any(|vertex| moves[vertex] > reach)
        };
        let first = conditions
            .iter()
            .filter(|it| contradicts(it))
            .map(Condition::rank)
            .min();
        if let Some(first) = first {
            conditions.retain(|it| it.rank() != first || !contradicts(it));
            continue;
        }
        let is_near = moves.iter().all(|by| *by <= reach);
        return is_near.then_some(Moved {
            vertices: Some(vertices),
            conditions,
        });
    }
    None
}

/// Returns `true` unless an edge has a goal between flat and half a turn.
fn folds_flat(edge: &Edge) -> bool {
    let goal = edge.goal.unwrap_or(PI).abs();
    goal.min(PI - goal) <= SAME_ANGLE_RAD
}

/// Returns the conditions that the creases round each vertex and each hole fold flat, if their number and letters allow
/// it.
fn flat_foldings(pattern: &CreasePattern, ends: impl Fn(&Edge) -> [usize; 2]) -> Vec<Condition> {
    let is_hinge = |edge: &usize| pattern.edges()[*edge].crease.is_some();
    let ends = |edge: usize| ends(&pattern.edges()[edge]);
    let vertices = pattern.real_vertices().filter_map(|vertex| {
        let star = pattern.stars()[vertex.index()]
            .iter()
            .map(|edge| edge.index());
        let hinges: Vec<usize> = star.filter(is_hinge).collect();
        let count = |letter| {
            let letters = hinges.iter().map(|&edge| pattern.edges()[edge].letter);
            letters.filter(|it| *it == letter).count()
        };
        let (mountains, valleys) = (count(Letter::Mountain), count(Letter::Valley));
        // The theorem of J. Maekawa, if each hinge has its way.
        let folds = mountains + valleys < hinges.len() || mountains.abs_diff(valleys) == 2;
        let creases = hinges.iter().map(|&edge| ends(edge)).collect();
        (hinges.len() >= 4 && hinges.len().is_multiple_of(2) && folds).then_some(
            Condition::FoldsFlat {
                creases,
                hole: None,
            },
        )
    });
    let holes = pattern
        .holes()
        .iter()
        .enumerate()
        .filter_map(|(hole, way)| {
            let edges = way.iter().map(|passage| passage.edge.index());
            let hinges: Vec<usize> = edges.filter(is_hinge).collect();
            let folds = hinges.len() >= 2 && hinges.len().is_multiple_of(2);
            let creases = hinges.into_iter().map(ends).collect();
            let (middle, _) = pattern.hole_frame(hole);
            folds.then_some(Condition::FoldsFlat {
                creases,
                hole: Some(middle),
            })
        });
    vertices.chain(holes).collect()
}
