//! Panels that bend: problems in which each panel may turn a little about its diagonals.

use std::sync::Arc;

use super::rows::Context;
use crate::certificate::range;
use crate::motion::Motion;
use crate::pattern::{CreaseId, CreasePattern, Diagonals, Letter};
use crate::planner::plan::{Attempt, Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::Note;
use crate::planner::{Goal, HingeLimit, PlanOptions};

/// Largest number of limits on the bend of panels that are tried after a plan is found.
const MAX_BEND_HALVINGS: usize = 12;
/// Largest bend that is tried to tell how far panels would have to bend, radians, and the number of smaller ones.
const HINTED_BEND_RAD: f64 = core::f64::consts::FRAC_PI_2;
const HINT_HALVINGS: usize = 3;
/// Fraction of the largest bend to which the least one is looked for.
const BEND_RATIO: f64 = 0.01;

/// Plans the motion in which panels bend least, and by no more than the options allow; or else the one that leads farthest.
pub(crate) fn bend_least(context: &Context<'_>, attempts: &mut Vec<Attempt>) -> Option<Plan> {
    let most = context.problem.options.bend;
    with_least_bend(context, most, MAX_BEND_HALVINGS, attempts)
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
    let bent = with_least_bend(&context, HINTED_BEND_RAD, HINT_HALVINGS, &mut Vec::new())?;
    (bent.outcome == Outcome::Planned).then_some(Note::WouldBend(bent.max_bend))
}

/// Returns the plan found in which panels bend least, and by no more than `most` radians; if there is none, the motion found
/// that leads farthest. Both diagonals of the panels are tried; then, for a plan, up to `halvings` smaller limits, between
/// the largest with which no plan is found and the smallest with which one is.
fn with_least_bend(
    context: &Context<'_>,
    most: f64,
    halvings: usize,
    attempts: &mut Vec<Attempt>,
) -> Option<Plan> {
    let asked = context.problem;
    let is_planned = |plan: &Plan| plan.outcome == Outcome::Planned;
    let mut best: Option<(BentSheet, Plan)> = None;
    for which in [Diagonals::Triangulation, Diagonals::Others] {
        let bent = BentSheet::of(asked.pattern, asked.goal, asked.options, which);
        let Some(sheet) = bent else { continue };
        let planned = best.as_ref().filter(|(_, plan)| is_planned(plan));
        let most = planned.map_or(most, |(_, plan)| plan.max_bend);
        let Some(plan) = bent_by(context, &sheet, most, attempts) else {
            continue;
        };
        let is_better = |(_, best): &(BentSheet, Plan)| {
            is_planned(&plan) || !is_planned(best) && plan.reached > best.reached
        };
        if best.as_ref().is_none_or(is_better) {
            best = Some((sheet, plan));
        }
    }
    let (sheet, mut plan) = best?;
    let mut too_small = 0.0;
    for _ in 0..halvings {
        let bend = plan.max_bend;
        if !is_planned(&plan) || asked.is_late() || bend - too_small < BEND_RATIO * bend {
            break;
        }
        let most = f64::midpoint(too_small, bend);
        match bent_by(context, &sheet, most, &mut Vec::new()).filter(is_planned) {
            Some(less) => plan = less,
            None => too_small = most,
        }
    }
    Some(plan)
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
        which: Diagonals,
    ) -> Option<Self> {
        let bent = pattern.with_bends(which)?;
        let limits = options.limits.iter().map(|limit| HingeLimit {
            crease: same(pattern, &bent, limit.crease),
            ..*limit
        });
        Some(Self {
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
        let curves = edges.flat_map(|edge| {
            let segments = 0..motion.segments();
            segments.map(move |segment| motion.curve(segment, edge))
        });
        let most = curves.map(|curve| {
            let [low, high] = range(&curve);
            high.max(-low)
        });
        most.fold(0.0, f64::max)
    }
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
