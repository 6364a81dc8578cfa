//! One part of the sheet after the other, where faces cross if all fold at once: the flaps of a letter, the lines of a
//! map.

use std::collections::{HashMap, HashSet};

use super::attempt::Attempt;
use super::judge::Judge;
use super::knots::Knot;
use super::mobility::independent_parts;
use super::plan::{FEW_CREASES, Outcome, Plan, Planning};
use super::reduction::{CLOSED, Reduction};
use super::{Goal, GoalKind, Search};
use crate::symmetry::{CreaseGroups, ReducedStars};

/// Orders tried at most.
const TRIES: usize = 100;
/// Sets of folded parts looked at, at most.
const MOST_SETS: usize = 2000;
/// Configurations of the path at which it is found what moves what.
const LOOKS: usize = 16;

impl Planning<'_> {
    /// The plan that folds independent parts of the sheet one after the other, if that leads to where `attempt` does and
    /// no faces cross; with as few stops as it takes.
    ///
    /// Orders are found depth first over sets of folded parts; a part that crosses others after some of them is not
    /// tried after these again. Source, for parts that are put together: R. Wilson, J.-C. Latombe, "Geometric reasoning
    /// about mechanical assembly", 1994.
    pub(super) fn in_turn(&self, attempt: &Attempt) -> Option<Plan> {
        let (pattern, options) = (self.pattern, self.options);
        let fits = self.goal.via.is_empty()
            && self.goal.kind != GoalKind::Driven
            && options.search == Search::Path
            && pattern.creases().len() <= FEW_CREASES;
        if !fits {
            return None;
        }
        let goal = attempt.reduction.groups.expand(attempt.last());
        let parts = self.parts(attempt, &goal)?;
        let groups = CreaseGroups::trivial(pattern);
        let reduction = Reduction::new(pattern, groups, options, self.deadline);
        let mut orders = Orders {
            judge: Judge::new(pattern, &reduction, true),
            accepted: reduction.accepted(options),
            groups: &reduction.groups,
            goal: goal.into_iter().map(Some).collect(),
            parts,
            free: HashMap::new(),
            dead: HashSet::new(),
            barred: HashSet::new(),
        };
        if !orders.is_free(orders.all()) {
            return None;
        }
        let mut effort = Plan::default();
        for _ in 0..TRIES {
            let mut order = Vec::new();
            if self.is_late() || !orders.extend(0, &mut order) {
                return None;
            }
            let stops: Vec<u64> = order.iter().skip(1).map(|&(folded, _)| folded).collect();
            let plan = self.by_way_of(&orders, &stops);
            if plan.outcome == Outcome::Planned {
                let (mut plan, phases) = self.with_fewer_stops(&orders, plan, stops);
                plan.add_effort(&effort);
                plan.notes.push(format!(
                    "folded in {phases} phases, as faces cross if all creases turn at once"
                ));
                return Some(plan);
            }
            let phases = plan.path.knots.iter().filter(|knot| knot.ends_phase);
            orders.barred.insert(order[phases.count().min(stops.len())]);
            effort.add_effort(&plan);
        }
        None
    }

    /// The plan without the stops that it can do without, runs of them first, and its phases; but not without any.
    fn with_fewer_stops(
        &self,
        orders: &Orders<'_>,
        mut plan: Plan,
        mut stops: Vec<u64>,
    ) -> (Plan, usize) {
        let mut effort = Plan::default();
        let mut run = stops.len() / 2;
        while run > 0 {
            let mut from = 0;
            while from < stops.len() && stops.len() > run {
                let mut fewer = stops.clone();
                fewer.drain(from..stops.len().min(from + run));
                let mut other = self.by_way_of(orders, &fewer);
                if other.outcome == Outcome::Planned {
                    core::mem::swap(&mut plan, &mut other);
                    stops = fewer;
                } else {
                    from += run;
                }
                effort.add_effort(&other);
            }
            run /= 2;
        }
        plan.add_effort(&effort);
        (plan, stops.len() + 1)
    }

    /// The plan by way of these sets of folded parts.
    fn by_way_of(&self, orders: &Orders<'_>, stops: &[u64]) -> Plan {
        let via = stops.iter().map(|&folded| {
            let angles = orders.angles(folded);
            Goal::chosen(self.pattern, angles, "a part of the goal".into())
        });
        let goal = Goal {
            via: via.collect(),
            ..self.goal.clone()
        };
        let planning = Planning {
            deadline: self.deadline,
            ..Planning::new(self.pattern, &goal, self.options)
        };
        planning.run()
    }

    /// Creases that move each other on the way of `attempt`, in sets that do not; `None` if there is one.
    fn parts(&self, attempt: &Attempt, goal: &[f64]) -> Option<Vec<Vec<usize>>> {
        let groups = &attempt.reduction.groups;
        let waypoints = &attempt.waypoints;
        // Where the sheet is flat it is singular, and often so at the goal.
        let inner = waypoints.get(1..waypoints.len().checked_sub(1)?)?;
        let step = inner.len().div_ceil(LOOKS).max(1);
        let looks = inner.iter().step_by(step);
        let mut looks: Vec<_> = looks.map(|w| groups.expand(&w.angles)).collect();
        if looks.is_empty() {
            looks.push(goal.iter().map(|angle| angle / 2.0).collect());
        }
        let mut parts = independent_parts(&ReducedStars::of_creases(self.pattern), &looks)?;
        parts.retain(|part| part.iter().any(|&crease| goal[crease].abs() > CLOSED));
        (2..=64).contains(&parts.len()).then_some(parts)
    }
}

