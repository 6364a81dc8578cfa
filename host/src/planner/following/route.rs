//! The route on given crease groups, from flat to the goal or as near as the motion leads: backwards from the goal, or
//! else forwards from flat, or else by the randomised search.

use super::follow::{Followed, Target, Waypoint, follow};
use super::judge::Judge;
use super::legs::{RouteFinder, append};
use super::nearly_closed::nearly_closed;
use super::reduction::{CLOSED, ClosedGoal, Reduction, SAME_RAD};
use crate::planner::Search;
use crate::planner::goal::GoalKind;
use crate::planner::plan::Effort;
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{Note, Stop};
use crate::planner::vectors::{fraction, largest, max_difference, max_norm};
use crate::progress::Stage;
use crate::symmetry::CreaseGroups;

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
    /// Work spent on all routes that were tried.
    pub(crate) effort: Effort,
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
/// Number of restarts of the randomised search as a last resort.
const LAST_RESORT_RESTARTS: usize = 3;
/// Number of unknowns above which the randomised search is not tried as a last resort: samples are too costly and too
/// rarely good.
const MAX_LAST_RESORT_UNKNOWNS: usize = 200;
/// Number of restarts of the randomised search if it is asked for.
const SEARCH_RESTARTS: usize = 20;

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
        let targets = problem.stage(Stage::Symmetry, || finder.targets(reach, exactly));
        problem.watch.begin(Stage::Following);
        let goals = problem.goal.via.len() + 1;
        let known = targets
            .as_ref()
            .ok()
            .filter(|targets| targets.len() == goals);
        let goal = known.and_then(|targets| Some(targets.last()?.angles.clone()));
        let followed = match targets {
            _ if problem.is_late() => Err(End::Stopped(Stop::Timeout)),
            Ok(targets) if problem.options.search == Search::Random => {
                Ok(finder.random(&targets, SEARCH_RESTARTS))
            }
            Ok(targets) => Ok(finder.best(&targets)),
            Err(end) => Err(end),
        };
        let (waypoints, end) = match followed {
            Ok(Followed { waypoints, stop }) => {
                (waypoints, stop.map_or(End::Reached, End::Stopped))
            }
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
            known_goal,
            ..
        } = finder;
        Self {
            waypoints,
            goal: goal.or(known_goal),
            closure_tolerance,
            end,
            exactly,
            reached,
            effort: Effort {
                iterations: work.iterations,
                evaluations: work.evaluations,
                is_random,
                ..Effort::default()
            },
            notes,
            symmetric: None,
            asked_closure: None,
            reduction,
        }
    }

    /// Looks for a route on which every crease turns on its own, and the sheet may fail to close by as much as its bound.
    /// Returns `None` if a crease has no goal angle, the goal has goals on the way, or there is none.
    pub(crate) fn nearly_closed(problem: &PlanningProblem<'a>) -> Option<Self> {
        let (goal, options) = (problem.goal, problem.options);
        let reduction = Reduction::of(problem, CreaseGroups::trivial(problem.pattern));
        let asked: Option<Vec<f64>> = reduction.asked(goal).0.into_iter().collect();
        let asked = asked.filter(|_| goal.via.is_empty() && reduction.allows(goal))?;
        let waypoints = nearly_closed(&reduction, &asked, options, options.bound)?;
        let mut judge = Judge::new(problem, &reduction, false);
        let keeps_bound = |waypoint: &Waypoint| {
            let errors = judge.errors_at(&waypoint.angles);
            errors.deformation <= options.bound && errors.gap <= options.bound
        };
        if !waypoints.iter().all(keeps_bound) {
            return None;
        }
        Some(Self {
            waypoints,
            closure_tolerance: options.bound,
            end: End::Reached,
            exactly: false,
            reached: 1.0,
            effort: Effort::default(),
            notes: vec![Note::NearlyClosed],
            symmetric: None,
            asked_closure: Some(reduction.closure_of_sheet(&asked)),
            goal: Some(asked),
            reduction,
        })
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
    fn best(&mut self, targets: &[ClosedGoal]) -> Followed {
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
            let stop = followed.stop;
            if stop.is_some() {
                return Followed { waypoints, stop };
            }
            if let (Some(end), true) = (waypoints.last_mut(), index < self.problem.goal.via.len()) {
                end.ends_phase = true;
            }
        }
        let stop = None;
        if whole {
            return Followed { waypoints, stop };
        }
        // The last goal is not a configuration: go as near to it as the motion leads.
        let followed = match waypoints.last().cloned() {
            None => {
                let way = self.up_to_limits().or_else(|| self.guided(true));
                let way = way.or_else(|| self.complete(None));
                let way = way.or_else(|| self.guided(false));
                way.unwrap_or_else(|| self.forwards(None))
            }
            Some(last) => self.complete(Some(&last.angles)).unwrap_or_else(|| {
                let mut solver = self.solver(self.closure_tolerance);
                let target = Target::Nearest(&self.asked);
                let followed = follow(&mut solver, &last.angles, None, target, self.rules());
                self.work += solver.work;
                followed
            }),
        };
        append(&mut waypoints, followed.waypoints);
        let stop = followed.stop;
        Followed { waypoints, stop }
    }

    /// Leads each hinge to its goal angle or to its limit before that, so that a limit stops no hinge but its own. Returns
    /// `None` if no limit is in the way, or the sheet does not close there.
    fn up_to_limits(&mut self) -> Option<Followed> {
        let asked = self.problem.goal;
        let mut goal = asked.clone();
        let mut limited = None;
        for limit in &self.problem.options.limits {
            let angle = &mut goal.fold_angles[limit.crease.index()];
            let kept = angle.map(|angle| angle.clamp(limit.lower, limit.upper));
            if kept != *angle {
                limited.get_or_insert(self.reduction.groups.of(limit.crease).group.index());
            }
            *angle = kept;
        }
        let stop = Stop::Limit(limited?);
        let problem = PlanningProblem {
            goal: &goal,
            ..self.problem
        };
        let mut finder = RouteFinder::new(problem, self.reduction);
        let targets = finder.targets(SAME_RAD, true).unwrap_or_default();
        let way = match targets.first() {
            Some(target) => Some(finder.reach_first(target)),
            None => finder.complete(None),
        };
        self.work += finder.work;
        self.is_random |= finder.is_random;
        let way = way.filter(|way| way.stop.is_none())?;
        self.closure_tolerance = finder.closure_tolerance;
        Some(Followed {
            stop: Some(stop),
            ..way
        })
    }

    /// Follows the path to the guide's goal as far as the angle asked for, if that angle lies on the path. The guide is the
    /// configuration that the pattern names or, if `is_named` is `false`, its letters.
    fn guided(&mut self, is_named: bool) -> Option<Followed> {
        let guide = self.problem.goal.guide.as_deref()?;
        if is_named != (guide.kind == GoalKind::Configuration) {
            return None;
        }
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
        let mut waypoints = best.ok()?.waypoints;
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
        let random = self.random(core::slice::from_ref(target), LAST_RESORT_RESTARTS);
        if random.stop.is_some() {
            return forwards;
        }
        self.notes.push(Note::FoundAtRandom);
        random
    }
}
