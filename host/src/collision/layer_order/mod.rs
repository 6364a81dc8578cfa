//! Can the layers of a goal that lies flat be stacked at all?
//!
//! At a goal with all fold angles 0 or half a turn, all faces lie in one plane, and a crossing there shows nowhere but in
//! their order: of two faces that overlap, one is above the other. These rules hold:
//!
//! - The letter of a crease tells which of its faces is above.
//! - A face that covers a part of a crease is not between the two faces of the crease: it is above both or below both.
//! - Two folded creases lie on one line, with their faces on the same side. Then the faces of the first are both between
//!   those of the second, or neither is.
//! - Two flat creases lie on one line. Then the faces of one are above those of the other on both sides.
//! - A flat crease lies on the line of a folded one. Then its face on that side is above both faces of the folded crease, or
//!   below both.
//! - Three faces share a point. Then they lie in an order there: if the first is above the second and the second above the
//!   third, the first is above the third.
//!
//! If no order keeps all rules, then no motion leads to the goal, whatever the order of the folds. If one does, a motion
//! need not exist. An overlap counts only if it is deeper than contact and rounding can make it, and only faces
//! that are convex count, as others can be above each other at one place and below at another.
//!
//! Source of the conditions: J. Justin, "Towards a mathematical theory of origami", 1997. Their names in H. Akitaya et al.,
//! "Box pleating is hard", 2015: taco-tortilla, taco-taco, tortilla-tortilla and transitivity.

mod geometry;
mod search;

use crate::folding::FoldingMap;
use crate::pattern::{CreasePattern, EdgeId, FaceId};
use geometry::{FlatSheet, Stack};
use search::{Rule, Search};

/// Largest number of faces of a sheet whose vertices are looked at one by one, and of a sheet whose faces are then looked at
/// all together.
const MAX_FACES: usize = 20_000;
const MAX_FACES_TOGETHER: usize = 1000;
/// Largest number of rules, and of rules looked at in all searches of a stack, after which nothing is known.
const MAX_RULES: usize = 50_000;
const MAX_STEPS: usize = 500_000;
/// Ratio of the distance up to which points may lie otherwise than they are placed to contact and tears.
const MARGIN_RATIO: f64 = 4.0;
/// Largest difference of a fold angle from 0 or half a turn at a goal that lies flat, radians.
const FLAT_RAD: f64 = 1e-9;

/// Returns faces of which no order is possible at these fold angles of the creases (radians), at which the sheet lies flat
/// and closes; empty if an order is, or if it is not known. None of them can be left out, unless to find that takes too
/// long. `contact` is the depth up to which an overlap is contact, median edges.
///
/// The faces round each vertex are looked at first, then all faces of a sheet on which not too many overlap. Cost: linear
/// in the number of vertices, then quadratic in that of faces; at most about a tenth of a second.
#[must_use]
pub fn faces_without_order(
    pattern: &CreasePattern,
    fold_angles: &[f64],
    contact: f64,
) -> Vec<FaceId> {
    let faces = pattern.faces().len();
    let is_flat = fold_angles.iter().copied().all(lies_flat);
    if faces > MAX_FACES || pattern.sheets() > 1 || !is_flat {
        return Vec::new();
    }
    let map = FoldingMap::new(pattern, pattern.tree(), fold_angles);
    let torn = map.rigidity(pattern, pattern.tree()).gap + map.parting(pattern, pattern.tree());
    let margin = MARGIN_RATIO * (contact + torn) * pattern.median_edge();
    let sheet = FlatSheet::new(pattern, map, fold_angles, margin);
    let stars = pattern.real_vertices().map(|vertex| {
        let faces = &pattern.corners()[vertex.index()];
        let edges = &pattern.stars()[vertex.index()];
        without_order(&sheet.stack(faces.iter().copied(), edges.iter().copied()))
    });
    let mut found = stars.filter(|faces| !faces.is_empty());
    if let Some(few) = found.next() {
        return few;
    }
    if faces > MAX_FACES_TOGETHER {
        return Vec::new();
    }
    let edges = (0..pattern.edges().len()).map(EdgeId::new);
    without_order(&sheet.stack((0..faces).map(FaceId::new), edges))
}

/// Returns faces of a stack of which no order is possible, as few as can be found.
fn without_order(stack: &Stack<'_>) -> Vec<FaceId> {
    let Some(mut rules) = stack.rules(MAX_RULES) else {
        return Vec::new();
    };
    let mut steps = MAX_STEPS;
    let mut is_refuted =
        |rules: &[Rule]| Search::new(stack.pairs(), rules).has_solution(&mut steps) == Some(false);
    if !is_refuted(&rules) {
        return Vec::new();
    }
    let few = reduced((0..stack.faces()).collect(), |faces| {
        let among = |face: usize| faces.binary_search(&face).is_ok();
        let kept = rules.iter().filter(|rule| {
            let mut pairs = rule.pairs().iter();
            pairs.all(|&pair| stack.faces_of(pair).into_iter().all(among))
        });
        let kept: Vec<Rule> = kept.copied().collect();
        let is_enough = is_refuted(&kept);
        if is_enough {
            rules = kept;
        }
        is_enough
    });
    few.into_iter().map(|face| stack.face(face)).collect()
}

/// Returns `true` if a fold angle is 0 or half a turn.
fn lies_flat(angle: f64) -> bool {
    let turn = angle.abs();
    turn.min((turn - core::f64::consts::PI).abs()) <= FLAT_RAD
}

/// Leaves out what is not needed for a property that all have together: first halves, then ever smaller parts.
fn reduced(mut all: Vec<usize>, mut has: impl FnMut(&[usize]) -> bool) -> Vec<usize> {
    let mut size = all.len() / 2;
    while size > 0 {
        let mut at = 0;
        while at < all.len() {
            let mut fewer = all.clone();
            fewer.drain(at..(at + size).min(all.len()));
            if has(&fewer) {
                all = fewer;
            } else {
                at += size;
            }
        }
        size /= 2;
    }
    all
}
