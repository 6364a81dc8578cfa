//! Planning from beginning to end.

use core::time::Duration;
use std::time::Instant;

use super::follow::{Followed, Stop, follow_to_flat};
use super::knots::{Knot, Path, timed};
use super::reduction::{ClosedGoal, Reduction, reduce};
use super::solver::{ClosureSolver, Work};
use super::{Goal, PlanOptions};
use crate::collision::{CollisionCounts, CollisionScene, Crossing};
use crate::folding::{FoldingMap, Rigidity, SpanningTree};
use crate::pattern::CreasePattern;
use crate::symmetry::essential_pattern;

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
            deadline: options.timeout.map(|timeout| Instant::now() + timeout),
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
        let Some(closed) = closed else {
            self.count(work);
            let reason = format!(
                "no closed configuration was found near {}",
                self.goal.source
            );
            return self.end(Outcome::GoalNotClosed, reason);
        };
        self.plan.goal_error = closed.error;
        self.plan.goal_closure = closed.asked_closure;

        let start = Instant::now();
        let mut solver = ClosureSolver::new(reduction.stars().view(), self.options.solver);
        let max_step = self.options.max_step;
        let followed = follow_to_flat(&mut solver, &closed.angles, max_step, self.deadline);
        work.iterations += solver.work.iterations;
        work.evaluations += solver.work.evaluations;
        self.plan.times.solve = start.elapsed();
        self.count(work);
        if let Some(stop) = followed.stop {
            return self.stopped(stop, &followed, &closed);
        }
        self.plan.path.interpolation = self.options.interpolation;
        self.plan.path.knots = timed(&followed.waypoints, self.options.max_speed);
        self.plan.reached = 1.0;
        self.judge(&reduction, &mut solver)
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

    /// Reuses the path on the whole sheet: folds it at every knot, measures, looks for crossings.
    fn judge(mut self, reduction: &Reduction, solver: &mut ClosureSolver<'_>) -> Plan {
        let start = Instant::now();
        let tree = SpanningTree::from_central_face(self.pattern);
        let flat = vec![0.0; self.pattern.creases().len()];
        let mut map = FoldingMap::new(self.pattern, &tree, &flat);
        self.plan.times.fold += start.elapsed();
        let start = Instant::now();
        let collision = self.options.collision;
        let mut scene = collision.then(|| CollisionScene::new(self.pattern));
        self.plan.times.collision += start.elapsed();

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
            let start = Instant::now();
            map.fold(self.pattern, &tree, &reduction.groups.expand(&knot.angles));
            let rigidity = map.rigidity(self.pattern);
            knot.closure = reduction.closure(&knot.angles);
            knot.deformation = rigidity.deformation;
            knot.gap = rigidity.gap;
            knot.vertices = map.vertices().to_vec();
            self.plan.rigidity = self.plan.rigidity.worse(rigidity);
            self.plan.max_closure = self.plan.max_closure.max(knot.closure);
            self.plan.times.fold += start.elapsed();

            let start = Instant::now();
            let crossing = scene
                .as_mut()
                .and_then(|scene| scene.deepest_crossing(&map));
            self.plan.times.collision += start.elapsed();
            if let Some(crossing) = crossing {
                crossed = Some((index, crossing));
                break;
            }
        }
        if let Some((index, crossing)) = crossed {
            let start = Instant::now();
            let fraction = self.first_crossing(reduction, solver, &knots, index, &mut scene);
            self.plan.times.collision += start.elapsed();
            self.note_counts(scene.as_ref());
            self.plan.reached = fraction;
            let [a, b] = crossing.faces;
            let reason = format!(
                "faces {a} and {b} pass through each other beyond {:.2} % of the path (at knot \
                 {index}: {:.3} median edges deep)",
                100.0 * fraction,
                crossing.depth / self.pattern.median_edge()
            );
            knots.truncate(index);
            self.plan.path.knots = knots;
            return self.end(Outcome::Crossing(crossing), reason);
        }
        self.note_counts(scene.as_ref());
        self.plan.path.knots = knots;
        self.judge_rigidity(reduction)
    }

    fn note_counts(&mut self, scene: Option<&CollisionScene>) {
        self.plan.collision = scene.map(CollisionScene::counts).unwrap_or_default();
    }

    fn judge_rigidity(mut self, reduction: &Reduction) -> Plan {
        let start = Instant::now();
        if let Ok((part, creases)) = essential_pattern(self.pattern, &reduction.groups) {
            let tree = SpanningTree::from_central_face(&part);
            let mut map = FoldingMap::new(&part, &tree, &vec![0.0; creases.len()]);
            for knot in &self.plan.path.knots {
                let whole = reduction.groups.expand(&knot.angles);
                let angles: Vec<f64> = creases.iter().map(|crease| whole[crease.index()]).collect();
                map.fold(&part, &tree, &angles);
                let rigidity = map.rigidity(&part);
                self.plan.essential_rigidity = self.plan.essential_rigidity.worse(rigidity);
            }
            self.plan.essential_faces = part.faces().len();
        }
        self.plan.times.fold += start.elapsed();
        let bound = self.options.bound;
        let within = |r: Rigidity| r.deformation <= bound && r.gap <= bound;
        let (whole, essential) = (self.plan.rigidity, self.plan.essential_rigidity);
        if within(whole) {
            return self.plan;
        }
        let reason = format!(
            "the whole sheet deforms by {:.3e} with gaps of {:.3e}, over the bound {bound:.3e}; its \
             essential crease pattern by {:.3e} with gaps of {:.3e}",
            whole.deformation, whole.gap, essential.deformation, essential.gap
        );
        self.end(Outcome::NotRigidlyFoldable, reason)
    }

    /// Fraction of the path at which faces first cross, between the knot before `index` and this.
    fn first_crossing(
        &self,
        reduction: &Reduction,
        solver: &mut ClosureSolver<'_>,
        knots: &[Knot],
        index: usize,
        scene: &mut Option<CollisionScene>,
    ) -> f64 {
        let end = knots.last().map_or(0.0, |knot| knot.time);
        let (Some(before), Some(scene)) = (index.checked_sub(1), scene) else {
            return 0.0;
        };
        let (from, to) = (&knots[before], &knots[index]);
        let tree = SpanningTree::from_central_face(self.pattern);
        let (mut free, mut crossed) = (0.0, 1.0);
        // Thirty halvings of ten degrees: far below what the crossing tolerance resolves.
        for _ in 0..30 {
            let s = (free + crossed) / 2.0;
            let between = from.angles.iter().zip(&to.angles);
            let mut angles: Vec<f64> = between.map(|(a, b)| a + s * (b - a)).collect();
            if !solver.closes(&mut angles) {
                break;
            }
            let whole = reduction.groups.expand(&angles);
            let map = FoldingMap::new(self.pattern, &tree, &whole);
            if scene.deepest_crossing(&map).is_some() {
                crossed = s;
            } else {
                free = s;
            }
        }
        (from.time + free * (to.time - from.time)) / end
    }
}
