//! One attempt at a path: on given crease groups, from flat to the goal or as near as the motion leads.

use core::time::Duration;
use std::time::Instant;

use super::depart::departures;
use super::follow::{
    Followed, Homeward, Rules, Stop, Target, Waypoint, follow, largest, max_difference, max_norm,
    tangent_at_flat,
};
use super::goal::GoalKind;
use super::judge::Judge;
use super::knots::Knot;
use super::reduction::{CLOSED, ClosedGoal, Reduction, SAME};
use super::search::{polyline, search};
use super::solver::{ClosureSolver, Work};
use super::{Goal, Judged, PlanOptions, Search};
use crate::pattern::CreasePattern;

/// How an attempt ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// At the goal, or the nearest closed configuration to it.
    Reached,
    /// Short of it.
    Stopped(Stop),
    /// Without a goal: none of the phases, counted with the goal as the last, may be missing.
    NotClosed {
        /// The phase without a closed configuration.
        phase: usize,
        /// How far (radians) the nearest closed configuration found is, if any is.
        nearest: Option<f64>,
    },
}

/// How near a goal has to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// How far a crease may be from its goal angle, radians.
    pub(super) radians: f64,
    /// Whether what closes only as well as can be does not count.
    pub(super) exactly: bool,
}

/// A path in group angles, and how it ended.
pub(super) struct Attempt<'a> {
    pub(super) reduction: Reduction<'a>,
    /// From flat.
    pub(super) waypoints: Vec<Waypoint>,
    /// The closed configuration at the goal, if one is known.
    pub(super) goal: Option<Vec<f64>>,
    /// Closure residual that counts as closed although it can be made no smaller.
    pub(super) accepted: f64,
    pub(super) end: End,
    /// Whether the goal had to close exactly.
    pub(super) exactly: bool,
    /// How much of the goal's angles the last waypoint has, 0 to 1.
    pub(super) reached: f64,
    /// Time for closing the goal, and for the rest.
    pub(super) times: [Duration; 2],
    pub(super) notes: Vec<String>,
}

/// Radians: a hinge this near what is asked of it may be there.
const NEARLY: f64 = 1e-6;
/// Part of the largest angle asked for by which a goal may be moved at most.
const MOVED: f64 = 0.5;
/// Part of the largest angle asked for that the nearest closed configuration has to have.
const TURNED: f64 = 0.1;
/// Part of the residual that the bound allows, up to which configurations are closed where they alone are judged.
const ROUGH: f64 = 1e-2;
/// Iterations that close what is predicted along a motion; a handful suffice, unless nothing closes there.
const ITERATIONS: u32 = 25;
/// Closure residual that rounding may leave on a straight way.
const STRAIGHT: f64 = 1e-12;
/// Steps of it at least: any two configurations close.
const STEPS: f64 = 4.0;
/// Branches that are followed from flat.
const BRANCHES: usize = 4;
/// Starts again of the randomised search as a last resort.
const LAST_RESORT: usize = 3;
/// Unknowns beyond which samples are too costly and too rarely good for a last resort.
const LAST_RESORT_UNKNOWNS: usize = 200;
/// Starts again of the randomised search where it is asked for.
const RESTARTS: usize = 20;

/// What all steps of an attempt share.
struct Route<'a> {
    pattern: &'a CreasePattern,
    goal: &'a Goal,
    options: &'a PlanOptions,
    reduction: &'a Reduction<'a>,
    asked: Vec<Option<f64>>,
    signs: Vec<f64>,
    notes: Vec<String>,
    accepted: f64,
    /// Motions found that leave the flat sheet.
    branches: usize,
}

