//! Judges a path afresh: from the file alone, sharing no state with the planner.
//!
//! Closure is taken by folding matrices where the planner uses quaternions; shape by the folding map, and
//! by the positions in the file where it has them. A path is more than its knots: the motion between
//! them, as the file has it interpolated, is what is judged. Its closure is bounded everywhere, and with
//! it the deformation of the sheet; letters and half turns are kept everywhere; shapes are sampled.

mod closure;
mod majorant;
mod motion;
mod turns;

use foldpath_core::{GroupId, Node, Spoke, StarView, local_foldability_matrix};
use nalgebra::{Matrix3, Vector3};

pub use closure::{Place, SegmentClosure};
use motion::Motion;

use crate::collision::{CollisionScene, Crossing};
use crate::folding::{
    Amplification, FoldingMap, Rigidity, SpanningTree, deformation, sheets_laid_on,
};
use crate::formats::fold::{PathFile, PathKnot};
use crate::pattern::{CreasePattern, EdgeId, VertexId};

/// Options of [`check`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckOptions {
    /// Bound on deformation and gap, a fraction.
    pub bound: f64,
    /// Shapes looked at in each segment between its knots; with 0, knots alone are judged.
    pub samples: usize,
}

impl Default for CheckOptions {
    fn default() -> Self {
        Self {
            bound: 1e-3,
            samples: 16,
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
/// Roundings that each face adds to the positions of those behind it.
const ROUNDINGS: f64 = 16.0;

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

/// A shape between two knots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The number of the knot before it.
    pub segment: usize,
    /// Where in the segment, from 0 to 1.
    pub at: f64,
    /// Deformation, gap and twist there.
    pub rigidity: Rigidity,
}

/// The verdict on a path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// What is wrong, in words; the path holds if this is empty.
    pub failures: Vec<String>,
    /// What was measured at each knot.
    pub knots: Vec<Measured>,
    /// Shapes looked at between knots.
    pub samples: Vec<Sample>,
    /// The closure of each segment.
    pub segments: Vec<SegmentClosure>,
    /// No deformation of the whole motion is larger. `None` where that is not known: round holes, and
    /// where closure is not bounded.
    pub certified_deformation: Option<f64>,
    /// Crossings found, one a segment at most: the deepest between its knots and at its end.
    pub crossings: Vec<PathCrossing>,
}

impl Verdict {
    /// Worst deformation and gap, at knots and between.
    #[must_use]
    pub fn rigidity(&self) -> Rigidity {
        let samples = self.samples.iter().map(|sample| sample.rigidity);
        let shapes = self.knots.iter().map(|knot| knot.rigidity).chain(samples);
        shapes.fold(Rigidity::default(), Rigidity::worse)
    }

    /// Worst closure residual met, at knots and between.
    #[must_use]
    pub fn closure(&self) -> f64 {
        let between = self.segments.iter().map(|segment| segment.sampled);
        let residuals = self.knots.iter().map(|knot| knot.closure).chain(between);
        residuals.fold(0.0, f64::max)
    }

