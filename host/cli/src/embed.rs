//! The command inside another program, as in the Python package: reading, planning, writing and errors are those of the
//! command line, text by text.

use std::ffi::OsString;
use std::path::Path;

use clap::Parser;

use crate::args::{Cli, Command, Export};
use crate::batch::record;
use crate::output::{write_whole, write_whole_with};
pub use crate::report::panic_text;
use crate::report::{ErrorFields, plain_text};
use crate::standard::Input;
use crate::{CliError, export};
use foldpath::export::fold::write_motion;
use foldpath::motion::Motion;
use foldpath::pattern::CreasePattern;
use foldpath::progress::Progress;
use foldpath::read::FileError;
use foldpath::read::fold::PatternFile;
use foldpath::request::{Family, PlanRequest, PlanTask, ReadingRequest, Request, RequestError};

/// Bad input or usage, in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The whole text that the command prints, without its name and colours: what is wrong, the place in the file, and a
    /// hint.
    pub text: String,
    /// The file that it is about; empty if it is about options.
    pub file: String,
    /// Line in the file, from 1.
    pub line: Option<usize>,
    /// Column in the line, from 1.
    pub column: Option<usize>,
    /// Advice on correcting it, if there is any.
    pub hint: Option<String>,
}

impl From<CliError> for Refusal {
    fn from(error: CliError) -> Self {
        let text = plain_text(&error);
        let ErrorFields {
            file,
            line,
            column,
            hint,
            ..
        } = ErrorFields::of(&error);
        Self {
            text,
            file,
            line,
            column,
            hint,
        }
    }
}

impl From<RequestError> for Refusal {
    fn from(error: RequestError) -> Self {
        CliError::from(error).into()
    }
}

impl From<FileError> for Refusal {
    fn from(error: FileError) -> Self {
        CliError::from(error).into()
    }
}

/// A file to read, or bytes.
pub struct Source {
    input: Input,
}

impl Source {
    /// Names a file.
    #[must_use]
    pub fn file(path: &Path) -> Self {
        let input = Input::of_file(path);
        Self { input }
    }

    /// Takes bytes, whose format is found from their content. `name` stands for them in messages.
    ///
    /// # Errors
    /// If there are too many bytes for a file of their format.
    pub fn bytes(name: &str, bytes: &[u8]) -> Result<Self, Refusal> {
        let input = Input::of_stream(name, bytes)?;
        Ok(Self { input })
    }

    /// Returns the pattern of a family, as a FOLD file that was never written.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn family(family: &Family) -> Result<Self, Refusal> {
        let input = Input::of_family(family)?;
        Ok(Self { input })
    }

    /// Returns the name in messages.
    #[must_use]
    pub fn name(&self) -> &Path {
        &self.input.name
    }

    /// Returns the bytes of a crease pattern.
    ///
    /// # Errors
    /// If the file cannot be read, or is too large.
    pub fn pattern_bytes(&self) -> Result<Vec<u8>, Refusal> {
        Ok(self.input.bytes()?.into_owned())
    }

    /// Parses a crease pattern from the bytes of this source.
    ///
    /// # Errors
    /// If they hold no crease pattern, or an option is out of its range.
    pub fn pattern(&self, bytes: &[u8], reading: &ReadingRequest) -> Result<PatternFile, Refusal> {
        let options = reading.options()?;
        Ok(self.input.pattern(bytes, &options)?)
    }

    /// Reads a motion.
    ///
    /// # Errors
    /// If the source holds no motion.
    pub fn motion(&self) -> Result<Motion, Refusal> {
        Ok(self.input.motion()?)
    }
}

/// Returns goal and options of a request; goals that it names are read from files. `name` is that of the pattern's file.
/// Knots keep the positions of vertices, as those of a path that is written.
///
/// # Errors
/// If an option is out of its range, or a goal cannot be read.
pub fn task(request: &PlanRequest, name: &Path, file: &PatternFile) -> Result<PlanTask, Refusal> {
    let read_goal = |path: &Path, pattern: &CreasePattern| Input::of_file(path).named_goal(pattern);
    Ok(request.task(name, file, true, read_goal)?)
}

/// Writes a path, whole or not at all.
///
/// # Errors
/// If the system refuses.
pub fn write_path(motion: &Motion, path: &Path) -> Result<(), Refusal> {
    Ok(write_whole_with(path, |out| write_motion(motion, out))?)
}

/// Writes a file, whole or not at all.
///
/// # Errors
/// If the system refuses.
pub fn write_file(path: &Path, content: &[u8]) -> Result<(), Refusal> {
    Ok(write_whole(path, content)?)
}

/// Exports a motion. `arguments` are those of `foldpath export` without the path.
///
/// # Errors
/// If the command refuses.
pub fn export_motion(motion: &Motion, name: &Path, arguments: &[OsString]) -> Result<(), Refusal> {
    let all = ["foldpath", "export", "-"].map(OsString::from);
    let all = all.iter().chain(arguments);
    let cli = Cli::try_parse_from(all).map_err(|error| CliError::Usage(usage_text(&error)))?;
    match cli.command {
        Command::Export(args) => {
            let args: Export = args;
            Ok(export::motion(&args, motion, name)?)
        }
        _ => Err(CliError::Usage("expected arguments of export".into()).into()),
    }
}

/// Returns the first paragraph of a message of clap, which says what is wrong; the others are about the command line.
fn usage_text(error: &clap::Error) -> String {
    let text = error.to_string();
    let text = text.trim_start_matches("error: ");
    text.split("\n\n").next().unwrap_or_default().into()
}

/// Plans the design of one line of `foldpath batch` and returns its result, in one line. `timeout` (seconds) holds for
/// a design that names none. With `stable`, what depends on the clock is left out.
#[must_use]
pub fn plan_line(line: &str, timeout: f64, stable: bool, progress: &Progress) -> String {
    record(line, timeout, stable, progress)
}

/// Runs the command with these arguments, the first of which is its name, and returns its exit status. `program` starts
/// it once more: a program and its first arguments.
#[must_use]
pub fn run(arguments: Vec<OsString>, program: &[OsString]) -> u8 {
    crate::run_command(arguments, program)
}
