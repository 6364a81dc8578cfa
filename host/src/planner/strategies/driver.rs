//! Runs the table of strategies: each row says when a strategy is tried, under which error model, and when its answer
//! takes the place of the best so far.

use std::sync::Arc;

use super::bending::BentSheet;
use super::fold_sequence::{fold_in_sequence, goal_is_free, goal_of_sequences, has_few_creases};
use super::lines::goal_of_lines;
use super::pipeline::{self, Ending};
use super::split_phases::{fold_in_split_phases, splits_phases};
use super::way_round::lead_round_crossings;
use crate::collision::contact_tolerance;
use crate::motion::PlanAnswer;
use crate::pattern::{CreasePattern, Diagonals};
use crate::planner::following::reduction::{CLOSED, EXPECTED_AMPLIFICATION};
use crate::planner::following::route_selection::FARTHER_RATIO;
use crate::planner::lifting::certified_motion::CERTIFIED_DEFORMATION;
use crate::planner::lifting::swept_motion::FIRST_BOUND_FRACTION;
use crate::planner::plan::{Attempt, Outcome, Plan, Strategy};
use crate::planner::problem::{ErrorModel, PlanningProblem};
use crate::planner::reason::{GroupsDropped, Note, Reason, TimeoutAt};
use crate::planner::{Goal, PlanOptions, Search, Symmetry};
use crate::progress::{Progress, Watch};
use crate::symmetry::closure_of;
use crate::util::clock::Instant;

/// Largest number of creases of a sheet that is planned once more without its crease groups to prove a smaller
/// deformation.
const FEW_CREASES: usize = 200;
/// Largest number of creases of a sheet that is planned once more without its crease groups because it is not proved to
/// keep the bound.
const MANY_CREASES: usize = 2000;

/// Largest number of limits on the bend of panels that are tried after a plan is found.
const MAX_BEND_HALVINGS: usize = 12;
/// Largest bend that is tried to tell how far panels would have to bend, radians, and the number of smaller ones.
const HINTED_BEND_RAD: f64 = core::f64::consts::FRAC_PI_2;
const HINT_HALVINGS: usize = 3;
/// Fraction of the largest bend to which the least one is looked for.
const BEND_RATIO: f64 = 0.01;

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
    /// `true` if the strategy is tried only if random numbers may have decided the best plan so far.
    needs_chance: bool,
    /// Tells whether a plan takes the place of the best so far.
    is_better: fn(&Plan, &Plan) -> bool,
    /// Returns a note for a plan that took the place of the best so far.
    note: fn(&PlanningProblem<'_>, &Plan, &Plan) -> Option<Note>,
}

/// The first row, which the others change.
const BASE: Row = Row {
    strategy: Strategy::CreaseGroups,
    errors: ErrorModel::Exact,
    symmetry: None,
    goes_near: false,
    seed: None,
    is_tried: |_, _| true,
    needs_chance: false,
    is_better: |_, _| true,
    note: |_, _, _| None,
};

