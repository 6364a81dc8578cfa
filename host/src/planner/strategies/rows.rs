//! A row of the table of strategies, and how rows are tried.

use super::pipeline::follow;
use crate::planner::foldability::stacking::note_no_layer_order;
use crate::planner::following::route::Route;
use crate::planner::following::route_selection::select_route;
use crate::planner::lifting::swept_motion::FIRST_BOUND_FRACTION;
use crate::planner::plan::{Attempt, Outcome, Plan, Strategy};
use crate::planner::problem::{ErrorModel, PlanningProblem};
use crate::planner::reason::Note;
use crate::planner::{PlanOptions, Symmetry};
use crate::util::clock::Instant;

/// A row of the table of strategies.
pub(crate) struct Row {
    pub(crate) strategy: Strategy,
    pub(crate) starts_from: StartsFrom,
    /// Tells whether the strategy is tried.
    pub(crate) is_tried: fn(&Context<'_>) -> bool,
    /// Runs the strategy, and lists its attempts. Returns `None` if the strategy does not apply, or finds nothing.
    pub(crate) run: fn(&Context<'_>, &mut Vec<Attempt>) -> Option<Plan>,
    /// Tells whether a plan takes the place of the best so far.
    pub(crate) is_better: fn(&Plan, &Plan) -> bool,
    /// Returns a note for a plan that takes the place of the best so far.
    pub(crate) note: fn(&Context<'_>, &Plan) -> Option<Note>,
    pub(crate) errors: ErrorModel,
    /// Use of crease groups; `None` for that of the options.
    pub(crate) symmetry: Option<Symmetry>,
    /// `true` if the closed configuration nearest to the goal will do.
    pub(crate) goes_near: bool,
    /// Seed of random numbers; `None` for that of the options.
    pub(crate) seed: Option<u64>,
}

/// Value from which a strategy starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StartsFrom {
    /// The problem, of which a route is looked for.
    Problem,
    /// A route that ends before the goal, which is not followed then if the strategy applies.
    Route,
    /// The answer along a route on which something is in the way.
    Answer,
}

/// Input of a row.
#[derive(Clone, Copy)]
pub(crate) struct Context<'a> {
    pub(crate) table: &'static [Row],
    pub(crate) row: &'static Row,
    pub(crate) problem: &'a PlanningProblem<'a>,
    /// The best answer so far.
    pub(crate) best: &'a Plan,
    /// The route of the problem, for a row that starts from it.
    pub(crate) route: Option<&'a Route<'a>>,
}

/// Tries the rows that start from something in their order, and returns the best answer.
pub(crate) fn try_rows(
    starts_from: StartsFrom,
    context: &Context<'_>,
    mut best: Plan,
    attempts: &mut Vec<Attempt>,
) -> Plan {
    let rows = context.table.iter();
    for row in rows.filter(|row| row.starts_from == starts_from) {
        let context = Context {
            row,
            best: &best,
            ..*context
        };
        if !(row.is_tried)(&context) {
            continue;
        }
        let Some(mut found) = (row.run)(&context, attempts) else {
            continue;
        };
        if (row.is_better)(&found, &best) {
            found.effort += best.effort;
            found.notes.extend((row.note)(&context, &found));
            best = found;
        }
    }
    best
}

impl Context<'_> {
    /// Returns `true` if the answer so far is no, and not for want of time.
    pub(crate) fn is_unplanned(&self) -> bool {
        is_no(self.best.outcome)
    }

    /// Plans with the error model, the crease groups and the seed of the row.
    pub(crate) fn pass_as_set(&self, attempts: &mut Vec<Attempt>) -> Option<Plan> {
        let (row, options) = (self.row, self.problem.options);
        let options = PlanOptions {
            symmetry: row.symmetry.unwrap_or(options.symmetry),
            seed: row.seed.unwrap_or(options.seed),
            ..options.clone()
        };
        let problem = PlanningProblem {
            options: &options,
            errors: row.errors,
            goes_near: row.goes_near,
            ..*self.problem
        };
        self.pass(&problem, attempts)
    }

    /// Finds a route of a problem and follows it, or tries the rows that start from the route or from the answer along it.
    /// Returns `None` if the error model changes nothing of this sheet, or allows no path.
    pub(crate) fn pass(
        &self,
        problem: &PlanningProblem<'_>,
        attempts: &mut Vec<Attempt>,
    ) -> Option<Plan> {
        let start = Instant::now();
        let route = select_route(problem)?;
        let on_route = Context {
            problem,
            route: Some(&route),
            ..*self
        };
        let rows = self.table.iter();
        let mut rows = rows.filter(|row| row.starts_from == StartsFrom::Route);
        let applied = rows.find_map(|row| {
            let plan = (row.is_tried)(&on_route).then(|| (row.run)(&on_route, attempts));
            Some((row.strategy, plan.flatten()?))
        });
        if let Some((strategy, plan)) = applied {
            attempts.push(Attempt::new(strategy, &plan, start));
            return Some(plan);
        }
        let (mut plan, is_obstructed) = follow(problem, &route, FIRST_BOUND_FRACTION);
        let goes_on = is_obstructed && !problem.goes_straight;
        if goes_on {
            plan.notes.extend(note_no_layer_order(problem));
        }
        attempts.push(Attempt::new(self.row.strategy, &plan, start));
        if !goes_on || plan.has_no_layer_order() {
            return Some(plan);
        }
        Some(try_rows(StartsFrom::Answer, &on_route, plan, attempts))
    }
}

/// Returns `true` if an answer is no, and not for want of time.
pub(crate) fn is_no(outcome: Outcome) -> bool {
    !matches!(outcome, Outcome::Planned | Outcome::Timeout)
}
