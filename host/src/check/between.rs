//! Judges the motion between knots as a whole: closure, shapes and crossings.

use std::sync::Arc;

use foldpath_core::Curve;

use super::closure::{Effort, SegmentClosure, certify};
use super::finding::{Failure, Moment, SheetError, Undecided};
use super::merged_groups::MergedGroups;
use super::{CheckOptions, PathCrossing, Sample, Verdict, count};
use crate::certificate::{Closure, FoldingCertifier, SheetCertifier};
use crate::collision::{
    CollisionScene, Crossing, Openness, Place, Plates, SearchEffort, SearchedSheet, SweepVerdict,
    Trims, thickest,
};
use crate::folding::{FoldingMap, Rigidity, SpanningTree};
use crate::motion::{Motion, PlateOptions};
use crate::progress::Watch;
use crate::symmetry::ReducedStars;

/// Bounds closure between knots, and with it the deformation of the whole sheet. The deformation is bounded by
/// the worst case of the sum of all closure residuals or, if that is too much, by folding the sheet from its
/// middle and from its rim.
pub(super) fn check_closure(
    path: &Motion,
    tree: &SpanningTree,
    motion: &MergedGroups,
    options: &CheckOptions,
    watch: Watch<'_>,
    verdict: &mut Verdict,
) {
    let pattern = &path.pattern;
    let all = ReducedStars::all(pattern, &motion.groups);
    let essential = all.essential();
    let mut sheet = SheetCertifier::new(pattern, tree, &all);
    let mut bound = |curves: &[Curve<f64>], effort: &Effort| {
        let (mut segment, bounds) = certify(pattern, &essential, curves, effort, options.bound);
        let (stars, holes) = bounds.split_at(essential.vertices().len());
        let closure = Closure {
            stars: stars.to_vec(),
            loops: holes.iter().map(|&bound| [bound; 2]).collect(),
        };
        let rigidity = sheet.as_mut().map(|sheet| sheet.rigidity(&closure));
        segment.rigidity = rigidity.filter(|r| r.worst().is_finite());
        segment
    };
    let mut folded: Option<FoldingCertifier<'_>> = None;
    let segments = motion.segments.iter().enumerate();
    let segments = segments.map(|(index, curves)| {
        if watch.is_over() {
            return SegmentClosure::UNJUDGED;
        }
        watch.done(index, motion.segments.len());
        let rough = bound(curves, &Effort::ROUGH);
        if rough.error() <= options.bound || rough.sampled > options.bound {
            return rough;
        }
        let mut fine = bound(curves, &Effort::FINE);
        if fine.error() > options.bound && fine.bound <= options.bound {
            let certifier = || FoldingCertifier::new(pattern, motion.groups.memberships());
            let folded = folded.get_or_insert_with(certifier);
            fine.rigidity = folded.rigidity(curves, options.bound).or(fine.rigidity);
        }
        fine
    });
    verdict.segments = segments.collect();
    judge_segments(options.bound, verdict);
}

/// Stores the worst violation of the bound on closure between knots, or else the worst segment that is not proved to keep
/// it.
fn judge_segments(bound: f64, verdict: &mut Verdict) {
    let worst = |value: fn(&SegmentClosure) -> f64| {
        let segments = verdict.segments.iter().enumerate();
        let segments = segments.filter(|(_, segment)| segment.is_judged());
        segments.max_by(|a, b| value(a.1).total_cmp(&value(b.1)))
    };
    let Some((index, open)) = worst(|segment| segment.sampled) else {
        return;
    };
    if open.sampled > bound || open.sampled.is_nan() {
        verdict.failures.push(Failure::FailsToClose {
            at: Moment::Between {
                segment: index,
                s: open.at,
            },
            site: open.open,
            residual: open.sampled,
            bound,
        });
        return;
    }
    if let Some((index, worst)) = worst(SegmentClosure::error)
        && (worst.error() > bound || worst.error().is_nan())
    {
        verdict.undecided.push(Undecided::Errors {
            segment: index,
            site: worst.place,
            closure: worst.bound,
            error: worst.error(),
            bound,
        });
    }
}

