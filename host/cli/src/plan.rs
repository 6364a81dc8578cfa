//! Runs `foldpath plan`, which plans a path and writes it.

use core::time::Duration;
use std::path::PathBuf;
use std::time::Instant;

use crate::args;
use crate::output::write_whole_with;
use crate::progress::watched;
use crate::report::{lost_lines, outcome};
use crate::standard::{Input, print_summary, shown};
use crate::{Answer, CliError, check_output, hints, print_json, print_notes, say};
use foldpath::export::fold::write_motion;
use foldpath::planner::{Outcome, Plan};
use foldpath::progress::{Progress, Stage};
use foldpath::read::fold::PatternFile;
use foldpath::request::{InputJson, PlanJson, PlanRequest, Planned, Request, Switch};

pub(crate) fn run(args: &args::Plan, quiet: bool) -> Answer {
    let start = Instant::now();
    let job = Job {
        request: args.request.get()?.clone(),
        pattern: args.pattern.clone(),
        output: args.output.clone(),
        json: args.report.json,
    };
    job.check()?;
    let done = watched(&args.report, quiet, |progress| {
        job.run(None, quiet, progress)
    })?;
    let json = done.json(&job, Some(start));
    print_notes(quiet, &json.notes);
    let plan = &done.planned.plan;
    if !quiet {
        let hints = hints::of_plan(plan, &job.request, &done.file.pattern);
        (hints.iter()).for_each(|hint| say(&format!("help: {hint}")));
    }
    if job.json {
        print_json(&json)?;
    } else {
        let text = summary(&job, &done, &json);
        print_summary(args.output.as_deref(), quiet, &text)?;
    }
    Ok(done.planned.plan.outcome == Outcome::Planned)
}

/// A request with its files.
pub(crate) struct Job {
    pub(crate) request: PlanRequest,
    /// File with the pattern.
    pub(crate) pattern: PathBuf,
    /// File to write the path to.
    pub(crate) output: Option<PathBuf>,
    /// `true` if the answer is JSON, which names a digest of the pattern.
    pub(crate) json: bool,
}

/// Pattern that was read, the plan, and the times that reading and writing took.
pub(crate) struct Done {
    pub(crate) input: InputJson,
    file: PatternFile,
    pub(crate) planned: Planned,
    read: Duration,
    write: Duration,
}

impl Job {
    /// Checks that the options and the file to write are valid.
    pub(crate) fn check(&self) -> Result<(), CliError> {
        self.request.options()?;
        if let Some(output) = &self.output {
            let inputs = [&self.pattern].into_iter().chain(self.request.goal_files());
            check_output("-o", output, inputs)?;
        }
        Ok(())
    }

    /// Reads the pattern, from `source` if it is found there, and the goal. Plans, and writes the path if it reaches the
    /// goal.
    pub(crate) fn run(
        &self,
        source: Option<Input>,
        quiet: bool,
        progress: &Progress,
    ) -> Result<Done, CliError> {
        progress.begin(Stage::Reading);
        let start = Instant::now();
        let reading = self.request.reading.options()?;
        let source = source.map_or_else(|| Input::of(&self.pattern), Ok)?;
        let bytes = source.bytes()?;
        let input = InputJson::of(&source.name, self.json.then_some(&*bytes));
        let file = source.pattern(&bytes, &reading)?;
        drop(bytes);
        let task = self
            .request
            .task(
                &source.name,
                &file,
                self.output.is_some(),
                |path, pattern, frames| Input::of(path)?.named_goals(pattern, frames),
            )
            // A drawing whose creases were left out may have no goal.
            .inspect_err(|_| {
                print_notes(quiet, file.pattern.repairs());
                print_notes(quiet, file.pattern.assumptions());
            })?;
        let read = start.elapsed();
        // The time that is allowed is that of the whole command.
        let planned = task.run(&file, read, progress);
        progress.begin(Stage::Writing);
        let start = Instant::now();
        if let (Some(motion), Some(output)) = (&planned.plan.motion, &self.output)
            && self.is_written(planned.plan.outcome)
        {
            write_whole_with(output, |mut out| write_motion(motion, &mut out))?;
        }
        Ok(Done {
            input,
            file,
            planned,
            read,
            write: start.elapsed(),
        })
    }

    /// Returns `true` if the path of a plan with this outcome is written.
    fn is_written(&self, outcome: Outcome) -> bool {
        self.request.keep || outcome == Outcome::Planned
    }
}

impl Done {
    /// Returns the answer for `--json`. `start` is when the work began; without it, the answer has no times.
    pub(crate) fn json<'a>(&'a self, job: &'a Job, start: Option<Instant>) -> PlanJson<'a> {
        let times = start.map(|start| [self.read, self.write, start.elapsed()]);
        PlanJson::of(&self.planned, &job.request, &self.input, &self.file, times)
    }
}

fn summary(job: &Job, done: &Done, json: &PlanJson<'_>) -> String {
    let Done { file, planned, .. } = done;
    let outcome = outcome(planned.plan.outcome == Outcome::Planned, json.outcome);
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
    text += &problem_in_words(planned, json);
    text += &path_in_words(&planned.plan, json);
    for (number, order) in (1..).zip(json.orders.iter().flatten()) {
        text += &format!("  {:12} {order}\n", format!("order {number}"));
    }
    text += &match job.request.collision {
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
    text + &written_in_words(job, &planned.plan)
}

/// Describes the sheet, the goal and the equations.
fn problem_in_words(Planned { goal, plan, .. }: &Planned, json: &PlanJson<'_>) -> String {
    let amplified = plan.reduced.amplification.map_or_else(
        || "how errors grow over the sheet is not known".to_string(),
        |factor| format!("errors grow up to {factor:.3}-fold over the sheet"),
    );
    format!(
        "  goal         {}\n  \
         sheet        {} creases, {} real vertices\n  \
         solved as    {} unknowns (crease groups), {} essential vertices\n  \
         tolerance    closure {:.1e} at each vertex: {amplified}\n",
        goal.source,
        json.creases,
        json.real_vertices,
        json.unknowns,
        json.essential_vertices,
        plan.reduced.closure_tolerance,
    )
}

/// Describes the path and its errors.
fn path_in_words(plan: &Plan, json: &PlanJson<'_>) -> String {
    let mut text = String::new();
    if json.knots > 0 {
        text += &format!(
            "  path         {} knots, {:.1} % of the way, {:.1e} degrees from the goal asked for\n  \
             rigidity     deformation {:.1e}, gap {:.1e}, closure {:.1e}\n",
            json.knots,
            plan.percent(),
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
    if plan.errors.essential_faces > 0 {
        text += &format!(
            "  essential    {} faces, deformation {:.1e}, gap {:.1e}\n",
            plan.errors.essential_faces,
            plan.errors.essential_rigidity.deformation,
            plan.errors.essential_rigidity.gap,
        );
    }
    text
}

/// Says if the path was written, and where.
fn written_in_words(job: &Job, plan: &Plan) -> String {
    match (&job.output, plan.outcome) {
        (Some(output), outcome) if plan.motion.is_some() && job.is_written(outcome) => {
            format!("  written to   {}\n", shown(output))
        }
        (Some(_), _) => "  nothing written\n".into(),
        (None, Outcome::Planned) => "  not written; -o FILE writes it\n".into(),
        _ => String::new(),
    }
}
