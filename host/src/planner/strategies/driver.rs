//! Runs the table of strategies: each row says when a strategy is tried, under which error model, and when its answer
//! takes the place of the best so far.

use std::time::Instant;

use super::fold_sequence::{fold_in_sequence, goal_of_sequences};
use super::pipeline::{self, Ending};
use crate::collision::contact_tolerance;
use crate::pattern::CreasePattern;
use crate::planner::following::reduction::{CLOSED, EXPECTED_AMPLIFICATION};
use crate::planner::following::route_selection::FARTHER_RATIO;
use crate::planner::lifting::certified_motion::CERTIFIED_DEFORMATION;
use crate::planner::lifting::whole_sheet::FIRST_BOUND_FRACTION;
use crate::planner::plan::{Attempt, Outcome, Plan, Strategy};
use crate::planner::problem::{ErrorModel, PlanningProblem};
use crate::planner::reason::{GroupsDropped, Note, Reason};
use crate::planner::{Goal, Judged, PlanOptions, Search, Symmetry};
use crate::progress::{Progress, Watch};
use crate::symmetry::closure_of;

/// Largest number of creases of a sheet that is planned once more without its crease groups to prove a smaller
/// deformation.
const FEW_CREASES: usize = 200;
/// Largest number of creases of a sheet that is planned once more without its crease groups because it is not proved to
/// keep the bound.
const MANY_CREASES: usize = 2000;

