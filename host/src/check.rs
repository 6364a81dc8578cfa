//! Judges a path afresh: from the file alone, sharing no state with the planner.
//!
//! Closure is taken by the report's 4x4 folding matrices where the planner uses quaternions; shape
//! by the folding map, and by the positions in the file where it has them.

use foldpath_core::{GroupId, Spoke, StarView, local_foldability_matrix};
use nalgebra::{Matrix3, Vector3};

use crate::collision::{CollisionScene, Crossing};
use crate::folding::{FoldingMap, Rigidity, SpanningTree, deformation, sheets_laid_on};
use crate::formats::fold::{PathFile, PathKnot};
use crate::pattern::{CreasePattern, VertexId};

/// Options of [`check`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckOptions {
    /// Bound on deformation and gap, a fraction.
    pub bound: f64,
    /// No hinge may turn by more than this from one knot to the next, radians.
    pub max_step: f64,
}

impl Default for CheckOptions {
    fn default() -> Self {
        Self {
            bound: 1e-3,
            max_step: 10_f64.to_radians(),
        }
    }
}

/// Angles that differ by less, in radians, are the same: a hundred times what is lost between
/// radians and the degrees of a file, a millionth of what can be seen.
const SAME_ANGLE: f64 = 1e-9;
/// A claim below the measured value by more than this factor is false.
const CLAIM_FACTOR: f64 = 10.0;
/// Errors below this are rounding, and no claim about them is false.
const CLAIM_FLOOR: f64 = 1e-9;

/// A crossing and where on the path it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathCrossing {
    /// The deepest crossing there.
    pub crossing: Crossing,
    /// The knots between which it was found.
    pub between_knots: [usize; 2],
    /// Where between them, from 0 to 1.
    pub at: f64,
}

/// What was measured at one knot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Deformation, and gap. Where the file has positions they count as one more opinion on where
    /// each vertex is.
    pub rigidity: Rigidity,
    /// Largest closure residual of a real vertex, or twist of a hinge if that is larger.
    pub closure: f64,
    /// The vertex that closes worst.
    pub vertex: Option<VertexId>,
}

/// The verdict on a path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// What is wrong, in words; the path holds if this is empty.
    pub failures: Vec<String>,
    /// What was measured at each knot.
    pub knots: Vec<Measured>,
    /// Crossings found, one a knot at most.
    pub crossings: Vec<PathCrossing>,
}

impl Verdict {
    /// Worst deformation and gap.
    #[must_use]
    pub fn rigidity(&self) -> Rigidity {
        let knots = self.knots.iter();
        knots.fold(Rigidity::default(), |worst, knot| {
            worst.worse(knot.rigidity)
        })
    }

    /// Worst closure residual.
    #[must_use]
    pub fn closure(&self) -> f64 {
        self.knots
            .iter()
            .fold(0.0, |worst, knot| f64::max(worst, knot.closure))
    }
}

/// Judges a path.
#[must_use]
pub fn check(path: &PathFile, options: &CheckOptions) -> Verdict {
    let mut verdict = Verdict {
        knots: measure(path),
        ..Verdict::default()
    };
    check_angles(path, &mut verdict.failures);
    check_groups(path, &mut verdict.failures);
    check_steps(path, options, &mut verdict.failures);
    check_rigidity(path, options, &mut verdict);
    check_crossings(path, &mut verdict);
    verdict
}

/// Measures every knot of a path.
#[must_use]
pub fn measure(path: &PathFile) -> Vec<Measured> {
    let pattern = &path.pattern;
    let tree = SpanningTree::from_central_face(pattern);
    let mut map = FoldingMap::new(pattern, &tree, &vec![0.0; pattern.creases().len()]);
    let knots = path.knots.iter().map(|knot| {
        let angles = crease_angles(pattern, knot);
        map.fold(pattern, &tree, &angles);
        let mut rigidity = map.rigidity(pattern, &tree);
        if let Some(written) = &knot.vertices {
            rigidity = rigidity.worse(Rigidity {
                deformation: deformation(pattern, written),
                gap: mismatch(pattern, map.vertices(), written) / pattern.median_edge(),
                twist: 0.0,
            });
        }
        let (closure, vertex) = closure(pattern, knot);
        Measured {
            rigidity,
            closure: closure.max(rigidity.twist),
            vertex,
        }
    });
    knots.collect()
}

/// Folded positions of the vertices at a knot: those in the file, or else by the folding map.
#[must_use]
pub fn positions(
    pattern: &CreasePattern,
    tree: &SpanningTree,
    knot: &PathKnot,
) -> Vec<Vector3<f64>> {
    knot.vertices.clone().unwrap_or_else(|| {
        let angles = crease_angles(pattern, knot);
        FoldingMap::new(pattern, tree, &angles).vertices().to_vec()
    })
}

fn crease_angles(pattern: &CreasePattern, knot: &PathKnot) -> Vec<f64> {
    let creases = pattern.creases().iter();
    creases.map(|edge| knot.fold_angles[edge.index()]).collect()
}

