//! Plans from beginning to end: tries crease groups, lifts the best path to the whole sheet, and retries with looser
//! conditions.

use core::time::Duration;
use std::time::Instant;

use super::follow::{Stop, Waypoint};
use super::judge::Judge;
use super::knots::{Knot, Path};
use super::reduction::{CLOSED, EXPECTED, Reduction, SAME, WorstClosure, closure_of};
use super::reuse::{CERTIFIED, CandidatePath, FIRST_PART};
use super::route::{Attempt, End, Reach, straight};
use super::solver::Work;
use super::vectors::{largest, max_norm, way_to};
use super::{Goal, Judged, PlanOptions, Search, Symmetry};
use crate::collision::{Clearance, Crossing, SweepCounts};
use crate::folding::Rigidity;
use crate::pattern::{CreasePattern, EdgeId};
use crate::progress::{Progress, Stage, Watch};
use crate::symmetry::CreaseGroups;

/// Answer of the planner.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Outcome {
    /// The path reaches the goal, within the bound and free of crossings.
    #[default]
    Planned,
    /// The path ends between flat and goal.
    Partial,
    /// The sheet deforms beyond the bound although its essential pattern does not, or is not proved to keep the bound.
    NotRigidlyFoldable,
    /// No closed configuration was found near the goal.
    GoalNotClosed,
    /// Faces pass through each other.
    Crossing(Crossing),
    /// Out of time.
    Timeout,
}

impl Outcome {
    /// Returns the name of the outcome in files.
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
    /// Finding the spanning tree, crease groups and essential vertices, closing the goal under them, and the closure of
    /// the goal as asked.
    pub symmetry: Duration,
    /// Following the path in group angles.
    pub solve: Duration,
    /// Placing knots on the path and certifying the motion between them.
    pub place: Duration,
    /// Folding the whole sheet at every knot and measuring it.
    pub fold: Duration,
    /// Looking for crossings.
    pub collision: Duration,
}

/// A plan: the answer, the path as far as it leads, and measurements.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// The answer.
    pub outcome: Outcome,
    /// Reason why the outcome is not `Planned`, in words.
    pub reason: Option<String>,
    /// Fraction of the way to the goal that the sheet can go.
    pub reached: f64,
    /// The path, from flat; empty if none was found.
    pub path: Path,
    /// Number of crease groups.
    pub groups: usize,
    /// Number of essential vertices.
    pub essential_vertices: usize,
    /// Number of unknowns that the solver worked on.
    pub unknowns: usize,
    /// Number of closed configurations that the path was followed through, before knots were placed.
    pub waypoints: usize,
    /// Largest deformation and gap over all knots.
    pub rigidity: Rigidity,
    /// Largest deformation and gap of the essential crease pattern over all knots.
    pub essential_rigidity: Rigidity,
    /// Number of faces of the essential crease pattern.
    pub essential_faces: usize,
    /// Largest closure residual of a real vertex or a hole, or twist of a hinge, over all knots.
    pub max_closure: f64,
    /// Bound on the closure residual of every real vertex and hole over the whole motion; `None` if unknown.
    pub certified_closure: Option<f64>,
    /// Bound on deformation and gap of the whole sheet over the whole motion, rounding included.
    ///
    /// If closure alone would allow more than the option's bound, this is the bound on the folded sheet by
    /// [`FoldingCertifier`](crate::certificate::FoldingCertifier). Infinite if nothing is known, `None` if nothing was
    /// to be certified.
    pub certified_deformation: Option<f64>,
    /// Largest ratio of the errors of the whole sheet to the closure residuals of its vertices and holes; `None` if
    /// unknown.
    pub amplification: Option<f64>,
    /// Largest closure residual of a vertex with which the whole sheet keeps the bound.
    pub essential_tolerance: f64,
    /// Largest closure residual of the goal as asked.
    pub goal_closure: f64,
    /// Largest difference of a fold angle at the end of the path from the goal as asked, radians.
    pub goal_error: f64,
    /// Number of iterations of the solver.
    pub iterations: u64,
    /// Number of evaluations of the closure conditions by the solver.
    pub evaluations: u64,
    /// Number of pairs that the search for crossings looked at and skipped.
    pub collision: SweepCounts,
    /// Smallest distance of two faces that share no vertex, over the whole motion, if crossings were looked for and
    /// none was found.
    pub clearance: Option<Clearance>,
    /// Time spent.
    pub times: Times,
    /// Remarks for the user, in words.
    pub notes: Vec<String>,
}

