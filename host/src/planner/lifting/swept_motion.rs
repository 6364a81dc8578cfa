//! Looks for crossings of a motion that is placed and measured: along the lattice of a tessellation, over the whole
//! motion, or at the knots alone.

use super::certified_motion::Lifting;
use crate::collision::{Crossing, SearchEffort, SweepOptions};
use crate::lattice::Lattice;
use crate::planner::following::judge::Judge;
use crate::planner::following::reduction::CLOSED;
use crate::planner::knots::Knot;
use crate::planner::options::Skips;
use crate::planner::plan::{Failure, Outcome, Plan};
use crate::planner::reason::{Reason, TimeoutAt, Undecided};
use crate::util::clock::Instant;

/// Depth of a crossing at a waypoint, in median edges, above which motions near the waypoint cross too: many times the
/// distance of a motion from its path.
const BLOCKING_DEPTH: f64 = 0.01;
/// Ratio of the sum of all tears to the depth that counts as a crossing above which tears may hide contact.
const HIDING_RATIO: f64 = 0.1;
/// Difference of a fold angle from half a turn up to which the faces at a crease may be layers that touch, radians.
const NEARLY_FOLDED_RAD: f64 = 1e-3;

/// Returns the options of the search for crossings of a sheet whose closure residuals are proved to be at most `closure`
/// all along the motion. Overlaps of up to `contact` median edges are contact.
pub(crate) fn sweep_options(skips: Skips, closure: Option<f64>, contact: f64) -> SweepOptions {
    let usual = SweepOptions::default();
    SweepOptions {
        closure: closure.unwrap_or(f64::INFINITY),
        contact,
        // There is no limit for a user who switches a skip off, to look at everything.
        max_queries: if skips == Skips::default() {
            SearchEffort::PLAN.max_queries
        } else {
            u64::MAX
        },
        skip_motion: skips.motion,
        skip_bounds: skips.bounds,
        skip_edges: skips.edges,
        ..usual
    }
}

impl<'a> Lifting<'a> {
    /// Returns the lattice along which to look for crossings, if there is one and it may be used.
    pub(crate) fn lattice(&self) -> Option<&'a Lattice> {
        let used = self.problem.options.skips.symmetry;
        used.then(|| self.reduction.lattice(self.problem.pattern))
            .flatten()
    }

    /// Returns `true` if layers may touch on the motion, and the sheet may be torn by more than faces that touch may overlap:
    /// whether layers that move together pass through each other is then hard to tell.
    pub(crate) fn tears_hide_contact(&self, plan: &Plan) -> bool {
        let (pattern, tree) = (self.problem.pattern, self.reduction.tree);
        let flat = core::f64::consts::PI - NEARLY_FOLDED_RAD;
        let angles = plan.path.knots.iter().flat_map(|knot| &knot.stored.angles);
        let touches = angles.copied().any(|angle| angle.abs() >= flat);
        let holonomy = tree.holonomy(pattern).filter(|_| touches);
        let (Some(holonomy), Some(closure)) = (holonomy, plan.certified_closure) else {
            return false;
        };
        let length = tree.reach(pattern);
        let tears = holonomy.tears(closure).into_iter();
        let sum: f64 = tears.map(|tear| tear.shift + tear.turn * length).sum();
        sum > HIDING_RATIO * SweepOptions::default().contact * pattern.median_edge()
    }

    /// Returns the first knot at which faces of a torn sheet cross, and the crossing: a second look, at whole shapes.
    pub(crate) fn crossed_knot(&self, plan: &Plan) -> Option<(usize, Crossing)> {
        let mut judge = Judge::new(self.problem, self.reduction, false);
        judge.first_crossing(&plan.path.knots, plan.max_closure <= CLOSED)
    }

    /// Returns `true` if faces cross at a waypoint by more than any motion is off the path: however near to the path a
    /// motion is, it crosses there.
    pub(crate) fn is_blocked(&self) -> bool {
        let problem = self.problem;
        let mut judge = Judge::new(problem, self.reduction, true);
        let deep = BLOCKING_DEPTH * problem.pattern.median_edge();
        let waypoints = self.candidate.waypoints.iter();
        let mut waypoints = waypoints.take_while(|_| !problem.is_late());
        waypoints.any(|waypoint| {
            let crossing = judge.crossing_at(&waypoint.angles);
            crossing.is_some_and(|crossing| crossing.depth > deep)
        })
    }

    /// Looks for crossings of all faces at the knots alone. Ends the path before the first, or else leaves the question
    /// open.
    pub(crate) fn sweep_no_more_than_knots(&self, mut plan: Plan) -> Plan {
        let start = Instant::now();
        let mut judge = Judge::new(self.problem, self.reduction, true);
        let knots = &plan.path.knots;
        // A flat sheet has no crossings, as its faces lie beside each other.
        let turned =
            |(_, knot): &(usize, &Knot)| knot.stored.angles.iter().any(|&angle| angle != 0.0);
        let mut turned = knots.iter().enumerate().filter(turned);
        let end = turned.find_map(|(index, knot)| {
            if self.problem.is_late() {
                return Some((index, None));
            }
            Some((index, Some(judge.crossing_at(&knot.stored.angles)?)))
        });
        plan.times.collision += start.elapsed();
        plan.collision = judge.counts();
        let (index, crossing) = match end {
            Some((index, Some(crossing))) => (index, crossing),
            Some((index, None)) => {
                return plan.ended(Failure::out_of_time(TimeoutAt::JudgingKnot(index)));
            }
            None => {
                let faces = self.problem.pattern.faces().len();
                plan.undecided.push(Undecided::CrossingsAtKnots { faces });
                return plan;
            }
        };
        let last = knots.last().map_or(1.0, |last| last.stored.time);
        let before = index
            .checked_sub(1)
            .map_or(0.0, |before| knots[before].stored.time);
        let failure = Failure {
            outcome: Outcome::Crossing(crossing),
            reason: Reason::CrossesAtKnot {
                faces: crossing.faces,
                knot: index,
            },
            kept: before / last,
        };
        plan.path.knots.truncate(index);
        plan.ended(failure)
    }
}
