//! The route on given crease groups, from flat to the goal or as near as the motion leads: backwards from the goal, or
//! else forwards from flat, or else by the randomised search.

use core::time::Duration;

use super::branch::branches_at_flat;
use super::follow::{Followed, Homeward, Rules, Target, Waypoint, follow, tangent_at_flat};
use super::judge::Judge;
use super::reduction::{CLOSED, ClosedGoal, Reduction, SAME_RAD};
use super::search::{polyline, search};
use crate::planner::closing::solver::{ClosureSolver, Work};
use crate::planner::goal::GoalKind;
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{Note, Stop};
use crate::planner::vectors::{fraction, largest, max_difference, max_norm};
use crate::planner::{PlanOptions, Search};
use crate::util::clock::Instant;

/// Way in which a route ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum End {
    /// The path ends at the goal, or at the closed configuration nearest to it.
    Reached,
    /// The path ends before the goal.
    Stopped(Stop),
    /// There is no goal: one of the phases, of which the goal is the last, has no closed configuration.
    NotClosed {
        /// The phase without a closed configuration.
        phase: usize,
        /// Distance (radians) of the nearest closed configuration that was found, if any was.
        nearest: Option<f64>,
    },
}

/// A path in group angles, and the way in which it ends.
pub(crate) struct Route<'a> {
    pub(crate) reduction: Reduction<'a>,
    /// Waypoints, from flat.
    pub(crate) waypoints: Vec<Waypoint>,
    /// The closed configuration at the goal, if one is known.
    pub(crate) goal: Option<Vec<f64>>,
    /// Closure residual up to which a local minimum counts as closed.
    pub(crate) closure_tolerance: f64,
    pub(crate) end: End,
    /// `true` if the goal had to close exactly.
    pub(crate) exactly: bool,
    /// Fraction of the goal's angles that the last waypoint has, 0 to 1.
    pub(crate) reached: f64,
    /// Time for finding crease groups and closing the goal.
    pub(crate) symmetry: Duration,
    /// Time for following motions.
    pub(crate) following: Duration,
    /// Work on all routes that were tried.
    pub(crate) work: Work,
    /// `true` if random numbers were drawn.
    pub(crate) is_random: bool,
    pub(crate) notes: Vec<Note>,
    /// Reduction to the crease groups that were dropped last, as the goal does not close under them or the sheet folds
    /// farther without them.
    pub(crate) symmetric: Option<Reduction<'a>>,
    /// Closure residual of the goal as asked, with every crease on its own, if all creases have an angle and the
    /// residual was needed.
    pub(crate) asked_closure: Option<f64>,
}

/// Distance from the angle asked for up to which a hinge counts as being there, radians.
const NEARLY_RAD: f64 = 1e-6;
/// Largest distance by which a goal may be moved, as a fraction of the largest angle asked for.
const MAX_MOVED_RATIO: f64 = 0.5;
/// Angle that the nearest closed configuration has to reach, as a fraction of the largest angle asked for.
const MIN_TURNED_RATIO: f64 = 0.1;
/// Largest number of iterations to close a predicted configuration: a handful suffice, unless nothing closes there.
const MAX_ITERATIONS: u32 = 25;
/// Closure residual that rounding may leave on a straight way between two configurations.
const STRAIGHT_RESIDUAL: f64 = 1e-12;
/// Smallest number of steps on a straight way: its two ends close in any case.
const MIN_STEPS: f64 = 4.0;
/// Largest number of branches that are followed from flat.
const MAX_BRANCHES: usize = 4;
/// Number of restarts of the randomised search as a last resort.
const LAST_RESORT_RESTARTS: usize = 3;
/// Number of unknowns above which the randomised search is not tried as a last resort: samples are too costly and too
/// rarely good.
const MAX_LAST_RESORT_UNKNOWNS: usize = 200;
/// Number of restarts of the randomised search if it is asked for.
const SEARCH_RESTARTS: usize = 20;

