//! Distances between faces along a path, and the nearest pair of faces, by a sweep of the motion.

use serde::Serialize;

use super::Measured;
use super::merged_groups::MergedGroups;
use crate::collision::{Openness, Place, SearchEffort, SearchedSheet, Sweep, SweepVerdict};
use crate::motion::Motion;
use crate::pattern::FaceId;
use crate::progress::Watch;

/// The faces that come nearest to each other on a path, or the first that pass through each other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WorstPair {
    /// The faces, the smaller number first.
    pub faces: [FaceId; 2],
    /// Time, in seconds of the path.
    pub time: f64,
    /// Distance of the faces, or depth of their crossing, in units of the sheet.
    pub distance: f64,
    /// `true` if the faces pass through each other.
    pub crosses: bool,
}

/// Distances between faces that share no vertex along a path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clearances {
    /// For each shape the smallest distance, in units of the sheet; `None` if faces cross, all share vertices,
    /// or the answer would take too long.
    pub shapes: Vec<Option<f64>>,
    /// The worst pair of the motion.
    pub worst: Option<WorstPair>,
}

/// Returns the clearances of `path` at the knots of `shapes`, which are configurations of its motion, as
/// [`Motion::with_steps`] has them; `measured` has the measurements at these knots. Cost: a sweep of the
/// motion, and one of each shape.
#[must_use]
pub fn clearances(path: &Motion, shapes: &Motion, measured: &[Measured]) -> Clearances {
    clearances_until_over(path, shapes, measured, Watch::default())
}

/// Returns what [`clearances`] does; once the call is over, the remaining clearances stay unknown.
pub(crate) fn clearances_until_over(
    path: &Motion,
    shapes: &Motion,
    measured: &[Measured],
    watch: Watch<'_>,
) -> Clearances {
    let unknown = Clearances {
        shapes: vec![None; shapes.knots.len()],
        worst: None,
    };
    let motion = MergedGroups::of(path);
    let sheet = SearchedSheet::new(&path.pattern, motion.groups.memberships(), None, watch);
    let search = |effort| nearest((&motion, &sheet), measured, effort);
    let (Some(mut whole), Some(mut at_knots)) = (
        search(&SearchEffort::PICTURE),
        search(&SearchEffort::PICTURE_SHAPE),
    ) else {
        return unknown;
    };
    let of_motion = worst(&whole.sweep(&motion.segments), |at| time(path, at));
    let mut found = Clearances {
        worst: of_motion,
        ..unknown
    };
    for (index, (clearance, knot)) in found.shapes.iter_mut().zip(&shapes.knots).enumerate() {
        let verdict = at_knots.sweep(&[motion.at_rest(shapes, index)]);
        let pair = worst(&verdict, |_| knot.time);
        *clearance = pair.filter(|p| !p.crosses).map(|p| p.distance);
        let worse = |pair: &WorstPair| {
            let rank = |p: &WorstPair| (!p.crosses, p.distance);
            found.worst.is_none_or(|w| rank(pair) < rank(&w))
        };
        if of_motion.is_none() {
            found.worst = pair.filter(worse).or(found.worst);
        }
    }
    found
}

/// Returns the smallest distance of faces that share no vertex at each knot of a motion, units of the sheet: infinite if
/// all share one, 0 if faces cross, `None` if the search ended before it had an answer. `motion` has the groups of
/// `path`.
pub(super) fn knot_clearances(
    path: &Motion,
    (motion, sheet): (&MergedGroups, &SearchedSheet<'_>),
    measured: &[Measured],
) -> Vec<Option<f64>> {
    let effort = &SearchEffort::PICTURE_SHAPE;
    let Some(mut sweep) = nearest((motion, sheet), measured, effort) else {
        return vec![None; path.knots.len()];
    };
    let knots = 0..path.knots.len();
    let clearances = knots.map(|knot| match sweep.sweep(&[motion.at_rest(path, knot)]) {
        SweepVerdict::Free(clearance) => Some(clearance.map_or(f64::INFINITY, |c| c.distance)),
        SweepVerdict::Crossing { .. } => Some(0.0),
        SweepVerdict::Undecided { .. } => None,
    });
    clearances.collect()
}

/// Returns a search for the nearest faces; `None` if it would take too long, or numbers overflow.
fn nearest<'a>(
    (motion, sheet): (&MergedGroups, &'a SearchedSheet<'_>),
    measured: &[Measured],
    effort: &SearchEffort,
) -> Option<Sweep<'a>> {
    let most = |value: fn(&Measured) -> f64| measured.iter().map(value).fold(0.0, f64::max);
    let openness = Openness {
        closure: most(|knot| knot.closure),
        gap: most(|knot| knot.rigidity.gap),
    };
    let finite = motion.is_finite();
    finite.then(|| sheet.nearest(effort, openness))?
}

fn worst(verdict: &SweepVerdict, time: impl Fn(Place) -> f64) -> Option<WorstPair> {
    match *verdict {
        SweepVerdict::Free(clearance) => clearance.map(|clearance| WorstPair {
            faces: clearance.faces,
            time: time(clearance.place),
            distance: clearance.distance,
            crosses: false,
        }),
        SweepVerdict::Crossing { crossing, at, .. } => Some(WorstPair {
            faces: crossing.faces,
            time: time(at),
            distance: crossing.depth,
            crosses: true,
        }),
        SweepVerdict::Undecided { .. } => None,
    }
}

/// Returns the time at a place of the motion, in seconds of the path.
fn time(path: &Motion, Place { segment, s }: Place) -> f64 {
    let time = |knot: usize| path.knots.get(knot).map_or(0.0, |knot| knot.time);
    let (from, to) = (time(segment), time((segment + 1).min(path.knots.len() - 1)));
    from + s * (to - from)
}
