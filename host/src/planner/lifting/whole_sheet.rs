//! Lifts a path found on few unknowns to the whole sheet: certified, measured and swept for crossings. If layers touch,
//! a motion that is as far off its path as the bound allows may cross: it is then lifted again, nearer to the path.

use foldpath_core::Interpolation;

use super::certified_motion::{CandidatePath, Certificate, cut, place_knots, unplaced};
use super::measured_motion::{MeasuredMotion, SheetErrors, measure, torn, torn_from_rim};
use super::swept_motion::{
    SweptKnots, crossed_knot, ends_at_knot, is_blocked, lattice, sweep_knots, sweep_options,
    tears_hide_contact,
};
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
    let placement = place_knots(problem, reduction, candidate, &path);
    plan.times.place += placement.time;
    store_certificate(&mut plan, placement.certificate);
    let Some(mut knots) = placement.knots else {
        let failure = unplaced(problem);
        if failure.outcome == Outcome::Timeout {
            return ended_unjudged(problem, candidate.waypoints, plan, failure);
        }
        return plan.ended(failure);
    };
    let mut certificate = placement.certificate;
    let proved = certificate.and_then(|c| cut(problem, reduction, &path, c, &mut knots));
    if let Some(proved) = &proved {
        certificate = Some(proved.certificate);
        store_certificate(&mut plan, certificate);
        plan.goal_error = proved.goal_error;
        plan.reached *= proved.fraction;
    }
    plan.path.interpolation = knots.interpolation;
    problem.watch.begin(Stage::Folding);
    let motion = measure(problem, reduction, knots.knots);
    if let Some(knot) = motion.late {
        let failure = Failure::out_of_time(TimeoutAt::JudgingKnot(knot));
        return ended_unjudged(problem, candidate.waypoints, plan, failure);
    }
    let (mut plan, failure) = measured(problem, plan, motion, certificate);
    if let Some(failure) = failure {
        return plan.ended(failure);
    }
    let (failure, time) = torn_from_rim(problem, reduction, &plan.path, plan.max_closure);
    plan.times.fold += time;
    if let Some(failure) = failure {
        return plan.ended(failure);
    }
    let Some(proved) = proved else {
        return sweep_if_asked(problem, reduction, candidate, &path, plan);
    };
    let reason = Reason::ProofStops {
        reached: plan.reached,
        certified: proved.whole,
        bound: problem.options.bound,
    };
    // The path ends where its proof ends, so that it is neither shortened nor brought nearer to the reduced path.
    let candidate = CandidatePath {
        retreats: false,
        bound_fraction: LEAST_BOUND_FRACTION,
        ..*candidate
    };
    let mut plan = sweep_if_asked(problem, reduction, &candidate, &path, plan);
    if plan.outcome == Outcome::Planned {
        (plan.outcome, plan.reason) = (Outcome::Partial, Some(reason));
    }
    plan
}

fn store_certificate(plan: &mut Plan, certificate: Option<Certificate>) {
    if let Some(certificate) = certificate {
        plan.certified_closure = certificate.closure;
        plan.certified_deformation = Some(certificate.deformation);
    }
}

/// Stores a measured motion in the plan. Returns the failure too, if the sheet breaks the bound at its knots or is not
/// proved to keep the bound between them.
fn measured(
    problem: &PlanningProblem<'_>,
    mut plan: Plan,
    motion: MeasuredMotion,
    certificate: Option<Certificate>,
) -> (Plan, Option<Failure>) {
    plan.times.fold += motion.time;
    plan.rigidity = motion.worst();
    plan.max_closure = motion.max_closure(plan.max_closure);
    if let Some(essential) = motion.essential {
        (plan.essential_rigidity, plan.essential_faces) = essential;
    }
    plan.path.knots = motion.knots;
    let errors = SheetErrors {
        whole: plan.rigidity,
        closure: plan.max_closure,
        essential: plan.essential_rigidity,
    };
    let failure = torn(problem.options.bound, &plan.path.knots, errors, certificate);
    (plan, failure)
}