/// Plans the path of `pattern` from flat to `goal`.
///
/// Always answers: a sheet that cannot be folded is an outcome, not an error.
#[must_use]
pub fn plan(pattern: &CreasePattern, goal: &Goal, options: &PlanOptions) -> Plan {
    plan_until_over(pattern, goal, options, Watch::default())
}

/// Plans as [`plan`] does, and reports to `progress`. A call that is cancelled answers [`Outcome::Timeout`], as does
/// one whose time is up.
#[must_use]
pub fn plan_watched(
    pattern: &CreasePattern,
    goal: &Goal,
    options: &PlanOptions,
    progress: &Progress,
) -> Plan {
    plan_until_over(pattern, goal, options, Watch::new(progress))
}

fn plan_until_over(
    pattern: &CreasePattern,
    goal: &Goal,
    options: &PlanOptions,
    watch: Watch<'_>,
) -> Plan {
    let deadline = options
        .timeout
        .and_then(|timeout| Instant::now().checked_add(timeout));
    let watch = watch.until(deadline);
    let alone = PlanOptions {
        symmetry: Symmetry::Off,
        ..options.clone()
    };
    let planning = Planning::new(pattern, goal, options, watch);
    let again = || Planning::new(pattern, goal, &alone, watch);
    let mut plan = planning.run();
    if plan.is_loose(pattern, options) {
        plan = tighter(plan, again().run());
    }
    for coarse in [false, true] {
        if !matches!(plan.outcome, Outcome::Planned | Outcome::Timeout) {
            plan = again().unrounded(plan, coarse);
        }
    }
    let open = matches!(
        plan.outcome,
        Outcome::GoalNotClosed | Outcome::Partial | Outcome::NotRigidlyFoldable
    );
    let motion = options.judged == Judged::Motion;
    if open && motion && nearly_closes(pattern, goal, options) {
        let again = || Planning {
            measured: true,
            ..again()
        };
        plan = again().measured(plan);
        if plan.outcome != Outcome::Planned {
            plan = again().unrounded(plan, false);
        }
        let closure = plan.certified_closure.unwrap_or(0.0);
        let most = closure * plan.amplification.unwrap_or(0.0);
        if plan.outcome == Outcome::Planned && most > options.bound {
            plan.notes.push(format!(
                "vertices fail to close by up to {closure:.1e}: at worst that adds up to more than the bound; what it does \
                 add up to is certified of the sheet folded from its middle and from its rim, doubled for other faces"
            ));
        }
    }
    plan
}

/// Returns `true` if a goal fails to close by no more than rounded coordinates may be off.
fn nearly_closes(pattern: &CreasePattern, goal: &Goal, options: &PlanOptions) -> bool {
    let off = closure_of(pattern, &goal.fold_angles);
    off.is_some_and(|off| off > CLOSED && off <= options.bound / EXPECTED)
}

/// Returns `tighter`, the plan without crease groups, if it proves less deformation, or else `plan`.
fn tighter(plan: Plan, mut tighter: Plan) -> Plan {
    if tighter.outcome != Outcome::Planned || tighter.proved() >= plan.proved() {
        return plan;
    }
    tighter.add_effort(&plan);
    tighter.notes.push(format!(
        "{} crease groups dropped: without them less deformation is proved",
        plan.groups
    ));
    tighter
}

impl Plan {
    /// Returns `true` if a plan without crease groups might prove less deformation: if this one proves more than the
    /// bound, or on a small sheet more than the planner aims for. With crease groups, vertices may close only to a
    /// local minimum of the residual.
    fn is_loose(&self, pattern: &CreasePattern, options: &PlanOptions) -> bool {
        let creases = pattern.creases().len();
        let aim = match self.outcome {
            Outcome::NotRigidlyFoldable if creases <= MANY_CREASES => options.bound,
            Outcome::Planned if creases <= FEW_CREASES => options.bound.min(CERTIFIED),
            _ => return false,
        };
        let held = self.rigidity.deformation.max(self.rigidity.gap) <= options.bound;
        let grouped = options.symmetry == Symmetry::Auto && self.groups < creases;
        let path = grouped && options.search == Search::Path;
        path && held && self.proved().is_some_and(|proved| proved > aim)
    }

    /// Adds the time and the work of another plan to those of this one.
    pub(super) fn add_effort(&mut self, other: &Self) {
        self.times = self.times.after(&other.times);
        self.iterations += other.iterations;
        self.evaluations += other.evaluations;
    }