/// The strategies in the order in which they are tried. Symmetry comes first, as it is fast; then every crease turns on
/// its own, under error models that claim less and less of the coordinates.
const STRATEGIES: [Row; 10] = [
    BASE,
    Row {
        strategy: Strategy::EveryCrease,
        symmetry: Some(Symmetry::Off),
        is_tried: is_loose,
        is_better: proves_less_deformation,
        note: |_, _, grouped| {
            Some(Note::GroupsDropped {
                groups: grouped.reduced.groups,
                why: GroupsDropped::LessDeformation,
            })
        },
        ..BASE
    },
    Row {
        strategy: Strategy::SnappedFine,
        errors: ErrorModel::Snapped {
            coarse: false,
            measured: false,
        },
        symmetry: Some(Symmetry::Off),
        is_tried: is_unplanned,
        is_better: leads_farther,
        ..BASE
    },
    Row {
        strategy: Strategy::SnappedCoarse,
        errors: ErrorModel::Snapped {
            coarse: true,
            measured: false,
        },
        symmetry: Some(Symmetry::Off),
        is_tried: is_unplanned,
        is_better: leads_farther,
        ..BASE
    },
    Row {
        strategy: Strategy::MeasuredError,
        errors: ErrorModel::Measured,
        symmetry: Some(Symmetry::Off),
        is_tried: nearly_closes,
        is_better: |new, _| new.outcome == Outcome::Planned,
        note: errors_added_up,
        ..BASE
    },
    Row {
        strategy: Strategy::SnappedMeasured,
        errors: ErrorModel::Snapped {
            coarse: false,
            measured: true,
        },
        symmetry: Some(Symmetry::Off),
        is_tried: nearly_closes,
        is_better: leads_farther,
        note: errors_added_up,
        ..BASE
    },
    Row {
        strategy: Strategy::NearestConfiguration,
        goes_near: true,
        is_tried: |_, plan| plan.outcome == Outcome::GoalNotClosed,
        is_better: leads_nearer,
        ..BASE
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
        seed: Some(seed),
        is_tried: is_unplanned,
        needs_chance: true,
        is_better: leads_farther,
        ..BASE
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
    let rigidity = plan.errors.rigidity;
    let held = rigidity.deformation.max(rigidity.gap) <= options.bound;
    let grouped = options.symmetry == Symmetry::Auto && plan.reduced.groups < creases;
    let path = grouped && options.search != Search::Random;
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
    open && off().is_some_and(near)
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
    let closure = new.certified_closure().unwrap_or(0.0);
    let most = closure * new.reduced.amplification.unwrap_or(0.0);
    let over = new.outcome == Outcome::Planned && most > problem.options.bound;
    over.then_some(Note::ErrorsAddedUp { closure })
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
    let asked = PlanningProblem {
        pattern: &Arc::new(pattern.clone()),
        goal,
        options,
        errors: ErrorModel::Exact,
        goes_near: false,
        goes_straight: false,
        contact: (options.contact).unwrap_or_else(|| contact_tolerance(pattern)),
        watch: watch.until(deadline),
    };
    let mut attempts = Vec::new();
    let mut best = run_table(&asked, &mut attempts);
    if goal.is_direction()
        && is_no(best.outcome)
        && let Some(mut lines) = with_lines_alone(&asked, &best, &mut attempts)
    {
        lines.effort += best.effort;
        best = lines;
    }
    if is_no(best.outcome) && options.bend > 0.0 {
        let bent = with_least_bend(&asked, options.bend, MAX_BEND_HALVINGS, &mut attempts);
        if let Some(mut bent) = bent {
            bent.effort += best.effort;
            best = bent;
        }
    } else if is_stuck(&asked, &best) {
        let quick = PlanningProblem {
            goes_straight: true,
            ..asked
        };
        let bent = with_least_bend(&quick, HINTED_BEND_RAD, HINT_HALVINGS, &mut Vec::new());
        let would_bend = bent.map(|bent| Note::WouldBend(bent.max_bend));
        best.notes.extend(would_bend);
    }
    if best.outcome == Outcome::Planned
        && let Some(&question) = best.undecided.first()
    {
        best.outcome = Outcome::Undecided;
        best.reason = Some(Reason::Undecided(question));
    }
    best.attempts = attempts;
    if let Some(motion) = &mut best.motion {
        motion.seed = Some(options.seed);
        motion.answer = Some(PlanAnswer {
            outcome: best.outcome.name().to_string(),
            reached: best.reached,
            bound: options.bound,
            bend: best.max_bend,
        });
        let inner = 1..motion.knots.len() - 1;
        motion.phases.retain(|knot| inner.contains(knot));
    }
    best
}

/// Tries the rows of the table in order, and returns the best plan.
fn run_table(asked: &PlanningProblem<'_>, attempts: &mut Vec<Attempt>) -> Plan {
    let options = asked.options;
    let mut best = Plan::default();
    let mut is_random = false;
    for row in &STRATEGIES {
        let is_left_out = row.seed == Some(options.seed) || row.needs_chance && !is_random;
        if is_left_out || !(row.is_tried)(asked, &best) {
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
            ..*asked
        };
        let Some((mut plan, drew)) = try_strategy(&problem, row.strategy, attempts) else {
            continue;
        };
        if (row.is_better)(&plan, &best) {
            is_random = drew;
            plan.effort += best.effort;
            plan.notes.extend((row.note)(asked, &plan, &best));
            best = plan;
        }
    }
    best
}

/// Returns the plan in which only lines that turn alone do, if it turns the sheet's creases by more than the best so far.
fn with_lines_alone(
    asked: &PlanningProblem<'_>,
    best: &Plan,
    attempts: &mut Vec<Attempt>,
) -> Option<Plan> {
    if !asked.goal.via.is_empty() || asked.is_late() {
        return None;
    }
    let (goal, limits) = goal_of_lines(asked.pattern, asked.goal)?;
    let mut options = PlanOptions {
        // A group may have a line and other creases.
        symmetry: Symmetry::Off,
        ..asked.options.clone()
    };
    options.limits.extend(limits);
    let problem = PlanningProblem {
        goal: &goal,
        options: &options,
        ..*asked
    };
    let (plan, _) = try_strategy(&problem, Strategy::LinesAlone, attempts)?;
    (plan.outcome == Outcome::NearGoal && turned(&plan) > turned(best)).then_some(plan)
}

/// Returns the sum of the angles by which creases are turned at the end of a path, radians.
fn turned(plan: &Plan) -> f64 {
    let motion = plan.motion.as_ref();
    let angles = motion.map_or_else(Vec::new, |motion| {
        motion.crease_angles(motion.knots.len() - 1)
    });
    angles.iter().map(|angle| angle.abs()).sum()
}

/// Returns `true` if a small sheet hardly leaves flat with rigid panels.
fn is_stuck(problem: &PlanningProblem<'_>, plan: &Plan) -> bool {
    let short = Outcome::FALLS_SHORT.contains(&plan.outcome);
    let few = problem.pattern.creases().len() <= FEW_CREASES;
    let path = problem.options.search != Search::Random;
    short && few && path && plan.reached < FARTHER_RATIO && !problem.is_late()
}

/// Returns the plan found in which panels bend least, and by no more than `most` radians, if there is one. Both diagonals
/// of the panels are tried; then up to `halvings` smaller limits, between the largest with which no plan is found and the
/// smallest with which one is.
fn with_least_bend(
    asked: &PlanningProblem<'_>,
    most: f64,
    halvings: usize,
    attempts: &mut Vec<Attempt>,
) -> Option<Plan> {
    let mut best: Option<(BentSheet, Plan)> = None;
    for which in [Diagonals::Triangulation, Diagonals::Others] {
        let bent = BentSheet::of(asked.pattern, asked.goal, asked.options, which);
        let Some(sheet) = bent else { continue };
        let most = best.as_ref().map_or(most, |(_, plan)| plan.max_bend);
        if let Some(plan) = bent_by(asked, &sheet, most, attempts) {
            best = Some((sheet, plan));
        }
    }
    let (sheet, mut plan) = best?;
    let mut too_small = 0.0;
    for _ in 0..halvings {
        let most = f64::midpoint(too_small, plan.max_bend);
        if asked.is_late() || plan.max_bend - too_small < BEND_RATIO * plan.max_bend {
            break;
        }
        match bent_by(asked, &sheet, most, &mut Vec::new()) {
            Some(less) => plan = less,
            None => too_small = most,
        }
    }
    Some(plan)
}

/// Plans a sheet whose panels bend by no more than `most` radians; `None` if that leads to no plan.
fn bent_by(
    asked: &PlanningProblem<'_>,
    sheet: &BentSheet,
    most: f64,
    attempts: &mut Vec<Attempt>,
) -> Option<Plan> {
    let options = sheet.bending_by(most);
    let problem = PlanningProblem {
        pattern: &sheet.pattern,
        goal: &sheet.goal,
        options: &options,
        ..*asked
    };
    let (mut plan, _) = try_strategy(&problem, Strategy::BendingPanels, attempts)?;
    if plan.outcome != Outcome::Planned {
        return None;
    }
    plan.max_bend = sheet.largest_bend(plan.motion.as_ref()?);
    Some(plan)
}

/// Runs the pipeline for one strategy. If faces cross then, or the path ends before the goal, folds in sequence are
/// tried too. Returns the plan, and `true` if random numbers may have decided it; `None` if the strategy does not apply to
/// this sheet.
fn try_strategy(
    problem: &PlanningProblem<'_>,
    strategy: Strategy,
    attempts: &mut Vec<Attempt>,
) -> Option<(Plan, bool)> {
    let start = Instant::now();
    let pass = pipeline::run(problem, FIRST_BOUND_FRACTION)?;
    let (plan, is_random) = (pass.plan, pass.route.is_random);
    attempts.push(Attempt {
        strategy: match pass.ending {
            Ending::StraightDeforming => Strategy::StraightDeforming,
            Ending::Route | Ending::Obstructed => strategy,
        },
        outcome: plan.outcome,
        reason: plan.reason.clone(),
        seconds: start.elapsed().as_secs_f64(),
    });
    if pass.ending != Ending::Obstructed || problem.goes_straight {
        return Some((plan, is_random));
    }
    let (splits, few) = (splits_phases(problem, &plan), has_few_creases(problem));
    let leads_round = !splits && matches!(plan.outcome, Outcome::Crossing(_));
    if !splits && !few && !leads_round {
        return Some((plan, is_random));
    }
    let goal = goal_of_sequences(problem, &pass.route);
    let Some(goal) = goal.filter(|goal| goal_is_free(problem, goal)) else {
        return Some((plan, is_random));
    };
    let mut try_phases = |strategy, none: Reason, fold: &dyn Fn() -> Option<Plan>| {
        let start = Instant::now();
        let found = fold();
        let (outcome, reason) = match &found {
            Some(found) => (found.outcome, found.reason.clone()),
            None if problem.is_late() => (
                Outcome::Timeout,
                Some(Reason::OutOfTime(TimeoutAt::LookingForOtherWays)),
            ),
            None => (Outcome::Partial, Some(none)),
        };
        attempts.push(Attempt {
            strategy,
            outcome,
            reason,
            seconds: start.elapsed().as_secs_f64(),
        });
        found
    };
    let split = || fold_in_split_phases(problem, &goal, &plan);
    let sequence = || fold_in_sequence(problem, &pass.route, goal.clone());
    let round = || lead_round_crossings(problem, &plan);
    let mut found = None;
    if splits {
        found = try_phases(Strategy::SplitPhases, Reason::NoFoldSequence, &split);
    }
    if found.is_none() && few {
        found = try_phases(Strategy::FoldSequence, Reason::NoFoldSequence, &sequence);
    }
    if found.is_none() && leads_round {
        found = try_phases(Strategy::WayRound, Reason::NoWayRound, &round);
    }
    let plan = match found {
        Some(mut found) => {
            found.effort += plan.effort;
            found
        }
        None => plan,
    };
    Some((plan, is_random))
}
