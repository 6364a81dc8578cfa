//! Looks for crossings of a motion that is placed and measured: along the lattice of a tessellation, over the whole
//! motion, or at the knots alone.

use super::certified_motion::Lifting;
use super::lifted::{Lifted, Recourse};
use crate::collision::{
    Clearance, Crossing, Place, Routed, SearchEffort, Searched, SearchedSheet, SweepCounts,
    SweepVerdict,
};
use crate::lattice::Lattice;
use crate::motion::Knot;
use crate::planner::following::judge::Judge;
use crate::planner::following::reduction::CLOSED;
use crate::planner::knots::KnotSequence;
use crate::planner::options::Skips;
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{TimeoutAt, Undecided};
use crate::progress::Stage;

/// Fraction of the certified deformation that is aimed for at first, as another method of certification may be less
/// sharp.
pub(crate) const FIRST_BOUND_FRACTION: f64 = 0.5;
/// Smallest fraction of the certified deformation that is aimed for.
pub(crate) const LEAST_BOUND_FRACTION: f64 = 5e-5;
/// The same, if layers touch and the sheet may be torn by more than layers may overlap.
const NEAREST_BOUND_FRACTION: f64 = 5e-7;
/// Distances that a path which ends before a crossing keeps from the configuration at which faces meet, radians, tried
/// one after the other: the motion of the shorter path differs by as much as the bound allows.
const ROOMS_RAD: [f64; 2] = [1e-3, 1e-2];
/// Distances that a path keeps which only has to end near its goal, radians.
const WIDE_ROOMS_RAD: [f64; 4] = [1e-3, 1e-2, 3e-2, 1e-1];
/// Depth of a crossing at a waypoint, in median edges, above which motions near the waypoint cross too: many times the
/// distance of a motion from its path.
const BLOCKING_DEPTH: f64 = 0.01;

/// Answer of the search for crossings on a motion.
pub(crate) enum Swept {
    /// No faces cross. The smallest distance of two of them was found, if faces were looked at.
    Free(Option<Clearance>),
    /// Faces cross.
    Crosses(Crossed),
    /// Faces cross at the knot of this number, the first at which they do; only knots were looked at.
    CrossesAtKnot(Crossing, usize),
    /// The question stays open.
    Undecided(Undecided),
    /// Time ran out.
    Late(TimeoutAt),
    /// The motion is too far from its path, or no nearer than the one before: a nearer one may tell whether faces cross on
    /// the path, or where. Holds the crossing of this one, if one was found.
    TooFar(Option<Crossed>),
}

/// Crossing before which a path has to end.
pub(crate) struct Crossed {
    pub(crate) crossing: Crossing,
    /// Last place free of crossings, if there is one.
    pub(crate) free: Option<Place>,
    /// Group angles at which the path may end instead, if it may end earlier, to be tried one after the other.
    pub(crate) earlier: Vec<Vec<f64>>,
    /// `true` if the sheet crosses at a knot, although the search over the motion found nothing.
    pub(crate) is_at_knot: bool,
}

/// Returns the place as much before another one as the fastest hinge turns by `room` (radians), at most at the start of the
/// segment; `None` after the last segment.
pub(crate) fn place_before(knots: &KnotSequence, place: Place, room: f64) -> Option<Place> {
    let curves = knots.curves().nth(place.segment)?;
    let rates = curves
        .iter()
        .map(|curve| curve.derivatives(place.s)[0].abs());
    let fastest = rates.fold(f64::MIN_POSITIVE, f64::max);
    Some(Place {
        s: (place.s - room / fastest).max(0.0),
        ..place
    })
}

/// Returns the group angles as much before a place of a motion as the fastest hinge turns by `room` (radians), at most at
/// the start of the segment.
pub(crate) fn angles_before(knots: &KnotSequence, place: Place, room: f64) -> Option<Vec<f64>> {
    let Some(Place { segment, s }) = place_before(knots, place, room) else {
        return Some(knots.knots.get(place.segment)?.angles.clone());
    };
    let curves = knots.curves().nth(segment)?;
    Some(curves.iter().map(|curve| curve.angle(s)).collect())
}

