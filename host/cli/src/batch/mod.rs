//! Runs `foldpath batch`, which plans many designs: JSON lines in, JSON lines out.
//!
//! - `design.rs`: a line that is read, and the plan that it asks for.
//! - `worker.rs`: a process that plans one design after the other. A design that ends its process, or hangs, ends nothing
//!   else.
//! - `pool.rs`: the workers, with the time that each may take.
//! - `results.rs`: the file of results, in the order of the designs, and going on with it after an interruption.

mod design;
mod pool;
mod results;
mod worker;

use core::time::Duration;
use std::ffi::OsString;
use std::fs::File;
use std::io::{BufRead, BufReader, IsTerminal, stderr, stdin};
use std::path::Path;

use indicatif::ProgressBar;

use crate::args::Batch;
use crate::progress::{PATIENCE, set_style};
use crate::standard::{is_standard, print_summary, shown};
use crate::values::Shard;
use crate::{Answer, CliError, check_output};
use design::Designs;
use foldpath::read::FileError;
use results::Results;

pub use worker::record;

/// Runs the command. `program` starts it once more, for the processes that plan: a program and its first arguments.
pub(crate) fn run(args: &Batch, quiet: bool, program: &[OsString]) -> Answer {
    if args.worker {
        worker::run(args.timeout, args.stable);
        return Ok(true);
    }
    if !(args.timeout > 0.0 && Duration::try_from_secs_f64(args.timeout).is_ok()) {
        let text = format!(
            "--timeout: expected seconds above 0, found {}",
            args.timeout
        );
        return Err(CliError::Usage(text));
    }
    let resume = args.resume || args.retry_errors;
    if resume && is_standard(&args.output) {
        let option = match args.resume {
            true => "--resume",
            false => "--retry-errors",
        };
        let text = format!("{option}: expected -o to name a file, found -");
        return Err(CliError::Usage(text));
    }
    check_output("-o", &args.output, [&args.designs])?;
    let bar = bar(args, quiet)?;
    let mut designs = open(&args.designs)?;
    // Designs that cannot be read leave the results that are there.
    let begin = designs.fill_buf().map_err(FileError::io(&args.designs))?;
    let mark = "\u{feff}".as_bytes();
    if begin.starts_with(mark) {
        designs.consume(mark.len());
    }
    let mut results = Results::open(&args.output, resume, args.retry_errors)?;
    let skipped = results.known();
    let taken = [args.designs.as_path(), args.output.as_path()];
    let designs = Designs::new(designs, args.shard, results.take_ids(), taken);
    let jobs = match args.jobs {
        Some(jobs) => jobs.get().into(),
        None => std::thread::available_parallelism().map_or(1, usize::from),
    };
    let limits = pool::Limits {
        jobs,
        timeout: args.timeout,
        stable: args.stable,
        program,
    };
    let counts = pool::run(designs, results, &limits, &bar)?;
    bar.finish_and_clear();
    let mut text = format!(
        "{} designs, written to {}\n",
        counts.total(),
        shown(&args.output)
    );
    for (outcome, count) in counts.by_outcome() {
        text += &format!("  {count:>9} {outcome}\n");
    }
    if skipped > 0 {
        text += &format!("  {skipped:>9} there before\n");
    }
    print_summary(Some(&args.output), quiet, &text)?;
    Ok(true)
}

/// Opens the designs for reading.
fn open(path: &Path) -> Result<Box<dyn BufRead + Send>, CliError> {
    if is_standard(path) {
        return Ok(Box::new(BufReader::new(stdin())));
    }
    let file = File::open(path).map_err(FileError::io(path))?;
    Ok(Box::new(BufReader::new(file)))
}

/// Returns a bar with rate and time to go, which is hidden unless stderr is a terminal.
fn bar(args: &Batch, quiet: bool) -> Result<ProgressBar, CliError> {
    if quiet || !stderr().is_terminal() {
        return Ok(ProgressBar::hidden());
    }
    let Shard { of, .. } = args.shard.unwrap_or_default();
    let (bar, template) = match lines(&args.designs)? {
        Some(lines) => (
            ProgressBar::new(lines / u64::from(of)),
            "{spinner} {elapsed} [{bar:30}] {pos}/{len} designs, {per_sec}, {eta} to go",
        ),
        None => (
            ProgressBar::new_spinner(),
            "{spinner} {elapsed} {pos} designs, {per_sec}",
        ),
    };
    set_style(&bar, template);
    bar.enable_steady_tick(PATIENCE);
    Ok(bar)
}

/// Counts the lines of a file; `None` for stdin and for pipes.
fn lines(path: &Path) -> Result<Option<u64>, CliError> {
    if is_standard(path) || !path.is_file() {
        return Ok(None);
    }
    let (mut file, mut count) = (open(path)?, 0);
    while file.skip_until(b'\n').map_err(FileError::io(path))? > 0 {
        count += 1;
    }
    Ok(Some(count))
}
