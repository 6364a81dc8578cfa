//! Standard streams: `-` stands for stdin where a file is read, and for stdout where one is written.

use std::borrow::Cow;
use std::io::stdin;
use std::path::{Path, PathBuf};

use crate::args::{Command, Plot, View};
use crate::{CliError, print, say};
use foldpath::export::fold::pattern_text;
use foldpath::motion::Motion;
use foldpath::pattern::CreasePattern;
use foldpath::read::fold::{GoalFrames, PatternFile, parse_goals, parse_motion};
use foldpath::read::{
    FileError, Format, JointNames, ReadOptions, ShapeFile, parse_drives, parse_pattern_with,
    parse_shape, read_file, read_stream,
};
use foldpath::request::{NamedGoals, generate};
use foldpath::sensitivity::Drive;
use foldpath::stream::parse_script;
use foldpath_firmware_sim::hinges::Trouble;
use serde_json::{Map, Value};

/// Name of stdin in messages.
const STDIN: &str = "<stdin>";

/// Returns `true` if the name of a file stands for a standard stream.
pub(crate) fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Returns the name that messages give the file that is read.
pub(crate) fn source(path: &Path) -> Cow<'_, str> {
    if is_standard(path) {
        STDIN.into()
    } else {
        path.to_string_lossy()
    }
}

/// Returns the name that messages give the file that is written.
pub(crate) fn shown(path: &Path) -> Cow<'_, str> {
    if is_standard(path) {
        "<stdout>".into()
    } else {
        path.to_string_lossy()
    }
}

/// Returns `true` if the name of a file in a message stands for stdin.
pub(crate) fn is_stdin(path: &Path) -> bool {
    path.as_os_str() == STDIN
}

/// Returns the name on the command line of a file in a message.
pub(crate) fn argument(path: &Path) -> &Path {
    if is_stdin(path) { Path::new("-") } else { path }
}

/// A file that is read, or stdin, which can be read only once.
pub struct Input {
    /// Name for messages.
    pub name: PathBuf,
    /// The bytes of stdin with their format; `None` for a file.
    piped: Option<(Vec<u8>, Format)>,
}

/// Key of the frames of a FOLD file.
const FRAMES: &str = "file_frames";

impl Input {
    /// Names a file, or reads stdin.
    ///
    /// # Errors
    /// If stdin cannot be read or is too large.
    pub(crate) fn of(path: &Path) -> Result<Self, CliError> {
        if !is_standard(path) {
            return Ok(Self::of_file(path));
        }
        let name = PathBuf::from(STDIN);
        let piped = Some(read_stream(&name, stdin().lock())?);
        Ok(Self { name, piped })
    }

    /// Names a file.
    #[must_use]
    pub fn of_file(path: &Path) -> Self {
        let name = path.to_path_buf();
        Self { name, piped: None }
    }

    /// Takes bytes, and finds their format.
    ///
    /// # Errors
    /// If there are too many bytes for a file of their format.
    pub fn of_stream(name: &str, bytes: &[u8]) -> Result<Self, CliError> {
        let name = PathBuf::from(name);
        let piped = Some(read_stream(&name, bytes)?);
        Ok(Self { name, piped })
    }

    /// Takes the pattern of a family, as a FOLD file that was never written.
    ///
    /// # Errors
    /// If there is no such family, or a parameter is none of the family's or out of its range.
    pub fn of_family(family: &Map<String, Value>) -> Result<Self, CliError> {
        let (title, drawing) = generate(family)?;
        let bytes = pattern_text(&title, &drawing).into_bytes();
        Ok(Self {
            name: format!("generate {title}").into(),
            piped: Some((bytes, Format::Fold)),
        })
    }

