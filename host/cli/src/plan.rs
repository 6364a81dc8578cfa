//! Runs `foldpath plan`, which plans a path and writes it.

use core::time::Duration;
use std::path::Path;
use std::time::Instant;

use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::args::{Frames, Plan, Switch};
use crate::hints::{nearest_hinge, radians};
use crate::output::write_whole_with;
use crate::progress::watched;
use crate::report::{lost_lines, outcome};
use crate::standard::{Input, print_summary, shown};
use crate::{Answer, CliError, check_output, print_json, print_notes};
use foldpath::export::fold::write_motion;
use foldpath::motion::Motion;
use foldpath::pattern::{CreaseId, CreasePattern, EdgeId, Letter};
use foldpath::planner::{
    self, Foldability, Goal, GoalError, HingeLimit, Outcome, PlanOptions, forecast,
};
use foldpath::progress::{Progress, Stage, Watch};
use foldpath::read::fold::PatternFile;
use foldpath::symmetry::CreaseGroups;

/// Largest number of causes that a plan's notes name; `info` names them all.
const MAX_CAUSES: usize = 5;
/// Largest number of panels that bend that are named.
const MAX_BENDS: usize = 8;

/// The answer as `--json` prints it.
#[derive(Serialize)]
pub(crate) struct PlanJson<'a> {
    pub(crate) version: &'static str,
    pub(crate) input: &'a InputJson,
    options: &'a Plan,
    pub(crate) outcome: &'static str,
    reason: Option<String>,
    reached: f64,
    creases: usize,
    real_vertices: usize,
    groups: usize,
    essential_vertices: usize,
    unknowns: usize,
    knots: usize,
    max_deformation: f64,
    certified_deformation: Option<f64>,
    max_closure: f64,
    max_gap: f64,
    max_bend: f64,
    goal_error: f64,
    flat_creases: usize,
    min_clearance: Option<f64>,
    contact_tolerance: f64,
    undecided: Vec<String>,
    notes: Vec<String>,
    attempts: Vec<AttemptJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<TimeJson>,
    solver: SolverJson,
    collision: CollisionJson,
    seed: u64,
}

impl PlanJson<'_> {
    /// Leaves out the times that were taken.
    pub(crate) fn leave_out_times(&mut self) {
        self.time = None;
        for attempt in &mut self.attempts {
            attempt.seconds = None;
        }
    }
}

/// The file that was read.
#[derive(Serialize)]
pub(crate) struct InputJson {
    file: String,
    sha256: String,
}

impl InputJson {
    fn of(args: &Plan, name: &Path, bytes: &[u8]) -> Self {
        // Only the JSON names the digest.
        let digest = args.report.json.then(|| Sha256::digest(bytes));
        let digest = digest.iter().flatten();
        Self {
            file: name.display().to_string(),
            sha256: digest.map(|byte| format!("{byte:02x}")).collect(),
        }
    }
}

/// A strategy that was tried.
#[derive(Serialize)]
struct AttemptJson {
    strategy: &'static str,
    outcome: &'static str,
    reason: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds: Option<f64>,
}

impl AttemptJson {
    fn of(attempt: &planner::Attempt) -> Self {
        Self {
            strategy: attempt.strategy.name(),
            outcome: attempt.outcome.name(),
            reason: attempt.reason.as_ref().map(ToString::to_string),
            seconds: Some(attempt.seconds),
        }
    }
}

#[derive(Serialize)]
struct TimeJson {
    total: f64,
    read: f64,
    symmetry: f64,
    solve: f64,
    fold: f64,
    collision: f64,
    write: f64,
}

#[derive(Serialize)]
struct SolverJson {
    iterations: u64,
    evaluations: u64,
}

#[derive(Serialize)]
struct CollisionJson {
    pairs: u64,
    tested: u64,
    skipped_symmetry: u64,
    skipped_motion: u64,
    skipped_bounds: u64,
    skipped_edges: u64,
}

pub(crate) fn run(args: &Plan, quiet: bool) -> Answer {
    let start = Instant::now();
    let options = checked_options(args)?;
    let planned = watched(&args.report, quiet, |progress| {
        planned(args, None, options, quiet, progress)
    })?;
    let json = told(args, &planned, start);
    print_notes(quiet, &json.notes);
    if args.report.json {
        print_json(&json)?;
    } else {
        let text = summary(args, &planned, &json);
        print_summary(args.output.as_deref(), quiet, &text)?;
    }
    Ok(planned.outcome() == Outcome::Planned)
}

