//! Looks for crossings on a path that is placed and measured, and ends the path before the first one.

use std::time::Instant;

use foldpath_core::Membership;

use super::course::Course;
use super::follow::max_difference;
use super::judge::Judge;
use super::knots::Knot;
use super::options::Skips;
use super::plan::{Outcome, Plan, Planning};
use super::reduction::{CLOSED, Reduction};
use super::reuse::{FIRST_PART, Found, LEAST_PART};
use crate::collision::{Crossing, Sweep, SweepCounts, SweepOptions, SweepVerdict, rounding};
use crate::folding::Rigidity;
use crate::lattice::Lattice;
use crate::progress::Stage;

/// Factor by which the fraction of the bound that is aimed for shrinks, if the motion crosses and its course may not.
const NEARER: f64 = 0.01;
/// Depth of a crossing at a waypoint, in median edges, above which motions near the waypoint cross too: many times the
/// distance of a motion from its course.
const BLOCKING: f64 = 0.01;
/// Largest distance before an inexact goal at which a path may stop so that nothing crosses, radians.
const RETREAT: f64 = 0.02;
/// Distance that such a path keeps from the configuration at which faces meet, radians.
const ROOM: f64 = 1e-3;
/// Largest number of faces for which the motion between knots is swept without a lattice.
const MOST_FACES: usize = 4000;
/// Largest number of faces for which a torn sheet is swept without its lattice at once. For more, a motion nearer to
/// the course is tried first, although it has more knots.
const TORN_FACES: usize = 400;

