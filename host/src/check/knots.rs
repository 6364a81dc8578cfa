//! Measures a path at its knots, and compares the measurements with the claims of the file.

use foldpath_core::{GroupId, Node, Spoke, StarView, local_foldability_matrix};
use nalgebra::{Matrix3, Vector3};

use super::{CheckOptions, Measured, SAME_ANGLE, Verdict};
use crate::folding::{FoldingMap, Rigidity, SpanningTree, align_sheets, deformation};
use crate::motion::{GroupNaming, Motion};
use crate::pattern::{CreasePattern, EdgeId, VertexId};

/// Ratio of the measured value to a claim above which the claim is false.
const CLAIM_FACTOR: f64 = 10.0;
/// Error below which values are rounding, and no claim about them is false.
const CLAIM_FLOOR: f64 = 1e-9;
/// Error of a coordinate in space, in ε, that folding and rigid registration leave.
const ROUNDINGS: f64 = 16.0;

/// Measures every knot of a path, on the sheet folded along a tree of its faces.
#[must_use]
pub fn measure(path: &Motion, tree: &SpanningTree) -> Vec<Measured> {
    let pattern = &path.pattern;
    let mut map = FoldingMap::flat(pattern);
    let knots = path.knots.iter().enumerate().map(|(index, knot)| {
        map.fold(pattern, tree, &path.crease_angles(index));
        let mut rigidity = map.rigidity(pattern, tree);
        let gap = rigidity.gap;
        let written = &knot.vertices;
        if !written.is_empty() {
            rigidity = rigidity.worse(Rigidity {
                deformation: deformation(pattern, written),
                gap: mismatch(pattern, map.vertices(), written) / pattern.median_edge(),
                twist: 0.0,
            });
        }
        let (closure, vertex) = closure(path, index);
        Measured {
            rigidity,
            gap,
            closure: closure.max(rigidity.twist),
            vertex,
        }
    });
    knots.collect()
}

/// Returns the largest closure residual ‖L − I‖ / √2 of a real vertex, and that vertex.
fn closure(path: &Motion, knot: usize) -> (f64, Option<VertexId>) {
    let pattern = &path.pattern;
    let edges = (0..pattern.edges().len()).map(EdgeId::new);
    let angles: Vec<f64> = edges.map(|edge| path.node(knot, edge).angle).collect();
    let mut worst = (0.0, None);
    for vertex in pattern.real_vertices() {
        let star = &pattern.stars()[vertex.index()];
        let spokes: Vec<Spoke<f64>> = star
            .iter()
            .map(|&edge| {
                let direction = pattern.direction(edge, vertex);
                Spoke {
                    group: GroupId(edge.0),
                    negative: false,
                    direction: [direction.x, direction.y],
                }
            })
            .collect();
        let star = StarView { spokes: &spokes };
        let l = local_foldability_matrix(star, [0.0, 0.0], &angles);
        let residual =
            (l.fixed_view::<3, 3>(0, 0) - Matrix3::identity()).norm() / core::f64::consts::SQRT_2;
        if residual > worst.0 || residual.is_nan() {
            worst = (residual, Some(vertex));
        }
    }
    worst
}

/// Returns the largest distance of a vertex between two shapes, after rigid registration of each sheet.
fn mismatch(pattern: &CreasePattern, a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    let laid = align_sheets(pattern, a, b);
    let pairs = laid.iter().zip(b).zip(pattern.corners().iter());
    let used = pairs.filter(|(_, faces)| !faces.is_empty());
    let distances = used.map(|((a, b), _)| (a - b).norm());
    distances.fold(
        0.0,
        |worst, d| if d > worst || d.is_nan() { d } else { worst },
    )
}

