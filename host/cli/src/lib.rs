//! The command `foldpath`: it reads arguments, prints text or JSON, and returns an exit status.
//!
//! Code that needs a terminal, a process or a serial port is here. Planning and judging are in the library,
//! [`foldpath`].

pub mod embed;
pub mod link;

mod args;
mod batch;
mod check;
mod complete;
mod drive;
mod export;
mod foldability;
mod fonts;
mod generate;
mod hints;
mod info;
mod jobs;
mod key;
mod loads;
mod log;
mod options;
mod output;
mod pair;
mod plan;
mod plot;
mod png;
mod progress;
mod reach;
mod report;
mod sim;
mod standard;
mod stream;
mod tolerance;
mod unfold;
mod values;
mod view;

use std::ffi::OsString;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use serde::Serialize;
use thiserror::Error;

use foldpath::read::FileError;
use foldpath::request::RequestError;

/// Bad input or usage: exit status 2.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "its texts say it")]
pub enum CliError {
    #[error(transparent)]
    File(#[from] FileError),
    /// An error about stdin, with the bytes that were read.
    #[error("{error}")]
    Piped {
        error: Box<FileError>,
        bytes: Vec<u8>,
    },
    #[error("stdout: {0}")]
    Output(std::io::Error),
    #[error("{}", options::on_command_line(.0))]
    Request(#[from] RequestError),
    #[error("{0}")]
    Usage(String),
}

/// Answer of a command that ran well: `true` if the work is done, `false` if the answer is no.
type Answer = Result<bool, CliError>;

/// Runs the command line of this process. Returns exit status 0 if the work is done, 1 if the answer is no, and 2 for
/// bad input or usage.
#[must_use]
pub fn main() -> ExitCode {
    let program = std::env::current_exe().map(|program| vec![program.into_os_string()]);
    let arguments = std::env::args_os().collect();
    run_command(arguments, &program.unwrap_or_default()).into()
}

/// Runs the command with these arguments, the first of which is its name, and returns its exit status. `program` starts
/// the command once more: a program and its first arguments.
#[must_use]
pub fn run_command(arguments: Vec<OsString>, program: &[OsString]) -> u8 {
    let wants_json = arguments.iter().any(|argument| argument == "--json");
    let cli = match args::Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => return usage(&error, wants_json),
    };
    let (quiet, json) = (cli.quiet, wants_json);
    let answer =
        standard::check_use(&cli.command, json).and_then(|()| run(cli.command, quiet, program));
    match answer {
        Ok(true) => 0,
        Ok(false) => 1,
        Err(error) => {
            report::tell(&error);
            if json {
                report::tell_json(&error);
            }
            2
        }
    }
}

fn run(command: args::Command, quiet: bool, program: &[OsString]) -> Answer {
    match command {
        args::Command::Generate(args) => generate::run(&args, quiet),
        args::Command::Info(args) => info::run(&args, quiet),
        args::Command::Plan(args) => args.jobs.run(|| plan::run(&args, quiet)),
        args::Command::Check(args) => args.jobs.run(|| check::run(&args, quiet)),
        args::Command::Tolerance(args) => args.jobs.run(|| tolerance::run(&args, quiet)),
        args::Command::Loads(args) => args.jobs.run(|| loads::run(&args, quiet)),
        args::Command::Unfold(args) => unfold::run(&args, quiet),
        args::Command::View(args) => view::run(&args, quiet),
        args::Command::Plot(args) => plot::run(&args, quiet),
        args::Command::Export(args) => export::run(&args, quiet),
        args::Command::Batch(args) => batch::run(&args, quiet, program),
        args::Command::Stream(args) => stream::run(&args, quiet),
        args::Command::Drive(args) => drive::run(&args, quiet),
        args::Command::Pair(args) => pair::run(&args, quiet),
        args::Command::Sim(args) => sim::run(&args, quiet),
        args::Command::Completions { shell } => complete::completions(shell),
        args::Command::Man { output } => complete::man(output.as_deref()),
    }
}

/// Prints what is wrong with the arguments, or the help or version that they ask for.
fn usage(error: &clap::Error, wants_json: bool) -> u8 {
    let _gone = error.print();
    if !error.use_stderr() {
        return 0;
    }
    if wants_json {
        report::tell_usage_json(&error.to_string());
    }
    2
}

/// Checks that the output file, named by `option`, is none of the input files. Stdout is no file.
fn check_output<'a>(
    option: &str,
    output: &Path,
    inputs: impl IntoIterator<Item = &'a PathBuf>,
) -> Result<(), CliError> {
    if standard::is_standard(output) {
        return Ok(());
    }
    let Ok(found) = output.canonicalize() else {
        return Ok(());
    };
    let same = |input: &PathBuf| input.canonicalize().is_ok_and(|input| input == found);
    if inputs.into_iter().any(same) {
        let output = output.display();
        return Err(CliError::Usage(format!(
            "{option}: {output} is an input file, expected another"
        )));
    }
    Ok(())
}

/// Prints to stdout, with colours if stdout is a terminal.
fn print(text: &str) -> Result<(), CliError> {
    print_to(anstream::stdout().lock(), text.as_bytes())
}

/// Writes the bytes unchanged. A reader that has closed its end of a pipe is no error.
fn print_to(mut out: impl Write, bytes: &[u8]) -> Result<(), CliError> {
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Output(error)),
        _ => Ok(()),
    }
}

fn print_json(value: &impl Serialize) -> Result<(), CliError> {
    let text = serde_json::to_string(value).unwrap_or_default();
    print_to(std::io::stdout().lock(), (text + "\n").as_bytes())
}

/// Prints a line on stderr. A failure to write is ignored.
fn say(line: &str) {
    let _gone = writeln!(std::io::stderr(), "{line}");
}

fn print_notes(quiet: bool, notes: &[impl core::fmt::Display]) {
    for note in notes.iter().filter(|_| !quiet) {
        say(&format!("note: {note}"));
    }
}