    /// Returns the bytes, of a file of any format.
    ///
    /// # Errors
    /// If the file cannot be read, or is too large.
    pub fn bytes(&self) -> Result<Cow<'_, [u8]>, CliError> {
        match &self.piped {
            Some((bytes, _)) => Ok(bytes.into()),
            None => Ok(read_file(&self.name)?.into()),
        }
    }

    /// Parses the bytes. An error has those that cannot be read again.
    fn parsed<T>(
        &self,
        parse: impl FnOnce(&Path, &[u8]) -> Result<T, FileError>,
    ) -> Result<T, CliError> {
        self.parsed_from(&self.bytes()?, parse)
    }

    fn parsed_from<T>(
        &self,
        bytes: &[u8],
        parse: impl FnOnce(&Path, &[u8]) -> Result<T, FileError>,
    ) -> Result<T, CliError> {
        parse(&self.name, bytes).map_err(|error| match &self.piped {
            None => error.into(),
            Some((bytes, _)) => CliError::Piped {
                error: Box::new(error),
                bytes: bytes.clone(),
            },
        })
    }

    fn format(&self) -> Format {
        let found = self.piped.as_ref().map(|(_, format)| *format);
        found.unwrap_or_else(|| Format::of_name(&self.name))
    }

    /// Parses a crease pattern from the bytes of this input.
    ///
    /// # Errors
    /// If they hold no crease pattern.
    pub fn pattern(&self, bytes: &[u8], options: &ReadOptions) -> Result<PatternFile, CliError> {
        let options = options.clone().with(|it| it.format = Some(self.format()));
        self.parsed_from(bytes, |name, bytes| {
            parse_pattern_with(name, bytes, &options)
        })
    }

    /// Reads a motion. `user` names what needs it, if the file is one of another format.
    pub(crate) fn motion_for(&self, user: &str) -> Result<Motion, CliError> {
        let (format, motion) = (self.format(), self.motion());
        if motion.is_ok() || format == Format::Fold {
            return motion;
        }
        self.parsed(|name, _| {
            Err(FileError::Expected {
                path: name.to_path_buf(),
                place: "the file".into(),
                expected: format!("a path, which {user} needs"),
                found: format.described(),
            })
        })
    }

    /// Returns `true` if the error of reading a motion is that the file is none, as a crease pattern is, rather than that the
    /// motion is wrong.
    pub(crate) fn has_no_path(&self, error: &CliError) -> bool {
        let error = match error {
            CliError::File(error) => error,
            CliError::Piped { error, .. } => error,
            _ => return false,
        };
        let no_frames = matches!(
            error,
            FileError::Expected { place, found, .. } if place == "file_frames" && found == "none"
        );
        no_frames || self.format() != Format::Fold
    }

    /// Reads a motion.
    ///
    /// # Errors
    /// If the input holds no motion.
    pub fn motion(&self) -> Result<Motion, CliError> {
        self.parsed(parse_motion)
    }

    /// Reads the motion of a sheet whose file has one; `None` for a crease pattern.
    #[must_use]
    pub fn motion_of_sheet(&self) -> Option<Motion> {
        // The frames of a motion have a key, so that a pattern need not be parsed once more.
        let bytes = self.bytes().ok()?;
        let has_frames = core::str::from_utf8(&bytes).is_ok_and(|text| text.contains(FRAMES));
        (has_frames && self.format() == Format::Fold).then(|| self.motion().ok())?
    }

    /// Reads the goal angles (radians) of the creases of a pattern in some frames, and returns them with the name of this
    /// input.
    pub(crate) fn named_goals(
        &self,
        pattern: &CreasePattern,
        frames: GoalFrames,
    ) -> Result<NamedGoals, CliError> {
        let goals = self.parsed(|name, bytes| parse_goals(name, bytes, pattern, frames))?;
        Ok((self.name.display().to_string(), goals))
    }

    /// Reads a folded shape.
    pub(crate) fn shape(&self, frame: Option<usize>) -> Result<ShapeFile, CliError> {
        let format = self.format();
        self.parsed(|name, bytes| parse_shape(name, bytes, Some(format), frame))
    }

    /// Reads a table of drives.
    ///
    /// # Errors
    /// If it cannot be read, or a line is no drive.
    pub fn drives(&self) -> Result<Vec<Drive>, CliError> {
        self.parsed(|name, bytes| parse_drives(name, &text(bytes)))
    }

    /// Reads names of joints.
    pub(crate) fn joint_names(&self) -> Result<JointNames, CliError> {
        self.parsed(|name, bytes| JointNames::parse(name, &text(bytes)))
    }

    /// Reads a script of disturbances of hinges.
    pub(crate) fn script(&self, hinges: usize) -> Result<Vec<(u64, Trouble)>, CliError> {
        self.parsed(|name, bytes| parse_script(name, &text(bytes), hinges))
    }
}

/// Returns bytes as text, without a byte order mark.
pub(crate) fn text(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    text.trim_start_matches('\u{feff}').to_string()
}

