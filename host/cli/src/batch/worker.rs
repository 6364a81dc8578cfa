//! A process that plans one design after the other: a line in, a line out.

use core::panic::AssertUnwindSafe;
use std::io::{Write, stdin, stdout};
use std::panic::{catch_unwind, set_hook};
use std::time::Instant;

use serde::Serialize;
use serde_json::{Map, Value};

use super::design::{Design, given, id_of};
use crate::CliError;
use crate::report::{ErrorFields, ErrorJson, panic_text};
use foldpath::planner::Outcome;
use foldpath::progress::Progress;
use foldpath::request::{FiguresJson, InputJson, PlanJson, PlanRequest};

/// A result.
#[derive(Serialize)]
struct Record<'a, T> {
    id: &'a str,
    /// The design as it was given, without its id.
    #[serde(skip_serializing_if = "Option::is_none")]
    design: Option<&'a Map<String, Value>>,
    #[serde(flatten)]
    answer: T,
}

/// A plan, and the figures of its motion, if one was found.
#[derive(Serialize)]
struct Ranked<'a> {
    #[serde(flatten)]
    plan: PlanJson<'a>,
    figures: Option<FiguresJson>,
}

/// Result of a design whose time was up, if nothing may depend on the clock.
#[derive(Serialize)]
struct TimedOut<'a> {
    version: &'static str,
    input: &'a InputJson,
    options: &'a PlanRequest,
    outcome: &'static str,
}

/// Plans the designs on stdin until its end.
pub(super) fn run(timeout: f64, stable: bool) {
    // A panic is told in the result.
    set_hook(Box::new(|_| {}));
    for line in stdin().lines() {
        let Ok(line) = line else {
            return;
        };
        let result = record(&line, timeout, stable, &Progress::new());
        if writeln!(stdout().lock(), "{result}").is_err() {
            return;
        }
    }
}

/// Plans the design of one line of `foldpath batch` and returns its result, in one line. A panic is a result. `timeout`
/// (seconds) holds for a design that names none. With `stable`, what depends on the clock is left out.
#[must_use]
pub fn record(line: &str, timeout: f64, stable: bool, progress: &Progress) -> String {
    let given = given(line);
    let given = given.as_ref();
    let design = match Design::parse(line) {
        Ok(design) => design,
        Err(error) => return failed(&id_of(line), given, ErrorFields::of(&error)),
    };
    let work = AssertUnwindSafe(|| answered(&design, given, timeout, stable, progress));
    match catch_unwind(work) {
        Ok(Ok(result)) => result,
        Ok(Err(error)) => failed(&design.id, given, ErrorFields::of(&error)),
        Err(panic) => {
            let text = panic_text(&*panic);
            failed(&design.id, given, ErrorFields::of_message(&text))
        }
    }
}

fn answered(
    design: &Design,
    given: Option<&Map<String, Value>>,
    timeout: f64,
    stable: bool,
    progress: &Progress,
) -> Result<String, CliError> {
    let start = Instant::now();
    let (input, job) = design.job(timeout)?;
    job.check()?;
    let done = job.run(Some(input), true, progress)?;
    let answer = done.json(&job, (!stable).then_some(start));
    // Some strategies may have had no time, whatever the best of the others found.
    let is_up = job
        .request
        .check
        .timeout
        .is_some_and(|timeout| start.elapsed().as_secs_f64() >= timeout);
    if stable && (is_up || done.planned.ran_out_of_time()) {
        let bare = TimedOut {
            version: answer.version,
            input: answer.input,
            options: &job.request,
            outcome: Outcome::Timeout.name(),
        };
        return Ok(text(&design.id, given, &bare));
    }
    let motion = done.planned.plan.motion.as_ref();
    let ranked = Ranked {
        plan: answer,
        figures: motion.map(FiguresJson::of),
    };
    Ok(text(&design.id, given, &ranked))
}

/// Returns the result of a design that could not be planned, in one line.
pub(super) fn failed(
    id: &str,
    design: Option<&Map<String, Value>>,
    error: ErrorFields<'_>,
) -> String {
    text(id, design, &ErrorJson { error })
}

fn text(id: &str, design: Option<&Map<String, Value>>, answer: &impl Serialize) -> String {
    serde_json::to_string(&Record { id, design, answer }).unwrap_or_default()
}
