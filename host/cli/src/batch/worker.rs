//! A process that plans one design after the other: a line in, a line out.

use core::panic::AssertUnwindSafe;
use std::io::{Write, stdin, stdout};
use std::panic::{catch_unwind, set_hook};
use std::time::Instant;

use serde::Serialize;

use super::design::{Design, Parsed};
use crate::CliError;
use crate::args::Plan;
use crate::plan::{PlanJson, plan_input, told};
use crate::report::ErrorFields;
use foldpath::planner::Outcome;

/// A result.
#[derive(Serialize)]
struct Record<'a, T> {
    id: &'a str,
    #[serde(flatten)]
    answer: T,
}

#[derive(Serialize)]
struct Failed<'a> {
    error: ErrorFields<'a>,
}

/// Result of a design whose time was up, if nothing may depend on the clock.
#[derive(Serialize)]
struct TimedOut<'a> {
    version: &'static str,
    input: &'a crate::plan::InputJson,
    options: &'a Plan,
    outcome: &'static str,
}

/// Plans the designs on stdin until its end.
pub(super) fn run(timeout: f64, stable: bool) {
    // A panic is told in the result.
    set_hook(Box::new(|_| {}));
    let mut parsed = Parsed::default();
    for line in stdin().lines() {
        let Ok(line) = line else {
            return;
        };
        let result = result(&line, timeout, stable, &mut parsed);
        if writeln!(stdout().lock(), "{result}").is_err() {
            return;
        }
    }
}

/// Returns the result of a line, in one line.
fn result(line: &str, timeout: f64, stable: bool, parsed: &mut Parsed) -> String {
    let design = match Design::parse(line) {
        Ok(design) => design,
        Err(error) => {
            let id = super::design::id_of(line);
            return failed(&id, ErrorFields::of(&error));
        }
    };
    let work = AssertUnwindSafe(|| answered(&design, timeout, stable, parsed));
    match catch_unwind(work) {
        Ok(Ok(result)) => result,
        Ok(Err(error)) => failed(&design.id, ErrorFields::of(&error)),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            let text = format!("a defect of foldpath: {}", text.unwrap_or("panic"));
            failed(&design.id, ErrorFields::of_message(&text))
        }
    }
}

fn answered(
    design: &Design,
    timeout: f64,
    stable: bool,
    parsed: &mut Parsed,
) -> Result<String, CliError> {
    let start = Instant::now();
    let (input, args) = design.arguments(timeout, parsed)?;
    let planned = plan_input(&args, input)?;
    let mut answer: PlanJson<'_> = told(&args, &planned, start);
    if !stable {
        return Ok(text(&design.id, &answer));
    }
    answer.leave_out_times();
    // Some strategies may have had no time, whatever the best of the others found.
    let is_up = args
        .timeout
        .is_some_and(|timeout| start.elapsed().as_secs_f64() >= timeout);
    if is_up || planned.ran_out_of_time() {
        let bare = TimedOut {
            version: answer.version,
            input: answer.input,
            options: &args,
            outcome: Outcome::Timeout.name(),
        };
        return Ok(text(&design.id, &bare));
    }
    Ok(text(&design.id, &answer))
}

/// Returns the result of a design that could not be planned, in one line.
pub(super) fn failed(id: &str, error: ErrorFields<'_>) -> String {
    text(id, &Failed { error })
}

fn text(id: &str, answer: &impl Serialize) -> String {
    serde_json::to_string(&Record { id, answer }).unwrap_or_default()
}
