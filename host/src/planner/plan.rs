//! Planning from beginning to end.

use core::time::Duration;
use std::time::Instant;

use super::follow::{Followed, Stop, follow_to_flat};
use super::judge::Judge;
use super::knots::{Knot, Path, timed};
use super::reduction::{ClosedGoal, Reduction, reduce};
use super::solver::{ClosureSolver, Work};
use super::{Goal, PlanOptions};
use crate::collision::{CollisionCounts, Crossing};
use crate::folding::Rigidity;
use crate::pattern::CreasePattern;

/// The answer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Outcome {
    /// The path reaches the goal, within the bound and free of crossings at every knot.
    #[default]
    Planned,
    /// The path ends between flat and goal.
    Partial,
    /// The sheet deforms beyond the bound although the essential pattern does not.
    NotRigidlyFoldable,
    /// No closed configuration was found near the goal.
    GoalNotClosed,
    /// Faces pass through each other.
    Crossing(Crossing),
    /// Out of time.
    Timeout,
}

impl Outcome {
    /// Its name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Planned => "planned",
            Self::Partial => "partial",
            Self::NotRigidlyFoldable => "not_rigidly_foldable",
            Self::GoalNotClosed => "goal_not_closed",
            Self::Crossing(_) => "crossing",
            Self::Timeout => "timeout",
        }
    }
}

/// Time spent in each stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Times {
    /// Finding crease groups and essential vertices, and closing the goal under them.
    pub symmetry: Duration,
    /// Following the path in group angles.
    pub solve: Duration,
    /// Folding the whole sheet at every knot and measuring it.
    pub fold: Duration,
    /// Looking for crossings at every knot.
    pub collision: Duration,
}

/// A plan: the answer, the path as far as it got, and what was measured.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// The answer.
    pub outcome: Outcome,
    /// Why the outcome is not `Planned`, in words.
    pub reason: Option<String>,
    /// Fraction of the way to the goal that is free to go.
    pub reached: f64,
    /// The path, from flat; empty if none was found.
    pub path: Path,
    /// Number of crease groups.
    pub groups: usize,
    /// Number of essential vertices.
    pub essential_vertices: usize,
    /// Unknowns that the solver worked on.
    pub unknowns: usize,
    /// Worst deformation and gap over all knots.
    pub rigidity: Rigidity,
    /// Worst deformation and gap of the essential crease pattern over all knots.
    pub essential_rigidity: Rigidity,
    /// Faces of the essential crease pattern.
    pub essential_faces: usize,
    /// Largest closure residual of a real vertex over all knots.
    pub max_closure: f64,
    /// Largest closure residual of the goal asked for.
    pub goal_closure: f64,
    /// Largest difference of a fold angle at the end from the goal asked for, radians.
    pub goal_error: f64,
    /// Iterations of the solver.
    pub iterations: u64,
    /// Evaluations of the closure conditions by the solver.
    pub evaluations: u64,
    /// What the search for crossings looked at.
    pub collision: CollisionCounts,
    /// Time spent.
    pub times: Times,
    /// What the user should know, in words.
    pub notes: Vec<String>,
}

/// Plans the path of `pattern` from flat to `goal`.
///
/// Always answers: a sheet that cannot be folded is an outcome, not an error.
#[must_use]
pub fn plan(pattern: &CreasePattern, goal: &Goal, options: &PlanOptions) -> Plan {
    Planning::new(pattern, goal, options).run()
}

struct Planning<'a> {
    pattern: &'a CreasePattern,
    goal: &'a Goal,
    options: &'a PlanOptions,
    deadline: Option<Instant>,
    plan: Plan,
}

impl<'a> Planning<'a> {
    fn new(pattern: &'a CreasePattern, goal: &'a Goal, options: &'a PlanOptions) -> Self {
        Self {
            pattern,
            goal,
            options,
            deadline: options
                .timeout
                .and_then(|timeout| Instant::now().checked_add(timeout)),
            plan: Plan::default(),
        }
    }