impl<'a> Lifting<'a> {
    /// Looks for crossings over the whole motion, if asked to. `before` is the motion that was found too far from the path.
    pub(crate) fn sweep(&self, lifted: &mut Lifted, before: Option<&Lifted>) -> Swept {
        if !self.problem.options.collision {
            return Swept::Free(None);
        }
        if before.is_some_and(|before| lifted.knots.moves_as(&before.knots)) {
            if !lifted.goes_nearer(LEAST_BOUND_FRACTION) {
                lifted.recourse = Recourse::Nothing;
            }
            return Swept::TooFar(None);
        }
        let lattice = self.problem.stage(Stage::Symmetry, || self.lattice());
        let (swept, counts) =
            (self.problem).stage(Stage::Crossings, || self.sweep_with(lifted, lattice));
        lifted.crossings.counts = counts;
        swept
    }

    fn sweep_with(&self, lifted: &Lifted, lattice: Option<&Lattice>) -> (Swept, SweepCounts) {
        let skips = self.problem.options.skips;
        let segments: Vec<_> = lifted.knots.curves().collect();
        let closure = lifted.certified_closure();
        let sheet = self.sheet();
        let torn = sheet.is_torn(lifted.tear());
        let torn_goes_nearer = torn && lifted.goes_nearer(LEAST_BOUND_FRACTION);
        let angles = lifted.knots.knots.iter().flat_map(|knot| &knot.angles);
        let hides_contact = || {
            lifted.goes_nearer(NEAREST_BOUND_FRACTION)
                && sheet.tears_hide_contact(closure, angles.copied())
        };
        let effort = if skips == Skips::default() {
            &SearchEffort::PLAN
        } else {
            &SearchEffort::PLAN_ALL
        };
        let options = sheet.options(effort, closure.unwrap_or(f64::INFINITY));
        let options = options.with(|it| {
            it.skip_motion = skips.motion;
            it.skip_bounds = skips.bounds;
            it.skip_edges = skips.edges;
        });
        match sheet.search_planned(&segments, options, lattice, torn_goes_nearer, hides_contact) {
            Routed::Searched(searched) => self.answer(lifted, searched, torn),
            Routed::TooFar(counts) => (Swept::TooFar(None), counts),
        }
    }

    /// Returns what the result of a search says of the motion. A torn sheet is looked at once more at its knots.
    fn answer(&self, lifted: &Lifted, searched: Searched, torn: bool) -> (Swept, SweepCounts) {
        let swept = match searched.verdict {
            SweepVerdict::Free(clearance) => {
                match torn.then(|| self.crossed_knot(lifted)).flatten() {
                    None => Swept::Free(clearance),
                    Some(crossed) if lifted.goes_nearer(LEAST_BOUND_FRACTION) => {
                        Swept::TooFar(Some(crossed))
                    }
                    Some(crossed) => Swept::Crosses(crossed),
                }
            }
            SweepVerdict::Undecided { .. } if self.problem.is_late() => {
                Swept::Late(TimeoutAt::LookingForCrossings)
            }
            SweepVerdict::Undecided { faces: None, .. } => {
                return self.sweep_no_more_than_knots(&lifted.knots.knots);
            }
            SweepVerdict::Undecided { faces, at } => Swept::Undecided(Undecided::Crossings {
                faces,
                segment: at.segment,
            }),
            SweepVerdict::Crossing {
                crossing,
                last_free,
                ..
            } => {
                let crossed = self.crossed(lifted, crossing, last_free);
                let is_first = lifted.recourse == Recourse::GoNearer(FIRST_BOUND_FRACTION);
                let nearer = lifted.goes_nearer(LEAST_BOUND_FRACTION);
                if nearer && (is_first || !self.is_blocked()) {
                    Swept::TooFar(Some(crossed))
                } else {
                    Swept::Crosses(crossed)
                }
            }
        };
        (swept, searched.counts)
    }

