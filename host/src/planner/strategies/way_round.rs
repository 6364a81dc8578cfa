//! Ways round crossings: a sheet with freedom to spare turns its creases a little otherwise where faces would cross.
//!
//! A path is followed up to its crossing. From there the sheet is moved, closed, until the two faces are clear of each
//! other, and the next path leads by way of that configuration. The direction is the infinitesimal motion of the closed
//! sheet nearest to the gradient of the two faces' distance.

use super::stops::{Leg, StopSearch, between, search_stops};
use crate::collision::face_distance;
use crate::folding::FoldingMap;
use crate::pattern::FaceId;
use crate::planner::closing::solver::ClosureSolver;
use crate::planner::following::judge::Judge;
use crate::planner::following::reduction::Reduction;
use crate::planner::lifting::swept_motion::FIRST_BOUND_FRACTION;
use crate::planner::plan::{Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{Note, Reason};
use crate::planner::vectors::{add_scaled, dot, max_norm};
use crate::progress::Stage;
use crate::symmetry::CreaseGroups;

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

/// Returns a plan that leads round the crossing of `straight` on a leg, and others that follow, if one is found.
pub(crate) fn lead_round_crossings(
    problem: &PlanningProblem<'_>,
    leg: &Leg,
    straight: &Plan,
) -> Option<Plan> {
    let mut way = WayRound {
        problem,
        leg,
        reduction: &Reduction::of(problem, CreaseGroups::trivial(problem.pattern)),
        stops: Vec::new(),
        pairs: Vec::new(),
        last: straight.clone(),
        gains: true,
    };
    let mut plan = search_stops(problem, leg, &mut way)?;
    plan.notes.push(Note::Phases(way.stops.len() + 1));
    Some(plan)
}

/// A way that gets another stop wherever faces cross on it.
struct WayRound<'a> {
    problem: &'a PlanningProblem<'a>,
    leg: &'a Leg,
    reduction: &'a Reduction<'a>,
    /// Fold angles of the creases at the stops, radians.
    stops: Vec<Vec<f64>>,
    /// Faces that crossed.
    pairs: Vec<[FaceId; 2]>,
    /// The plan by way of these stops.
    last: Plan,
    /// `true` if the last stop has made the way to the crossing longer.
    gains: bool,
}

impl StopSearch for WayRound<'_> {
    const MAX_TRIES: usize = 12;
    const BOUND_FRACTION: f64 = FIRST_BOUND_FRACTION;

    fn next(&mut self) -> Option<Vec<Vec<f64>>> {
        let Outcome::Crossing(crossing) = self.last.outcome else {
            return None;
        };
        if !self.gains {
            return None;
        }
        if !self.pairs.contains(&crossing.faces) {
            self.pairs.push(crossing.faces);
        }
        let phase = self.leg.ended_phases(&self.last).min(self.stops.len());
        let motion = self.last.motion.as_ref()?;
        // At the end of the motion the faces touch, and have no direction in which they part.
        let last = match self.last.reason.as_ref()? {
            Reason::Crosses { segment, .. } => *segment,
            Reason::CrossesAtKnot { knot, .. } => knot.checked_sub(1)?,
            _ => motion.knots.len() - 1,
        };
        let [end, before] = [last, last.checked_sub(1)?].map(|knot| motion.crease_angles(knot));
        let along: Vec<f64> = end
            .iter()
            .zip(before)
            .map(|(end, before)| end - before)
            .collect();
        let mut apart = CLEARANCES_EDGES
            .iter()
            .map(|&clear| self.moved_apart(&end, &along, clear));
        self.stops.insert(phase, apart.find_map(|found| found)?);
        Some(self.stops.clone())
    }

    fn learn(&mut self, plan: &Plan) {
        self.gains = plan.reached >= self.last.reached + MIN_GAIN_RATIO;
        self.last = plan.clone();
    }
}

/// Distance that a pair of faces lacks, and the gradient of its distance by the group angles.
type Near = (f64, Vec<f64>);

impl WayRound<'_> {
    /// Returns a closed configuration near `angles`, fold angles of the creases in radians, at which each pair of faces is
    /// this far from each other (median edges) and no faces cross, if one is found. Moves `along` the path, which only
    /// lead back, do not count.
    fn moved_apart(&self, angles: &[f64], along: &[f64], clear: f64) -> Option<Vec<f64>> {
        let (problem, reduction) = (self.problem, self.reduction);
        let options = problem.options;
        let mut angles = angles.to_vec();
        let mut map = FoldingMap::flat(problem.pattern);
        let mut solver = reduction.solver(options, 0.0);
        let (_, signs) = reduction.asked(problem.goal);
        solver.limits = reduction.orthant(&signs);
        let along = reduction.groups.reduce_all(along);
        for _ in 0..MAX_MOVES {
            let near = self.too_near(&mut map, &angles, clear)?;
            if near.is_empty() {
                break;
            }
            let mut closed = reduction.groups.reduce_all(&angles);
            move_apart(&mut solver, &mut closed, &along, &near)?;
            angles = reduction.groups.expand(&closed);
        }
        let mut judge = Judge::new(problem, reduction, options.collision);
        let is_free = problem.stage(Stage::Crossings, || judge.is_free(&angles, options));
        is_free.then_some(angles)
    }

    /// Returns the pairs that are nearer than `clear` median edges. Returns `None` if faces intersect or time is up.
    fn too_near(&self, map: &mut FoldingMap, angles: &[f64], clear: f64) -> Option<Vec<Near>> {
        let (pattern, reduction) = (self.problem.pattern, self.reduction);
        let clear = clear * pattern.median_edge();
        let mut distance = |angles: &[f64], faces| {
            map.fold(pattern, reduction.tree, angles);
            face_distance(pattern, map, faces)
        };
        let mut near = Vec::new();
        for &faces in &self.pairs {
            let before = distance(angles, faces);
            if before >= clear {
                continue;
            }
            let mut slopes = vec![0.0; angles.len()];
            for crease in between(pattern, faces).ones() {
                let mut turned = angles.to_vec();
                turned[crease] += PROBE_RAD;
                slopes[crease] = (distance(&turned, faces) - before) / PROBE_RAD;
            }
            // Faces that intersect have no direction in which they part.
            let parts = dot(&slopes, &slopes);
            if parts.is_nan() || parts <= 0.0 || self.problem.is_late() {
                return None;
            }
            near.push((clear - before, reduction.groups.reduce_all(&slopes)));
        }
        Some(near)
    }
}

/// Moves pairs that are too near apart, by one move of closed group angles. Returns `None` if they cannot be moved so, but
/// for moves `along` the path.
fn move_apart(
    solver: &mut ClosureSolver<'_>,
    closed: &mut [f64],
    along: &[f64],
    near: &[Near],
) -> Option<()> {
    let mut turns = vec![0.0; closed.len()];
    for (lacks, slopes) in near {
        add_scaled(&mut turns, lacks / dot(slopes, slopes), slopes);
    }
    let wanted = max_norm(&turns);
    solver.project_on_motions(closed, &mut turns)?;
    let part = dot(&turns, along) / dot(along, along);
    add_scaled(&mut turns, -part, along);
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
    add_scaled(closed, step, &turns);
    solver.closes(closed).then_some(())
}