/// Returns the waypoints as knots, as far apart in time as the largest speed of the hinges (radians per second)
/// requires. The errors of the sheet are NaN: they are not measured.
fn unmeasured(waypoints: &[Waypoint], max_speed: f64) -> Vec<Knot> {
    let mut time = 0.0;
    let mut before: Option<&[f64]> = None;
    let knots = waypoints.iter().map(|waypoint| {
        let turned = before.map_or(0.0, |before| max_difference(before, &waypoint.angles));
        time += turned / max_speed;
        before = Some(&waypoint.angles);
        Knot {
            time,
            rates: vec![0.0; waypoint.angles.len()],
            angles: waypoint.angles.clone(),
            ends_phase: waypoint.ends_phase,
            deformation: f64::NAN,
            gap: f64::NAN,
            closure: f64::NAN,
            ..Knot::default()
        }
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

/// Stores the result of a search for crossings at the knots alone, and ends the path before the first crossing.
fn ended_at_knots(mut plan: Plan, swept: SweptKnots) -> Plan {
    plan.times.collision += swept.time;
    plan.collision = swept.counts;
    let Some((index, crossing)) = swept.end else {
        return plan;
    };
    let failure = ends_at_knot(&plan.path.knots, index, crossing);
    if crossing.is_some() {
        plan.path.knots.truncate(index);
    }
    plan.ended(failure)
}

/// Looks for crossings along the motion, if asked to.
fn sweep_if_asked(
    problem: &PlanningProblem<'_>,
    reduction: &Reduction<'_>,
    candidate: &CandidatePath<'_>,
    path: &ReducedPath,
    plan: Plan,
) -> Plan {
    if !problem.options.collision {
        return plan;
    }
    if candidate.before != Some(&plan.path) {
        return sweep(problem, reduction, candidate, path, plan);
    }
    let nearer = nearer(problem, reduction, candidate, &plan);
    nearer.unwrap_or_else(|| {
        plan.ended(Failure {
            outcome: Outcome::Partial,
            reason: Reason::NothingNearer,
            kept: 1.0,
        })
    })
}

/// Looks for crossings over the whole motion, and ends the path before the first one.
fn sweep(
    problem: &PlanningProblem<'_>,
    reduction: &Reduction<'_>,
    candidate: &CandidatePath<'_>,
    path: &ReducedPath,
    mut plan: Plan,
) -> Plan {
    problem.watch.begin(Stage::Crossings);
    let start = Instant::now();
    let lattice = lattice(problem, reduction);
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
            && let Some(nearer) = nearer(problem, reduction, candidate, &plan)
        {
            return nearer;
        }
        let start = Instant::now();
        let hidden = tears_hide_contact(problem, reduction, &plan)
            && candidate.bound_fraction > NEAREST_BOUND_FRACTION;
        let first = if hidden {
            motion.with_queries(MAX_HIDDEN_QUERIES)
        } else {
            motion
        };
        let mut swept = first.all_faces();
        plan.times.collision += start.elapsed();
        if hidden && matches!(swept.verdict, SweepVerdict::Undecided { .. }) {
            if let Some(nearer) =
                nearer_than(NEAREST_BOUND_FRACTION, problem, reduction, candidate, &plan)
            {
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
            let crossed_knot = torn
                .then(|| crossed_knot(problem, reduction, &plan.path.knots, plan.max_closure))
                .flatten();
            plan.times.collision += start.elapsed();
            let Some((index, crossing)) = crossed_knot else {
                plan.clearance = clearance;
                return plan;
            };
            if let Some(nearer) = nearer(problem, reduction, candidate, &plan) {
                return nearer;
            }
            let before = index.checked_sub(1);
            let crossed = Crossed {
                crossing,
                segment: before.unwrap_or(0),
                free: before.map(|before| plan.path.knots[before].angles.clone()),
            };
            let retreated = candidate
                .retreats
                .then(|| retreated(problem, reduction, candidate, path, &plan, &crossed));
            match retreated.flatten() {
                Some(retreated) => retreated,
                None => end_before(problem, candidate, path, plan, crossed),
            }
        }
        SweepVerdict::Undecided { .. } if problem.is_late() => {
            plan.ended(Failure::out_of_time(TimeoutAt::LookingForCrossings))
        }
        SweepVerdict::Undecided { faces: None, .. } => {
            sweep_no_more_than_knots(problem, reduction, plan)
        }
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
            let blocked = candidate.bound_fraction < FIRST_BOUND_FRACTION
                && is_blocked(problem, reduction, candidate);
            plan.times.collision += start.elapsed();
            let nearer = (!blocked).then(|| nearer(problem, reduction, candidate, &plan));
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
            let mut shorter = rooms.iter().filter_map(|&room| {
                retreated(problem, reduction, candidate, path, &plan, &crossed(room))
            });
            let shorter = shorter.find(|plan| !matches!(plan.outcome, Outcome::Crossing(_)));
            let crossed = crossed(0.0);
            shorter.unwrap_or_else(|| end_before(problem, candidate, path, plan, crossed))
        }
    }
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

/// Looks for crossings at the knots alone, and leaves the question open.
fn sweep_no_more_than_knots(
    problem: &PlanningProblem<'_>,
    reduction: &Reduction<'_>,
    plan: Plan,
) -> Plan {
    let swept = sweep_knots(problem, reduction, &plan.path.knots);
    let mut plan = ended_at_knots(plan, swept);
    if plan.outcome == Outcome::Planned {
        let faces = problem.pattern.faces().len();
        plan.undecided.push(Undecided::CrossingsAtKnots { faces });
    }
    plan
}

/// Returns the plan with the motion nearer to the path: if layers touch, a motion that is as far off the path as the
/// bound allows may cross. Returns `None` if the motion is as near as it gets, or the nearer one decides nothing.
fn nearer(
    problem: &PlanningProblem<'_>,
    reduction: &Reduction<'_>,
    candidate: &CandidatePath<'_>,
    plan: &Plan,
) -> Option<Plan> {
    nearer_than(LEAST_BOUND_FRACTION, problem, reduction, candidate, plan)
}

/// Does what [`nearer`] does, until `least` of the bound is aimed for.
fn nearer_than(
    least: f64,
    problem: &PlanningProblem<'_>,
    reduction: &Reduction<'_>,
    candidate: &CandidatePath<'_>,
    plan: &Plan,
) -> Option<Plan> {
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
    let plan = lift(problem, reduction, &nearer, so_far);
    matches!(plan.outcome, Outcome::Planned | Outcome::Crossing(_)).then_some(plan)
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
    fn reason(&self, problem: &PlanningProblem<'_>, reached: f64, path: &ReducedPath) -> Reason {
        Reason::Crosses {
            faces: self.crossing.faces,
            reached,
            free: self.free_fraction(path),
            segment: self.segment,
            depth: self.crossing.depth / problem.pattern.median_edge(),
        }
    }

    fn free_fraction(&self, path: &ReducedPath) -> f64 {
        self.free.as_ref().map_or(0.0, |free| path.fraction(free))
    }
}

/// Returns the plan of the path that ends a little before a crossing, near an inexact goal. Returns `None` if the
/// crossing is far from the goal.
fn retreated(
    problem: &PlanningProblem<'_>,
    reduction: &Reduction<'_>,
    candidate: &CandidatePath<'_>,
    path: &ReducedPath,
    plan: &Plan,
    crossed: &Crossed,
) -> Option<Plan> {
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
        crossing: crossed.reason(problem, candidate.reached, path),
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
fn end_before(
    problem: &PlanningProblem<'_>,
    candidate: &CandidatePath<'_>,
    path: &ReducedPath,
    mut plan: Plan,
    crossed: Crossed,
) -> Plan {
    let reason = crossed.reason(problem, candidate.reached, path);
    plan.reached = candidate.reached * crossed.free_fraction(path);
    plan.path.knots.truncate(crossed.segment + 1);
    plan.ended(Failure {
        outcome: Outcome::Crossing(crossed.crossing),
        reason,
        kept: 1.0,
    })
}