/// Plans for an input that was found otherwise than by the arguments, and prints nothing.
///
/// # Errors
/// As the command refuses.
pub(crate) fn plan_input(args: &Plan, input: Input) -> Result<Planned, CliError> {
    let options = checked_options(args)?;
    planned(args, Some(input), options, true, &Progress::new())
}

/// Returns the planner's options, if these and the file to write are valid.
fn checked_options(args: &Plan) -> Result<PlanOptions, CliError> {
    let options = args.options()?;
    if let Some(output) = &args.output {
        let inputs = [&args.pattern]
            .into_iter()
            .chain(&args.goal)
            .chain(&args.via);
        check_output("-o", output, inputs)?;
    }
    Ok(options)
}

/// Returns the answer for `--json`. `start` is when the work began.
pub(crate) fn told<'a>(args: &'a Plan, planned: &'a Planned, start: Instant) -> PlanJson<'a> {
    let Planned {
        input,
        file,
        plan,
        read,
        write,
        ..
    } = planned;
    let times = plan.times;
    let notes = [file.pattern.repairs(), file.pattern.assumptions()];
    let mut notes: Vec<String> = notes.concat();
    notes.extend(plan.notes.iter().map(ToString::to_string));
    notes.extend_from_slice(&planned.held_flat);
    notes.extend_from_slice(&planned.in_the_way);
    notes.extend(plan.motion.iter().flat_map(bends));
    if args.goal.is_none() && args.fold.is_none() && args.crease.is_empty() {
        let open = plan.outcome == Outcome::GoalNotClosed;
        let closure = if open {
            f64::INFINITY
        } else {
            plan.goal_closure
        };
        notes.extend(radians(&file.pattern, Some(closure)));
    }
    PlanJson {
        version: env!("CARGO_PKG_VERSION"),
        input,
        options: args,
        outcome: plan.outcome.name(),
        reason: plan.reason.as_ref().map(ToString::to_string),
        reached: plan.reached,
        creases: file.pattern.creases().len(),
        real_vertices: file.pattern.real_vertices().count(),
        groups: plan.groups,
        essential_vertices: plan.essential_vertices,
        unknowns: plan.unknowns,
        knots: plan.knots().len(),
        max_deformation: plan.rigidity.deformation,
        certified_deformation: plan.certified_deformation,
        max_closure: plan.max_closure,
        max_gap: plan.rigidity.gap,
        max_bend: plan.max_bend.to_degrees(),
        goal_error: plan.goal_error.to_degrees(),
        flat_creases: plan.flat_creases,
        min_clearance: plan.clearance.map(|clearance| clearance.distance),
        contact_tolerance: plan.contact_tolerance,
        undecided: plan.undecided.iter().map(ToString::to_string).collect(),
        notes,
        attempts: plan.attempts.iter().map(AttemptJson::of).collect(),
        time: Some(TimeJson {
            write: write.as_secs_f64(),
            total: start.elapsed().as_secs_f64(),
            read: read.as_secs_f64(),
            symmetry: times.symmetry.as_secs_f64(),
            solve: times.solve.as_secs_f64(),
            fold: (times.place + times.fold).as_secs_f64(),
            collision: times.collision.as_secs_f64(),
        }),
        solver: SolverJson {
            iterations: plan.iterations,
            evaluations: plan.evaluations,
        },
        collision: CollisionJson {
            pairs: plan.collision.pairs,
            tested: plan.collision.tested,
            skipped_symmetry: plan.collision.skipped_symmetry,
            skipped_motion: plan.collision.skipped_motion,
            skipped_bounds: plan.collision.skipped_bounds,
            skipped_edges: plan.collision.skipped_edges,
        },
        seed: args.seed,
    }
}

/// Pattern and goal that were read, the plan, and the times that reading and writing took.
pub(crate) struct Planned {
    input: InputJson,
    file: PatternFile,
    goal: Goal,
    plan: planner::Plan,
    /// A note for each limit that holds its crease flat.
    held_flat: Vec<String>,
    /// A note for each cause, if the answer is no.
    in_the_way: Vec<String>,
    read: Duration,
    write: Duration,
}