    /// Returns the deformation that the sheet is proved to keep, infinite for none; `None` if nothing was to be proved.
    fn proved(&self) -> Option<f64> {
        self.certified_closure?;
        let certified = self.certified_deformation;
        Some(certified.filter(|c| !c.is_nan()).unwrap_or(f64::INFINITY))
    }
}

impl Times {
    /// Returns the sum of these times and of others.
    fn after(self, others: &Self) -> Self {
        Self {
            symmetry: self.symmetry + others.symmetry,
            solve: self.solve + others.solve,
            place: self.place + others.place,
            fold: self.fold + others.fold,
            collision: self.collision + others.collision,
        }
    }
}

/// One run of the planner, with the plan as far as it is made.
pub(super) struct Planning<'a> {
    pub(super) pattern: &'a CreasePattern,
    pub(super) goal: &'a Goal,
    pub(super) options: &'a PlanOptions,
    pub(super) watch: Watch<'a>,
    /// Closure residual of the goal as asked, with every crease on its own, if all creases have an angle and the
    /// residual was needed.
    pub(super) asked_closure: Option<f64>,
    /// Fraction of the bound for which the motion between knots is certified at first.
    pub(super) part: f64,
    /// `Some` if stars that nearly fold flat are taken to fold flat exactly. `Some(true)` allows for the largest
    /// rounding with which the goal closes, `Some(false)` for little more than the smallest.
    pub(super) unrounded: Option<bool>,
    /// `true` if the errors of vertices are not bounded in the worst case beforehand, but their sum is measured.
    pub(super) measured: bool,
    pub(super) plan: Plan,
}

impl<'a> Planning<'a> {
    pub(super) fn new(
        pattern: &'a CreasePattern,
        goal: &'a Goal,
        options: &'a PlanOptions,
        watch: Watch<'a>,
    ) -> Self {
        Self {
            pattern,
            goal,
            options,
            watch,
            asked_closure: None,
            part: FIRST_PART,
            unrounded: None,
            measured: false,
            plan: Plan::default(),
        }
    }

    pub(super) fn is_late(&self) -> bool {
        self.watch.is_over()
    }

    pub(super) fn run(self) -> Plan {
        if let Some(coarse) = self.unrounded {
            return self.run_unrounded(coarse).unwrap_or(Plan {
                outcome: Outcome::Partial,
                ..Plan::default()
            });
        }
        self.run_exactly()
    }

