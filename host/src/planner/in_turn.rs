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
use crate::folding::SpanningTree;
use crate::pattern::FaceId;
use crate::symmetry::{CreaseGroups, ReducedStars};

/// Orders tried at most.
const TRIES: usize = 200;
/// Sets of folded parts looked at, at most.
const MOST_SETS: usize = 2000;
/// Steps of orders tried, at most.
const MOST_STEPS: usize = 100_000;
/// Configurations of the path at which it is found what moves what.
const LOOKS: usize = 16;

impl Planning<'_> {
    /// The plan that folds independent parts of the sheet one after the other, if that leads to where `attempt` does and
    /// no faces cross; with as few stops as it takes.
    ///
    /// Orders are found depth first. Where a part cannot be next as two faces cross, it is not tried again wherever the
    /// parts between these have been folded in the same order: they alone say where the two are, and which lies on
    /// which. Source, for parts that are put together: R. Wilson, J.-C. Latombe, "Geometric reasoning about mechanical
    /// assembly", 1994.
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
            tree: &reduction.tree,
            groups: &reduction.groups,
            goal: goal.into_iter().map(Some).collect(),
            seldom: (0..parts.len()).collect(),
            parts,
            free: HashMap::new(),
            dead: HashSet::new(),
            barred: Vec::new(),
            steps: 0,
        };
        if !orders.is_free(orders.all()) {
            return None;
        }
        let mut effort = Plan::default();
        for _ in 0..TRIES {
            let mut order = Vec::new();
            if self.is_late() || orders.extend(&mut order).is_err() {
                return None;
            }
            let stops: Vec<u64> = (1..order.len()).map(|k| set(&order[..k])).collect();
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
            let next = phases.count().min(stops.len());
            orders.bar(&order[..next], order[next], &plan.outcome);
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

/// The set of parts, as bits.
fn set(parts: &[usize]) -> u64 {
    parts.iter().fold(0, |set, part| set | 1 << part)
}

/// A part that cannot be next after others.
struct Barred {
    /// The parts that matter, a set.
    between: u64,
    /// Those of them that are folded, in their order.
    before: Vec<usize>,
    next: usize,
}

/// Orders in which parts can be folded. Sets of parts are bits.
struct Orders<'a> {
    judge: Judge<'a>,
    tree: &'a SpanningTree,
    /// Closure residual that counts as closed.
    accepted: f64,
    groups: &'a CreaseGroups,
    /// Fold angles of the creases with all parts folded, radians.
    goal: Vec<Option<f64>>,
    /// Creases of each part.
    parts: Vec<Vec<usize>>,
    /// Whether the sheet closes with these parts folded, and no faces cross.
    free: HashMap<u64, bool>,
    /// Sets from which nothing leads on, in whatever order they were folded.
    dead: HashSet<u64>,
    barred: Vec<Barred>,
    /// Parts, those that were seldom in the way first.
    seldom: Vec<usize>,
    /// Steps tried.
    steps: usize,
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

    /// Extends an order to all parts, if that can be; and whether it cannot in any order of the parts so far.
    fn extend(&mut self, order: &mut Vec<usize>) -> Result<(), bool> {
        let folded = set(order);
        if folded == self.all() {
            return Ok(());
        }
        self.steps += 1;
        if self.steps > MOST_STEPS {
            return Err(false);
        }
        let mut in_any_order = true;
        for part in self.seldom.clone() {
            let after = folded | 1 << part;
            if after == folded || self.dead.contains(&after) || !self.is_free(after) {
                continue;
            }
            let mut barred = self.barred.iter();
            if let Some(barred) = barred.find(|barred| barred.bars(order, part)) {
                in_any_order &= barred.before.len() < 2;
                continue;
            }
            order.push(part);
            match self.extend(order) {
                Ok(()) => return Ok(()),
                Err(whatever) => in_any_order &= whatever,
            }
            order.pop();
        }
        if in_any_order {
            self.dead.insert(folded);
        }
        Err(in_any_order)
    }

    /// Bars a part from being next after others, as it ended like this.
    fn bar(&mut self, order: &[usize], next: usize, outcome: &Outcome) {
        let between = match outcome {
            Outcome::Crossing(crossing) => self.between(crossing.faces),
            _ => self.all(),
        };
        let before = order
            .iter()
            .copied()
            .filter(|part| between >> part & 1 == 1);
        self.barred.push(Barred {
            between,
            before: before.collect(),
            next,
        });
        let barred = &self.barred;
        self.seldom.sort_by_cached_key(|part| {
            let in_the_way = barred.iter().filter(|barred| barred.before.contains(part));
            (in_the_way.count(), *part)
        });
    }

    /// The parts of which creases lie on the way from one face to another.
    fn between(&self, faces: [FaceId; 2]) -> u64 {
        let [a, b] = faces.map(|face| {
            let step = |face: FaceId| self.tree.steps().iter().find(|step| step.face == face);
            let way = core::iter::successors(step(face), |at| step(at.parent));
            way.filter_map(|step| step.crease).collect::<HashSet<_>>()
        });
        let creases = a.symmetric_difference(&b);
        let parts = creases.filter_map(|crease| {
            let holds = |part: &Vec<usize>| part.contains(&crease.index());
            self.parts.iter().position(holds)
        });
        set(&parts.collect::<Vec<_>>())
    }
}

impl Barred {
    fn bars(&self, order: &[usize], next: usize) -> bool {
        let before = order.iter().filter(|&part| self.between >> part & 1 == 1);
        self.next == next && before.eq(&self.before)
    }
}