impl<'a> Attempt<'a> {
    /// Tries to find a path.
    pub(super) fn new(
        pattern: &CreasePattern,
        reduction: Reduction<'a>,
        goal: &Goal,
        reach: Reach,
        options: &PlanOptions,
        work: &mut Work,
    ) -> Self {
        let (asked, signs) = reduction.asked(goal);
        let mut route = Route {
            pattern,
            goal,
            options,
            reduction: &reduction,
            asked,
            signs,
            notes: Vec::new(),
            accepted: 0.0,
            branches: 0,
        };
        let start = Instant::now();
        let targets = route.targets(reach, work);
        let closing = start.elapsed();
        let start = Instant::now();
        let goals = route.goal.via.len() + 1;
        let known = targets
            .as_ref()
            .ok()
            .filter(|targets| targets.len() == goals);
        let closed = known.and_then(|targets| Some(targets.last()?.angles.clone()));
        let (waypoints, end) = match targets {
            Ok(targets) if options.search == Search::Random => {
                route.random(&targets, RESTARTS, work)
            }
            Ok(targets) => route.best(&targets, work),
            Err(end) => (Vec::new(), end),
        };
        let reached = match (end, waypoints.last()) {
            (End::Reached, _) => 1.0,
            (_, Some(last)) => route.part(&last.angles),
            (_, None) => 0.0,
        };
        if route.branches > 1 {
            route.notes.push(format!(
                "{} first steps found that leave the flat sheet with these signs; the path takes that which \
                 leads farthest",
                route.branches
            ));
        }
        let (notes, accepted) = (route.notes, route.accepted);
        Self {
            waypoints,
            goal: closed,
            accepted,
            end,
            exactly: reach.exactly,
            reached,
            times: [closing, start.elapsed()],
            notes,
            reduction,
        }
    }

    /// Where the path ends; nothing if there is none.
    pub(super) fn last(&self) -> &[f64] {
        self.waypoints.last().map_or(&[], |last| &last.angles)
    }

    /// Whether nothing better can be had.
    pub(super) fn is_complete(&self) -> bool {
        matches!(self.end, End::Reached | End::Stopped(Stop::Timeout))
    }

    /// Larger is better.
    pub(super) fn rank(&self) -> f64 {
        match self.end {
            End::Reached => 2.0,
            End::Stopped(_) => self.reached,
            End::NotClosed { .. } => -1.0,
        }
    }
}

