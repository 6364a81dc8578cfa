//! Ways round crossings: a sheet with freedom to spare turns its creases a little otherwise where faces would cross.
//!
//! A path is followed up to its crossing. From there the sheet is moved, closed, until the two faces are clear of each
//! other, and the next path leads by way of that configuration. The direction is the infinitesimal motion of the closed
//! sheet nearest to the gradient of the two faces' distance.

use super::fold_sequence::{between, is_free, plan_via};
use crate::collision::face_distance;
use crate::folding::FoldingMap;
use crate::pattern::FaceId;
use crate::planner::following::judge::Judge;
use crate::planner::following::reduction::Reduction;
use crate::planner::lifting::whole_sheet::FIRST_BOUND_FRACTION;
use crate::planner::plan::{Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::Note;
use crate::planner::vectors::{dot, max_norm};
use crate::symmetry::CreaseGroups;

/// Largest number of configurations by way of which a path is led.
const MAX_STOPS: usize = 12;
/// Part of the whole path by which the path has to become longer with each of these configurations.
const MIN_GAIN_RATIO: f64 = 0.02;
/// Distances to which faces that would cross are moved apart, median edges, tried one after the other: others may cross
/// at the larger ones.
const CLEARANCES_EDGES: [f64; 3] = [0.1, 0.03, 0.01];
/// Largest number of moves for one configuration, and largest turn of a crease in one move, radians.
const MAX_MOVES: usize = 30;
const MAX_TURN_RAD: f64 = 0.05;
/// Ratio of a move to the one after which the faces are far enough apart, if distances grew in proportion to the move.
const OVERSHOOT_RATIO: f64 = 1.2;
/// Least turn of a crease off the path, over the largest one in the gradient.
const MIN_TURN_RATIO: f64 = 1e-3;
/// Turn of a crease by which the gradient is measured, radians.
const PROBE_RAD: f64 = 1e-5;

/// Returns a plan that leads round the crossing of `straight`, and others that follow, if one is found.
pub(crate) fn lead_round_crossings(problem: &PlanningProblem<'_>, straight: &Plan) -> Option<Plan> {
    let reduction = Reduction::of(problem, CreaseGroups::trivial(problem.pattern));
    let mut stops: Vec<Vec<f64>> = Vec::new();
    let mut pairs = Vec::new();
    let mut effort = Plan::default();
    let mut plan = straight.clone();
    let mut reached = plan.reached;
    while stops.len() < MAX_STOPS && !problem.is_late() {
        let Outcome::Crossing(crossing) = plan.outcome else {
            return None;
        };
        if !pairs.contains(&crossing.faces) {
            pairs.push(crossing.faces);
        }
        let phases = plan.path.knots.iter().filter(|knot| knot.ends_phase);
        let phase = phases.count().min(stops.len());
        let mut knots = plan.path.knots.iter().rev();
        let [end, before] = [knots.next()?, knots.next()?].map(|k| plan.path.crease_angles(k));
        let along: Vec<f64> = end
            .iter()
            .zip(before)
            .map(|(end, before)| end - before)
            .collect();
        let at = [end.as_slice(), along.as_slice()];
        let mut apart = CLEARANCES_EDGES
            .iter()
            .map(|&clear| moved_apart(problem, &reduction, at, &pairs, clear));
        stops.insert(phase, apart.find_map(|found| found)?);
        plan = plan_via(problem, &stops, FIRST_BOUND_FRACTION);
        if plan.outcome == Outcome::Planned {
            plan.add_effort(&effort);
            plan.notes.push(Note::Phases(stops.len() + 1));
            return Some(plan);
        }
        effort.add_effort(&plan);
        if plan.reached < reached + MIN_GAIN_RATIO {
            return None;
        }
        reached = plan.reached;
    }
    None
}

/// Returns a closed configuration near `angles`, fold angles of the creases in radians, at which each pair of faces is
/// this far from each other (median edges) and no faces cross, if one is found. Moves `along` the path, which only lead
/// back, do not count.
fn moved_apart(
    problem: &PlanningProblem<'_>,
    reduction: &Reduction<'_>,
    [angles, along]: [&[f64]; 2],
    pairs: &[[FaceId; 2]],
    clear: f64,
) -> Option<Vec<f64>> {
    let options = problem.options;
    let clear = clear * problem.pattern.median_edge();
    let mut angles = angles.to_vec();
    let mut map = FoldingMap::flat(problem.pattern);
    let mut distance = |angles: &[f64], faces| {
        map.fold(problem.pattern, reduction.tree, angles);
        face_distance(problem.pattern, &map, faces)
    };
    let mut solver = reduction.solver(options, 0.0);
    let (_, signs) = reduction.asked(problem.goal);
    solver.limits = reduction.orthant(&signs);
    let along = reduction.groups.reduce_all(along);
    for _ in 0..MAX_MOVES {
        // For each pair that is too near, how much it lacks and the gradient of its distance.
        let mut near = Vec::new();
        for &faces in pairs {
            let before = distance(&angles, faces);
            if before >= clear {
                continue;
            }
            let mut slopes = vec![0.0; angles.len()];
            for crease in between(reduction.tree, &angles, faces).ones() {
                let mut turned = angles.clone();
                turned[crease] += PROBE_RAD;
                slopes[crease] = (distance(&turned, faces) - before) / PROBE_RAD;
            }
            // Faces that intersect have no direction in which they part.
            let parts = dot(&slopes, &slopes);
            if parts.is_nan() || parts <= 0.0 || problem.is_late() {
                return None;
            }
            near.push((clear - before, reduction.groups.reduce_all(&slopes)));
        }
        if near.is_empty() {
            break;
        }
        let mut closed = reduction.groups.reduce_all(&angles);
        let mut turns = vec![0.0; closed.len()];
        for (lacks, slopes) in &near {
            let turn = lacks / dot(slopes, slopes);
            turns
                .iter_mut()
                .zip(slopes)
                .for_each(|(sum, slope)| *sum += turn * slope);
        }
        let wanted = max_norm(&turns);
        solver.project_on_motions(&closed, &mut turns)?;
        let part = dot(&turns, &along) / dot(&along, &along);
        turns
            .iter_mut()
            .zip(&along)
            .for_each(|(turn, along)| *turn -= part * along);
        let most = max_norm(&turns);
        // A sheet without freedom to spare moves along the path only.
        if most < MIN_TURN_RATIO * wanted {
            return None;
        }
        let steps = near
            .iter()
            .map(|(lacks, slopes)| lacks / dot(&turns, slopes));
        let step = steps.filter(|step| *step > 0.0).fold(0.0, f64::max);
        if step <= 0.0 {
            return None;
        }
        let step = f64::min(OVERSHOOT_RATIO * step, MAX_TURN_RAD / most);
        closed
            .iter_mut()
            .zip(turns)
            .for_each(|(angle, turn)| *angle += step * turn);
        if !solver.closes(&mut closed) {
            return None;
        }
        angles = reduction.groups.expand(&closed);
    }
    let mut judge = Judge::new(problem, reduction, options.collision);
    let tolerance = reduction.closure_tolerance(options);
    is_free(&mut judge, &reduction.groups, &angles, tolerance).then_some(angles)
}
