//! Lifts a path found on few unknowns to the whole sheet: certified, measured and swept for crossings. If layers touch,
//! a motion that is as far off its path as the bound allows may cross: it is then lifted again, nearer to the path.

use foldpath_core::Interpolation;

use super::certified_motion::{CandidatePath, Certificate, Lifting};
use super::measured_motion::{MeasuredMotion, torn};
use super::swept_motion::sweep_options;
use crate::collision::{Crossing, Place, Searched, SearchedMotion, SweepVerdict, is_torn};
use crate::folding::Rigidity;
use crate::planner::following::follow::Waypoint;
use crate::planner::following::reduction::Reduction;
use crate::planner::knots::{Knot, Path};
use crate::planner::placement::reduced_path::ReducedPath;
use crate::planner::plan::{Failure, Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{Note, Reason, TimeoutAt, Undecided};
use crate::planner::vectors::max_difference;
use crate::progress::Stage;
use crate::util::clock::Instant;

/// Fraction of the certified deformation that is aimed for at first, as another method of certification may be less
/// sharp.
pub(crate) const FIRST_BOUND_FRACTION: f64 = 0.5;
/// Factor by which the fraction of the bound that is aimed for shrinks, if the motion crosses and its path may not.
const NEARER_FACTOR: f64 = 0.01;
/// Smallest fraction of the certified deformation that is aimed for.
pub(crate) const LEAST_BOUND_FRACTION: f64 = 5e-5;
/// The same, if layers touch and the sheet may be torn by more than layers may overlap.
const NEAREST_BOUND_FRACTION: f64 = 5e-7;
/// Number of queries of pairs after which a motion nearer to the path is tried, if tears may hide contact.
const MAX_HIDDEN_QUERIES: u64 = 200_000;
/// Largest distance before an inexact goal at which a path may stop so that nothing crosses, radians.
const MAX_RETREAT_RAD: f64 = 0.02;
/// Distances that such a path keeps from the configuration at which faces meet, radians, tried one after the other: the
/// motion of the shorter path differs by as much as the bound allows.
const ROOMS_RAD: [f64; 2] = [1e-3, 1e-2];
/// Distances that a path keeps which only has to end near its goal, radians.
const WIDE_ROOMS_RAD: [f64; 4] = [1e-3, 1e-2, 3e-2, 1e-1];
/// Largest number of faces for which a torn sheet is swept without its lattice at once. For more, a motion nearer to
/// the path is tried first, although it has more knots.
const MAX_TORN_FACES: usize = 400;

/// Lifts a path to the whole sheet and judges it there. `plan` is the plan so far; the motion, its errors and what ends
/// it are stored in the plan that is returned.
pub(crate) fn lift(
    problem: &PlanningProblem<'_>,
    reduction: &Reduction<'_>,
    candidate: &CandidatePath<'_>,
    mut plan: Plan,
) -> Plan {
    plan.reached = candidate.reached;
    plan.waypoints = candidate.waypoints.len();
    let path = ReducedPath::new(candidate.waypoints);
    let lifting = Lifting {
        problem,
        reduction,
        candidate,
        path: &path,
    };
    let placement = lifting.place_knots();
    plan.times.place += placement.time;
    store_certificate(&mut plan, placement.certificate);
    let Some(mut knots) = placement.knots else {
        let failure = lifting.unplaced();
        if failure.outcome == Outcome::Timeout {
            return ended_unjudged(problem, candidate.waypoints, plan, failure);
        }
        return plan.ended(failure);
    };
    let bound = problem.options.bound;
    let mut certificate = placement.certificate;
    let mut proof_stops = None;
    // A motion that closes at its knots, but is not proved to keep the bound, ends before the first segment that is not
    // known to close well enough.
    if let Some(certified) = certificate.and_then(|certificate| certificate.over(bound))
        && knots.cut()
    {
        certificate = Some(lifting.certify(&reduction.all, &knots));
        store_certificate(&mut plan, certificate);
        let end = knots.knots.last().map_or(&[][..], |end| &end.stored.angles);
        plan.goal_error = reduction.distance(end, problem.goal);
        plan.reached *= path.fraction(end);
        proof_stops = Some(Reason::ProofStops {
            reached: plan.reached,
            certified,
            bound,
        });
    }
    plan.path.interpolation = knots.interpolation;
    problem.watch.begin(Stage::Folding);
    let motion = lifting.measure(knots.knots);
    if let Some(knot) = motion.late {
        let failure = Failure::out_of_time(TimeoutAt::JudgingKnot(knot));
        return ended_unjudged(problem, candidate.waypoints, plan, failure);
    }
    store_motion(&mut plan, motion);
    if let Some(failure) = torn(bound, &plan, certificate) {
        return plan.ended(failure);
    }
    let (failure, time) = lifting.torn_from_rim(&plan);
    plan.times.fold += time;
    if let Some(failure) = failure {
        return plan.ended(failure);
    }
    if proof_stops.is_none() {
        return lifting.sweep_if_asked(plan);
    }
    // The path ends where its proof ends, so that it is neither shortened nor brought nearer to the reduced path.
    let candidate = CandidatePath {
        retreats: false,
        bound_fraction: LEAST_BOUND_FRACTION,
        ..*candidate
    };
    let lifting = Lifting {
        candidate: &candidate,
        ..lifting
    };
    let mut plan = lifting.sweep_if_asked(plan);
    if plan.outcome == Outcome::Planned {
        (plan.outcome, plan.reason) = (Outcome::Partial, proof_stops);
    }
    plan
}

fn store_certificate(plan: &mut Plan, certificate: Option<Certificate>) {
    if let Some(certificate) = certificate {
        plan.certified_closure = certificate.closure;
        plan.certified_deformation = Some(certificate.deformation);
    }
}

/// Stores a measured motion in the plan.
fn store_motion(plan: &mut Plan, motion: MeasuredMotion) {
    plan.times.fold += motion.time;
    plan.rigidity = motion.worst();
    plan.max_closure = motion.max_closure(plan.max_closure);
    if let Some(essential) = motion.essential {
        (plan.essential_rigidity, plan.essential_faces) = essential;
    }
    plan.path.knots = motion.knots;
}

/// Returns the waypoints as knots, as far apart in time as the largest speed of the hinges (radians per second)
/// requires. The errors of the sheet are not measured.
fn unmeasured(waypoints: &[Waypoint], max_speed: f64) -> Vec<Knot> {
    let mut time = 0.0;
    let mut before: Option<&[f64]> = None;
    let knots = waypoints.iter().map(|waypoint| {
        let turned = before.map_or(0.0, |before| max_difference(before, &waypoint.angles));
        time += turned / max_speed;
        before = Some(&waypoint.angles);
        let mut knot = Knot::at(waypoint.angles.clone());
        knot.stored.time = time;
        knot.stored.rates = vec![0.0; waypoint.angles.len()];
        knot.ends_phase = waypoint.ends_phase;
        knot
    });
    knots.collect()
}

/// Ends a plan as time ran out before its path was judged: the path goes through the waypoints that were found.
pub(crate) fn ended_unjudged(
    problem: &PlanningProblem<'_>,
    waypoints: &[Waypoint],
    mut plan: Plan,
    failure: Failure,
) -> Plan {
    // A single waypoint is the flat sheet, and no path.
    if waypoints.len() > 1 {
        plan.path.interpolation = Interpolation::Linear;
        plan.path.knots = unmeasured(waypoints, problem.options.max_speed);
    }
    plan.ended(failure)
}

/// Returns the group angles at a place of a motion or, if `room` (radians) is above 0, as much before it as the fastest
/// hinge turns by `room`, at most to the start of the segment.
fn angles_before(path: &Path, place: Place, room: f64) -> Vec<f64> {
    let curves = &path.curves()[place.segment];
    let rates = curves
        .iter()
        .map(|curve| curve.derivatives(place.s)[0].abs());
    let fastest = rates.fold(f64::MIN_POSITIVE, f64::max);
    let s = (place.s - room / fastest).max(0.0);
    curves.iter().map(|curve| curve.angle(s)).collect()
}

/// Crossing before which a path has to end.
struct Crossed {
    crossing: Crossing,
    /// Number of the segment in which the path ends.
    segment: usize,
    /// Last group angles free of crossings, if there are any.
    free: Option<Vec<f64>>,
}

impl Crossed {
    fn reason(&self, lifting: &Lifting<'_>) -> Reason {
        Reason::Crosses {
            faces: self.crossing.faces,
            reached: lifting.candidate.reached,
            free: self.free_fraction(lifting.path),
            segment: self.segment,
            depth: self.crossing.depth / lifting.problem.pattern.median_edge(),
        }
    }

    fn free_fraction(&self, path: &ReducedPath) -> f64 {
        self.free.as_ref().map_or(0.0, |free| path.fraction(free))
    }
}

impl Lifting<'_> {
    /// Looks for crossings along the motion, if asked to.
    fn sweep_if_asked(&self, plan: Plan) -> Plan {
        if !self.problem.options.collision {
            return plan;
        }
        if self.candidate.before != Some(&plan.path) {
            return self.sweep(plan);
        }
        let nearer = self.nearer(&plan);
        nearer.unwrap_or_else(|| {
            plan.ended(Failure {
                outcome: Outcome::Partial,
                reason: Reason::NothingNearer,
                kept: 1.0,
            })
        })
    }

    /// Looks for crossings over the whole motion, and ends the path before the first one.
    fn sweep(&self, mut plan: Plan) -> Plan {
        let (problem, candidate) = (self.problem, self.candidate);
        problem.watch.begin(Stage::Crossings);
        let start = Instant::now();
        let lattice = self.lattice();
        plan.times.symmetry += start.elapsed();
        let start = Instant::now();
        let gap = plan.rigidity.gap;
        let options = sweep_options(
            problem.options.skips,
            plan.certified_closure,
            problem.contact,
        );
        let torn = is_torn(plan.certified_deformation.unwrap_or(0.0).max(gap));
        let segments = plan.path.curves();
        let motion = SearchedMotion {
            pattern: problem.pattern,
            memberships: &plan.path.memberships,
            segments: &segments,
            options,
            watch: problem.watch,
        };
        let along = lattice.and_then(|lattice| motion.along_lattice(lattice));
        plan.times.collision += start.elapsed();
        let Searched { verdict, counts } = if let Some(along) = along {
            along
        } else {
            let faces = problem.pattern.faces().len();
            if lattice.is_some()
                && torn
                && faces > MAX_TORN_FACES
                && let Some(nearer) = self.nearer(&plan)
            {
                return nearer;
            }
            let start = Instant::now();
            let hidden =
                self.tears_hide_contact(&plan) && candidate.bound_fraction > NEAREST_BOUND_FRACTION;
            let first = if hidden {
                motion.with_queries(MAX_HIDDEN_QUERIES)
            } else {
                motion
            };
            let mut swept = first.all_faces();
            plan.times.collision += start.elapsed();
            if hidden && matches!(swept.verdict, SweepVerdict::Undecided { .. }) {
                if let Some(nearer) = self.nearer_than(NEAREST_BOUND_FRACTION, &plan) {
                    return nearer;
                }
                let start = Instant::now();
                swept = motion.all_faces();
                plan.times.collision += start.elapsed();
            }
            swept
        };
        plan.collision = counts;
        match verdict {
            SweepVerdict::Free(clearance) => {
                let start = Instant::now();
                let crossed_knot = torn.then(|| self.crossed_knot(&plan)).flatten();
                plan.times.collision += start.elapsed();
                let Some((index, crossing)) = crossed_knot else {
                    plan.clearance = clearance;
                    return plan;
                };
                if let Some(nearer) = self.nearer(&plan) {
                    return nearer;
                }
                let before = index.checked_sub(1);
                let crossed = Crossed {
                    crossing,
                    segment: before.unwrap_or(0),
                    free: before.map(|before| plan.path.knots[before].stored.angles.clone()),
                };
                let retreated = candidate.retreats.then(|| self.retreated(&plan, &crossed));
                match retreated.flatten() {
                    Some(retreated) => retreated,
                    None => self.end_before(plan, crossed),
                }
            }
            SweepVerdict::Undecided { .. } if problem.is_late() => {
                plan.ended(Failure::out_of_time(TimeoutAt::LookingForCrossings))
            }
            SweepVerdict::Undecided { faces: None, .. } => self.sweep_no_more_than_knots(plan),
            SweepVerdict::Undecided { faces, at } => {
                plan.undecided.push(Undecided::Crossings {
                    faces,
                    segment: at.segment,
                });
                plan
            }
            SweepVerdict::Crossing {
                crossing,
                last_free,
                ..
            } => {
                let start = Instant::now();
                let blocked = candidate.bound_fraction < FIRST_BOUND_FRACTION && self.is_blocked();
                plan.times.collision += start.elapsed();
                let nearer = (!blocked).then(|| self.nearer(&plan));
                // A sheet that is torn by more than the tolerance crosses elsewhere than its path does; a nearer motion
                // tells where.
                let leads = |nearer: &Plan| torn || nearer.outcome == Outcome::Planned;
                if let Some(nearer) = nearer.flatten().filter(leads) {
                    return nearer;
                }
                let crossed = |room| Crossed {
                    crossing,
                    segment: last_free.map_or(0, |place| place.segment),
                    free: last_free.map(|place| angles_before(&plan.path, place, room)),
                };
                let rooms: &[f64] = match (candidate.retreats, problem.goes_near) {
                    (true, false) => &ROOMS_RAD,
                    (true, true) => &WIDE_ROOMS_RAD,
                    (false, _) => &[],
                };
                let mut shorter = rooms
                    .iter()
                    .filter_map(|&room| self.retreated(&plan, &crossed(room)));
                let shorter = shorter.find(|plan| !matches!(plan.outcome, Outcome::Crossing(_)));
                let crossed = crossed(0.0);
                shorter.unwrap_or_else(|| self.end_before(plan, crossed))
            }
        }
    }

    /// Returns the plan with the motion nearer to the path: if layers touch, a motion that is as far off the path as the
    /// bound allows may cross. Returns `None` if the motion is as near as it gets, or the nearer one decides nothing.
    fn nearer(&self, plan: &Plan) -> Option<Plan> {
        self.nearer_than(LEAST_BOUND_FRACTION, plan)
    }

    /// Does what [`nearer`](Self::nearer) does, until `least` of the bound is aimed for.
    fn nearer_than(&self, least: f64, plan: &Plan) -> Option<Plan> {
        let candidate = self.candidate;
        if candidate.bound_fraction <= least || candidate.retreats {
            return None;
        }
        let nearer = CandidatePath {
            bound_fraction: candidate.bound_fraction * NEARER_FACTOR,
            before: Some(&plan.path),
            ..*candidate
        };
        let so_far = Plan {
            rigidity: Rigidity::default(),
            max_closure: 0.0,
            ..plan.clone()
        };
        let plan = lift(self.problem, self.reduction, &nearer, so_far);
        matches!(plan.outcome, Outcome::Planned | Outcome::Crossing(_)).then_some(plan)
    }

    /// Returns the plan of the path that ends a little before a crossing, near an inexact goal. Returns `None` if the
    /// crossing is far from the goal.
    fn retreated(&self, plan: &Plan, crossed: &Crossed) -> Option<Plan> {
        let Self {
            problem,
            reduction,
            candidate,
            path,
        } = *self;
        let free = crossed.free.as_ref()?;
        let goal = candidate.waypoints.last()?;
        let short = max_difference(free, &goal.angles);
        if short > MAX_RETREAT_RAD && !problem.goes_near {
            return None;
        }
        let mut solver = reduction.solver(problem.options, candidate.closure_tolerance);
        let waypoints = path.cut(&mut solver, free.clone())?;
        let mut plan = plan.clone();
        plan.notes.push(Note::EndsBeforeCrossing {
            residual: plan.goal_closure,
            crossing: crossed.reason(self),
            short,
        });
        let end = waypoints.last().map_or(&[][..], |last| &last.angles);
        plan.goal_error = reduction.distance(end, problem.goal);
        plan.rigidity = Rigidity::default();
        let shorter = CandidatePath {
            waypoints: &waypoints,
            retreats: false,
            before: None,
            ..*candidate
        };
        Some(lift(problem, reduction, &shorter, plan))
    }

    /// Ends the path before a crossing.
    fn end_before(&self, mut plan: Plan, crossed: Crossed) -> Plan {
        let reason = crossed.reason(self);
        plan.reached = self.candidate.reached * crossed.free_fraction(self.path);
        plan.path.knots.truncate(crossed.segment + 1);
        plan.ended(Failure {
            outcome: Outcome::Crossing(crossed.crossing),
            reason,
            kept: 1.0,
        })
    }
}
