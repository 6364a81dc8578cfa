//! Distances between faces along a path, and the nearest pair of faces, by a sweep of the motion.

use foldpath_core::Curve;

use super::Measured;
use super::merged_groups::MergedGroups;
use crate::collision::{Place, SearchEffort, Sweep, SweepOptions, SweepVerdict, contact_tolerance};
use crate::motion::Motion;
use crate::pattern::FaceId;
use crate::progress::Watch;

/// The faces that come nearest to each other on a path, or the first that pass through each other.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    let pattern = &path.pattern;
    let unknown = Clearances {
        shapes: vec![None; shapes.knots.len()],
        worst: None,
    };
    let motion = MergedGroups::of(path);
    let members = motion.groups.memberships();
    let gap = (measured.iter().map(|m| m.rigidity.gap)).fold(0.0, f64::max);
    let closure = measured.iter().map(|m| m.closure).fold(0.0, f64::max);
    let lattice = SearchEffort::PICTURE.lattice(pattern, members, gap);
    if !motion.is_finite() || !SearchEffort::PICTURE.affords(pattern, lattice.as_ref()) {
        return unknown;
    }
    let [mut sweep, mut still_sweep] =
        [SearchEffort::PICTURE, SearchEffort::PICTURE_SHAPE].map(|effort| {
            let options = SweepOptions {
                closure,
                contact: contact_tolerance(pattern),
                max_queries: effort.max_queries,
                ..SweepOptions::default()
            };
            Sweep::build(pattern, members, options, lattice.as_ref()).watched(watch)
        });
    let mut found = Clearances {
        worst: worst(&sweep.sweep(&motion.segments), |at| time(path, at)),
        ..unknown
    };
    let moving = found.worst.is_some();
    for (index, clearance) in found.shapes.iter_mut().enumerate() {
        let time = shapes.knots[index].time;
        let leaders = motion.leaders.iter();
        let angles = leaders.map(|&leader| shapes.node(index, leader).angle);
        // A motion that stays where it is.
        let still = angles.map(|angle| Curve::Angle([angle; 4])).collect();
        let pair = worst(&still_sweep.sweep(&[still]), |_| time);
        *clearance = pair.filter(|p| !p.crosses).map(|p| p.distance);
        let worse = |pair: &WorstPair| {
            let rank = |p: &WorstPair| (!p.crosses, p.distance);
            found.worst.is_none_or(|w| rank(pair) < rank(&w))
        };
        if !moving {
            found.worst = pair.filter(worse).or(found.worst);
        }
    }
    found
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
