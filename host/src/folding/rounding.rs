//! What rounding alone makes of a folded sheet.

use super::map::Rigidity;
use super::tree::SpanningTree;
use crate::pattern::CreasePattern;

/// Roundings of a step of the folding map, in ε: of a rotated vector by half angle, axis, product and
/// normalisation of quaternions; of the pivot's two rotations and of sums, per length.
const TURN: f64 = 16.0;
const ROTATE: f64 = 8.0;
const SUM: f64 = 2.0;

/// Bounds on gap, deformation and twist that [`FoldingMap`](super::FoldingMap) may show of a sheet that
/// folds rigidly. Rotations lose some ε each step from the root, positions what rotations lost before,
/// times the way, and the roundings of coordinates: least where the origin is near. Cost: linear.
#[must_use]
pub fn rounding(pattern: &CreasePattern, tree: &SpanningTree) -> Rigidity {
    #[derive(Clone, Copy)]
    struct Lost {
        /// Of a rotated vector, per length; of the pivot's position.
        turn: f64,
        shift: f64,
        pivot: nalgebra::Vector2<f64>,
        /// No farther from the root's origin is the pivot in space.
        reach: f64,
    }
    let corner = |face: usize| pattern.vertices()[pattern.faces()[face][0].index()];
    let mut lost: Vec<Lost> = (0..tree.faces())
        .map(|face| Lost {
            turn: 0.0,
            shift: 0.0,
            pivot: corner(face),
            reach: corner(face).norm(),
        })
        .collect();
    for step in tree.steps() {
        let parent = lost[step.parent.index()];
        if step.crease.is_none() {
            lost[step.face.index()] = parent;
            continue;
        }
        let way = (step.pivot - parent.pivot).norm();
        let (reach, arm) = (parent.reach + way, step.pivot.norm());
        let rounded = 2.0 * ROTATE * arm + SUM * (2.0 * arm + reach);
        lost[step.face.index()] = Lost {
            turn: parent.turn + TURN * f64::EPSILON,
            shift: parent.shift + parent.turn * way + rounded * f64::EPSILON,
            pivot: step.pivot,
            reach,
        };
    }

    let corners = pattern.corners().iter().zip(pattern.vertices());
    let moved: Vec<f64> = corners
        .map(|(faces, place)| {
            let each = faces.iter().map(|face| {
                let Lost {
                    turn,
                    shift,
                    pivot,
                    reach,
                } = lost[face.index()];
                let way = (place - pivot).norm();
                let rounded = ROTATE * place.norm() + SUM * (reach + way);
                shift + turn * way + rounded * f64::EPSILON
            });
            each.fold(0.0, f64::max)
        })
        .collect();
    let strain = |ends: [crate::pattern::VertexId; 2]| {
        let [a, b] = ends.map(|end| moved[end.index()]);
        (a + b) / pattern.length(ends) + 4.0 * f64::EPSILON
    };
    let turn = lost.iter().map(|lost| lost.turn).fold(0.0, f64::max);
    Rigidity {
        deformation: pattern.struts().map(strain).fold(0.0, f64::max),
        gap: 2.0 * moved.iter().copied().fold(0.0, f64::max) / pattern.median_edge(),
        twist: 2.0 * (turn + TURN * f64::EPSILON),
    }
}