/// Returns what a search for crossings may cost after what is known so far, and how far the sheet is from closing.
fn search_of(verdict: &Verdict, options: &CheckOptions) -> (SearchEffort, Openness) {
    let certified = verdict.certified().map(|most| most.gap);
    let certified = certified.filter(|gap| *gap <= options.bound);
    // The motion of a path that fails may be absurd.
    let effort = if verdict.holds() {
        SearchEffort::CHECK
    } else {
        SearchEffort::CHECK_FAILED
    };
    let openness = Openness {
        closure: verdict.closure_bound(),
        gap: certified.unwrap_or_else(|| verdict.rigidity().gap),
    };
    (effort, openness)
}

/// Searches the whole motion for faces that pass through each other, and stores the first crossing.
pub(super) fn check_crossings(
    path: &Motion,
    tree: &SpanningTree,
    (motion, sheet): (&MergedGroups, &SearchedSheet<'_>),
    options: &CheckOptions,
    verdict: &mut Verdict,
) {
    let (effort, openness) = search_of(verdict, options);
    let gap = openness.gap;
    let searched = sheet.search(&motion.segments, &effort, openness);
    match searched.verdict {
        SweepVerdict::Free(clearance) => {
            // The knots of a torn sheet are looked at once more, each as a whole.
            if sheet.is_torn(gap) {
                let crossing = crossed_knot(path, tree, verdict);
                verdict.crossings.extend(crossing);
            }
            verdict.min_clearance = clearance.map(|clearance| clearance.distance);
        }
        SweepVerdict::Crossing { crossing, at, .. } => verdict.crossings.push(PathCrossing {
            crossing,
            between_knots: [at.segment, at.segment + 1],
            at: at.s,
        }),
        SweepVerdict::Undecided { faces, at } => verdict.undecided.push(Undecided::Crossings {
            at: Moment::Between {
                segment: at.segment,
                s: at.s,
            },
            faces,
        }),
    }
}

/// Makes the plates that the file names, for the angles that its hinges have, and searches the whole motion for plates that
/// pass through each other. Plates are not looked at if thin faces cross.
pub(super) fn check_plates(
    path: &Motion,
    (motion, sheet): (&MergedGroups, &SearchedSheet<'_>),
    (options, check): (&PlateOptions, &CheckOptions),
    verdict: &mut Verdict,
    watch: Watch<'_>,
) {
    let pattern = &path.pattern;
    if !verdict.crossings.is_empty() {
        return;
    }
    let trims = Trims::of(path, options);
    let memberships = motion.groups.memberships();
    let (effort, openness) = search_of(verdict, check);
    let search = |plates: Arc<Plates>| {
        let plated = SearchedSheet::new(pattern, memberships, Some(sheet.contact), watch);
        let plated = plated.made_of(plates);
        plated.search(&motion.segments, &effort, openness)
    };
    if check.thickest {
        let found = thickest(pattern, &trims, options, |plates| search(plates).verdict);
        verdict.thickest = Some(found);
    }
    let plates = match Plates::new(pattern, &trims, options) {
        Ok(plates) => plates,
        Err(error) => return verdict.failures.push(Failure::PlatesNotMade(error)),
    };
    let searched = search(Arc::new(plates));
    let moment = |at: Place| Moment::Between {
        segment: at.segment,
        s: at.s,
    };
    match searched.verdict {
        SweepVerdict::Free(clearance) => {
            verdict.min_clearance =
                clearance.map_or(verdict.min_clearance, |clearance| Some(clearance.distance));
        }
        SweepVerdict::Crossing { crossing, at, .. } => {
            verdict.failures.push(Failure::PlatesCross {
                at: moment(at),
                crossing,
                thickness: options.thickness,
            });
        }
        SweepVerdict::Undecided { faces, at } => verdict.undecided.push(Undecided::Plates {
            at: moment(at),
            faces,
        }),
    }
}

/// Returns the first knot at which faces pass through each other.
fn crossed_knot(path: &Motion, tree: &SpanningTree, verdict: &Verdict) -> Option<PathCrossing> {
    let pattern = &path.pattern;
    let (mut map, mut scene) = (FoldingMap::flat(pattern), CollisionScene::new(pattern));
    (0..path.knots.len()).find_map(|index| {
        map.fold(pattern, tree, &path.crease_angles(index));
        let crossing = scene.deepest_crossing(&map, verdict.contact_tolerance)?;
        Some(PathCrossing {
            crossing,
            between_knots: [index.saturating_sub(1), index],
            at: if index == 0 { 0.0 } else { 1.0 },
        })
    })
}

/// Judges shapes at knots and between: deformation of the sheet and, unless the motion is swept, crossings of
/// faces.
pub(super) fn check_shapes(
    path: &Motion,
    tree: &SpanningTree,
    motion: &MergedGroups,
    options: &CheckOptions,
    watch: Watch<'_>,
    verdict: &mut Verdict,
) {
    let pattern = &path.pattern;
    let mut map = FoldingMap::flat(pattern);
    let mut scene = (!options.sweep).then(|| CollisionScene::new(pattern));
    let contact = verdict.contact_tolerance;
    for index in 0..path.knots.len() {
        if watch.is_over() {
            break;
        }
        watch.done(index, path.knots.len());
        let segment = index.checked_sub(1).filter(|_| options.samples > 0);
        let inside = segment.into_iter().flat_map(|_| places(options.samples));
        let end = if index == 0 { 0.0 } else { 1.0 };
        let mut deepest: Option<Crossing> = None;
        let mut place = end;
        // Knots have been measured: they are only searched for crossings.
        for at in inside.chain(scene.is_some().then_some(end)) {
            let between = segment.filter(|_| at < 1.0);
            let angles = between.map_or_else(
                || path.crease_angles(index),
                |segment| motion.angles(segment, at),
            );
            map.fold(pattern, tree, &angles);
            let rigidity = map.rigidity(pattern, tree);
            verdict.samples.extend(between.map(|segment| Sample {
                segment,
                at,
                rigidity,
            }));
            let found = scene.as_mut();
            let found = found.and_then(|scene| scene.deepest_crossing(&map, contact));
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
    verdict.failures.extend(worst_sample(options, verdict));
}

/// Returns `samples` places inside a segment, evenly spaced.
fn places(samples: usize) -> impl Iterator<Item = f64> {
    (0..samples).map(move |k| count(k + 1) / count(samples + 1))
}

/// Returns the worst violation of the bound between knots.
fn worst_sample(options: &CheckOptions, verdict: &Verdict) -> Option<Failure> {
    let errors = verdict.samples.iter().map(|sample| {
        let Rigidity {
            deformation, gap, ..
        } = sample.rigidity;
        if deformation > gap || deformation.is_nan() {
            (sample, SheetError::Deformation, deformation)
        } else {
            (sample, SheetError::Gap, gap)
        }
    });
    let bound = options.bound;
    let over = errors.filter(|(.., value)| *value > bound || value.is_nan());
    let (sample, error, value) = over.max_by(|a, b| a.2.total_cmp(&b.2))?;
    Some(Failure::OverBound {
        at: Moment::Between {
            segment: sample.segment,
            s: sample.at,
        },
        error,
        value,
        bound,
        open: None,
    })
}

/// Returns the first crossing as a fault of the path.
pub(super) fn first_crossing(path: &Motion, verdict: &Verdict) -> Option<Failure> {
    let first = verdict.crossings.first()?;
    let ([before, knot], at) = (first.between_knots, first.at);
    let at = if at > 0.0 && at < 1.0 {
        Moment::Between {
            segment: before,
            s: at,
        }
    } else {
        Moment::Knot(if at > 0.0 { knot } else { before })
    };
    Some(Failure::Crosses {
        at,
        crossing: first.crossing,
        depth_edges: first.crossing.depth / path.pattern.median_edge(),
    })
}