/// State shared by all steps of the search for a route.
struct RouteFinder<'a> {
    problem: PlanningProblem<'a>,
    reduction: &'a Reduction<'a>,
    /// Group angles that the goal asks for.
    asked: Vec<Option<f64>>,
    signs: Vec<f64>,
    notes: Vec<Note>,
    /// Closure residual up to which a local minimum counted as closed on the path found last.
    closure_tolerance: f64,
    /// Number of motions found that leave the flat sheet.
    branches: usize,
    /// `true` if random numbers were drawn.
    is_random: bool,
    work: Work,
}

impl<'a> Route<'a> {
    /// Looks for a route to the goal of `problem`, or to a closed configuration in which no crease is farther than
    /// `reach` (radians) from its goal angle. If the goal has to close `exactly`, a local minimum of the residual does not
    /// count.
    pub(crate) fn find(
        problem: &PlanningProblem<'_>,
        reduction: Reduction<'a>,
        reach: f64,
        exactly: bool,
    ) -> Self {
        let mut finder = RouteFinder::new(*problem, &reduction);
        let start = Instant::now();
        let targets = finder.targets(reach, exactly);
        let symmetry = start.elapsed();
        let start = Instant::now();
        let goals = problem.goal.via.len() + 1;
        let known = targets
            .as_ref()
            .ok()
            .filter(|targets| targets.len() == goals);
        let goal = known.and_then(|targets| Some(targets.last()?.angles.clone()));
        let (waypoints, end) = match targets {
            _ if problem.is_late() => (Vec::new(), End::Stopped(Stop::Timeout)),
            Ok(targets) if problem.options.search == Search::Random => {
                finder.random(&targets, SEARCH_RESTARTS)
            }
            Ok(targets) => finder.best(&targets),
            Err(end) => (Vec::new(), end),
        };
        let reached = match (end, waypoints.last()) {
            (End::Reached, _) => 1.0,
            (_, Some(last)) => fraction(&finder.asked, &last.angles),
            (_, None) => 0.0,
        };
        if finder.branches > 1 {
            finder.notes.push(Note::Branches(finder.branches));
        }
        let RouteFinder {
            notes,
            closure_tolerance,
            work,
            is_random,
            ..
        } = finder;
        Self {
            waypoints,
            goal,
            closure_tolerance,
            end,
            exactly,
            reached,
            symmetry,
            following: start.elapsed(),
            work,
            is_random,
            notes,
            symmetric: None,
            asked_closure: None,
            reduction,
        }
    }

    /// Returns the configuration at the end of the path; empty if there is no path.
    pub(crate) fn last(&self) -> &[f64] {
        self.waypoints.last().map_or(&[], |last| &last.angles)
    }

    /// Returns `true` if the route does not reach the goal, and not for want of time.
    pub(crate) fn ends_early(&self) -> bool {
        match self.end {
            End::Reached => self.waypoints.is_empty(),
            End::Stopped(stop) => stop != Stop::Timeout,
            End::NotClosed { .. } => true,
        }
    }

    /// Returns `true` if no other route can do better.
    pub(crate) fn is_complete(&self) -> bool {
        matches!(self.end, End::Reached | End::Stopped(Stop::Timeout))
    }

    /// Returns the rank of the route; a larger one is better.
    pub(crate) fn rank(&self) -> f64 {
        match self.end {
            End::Reached => 2.0,
            End::Stopped(_) => self.reached,
            End::NotClosed { .. } => -1.0,
        }
    }
}

impl<'a> RouteFinder<'a> {
    fn new(problem: PlanningProblem<'a>, reduction: &'a Reduction<'a>) -> Self {
        let (asked, signs) = reduction.asked(problem.goal);
        Self {
            problem,
            reduction,
            asked,
            signs,
            notes: Vec::new(),
            closure_tolerance: 0.0,
            branches: 0,
            is_random: false,
            work: Work::default(),
        }
    }

