//! The motion between knots, judged as one.

use super::closure::{Place, certify};
use super::knots::crease_angles;
use super::motion::Motion;
use super::{CheckOptions, PathCrossing, Sample, Verdict, count};
use crate::collision::{CollisionScene, Crossing};
use crate::folding::{Amplification, FoldingMap, Rigidity, SpanningTree};
use crate::formats::fold::PathFile;

/// Roundings that each face adds to the positions of those behind it.
const ROUNDINGS: f64 = 16.0;

/// Closure between knots, and with it the deformation of the whole sheet, by the most that it adds up to.
pub(super) fn check_closure(
    path: &PathFile,
    motion: &Motion,
    options: &CheckOptions,
    verdict: &mut Verdict,
) {
    let pattern = &path.pattern;
    let tree = SpanningTree::from_central_face(pattern);
    let factors = Amplification::new(pattern, &tree);
    let worst = factors.map_or(1.0, |factors| factors.worst());
    verdict.segments = certify(pattern, motion, options.bound / worst);
    let rounding = ROUNDINGS * f64::EPSILON * count(pattern.faces().len());
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
pub(super) fn check_shapes(
    path: &PathFile,
    motion: &Motion,
    options: &CheckOptions,
    verdict: &mut Verdict,
) {
    let pattern = &path.pattern;
    let tree = SpanningTree::from_central_face(pattern);
    let mut map = FoldingMap::new(pattern, &tree, &vec![0.0; pattern.creases().len()]);
    let mut scene = CollisionScene::new(pattern);
    for (index, knot) in path.knots.iter().enumerate() {
        let segment = index.checked_sub(1).filter(|_| options.samples > 0);
        let inside = segment.into_iter().flat_map(|_| places(options.samples));
        let end = if index == 0 { 0.0 } else { 1.0 };
        let mut deepest: Option<Crossing> = None;
        let mut place = end;
        for at in inside.chain([end]) {
            let between = segment.filter(|_| at < 1.0);
            let angles = between.map_or_else(
                || crease_angles(pattern, knot),
                |segment| motion.angles(segment, at),
            );
            map.fold(pattern, &tree, &angles);
            let rigidity = map.rigidity(pattern, &tree);
            verdict.samples.extend(between.map(|segment| Sample {
                segment,
                at,
                rigidity,
            }));
            let found = scene.deepest_crossing(&map, rigidity.gap);
            if let Some(found) = found.filter(|f| deepest.is_none_or(|d| d.depth < f.depth)) {
                (deepest, place) = (Some(found), at);
            }
        }
        verdict
            .crossings
            .extend(deepest.map(|crossing| PathCrossing {
                crossing,
                between_knots: [index.saturating_sub(1), index],
                at: place,
            }));
    }
    let failures = [
        worst_sample(options, verdict),
        first_crossing(path, verdict),
    ];
    verdict.failures.extend(failures.into_iter().flatten());
}

/// So many places inside a segment, evenly.
fn places(samples: usize) -> impl Iterator<Item = f64> {
    (0..samples).map(move |k| count(k + 1) / count(samples + 1))
}

/// What breaks the bound most between knots, in words.
fn worst_sample(options: &CheckOptions, verdict: &Verdict) -> Option<String> {
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
    let bound = options.bound;
    let over = errors.filter(|(.., value)| *value > bound || value.is_nan());
    let (sample, name, value) = over.max_by(|a, b| a.2.total_cmp(&b.2))?;
    let (segment, next, at) = (sample.segment, sample.segment + 1, sample.at);
    Some(format!(
        "between knots {segment} and {next}, at {at:.3}: {name} {value:.3e} over the bound {bound:.3e}"
    ))
}

/// The first crossing, in words.
fn first_crossing(path: &PathFile, verdict: &Verdict) -> Option<String> {
    let first = verdict.crossings.first()?;
    let ([before, knot], at) = (first.between_knots, first.at);
    let place = if at > 0.0 && at < 1.0 {
        format!("between knots {before} and {knot}, at {at:.3}")
    } else {
        format!("knot {knot}")
    };
    let [a, b] = first.crossing.faces;
    let depth = first.crossing.depth / path.pattern.median_edge();
    Some(format!(
        "{place}: faces {a} and {b} pass through each other, {depth:.3e} median edges deep"
    ))
}