    fn run_exactly(mut self) -> Plan {
        let mut work = Work::default();
        let mut best: Option<Attempt> = None;
        let mut symmetric: Option<Reduction> = None;
        let start = Instant::now();
        self.watch.begin(Stage::Symmetry);
        let pattern = self.pattern;
        let symmetries = self.symmetries();
        if !symmetries.is_empty() {
            self.asked_closure = closure_of(pattern, &self.goal.fold_angles);
        }
        let exact = self.asked_closure.is_some_and(|closure| closure <= CLOSED);
        self.plan.times.symmetry += start.elapsed();
        // Symmetry is a shortcut: a path that is not found with it is looked for without it.
        let without = core::iter::once_with(|| (CreaseGroups::trivial(pattern), false));
        for (groups, exactly) in symmetries.into_iter().chain(without) {
            let start = Instant::now();
            self.watch.begin(Stage::Symmetry);
            // A goal far away is not what was asked for: with every crease free, one may be nearer. If the goal closes
            // as asked, with every crease on its own, a goal beside it is not what was asked for either.
            let radians = if exact && !groups.is_trivial() {
                SAME
            } else {
                self.goal.reach
            };
            let reach = Reach { radians, exactly };
            let options = self.options;
            let reduction = self.reduction(groups);
            self.plan.times.symmetry += start.elapsed();
            self.watch.begin(Stage::Following);
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

    /// Plans with stars that are taken to fold flat exactly if they nearly do, within what the bound allows. Returns
    /// that plan if it leads farther than `without`, or else `without`.
    ///
    /// At a vertex where two straight lines cross, one line can turn while the other is flat, and once the first is
    /// folded flat, the other can turn. If a line bends by the least amount at the vertex, neither can.
    fn unrounded(mut self, without: Plan, coarse: bool) -> Plan {
        self.unrounded = Some(coarse);
        let Some(mut plan) = self.run_unrounded(coarse) else {
            return without;
        };
        let short = matches!(without.outcome, Outcome::Partial | Outcome::GoalNotClosed);
        let farther = plan.outcome == Outcome::Partial && plan.reached > without.reached + FARTHER;
        if plan.outcome != Outcome::Planned && !(short && farther) {
            return without;
        }
        plan.add_effort(&without);
        plan
    }

    /// Plans with vertices that may fail to close by more than would add up to the bound in the worst case. Returns
    /// that plan if it keeps the bound, or else `without`.
    fn measured(self, without: Plan) -> Plan {
        let mut plan = self.run();
        if plan.outcome != Outcome::Planned {
            return without;
        }
        plan.add_effort(&without);
        plan
    }

    fn run_unrounded(mut self, coarse: bool) -> Option<Plan> {
        let mut work = Work::default();
        let start = Instant::now();
        let (pattern, goal, options) = (self.pattern, self.goal, self.options);
        let alone = CreaseGroups::trivial(pattern);
        let reduction = self.reduction(alone);
        let (reduction, turned) = reduction.unrounded(pattern, goal, options, coarse)?;
        let reach = Reach {
            radians: goal.reach,
            exactly: false,
        };
        self.plan.times.symmetry += start.elapsed();
        let mut attempt = Attempt::new(pattern, reduction, goal, reach, options, &mut work);
        self.plan.times.symmetry += attempt.times[0];
        self.plan.times.solve += attempt.times[1];
        self.plan.iterations = work.iterations;
        self.plan.evaluations = work.evaluations;
        let reduction = &attempt.reduction;
        let open = |waypoint: &Waypoint| reduction.closure_of_sheet(&waypoint.angles);
        let closes = |waypoint| open(waypoint) <= reduction.closure_tolerance(options);
        if attempt.waypoints.is_empty() || !attempt.waypoints.iter().all(closes) {
            return None;
        }
        attempt.notes.push(format!(
            "creases turned by up to {:.1e} degrees are folded as if the sheet folded flat exactly: its coordinates are \
             rounded",
            turned.to_degrees()
        ));
        Some(self.conclude(attempt, None))
    }

    /// Makes the unknowns and conditions for these groups.
    pub(super) fn reduction(&self, groups: CreaseGroups) -> Reduction<'a> {
        let reduction = Reduction::new(self.pattern, groups, self.options, self.watch);
        if self.measured {
            reduction.measured()
        } else {
            reduction
        }
    }

    /// Returns crease groups to try one after the other, each with `true` if the goal has to close exactly under them.
    /// Groups of a finer symmetry fold the sheet more exactly, if they fold it at all.
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
        found.retain(|(groups, _)| !groups.is_trivial());
        found
    }