    fn rules(&self) -> Rules<'_> {
        Rules {
            signs: &self.signs,
            max_step: self.problem.options.max_step,
            watch: self.reduction.watch,
        }
    }

    /// Makes a solver of configurations in which no hinge turns against its sign.
    fn solver(&self, closure_tolerance: f64) -> ClosureSolver<'a> {
        let mut solver = self
            .reduction
            .solver(self.problem.options, closure_tolerance);
        solver.limits = self.reduction.orthant(&self.signs);
        solver.max_iterations = MAX_ITERATIONS;
        solver
    }

    /// Returns the closed configurations to pass through, with the goal last; without the goal if it is not a
    /// configuration. `Err` names the phase that does not close, or tells that time ran out.
    fn targets(&mut self, reach: f64, exactly: bool) -> Result<Vec<ClosedGoal>, End> {
        if self.problem.is_late() {
            return Err(End::Stopped(Stop::Timeout));
        }
        let mut targets = Vec::new();
        let goals = self.problem.goal.via.iter().chain([self.problem.goal]);
        for (index, goal) in goals.enumerate() {
            let last = index == self.problem.goal.via.len();
            if last && (goal.kind == GoalKind::Driven || !self.reduction.allows(goal)) {
                continue;
            }
            let (closed, work) = self.reduction.close_goal(goal, self.problem.options);
            self.work += work;
            let goes_near = self.problem.goes_near && last;
            let near = |closed: &ClosedGoal| {
                goes_near
                    || closed.error <= reach.min(goal.reach)
                    && !(exactly && closed.closure_tolerance > 0.0)
                    // If the goal closes as asked, but only nearly in these groups, the groups are not a symmetry of
                    // the goal.
                    && (reach > SAME_RAD || self.reduction.closure(&closed.angles) <= CLOSED)
            };
            // The flat sheet always closes, but is not what was asked for.
            let asked = largest(&goal.fold_angles);
            let turned = |closed: &ClosedGoal| {
                let moved = goes_near
                    || goal.kind == GoalKind::Letters
                    || closed.error <= MAX_MOVED_RATIO * asked;
                moved && max_norm(&closed.angles) >= MIN_TURNED_RATIO * asked
            };
            let near = closed
                .as_ref()
                .is_some_and(|closed| near(closed) && turned(closed));
            match closed {
                Some(closed) if near => targets.push(closed),
                // Letters say a way, and whoever goes near the goal goes as near as the motion leads.
                _ if goes_near || goal.kind == GoalKind::Letters => {}
                closed => {
                    return Err(End::NotClosed {
                        phase: index,
                        nearest: closed.map(|closed| closed.error),
                    });
                }
            }
        }
        Ok(targets)
    }

    /// Returns the path through all targets, or as far as it leads.
    fn best(&mut self, targets: &[ClosedGoal]) -> (Vec<Waypoint>, End) {
        let whole = targets.len() == self.problem.goal.via.len() + 1;
        let mut waypoints: Vec<Waypoint> = Vec::new();
        for (index, target) in targets.iter().enumerate() {
            let followed = match waypoints.last() {
                None => self.reach_first(target),
                Some(last) => {
                    let from = last.angles.clone();
                    self.between(&from, target)
                }
            };
            append(&mut waypoints, followed.waypoints);
            if let Some(stop) = followed.stop {
                return (waypoints, End::Stopped(stop));
            }
            if let (Some(end), true) = (waypoints.last_mut(), index < self.problem.goal.via.len()) {
                end.ends_phase = true;
            }
        }
        if whole {
            return (waypoints, End::Reached);
        }
        // The last goal is not a configuration: go as near to it as the motion leads.
        let followed = match waypoints.last().cloned() {
            None => match self.guided() {
                Some(guided) => guided,
                None => self.forwards(None),
            },
            Some(last) => {
                let mut solver = self.solver(self.closure_tolerance);
                let target = Target::Nearest(&self.asked);
                let followed = follow(&mut solver, &last.angles, None, target, self.rules());
                self.work += solver.work;
                followed
            }
        };
        append(&mut waypoints, followed.waypoints);
        let end = followed.stop.map_or(End::Reached, End::Stopped);
        (waypoints, end)
    }

    /// Follows the path to the guide's goal as far as the angle asked for, if that angle lies on the path.
    fn guided(&mut self) -> Option<Followed> {
        let guide = self.problem.goal.guide.as_deref()?;
        let problem = PlanningProblem {
            goal: guide,
            ..self.problem
        };
        let mut finder = RouteFinder {
            closure_tolerance: self.closure_tolerance,
            ..RouteFinder::new(problem, self.reduction)
        };
        let targets = finder.targets(guide.reach, false);
        let best = targets.map(|targets| finder.best(&targets));
        self.work += finder.work;
        self.is_random |= finder.is_random;
        let (mut waypoints, _) = best.ok()?;
        let closure_tolerance = finder.closure_tolerance;
        let short = |w: &Waypoint| {
            let mut pairs = self.asked.iter().zip(&w.angles);
            pairs.any(|(asked, angle)| asked.is_some_and(|a| angle.abs() + NEARLY_RAD < a.abs()))
        };
        let beyond = waypoints.iter().position(|w| !short(w))?;
        let before = waypoints.get(beyond.checked_sub(1)?)?.clone();
        waypoints.truncate(beyond);
        self.closure_tolerance = closure_tolerance;
        let mut solver = self.solver(closure_tolerance);
        let target = Target::Nearest(&self.asked);
        let came = Some(before.tangent.as_slice());
        let last = follow(&mut solver, &before.angles, came, target, self.rules());
        self.work += solver.work;
        append(&mut waypoints, last.waypoints);
        last.stop.is_none().then_some(Followed {
            waypoints,
            stop: None,
        })
    }

    /// Leads from flat to the first target: on the straight way, or else followed backwards from the target, or else
    /// followed forwards from flat, or else by the randomised search.
    fn reach_first(&mut self, target: &ClosedGoal) -> Followed {
        if let Some(straight) = self.straight_way(&vec![0.0; target.angles.len()], &target.angles) {
            return straight;
        }
        let backwards = self.backwards(target);
        if matches!(backwards.stop, None | Some(Stop::Timeout)) {
            return backwards;
        }
        // The goal closes exactly, but the path from it may not, as happens with rounded coordinates: start from a
        // local minimum of the residual near the goal.
        if target.closure_tolerance <= 0.0
            && matches!(backwards.stop, Some(Stop::Closure | Stop::Singular))
        {
            let closure_tolerance = self.reduction.closure_tolerance(self.problem.options);
            let goal = self.problem.goal.via.first().unwrap_or(self.problem.goal);
            let options = self.problem.options;
            let (rough, work) = self
                .reduction
                .close_goal_to(closure_tolerance, goal, options);
            self.work += work;
            let near = |rough: &ClosedGoal| {
                max_difference(&rough.angles, &target.angles) <= self.problem.options.max_step
            };
            if let Some(rough) = rough.filter(near) {
                let followed = self.backwards(&rough);
                if followed.stop.is_none() {
                    return followed;
                }
            }
        }
        let forwards = self.forwards(Some(target));
        if matches!(forwards.stop, None | Some(Stop::Timeout)) {
            return forwards;
        }
        if self.asked.len() > MAX_LAST_RESORT_UNKNOWNS {
            return forwards;
        }
        let (waypoints, end) = self.random(core::slice::from_ref(target), LAST_RESORT_RESTARTS);
        match end {
            End::Reached => {
                self.notes.push(Note::FoundAtRandom);
                Followed {
                    waypoints,
                    stop: None,
                }
            }
            _ => forwards,
        }
    }

    /// Returns the straight way between two configurations if the sheet closes all along it: the creases that turn do
    /// so about the same line, or each on its own.
    fn straight_way(&self, from: &[f64], to: &[f64]) -> Option<Followed> {
        let far = max_difference(from, to);
        if far <= 0.0 {
            return None;
        }
        let steps = (far / self.problem.options.max_step).ceil().max(MIN_STEPS);
        let parts = core::iter::successors(Some(0.0), |step| Some(step + 1.0));
        let parts = parts.take_while(|step| *step <= steps);
        let knots = parts.map(|step| {
            let pairs = from.iter().zip(to);
            let angles: Vec<f64> = pairs.map(|(a, b)| a + (b - a) * (step / steps)).collect();
            (self.reduction.closure(&angles) <= STRAIGHT_RESIDUAL).then_some(angles)
        });
        let knots: Vec<_> = knots.collect::<Option<_>>()?;
        Some(Followed {
            waypoints: polyline(&knots),
            stop: None,
        })
    }

    /// Follows the motion from the target to flat, and returns the path reversed.
    fn backwards(&mut self, target: &ClosedGoal) -> Followed {
        let mut solver = self.solver(target.closure_tolerance);
        self.closure_tolerance = target.closure_tolerance;
        let manners = [Homeward::Straight, Homeward::Together];
        let mut followed = Followed {
            waypoints: Vec::new(),
            stop: None,
        };
        for manner in manners {
            let flat = Target::Flat(manner);
            followed = follow(&mut solver, &target.angles, None, flat, self.rules());
            if matches!(followed.stop, None | Some(Stop::Timeout)) {
                break;
            }
        }
        self.work += solver.work;
        if followed.stop.is_some() {
            // Waypoints that do not begin at flat are no part of a path.
            followed.waypoints = vec![Waypoint::new(
                vec![0.0; target.angles.len()],
                vec![0.0; target.angles.len()],
            )];
        }
        followed.reversed()
    }

    /// Follows the motion from one target to the next, or else backwards.
    fn between(&mut self, from: &[f64], to: &ClosedGoal) -> Followed {
        if let Some(straight) = self.straight_way(from, &to.angles) {
            return straight;
        }
        let closure_tolerance = self.closure_tolerance.max(to.closure_tolerance);
        let mut solver = self.solver(closure_tolerance);
        let mut followed = follow(
            &mut solver,
            from,
            None,
            Target::Closed(&to.angles),
            self.rules(),
        );
        if followed.stop.is_some() {
            let target = Target::Closed(from);
            let back = follow(&mut solver, &to.angles, None, target, self.rules());
            if back.stop.is_none() {
                followed = back.reversed();
            }
        }
        self.work += solver.work;
        followed
    }

    /// Follows the motion from flat along the signs of the goal: with exact closure or, if only that leads all the way
    /// because coordinates are rounded, through local minima of the residual.
    fn forwards(&mut self, target: Option<&ClosedGoal>) -> Followed {
        let exact = self.forwards_to(target, 0.0);
        self.closure_tolerance = 0.0;
        if matches!(exact.stop, None | Some(Stop::Timeout)) {
            return exact;
        }
        let closure_tolerance = self.reduction.closure_tolerance(self.problem.options);
        let rough = self.forwards_to(target, closure_tolerance);
        if rough.stop.is_none() {
            self.closure_tolerance = closure_tolerance;
            return rough;
        }
        exact
    }

    /// Follows the motion from flat on the branch that leads farthest.
    fn forwards_to(&mut self, target: Option<&ClosedGoal>, closure_tolerance: f64) -> Followed {
        let towards: Vec<f64> = match target {
            Some(closed) => closed.angles.clone(),
            None => self.guess(),
        };
        let flat = vec![0.0; towards.len()];
        let mut solver = self.solver(closure_tolerance);
        let at_flat = |tangent: Vec<f64>| Waypoint::new(flat.clone(), tangent);
        let mut best = Followed {
            waypoints: vec![at_flat(flat.clone())],
            stop: Some(Stop::Singular),
        };
        let mut best_part = 0.0;
        self.is_random = true;
        let (branches, work) = branches_at_flat(
            self.reduction,
            &towards,
            &self.signs,
            closure_tolerance,
            self.problem.options,
        );
        self.work += work;
        let near = |near: &&Vec<f64>| max_norm(near) <= self.problem.options.max_step;
        for near in branches.iter().filter(near).take(MAX_BRANCHES) {
            let tangent = tangent_at_flat(&mut solver, near);
            let target = match target {
                Some(closed) => Target::Closed(&closed.angles),
                None => Target::Nearest(&self.asked),
            };
            let mut followed = follow(&mut solver, near, Some(&tangent), target, self.rules());
            followed.waypoints.insert(0, at_flat(tangent));
            if followed.stop.is_some() {
                // Waypoints beyond the one nearest to the goal are not part of the path.
                let parts = followed
                    .waypoints
                    .iter()
                    .map(|w| fraction(&self.asked, &w.angles));
                let far =
                    parts.enumerate().fold(
                        (0, 0.0),
                        |best, (k, part)| {
                            if part > best.1 { (k, part) } else { best }
                        },
                    );
                followed.waypoints.truncate(far.0 + 1);
            }
            let last = followed.waypoints.last();
            let part = last.map_or(0.0, |last| fraction(&self.asked, &last.angles));
            let done = followed.stop.is_none();
            if done || part > best_part {
                (best, best_part) = (followed, part);
            }
            if done {
                break;
            }
        }
        if solver.is_late() && best.stop.is_some() {
            best.stop = Some(Stop::Timeout);
        }
        self.work += solver.work;
        if branches.len() > 1 {
            self.branches = branches.len();
        }
        best
    }

    /// Returns a direction in which to leave flat: the angles asked for, and for free groups the largest of these
    /// angles with the group's sign.
    fn guess(&self) -> Vec<f64> {
        let largest = largest(&self.asked);
        let pairs = self.asked.iter().zip(&self.signs);
        pairs
            .map(|(asked, sign)| asked.unwrap_or(sign * largest))
            .collect()
    }

    /// Searches at random for a path to the last of the targets.
    fn random(&mut self, targets: &[ClosedGoal], restarts: usize) -> (Vec<Waypoint>, End) {
        self.is_random = true;
        let options = self.problem.options;
        let exact = options.search != Search::Random;
        // As in the report, a closure residual that the deformation bound allows is enough.
        let tolerance = if exact {
            0.0
        } else {
            self.reduction.closure_tolerance(options)
        };
        let mut solver = self.solver(tolerance);
        solver.tolerance = solver.tolerance.max(tolerance);
        let mut judge = Judge::new(&self.problem, self.reduction, options.collision && !exact);
        let closed = targets.last().map(|closed| closed.angles.as_slice());
        let asked: Vec<Option<f64>> = match closed {
            Some(closed) => closed.iter().map(|&angle| Some(angle)).collect(),
            None => self.asked.clone(),
        };
        let feasible = &mut |angles: &[f64]| {
            let errors = judge.errors_at(angles);
            judge.crossing().is_none()
                && errors.deformation <= options.bound
                && errors.gap <= options.bound
        };
        let followed = search(
            &mut solver,
            &asked,
            closed,
            restarts,
            self.rules(),
            options,
            feasible,
        );
        self.work += solver.work;
        self.closure_tolerance = tolerance;
        let end = followed.stop.map_or(End::Reached, End::Stopped);
        (followed.waypoints, end)
    }
}

