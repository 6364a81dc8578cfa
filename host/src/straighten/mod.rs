//! Straightens a drawing: moves its vertices by so little that nobody sees it, so that lines that are nearly straight or
//! parallel are so exactly, and so that vertices and holes that nearly fold flat do.
//!
//! People draw to about a thousandth of a line, and programs write a few digits. Creases that miss each other by so
//! little lock a sheet of rigid panels. The moves are the least, in the sum of their squares, that fulfil all conditions
//! at once.
//!
//! `symmetry` also restores stars whose coordinates are rounded. It turns the spokes of one star, for a planner that
//! solves a sheet of its own; here the drawing itself changes, so that all stars and holes share their vertices.

mod condition;
mod least_moves;
mod lines;

use core::f64::consts::PI;

use nalgebra::Vector2;

use self::condition::Condition;
use self::least_moves::{Effort, fulfil};
use crate::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};
use crate::progress::Watch;
use crate::util::nan_max::diagonal;

/// Farthest move of a vertex, in tolerances: two lines that lie within the tolerance of a third are twice as far from
/// each other.
const REACH_TOLERANCES: f64 = 2.0;

/// Length within which a condition holds, as a fraction of the drawing's diagonal: some roundings of a coordinate.
const EXACT_RATIO: f64 = 1e-14;

/// Length within which a condition counts as fulfilled after the moves, in the same unit.
const FULFILLED_RATIO: f64 = 1e-13;

/// Largest difference between a goal and half a turn, or flat, that is rounding, radians.
const SAME_ANGLE_RAD: f64 = 1e-3;

/// Largest number of times that conditions which contradict each other are given up.
const MAX_ROUNDS: usize = 12;

/// Largest number of edges of a drawing that is straightened.
const MAX_EDGES: usize = 1 << 14;

/// A straightened drawing.
pub(super) struct Straightened {
    /// The vertices in their new places.
    pub(super) vertices: Vec<Vector2<f64>>,
    /// Number of vertices that were moved.
    pub(super) moved: usize,
    /// Length of the farthest move, and the place at which it began.
    pub(super) farthest: (f64, Vector2<f64>),
}

/// Straightens a drawing, of which `pattern` was made, within the tolerance of its repair. Returns `None` if nothing has
/// to be moved, or no moves within the tolerance are found with the effort that is allowed.
pub(super) fn straighten(
    pattern: &CreasePattern,
    drawing: &Drawing,
    tolerance: f64,
    watch: Watch<'_>,
) -> Option<Straightened> {
    if drawing.edges.len() > MAX_EDGES {
        return None;
    }
    let reach = REACH_TOLERANCES * tolerance;
    let diagonal = diagonal(&drawing.vertices);
    let drawn = &drawing.vertices;
    let exact = EXACT_RATIO * diagonal;
    let mut conditions = lines::conditions(drawing, reach);
    if drawing.edges.iter().all(folds_flat) {
        conditions.extend(flat_foldings(pattern, drawing));
    } else {
        // The designer of such a sheet turned lines on purpose.
        conditions.retain(|it| !matches!(it, Condition::Parallel { .. }));
    }
    conditions.retain(|it| it.is_meant(drawn, reach));
    let is_off = |it: &Condition, points: &[Vector2<f64>], within: f64| {
        let equations = it.equations(points);
        equations.iter().any(|equation| equation.off.abs() > within)
    };
    let mut effort = Effort::new(watch);
    for _ in 0..MAX_ROUNDS {
        if !conditions.iter().any(|it| is_off(it, drawn, exact)) {
            return None;
        }
        let vertices = fulfil(&conditions, drawn.clone(), exact, &mut effort)?;
        let moves: Vec<f64> = vertices
            .iter()
            .zip(drawn)
            .map(|(a, b)| (a - b).norm())
            .collect();
        // Conditions that stay open, or move a vertex too far, contradict others.
        let contradicts = |it: &Condition| {
            is_off(it, &vertices, FULFILLED_RATIO * diagonal)
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
        if moves.iter().any(|by| *by > reach) {
            return None;
        }
        let farthest = moves.iter().copied().zip(drawn.iter().copied());
        return Some(Straightened {
            moved: moves.iter().filter(|by| **by > 0.0).count(),
            farthest: farthest.max_by(|a, b| a.0.total_cmp(&b.0))?,
            vertices,
        });
    }
    None
}

/// Returns `true` unless an edge has a goal between flat and half a turn.
fn folds_flat(edge: &DrawnEdge) -> bool {
    let goal = edge.goal.unwrap_or(PI).abs();
    goal.min(PI - goal) <= SAME_ANGLE_RAD
}

/// Returns the conditions that the creases round each vertex and each hole fold flat, if their number and letters allow
/// it.
fn flat_foldings(pattern: &CreasePattern, drawing: &Drawing) -> Vec<Condition> {
    let is_hinge = |edge: &usize| pattern.edges()[*edge].crease.is_some();
    let ends = |edge: usize| drawing.edges[edge].ends;
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
