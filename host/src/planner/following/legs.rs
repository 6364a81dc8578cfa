//! Legs of a route between two configurations: straight, followed backwards from the goal or forwards from flat, or found
//! by the randomised search.

use super::branch::branches_at_flat;
use super::follow::{Followed, Homeward, Rules, Target, Waypoint, follow, tangent_at_flat};
use super::judge::Judge;
use super::reduction::{CLOSED, ClosedGoal, Reduction};
use super::search::{polyline, search};
use crate::planner::closing::solver::{ClosureSolver, Work};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{Note, Stop};
use crate::planner::vectors::{fraction, largest, max_difference, max_norm};
use crate::planner::{PlanOptions, Search};

/// Largest number of iterations to close a predicted configuration: a handful suffice, unless nothing closes there.
const MAX_ITERATIONS: u32 = 25;
/// Smallest number of steps on a straight way: its two ends close in any case.
const MIN_STEPS: f64 = 4.0;
/// Largest number of branches that are followed from flat.
const MAX_BRANCHES: usize = 4;

/// State shared by all steps of the search for a route.
pub(super) struct RouteFinder<'a> {
    pub(super) problem: PlanningProblem<'a>,
    pub(super) reduction: &'a Reduction<'a>,
    /// Group angles that the goal asks for.
    pub(super) asked: Vec<Option<f64>>,
    pub(super) signs: Vec<f64>,
    pub(super) notes: Vec<Note>,
    /// Closure residual up to which a local minimum counted as closed on the path found last.
    pub(super) closure_tolerance: f64,
    /// Closed configuration in which driven creases have their angles, if one is known to which no way was found.
    pub(super) known_goal: Option<Vec<f64>>,
    /// Number of motions found that leave the flat sheet.
    pub(super) branches: usize,
    /// `true` if random numbers were drawn.
    pub(super) is_random: bool,
    pub(super) work: Work,
}

impl<'a> RouteFinder<'a> {
    pub(super) fn new(problem: PlanningProblem<'a>, reduction: &'a Reduction<'a>) -> Self {
        let (asked, signs) = reduction.asked(problem.goal);
        Self {
            problem,
            reduction,
            asked,
            signs,
            notes: Vec::new(),
            closure_tolerance: 0.0,
            known_goal: None,
            branches: 0,
            is_random: false,
            work: Work::default(),
        }
    }

    pub(super) fn rules(&self) -> Rules<'_> {
        Rules {
            signs: &self.signs,
            max_step: self.problem.options.max_step,
            watch: self.reduction.watch,
        }
    }

    /// Makes a solver of configurations in which no hinge turns against its sign.
    pub(super) fn solver(&self, closure_tolerance: f64) -> ClosureSolver<'a> {
        let mut solver = self
            .reduction
            .solver(self.problem.options, closure_tolerance);
        solver.limits = self.reduction.orthant(&self.signs);
        solver.max_iterations = MAX_ITERATIONS;
        solver
    }

    /// Returns the straight way between two configurations if the sheet closes all along it: the creases that turn do
    /// so about the same line, or each on its own.
    pub(super) fn straight_way(&self, from: &[f64], to: &[f64]) -> Option<Followed> {
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
            (self.reduction.closure(&angles) <= CLOSED).then_some(angles)
        });
        let knots: Vec<_> = knots.collect::<Option<_>>()?;
        Some(Followed {
            waypoints: polyline(&knots),
            stop: None,
        })
    }

    /// Follows the motion from the target to flat, and returns the path reversed.
    pub(super) fn backwards(&mut self, target: &ClosedGoal) -> Followed {
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
    pub(super) fn between(&mut self, from: &[f64], to: &ClosedGoal) -> Followed {
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
    pub(super) fn forwards(&mut self, target: Option<&ClosedGoal>) -> Followed {
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
                let waypoints = followed.waypoints.iter().enumerate();
                let far = waypoints.fold((0, 0.0), |best, (k, waypoint)| {
                    let part = fraction(&self.asked, &waypoint.angles);
                    if part > best.1 { (k, part) } else { best }
                });
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
    pub(super) fn random(&mut self, targets: &[ClosedGoal], restarts: usize) -> Followed {
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
        followed
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
pub(super) fn append(waypoints: &mut Vec<Waypoint>, next: Vec<Waypoint>) {
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