/// Largest closure residual ‖L − I‖ / √2 of a real vertex, and that vertex.
fn closure(pattern: &CreasePattern, knot: &PathKnot) -> (f64, Option<VertexId>) {
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
        let l = local_foldability_matrix(star, [0.0, 0.0], &knot.fold_angles);
        let residual =
            (l.fixed_view::<3, 3>(0, 0) - Matrix3::identity()).norm() / core::f64::consts::SQRT_2;
        if residual > worst.0 || residual.is_nan() {
            worst = (residual, Some(vertex));
        }
    }
    worst
}

/// Largest distance of a vertex between two shapes, each sheet laid on the other as well as possible.
fn mismatch(pattern: &CreasePattern, a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    let laid = sheets_laid_on(pattern, a, b);
    let pairs = laid.iter().zip(b).zip(pattern.corners().iter());
    let used = pairs.filter(|(_, faces)| !faces.is_empty());
    let distances = used.map(|((a, b), _)| (a - b).norm());
    distances.fold(
        0.0,
        |worst, d| if d > worst || d.is_nan() { d } else { worst },
    )
}

fn check_angles(path: &PathFile, failures: &mut Vec<String>) {
    for (index, knot) in path.knots.iter().enumerate() {
        for (edge, (&angle, data)) in knot
            .fold_angles
            .iter()
            .zip(path.pattern.edges())
            .enumerate()
        {
            let degrees = angle.to_degrees();
            let code = data.letter.code();
            let wrong = if angle.abs() > core::f64::consts::PI + SAME_ANGLE {
                format!("is at {degrees} degrees, beyond half a turn")
            } else if data.crease.is_none() && angle.abs() > SAME_ANGLE {
                format!("is lettered {code} and must stay flat, but is at {degrees} degrees")
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

fn check_groups(path: &PathFile, failures: &mut Vec<String>) {
    let leaders = path.leaders();
    for (index, knot) in path.knots.iter().enumerate() {
        for (edge, member) in path.members.iter().enumerate() {
            let Some(member) = *member else { continue };
            let Some((leader, part)) = leaders[member.group.index()] else {
                continue;
            };
            // The way from an edge's angle to its group's is that back: a sign.
            let expected = part.apply(knot.fold_angles[leader.index()]);
            let angle = member.apply(knot.fold_angles[edge]);
            if (angle - expected).abs() > SAME_ANGLE {
                failures.push(format!(
                    "knot {index}: edges {leader} and {edge} are in group {}, but turn by {} and \
                     {} degrees, signs applied",
                    member.group.0,
                    expected.to_degrees(),
                    angle.to_degrees()
                ));
                return;
            }
        }
    }
}

fn check_steps(path: &PathFile, options: &CheckOptions, failures: &mut Vec<String>) {
    let mut worst = (options.max_step + SAME_ANGLE, None);
    for (index, pair) in path.knots.windows(2).enumerate() {
        let angles = pair[0].fold_angles.iter().zip(&pair[1].fold_angles);
        for (edge, (from, to)) in angles.enumerate() {
            let step = (to - from).abs();
            if step > worst.0 {
                worst = (step, Some((index, edge)));
            }
        }
    }
    if let (step, Some((index, edge))) = worst {
        failures.push(format!(
            "edge {edge} turns by {:.3} degrees between knots {index} and {}: over {} degrees",
            step.to_degrees(),
            index + 1,
            options.max_step.to_degrees()
        ));
    }
}

fn check_rigidity(path: &PathFile, options: &CheckOptions, verdict: &mut Verdict) {
    let mut worst: Option<(f64, String)> = None;
    for (index, (measured, knot)) in verdict.knots.iter().zip(&path.knots).enumerate() {
        let Rigidity {
            deformation, gap, ..
        } = measured.rigidity;
        let values = [deformation, gap, measured.closure];
        for ((name, value), claim) in ["deformation", "gap", "closure"]
            .into_iter()
            .zip(values)
            .zip(knot.claims)
        {
            if claim.is_some_and(|claim| value > CLAIM_FACTOR * claim.max(CLAIM_FLOOR)) {
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

fn check_crossings(path: &PathFile, verdict: &mut Verdict) {
    let pattern = &path.pattern;
    let tree = SpanningTree::from_central_face(pattern);
    let mut scene = CollisionScene::new(pattern);
    for (index, knot) in path.knots.iter().enumerate() {
        let map = FoldingMap::new(pattern, &tree, &crease_angles(pattern, knot));
        let gap = verdict.knots[index].rigidity.gap;
        if let Some(crossing) = scene.deepest_crossing(&map, gap) {
            verdict.crossings.push(PathCrossing {
                crossing,
                between_knots: [index.saturating_sub(1), index],
                at: if index == 0 { 0.0 } else { 1.0 },
            });
        }
    }
    if let Some(first) = verdict.crossings.first() {
        let [a, b] = first.crossing.faces;
        let depth = first.crossing.depth / pattern.median_edge();
        verdict.failures.push(format!(
            "knot {}: faces {a} and {b} pass through each other, {depth:.3e} median edges deep",
            first.between_knots[1]
        ));
    }
}
