//! Measures a path at its knots, and compares the measurements with the claims of the file.

use foldpath_core::{GroupId, Node, Spoke, StarView, local_foldability_matrix};
use nalgebra::{Matrix3, Vector3};

use super::finding::{Failure, GroupQuantity, Moment, SheetError, WrongTurn};
use super::{Measured, SAME_ANGLE_RAD};
use crate::folding::{FoldingMap, Rigidity, SpanningTree, align_sheets, deformation};
use crate::motion::{GroupNaming, Motion};
use crate::pattern::{CreasePattern, EdgeId, Letter, VertexId};

/// Ratio of the measured value to a claim above which the claim is false.
const CLAIM_FACTOR: f64 = 10.0;
/// Error below which values are rounding, and no claim about them is false.
const MIN_CLAIMED_ERROR: f64 = 1e-9;
/// Error of a coordinate in space, in ε, that folding and rigid registration leave.
const ROUNDING_EPSILONS: f64 = 16.0;

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

/// Returns the first hinge that is turned at a knot as it must not be.
///
/// Panels may bend by `bend` radians.
pub(super) fn wrong_angle(path: &Motion, bend: f64) -> Option<Failure> {
    let knots = 0..path.knots.len();
    let mut hinges = knots.flat_map(|knot| {
        let edges = path.pattern.edges().iter().enumerate();
        edges.map(move |(edge, data)| (knot, EdgeId::new(edge), data))
    });
    hinges.find_map(|(knot, edge, data)| {
        let Node { angle, rate, .. } = path.node(knot, edge);
        let (wrong, value) = if angle.abs() > core::f64::consts::PI + SAME_ANGLE_RAD {
            (WrongTurn::BeyondHalfTurn, angle)
        } else if data.letter == Letter::Bend && angle.abs() > bend + SAME_ANGLE_RAD {
            (WrongTurn::BeyondBend, angle)
        } else if data.crease.is_none() && angle.abs() > SAME_ANGLE_RAD {
            (WrongTurn::NotFlat, angle)
        } else if data.crease.is_none() && rate.abs() > SAME_ANGLE_RAD && path.uses_rates() {
            (WrongTurn::FlatButTurns, rate)
        } else if angle * data.letter.sign() < -SAME_ANGLE_RAD {
            (WrongTurn::AgainstLetter, angle)
        } else {
            return None;
        };
        Some(Failure::Turns {
            at: Moment::Knot(knot),
            edge,
            letter: data.letter,
            wrong,
            value,
        })
    })
}

/// Returns the first hinge that does not turn like the others of its group in the file.
pub(crate) fn differing_hinge(path: &Motion) -> Option<Failure> {
    let GroupNaming::Contradicted(named) = &path.naming else {
        return None;
    };
    let leaders = path.leaders();
    let knots = 0..path.knots.len();
    let mut hinges = knots.flat_map(|knot| {
        let members = named.iter().enumerate();
        members.filter_map(move |(edge, member)| Some((knot, EdgeId::new(edge), (*member)?)))
    });
    hinges.find_map(|(knot, edge, member)| {
        let (leader, part) = leaders[member.group.index()]?;
        // A membership is a sign, so it takes an edge's angle to its group's as well as back.
        let [expected, found] = [(leader, part), (edge, member)].map(|(edge, part)| {
            let node = path.node(knot, edge);
            let rate = if path.uses_rates() { node.rate } else { 0.0 };
            [
                part.apply(node.angle),
                part.apply(rate),
                node.weight[0],
                node.weight[1],
            ]
        });
        let quantities = [
            GroupQuantity::Angle,
            GroupQuantity::Rate,
            GroupQuantity::Weight,
            GroupQuantity::WeightGrowth,
        ];
        let mut pairs = quantities.into_iter().zip(expected.into_iter().zip(found));
        let (quantity, (a, b)) = pairs.find(|(_, (a, b))| (a - b).abs() > SAME_ANGLE_RAD)?;
        Some(Failure::GroupDiffers {
            knot,
            edges: [leader, edge],
            group: member.group,
            quantity,
            values: [a, b],
        })
    })
}

/// Returns the claims of the file that are false, and the worst violation of the bound at a knot.
pub(super) fn check_rigidity(path: &Motion, bound: f64, knots: &[Measured]) -> Vec<Failure> {
    let mut failures = Vec::new();
    let mut worst: Option<(f64, Failure)> = None;
    let points = path.pattern.vertices();
    let far = points.iter().map(|point| (point - points[0]).norm());
    let rounding =
        ROUNDING_EPSILONS * f64::EPSILON * far.fold(0.0, f64::max) / path.pattern.median_edge();
    let floor = MIN_CLAIMED_ERROR.max(rounding);
    for (index, (measured, knot)) in knots.iter().zip(&path.knots).enumerate() {
        let Rigidity {
            deformation, gap, ..
        } = measured.rigidity;
        let claims = &knot.claims;
        let errors = [
            (SheetError::Deformation, deformation, claims.deformation),
            (SheetError::Gap, gap, claims.gap),
            (SheetError::Closure, measured.closure, claims.closure),
        ];
        for (error, value, claim) in errors {
            if let Some(claimed) = claim
                && value > CLAIM_FACTOR * claimed.max(floor)
            {
                failures.push(Failure::FalseClaim {
                    knot: index,
                    error,
                    claimed,
                    found: value,
                });
            }
            let over = value > bound || value.is_nan();
            let worse = |(most, _): &(f64, Failure)| value > *most || value.is_nan();
            if over && worst.as_ref().is_none_or(worse) {
                let open = measured
                    .vertex
                    .filter(|_| measured.closure > SAME_ANGLE_RAD);
                let failure = Failure::OverBound {
                    at: Moment::Knot(index),
                    error,
                    value,
                    bound,
                    open: open.map(|vertex| (vertex, measured.closure)),
                };
                worst = Some((value, failure));
            }
        }
    }
    failures.extend(worst.map(|(_, failure)| failure));
    failures
}
