//! The table of strategies: each row says when a strategy is tried, under which error model, and when its answer takes the
//! place of the best so far.

use std::sync::Arc;

use super::advice::{explain_first_steps, goal_crossing, note_free_turns, what_may_help};
use super::bending::{bend_least, note_least_bend};
use super::fold_sequence::{fold_in_sequence, has_few_creases};
use super::lines::{turn_driven_alone, turn_lines_alone, turns_more};
use super::phase_samples::turns_freely;
use super::pipeline::deform;
use super::plates::{judge_plates, plates_asked_for};
use super::rows::{Context, Row, StartsFrom, is_no, try_rows};
use super::split_phases::{fold_in_split_phases, splits_phases};
use super::stops::try_phases;
use super::way_round::lead_round_crossings;
use crate::collision::{Crossing, Plates, contact_tolerance};
use crate::motion::PlanAnswer;
use crate::pattern::CreasePattern;
use crate::planner::following::reduction::{CLOSED, EXPECTED_AMPLIFICATION};
use crate::planner::following::route::Route;
use crate::planner::following::route_selection::FARTHER_RATIO;
use crate::planner::lifting::certified_motion::CERTIFIED_DEFORMATION;
use crate::planner::plan::{Attempt, FoldOrder, Outcome, Plan, Strategy};
use crate::planner::problem::{ErrorModel, PlanningProblem, StageTimes};
use crate::planner::reason::{GroupsDropped, Note, Reason, TimeoutAt};
use crate::planner::{Goal, GoalKind, PlanOptions, PlateRequest, Search, Symmetry};
use crate::progress::{Progress, Stage, Watch};
use crate::straighten::straightened;
use crate::symmetry::closure_of;
use crate::util::clock::Instant;
use crate::util::nan_max::diagonal;

/// Largest number of creases of a sheet that is planned once more without its crease groups to prove a smaller
/// deformation.
const FEW_CREASES: usize = 200;
/// Largest number of creases of a sheet that is planned once more without its crease groups because it is not proved to
/// keep the bound.
const MANY_CREASES: usize = 2000;

/// Bound on deformation and gap within which plates are planned at first.
const PLATE_BOUND: f64 = 1e-6;

/// Number of halvings in the search for plates as thick as they can be at the goal, and part of that thickness that is tried.
const THICKNESS_HALVINGS: u32 = 10;
const NEARLY: f64 = 0.995;

/// The row that the others change.
const BASE: Row = Row {
    strategy: Strategy::CreaseGroups,
    starts_from: StartsFrom::Problem,
    is_tried: |context| context.best.motion.is_none(),
    run: |context, attempts| context.pass_as_set(attempts),
    is_better: |_, _| true,
    note: |_, _| None,
    errors: ErrorModel::Exact,
    symmetry: None,
    goes_near: false,
    seed: None,
};

/// A row in which no crease groups are used, for a sheet that is not planned yet.
const UNGROUPED: Row = Row {
    symmetry: Some(Symmetry::Off),
    is_tried: |context| context.is_unplanned(),
    is_better: leads_farther,
    ..BASE
};

/// A row in which driven creases turn alone. It comes first, unless the pattern names a goal that closes: then they
/// turn on the path to that goal.
const ALONE: Row = Row {
    run: turn_driven_alone,
    is_better: |new, _| new.outcome == Outcome::Planned,
    ..BASE
};