/// Makes the straight path from flat to the group angles `goal`, as a sheet that may deform could go. Each
/// configuration is moved to the local minimum of the residual, if that is near.
pub(crate) fn straight(
    reduction: &Reduction,
    goal: &[f64],
    options: &PlanOptions,
) -> Vec<Waypoint> {
    let mut solver = reduction.solver(options, options.bound);
    let steps = (max_norm(goal) / options.max_step).ceil().max(1.0);
    let mut knots = vec![vec![0.0; goal.len()]];
    let mut step = 1.0;
    while step <= steps {
        let exact: Vec<f64> = goal.iter().map(|angle| angle * step / steps).collect();
        let mut near = exact.clone();
        // The last configuration is the goal itself.
        let moves = step < steps && solver.closes(&mut near);
        let same = moves
            && max_difference(&near, &exact) <= MAX_SHIFT_RATIO * options.max_step
            && near.iter().zip(goal).all(|(near, goal)| near * goal >= 0.0);
        knots.push(if same { near } else { exact });
        step += 1.0;
    }
    polyline(&knots)
}

/// Largest distance that a configuration of the straight path may be moved, as a fraction of the largest step.
const MAX_SHIFT_RATIO: f64 = 0.25;

/// Appends waypoints to a path, which rests where the two join at a corner.
fn append(waypoints: &mut Vec<Waypoint>, next: Vec<Waypoint>) {
    if let (Some(corner), Some(first)) = (waypoints.last_mut(), next.first()) {
        if max_difference(&corner.tangent, &first.tangent) > SMOOTH_TURN {
            corner.tangent.fill(0.0);
        }
        waypoints.extend(next.into_iter().skip(1));
    } else {
        *waypoints = next;
    }
}

/// Largest change of a unit tangent that is no corner.
const SMOOTH_TURN: f64 = 1e-6;
