//! Planning from beginning to end.

use core::time::Duration;
use std::time::Instant;

use super::attempt::{Attempt, End, Reach, straight};
use super::course::Course;
use super::follow::{Stop, Waypoint, largest, max_norm, way_to};
use super::judge::Judge;
use super::knots::{Knot, Path};
use super::place::{Placed, Terms, place};
use super::reduction::{Blame, CLOSED, Reduction, SAME, closure_of};
use super::solver::{ClosureSolver, Work};
use super::{Goal, PlanOptions, Symmetry};
use crate::certificate::SheetCertifier;
use crate::collision::{CollisionCounts, Crossing};
use crate::folding::Rigidity;
use crate::pattern::{CreasePattern, EdgeId};
use crate::symmetry::CreaseGroups;

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
    /// Placing knots on it and certifying the motion between them.
    pub place: Duration,
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
    /// Closed configurations that the path was followed through, before knots were placed.
    pub waypoints: usize,
    /// Worst deformation and gap over all knots.
    pub rigidity: Rigidity,
    /// Worst deformation and gap of the essential crease pattern over all knots.
    pub essential_rigidity: Rigidity,
    /// Faces of the essential crease pattern.
    pub essential_faces: usize,
    /// Largest closure residual of a real vertex or a hole, or twist of a hinge, over all knots.
    pub max_closure: f64,
    /// Bound on the closure residual of every real vertex and hole over the whole motion.
    pub certified_closure: Option<f64>,
    /// Bound on deformation and gap of the whole sheet over the whole motion, rounding included.
    pub certified_deformation: Option<f64>,
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

    fn is_late(&self) -> bool {
        self.deadline
            .is_some_and(|deadline| Instant::now() >= deadline)
    }

    fn run(mut self) -> Plan {
        let mut work = Work::default();
        let mut best: Option<Attempt> = None;
        let mut symmetric: Option<Reduction> = None;
        let start = Instant::now();
        let pattern = self.pattern;
        let symmetries = self.symmetries();
        let exact = !symmetries.is_empty() && self.goal_is_exact();
        self.plan.times.symmetry += start.elapsed();
        // Symmetry is a shortcut: what it does not find is looked for without.
        let without = core::iter::once_with(|| (CreaseGroups::trivial(pattern), false));
        for (groups, exactly) in symmetries.into_iter().chain(without) {
            let start = Instant::now();
            // A goal far away is not what was asked for: with every crease free, one may be nearer. Nor is
            // one beside a goal that closes as it stands, all creases on their own.
            let shrinks = groups.len() < pattern.creases().len();
            let radians = if exact && shrinks {
                SAME
            } else {
                self.goal.reach
            };
            let reach = Reach { radians, exactly };
            let (options, deadline) = (self.options, self.deadline);
            let reduction = Reduction::new(self.pattern, groups, options, deadline);
            self.plan.times.symmetry += start.elapsed();
            let attempt = Attempt::new(
                self.pattern,
                reduction,
                self.goal,
                reach,
                options,
                &mut work,
            );
            self.plan.times.symmetry += attempt.times[0];
            self.plan.times.solve += attempt.times[1];
            let dropped = match best.take() {
                Some(before) if before.rank() + FARTHER >= attempt.rank() => {
                    best = Some(before);
                    None
                }
                before => {
                    best = Some(attempt);
                    before
                }
            };
            if let Some(dropped) = dropped.filter(|dropped| !dropped.exactly) {
                let why = match dropped.end {
                    End::NotClosed { .. } => "the goal does not close under them",
                    _ => "the sheet folds farther without them",
                };
                let groups = dropped.reduction.groups.len();
                let note = format!("{groups} crease groups dropped: {why}");
                self.plan.notes.push(note);
                symmetric = Some(dropped.reduction);
            }
            if best.as_ref().is_some_and(Attempt::is_complete) {
                break;
            }
        }
        self.plan.iterations = work.iterations;
        self.plan.evaluations = work.evaluations;
        match best {
            Some(best) => self.conclude(best, symmetric),
            None => self.plan,
        }
    }

    /// Crease groups to try one after the other, and whether the goal has to close exactly under them.
    /// Groups of a finer symmetry fold the sheet more exactly, if they do at all.
    fn symmetries(&self) -> Vec<(CreaseGroups, bool)> {
        let mut found = Vec::new();
        if self.options.symmetry == Symmetry::Auto {
            let groups = CreaseGroups::find(self.pattern);
            let fine = groups
                .is_rough()
                .then(|| CreaseGroups::find_exact(self.pattern));
            found.extend(fine.clone().map(|fine| (fine, true)));
            found.push((groups, false));
            found.extend(fine.map(|fine| (fine, false)));
        }
        found.retain(|(groups, _)| groups.len() < self.pattern.creases().len());
        found
    }

    /// Whether the goal closes as it stands, all creases on their own.
    fn goal_is_exact(&self) -> bool {
        let closure = closure_of(self.pattern, &self.goal.fold_angles);
        closure.is_some_and(|closure| closure <= CLOSED)
    }

    /// Notes what the path is made of.
    fn describe(&mut self, reduction: &Reduction) {
        let groups = &reduction.groups;
        if groups.is_rough() {
            self.plan.notes.push(format!(
                "{} crease groups: the sheet is symmetric only to {:.0e} of its median edge",
                groups.len(),
                groups.tolerance()
            ));
        }
        self.plan.amplification = reduction.amplification;
        self.plan.essential_tolerance = reduction.accepted(self.options);
        self.plan.groups = reduction.groups.len();
        self.plan.essential_vertices = reduction.essential.vertices().len();
        self.plan.unknowns = reduction.groups.len();
        self.plan.path.memberships = reduction.groups.memberships().to_vec();
    }

    fn conclude(mut self, mut attempt: Attempt, symmetric: Option<Reduction>) -> Plan {
        self.plan.notes.append(&mut attempt.notes);
        self.describe(&attempt.reduction);
        let Some(last) = attempt.waypoints.last() else {
            return self.not_closed(attempt, symmetric);
        };
        self.plan.goal_error = attempt.reduction.distance(&last.angles, self.goal);
        let (reason, outcome) = match attempt.end {
            End::Reached => {
                self.moved_goal(&attempt);
                (None, Outcome::Planned)
            }
            End::Stopped(Stop::Timeout) => {
                let reason = self.stopped(&attempt, Stop::Timeout);
                return self.end(Outcome::Timeout, reason);
            }
            End::Stopped(stop) => {
                let reduction = symmetric.as_ref().unwrap_or(&attempt.reduction);
                if let Some(plan) = self.deforming(reduction) {
                    return plan;
                }
                let reason = self.stopped(&attempt, stop);
                match self.goal_crossing(&attempt) {
                    Some(crossing) => {
                        let [a, b] = crossing.faces;
                        let reason = format!(
                            "at the goal faces {a} and {b} pass through each other; {reason}"
                        );
                        (Some(reason), Outcome::Crossing(crossing))
                    }
                    None => (Some(reason), Outcome::Partial),
                }
            }
            End::NotClosed { .. } => return self.not_closed(attempt, symmetric),
        };
        let mut plan = self.judge(
            &attempt.reduction,
            attempt.accepted,
            &attempt.waypoints,
            attempt.reached,
        );
        if plan.outcome == Outcome::Planned {
            (plan.outcome, plan.reason) = (outcome, reason);
        }
        plan
    }

    /// Faces that pass through each other at the goal itself.
    fn goal_crossing(&self, attempt: &Attempt) -> Option<Crossing> {
        let mut goal = Knot {
            angles: attempt.goal.clone()?,
            ..Knot::default()
        };
        Judge::new(self.pattern, &attempt.reduction, self.options.collision).judge(&mut goal)
    }

    /// Says how far the goal was moved, if it was.
    fn moved_goal(&mut self, attempt: &Attempt) {
        let start = Instant::now();
        let angles = attempt.reduction.groups.expand(attempt.last());
        let asked = self.goal.fold_angles.iter().zip(angles);
        // Free hinges as they close.
        let angles: Vec<_> = asked.map(|(asked, free)| asked.or(Some(free))).collect();
        self.plan.goal_closure = closure_of(self.pattern, &angles).unwrap_or(0.0);
        self.plan.times.symmetry += start.elapsed();
        if self.plan.goal_closure > CLOSED {
            self.plan.notes.push(format!(
                "not closed: {} (residual {:.1e}); moved to the nearest configuration found that is, \
                 {:.2e} degrees away",
                self.goal.source,
                self.plan.goal_closure,
                self.plan.goal_error.to_degrees()
            ));
        }
    }

    fn not_closed(mut self, attempt: Attempt, symmetric: Option<Reduction>) -> Plan {
        let reduction = symmetric.as_ref().unwrap_or(&attempt.reduction);
        if let Some(plan) = self.deforming(reduction) {
            return plan;
        }
        if self.is_late() {
            let reason = "out of time while closing the goal".into();
            return self.end(Outcome::Timeout, reason);
        }
        let End::NotClosed { phase, nearest } = attempt.end else {
            return self.plan;
        };
        self.plan.goal_error = nearest.unwrap_or_else(|| largest(&self.goal.fold_angles));
        let goal = self.goal.via.get(phase).unwrap_or(self.goal);
        let mut reason = format!("no closed configuration was found near {}", goal.source);
        if let Some(error) = nearest {
            let degrees = error.to_degrees();
            reason +=
                &format!(": the nearest found turns a crease {degrees:.1} degrees from its goal");
        }
        let asked = goal
            .fold_angles
            .iter()
            .map(|angle| Some(angle.unwrap_or(0.0)));
        let asked = attempt.reduction.groups.reduce(&asked.collect::<Vec<_>>());
        let asked: Vec<f64> = asked.into_iter().flatten().collect();
        let blame = attempt.reduction.worst(self.pattern, &asked);
        if let Some(blame) = blame.filter(|blame| blame.residual > CLOSED) {
            reason += &format!("; there {blame}");
        }
        self.end(Outcome::GoalNotClosed, reason)
    }

    fn end(mut self, outcome: Outcome, reason: String) -> Plan {
        self.plan.outcome = outcome;
        self.plan.reason = Some(reason);
        self.plan
    }

    /// Why the path ends where it does, in words.
    fn stopped(&self, attempt: &Attempt, stop: Stop) -> String {
        let reduction = &attempt.reduction;
        let last = attempt.last();
        let why = match stop {
            Stop::Singular if attempt.waypoints.len() < 2 => {
                "no motion leaves the flat sheet with these signs"
            }
            Stop::Singular => "no motion leads on (singular)",
            Stop::Closure => "no closed configuration follows (closure)",
            Stop::Nearest => "the motion leads no nearer to the goal (closure)",
            Stop::Limit(_) => "a hinge is at its limit",
            Stop::TooLong => "the motion goes on without coming nearer to the goal (closure)",
            Stop::Timeout => "out of time",
        };
        let mut reason = format!(
            "as far as {:.1} % of the goal's angles: {why}",
            100.0 * attempt.reached
        );
        if let Stop::Limit(unknown) = stop {
            let edges = self.members(reduction, unknown);
            return reason + ": " + &edge_list(&edges);
        }
        // What a small step straight to the goal would tear.
        let asked = reduction.groups.reduce(&self.goal.fold_angles);
        let mut ahead = way_to(&asked, last);
        let far = max_norm(&ahead);
        for (step, at) in ahead.iter_mut().zip(last) {
            *step = at + *step * (PROBE / far.max(PROBE));
        }
        if stop != Stop::Timeout
            && let Some(blame) = reduction.worst(self.pattern, &ahead)
        {
            reason += &format!("; going on straight, {blame}");
        }
        reason
    }

    /// Edges of the creases of a group.
    fn members(&self, reduction: &Reduction, group: usize) -> Vec<EdgeId> {
        let memberships = reduction.groups.memberships().iter();
        let pairs = memberships.zip(self.pattern.creases());
        let members = pairs.filter(|(membership, _)| membership.group.index() == group);
        members.map(|(_, &edge)| edge).collect()
    }

    /// Whether the sheet folds within the bound although not rigidly: the essential crease pattern is
    /// taken straight to the goal, and if that keeps the bound, the path is reused on the whole sheet.
    /// Holding there too, it is a plan; else the sheet is not rigidly foldable this way
    /// (Prop. 5.1 of the report). `None` if already the essential pattern breaks the bound, or the goal
    /// is not one of its crease groups.
    fn deforming(&self, reduction: &Reduction) -> Option<Plan> {
        let asked = reduction.groups.reduce(&self.goal.fold_angles);
        let goal: Vec<f64> = asked.into_iter().collect::<Option<_>>()?;
        let shrinks = reduction.groups.len() < self.pattern.creases().len();
        let error = reduction.distance(&goal, self.goal);
        if !shrinks
            || error > SAME_GOAL
            || !self.goal.via.is_empty()
            || !reduction.allows(self.goal)
        {
            return None;
        }
        let waypoints = straight(reduction, &goal, self.options);
        let mut judge = Judge::new(self.pattern, reduction, false);
        let (essential, _) = judge.essential(waypoints.iter().map(|w| w.angles.as_slice()));
        if !(essential.deformation <= self.options.bound && essential.gap <= self.options.bound) {
            return None;
        }
        let mut planning = Planning {
            plan: self.plan.clone(),
            ..*self
        };
        planning.describe(reduction);
        planning.plan.goal_error = error;
        planning.plan.notes.push(
            "no exact motion leads to the goal; the sheet is taken there straight, deforming"
                .into(),
        );
        // Whether faces of a torn sheet cross means nothing.
        let blind = PlanOptions {
            collision: false,
            ..self.options.clone()
        };
        let torn = Planning {
            options: &blind,
            plan: planning.plan.clone(),
            ..*self
        };
        let accepted = self.options.bound;
        let plan = torn.judge(reduction, accepted, &waypoints, 1.0);
        if plan.outcome != Outcome::Planned || !self.options.collision {
            return Some(plan);
        }
        Some(planning.judge(reduction, accepted, &waypoints, 1.0))
    }

    /// Places knots on the course through the waypoints, and certifies the motion between them.
    fn place(
        &mut self,
        reduction: &Reduction,
        accepted: f64,
        waypoints: &[Waypoint],
    ) -> Option<Placed> {
        let start = Instant::now();
        let (_, signs) = reduction.asked(self.goal);
        let limits = reduction.orthant(&signs);
        let mut solver = reduction.solver(self.options, accepted);
        solver.set_limits(limits.clone());
        let exact = waypoints
            .iter()
            .all(|waypoint| reduction.essential_closure(&waypoint.angles) <= CLOSED);
        let terms = Terms {
            stars: &reduction.essential,
            closure: exact.then(|| reduction.accepted(self.options)),
            limits: &limits,
            speed: self.options.max_speed,
            acceleration: self.options.max_acceleration.unwrap_or(f64::INFINITY),
            most: self.options.max_knots.unwrap_or(MOST_KNOTS),
        };
        let course = Course::new(waypoints);
        let placed = place(&course, &terms, &mut solver, self.options);
        self.plan.times.place += start.elapsed();
        placed
    }

    /// Reuses the path, which reaches that part of the goal, on the whole sheet: judges it at every knot
    /// and between them.
    fn judge(
        mut self,
        reduction: &Reduction,
        accepted: f64,
        waypoints: &[Waypoint],
        reached: f64,
    ) -> Plan {
        self.plan.reached = reached;
        self.plan.waypoints = waypoints.len();
        let Some(placed) = self.place(reduction, accepted, waypoints) else {
            self.plan.reached = 0.0;
            return self.unplaced();
        };
        self.plan.path.interpolation = placed.interpolation;
        self.certify(reduction, &placed);
        let mut knots = placed.knots;
        let mut judge = Judge::new(self.pattern, reduction, self.options.collision);
        judge.keep_vertices = self.options.keep_vertices;
        let mut crossed = None;
        for (index, knot) in knots.iter_mut().enumerate() {
            if self.is_late() {
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
            let mut solver = reduction.solver(self.options, accepted);
            if let Some(reason) =
                self.stop_before(&mut judge, &mut solver, &mut knots, &refused, crossing)
            {
                self.note(&judge, knots);
                return self.end(Outcome::Crossing(crossing), reason);
            }
        }
        (self.plan.essential_rigidity, self.plan.essential_faces) =
            judge.essential(knots.iter().map(|knot| knot.angles.as_slice()));
        self.note(&judge, knots);
        self.judge_rigidity()
    }

    /// Takes the bounds on closure to bounds on the whole sheet.
    fn certify(&mut self, reduction: &Reduction, placed: &Placed) {
        let start = Instant::now();
        let closure = placed.closure();
        self.plan.certified_closure = Some(closure.worst());
        let sheet = SheetCertifier::new(self.pattern, &reduction.tree, &reduction.all);
        self.plan.certified_deformation = sheet.map(|mut sheet| {
            let bounds = sheet.rigidity(&closure);
            bounds.deformation.max(bounds.gap)
        });
        self.plan.times.place += start.elapsed();
    }

    /// No knots could be placed.
    fn unplaced(self) -> Plan {
        if self.is_late() {
            return self.end(Outcome::Timeout, "out of time while placing knots".into());
        }
        let most = self.options.max_knots.unwrap_or(MOST_KNOTS);
        let reason = format!("the bound needs more than {most} knots with this interpolation");
        self.end(Outcome::Partial, reason)
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
        let whole = self.plan.reached;
        self.plan.reached *= if goal.time > 0.0 {
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
        self.plan.reached = whole;
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

    fn judge_rigidity(mut self) -> Plan {
        let bound = self.options.bound;
        let (whole, essential) = (self.plan.rigidity, self.plan.essential_rigidity);
        let within = [whole.deformation, whole.gap, self.plan.max_closure];
        if within.iter().all(|value| *value <= bound) {
            return self.plan;
        }
        let knots = &self.plan.path.knots;
        let torn = |knot: &Knot| {
            let within = [knot.deformation, knot.gap, knot.closure];
            !within.iter().all(|value| *value <= bound)
        };
        let good = knots.iter().take_while(|knot| !torn(knot)).last();
        if let (Some(good), Some(last)) = (good, knots.last()) {
            self.plan.reached *= if last.time > 0.0 {
                good.time / last.time
            } else {
                0.0
            };
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

/// Knots of a path at most.
const MOST_KNOTS: usize = 20_000;
/// Radians by which a path may stop short of an inexact goal so that nothing crosses.
const RETREAT: f64 = 0.02;
/// Radians: a step that shows which vertex stands in the way.
const PROBE: f64 = 0.1;
/// Radians: goal angles of one crease group are the same.
const SAME_GOAL: f64 = 1e-2;
/// Part of the goal that a path without symmetry has to come nearer to be preferred.
const FARTHER: f64 = 0.01;
/// Edges named at most.
const NAMED: usize = 12;

impl core::fmt::Display for Blame {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let edges = edge_list(&self.edges);
        write!(
            f,
            "{} (creases: {edges}) does not close: residual {:.1e}",
            self.place, self.residual
        )
    }
}

fn edge_list(edges: &[EdgeId]) -> String {
    let names = edges
        .iter()
        .take(NAMED)
        .map(|edge| edge.index().to_string());
    let names = names.collect::<Vec<_>>().join(", ");
    let more = edges.len().saturating_sub(NAMED);
    let more = if more > 0 {
        format!(" and {more} more")
    } else {
        String::new()
    };
    format!("edges {names}{more}")
}