/// A row of the table of strategies.
struct Row {
    strategy: Strategy,
    errors: ErrorModel,
    /// Use of crease groups; `None` for that of the options.
    symmetry: Option<Symmetry>,
    /// `true` if the closed configuration nearest to the goal will do.
    goes_near: bool,
    /// Seed of random numbers; `None` for that of the options.
    seed: Option<u64>,
    /// Tells whether the strategy is tried, from the best plan so far.
    is_tried: fn(&PlanningProblem<'_>, &Plan) -> bool,
    /// Tells whether a plan takes the place of the best so far.
    is_better: fn(&Plan, &Plan) -> bool,
    /// Returns a note for a plan that took the place of the best so far.
    note: fn(&PlanningProblem<'_>, &Plan, &Plan) -> Option<Note>,
}

/// The strategies in the order in which they are tried. Symmetry comes first, as it is fast; then every crease turns on
/// its own, under error models that claim less and less of the coordinates.
const STRATEGIES: [Row; 10] = [
    Row {
        strategy: Strategy::CreaseGroups,
        errors: ErrorModel::Exact,
        symmetry: None,
        goes_near: false,
        seed: None,
        is_tried: |_, _| true,
        is_better: |_, _| true,
        note: |_, _, _| None,
    },
    Row {
        strategy: Strategy::EveryCrease,
        errors: ErrorModel::Exact,
        symmetry: Some(Symmetry::Off),
        goes_near: false,
        seed: None,
        is_tried: is_loose,
        is_better: proves_less_deformation,
        note: |_, _, grouped| {
            Some(Note::GroupsDropped {
                groups: grouped.groups,
                why: GroupsDropped::LessDeformation,
            })
        },
    },
    Row {
        strategy: Strategy::SnappedFine,
        errors: ErrorModel::Snapped {
            coarse: false,
            measured: false,
        },
        symmetry: Some(Symmetry::Off),
        goes_near: false,
        seed: None,
        is_tried: is_unplanned,
        is_better: leads_farther,
        note: |_, _, _| None,
    },
    Row {
        strategy: Strategy::SnappedCoarse,
        errors: ErrorModel::Snapped {
            coarse: true,
            measured: false,
        },
        symmetry: Some(Symmetry::Off),
        goes_near: false,
        seed: None,
        is_tried: is_unplanned,
        is_better: leads_farther,
        note: |_, _, _| None,
    },
    Row {
        strategy: Strategy::MeasuredError,
        errors: ErrorModel::Measured,
        symmetry: Some(Symmetry::Off),
        goes_near: false,
        seed: None,
        is_tried: nearly_closes,
        is_better: |new, _| new.outcome == Outcome::Planned,
        note: errors_added_up,
    },
    Row {
        strategy: Strategy::SnappedMeasured,
        errors: ErrorModel::Snapped {
            coarse: false,
            measured: true,
        },
        symmetry: Some(Symmetry::Off),
        goes_near: false,
        seed: None,
        is_tried: nearly_closes,
        is_better: leads_farther,
        note: errors_added_up,
    },
    Row {
        strategy: Strategy::NearestConfiguration,
        errors: ErrorModel::Exact,
        symmetry: None,
        goes_near: true,
        seed: None,
        is_tried: |_, plan| plan.outcome == Outcome::GoalNotClosed,
        is_better: leads_nearer,
        note: |_, _, _| None,
    },
    other_seed(0),
    other_seed(1),
    other_seed(2),
];

/// Returns the row that tries other random numbers, unless the user named this seed. The seeds are the same whatever
/// seed the user names, so that the answer seldom depends on it.
const fn other_seed(seed: u64) -> Row {
    Row {
        strategy: Strategy::OtherSeed,
        errors: ErrorModel::Exact,
        symmetry: None,
        goes_near: false,
        seed: Some(seed),
        is_tried: |_, plan| plan.is_random && is_no(plan.outcome),
        is_better: leads_farther,
        note: |_, _, _| None,
    }
}

/// Returns `true` if a plan without crease groups might prove less deformation: if `plan` proves more than the bound,
/// or on a small sheet more than the planner aims for. With crease groups, vertices may close only to a local minimum
/// of the residual.
fn is_loose(problem: &PlanningProblem<'_>, plan: &Plan) -> bool {
    let (options, creases) = (problem.options, problem.pattern.creases().len());
    let aim = match plan.outcome {
        Outcome::NotRigidlyFoldable if creases <= MANY_CREASES => options.bound,
        Outcome::Planned if creases <= FEW_CREASES => options.bound.min(CERTIFIED_DEFORMATION),
        _ => return false,
    };
    let held = plan.rigidity.deformation.max(plan.rigidity.gap) <= options.bound;
    let grouped = options.symmetry == Symmetry::Auto && plan.groups < creases;
    let path = grouped && options.search == Search::Path;
    path && held && plan.proved().is_some_and(|proved| proved > aim)
}

/// Returns `true` if there is no plan yet, but time to find one.
fn is_unplanned(_: &PlanningProblem<'_>, plan: &Plan) -> bool {
    is_no(plan.outcome)
}

/// Returns `true` if an answer is no, and not for want of time.
fn is_no(outcome: Outcome) -> bool {
    !matches!(outcome, Outcome::Planned | Outcome::Timeout)
}

/// Returns `true` if there is no plan yet, and the goal fails to close by no more than rounded coordinates may be off.
fn nearly_closes(problem: &PlanningProblem<'_>, plan: &Plan) -> bool {
    let open = matches!(
        plan.outcome,
        Outcome::GoalNotClosed | Outcome::NearGoal | Outcome::Partial | Outcome::NotRigidlyFoldable
    );
    let off = || closure_of(problem.pattern, &problem.goal.fold_angles);
    let near = |off: f64| off > CLOSED && off <= problem.options.bound / EXPECTED_AMPLIFICATION;
    open && problem.options.judged == Judged::Motion && off().is_some_and(near)
}

/// Returns `true` if a plan is found that proves less deformation than the best so far.
fn proves_less_deformation(new: &Plan, best: &Plan) -> bool {
    !(new.outcome != Outcome::Planned || new.proved() >= best.proved())
}

/// Returns `true` if a plan is found or, where the best so far ends before the goal, a path that leads farther.
fn leads_farther(new: &Plan, best: &Plan) -> bool {
    let ends_before = |outcome| matches!(outcome, Outcome::Partial | Outcome::NearGoal);
    let short = ends_before(best.outcome) || best.outcome == Outcome::GoalNotClosed;
    let farther = ends_before(new.outcome) && new.reached > best.reached + FARTHER_RATIO;
    new.outcome == Outcome::Planned || short && farther
}

/// Returns `true` if a path is found where the best so far is none, as the goal does not close.
fn leads_nearer(new: &Plan, best: &Plan) -> bool {
    new.outcome == Outcome::NearGoal
        || is_no(new.outcome) && new.reached > best.reached + FARTHER_RATIO
}

/// Returns a note if the errors of the vertices of a plan would add up to more than the bound in the worst case.
fn errors_added_up(problem: &PlanningProblem<'_>, new: &Plan, _: &Plan) -> Option<Note> {
    let closure = new.certified_closure.unwrap_or(0.0);
    let most = closure * new.amplification.unwrap_or(0.0);
    let over = new.outcome == Outcome::Planned && most > problem.options.bound;
    over.then_some(Note::ErrorsAddedUp { closure })
}

/// Plans the path of `pattern` from flat to `goal`.
///
/// Always answers: a sheet that cannot be folded is an outcome, not an error.
#[must_use]
pub fn plan(pattern: &CreasePattern, goal: &Goal, options: &PlanOptions) -> Plan {
    plan_until_over(pattern, goal, options, Watch::default()).finished(pattern, options)
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
    plan_until_over(pattern, goal, options, Watch::new(progress)).finished(pattern, options)
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
    let asked = PlanningProblem {
        pattern,
        goal,
        options,
        errors: ErrorModel::Exact,
        goes_near: false,
        contact: (options.contact).unwrap_or_else(|| contact_tolerance(pattern)),
        watch: watch.until(deadline),
    };
    let mut best = Plan::default();
    let mut attempts = Vec::new();
    for row in &STRATEGIES {
        if row.seed == Some(options.seed) || !(row.is_tried)(&asked, &best) {
            continue;
        }
        let options = PlanOptions {
            symmetry: row.symmetry.unwrap_or(options.symmetry),
            seed: row.seed.unwrap_or(options.seed),
            ..options.clone()
        };
        let problem = PlanningProblem {
            options: &options,
            errors: row.errors,
            goes_near: row.goes_near,
            ..asked
        };
        let Some(mut plan) = try_strategy(&problem, row.strategy, &mut attempts) else {
            continue;
        };
        if (row.is_better)(&plan, &best) {
            plan.add_effort(&best);
            plan.notes.extend((row.note)(&asked, &plan, &best));
            best = plan;
        }
    }
    if best.outcome == Outcome::Planned
        && let Some(&question) = best.undecided.first()
    {
        best.outcome = Outcome::Undecided;
        best.reason = Some(Reason::Undecided(question));
    }
    Plan {
        attempts,
        contact_tolerance: asked.contact,
        ..best
    }
}

/// Runs the pipeline for one strategy. If faces cross then, or the path ends before the goal, folds in sequence are
/// tried too. Returns `None` if the strategy does not apply to this sheet.
fn try_strategy(
    problem: &PlanningProblem<'_>,
    strategy: Strategy,
    attempts: &mut Vec<Attempt>,
) -> Option<Plan> {
    let start = Instant::now();
    let pass = pipeline::run(problem, FIRST_BOUND_FRACTION)?;
    let plan = pass.plan;
    attempts.push(Attempt {
        strategy: match pass.ending {
            Ending::StraightDeforming => Strategy::StraightDeforming,
            Ending::Route | Ending::Obstructed => strategy,
        },
        outcome: plan.outcome,
        reason: plan.reason.clone(),
        seconds: start.elapsed().as_secs_f64(),
    });
    if pass.ending != Ending::Obstructed {
        return Some(plan);
    }
    let start = Instant::now();
    let Some(goal) = goal_of_sequences(problem, &pass.route) else {
        return Some(plan);
    };
    let sequence = fold_in_sequence(problem, &pass.route, goal);
    let (outcome, reason) = match &sequence {
        Some(sequence) => (sequence.outcome, sequence.reason.clone()),
        None => (Outcome::Partial, Some(Reason::NoFoldSequence)),
    };
    attempts.push(Attempt {
        strategy: Strategy::FoldSequence,
        outcome,
        reason,
        seconds: start.elapsed().as_secs_f64(),
    });
    Some(match sequence {
        Some(mut sequence) => {
            sequence.add_effort(&plan);
            sequence
        }
        None => plan,
    })
}