    /// Stores the sizes and tolerances of the reduced problem in the plan.
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
        self.plan.essential_tolerance = reduction.closure_tolerance(self.options);
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
                let crossing = self.goal_crossing(&attempt);
                let outcome = crossing.map_or(Outcome::Partial, Outcome::Crossing);
                (Some(self.stopped(&attempt, stop)), outcome)
            }
            End::NotClosed { .. } => return self.not_closed(attempt, symmetric),
        };
        let found = CandidatePath {
            waypoints: &attempt.waypoints,
            closure_tolerance: attempt.closure_tolerance,
            reached: attempt.reached,
            retreats: self.plan.goal_closure > CLOSED && self.unrounded.is_none(),
            part: self.part,
            before: None,
        };
        let planning = Planning {
            plan: Plan::default(),
            ..self
        };
        let mut plan = self.judge(&attempt.reduction, &found);
        let crossed = matches!(plan.outcome, Outcome::Crossing(_));
        match plan.outcome {
            Outcome::Planned => (plan.outcome, plan.reason) = (outcome, reason),
            // The goal crosses, however much of the path is proved.
            Outcome::Partial if matches!(outcome, Outcome::Crossing(_)) => plan.outcome = outcome,
            _ => {}
        }
        let in_turn = crossed && outcome == Outcome::Planned || plan.outcome == Outcome::Partial;
        if in_turn && let Some(mut other) = planning.in_turn(&attempt) {
            other.add_effort(&plan);
            return other;
        }
        if crossed {
            return plan;
        }
        if let Outcome::Crossing(Crossing { faces: [a, b], .. }) = plan.outcome {
            let reason = plan.reason.unwrap_or_default();
            plan.reason = Some(format!(
                "at the goal faces {a} and {b} pass through each other; {reason}"
            ));
        }
        plan
    }

    /// Returns the crossing of faces at the goal itself, if there is one.
    fn goal_crossing(&self, attempt: &Attempt) -> Option<Crossing> {
        let mut goal = Knot {
            angles: attempt.goal.clone()?,
            ..Knot::default()
        };
        Judge::new(self.pattern, &attempt.reduction, self.options.collision).judge(&mut goal)
    }

    /// Adds a note about how far the goal was moved, if it was.
    fn moved_goal(&mut self, attempt: &Attempt) {
        let start = Instant::now();
        let closure = self.asked_closure.or_else(|| {
            let angles = attempt.reduction.groups.expand(attempt.last());
            let asked = self.goal.fold_angles.iter().zip(angles);
            // Free hinges take the angles at which the sheet closes.
            let angles: Vec<_> = asked.map(|(asked, free)| asked.or(Some(free))).collect();
            closure_of(self.pattern, &angles)
        });
        self.plan.goal_closure = closure.unwrap_or(0.0);
        self.plan.times.symmetry += start.elapsed();
        let moved = self.unrounded.is_none() || self.plan.goal_error > SAME;
        if self.plan.goal_closure > CLOSED && moved {
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
        let worst = attempt.reduction.worst(self.pattern, &asked);
        if let Some(worst) = worst.filter(|worst| worst.residual > CLOSED) {
            reason += &format!("; there {worst}");
        }
        self.end(Outcome::GoalNotClosed, reason)
    }

    pub(super) fn end(mut self, outcome: Outcome, reason: String) -> Plan {
        self.plan.outcome = outcome;
        self.plan.reason = Some(reason);
        self.plan
    }

    /// Returns the reason why the path ends before the goal, in words.
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
        // The vertex that stands in the way is the one that a small step straight to the goal would tear most.
        let asked = reduction.groups.reduce(&self.goal.fold_angles);
        let mut ahead = way_to(&asked, last);
        let far = max_norm(&ahead);
        for (step, at) in ahead.iter_mut().zip(last) {
            *step = at + *step * (PROBE / far.max(PROBE));
        }
        if stop != Stop::Timeout
            && let Some(worst) = reduction.worst(self.pattern, &ahead)
        {
            reason += &format!("; going on straight, {worst}");
        }
        reason
    }

    /// Returns the edges of the creases of a group.
    fn members(&self, reduction: &Reduction, group: usize) -> Vec<EdgeId> {
        let memberships = reduction.groups.memberships().iter();
        let pairs = memberships.zip(self.pattern.creases());
        let members = pairs.filter(|(membership, _)| membership.group.index() == group);
        members.map(|(_, &edge)| edge).collect()
    }

    /// Plans a path on which the sheet deforms within the bound, as it does not fold rigidly.
    ///
    /// The essential crease pattern is taken straight to the goal. If it keeps the bound, the path is lifted to the
    /// whole sheet: either the whole sheet keeps the bound too, or it is not rigidly foldable this way (Prop. 5.1 of
    /// the report). Returns `None` if the essential pattern already breaks the bound, or the goal does not have the
    /// symmetry of the crease groups.
    fn deforming(&self, reduction: &Reduction) -> Option<Plan> {
        let asked = reduction.groups.reduce(&self.goal.fold_angles);
        let goal: Vec<f64> = asked.into_iter().collect::<Option<_>>()?;
        let error = reduction.distance(&goal, self.goal);
        if reduction.groups.is_trivial()
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
        let found = CandidatePath {
            waypoints: &waypoints,
            closure_tolerance: self.options.bound,
            reached: 1.0,
            retreats: false,
            part: FIRST_PART,
            before: None,
        };
        Some(planning.judge(reduction, &found))
    }
}

/// Largest number of creases of a sheet that is planned once more without its crease groups to prove a smaller
/// deformation.
pub(super) const FEW_CREASES: usize = 200;
/// Largest number of creases of a sheet that is planned once more without its crease groups because it is not proved to
/// keep the bound.
const MANY_CREASES: usize = 2000;
/// Largest turn of a crease in the step that shows which vertex stands in the way, radians.
const PROBE: f64 = 0.1;
/// Largest difference between goal angles of one crease group that count as the same, radians.
const SAME_GOAL: f64 = 1e-2;
/// Fraction of the goal by which a path without symmetry has to lead farther to be preferred.
const FARTHER: f64 = 0.01;
/// Largest number of edges named in a reason.
const NAMED: usize = 12;

impl core::fmt::Display for WorstClosure {
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