    fn run(mut self) -> Plan {
        let start = Instant::now();
        let mut work = Work::default();
        let notes = &mut self.plan.notes;
        let (reduction, closed) = reduce(self.pattern, self.goal, self.options, &mut work, notes);
        self.plan.groups = reduction.groups.len();
        self.plan.essential_vertices = reduction.essential.vertices().len();
        self.plan.unknowns = reduction.groups.len();
        self.plan.path.memberships = reduction.groups.memberships().to_vec();
        self.plan.times.symmetry = start.elapsed();
        let far = closed
            .as_ref()
            .filter(|closed| closed.error > self.goal.reach);
        let (Some(closed), None) = (&closed, far) else {
            self.count(work);
            let nearest = far.map_or(String::new(), |far| {
                let degrees = far.error.to_degrees();
                format!(": the nearest found turns a crease {degrees:.1} degrees from its goal")
            });
            let goal = &self.goal.source;
            let reason = format!("no closed configuration was found near {goal}{nearest}");
            return self.end(Outcome::GoalNotClosed, reason);
        };
        self.plan.goal_error = closed.error;
        self.plan.goal_closure = closed.asked_closure;
        if closed.asked_closure > CLOSED {
            self.plan.notes.push(format!(
                "{} does not close (residual {:.1e}): moved to the nearest configuration found that \
                 does, {:.3e} degrees away",
                self.goal.source,
                closed.asked_closure,
                closed.error.to_degrees()
            ));
        }

        let start = Instant::now();
        let mut rough = None;
        let (mut solver, mut followed) = self.follow(&reduction, closed, &mut work);
        if closed.accepted <= 0.0 && matches!(followed.stop, Some(Stop::Closure | Stop::Singular)) {
            // The goal closes exactly, by luck or by rounding; the way there may not.
            let accepted = reduction.accepted(self.options);
            rough = reduction.close_goal_to(accepted, self.goal, self.options, &mut work);
        }
        let mut closed = closed;
        if let Some(rough) = rough
            .as_ref()
            .filter(|rough| rough.error <= self.goal.reach)
        {
            let (rough_solver, rough_followed) = self.follow(&reduction, rough, &mut work);
            if rough_followed.stop.is_none() {
                (closed, solver, followed) = (rough, rough_solver, rough_followed);
                self.plan.goal_error = rough.error;
            }
        }
        self.plan.times.solve = start.elapsed();
        self.count(work);
        if let Some(stop) = followed.stop {
            return self.stopped(stop, &followed, closed);
        }
        self.plan.path.interpolation = self.options.interpolation;
        self.plan.path.knots = timed(&followed.waypoints, self.options.max_speed);
        self.plan.reached = 1.0;
        self.judge(&reduction, &mut solver)
    }