impl<'a> Route<'a> {
    fn rules(&self) -> Rules<'_> {
        Rules {
            signs: &self.signs,
            max_step: self.options.max_step,
            tangents: self.options.judged == Judged::Motion,
            watch: self.reduction.watch,
        }
    }

    /// A solver of configurations that turn no hinge against its sign.
    fn solver(&self, accepted: f64) -> ClosureSolver<'a> {
        let mut solver = self.reduction.solver(self.options, accepted);
        solver.set_limits(self.reduction.orthant(&self.signs));
        let solver = solver.at_most(ITERATIONS);
        if self.options.judged == Judged::Motion {
            return solver;
        }
        // Where crossings are looked for along a lattice, faces have to be where it has them.
        let alone = self.reduction.groups.is_trivial();
        let rough = ROUGH * self.reduction.tolerance(self.options.bound);
        solver
            .with_rough_motions()
            .content_with(if alone { rough } else { 0.0 })
    }

    /// The closed configurations to pass through, the goal last; none for a goal that is not a
    /// configuration. `Err` says which does not close.
    fn targets(&mut self, reach: Reach, work: &mut Work) -> Result<Vec<ClosedGoal>, End> {
        let mut targets = Vec::new();
        let goals = self.goal.via.iter().chain([self.goal]);
        for (index, goal) in goals.enumerate() {
            let last = index == self.goal.via.len();
            if last && (goal.kind == GoalKind::Driven || !self.reduction.allows(goal)) {
                continue;
            }
            let closed = self.reduction.close_goal(goal, self.options, work);
            let near = |closed: &ClosedGoal| {
                closed.error <= reach.radians.min(goal.reach)
                    && !(reach.exactly && closed.accepted > 0.0)
                    // Groups that a goal which closes as it stands has only nearly are no groups.
                    && (reach.radians > SAME || self.reduction.closure(&closed.angles) <= CLOSED)
            };
            // The flat sheet, which always closes, is not what is asked for.
            let asked = largest(&goal.fold_angles);
            let turned = |closed: &ClosedGoal| {
                let moved = goal.kind == GoalKind::Letters || closed.error <= MOVED * asked;
                moved && max_norm(&closed.angles) >= TURNED * asked
            };
            let near = closed
                .as_ref()
                .is_some_and(|closed| near(closed) && turned(closed));
            match closed {
                Some(closed) if near => targets.push(closed),
                _ if goal.kind == GoalKind::Letters => {}
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

    /// The path through all targets, or as far as it goes.
    fn best(&mut self, targets: &[ClosedGoal], work: &mut Work) -> (Vec<Waypoint>, End) {
        let whole = targets.len() == self.goal.via.len() + 1;
        let mut waypoints: Vec<Waypoint> = Vec::new();
        for (index, target) in targets.iter().enumerate() {
            let followed = match waypoints.last() {
                None => self.reach_first(target, work),
                Some(last) => {
                    let from = last.angles.clone();
                    self.between(&from, target, work)
                }
            };
            append(&mut waypoints, followed.waypoints);
            if let Some(stop) = followed.stop {
                return (waypoints, End::Stopped(stop));
            }
            if let (Some(end), true) = (waypoints.last_mut(), index < self.goal.via.len()) {
                end.ends_phase = true;
            }
        }
        if whole {
            return (waypoints, End::Reached);
        }
        // The last goal is not a configuration: as near as the motion goes.
        let followed = match waypoints.last().cloned() {
            None => match self.guided(work) {
                Some(guided) => guided,
                None => self.forwards(None, work),
            },
            Some(last) => {
                let mut solver = self.solver(self.accepted);
                let target = Target::Nearest(&self.asked);
                let followed = follow(&mut solver, &last.angles, None, target, self.rules());
                *work += solver.work;
                followed
            }
        };
        append(&mut waypoints, followed.waypoints);
        let end = followed.stop.map_or(End::Reached, End::Stopped);
        (waypoints, end)
    }

    /// On the way to the guide's goal as far as what is asked for, if it is on that way.
    fn guided(&mut self, work: &mut Work) -> Option<Followed> {
        let guide = self.goal.guide.as_deref()?;
        let (asked, signs) = self.reduction.asked(guide);
        let mut route = Route {
            goal: guide,
            asked,
            signs,
            notes: Vec::new(),
            ..*self
        };
        let reach = Reach {
            radians: guide.reach,
            exactly: false,
        };
        let targets = route.targets(reach, work).ok()?;
        let (mut waypoints, _) = route.best(&targets, work);
        let accepted = route.accepted;
        let short = |w: &Waypoint| {
            let mut pairs = self.asked.iter().zip(&w.angles);
            pairs.any(|(asked, angle)| asked.is_some_and(|a| angle.abs() + NEARLY < a.abs()))
        };
        let beyond = waypoints.iter().position(|w| !short(w))?;
        let before = waypoints.get(beyond.checked_sub(1)?)?.clone();
        waypoints.truncate(beyond);
        self.accepted = accepted;
        let mut solver = self.solver(accepted);
        let target = Target::Nearest(&self.asked);
        let came = Some(before.tangent.as_slice());
        let last = follow(&mut solver, &before.angles, came, target, self.rules());
        *work += solver.work;
        append(&mut waypoints, last.waypoints);
        last.stop.is_none().then_some(Followed {
            waypoints,
            stop: None,
        })
    }

    /// From flat to the first target: followed from there, or else from flat, or else searched.
    fn reach_first(&mut self, target: &ClosedGoal, work: &mut Work) -> Followed {
        if let Some(straight) = self.straight_way(&vec![0.0; target.angles.len()], &target.angles) {
            return straight;
        }
        let backwards = self.backwards(target, work);
        if matches!(backwards.stop, None | Some(Stop::Timeout)) {
            return backwards;
        }
        // Where the goal closes exactly but the way from it does not, as happens with rounded
        // coordinates, the way from one that closes as well as can be.
        if target.accepted <= 0.0 && matches!(backwards.stop, Some(Stop::Closure | Stop::Singular))
        {
            let accepted = self.reduction.accepted(self.options);
            let goal = self.goal.via.first().unwrap_or(self.goal);
            let rough = self
                .reduction
                .close_goal_to(accepted, goal, self.options, work);
            let near = |rough: &ClosedGoal| {
                max_difference(&rough.angles, &target.angles) <= self.options.max_step
            };
            if let Some(rough) = rough.filter(near) {
                let followed = self.backwards(&rough, work);
                if followed.stop.is_none() {
                    return followed;
                }
            }
        }
        let forwards = self.forwards(Some(target), work);
        if matches!(forwards.stop, None | Some(Stop::Timeout)) {
            return forwards;
        }
        if self.asked.len() > LAST_RESORT_UNKNOWNS {
            return forwards;
        }
        let (waypoints, end) = self.random(core::slice::from_ref(target), LAST_RESORT, work);
        match end {
            End::Reached => {
                self.notes
                    .push("the path was found by the randomised search".into());
                Followed {
                    waypoints,
                    stop: None,
                }
            }
            _ => forwards,
        }
    }

    /// The straight way between two configurations, if the sheet closes all along: what turns does so about the same
    /// line, or on its own.
    fn straight_way(&self, from: &[f64], to: &[f64]) -> Option<Followed> {
        let far = max_difference(from, to);
        if far <= 0.0 {
            return None;
        }
        let steps = (far / self.options.max_step).ceil().max(STEPS);
        let parts = core::iter::successors(Some(0.0), |step| Some(step + 1.0));
        let parts = parts.take_while(|step| *step <= steps);
        let knots = parts.map(|step| {
            let pairs = from.iter().zip(to);
            let angles: Vec<f64> = pairs.map(|(a, b)| a + (b - a) * (step / steps)).collect();
            (self.reduction.closure(&angles) <= STRAIGHT).then_some(angles)
        });
        let knots: Vec<_> = knots.collect::<Option<_>>()?;
        Some(Followed {
            waypoints: polyline(&knots),
            stop: None,
        })
    }

    /// From the target to flat, turned round.
    fn backwards(&mut self, target: &ClosedGoal, work: &mut Work) -> Followed {
        let mut solver = self.solver(target.accepted);
        self.accepted = target.accepted;
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
        *work += solver.work;
        if followed.stop.is_some() {
            // What does not begin flat is no part of a path.
            followed.waypoints = vec![Waypoint::new(
                vec![0.0; target.angles.len()],
                vec![0.0; target.angles.len()],
            )];
        }
        followed.reversed()
    }

    /// Between two targets.
    fn between(&mut self, from: &[f64], to: &ClosedGoal, work: &mut Work) -> Followed {
        if let Some(straight) = self.straight_way(from, &to.angles) {
            return straight;
        }
        let accepted = self.accepted.max(to.accepted);
        let mut solver = self.solver(accepted);
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
        *work += solver.work;
        followed
    }

    /// From flat along the signs of the goal: exactly, or else, where only that leads all the way because
    /// coordinates are rounded, as closed as can be.
    fn forwards(&mut self, target: Option<&ClosedGoal>, work: &mut Work) -> Followed {
        let exact = self.forwards_to(target, 0.0, work);
        self.accepted = 0.0;
        if matches!(exact.stop, None | Some(Stop::Timeout)) {
            return exact;
        }
        let accepted = self.reduction.accepted(self.options);
        let rough = self.forwards_to(target, accepted, work);
        if rough.stop.is_none() {
            self.accepted = accepted;
            return rough;
        }
        exact
    }

    /// From flat on the branch that leads farthest.
    fn forwards_to(
        &mut self,
        target: Option<&ClosedGoal>,
        accepted: f64,
        work: &mut Work,
    ) -> Followed {
        let towards: Vec<f64> = match target {
            Some(closed) => closed.angles.clone(),
            None => self.guess(),
        };
        let flat = vec![0.0; towards.len()];
        let mut solver = self.solver(accepted);
        let at_flat = |tangent: Vec<f64>| Waypoint::new(flat.clone(), tangent);
        let mut best = Followed {
            waypoints: vec![at_flat(flat.clone())],
            stop: Some(Stop::Singular),
        };
        let mut best_part = 0.0;
        let branches = departures(
            self.reduction,
            &towards,
            &self.signs,
            accepted,
            self.options,
            work,
        );
        let near = |near: &&Vec<f64>| max_norm(near) <= self.options.max_step;
        for near in branches.iter().filter(near).take(BRANCHES) {
            let tangent = tangent_at_flat(&mut solver, near);
            let target = match target {
                Some(closed) => Target::Closed(&closed.angles),
                None => Target::Nearest(&self.asked),
            };
            let mut followed = follow(&mut solver, near, Some(&tangent), target, self.rules());
            followed.waypoints.insert(0, at_flat(tangent));
            if followed.stop.is_some() {
                // What leads on without coming nearer to the goal is not part of the way there.
                let parts = followed.waypoints.iter().map(|w| self.part(&w.angles));
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
            let part = last.map_or(0.0, |last| self.part(&last.angles));
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
        *work += solver.work;
        if branches.len() > 1 {
            self.branches = branches.len();
        }
        best
    }

    /// A direction from flat: what is asked for, and what is not as large, the way of its letter.
    fn guess(&self) -> Vec<f64> {
        let largest = largest(&self.asked);
        let pairs = self.asked.iter().zip(&self.signs);
        pairs
            .map(|(asked, sign)| asked.unwrap_or(sign * largest))
            .collect()
    }

    /// The randomised search for the last of the targets.
    fn random(
        &mut self,
        targets: &[ClosedGoal],
        restarts: usize,
        work: &mut Work,
    ) -> (Vec<Waypoint>, End) {
        let options = self.options;
        let exact = options.search != Search::Random;
        // As the report does, content with what the deformation bound allows.
        let tolerance = if exact {
            0.0
        } else {
            self.reduction.accepted(options)
        };
        let mut solver = self.solver(tolerance).content_with(tolerance);
        let mut judge = Judge::new(self.pattern, self.reduction, options.collision && !exact);
        let closed = targets.last().map(|closed| closed.angles.as_slice());
        let asked: Vec<Option<f64>> = match closed {
            Some(closed) => closed.iter().map(|&angle| Some(angle)).collect(),
            None => self.asked.clone(),
        };
        let feasible = &mut |angles: &[f64]| {
            let mut knot = Knot {
                angles: angles.to_vec(),
                ..Knot::default()
            };
            let crossing = judge.judge(&mut knot);
            crossing.is_none() && knot.deformation <= options.bound && knot.gap <= options.bound
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
        *work += solver.work;
        self.accepted = tolerance;
        let end = followed.stop.map_or(End::Reached, End::Stopped);
        (followed.waypoints, end)
    }

    /// How much of the goal's angles a configuration has, 0 to 1.
    fn part(&self, angles: &[f64]) -> f64 {
        let pairs = self.asked.iter().zip(angles);
        let (dot, square) = pairs.fold((0.0, 0.0), |(dot, square), (asked, angle)| {
            let asked = asked.unwrap_or(0.0);
            (dot + asked * angle, square + asked * asked)
        });
        if square > 0.0 {
            (dot / square).clamp(0.0, 1.0)
        } else {
            0.0
        }
    }
}

/// Straight from flat to the group angles `goal`, each configuration moved to where the residual is least
/// near by: what a sheet could do that may deform.
pub(super) fn straight(
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
        // The last is the goal itself.
        let moves = step < steps && solver.closes(&mut near);
        let same = moves
            && max_difference(&near, &exact) <= SHIFT * options.max_step
            && near.iter().zip(goal).all(|(near, goal)| near * goal >= 0.0);
        knots.push(if same { near } else { exact });
        step += 1.0;
    }
    polyline(&knots)
}

/// Part of a step that a configuration of the straight path may be moved.
const SHIFT: f64 = 0.25;

/// Appends what follows a corner, where the path rests.
fn append(waypoints: &mut Vec<Waypoint>, next: Vec<Waypoint>) {
    if let (Some(corner), Some(first)) = (waypoints.last_mut(), next.first()) {
        if max_difference(&corner.tangent, &first.tangent) > SMOOTH {
            corner.tangent.fill(0.0);
        }
        waypoints.extend(next.into_iter().skip(1));
    } else {
        *waypoints = next;
    }
}

/// Largest change of a unit tangent that is no corner.
const SMOOTH: f64 = 1e-6;
