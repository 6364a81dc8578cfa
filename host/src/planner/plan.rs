//! Planning from beginning to end.

use core::time::Duration;
use std::time::Instant;

use super::follow::{Followed, Stop, follow_to_flat, norm};
use super::judge::Judge;
use super::knots::{Knot, Path, timed};
use super::reduction::{CLOSED, ClosedGoal, Reduction, closure_of, reduce};
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
    /// Finding the spanning tree, crease groups and essential vertices, closing the goal under them, and its own closure.
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
    /// Largest closure residual of a real vertex, or twist of a hinge, over all knots.
    pub max_closure: f64,
    /// How much larger than the closure residuals of its vertices the errors of the whole sheet can
    /// be; `None` where a hole adds conditions of its own.
    pub amplification: Option<f64>,
    /// Closure residual that no vertex may exceed, so that the whole sheet keeps the bound.
    pub essential_tolerance: f64,
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
        self.plan.amplification = reduction.amplification;
        self.plan.essential_tolerance = reduction.accepted(self.options);
        self.plan.path.memberships = reduction.groups.memberships().to_vec();
        self.plan.times.symmetry = start.elapsed();
        let nearest = closed.as_ref().map(|closed| closed.error);
        let Some(closed) = closed.filter(|closed| closed.error <= self.goal.reach) else {
            self.count(work);
            return self.not_closed(nearest);
        };

        let start = Instant::now();
        let (closed, mut solver, followed) = self.follow_best(&reduction, closed, &mut work);
        self.plan.times.solve = start.elapsed();
        self.count(work);
        self.plan.goal_error = closed.error;
        let start = Instant::now();
        self.plan.goal_closure = self.goal_closure(&reduction, &closed);
        self.plan.times.symmetry += start.elapsed();
        if self.plan.goal_closure > CLOSED {
            self.plan.notes.push(format!(
                "not closed: {} (residual {:.1e}); moved to the nearest configuration found that is, \
                 {:.2e} degrees away",
                self.goal.source,
                self.plan.goal_closure,
                closed.error.to_degrees()
            ));
        }
        if let Some(stop) = followed.stop {
            return self.stopped(stop, &followed, &closed);
        }
        self.plan.path.interpolation = self.options.interpolation;
        self.plan.path.knots = timed(&followed.waypoints, self.options.max_speed);
        self.plan.reached = 1.0;
        self.judge(&reduction, &mut solver)
    }

    /// Closure residual of the goal asked for, free hinges as they close.
    fn goal_closure(&self, reduction: &Reduction, closed: &ClosedGoal) -> f64 {
        let angles = reduction.groups.expand(&closed.angles);
        let asked = self.goal.fold_angles.iter().zip(angles);
        let angles: Vec<_> = asked.map(|(asked, free)| asked.or(Some(free))).collect();
        closure_of(self.pattern, &angles).unwrap_or(0.0)
    }

    fn not_closed(self, nearest: Option<f64>) -> Plan {
        let goal = &self.goal.source;
        let mut reason = format!("no closed configuration was found near {goal}");
        if let Some(error) = nearest {
            let degrees = error.to_degrees();
            reason +=
                &format!(": the nearest found turns a crease {degrees:.1} degrees from its goal");
        }
        self.end(Outcome::GoalNotClosed, reason)
    }

    /// Follows the path from the goal. Where that closes exactly but the way from it does not, as
    /// happens with rounded coordinates, the way from one that closes as well as can be is tried.
    fn follow_best<'r>(
        &self,
        reduction: &'r Reduction,
        closed: ClosedGoal,
        work: &mut Work,
    ) -> (ClosedGoal, ClosureSolver<'r>, Followed) {
        let (solver, followed) = self.follow(reduction, &closed, work);
        let exact = closed.accepted <= 0.0;
        if exact && matches!(followed.stop, Some(Stop::Closure | Stop::Singular)) {
            let accepted = reduction.accepted(self.options);
            let rough = reduction.close_goal_to(accepted, self.goal, self.options, work);
            if let Some(rough) = rough.filter(|rough| rough.error <= self.goal.reach) {
                let (rough_solver, rough_followed) = self.follow(reduction, &rough, work);
                if rough_followed.stop.is_none() {
                    return (rough, rough_solver, rough_followed);
                }
            }
        }
        (closed, solver, followed)
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
        let outcome = match stop {
            Stop::Timeout => Outcome::Timeout,
            _ => Outcome::Partial,
        };
        self.end(outcome, reason)
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
                knots.truncate(index);
                self.note(&judge, knots);
                return self.end(Outcome::Timeout, reason);
            }
            if let Some(crossing) = judge.judge(knot) {
                crossed = Some((index, crossing));
                break;
            }
        }
        if let Some((index, crossing)) = crossed {
            let refused = knots.split_off(index);
            if let Some(reason) =
                self.stop_before(&mut judge, solver, &mut knots, &refused, crossing)
            {
                self.note(&judge, knots);
                return self.end(Outcome::Crossing(crossing), reason);
            }
        }
        (self.plan.essential_rigidity, self.plan.essential_faces) = judge.essential(&knots);
        self.note(&judge, knots);
        self.judge_rigidity()
    }

    /// Ends the path before the first crossing, which is between the last of `knots` and the first
    /// of those `refused`. An inexact goal near that is reached all the same; otherwise says why it
    /// is not.
    fn stop_before(
        &mut self,
        judge: &mut Judge<'_>,
        solver: &mut ClosureSolver<'_>,
        knots: &mut Vec<Knot>,
        refused: &[Knot],
        crossing: Crossing,
    ) -> Option<String> {
        let (Some(to), Some(goal)) = (refused.first(), refused.last()) else {
            return None;
        };
        let (time, angles, rates) = knots.last().map_or_else(
            || (0.0, to.angles.clone(), to.rates.clone()),
            |from| {
                let (s, angles) = judge.last_free(solver, from, to);
                let rates = from.rates.iter().zip(&to.rates);
                let rates = rates.map(|(a, b)| a + s * (b - a)).collect();
                (from.time + s * (to.time - from.time), angles, rates)
            },
        );
        self.plan.goal_error = judge.distance(&angles, self.goal);
        self.plan.reached = if goal.time > 0.0 {
            time / goal.time
        } else {
            0.0
        };
        let [a, b] = crossing.faces;
        let reason = format!(
            "faces {a} and {b} pass through each other beyond {:.2} % of the path (at knot {}: {:.1e} \
             median edges deep)",
            100.0 * self.plan.reached,
            knots.len(),
            crossing.depth / self.pattern.median_edge()
        );
        let differences = goal.angles.iter().zip(&angles).map(|(a, b)| (a - b).abs());
        let short = differences.fold(0.0, f64::max);
        if self.plan.goal_closure <= CLOSED || short > RETREAT || knots.is_empty() {
            return Some(reason);
        }
        self.plan.notes.push(format!(
            "the goal itself does not close (residual {:.1e}), and near it {reason}: the path ends {:.3} \
             degrees before",
            self.plan.goal_closure,
            short.to_degrees(),
        ));
        self.plan.reached = 1.0;
        if knots.last().is_some_and(|knot| knot.time < time) {
            let mut last = Knot {
                time,
                angles,
                rates,
                ..Knot::default()
            };
            if judge.judge(&mut last).is_none() {
                knots.push(last);
            }
        }
        None
    }

    /// Notes what was measured at the knots, and keeps them.
    fn note(&mut self, judge: &Judge<'_>, knots: Vec<Knot>) {
        self.plan.collision = judge.counts();
        self.plan.times.fold = judge.fold;
        self.plan.times.collision = judge.collision;
        for knot in &knots {
            self.plan.rigidity = self.plan.rigidity.worse(Rigidity {
                deformation: knot.deformation,
                gap: knot.gap,
                twist: knot.closure,
            });
            self.plan.max_closure = self.plan.max_closure.max(knot.closure);
        }
        self.plan.path.knots = knots;
    }

    fn judge_rigidity(self) -> Plan {
        let bound = self.options.bound;
        let (whole, essential) = (self.plan.rigidity, self.plan.essential_rigidity);
        let within = [whole.deformation, whole.gap, self.plan.max_closure];
        if within.iter().all(|value| *value <= bound) {
            return self.plan;
        }
        let reason = format!(
            "the whole sheet deforms by {:.3e} with gaps of {:.3e} and closure {:.3e}, over the bound \
             {bound:.3e}; its essential crease pattern by {:.3e} with gaps of {:.3e}",
            whole.deformation,
            whole.gap,
            self.plan.max_closure,
            essential.deformation,
            essential.gap
        );
        self.end(Outcome::NotRigidlyFoldable, reason)
    }
}

/// Radians by which a path may stop short of an inexact goal so that nothing crosses.
const RETREAT: f64 = 0.02;