    /// What no closure residual of the whole motion exceeds.
    #[must_use]
    pub fn closure_bound(&self) -> f64 {
        let bounds = self.segments.iter().map(|segment| segment.bound);
        bounds.fold(self.closure(), f64::max)
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
    check_rigidity(path, options, &mut verdict);
    let mut motion = Motion::of(path);
    if options.samples == 0 {
        motion.segments.clear();
    }
    if verdict.failures.is_empty() {
        let wrong = turns::wrong_turn(&path.pattern, &motion);
        verdict.failures.extend(wrong);
    }
    // Numbers that overflow have been found by now.
    if motion.is_finite() {
        check_closure(path, &motion, options, &mut verdict);
        check_shapes(path, &motion, options, &mut verdict);
    }
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
        let mut rigidity = map.rigidity(pattern, &tree, &angles);
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
        for (edge, data) in path.pattern.edges().iter().enumerate() {
            let Node { angle, rate, .. } = knot.node(EdgeId::new(edge));
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

fn check_groups(path: &PathFile, failures: &mut Vec<String>) {
    let leaders = path.leaders();
    for (index, knot) in path.knots.iter().enumerate() {
        for (edge, member) in path.members.iter().enumerate() {
            let Some(member) = *member else { continue };
            let Some((leader, part)) = leaders[member.group.index()] else {
                continue;
            };
            // The way from an edge's angle to its group's is that back: a sign.
            let [expected, found] =
                [(leader, part), (EdgeId::new(edge), member)].map(|(edge, part)| {
                    let node = knot.node(edge);
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

/// Closure between knots, and with it the deformation of the whole sheet, by the most that it adds up to.
fn check_closure(path: &PathFile, motion: &Motion, options: &CheckOptions, verdict: &mut Verdict) {
    let pattern = &path.pattern;
    let tree = SpanningTree::from_central_face(pattern);
    let factors = Amplification::new(pattern, &tree);
    let worst = factors.map_or(1.0, |factors| factors.worst());
    verdict.segments = closure::certify(pattern, motion, options.bound / worst);
    #[allow(clippy::cast_precision_loss, reason = "a scale")]
    let rounding = ROUNDINGS * f64::EPSILON * pattern.faces().len() as f64;
    let closure = verdict.closure_bound();
    verdict.certified_deformation = factors
        .map(|factors| factors.deformation * closure + rounding)
        .filter(|deformation| deformation.is_finite());

    let segments = verdict.segments.iter().enumerate();
    let Some((index, segment)) = segments.max_by(|a, b| a.1.bound.total_cmp(&b.1.bound)) else {
        return;
    };
    let (bound, error) = (options.bound, worst * segment.bound + rounding);
    if error <= bound {
        return;
    }
    let name = |place: Option<Place>| place.map_or_else(String::new, |place| place.name(pattern));
    let knots = format!("between knots {index} and {}", index + 1);
    verdict.failures.push(if segment.sampled <= bound {
        let vertex = name(segment.place);
        let most = segment.bound;
        format!(
            "not certified: {knots}, {vertex} fails to close by up to {most:.3e}, by which the sheet \
             may deform or tear by {error:.3e}, over the bound {bound:.3e}"
        )
    } else {
        let (at, vertex, sampled) = (segment.at, name(segment.open), segment.sampled);
        format!("{knots}, at {at:.3}: {vertex} fails to close by {sampled:.3e}, over the bound {bound:.3e}")
    });
}

/// Shapes at knots and between: whether the sheet deforms there, and faces pass through each other.
fn check_shapes(path: &PathFile, motion: &Motion, options: &CheckOptions, verdict: &mut Verdict) {
    let pattern = &path.pattern;
    let tree = SpanningTree::from_central_face(pattern);
    let mut map = FoldingMap::new(pattern, &tree, &vec![0.0; pattern.creases().len()]);
    let mut scene = CollisionScene::new(pattern);
    for (index, knot) in path.knots.iter().enumerate() {
        let between_knots = [index.saturating_sub(1), index];
        let mut deepest: Option<PathCrossing> = None;
        let mut look = |map: &FoldingMap, gap, at| {
            let found = scene.deepest_crossing(map, gap);
            let found = found.filter(|f| deepest.is_none_or(|d| d.crossing.depth < f.depth));
            deepest = found.map_or(deepest, |crossing| {
                Some(PathCrossing {
                    crossing,
                    between_knots,
                    at,
                })
            });
        };
        for at in places(if index == 0 || motion.segments.is_empty() {
            0
        } else {
            options.samples
        }) {
            let segment = index - 1;
            let angles = motion.angles(segment, at);
            map.fold(pattern, &tree, &angles);
            let rigidity = map.rigidity(pattern, &tree, &angles);
            verdict.samples.push(Sample {
                segment,
                at,
                rigidity,
            });
            look(&map, rigidity.gap, at);
        }
        map.fold(pattern, &tree, &crease_angles(pattern, knot));
        look(
            &map,
            verdict.knots[index].rigidity.gap,
            if index == 0 { 0.0 } else { 1.0 },
        );
        verdict.crossings.extend(deepest);
    }
    let errors = verdict.samples.iter().map(|sample| {
        let Rigidity {
            deformation, gap, ..
        } = sample.rigidity;
        if deformation > gap || deformation.is_nan() {
            (sample, "deformation", deformation)
        } else {
            (sample, "gap", gap)
        }
    });
    let worst = errors.max_by(|a, b| a.2.total_cmp(&b.2));
    let bound = options.bound;
    if let Some((sample, name, value)) = worst.filter(|w| w.2 > bound || w.2.is_nan()) {
        let (segment, next, at) = (sample.segment, sample.segment + 1, sample.at);
        verdict.failures.push(format!(
            "between knots {segment} and {next}, at {at:.3}: {name} {value:.3e} over the bound {bound:.3e}"
        ));
    }
    if let Some(first) = verdict.crossings.first() {
        let ([before, knot], at) = (first.between_knots, first.at);
        let place = if at > 0.0 && at < 1.0 {
            format!("between knots {before} and {knot}, at {at:.3}")
        } else {
            format!("knot {knot}")
        };
        let [a, b] = first.crossing.faces;
        let depth = first.crossing.depth / pattern.median_edge();
        verdict.failures.push(format!(
            "{place}: faces {a} and {b} pass through each other, {depth:.3e} median edges deep"
        ));
    }
}

/// So many places inside a segment, evenly.
fn places(samples: usize) -> impl Iterator<Item = f64> {
    #[allow(clippy::cast_precision_loss, reason = "few")]
    let place = move |k: usize| (k + 1) as f64 / (samples + 1) as f64;
    (0..samples).map(place)
}