/// Prints a summary: on stdout, or on stderr if stdout gets the file that the command writes.
pub(crate) fn print_summary(
    output: Option<&Path>,
    quiet: bool,
    text: &str,
) -> Result<(), CliError> {
    match output {
        Some(output) if is_standard(output) => {
            if !quiet {
                say(&anstream::adapter::strip_str(text.trim_end()).to_string());
            }
            Ok(())
        }
        _ => print(text),
    }
}

/// Checks that stdin is read once at most, and that stdout gets one thing.
///
/// # Errors
/// If two options name stdin, or stdout would get a file and the object of `--json`.
pub(crate) fn check_use(command: &Command, json: bool) -> Result<(), CliError> {
    let (inputs, outputs) = files(command);
    let standard = |files: Vec<(&'static str, &Path)>| -> Vec<&'static str> {
        let standard = files.into_iter().filter(|(_, path)| is_standard(path));
        standard.map(|(option, _)| option).collect()
    };
    if let [first, second, ..] = standard(inputs)[..] {
        return Err(CliError::Usage(format!(
            "{first} and {second}: expected one at most to be -, as stdin can be read only once"
        )));
    }
    if let (Some(option), true) = (standard(outputs).first(), json) {
        return Err(CliError::Usage(format!(
            "{option}: expected a file, as --json writes its answer to stdout"
        )));
    }
    Ok(())
}

/// Options with the files that they name.
type Files<'a> = Vec<(&'static str, &'a Path)>;

/// Returns the files that a command reads, and those that it writes.
fn files(command: &Command) -> (Files<'_>, Files<'_>) {
    fn some<'a>(
        option: &'static str,
        file: &'a Option<PathBuf>,
    ) -> Option<(&'static str, &'a Path)> {
        file.as_deref().map(|file| (option, file))
    }
    match command {
        Command::Generate(args) => (vec![], vec![("-o", &args.output)]),
        // A process that plans for another has the streams for itself.
        Command::Batch(args) if args.worker => (vec![], vec![]),
        Command::Batch(args) => (vec![("DESIGNS", &args.designs)], vec![("-o", &args.output)]),
        Command::Info(args) => (vec![("PATTERN", &args.pattern)], vec![]),
        Command::Plan(args) => {
            let request = args.request.get().ok();
            let via = request.into_iter().flat_map(|request| &request.via);
            let via = via.map(|via| ("--via", via.as_path()));
            let inputs = [("PATTERN", args.pattern.as_path())].into_iter();
            let inputs = inputs
                .chain(request.and_then(|request| some("--goal", &request.goal)))
                .chain(via);
            (
                inputs.collect(),
                some("-o", &args.output).into_iter().collect(),
            )
        }
        Command::Check(args) => (vec![("PATH", &args.path)], vec![]),
        Command::Tolerance(args) => (vec![("PATH", &args.path)], vec![]),
        Command::Loads(args) => {
            let inputs = [("PATH", args.path.as_path())].into_iter();
            (
                inputs.chain(some("--drives", &args.drives)).collect(),
                vec![],
            )
        }
        Command::Unfold(args) => (vec![("SHAPE", &args.shape)], vec![("-o", &args.output)]),
        Command::View(View { path, output, .. }) | Command::Plot(Plot { path, output, .. }) => {
            (vec![("PATH", path)], vec![("-o", output)])
        }
        Command::Export(args) => (vec![("PATH", &args.path)], vec![("-o", &args.output)]),
        Command::Stream(args) => {
            let inputs = [("PATH", args.path.as_path())].into_iter();
            let inputs = inputs
                .chain(some("--script", &args.script))
                .chain(some("--sheet", &args.sheet))
                .chain(some("--key", &args.line.key));
            (
                inputs.collect(),
                some("--log", &args.log).into_iter().collect(),
            )
        }
        Command::Drive(args) => {
            let stdin = args
                .commands
                .is_empty()
                .then_some(("COMMANDS", Path::new("-")));
            let inputs = stdin.into_iter().chain(some("--key", &args.line.key));
            (inputs.collect(), vec![])
        }
        Command::Sim(args) => (some("--key", &args.key).into_iter().collect(), vec![]),
        Command::Pair(_) | Command::Completions { .. } | Command::Man { .. } => (vec![], vec![]),
    }
}