    /// Returns where the path ends if faces cross on the motion after a place.
    fn crossed(&self, lifted: &Lifted, crossing: Crossing, last_free: Option<Place>) -> Crossed {
        let rooms: &[f64] = match lifted.recourse {
            Recourse::EndEarlier if self.problem.goes_near => &WIDE_ROOMS_RAD,
            Recourse::EndEarlier => &ROOMS_RAD,
            _ => &[],
        };
        let before = |room| angles_before(&lifted.knots, last_free?, room);
        Crossed {
            crossing,
            free: last_free,
            earlier: rooms.iter().filter_map(|&room| before(room)).collect(),
            is_at_knot: false,
        }
    }

    /// Returns the sheet, to be searched for crossings.
    pub(crate) fn sheet(&self) -> SearchedSheet<'a> {
        let PlanningProblem {
            pattern,
            contact,
            watch,
            ..
        } = *self.problem;
        let memberships = self.reduction.groups.memberships();
        SearchedSheet::new(pattern, memberships, Some(contact), watch)
    }

    /// Returns the lattice along which to look for crossings, if there is one and it may be used.
    fn lattice(&self) -> Option<&'a Lattice> {
        let used = self.problem.options.skips.symmetry;
        used.then(|| self.reduction.lattice(self.problem.pattern))
            .flatten()
    }

    /// Returns the crossing at the first knot at which faces cross: a second look, at whole shapes.
    fn crossed_knot(&self, lifted: &Lifted) -> Option<Crossed> {
        let mut judge = Judge::new(self.problem, self.reduction, false);
        let alike = lifted.errors.closure <= CLOSED;
        let (index, crossing) = judge.first_crossing(&lifted.knots.knots, alike)?;
        let before = index.checked_sub(1);
        let earlier = before.filter(|_| lifted.recourse == Recourse::EndEarlier);
        Some(Crossed {
            crossing,
            free: before.map(|segment| Place { segment, s: 0.0 }),
            earlier: earlier
                .map(|before| lifted.knots.knots[before].angles.clone())
                .into_iter()
                .collect(),
            is_at_knot: true,
        })
    }

    /// Returns `true` if faces cross at a waypoint by more than any motion is off the path: however near to the path a
    /// motion is, it crosses there.
    fn is_blocked(&self) -> bool {
        let problem = self.problem;
        let mut judge = Judge::new(problem, self.reduction, true);
        let deep = BLOCKING_DEPTH * problem.pattern.median_edge();
        let mut waypoints = self.waypoints.iter().take_while(|_| !problem.is_late());
        waypoints.any(|waypoint| {
            let crossing = judge.crossing_at(&waypoint.angles);
            crossing.is_some_and(|crossing| crossing.depth > deep)
        })
    }

    /// Looks for crossings of all faces at the knots alone, up to the first. If there is none, the question stays open.
    fn sweep_no_more_than_knots(&self, knots: &[Knot]) -> (Swept, SweepCounts) {
        let mut judge = Judge::new(self.problem, self.reduction, true);
        // A flat sheet has no crossings, as its faces lie beside each other.
        let turned = |(_, knot): &(usize, &Knot)| knot.angles.iter().any(|&angle| angle != 0.0);
        let mut turned = knots.iter().enumerate().filter(turned);
        let end = turned.find_map(|(index, knot)| {
            if self.problem.is_late() {
                return Some(Swept::Late(TimeoutAt::JudgingKnot(index)));
            }
            Some(Swept::CrossesAtKnot(
                judge.crossing_at(&knot.angles)?,
                index,
            ))
        });
        let faces = self.problem.pattern.faces().len();
        let open = Swept::Undecided(Undecided::CrossingsAtKnots { faces });
        (end.unwrap_or(open), judge.counts())
    }
}