impl Planned {
    /// Returns the outcome of the plan.
    pub(crate) fn outcome(&self) -> Outcome {
        self.plan.outcome
    }

    /// Returns `true` if a strategy was ended by the timeout.
    pub(crate) fn ran_out_of_time(&self) -> bool {
        let attempts = self.plan.attempts.iter().map(|attempt| attempt.outcome);
        attempts
            .chain([self.plan.outcome])
            .any(|outcome| outcome == Outcome::Timeout)
    }
}

/// Reads the pattern and the goal, plans, and writes the path if it reaches the goal.
fn planned(
    args: &Plan,
    source: Option<Input>,
    mut options: PlanOptions,
    quiet: bool,
    progress: &Progress,
) -> Result<Planned, CliError> {
    progress.begin(Stage::Reading);
    let start = Instant::now();
    let reading = args.reading.options()?;
    let source = source.map_or_else(|| Input::of(&args.pattern), Ok)?;
    let bytes = source.pattern_bytes()?;
    let input = InputJson::of(args, &source.name, &bytes);
    let file = source.pattern(&bytes, &reading)?;
    drop(bytes);
    // A drawing whose creases were left out may have no goal.
    let goal = goal(args, &source.name, &file)
        .inspect_err(|_| print_notes(quiet, file.pattern.repairs()))?;
    let limits = limits(args, &file.pattern)?;
    options.keep_vertices = args.output.is_some() && args.frames == Frames::Full;
    options.limits = limits;
    options
        .validate()
        .map_err(|option| CliError::Options { option })?;
    let read = start.elapsed();
    // The time that is allowed is that of the whole command.
    options.timeout = options.timeout.map(|time| time.saturating_sub(read));
    let deadline = options
        .timeout
        .and_then(|time| Instant::now().checked_add(time));
    let mut plan = planner::plan_watched(&file.pattern, &goal, &options, progress);
    let in_the_way = in_the_way(args, &file.pattern, plan.outcome, deadline);
    progress.begin(Stage::Writing);
    let start = Instant::now();
    if let Some(motion) = &mut plan.motion {
        motion.title.clone_from(&file.title);
        if let Some(output) = args
            .output
            .as_ref()
            .filter(|_| is_written(args, plan.outcome))
        {
            write_whole_with(output, |out| write_motion(motion, out))?;
        }
    }
    let write = start.elapsed();
    Ok(Planned {
        input,
        held_flat: held_flat(args, &file.pattern, &goal),
        in_the_way,
        file,
        goal,
        plan,
        read,
        write,
    })
}

/// Returns a note for each panel that bends, those that bend most first.
fn bends(motion: &Motion) -> Vec<String> {
    let edges = motion.pattern.edges().iter().enumerate();
    let mut bends: Vec<(f64, String)> = edges
        .filter(|(_, edge)| edge.letter == Letter::Bend)
        .map(|(index, edge)| {
            let angles =
                (0..motion.knots.len()).map(|knot| motion.node(knot, EdgeId::new(index)).angle);
            let most = angles.map(f64::abs).fold(0.0, f64::max).to_degrees();
            let [from, to] = edge.ends;
            let line = format!("from vertex {from} to vertex {to} (edge {index})");
            (
                most,
                format!("a panel bends by {most:.2} degrees about its diagonal {line}"),
            )
        })
        .filter(|(most, _)| *most > 0.0)
        .collect();
    bends.sort_by(|a, b| b.0.total_cmp(&a.0));
    let more = bends.len().saturating_sub(MAX_BENDS);
    let named = bends.into_iter().take(MAX_BENDS).map(|(_, note)| note);
    let more = (more > 0).then(|| format!("{more} more panels bend, by less"));
    named.chain(more).collect()
}

/// Returns what the flat sheet alone tells of the reasons for a no, in notes; none if another goal than the pattern's own
/// was asked for.
fn in_the_way(
    args: &Plan,
    pattern: &CreasePattern,
    outcome: Outcome,
    deadline: Option<Instant>,
) -> Vec<String> {
    let stops_short = matches!(
        outcome,
        Outcome::Partial | Outcome::NearGoal | Outcome::GoalNotClosed
    );
    if !stops_short || args.goal.is_some() || !args.crease.is_empty() {
        return Vec::new();
    }
    let watch = Watch::default().until(deadline);
    let groups = CreaseGroups::find_until(pattern, watch);
    let forecast = forecast(pattern, &groups, watch);
    let proof = (forecast.foldability == Foldability::No)
        .then(|| "it is proved that no motion leaves flat along the letters".to_string());
    let causes = forecast.causes.iter().take(MAX_CAUSES);
    let causes = causes.map(|cause| format!("in the way: {cause}"));
    proof.into_iter().chain(causes).collect()
}