    fn follow<'r>(
        &self,
        reduction: &'r Reduction,
        closed: &ClosedGoal,
        work: &mut Work,
    ) -> (ClosureSolver<'r>, Followed) {
        let mut solver = reduction.solver(self.options, closed);
        let max_step = self.options.max_step;
        let followed = follow_to_flat(&mut solver, &closed.angles, max_step, self.deadline);
        work.iterations += solver.work.iterations;
        work.evaluations += solver.work.evaluations;
        (solver, followed)
    }

    fn count(&mut self, work: Work) {
        self.plan.iterations = work.iterations;
        self.plan.evaluations = work.evaluations;
    }

    fn end(mut self, outcome: Outcome, reason: String) -> Plan {
        self.plan.outcome = outcome;
        self.plan.reason = Some(reason);
        self.plan
    }

    fn stopped(self, stop: Stop, followed: &Followed, closed: &ClosedGoal) -> Plan {
        let norm = |x: &[f64]| x.iter().map(|a| a * a).sum::<f64>().sqrt();
        let last = followed.waypoints.last();
        let left = last.map_or(1.0, |last| norm(&last.angles) / norm(&closed.angles));
        let why = match stop {
            Stop::Singular => "no motion leads on towards the flat sheet",
            Stop::Closure => "no closed configuration follows within the smallest step",
            Stop::TooLong => "the motion goes on without coming nearer to the flat sheet",
            Stop::Timeout => "out of time",
        };
        let reason = format!(
            "followed from the goal towards the flat sheet, {why} at {:.1} % of the goal's angles",
            100.0 * left
        );
        let timeout = stop == Stop::Timeout;
        self.end(
            if timeout {
                Outcome::Timeout
            } else {
                Outcome::Partial
            },
            reason,
        )
    }

    /// Reuses the path on the whole sheet: judges it at every knot.
    fn judge(mut self, reduction: &Reduction, solver: &mut ClosureSolver<'_>) -> Plan {
        let mut judge = Judge::new(self.pattern, reduction, self.options.collision);
        let mut knots = core::mem::take(&mut self.plan.path.knots);
        let mut crossed = None;
        for (index, knot) in knots.iter_mut().enumerate() {
            if self
                .deadline
                .is_some_and(|deadline| Instant::now() >= deadline)
            {
                self.plan.reached = 0.0;
                let reason = format!("out of time while judging knot {index}");
                return self.end(Outcome::Timeout, reason);
            }
            if let Some(crossing) = judge.judge(knot) {
                crossed = Some((index, crossing));
                break;
            }
        }
        if let Some((index, crossing)) = crossed {
            let end = knots.last().map_or(0.0, |knot| knot.time);
            let refused = knots.split_off(index);
            let (from, to) = (knots.last(), &refused[0]);
            let free = from.map(|from| (from.time, judge.last_free(solver, from, to)));
            let (time, angles) = free.map_or_else(
                || (0.0, to.angles.clone()),
                |(time, (s, angles))| (time + s * (to.time - time), angles),
            );
            self.plan.reached = if end > 0.0 { time / end } else { 0.0 };
            let [a, b] = crossing.faces;
            let reason = format!(
                "faces {a} and {b} pass through each other beyond {:.2} % of the path (at knot \
                 {index}: {:.1e} median edges deep)",
                100.0 * self.plan.reached,
                crossing.depth / self.pattern.median_edge()
            );
            let goal = &refused[refused.len() - 1].angles;
            let short = goal
                .iter()
                .zip(&angles)
                .fold(0.0, |max, (a, b)| f64::max(max, (a - b).abs()));
            if self.plan.goal_closure <= CLOSED || short > RETREAT || knots.is_empty() {
                self.note(&judge);
                self.measure(&knots);
                self.plan.path.knots = knots;
                return self.end(Outcome::Crossing(crossing), reason);
            }
            self.plan.notes.push(format!(
                "the goal itself does not close (residual {:.1e}) and its neighbours cross: the path \
                 ends {:.3} degrees before, where {reason}",
                self.plan.goal_closure,
                short.to_degrees()
            ));
            self.plan.reached = 1.0;
            self.plan.goal_error = reduction.distance(&angles, self.goal);
            let mut last = Knot {
                time,
                angles,
                ..to.clone()
            };
            judge.judge(&mut last);
            if knots.last().is_some_and(|knot| knot.time < time) {
                knots.push(last);
            }
        }
        (self.plan.essential_rigidity, self.plan.essential_faces) = judge.essential(&knots);
        self.note(&judge);
        self.measure(&knots);
        self.plan.path.knots = knots;
        self.judge_rigidity()
    }

    fn note(&mut self, judge: &Judge<'_>) {
        self.plan.collision = judge.counts();
        self.plan.times.fold = judge.fold;
        self.plan.times.collision = judge.collision;
    }

    fn measure(&mut self, knots: &[Knot]) {
        for knot in knots {
            self.plan.rigidity = self.plan.rigidity.worse(Rigidity {
                deformation: knot.deformation,
                gap: knot.gap,
            });
            self.plan.max_closure = self.plan.max_closure.max(knot.closure);
        }
    }

    fn judge_rigidity(self) -> Plan {
        let bound = self.options.bound;
        let (whole, essential) = (self.plan.rigidity, self.plan.essential_rigidity);
        if whole.deformation <= bound && whole.gap <= bound {
            return self.plan;
        }
        let reason = format!(
            "the whole sheet deforms by {:.3e} with gaps of {:.3e}, over the bound {bound:.3e}; its \
             essential crease pattern by {:.3e} with gaps of {:.3e}",
            whole.deformation, whole.gap, essential.deformation, essential.gap
        );
        self.end(Outcome::NotRigidlyFoldable, reason)
    }
}

/// Closure residual up to which a goal counts as exact: above the rounding of angles in degrees.
const CLOSED: f64 = 1e-9;
/// Radians by which a path may stop short of an inexact goal so that nothing crosses.
const RETREAT: f64 = 0.02;