/// The strategies in the order in which they are tried. Symmetry comes first, as it is fast; then every crease turns on
/// its own, under error models that claim less and less of the coordinates. The rows that start from a route or from an
/// answer are tried within each of the others.
static STRATEGIES: [Row; 19] = [
    Row {
        strategy: Strategy::DrivenAlone,
        is_tried: |context| is_driven(context.problem, false),
        ..ALONE
    },
    BASE,
    Row {
        strategy: Strategy::DrivenAlone,
        is_tried: |context| context.is_unplanned() && is_driven(context.problem, true),
        ..ALONE
    },
    Row {
        strategy: Strategy::StraightDeforming,
        starts_from: StartsFrom::Route,
        is_tried: |context| context.route.is_some_and(Route::ends_early),
        run: |context, _| deform(context.problem, context.route?),
        ..BASE
    },
    Row {
        strategy: Strategy::SplitPhases,
        starts_from: StartsFrom::Answer,
        is_tried: |context| splits_phases(context.problem, context.best),
        run: |context, attempts| {
            try_phases(
                context,
                attempts,
                Reason::NoFoldSequence,
                |problem, _, straight, leg| fold_in_split_phases(problem, leg, straight),
            )
        },
        ..BASE
    },
    Row {
        strategy: Strategy::FoldSequence,
        starts_from: StartsFrom::Answer,
        is_tried: |context| {
            let problem = context.problem;
            context.is_unplanned() && has_few_creases(problem) && !is_straightened_first(problem)
        },
        run: |context, attempts| {
            try_phases(
                context,
                attempts,
                Reason::NoFoldSequence,
                |problem, route, _, leg| fold_in_sequence(problem, route, leg),
            )
        },
        ..BASE
    },
    Row {
        strategy: Strategy::WayRound,
        starts_from: StartsFrom::Answer,
        is_tried: |context| {
            let plan = context.best;
            let crosses = matches!(plan.outcome, Outcome::Crossing(_));
            crosses && !splits_phases(context.problem, plan)
        },
        run: |context, attempts| {
            try_phases(
                context,
                attempts,
                Reason::NoWayRound,
                |problem, _, straight, leg| lead_round_crossings(problem, leg, straight),
            )
        },
        ..BASE
    },
    Row {
        strategy: Strategy::EveryCrease,
        symmetry: Some(Symmetry::Off),
        is_tried: |context| is_loose(context.problem, context.best),
        is_better: proves_less_deformation,
        note: |context, _| {
            Some(Note::GroupsDropped {
                groups: context.best.reduced.groups,
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
        ..UNGROUPED
    },
    Row {
        strategy: Strategy::SnappedCoarse,
        errors: ErrorModel::Snapped {
            coarse: true,
            measured: false,
        },
        ..UNGROUPED
    },
    Row {
        strategy: Strategy::NearestConfiguration,
        goes_near: true,
        is_tried: |context| context.best.outcome == Outcome::GoalNotClosed,
        is_better: leads_nearer,
        ..BASE
    },
    Row {
        strategy: Strategy::Straightened,
        is_tried: |context| {
            let may_be = context.problem.pattern.straightens_within().is_some();
            let is_open = context.is_unplanned() || !context.best.undecided.is_empty();
            may_be && is_open && !context.problem.is_late()
        },
        run: plan_straightened,
        is_better: |new, best| {
            if !is_no(best.outcome) {
                return new.outcome == Outcome::Planned && new.undecided.is_empty();
            }
            // If even the straightened sheet deforms, the drawing is not the reason why the sheet does not reach its goal.
            leads_farther(new, best) || new.outcome == Outcome::NotRigidlyFoldable
        },
        ..BASE
    },
    Row {
        strategy: Strategy::MeasuredError,
        errors: ErrorModel::Measured,
        is_tried: |context| nearly_closes(context, context.problem.options.bound),
        is_better: |new, _| new.outcome == Outcome::Planned,
        note: errors_added_up,
        ..UNGROUPED
    },
    Row {
        strategy: Strategy::SnappedMeasured,
        errors: ErrorModel::Snapped {
            coarse: false,
            measured: true,
        },
        is_tried: |context| {
            let bound = context.problem.options.bound;
            nearly_closes(context, bound / EXPECTED_AMPLIFICATION)
        },
        note: errors_added_up,
        ..UNGROUPED
    },
    Row {
        strategy: Strategy::BendingPanels,
        is_tried: |context| context.is_unplanned() && context.problem.options.bend > 0.0,
        run: bend_least,
        is_better: leads_farther,
        ..BASE
    },
    other_seed(0),
    other_seed(1),
    other_seed(2),
    Row {
        strategy: Strategy::LinesAlone,
        is_tried: |context| {
            let problem = context.problem;
            let asks_lines = problem.goal.is_direction() && problem.goal.via.is_empty();
            asks_lines && context.is_unplanned() && !problem.is_late()
        },
        run: turn_lines_alone,
        is_better: turns_more,
        ..BASE
    },
];

/// Returns the row that tries other random numbers, unless the user named this seed. The seeds are the same whatever
/// seed the user names, so that the answer seldom depends on it.
const fn other_seed(seed: u64) -> Row {
    Row {
        strategy: Strategy::OtherSeed,
        seed: Some(seed),
        is_tried: |context| {
            let is_new = context.row.seed != Some(context.problem.options.seed);
            let may_help = is_new && context.best.effort.is_random && context.is_unplanned();
            may_help && !crosses_at_goal_asked(context) && !context.best.has_no_layer_order()
        },
        is_better: leads_farther_uncrossed,
        ..BASE
    }
}

/// Returns `true` if faces cross at the goal, which names every crease and closes as asked: no path leads there.
fn crosses_at_goal_asked(context: &Context<'_>) -> bool {
    let problem = context.problem;
    matches!(context.best.reason, Some(Reason::GoalCrosses { .. }))
        && problem.closed_goal(problem.pattern, CLOSED).is_some()
}

/// Returns `true` if a goal is that of driven creases alone, and the pattern names goal angles that close, within the bound,
/// or if `is_guided` is `false` does not.
fn is_driven(problem: &PlanningProblem<'_>, is_guided: bool) -> bool {
    let goal = problem.goal;
    let named = |guide: &&Goal| guide.kind == GoalKind::Configuration;
    let guide = goal.guide.as_deref().filter(named);
    let off = guide.and_then(|guide| closure_of(problem.pattern, &guide.fold_angles));
    let closes = off.is_some_and(|off| off <= problem.options.bound);
    goal.kind == GoalKind::Driven && goal.via.is_empty() && closes == is_guided
}

/// Returns `true` if a sheet whose errors are snapped can be straightened. The straightened sheet is tried next. It closes at
/// every stop, so that sequences of folds are found on it in a fraction of the time.
fn is_straightened_first(problem: &PlanningProblem<'_>) -> bool {
    let is_next = problem.errors.is_snapped() && !problem.errors.is_measured();
    let within = problem.pattern.straightens_within().filter(|_| is_next);
    within.is_some_and(|within| straightened(problem.pattern, within, problem.watch).is_some())
}

/// Plans the sheet straightened, with what its vertices moved as contact, if the reader allowed it to be straightened.
fn plan_straightened(context: &Context<'_>, attempts: &mut Vec<Attempt>) -> Option<Plan> {
    let (start, asked) = (Instant::now(), context.problem);
    let within = asked.pattern.straightens_within()?;
    let (mut straight, how) = straightened(asked.pattern, within, asked.watch)?;
    straight.straighten_within(None);
    let problem = PlanningProblem {
        contact: asked
            .options
            .contact
            .unwrap_or_else(|| contact_tolerance(&straight)),
        pattern: &Arc::new(straight),
        ..*asked
    };
    let none = Plan::default();
    let context = Context {
        problem: &problem,
        best: &none,
        ..*context
    };
    let mut plan = try_rows(
        StartsFrom::Problem,
        &context,
        Plan::default(),
        &mut Vec::new(),
    );
    plan.notes.insert(0, Note::Straightened(how));
    attempts.push(Attempt::new(Strategy::Straightened, &plan, start));
    Some(plan)
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

/// Returns `true` if there is no plan yet, and the goal fails to close by no more than `most`.
fn nearly_closes(context: &Context<'_>, most: f64) -> bool {
    let problem = context.problem;
    let open = matches!(
        context.best.outcome,
        Outcome::GoalNotClosed | Outcome::NearGoal | Outcome::Partial | Outcome::NotRigidlyFoldable
    );
    let off = || closure_of(problem.pattern, &problem.goal.fold_angles);
    let near = |off: f64| off > CLOSED && off <= most;
    open && off().is_some_and(near)
}

/// Returns `true` if a plan is found that proves less deformation than the best so far.
fn proves_less_deformation(new: &Plan, best: &Plan) -> bool {
    !(new.outcome != Outcome::Planned || new.proved() >= best.proved())
}

/// Returns `true` if a plan is found, or a path that leads farther than the best so far, whatever ends it.
fn leads_farther(new: &Plan, best: &Plan) -> bool {
    let farther = is_no(new.outcome) && new.reached > best.reached + FARTHER_RATIO;
    new.outcome == Outcome::Planned || farther && new.motion.is_some()
}

/// Returns `true` if a plan is found or, if faces cross at the end of neither path, a path that leads farther. A crossing that
/// other random numbers meet tells less than lines that turn alone, which are tried after them.
fn leads_farther_uncrossed(new: &Plan, best: &Plan) -> bool {
    let ends_before = |outcome| matches!(outcome, Outcome::Partial | Outcome::NearGoal);
    let is_short = ends_before(best.outcome) || best.outcome == Outcome::GoalNotClosed;
    leads_farther(new, best)
        && (new.outcome == Outcome::Planned || is_short && ends_before(new.outcome))
}

/// Returns `true` if a path is found where the best so far is none, as the goal does not close.
fn leads_nearer(new: &Plan, best: &Plan) -> bool {
    matches!(new.outcome, Outcome::Planned | Outcome::NearGoal)
        || is_no(new.outcome) && new.reached > best.reached + FARTHER_RATIO
}

/// Returns a note if the errors of the vertices of a plan would add up to more than the bound in the worst case.
fn errors_added_up(context: &Context<'_>, new: &Plan) -> Option<Note> {
    let closure = new.certified_closure().unwrap_or(0.0);
    let most = closure * new.reduced.amplification.unwrap_or(0.0);
    let over = new.outcome == Outcome::Planned && most > context.problem.options.bound;
    over.then_some(Note::ErrorsAddedUp { closure })
}

/// Returns `true` if a small sheet hardly leaves flat with panels that have to be rigid.
fn is_stuck(problem: &PlanningProblem<'_>, plan: &Plan) -> bool {
    let short = problem.options.bend <= 0.0 && Outcome::FALLS_SHORT.contains(&plan.outcome);
    let few = problem.pattern.creases().len() <= FEW_CREASES;
    let path = problem.options.search != Search::Random;
    short && few && path && plan.reached < FARTHER_RATIO && !problem.is_late()
}

/// Adds to an answer what is known of the first steps from flat, and notes on what may help.
fn explain(context: &Context<'_>, best: &mut Plan) {
    let asked = context.problem;
    if is_stuck(asked, best) {
        best.notes.extend(note_least_bend(context));
    }
    if let Some(reason) = best.reason.as_mut().filter(|_| !asked.is_late()) {
        explain_first_steps(asked, reason);
    }
    best.notes.extend(what_may_help(asked, best));
    best.notes.extend(note_free_turns(asked, best));
}

/// Plans the path of `pattern` from flat to `goal`.
///
/// Always answers: a sheet that cannot be folded is an outcome, not an error.
#[must_use]
pub fn plan(pattern: &CreasePattern, goal: &Goal, options: &PlanOptions) -> Plan {
    plan_watched(pattern, goal, options, &Progress::default())
}

/// Plans as [`plan`] does, and reports to `progress`. A call that is cancelled answers [`Outcome::Timeout`], as does
/// one whose time is up.
///
/// Plates are planned within a tighter bound first, so that they keep to their hinges.
#[must_use]
pub fn plan_watched(
    pattern: &CreasePattern,
    goal: &Goal,
    options: &PlanOptions,
    progress: &Progress,
) -> Plan {
    let deadline = options
        .timeout
        .and_then(|timeout| Instant::now().checked_add(timeout));
    let mut first = None;
    if options.plates.is_some() && options.bound > PLATE_BOUND {
        let tight = options.clone().with(|it| it.bound = PLATE_BOUND);
        let mut plan = plan_until(pattern, goal, &tight, (deadline, progress));
        let answer = plan
            .motion
            .as_mut()
            .and_then(|motion| motion.answer.as_mut());
        if let Some(answer) = answer {
            answer.bound = options.bound;
        }
        if plan.outcome == Outcome::Planned {
            return plan;
        }
        // Another bound does not change that plates pass through each other.
        if plan.knows_plates() {
            return plan;
        }
        first = Some(plan.effort);
    }
    let mut plan = plan_until(pattern, goal, options, (deadline, progress));
    if let Some(first) = first {
        plan.effort += first;
        plan.effort.times = plan.effort.times.plus(&first.times);
    }
    plan
}

/// Plans within the time that is left until a deadline.
fn plan_until(
    pattern: &CreasePattern,
    goal: &Goal,
    options: &PlanOptions,
    (deadline, progress): (Option<Instant>, &Progress),
) -> Plan {
    let precision = goal.precision(pattern);
    let mut pattern = pattern.clone();
    pattern.written_with(precision);
    let contact = options
        .contact
        .unwrap_or_else(|| contact_tolerance(&pattern));
    let stage_times = StageTimes::default();
    let asked = PlanningProblem {
        pattern: &Arc::new(pattern),
        goal,
        options,
        errors: ErrorModel::Exact,
        goes_near: false,
        goes_straight: false,
        is_trial: false,
        contact,
        plates: None,
        watch: Watch::new(progress).until(deadline),
        stage_times: &stage_times,
    };
    let mut attempts = Vec::new();
    let context = Context {
        table: &STRATEGIES,
        row: &BASE,
        problem: &asked,
        best: &Plan::default(),
        route: None,
    };
    let mut best = asked.stage(Stage::Following, || {
        let none = Plan::default();
        let mut best = try_rows(StartsFrom::Problem, &context, none, &mut attempts);
        explain(&context, &mut best);
        best
    });
    list_own_order(&asked, &mut best);
    if let Some(thickness) = judge_plates(&asked, &mut best) {
        fold_plates_in_phases(&context, thickness, &mut best, &mut attempts);
    }
    best.effort.times = stage_times.times();
    if best.outcome == Outcome::Planned
        && let Some(&question) = best.undecided.first()
    {
        best.outcome = Outcome::Undecided;
        best.reason = Some(Reason::Undecided(question));
    }
    let is_late = |attempt: &Attempt| attempt.outcome == Outcome::Timeout;
    if is_no(best.outcome) && (asked.is_late() || attempts.iter().any(is_late)) {
        // The strategy that ran out of time might have found a plan.
        best.outcome = Outcome::Timeout;
        best.reason = Some(Reason::OutOfTime(TimeoutAt::LookingForOtherWays));
    }
    if best.outcome == Outcome::Timeout {
        best.notes
            .extend(note_not_straightened(&asked, &attempts, progress));
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

/// Looks for phases in which plates do not pass through each other that do so at this thickness (units of the sheet) on the
/// motion of the thin sheet, if each hinge turns freely. If the largest thickness is asked for, they have to be nearly as thick as the goal allows.
fn fold_plates_in_phases(
    context: &Context<'_>,
    crosses_at: f64,
    best: &mut Plan,
    attempts: &mut Vec<Attempt>,
) {
    let asked = context.problem;
    let is_max = best.max_thickness.is_some();
    if asked.options.search != Search::Auto || !turns_freely(asked.pattern) {
        return;
    }
    let plates = if is_max {
        thickest_at_goal(asked, crosses_at)
    } else {
        plates_asked_for(asked, crosses_at)
    };
    let Some(plates) = plates.map(Arc::new) else {
        return;
    };
    let options = asked.options.clone();
    let options = options.with(|it| it.plates = Some(PlateRequest::given(plates.options)));
    let problem = PlanningProblem {
        plates: Some(&plates),
        options: &options,
        ..*asked
    };
    if let Some(Crossing { faces, depth }) = goal_crossing(&problem, asked.pattern) {
        let thickness = plates.options.thickness;
        best.notes.push(Note::PlatesCrossAtGoal {
            faces,
            depth,
            thickness,
        });
        return;
    }
    let context = Context {
        problem: &problem,
        ..*context
    };
    let mut plan = asked.stage(Stage::Following, || {
        try_rows(StartsFrom::Problem, &context, Plan::default(), attempts)
    });
    plan.effort += core::mem::take(&mut best.effort);
    if plan.outcome == Outcome::Planned && is_max {
        judge_plates(asked, &mut plan);
    }
    let proved = |plan: &Plan| plan.max_thickness.map_or(0.0, |[proved, _]| proved);
    if plan.outcome == Outcome::Planned && (!is_max || proved(&plan) > proved(best)) {
        list_own_order(asked, &mut plan);
        *best = plan;
    } else {
        best.effort = plan.effort;
    }
}

/// Returns plates nearly as thick as they can be at the goal, if they are thicker than those that are refuted on the way.
fn thickest_at_goal(asked: &PlanningProblem<'_>, refuted: f64) -> Option<Plates> {
    let is_free = |thickness: f64| {
        let plates = plates_asked_for(asked, thickness).map(Arc::new);
        plates.is_some_and(|plates| {
            let problem = PlanningProblem {
                plates: Some(&plates),
                ..*asked
            };
            goal_crossing(&problem, asked.pattern).is_none()
        })
    };
    let most = diagonal(asked.pattern.vertices());
    let [mut low, mut high] = [refuted; 2];
    while high < most && is_free(high) {
        (low, high) = (high, 2.0 * high);
    }
    for _ in 0..THICKNESS_HALVINGS {
        let middle = f64::midpoint(low, high);
        if is_free(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    let thickness = NEARLY * low;
    (thickness > refuted).then(|| plates_asked_for(asked, thickness))?
}

/// Lists the order of the motion, if orders are asked for, the plan has none yet, and each hinge turns freely.
fn list_own_order(asked: &PlanningProblem<'_>, best: &mut Plan) {
    if asked.options.orders == 0 {
        best.orders.clear();
    } else if best.orders.is_empty()
        && best.outcome == Outcome::Planned
        && turns_freely(asked.pattern)
    {
        let motion = best.motion.iter();
        best.orders.extend(motion.map(FoldOrder::of));
    }
}

/// Returns a note on the straightened sheet, if it could be planned but was not begun for want of time. Only small sheets
/// are straightened for it, in milliseconds, as the time is over.
fn note_not_straightened(
    asked: &PlanningProblem<'_>,
    attempts: &[Attempt],
    progress: &Progress,
) -> Option<Note> {
    let is_straightened = |attempt: &Attempt| attempt.strategy == Strategy::Straightened;
    let within = asked.pattern.straightens_within();
    let within = within.filter(|_| !attempts.iter().any(is_straightened))?;
    let is_small = asked.pattern.creases().len() <= FEW_CREASES;
    let watch = Watch::new(progress);
    let (_, how) = is_small.then(|| straightened(asked.pattern, within, watch))??;
    Some(Note::NotStraightened(how))
}
