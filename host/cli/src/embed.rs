//! The command inside another program, as in the Python package: reading, planning, writing and errors are those of the
//! command line, text by text.

use std::ffi::OsString;
use std::path::Path;

use clap::Parser;

pub use crate::CliError;
use crate::args::{Cli, Command, Export};
pub use crate::batch::record as plan_line;
use crate::export;
pub use crate::output::write_whole as write_file;
use crate::output::write_whole_with;
pub use crate::report::{ErrorFields, panic_text, plain_text};
pub use crate::standard::Input as Source;
pub use crate::unfold::{Unfolded, unfolded};
use foldpath::export::fold::write_motion;
use foldpath::motion::Motion;
use foldpath::pattern::CreasePattern;
use foldpath::read::fold::{GoalFrames, PatternFile};
use foldpath::request::{PlanRequest, PlanTask};

/// Returns goal and options of a request; goals that it names are read from files. `name` is that of the pattern's file.
/// Knots keep the positions of vertices, as those of a path that is written.
///
/// # Errors
/// If an option is out of its range, or a goal cannot be read.
pub fn task(request: &PlanRequest, name: &Path, file: &PatternFile) -> Result<PlanTask, CliError> {
    let read_goal = |path: &Path, pattern: &CreasePattern, frames: GoalFrames| {
        Source::of_file(path).named_goals(pattern, frames)
    };
    request.task(name, file, true, read_goal)
}

/// Writes a path, whole or not at all.
///
/// # Errors
/// If the system refuses.
pub fn write_path(motion: &Motion, path: &Path) -> Result<(), CliError> {
    write_whole_with(path, |mut out| write_motion(motion, &mut out))
}

/// Exports a motion. `arguments` are those of `foldpath export` without the path.
///
/// # Errors
/// If the command refuses.
pub fn export_motion(motion: &Motion, name: &Path, arguments: &[OsString]) -> Result<(), CliError> {
    let all = ["foldpath", "export", "-"].map(OsString::from);
    let all = all.iter().chain(arguments);
    let cli = Cli::try_parse_from(all).map_err(|error| CliError::Usage(usage_text(&error)))?;
    match cli.command {
        Command::Export(args) => {
            let args: Export = args;
            export::motion(&args, motion, name)
        }
        _ => Err(CliError::Usage("expected arguments of export".into())),
    }
}

/// Returns the first paragraph of a message of clap, which says what is wrong; the others are about the command line.
fn usage_text(error: &clap::Error) -> String {
    let text = error.to_string();
    let text = text.trim_start_matches("error: ");
    text.split("\n\n").next().unwrap_or_default().into()
}