impl Planning<'_> {
    /// Returns the options of the search for crossings.
    fn sweep_options(&self) -> SweepOptions {
        let skips = self.options.skips;
        let certified = self.plan.certified_deformation.unwrap_or(0.0);
        let gap = certified.max(self.plan.rigidity.gap);
        let usual = SweepOptions::default();
        SweepOptions {
            gap,
            rounding: rounding(self.plan.rigidity.gap),
            // There is no limit for a user who switches a skip off, to look at everything.
            max_queries: if skips == Skips::default() {
                usual.max_queries
            } else {
                u64::MAX
            },
            skip_motion: skips.motion,
            skip_bounds: skips.bounds,
            skip_edges: skips.edges,
            ..usual
        }
    }

    /// Returns the lattice along which to look for crossings, if there is one and it may be used.
    pub(super) fn lattice<'r>(&self, reduction: &'r Reduction) -> Option<&'r Lattice> {
        let used = self.options.skips.symmetry;
        used.then(|| reduction.lattice(self.pattern)).flatten()
    }

    /// Looks for crossings along the lattice. Returns `None` if the faces may be far from where the lattice has them,
    /// or the lattice does not decide.
    fn sweep_lattice(
        &self,
        lattice: &Lattice,
        memberships: &[Membership],
        options: SweepOptions,
    ) -> Option<(SweepVerdict, SweepCounts)> {
        let torn = options.gap > SweepOptions::default().tolerance;
        let closure = self.plan.certified_closure.unwrap_or(f64::INFINITY);
        let lattice_deviation = if torn {
            lattice.lattice_deviation(self.pattern, closure)
        } else {
            0.0
        };
        let options = SweepOptions {
            lattice_deviation,
            ..options
        };
        let mut sweep = (lattice_deviation < SweepOptions::FAR_FROM_LATTICE_EDGES).then(|| {
            Sweep::with_lattice(self.pattern, memberships, options, lattice).watched(self.watch)
        })?;
        let verdict = sweep.sweep(&self.plan.path.curves());
        let decided = match verdict {
            SweepVerdict::Free(_) => true,
            // Too many cells may meet along the lattice, more than the pairs of faces that do meet.
            SweepVerdict::Undecided { faces: None, .. } => false,
            // On a torn sheet, faces that nearly touch along the lattice may not do so by the folding map.
            _ => !torn,
        };
        decided.then(|| (verdict, sweep.counts()))
    }

    /// Looks for crossings over the whole motion, and ends the path before the first one.
    pub(super) fn sweep(
        mut self,
        reduction: &Reduction,
        found: &Found<'_>,
        course: &Course,
    ) -> Plan {
        let mut start = Instant::now();
        self.watch.begin(Stage::Crossings);
        let lattice = self.lattice(reduction);
        self.plan.times.symmetry += start.elapsed();
        start = Instant::now();
        let options = self.sweep_options();
        let memberships = reduction.groups.memberships();
        let along = lattice.and_then(|lattice| self.sweep_lattice(lattice, memberships, options));
        let (verdict, counts) = if let Some(found) = along {
            found
        } else {
            self.plan.times.collision += start.elapsed();
            let faces = self.pattern.faces().len();
            let torn = options.gap > SweepOptions::default().tolerance;
            if lattice.is_some()
                && torn
                && faces > TORN_FACES
                && let Some(plan) = self.nearer(reduction, found)
            {
                return plan;
            }
            if faces > MOST_FACES {
                return self.sweep_no_more_than_knots(reduction);
            }
            start = Instant::now();
            let mut sweep = Sweep::new(self.pattern, memberships, options).watched(self.watch);
            (sweep.sweep(&self.plan.path.curves()), sweep.counts())
        };
        self.plan.collision = counts;
        self.plan.times.collision += start.elapsed();
        match verdict {
            SweepVerdict::Free(clearance) => {
                if let Some((index, crossing)) = self.crossed_knot(reduction, options.gap) {
                    if let Some(plan) = self.nearer(reduction, found) {
                        return plan;
                    }
                    let before = index.checked_sub(1);
                    let crossed = Crossed {
                        crossing,
                        segment: before.unwrap_or(0),
                        free: before.map(|before| self.plan.path.knots[before].angles.clone()),
                    };
                    return self.crossed(reduction, found, course, crossed);
                }
                self.plan.clearance = clearance;
                self.plan
            }
            SweepVerdict::Undecided { .. } if self.is_late() => {
                self.plan.reached = 0.0;
                let reason = "out of time while looking for crossings".into();
                self.end(Outcome::Timeout, reason)
            }
            SweepVerdict::Undecided { faces: None, .. } => self.sweep_no_more_than_knots(reduction),
            SweepVerdict::Undecided { faces, at } => {
                let faces = faces.map_or(String::new(), |[a, b]| format!(" of faces {a} and {b}"));
                self.plan.notes.push(format!(
                    "crossings are not decided: the search gave up at the pair{faces} between knots {} \
                     and {}",
                    at.segment,
                    at.segment + 1
                ));
                self.plan
            }
            SweepVerdict::Crossing {
                crossing,
                last_free,
                ..
            } => {
                // A sheet that is torn by more than the tolerance crosses elsewhere than its course does; a nearer
                // motion tells where.
                let torn = options.gap > SweepOptions::default().tolerance;
                let blocked = found.part < FIRST_PART && self.blocked(reduction, found);
                let nearer = (!blocked).then(|| self.nearer(reduction, found));
                let leads = |plan: &Plan| torn || plan.outcome == Outcome::Planned;
                if let Some(plan) = nearer.flatten().filter(leads) {
                    return plan;
                }
                let curves = self.plan.path.curves();
                let free: Option<Vec<f64>> = last_free.map(|place| {
                    let curves = curves[place.segment].iter();
                    let rates = curves
                        .clone()
                        .map(|curve| curve.derivatives(place.s)[0].abs());
                    let fastest = rates.fold(f64::MIN_POSITIVE, f64::max);
                    let room = if found.retreats { ROOM / fastest } else { 0.0 };
                    let s = (place.s - room).max(0.0);
                    curves.map(|curve| curve.angle(s)).collect()
                });
                let segment = last_free.map_or(0, |place| place.segment);
                self.crossed(
                    reduction,
                    found,
                    course,
                    Crossed {
                        crossing,
                        segment,
                        free,
                    },
                )
            }
        }
    }

    /// Returns the first knot at which faces cross, for a motion that may tear the sheet by `gap`. Between knots, faces
    /// round a vertex may lie across each other by as much as the gap, but not at the knots, where the sheet is hardly
    /// torn.
    fn crossed_knot(&mut self, reduction: &Reduction, gap: f64) -> Option<(usize, Crossing)> {
        let torn = gap > SweepOptions::default().tolerance;
        if !torn || self.pattern.faces().len() > MOST_FACES {
            return None;
        }
        let start = Instant::now();
        let mut judge = Judge::new(self.pattern, reduction, false);
        let alike = self.plan.max_closure <= CLOSED;
        let crossed = judge.first_crossing(&self.plan.path.knots, alike);
        self.plan.times.collision += start.elapsed();
        crossed
    }

    /// Looks for crossings at the knots alone, and adds a note about it.
    fn sweep_no_more_than_knots(self, reduction: &Reduction) -> Plan {
        let faces = self.pattern.faces().len();
        let mut plan = self.sweep_knots(reduction, Instant::now());
        if plan.outcome == Outcome::Planned {
            plan.notes.push(format!(
                "crossings were looked for at knots only: too many faces ({faces}) for the motion between them"
            ));
        }
        plan
    }

    /// Looks for crossings at the knots alone, among all faces. The search began at `start`.
    pub(super) fn sweep_knots(self, reduction: &Reduction, start: Instant) -> Plan {
        let mut judge = Judge::new(self.pattern, reduction, true);
        let plan = self.cross_at_knots(start, |knot| judge.crossing_at(&knot.angles));
        Plan {
            collision: judge.counts(),
            ..plan
        }
    }

    /// Ends the path before the first knot at which faces cross. The search began at `start`.
    pub(super) fn cross_at_knots(
        mut self,
        start: Instant,
        mut crossing_at: impl FnMut(&Knot) -> Option<Crossing>,
    ) -> Plan {
        let knots = core::mem::take(&mut self.plan.path.knots);
        // A flat sheet has no crossings, as its faces lie beside each other.
        let turned = |(_, knot): &(usize, &Knot)| knot.angles.iter().any(|&angle| angle != 0.0);
        let found = knots
            .iter()
            .enumerate()
            .filter(turned)
            .find_map(|(index, knot)| {
                if self.is_late() {
                    return Some((index, None));
                }
                Some((index, Some(crossing_at(knot)?)))
            });
        self.plan.path.knots = knots;
        self.plan.times.collision += start.elapsed();
        match found {
            Some((index, Some(crossing))) => self.crossed_at(index, crossing),
            Some((index, None)) => self.late_at(index),
            None => self.plan,
        }
    }

    /// Ends the path before a knot at which faces cross.
    pub(super) fn crossed_at(mut self, index: usize, crossing: Crossing) -> Plan {
        let last = self.plan.path.knots.last().map_or(1.0, |last| last.time);
        let before = index
            .checked_sub(1)
            .map_or(0.0, |before| self.plan.path.knots[before].time);
        self.plan.reached *= before / last;
        self.plan.path.knots.truncate(index);
        let [a, b] = crossing.faces;
        let reason = format!("faces {a} and {b} pass through each other at knot {index}");
        self.end(Outcome::Crossing(crossing), reason)
    }

    /// Returns `true` if faces cross at a waypoint by more than any motion is off the course: however near to the
    /// course a motion is, it crosses there.
    fn blocked(&mut self, reduction: &Reduction, found: &Found<'_>) -> bool {
        let start = Instant::now();
        let mut judge = Judge::new(self.pattern, reduction, true);
        let deep = BLOCKING * self.pattern.median_edge();
        let mut waypoints = found.waypoints.iter().take_while(|_| !self.is_late());
        let blocked = waypoints.any(|waypoint| {
            let crossing = judge.crossing_at(&waypoint.angles);
            crossing.is_some_and(|crossing| crossing.depth > deep)
        });
        self.plan.times.collision += start.elapsed();
        blocked
    }

    /// Returns the plan with the motion nearer to the course: if layers touch, a motion that is as far off the course
    /// as the bound allows may cross. Returns `None` if the motion is as near as it gets, or the nearer one decides
    /// nothing.
    pub(super) fn nearer(&self, reduction: &Reduction, found: &Found<'_>) -> Option<Plan> {
        if found.part <= LEAST_PART || found.retreats {
            return None;
        }
        let mut planning = Planning {
            plan: self.plan.clone(),
            ..*self
        };
        planning.plan.rigidity = Rigidity::default();
        planning.plan.max_closure = 0.0;
        let nearer = Found {
            part: found.part * NEARER,
            before: Some(&self.plan.path),
            ..*found
        };
        let plan = planning.judge(reduction, &nearer);
        matches!(plan.outcome, Outcome::Planned | Outcome::Crossing(_)).then_some(plan)
    }

    /// Ends the path before a crossing. If the goal is inexact and near the crossing, the path counts as reaching it;
    /// otherwise the plan gives the reason why it does not.
    fn crossed(
        mut self,
        reduction: &Reduction,
        found: &Found<'_>,
        course: &Course,
        crossed: Crossed,
    ) -> Plan {
        let Crossed {
            crossing,
            segment,
            free,
        } = crossed;
        let [a, b] = crossing.faces;
        let part = free.as_ref().map_or(0.0, |free| course.part(free));
        let reason = format!(
            "faces {a} and {b} pass through each other beyond {:.2} % of the path (between knots {segment} \
             and {}: {:.1e} median edges deep)",
            100.0 * found.reached * part,
            segment + 1,
            crossing.depth / self.pattern.median_edge()
        );
        let goal = found.waypoints.last().map_or(&[][..], |last| &last.angles);
        let short = free
            .as_ref()
            .map_or(f64::INFINITY, |free| max_difference(free, goal));
        if let Some(free) = free.filter(|_| found.retreats && short <= RETREAT)
            && let Some(waypoints) =
                course.cut(&mut reduction.solver(self.options, found.accepted), free)
        {
            self.plan.notes.push(format!(
                "the goal itself does not close (residual {:.1e}), and near it {reason}: the path ends {:.3} degrees before",
                self.plan.goal_closure,
                short.to_degrees(),
            ));
            let end = waypoints.last().map_or(&[][..], |last| &last.angles);
            self.plan.goal_error = reduction.distance(end, self.goal);
            self.plan.rigidity = Rigidity::default();
            let shorter = Found {
                waypoints: &waypoints,
                retreats: false,
                before: None,
                ..*found
            };
            return self.judge(reduction, &shorter);
        }
        self.plan.reached = found.reached * part;
        self.plan.path.knots.truncate(segment + 1);
        self.end(Outcome::Crossing(crossing), reason)
    }
}

/// Crossing before which a path has to end.
struct Crossed {
    crossing: Crossing,
    /// Number of the segment in which the path ends.
    segment: usize,
    /// Last group angles free of crossings, if there are any.
    free: Option<Vec<f64>>,
}
