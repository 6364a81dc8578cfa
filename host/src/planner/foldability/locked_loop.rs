//! Loops of vertices that lock each other: the letters leave a vertex of four creases that folds flat one mode, in which
//! neighbouring creases turn in a fixed ratio, and round a loop of vertices the ratios multiply to something else than 1.
//!
//! Opposite creases of such a vertex turn by equal angles, and the tangents of half the angles of neighbouring creases
//! keep their ratio all along the motion (T. Tachi, "Generalization of rigid-foldable quadrilateral-mesh origami", 2009).
//! The ratios of all vertices are followed from crease to crease (unit propagation).

use core::f64::consts::PI;
use std::collections::{HashSet, VecDeque};

use nalgebra::{Matrix3, Rotation3};

use super::cause::{Cause, CauseKind, decimals};
use crate::pattern::{CreasePattern, EdgeId, VertexId};

/// Largest angle by which sectors of a vertex that folds flat may be off, radians.
const FLAT_FOLDABLE_RAD: f64 = 1e-3;
/// Turn at which the two modes of a vertex are told apart, radians, and the largest residual of the right one.
const PROBE_RAD: f64 = 0.8;
const MAX_CLOSED_RAD: f64 = 5e-3;
/// Difference of the logarithms of two ratios from which on they contradict each other.
const OTHER_RATIO: f64 = 0.02;

/// Two creases whose half angles' tangents have a fixed ratio.
struct Tie {
    to: usize,
    /// Logarithm of the ratio.
    log: f64,
    vertex: VertexId,
}

/// Returns a cause for each set of vertices that lock each other, with the creases that cannot turn.
///
/// `letters` has for each crease 1 (valley), -1 (mountain) or 0. Cost: O(creases).
pub(super) fn locked_loops(pattern: &CreasePattern, letters: &[f64]) -> Vec<Cause> {
    let mut ties: Vec<Vec<Tie>> = Vec::new();
    ties.resize_with(letters.len(), Vec::new);
    for vertex in pattern.real_vertices() {
        let Some((creases, ratio)) = mode(pattern, letters, vertex) else {
            continue;
        };
        // Each crease with the next one: the first and the third are the pair with opposite letters.
        for k in 0..4 {
            let (from, to) = (creases[k], creases[(k + 1) % 4]);
            let log = if k % 2 == 0 { -ratio } else { ratio };
            ties[from].push(Tie { to, log, vertex });
            ties[to].push(Tie {
                to: from,
                log: -log,
                vertex,
            });
        }
    }
    let mut turns = vec![None; letters.len()];
    let mut causes = Vec::new();
    for first in 0..letters.len() {
        if turns[first].is_none() && !ties[first].is_empty() {
            causes.extend(propagate(pattern, &ties, &mut turns, first));
        }
    }
    causes
}

/// Follows the ratios from a crease to all that depend on it. Returns the cause if they contradict each other: the loop is
/// the way back from both ends of the tie that contradicts.
fn propagate(
    pattern: &CreasePattern,
    ties: &[Vec<Tie>],
    turns: &mut [Option<f64>],
    first: usize,
) -> Option<Cause> {
    let mut came: Vec<Option<(usize, VertexId)>> = vec![None; turns.len()];
    let mut open = VecDeque::from([first]);
    let (mut reached, mut wrong) = (vec![first], None);
    turns[first] = Some(0.0);
    while let Some(crease) = open.pop_front() {
        let here = turns[crease].unwrap_or_default();
        for tie in &ties[crease] {
            match turns[tie.to] {
                None => {
                    turns[tie.to] = Some(here + tie.log);
                    came[tie.to] = Some((crease, tie.vertex));
                    reached.push(tie.to);
                    open.push_back(tie.to);
                }
                Some(known) if (known - here - tie.log).abs() > OTHER_RATIO => {
                    wrong = wrong.or(Some((crease, tie, (here + tie.log - known).exp())));
                }
                Some(_) => {}
            }
        }
    }
    let (from, tie, product) = wrong?;
    let back = |crease: usize| -> Vec<VertexId> {
        let step = |(crease, _): &(usize, VertexId)| came[*crease];
        let way = core::iter::successors(came[crease], step);
        way.map(|(_, vertex)| vertex).collect()
    };
    let [mut one, mut other] = [back(from), back(tie.to)];
    // The ways run together before they come to the first crease.
    while one.last().is_some() && one.last() == other.last() {
        one.pop();
        other.pop();
    }
    let mut vertices = vec![tie.vertex];
    vertices.extend(one.into_iter().chain(other));
    let mut seen = HashSet::new();
    vertices.retain(|vertex| seen.insert(*vertex));
    reached.sort_unstable();
    Some(Cause {
        kind: CauseKind::LockedLoop(product),
        at: pattern.drawn_place(tie.vertex),
        decimals: decimals(pattern),
        edges: reached
            .into_iter()
            .map(|crease| pattern.creases()[crease])
            .collect(),
        vertices,
    })
}