pub(super) fn check_angles(path: &Motion, failures: &mut Vec<String>) {
    for index in 0..path.knots.len() {
        for (edge, data) in path.pattern.edges().iter().enumerate() {
            let Node { angle, rate, .. } = path.node(index, EdgeId::new(edge));
            let degrees = angle.to_degrees();
            let code = data.letter.code();
            let wrong = if angle.abs() > core::f64::consts::PI + SAME_ANGLE {
                format!("is at {degrees} degrees, beyond half a turn")
            } else if data.crease.is_none() && angle.abs() > SAME_ANGLE {
                format!("is lettered {code} and must stay flat, but is at {degrees} degrees")
            } else if data.crease.is_none() && rate.abs() > SAME_ANGLE && path.uses_rates() {
                let rate = rate.to_degrees();
                format!(
                    "is lettered {code} and must stay flat, but turns by {rate} degrees a second"
                )
            } else if angle * data.letter.sign() < -SAME_ANGLE {
                format!("is lettered {code}, but is at {degrees} degrees: wrong sign")
            } else {
                continue;
            };
            failures.push(format!("knot {index}: edge {edge} {wrong}"));
            return;
        }
    }
}

/// Checks that all hinges of a group turn alike; if some do not, reports the first failure.
pub(crate) fn check_groups(path: &Motion, failures: &mut Vec<String>) {
    let GroupNaming::Contradicted(named) = &path.naming else {
        return;
    };
    let leaders = path.leaders();
    for index in 0..path.knots.len() {
        for (edge, member) in named.iter().enumerate() {
            let Some(member) = *member else { continue };
            let Some((leader, part)) = leaders[member.group.index()] else {
                continue;
            };
            // A membership is a sign, so it takes an edge's angle to its group's as well as back.
            let [expected, found] =
                [(leader, part), (EdgeId::new(edge), member)].map(|(edge, part)| {
                    let node = path.node(index, edge);
                    let rate = if path.uses_rates() { node.rate } else { 0.0 };
                    [
                        part.apply(node.angle),
                        part.apply(rate),
                        node.weight[0],
                        node.weight[1],
                    ]
                });
            let kinds = [
                "turn to",
                "turn at",
                "have weights of",
                "have weights that grow by",
            ];
            let pairs = expected.iter().zip(&found);
            let differ = pairs.map(|(a, b)| (a - b).abs() > SAME_ANGLE);
            if let Some(kind) = differ.into_iter().position(|differs| differs) {
                let [a, b] = [expected, found].map(|values| {
                    let value = values[kind];
                    if kind < 2 { value.to_degrees() } else { value }
                });
                failures.push(format!(
                    "knot {index}: edges {leader} and {edge} are in group {}, but {} {a} and {b}{}, signs applied",
                    member.group.0,
                    kinds[kind],
                    [" degrees", " degrees a second", "", " a second"][kind],
                ));
                return;
            }
        }
    }
}

pub(super) fn check_rigidity(path: &Motion, options: &CheckOptions, verdict: &mut Verdict) {
    let mut worst: Option<(f64, String)> = None;
    let points = path.pattern.vertices();
    let far = points.iter().map(|point| (point - points[0]).norm());
    let rounding = ROUNDINGS * f64::EPSILON * far.fold(0.0, f64::max) / path.pattern.median_edge();
    let floor = CLAIM_FLOOR.max(rounding);
    for (index, (measured, knot)) in verdict.knots.iter().zip(&path.knots).enumerate() {
        let Rigidity {
            deformation, gap, ..
        } = measured.rigidity;
        let values = [deformation, gap, measured.closure];
        let claims = [
            knot.claims.deformation,
            knot.claims.gap,
            knot.claims.closure,
        ];
        for ((name, value), claim) in ["deformation", "gap", "closure"]
            .into_iter()
            .zip(values)
            .zip(claims)
        {
            if claim.is_some_and(|claim| value > CLAIM_FACTOR * claim.max(floor)) {
                let claim = claim.unwrap_or_default();
                verdict.failures.push(format!(
                    "knot {index}: the file claims a {name} of {claim:.3e}, but it is {value:.3e}"
                ));
            }
            let over = value > options.bound || value.is_nan();
            if over
                && worst
                    .as_ref()
                    .is_none_or(|(most, _)| value > *most || value.is_nan())
            {
                let open = measured.vertex.filter(|_| measured.closure > SAME_ANGLE);
                let vertex = open.map_or(String::new(), |vertex| {
                    format!(
                        "; vertex {vertex} fails to close by {:.3e}",
                        measured.closure
                    )
                });
                let bound = options.bound;
                let text =
                    format!("knot {index}: {name} {value:.3e} over the bound {bound:.3e}{vertex}");
                worst = Some((value, text));
            }
        }
    }
    verdict.failures.extend(worst.map(|(_, text)| text));
}