/// Returns `true` if the path of a plan with this outcome is written.
fn is_written(args: &Plan, outcome: Outcome) -> bool {
    args.keep || outcome == Outcome::Planned
}

fn goal(args: &Plan, name: &Path, file: &PatternFile) -> Result<Goal, CliError> {
    let bad = |source| match source {
        GoalError::Crease { .. } | GoalError::CreaseTwice { .. } => {
            CliError::Usage(source.to_string())
        }
        _ => CliError::Goal {
            file: name.display().to_string(),
            source,
        },
    };
    let chosen = |path: &Path| -> Result<Goal, CliError> {
        let input = Input::of(path)?;
        let source = format!("the goal angles of {}", input.name.display());
        let angles = input.goal(&file.pattern)?;
        Ok(Goal::chosen(&file.pattern, angles, source))
    };
    let mut goal = match (&args.goal, args.fold, &args.crease[..]) {
        (Some(path), ..) => chosen(path)?,
        (None, Some(fraction), _) if !(0.0..=1.0).contains(&fraction) => {
            let text = format!("--fold: expected a fraction from 0 to 1, found {fraction}");
            return Err(CliError::Usage(text));
        }
        (None, Some(fraction), _) if fraction <= 0.0 => flat(&file.pattern),
        (None, Some(fraction), _) => Goal::of_letters(&file.pattern, fraction).map_err(bad)?,
        (None, None, []) => Goal::of_pattern(&file.pattern).map_err(bad)?,
        (None, None, driven) => {
            let driven = driven.iter().map(|driven| {
                let crease = crease(&file.pattern, "--crease", driven.edge)?;
                Ok((crease, driven.degrees.to_radians()))
            });
            let driven: Vec<_> = driven.collect::<Result<_, CliError>>()?;
            Goal::of_creases(&file.pattern, &driven).map_err(bad)?
        }
    };
    goal.via = args
        .via
        .iter()
        .map(|path| chosen(path))
        .collect::<Result<_, _>>()?;
    Ok(goal)
}

/// Returns the flat sheet as a goal. The path begins at the flat sheet, and with `--via` it goes back to it.
fn flat(pattern: &CreasePattern) -> Goal {
    let angles = vec![Some(0.0); pattern.creases().len()];
    Goal::chosen(pattern, angles, "the flat sheet".into())
}

/// Returns the limits of the hinges.
fn limits(args: &Plan, pattern: &CreasePattern) -> Result<Vec<HingeLimit>, CliError> {
    let limit = |limit: &crate::args::LimitedEdge| {
        Ok(HingeLimit {
            crease: crease(pattern, "--limit", limit.edge)?,
            lower: limit.lower.to_radians(),
            upper: limit.upper.to_radians(),
        })
    };
    args.limit.iter().map(limit).collect()
}

/// Returns a note for each limit that leaves its crease no room at all in the direction in which the crease is to turn.
/// No outcome says so.
fn held_flat(args: &Plan, pattern: &CreasePattern, goal: &Goal) -> Vec<String> {
    let note = |limit: &crate::args::LimitedEdge| {
        let edge = pattern.edges().get(limit.edge)?;
        let asked = goal.fold_angles[edge.crease?.index()];
        let (way, what) = match (edge.letter.sign(), asked) {
            (_, Some(asked)) if asked.abs() <= 0.0 => return None,
            (sign, _) if sign.abs() > 0.0 => (sign, format!("lettered {}", edge.letter.code())),
            (_, asked) => {
                let asked = asked?;
                (
                    asked,
                    format!("whose goal is {:.6} degrees", asked.to_degrees()),
                )
            }
        };
        let (room, side) = if way < 0.0 {
            (limit.lower < 0.0, "below")
        } else {
            (limit.upper > 0.0, "above")
        };
        (!room).then(|| {
            format!(
                "--limit: edge {}, {what}, turns to angles {side} 0, of which {}..{} degrees leave it none: it stays \
                 flat",
                limit.edge, limit.lower, limit.upper
            )
        })
    };
    args.limit.iter().filter_map(note).collect()
}