/// Returns the creases of a vertex counter-clockwise, from the one whose letter differs from the others', and the
/// logarithm of the ratio of the first crease's tangent to the second's. `None` if the letters leave the vertex no mode of
/// its own: it has other than four creases, does not fold flat, or has creases in line.
fn mode(pattern: &CreasePattern, letters: &[f64], vertex: VertexId) -> Option<([usize; 4], f64)> {
    let star = pattern.stars()[vertex.index()].iter().copied();
    let star: Vec<EdgeId> = star.filter(|&edge| !pattern.joins_parts(edge)).collect();
    let star: [EdgeId; 4] = star.try_into().ok()?;
    let mut creases = [0; 4];
    for (crease, edge) in creases.iter_mut().zip(star) {
        *crease = pattern.edge(edge).crease?.index();
    }
    let sum: f64 = creases.iter().map(|&crease| letters[crease]).sum();
    let lettered = creases.iter().all(|&crease| letters[crease].abs() > 0.0);
    if !lettered || (sum.abs() - 2.0).abs() > 0.5 {
        return None;
    }
    let odd = creases
        .iter()
        .position(|&crease| letters[crease] * sum < 0.0)?;
    creases.rotate_left(odd);
    let mut ways = star.map(|edge| pattern.direction(edge, vertex));
    ways.rotate_left(odd);
    let sector = |k: usize| {
        let (a, b) = (ways[k], ways[(k + 1) % 4]);
        a.perp(&b).atan2(a.dot(&b)).rem_euclid(2.0 * PI)
    };
    if (sector(0) + sector(2) - PI).abs() > FLAT_FOLDABLE_RAD {
        return None;
    }
    let [half_sum, half_difference] =
        [sector(0) + sector(1), sector(0) - sector(1)].map(|a| a / 2.0);
    let cosines = (half_sum.cos() / half_difference.cos()).abs();
    let sines = (half_difference.sin() / half_sum.sin()).abs();
    let residual = |ratio: f64| {
        let tangent = (PROBE_RAD / 2.0).tan();
        // The larger of the two angles is the one that is set.
        let (first, second) = if ratio > 1.0 {
            (tangent, tangent / ratio)
        } else {
            (tangent * ratio, tangent)
        };
        let turns = [first, second, first, second];
        let product = (0..4).fold(Rotation3::identity(), |product, k| {
            let angle = 2.0 * turns[k].atan() * letters[creases[k]];
            product * Rotation3::new(ways[k].push(0.0) * angle)
        });
        (product.matrix() - Matrix3::identity()).norm()
    };
    let ratios = [cosines, sines, 1.0 / cosines, 1.0 / sines];
    let sound = ratios
        .into_iter()
        .filter(|ratio| (1e-6..1e6).contains(ratio));
    let judged = sound.map(|ratio| (residual(ratio), ratio));
    // Both modes nearly close if they are nearly alike.
    let (residual, ratio) = judged.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (residual < MAX_CLOSED_RAD).then_some((creases, ratio.ln()))
}
