//! Bounds the errors of a folded sheet that rounding alone causes.

use crate::pattern::{CreasePattern, Rigidity, SpanningTree};

/// Rounding errors of a step of the folding map, in units of ε times the length: of a rotated vector by half angle,
/// axis, product and normalisation of quaternions (`TURN_EPS`), of one rotation of the pivot (`PIVOT_EPS`), and of sums
/// (`SUM_EPS`).
const TURN_EPS: f64 = 16.0;
const PIVOT_EPS: f64 = 8.0;
const SUM_EPS: f64 = 2.0;

/// Bounds the gap, deformation and twist that [`FoldingMap`](super::FoldingMap) may show for a sheet that folds
/// rigidly.
///
/// Rotations lose some ε in each step from the root. Positions lose as much as rotations lost before, times the
/// way, and the rounding of coordinates; least is lost if the origin is near. Cost: linear.
#[must_use]
pub fn rounding(pattern: &CreasePattern, tree: &SpanningTree) -> Rigidity {
    #[derive(Clone, Copy)]
    struct Lost {
        /// Errors so far: of a rotated vector, per length (`turn`), and of the pivot's position (`shift`).
        turn: f64,
        shift: f64,
        pivot: nalgebra::Vector2<f64>,
        /// Upper bound of the distance in space from the root's origin to the pivot.
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
        let rounded = 2.0 * PIVOT_EPS * arm + SUM_EPS * (2.0 * arm + reach);
        lost[step.face.index()] = Lost {
            turn: parent.turn + TURN_EPS * f64::EPSILON,
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
                let rounded = PIVOT_EPS * place.norm() + SUM_EPS * (reach + way);
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
        twist: 2.0 * (turn + TURN_EPS * f64::EPSILON),
    }
}