/// Orders in which parts can be folded. Sets of parts are bits.
struct Orders<'a> {
    judge: Judge<'a>,
    /// Closure residual that counts as closed.
    accepted: f64,
    groups: &'a CreaseGroups,
    /// Fold angles of the creases with all parts folded, radians.
    goal: Vec<Option<f64>>,
    /// Creases of each part.
    parts: Vec<Vec<usize>>,
    /// Whether the sheet closes with these parts folded, and no faces cross.
    free: HashMap<u64, bool>,
    /// From where no order leads on.
    dead: HashSet<u64>,
    /// Folded parts and one that cannot be next.
    barred: HashSet<(u64, usize)>,
}

impl Orders<'_> {
    /// All parts.
    fn all(&self) -> u64 {
        u64::MAX >> (64 - self.parts.len())
    }

    /// Fold angles of the creases with these parts folded and the others flat.
    fn angles(&self, folded: u64) -> Vec<Option<f64>> {
        let mut angles = self.goal.clone();
        let flat = (0..self.parts.len()).filter(|part| folded >> part & 1 == 0);
        for &crease in flat.flat_map(|part| &self.parts[part]) {
            angles[crease] = Some(0.0);
        }
        angles
    }

    fn is_free(&mut self, folded: u64) -> bool {
        if let Some(&free) = self.free.get(&folded) {
            return free;
        }
        let angles = self.groups.reduce(&self.angles(folded));
        let mut knot = Knot {
            angles: angles.into_iter().flatten().collect(),
            ..Knot::default()
        };
        let free = self.free.len() < MOST_SETS
            && self.judge.judge(&mut knot).is_none()
            && knot.closure <= self.accepted;
        self.free.insert(folded, free);
        free
    }

    /// Extends an order, a set of folded parts and the next one at each place, to all parts, if that can be.
    fn extend(&mut self, folded: u64, order: &mut Vec<(u64, usize)>) -> bool {
        if folded == self.all() {
            return true;
        }
        for part in 0..self.parts.len() {
            let after = folded | 1 << part;
            if after == folded
                || self.barred.contains(&(folded, part))
                || self.dead.contains(&after)
                || !self.is_free(after)
            {
                continue;
            }
            order.push((folded, part));
            if self.extend(after, order) {
                return true;
            }
            order.pop();
        }
        self.dead.insert(folded);
        false
    }
}