/// Returns the crease of an edge that an option names.
fn crease(pattern: &CreasePattern, option: &str, edge: usize) -> Result<CreaseId, CliError> {
    let found = pattern.edges().get(edge);
    found.and_then(|edge| edge.crease).ok_or_else(|| {
        let found = match found {
            Some(edge) => format!("it is lettered {}", edge.letter.code()),
            None => format!("edges go from 0 to {}", pattern.edges().len() - 1),
        };
        CliError::Hinge {
            text: format!("{option}: edge {edge}: expected a hinge between two faces, but {found}"),
            hint: nearest_hinge(pattern, edge),
        }
    })
}

fn summary(args: &Plan, planned: &Planned, json: &PlanJson<'_>) -> String {
    let Planned {
        file, goal, plan, ..
    } = planned;
    let outcome = outcome(plan.outcome == Outcome::Planned, json.outcome);
    let mut text = format!("{}: {outcome}\n", file.title);
    if let Some(reason) = &json.reason {
        text += &format!("  reason       {reason}\n");
        let attempts = json.attempts.iter();
        let tried: Vec<String> = attempts
            .map(|attempt| format!("{}: {}", attempt.strategy, attempt.outcome))
            .collect();
        text += &format!("  tried        {}\n", tried.join("; "));
    }
    if let Some(lost) = file.pattern.lost_lines() {
        text += &format!("  lost lines   {}\n", lost_lines(lost));
    }
    text += &format!(
        "  goal         {}\n  \
         sheet        {} creases, {} real vertices\n  \
         solved as    {} unknowns (crease groups), {} essential vertices\n",
        goal.source, json.creases, json.real_vertices, json.unknowns, json.essential_vertices,
    );
    let amplified = plan.amplification.map_or_else(
        || "how errors grow over the sheet is not known".to_string(),
        |factor| format!("errors grow up to {factor:.3}-fold over the sheet"),
    );
    text += &format!(
        "  tolerance    closure {:.1e} at each vertex: {amplified}\n",
        plan.essential_tolerance,
    );
    if json.knots > 0 {
        text += &format!(
            "  path         {} knots, {:.1} % of the way, {:.1e} degrees from the goal asked for\n  \
             rigidity     deformation {:.1e}, gap {:.1e}, closure {:.1e}\n",
            json.knots,
            100.0 * json.reached,
            json.goal_error,
            json.max_deformation,
            json.max_gap,
            json.max_closure,
        );
    }
    if json.max_bend > 0.0 {
        text += &format!(
            "  bend         panels bend by up to {:.2} degrees\n",
            json.max_bend
        );
    }
    if let Some(certified) = json.certified_deformation {
        text +=
            &format!("  certified    deformation and gap {certified:.1e} over the whole motion\n");
    }
    if plan.essential_faces > 0 {
        text += &format!(
            "  essential    {} faces, deformation {:.1e}, gap {:.1e}\n",
            plan.essential_faces, plan.essential_rigidity.deformation, plan.essential_rigidity.gap,
        );
    }
    text += &match args.collision {
        Switch::Off => "  crossings    not looked for\n".to_string(),
        Switch::On => {
            let clearance = json.min_clearance.map_or_else(String::new, |clearance| {
                format!("; smallest clearance {clearance:.3e}")
            });
            format!(
                "  crossings    {} pairs of faces over the motion, {} tested{clearance}\n",
                json.collision.pairs, json.collision.tested
            )
        }
    };
    if let Some(time) = &json.time {
        text += &format!(
            "  time         {:.2} ms: read {:.2}, symmetry {:.2}, solve {:.3}, fold {:.2}, collision \
         {:.2}, write {:.2}\n",
            1e3 * time.total,
            1e3 * time.read,
            1e3 * time.symmetry,
            1e3 * time.solve,
            1e3 * time.fold,
            1e3 * time.collision,
            1e3 * time.write,
        );
    }
    match (&args.output, plan.outcome) {
        (Some(output), outcome) if plan.motion.is_some() && is_written(args, outcome) => {
            text += &format!("  written to   {}\n", shown(output))
        }
        (Some(_), _) => text += "  nothing written\n",
        (None, Outcome::Planned) => text += "  not written; -o FILE writes it\n",
        _ => {}
    }
    text
}
