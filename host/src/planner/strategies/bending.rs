//! Panels that bend: problems in which each panel may turn a little about its diagonals.

use std::sync::Arc;

use fixedbitset::FixedBitSet;
use foldpath_core::GroupId;

use super::rows::Context;
use crate::certificate::range;
use crate::motion::Motion;
use crate::pattern::{CreaseId, CreasePattern, EdgeId, Letter};
use crate::planner::plan::{Attempt, Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::Note;
use crate::planner::{Goal, HingeLimit, PlanOptions};

/// Largest number of attempts in which the diagonals of panels are exchanged. Each costs as much as a plan.
const MAX_EXCHANGES: usize = 8;
/// Work of the solver after which no other diagonals are exchanged, over that of the plan before. Without the symmetry of the
/// sheet an attempt may cost ten times as much.
const MAX_EXCHANGE_WORK: u64 = 16;
/// Largest number of limits on the bend of panels that are tried after a plan is found.
const MAX_BEND_HALVINGS: usize = 12;
/// Largest bend that is tried to tell how far panels would have to bend, radians, and the number of smaller ones.
const HINTED_BEND_RAD: f64 = core::f64::consts::FRAC_PI_2;
const HINT_HALVINGS: usize = 3;
/// Fraction of the largest bend to which the least one is looked for, and below which a panel hardly bends.
const BEND_RATIO: f64 = 0.01;

/// Plans the motion in which panels bend least, and by no more than the options allow; or else the one that leads farthest.
pub(crate) fn bend_least(context: &Context<'_>, attempts: &mut Vec<Attempt>) -> Option<Plan> {
    let most = context.problem.options.bend;
    let efforts = [MAX_BEND_HALVINGS, MAX_EXCHANGES];
    with_least_bend(context, most, efforts, attempts)
}

/// Returns a note of the bend with which panels would fold to the goal, if one would be enough.
pub(crate) fn note_least_bend(context: &Context<'_>) -> Option<Note> {
    let quick = PlanningProblem {
        goes_straight: true,
        ..*context.problem
    };
    let context = Context {
        problem: &quick,
        ..*context
    };
    let efforts = [HINT_HALVINGS, 0];
    let bent = with_least_bend(&context, HINTED_BEND_RAD, efforts, &mut Vec::new())?;
    (bent.outcome == Outcome::Planned).then_some(Note::WouldBend(bent.max_bend))
}

/// Returns the plan found in which panels bend least, and by no more than `most` radians; if there is none, the motion found
/// that leads farthest. All panels are cut along the diagonals of their triangulation, then all along their others. Then up
/// to `halvings` smaller limits are tried for a plan, and diagonals are exchanged in up to `exchanges` attempts.
fn with_least_bend(
    context: &Context<'_>,
    most: f64,
    [halvings, exchanges]: [usize; 2],
    attempts: &mut Vec<Attempt>,
) -> Option<Plan> {
    let asked = context.problem;
    let none = FixedBitSet::with_capacity(asked.pattern.faces().len());
    let mut all = none.clone();
    all.extend(asked.pattern.quadrilaterals().map(|(face, _)| face));
    let mut best = BentPlan::cut(context, none, most, attempts);
    if !all.is_clear() {
        let limit = best.as_ref().map_or(most, |best| best.limit(most, 1.0));
        let other = BentPlan::cut(context, all, limit, attempts);
        let is_better = |other: &BentPlan| best.as_ref().is_none_or(|best| other.is_better(best));
        best = other.filter(is_better).or(best);
    }
    let mut best = best?;
    best.bend_less(context, halvings);
    if best.exchange(context, most, exchanges, attempts) {
        best.bend_less(context, halvings);
    }
    Some(best.plan)
}

fn is_planned(plan: &Plan) -> bool {
    plan.outcome == Outcome::Planned
}

/// A motion of a sheet whose panels bend.
struct BentPlan {
    sheet: BentSheet,
    plan: Plan,
}

impl BentPlan {
    /// Plans the sheet with the panels in `others` cut along their other diagonals, and bends limited to `most` radians.
    fn cut(
        context: &Context<'_>,
        others: FixedBitSet,
        most: f64,
        attempts: &mut Vec<Attempt>,
    ) -> Option<Self> {
        let asked = context.problem;
        let sheet = BentSheet::of(asked.pattern, asked.goal, asked.options, others)?;
        let plan = bent_by(context, &sheet, most, attempts)?;
        Some(Self { sheet, plan })
    }

    /// Returns the largest bend with which another plan may be better: `most`, or `part` of that of this one if it is planned.
    fn limit(&self, most: f64, part: f64) -> f64 {
        if is_planned(&self.plan) {
            part * self.plan.max_bend
        } else {
            most
        }
    }

    /// Returns `true` if this one is planned, within the [limit](Self::limit) that the other one set, or leads farther than the
    /// other one, which is not planned.
    fn is_better(&self, other: &Self) -> bool {
        is_planned(&self.plan) || !is_planned(&other.plan) && self.plan.reached > other.plan.reached
    }

    /// Tries smaller limits on the bend of a plan, up to `halvings`, between the largest with which no plan is found and the
    /// smallest with which one is.
    fn bend_less(&mut self, context: &Context<'_>, halvings: usize) {
        let mut too_small = 0.0;
        for _ in 0..halvings {
            let bend = self.plan.max_bend;
            let is_late = context.problem.is_late();
            if !is_planned(&self.plan) || is_late || bend - too_small < BEND_RATIO * bend {
                return;
            }
            let most = f64::midpoint(too_small, bend);
            match bent_by(context, &self.sheet, most, &mut Vec::new()).filter(is_planned) {
                Some(less) => self.plan = less,
                None => too_small = most,
            }
        }
    }

    /// Exchanges the diagonals of panels for their others, as long as that leads farther or to a plan with a smaller bend.
    ///
    /// Greedy: the panels that bend most come first, and after each gain they are ordered anew. Panels that bend alike all
    /// along the motion are exchanged at once, so that a sheet keeps its symmetry. Returns `true` if anything was gained.
    fn exchange(
        &mut self,
        context: &Context<'_>,
        most: f64,
        exchanges: usize,
        attempts: &mut Vec<Attempt>,
    ) -> bool {
        let start = self.sheet.others.clone();
        let mut tried = vec![start.clone()];
        let mut work = MAX_EXCHANGE_WORK * self.plan.effort.evaluations;
        let mut sets = self.sets_by_bend(context.problem.pattern).into_iter();
        while tried.len() <= exchanges && work > 0 && !context.problem.is_late() {
            let Some(set) = sets.next() else { break };
            let others = &self.sheet.others ^ &set;
            if tried.contains(&others) {
                continue;
            }
            tried.push(others.clone());
            let limit = self.limit(most, 1.0 - BEND_RATIO);
            let Some(exchanged) = Self::cut(context, others, limit, attempts) else {
                continue;
            };
            work = work.saturating_sub(exchanged.plan.effort.evaluations);
            if exchanged.is_better(self) {
                *self = exchanged;
                sets = self.sets_by_bend(context.problem.pattern).into_iter();
            }
        }
        self.sheet.others != start
    }

    /// Returns the sets of panels that bend alike and have another diagonal, those that bend most first. Panels that
    /// hardly bend are left out if faces cross: their diagonals are not the reason.
    fn sets_by_bend(&self, drawn: &CreasePattern) -> Vec<FixedBitSet> {
        let Some(motion) = &self.plan.motion else {
            return Vec::new();
        };
        let memberships = motion.memberships();
        let mut sets: Vec<(f64, GroupId, FixedBitSet)> = Vec::new();
        for (face, edge) in drawn.quadrilaterals() {
            let Some(crease) = self.sheet.pattern.edge(edge).crease else {
                continue;
            };
            let group = memberships[crease.index()].group;
            if let Some((.., set)) = sets.iter_mut().find(|(_, known, _)| *known == group) {
                set.insert(face);
                continue;
            }
            let mut set = FixedBitSet::with_capacity(drawn.faces().len());
            set.insert(face);
            sets.push((largest_bend(motion, edge), group, set));
        }
        if matches!(self.plan.outcome, Outcome::Crossing(_)) {
            sets.retain(|(bend, ..)| *bend > BEND_RATIO * self.plan.max_bend);
        }
        sets.sort_by(|a, b| b.0.total_cmp(&a.0));
        sets.into_iter().map(|(.., set)| set).collect()
    }
}

/// Plans a sheet whose panels bend by no more than `most` radians; `None` if no path is found.
fn bent_by(
    context: &Context<'_>,
    sheet: &BentSheet,
    most: f64,
    attempts: &mut Vec<Attempt>,
) -> Option<Plan> {
    let options = sheet.bending_by(most);
    let problem = PlanningProblem {
        pattern: &sheet.pattern,
        goal: &sheet.goal,
        options: &options,
        ..*context.problem
    };
    let mut plan = context.pass(&problem, attempts)?;
    plan.max_bend = sheet.largest_bend(plan.motion.as_ref()?);
    Some(plan)
}

/// A sheet whose panels are cut along diagonals, with the same goal and options for it.
struct BentSheet {
    /// The panels that are cut along the other diagonal than in their triangulation.
    others: FixedBitSet,
    pattern: Arc<CreasePattern>,
    goal: Goal,
    options: PlanOptions,
}

impl BentSheet {
    /// Cuts the panels of a sheet along diagonals. Returns `None` if no panel can bend, or the sheet is cut.
    fn of(
        pattern: &CreasePattern,
        goal: &Goal,
        options: &PlanOptions,
        others: FixedBitSet,
    ) -> Option<Self> {
        let bent = pattern.with_bends(&others)?;
        let limits = options.limits.iter().map(|limit| HingeLimit {
            crease: same(pattern, &bent, limit.crease),
            ..*limit
        });
        Some(Self {
            others,
            goal: goal_of(pattern, &bent, goal),
            options: PlanOptions {
                limits: limits.collect(),
                ..options.clone()
            },
            pattern: Arc::new(bent),
        })
    }

    /// Returns the options with the panels' bends limited to `most` radians.
    fn bending_by(&self, most: f64) -> PlanOptions {
        let mut options = self.options.clone();
        options
            .limits
            .extend(bends(&self.pattern).map(|crease| HingeLimit {
                crease,
                lower: -most,
                upper: most,
            }));
        options
    }

    /// Returns the largest bend of a panel over a motion of this sheet, radians.
    fn largest_bend(&self, motion: &Motion) -> f64 {
        let edges = bends(&self.pattern).map(|crease| self.pattern.creases()[crease.index()]);
        let most = edges.map(|edge| largest_bend(motion, edge));
        most.fold(0.0, f64::max)
    }
}

/// Returns the largest bend about an edge over a motion, radians.
fn largest_bend(motion: &Motion, edge: EdgeId) -> f64 {
    let segments = 0..motion.segments();
    let most = segments.map(|segment| {
        let [low, high] = range(&motion.curve(segment, edge));
        high.max(-low)
    });
    most.fold(0.0, f64::max)
}

/// Returns the creases about which panels bend.
fn bends(pattern: &CreasePattern) -> impl Iterator<Item = CreaseId> {
    let creases = pattern.creases().iter().enumerate();
    let bends = creases.filter(|(_, edge)| pattern.edge(**edge).letter == Letter::Bend);
    bends.map(|(crease, _)| CreaseId::new(crease))
}

/// Returns the crease of the bent sheet that lies on the same edge.
fn same(pattern: &CreasePattern, bent: &CreasePattern, crease: CreaseId) -> CreaseId {
    let edge = pattern.creases()[crease.index()];
    bent.edge(edge).crease.unwrap_or(crease)
}

/// Returns the goal for the bent sheet: bends are free.
fn goal_of(pattern: &CreasePattern, bent: &CreasePattern, goal: &Goal) -> Goal {
    let mut fold_angles = vec![None; bent.creases().len()];
    let mut signs = vec![0.0; fold_angles.len()];
    for (crease, angle) in goal.fold_angles.iter().enumerate() {
        let to = same(pattern, bent, CreaseId::new(crease)).index();
        (fold_angles[to], signs[to]) = (*angle, goal.signs[crease]);
    }
    Goal {
        fold_angles,
        signs,
        via: goal
            .via
            .iter()
            .map(|via| goal_of(pattern, bent, via))
            .collect(),
        guide: goal
            .guide
            .as_ref()
            .map(|guide| Box::new(goal_of(pattern, bent, guide))),
        ..goal.clone()
    }
}
