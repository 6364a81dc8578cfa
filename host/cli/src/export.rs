//! Runs `foldpath export`, which writes a path, or its pattern, in other formats.

use std::borrow::Cow;
use std::path::{MAIN_SEPARATOR, Path, PathBuf};

use crate::args::Export;
use crate::output::{Pending, write_whole};
use crate::standard::{Input, is_standard, print_summary, shown};
use crate::{Answer, CliError, check_output, print_notes};
use foldpath::export::{ExportOptions, FORMATS, Format, Needs, Place, Source};
use foldpath::motion::Motion;
use foldpath::read::{FileError, check_unit};
use foldpath::request::{OptionInfo, ReadingRequest, Request};

pub(crate) fn run(args: &Export, quiet: bool) -> Answer {
    let options = checked(args)?;
    check_output("-o", &args.output, [&args.path])?;
    let input = Input::of(&args.path)?;
    let reading = args.reading.get()?.options()?;
    let mut path = match (args.to.needs)(&options) {
        Needs::Path => {
            let user = format!("--to {}", args.to.name);
            Some(input.motion_for(&user)?)
        }
        Needs::PathOrPattern => input.motion().ok(),
        Needs::Pattern => None,
    };
    if let (Some(motion), Some(unit)) = (&mut path, reading.unit) {
        check_unit(&input.name, motion.pattern.unit(), unit)?;
        motion.measured_in(unit);
    }
    let text = if let Some(motion) = &path {
        export(args, &options, Source::Motion(motion), &input.name, quiet)?
    } else {
        let file = input.pattern(&input.bytes()?, &reading)?;
        let source = Source::Pattern(&file.title, &file.pattern);
        export(args, &options, source, &input.name, quiet)?
    };
    print_summary(Some(&args.output), quiet, &text)?;
    Ok(true)
}

/// Exports a motion that was never written. `name` stands for it in messages.
///
/// # Errors
/// As the command refuses.
pub(crate) fn motion(args: &Export, motion: &Motion, name: &Path) -> Result<(), CliError> {
    let options = checked(args)?;
    if is_standard(&args.output) {
        return Err(CliError::Usage("-o: expected a file, found -".into()));
    }
    let mut motion = Cow::Borrowed(motion);
    if let Some(unit) = args.reading.get()?.options()?.unit {
        check_unit(name, motion.pattern.unit(), unit)?;
        motion.to_mut().measured_in(unit);
    }
    export(args, &options, Source::Motion(&motion), name, true).map(drop)
}

/// Returns the options, which have to have a meaning for the format.
fn checked(args: &Export) -> Result<ExportOptions, CliError> {
    let format: &Format = args.to;
    let request = args.request.get()?;
    let usage = |text: String| Err(CliError::Usage(text));
    let takes = |format: &Format, option: &OptionInfo| format.options.contains(&option.name);
    if let Some((option, _)) = request
        .given()
        .iter()
        .find(|(option, _)| !takes(format, option))
    {
        let takers = FORMATS.iter().filter(|format| takes(format, option));
        let takers: Vec<&str> = takers.map(|format| format.name).collect();
        return usage(format!(
            "--{}: expected --to {}, found --to {}",
            option.flag(),
            takers.join(" or --to "),
            format.name
        ));
    }
    let mut options = request.options()?;
    if let Some(file) = &request.names {
        options.names = Some(Input::of(file)?.joint_names()?);
    }
    let reading = args.reading.get()?;
    let without_unit = ReadingRequest {
        unit: None,
        ..reading.clone()
    };
    if without_unit != ReadingRequest::default() && (format.needs)(&options) == Needs::Path {
        let text = "--tolerance, --straighten, --colors, --layers and --dashes: expected --to svg with colours by letters or groups, which reads drawings";
        return usage(text.into());
    }
    if format.place != Place::File && is_standard(&args.output) {
        return usage(format!(
            "-o: expected a folder, as --to {} writes several files, found -",
            format.name
        ));
    }
    Ok(options)
}

/// Makes the files and returns a summary.
fn export(
    args: &Export,
    options: &ExportOptions,
    source: Source<'_>,
    name: &Path,
    quiet: bool,
) -> Result<String, CliError> {
    let (format, output) = (args.to, &args.output);
    let numbers_in_folder = format.place == Place::Sequence && is_folder(output);
    if format.place == Place::Folder || numbers_in_folder {
        if output.is_file() {
            let (name, output) = (format.name, output.display());
            let text = format!("-o: --to {name} expected a folder, found the file {output}");
            return Err(CliError::Usage(text));
        }
        std::fs::create_dir_all(output).map_err(FileError::io(output))?;
    }
    let mut pending = Pending::default();
    let mut single = Vec::new();
    let made = format.make(source, name, options, &mut |name, content| {
        let path = match format.place {
            Place::File => {
                single = content;
                return Ok(());
            }
            Place::Folder => output.join(name),
            Place::Sequence if numbers_in_folder => {
                output.join(format!("frame-{name}.{}", format.name))
            }
            Place::Sequence => beside(output, name, format.name),
        };
        pending.add(path, |out| out.write_all(&content))
    })?;
    let place = match &pending.paths().collect::<Vec<_>>()[..] {
        [] => {
            write_whole(output, &single)?;
            let bytes = single.len();
            format!("{bytes} bytes written to {}", shown(output))
        }
        paths => {
            for path in paths {
                check_output("-o", path, [&args.path])?;
            }
            let [first, last] = [paths[0], paths[paths.len() - 1]].map(|path| path.display());
            match format.place {
                Place::Sequence => format!("written to {first} to {last}"),
                _ => format!("written to {first}"),
            }
        }
    };
    pending.persist()?;
    print_notes(quiet, &made.notes);
    Ok(format!("{}: {}, {place}\n", source.title(), made.told))
}

/// Returns `true` if numbered files are to be in a folder with this name.
fn is_folder(output: &Path) -> bool {
    let name = output.as_os_str().to_string_lossy();
    name.ends_with(MAIN_SEPARATOR) || output.is_dir()
}

/// Returns the name of a numbered file: `fold.obj` gives `fold-0000.obj`, `fold-0001.obj` and so on.
fn beside(output: &Path, number: &str, ending: &str) -> PathBuf {
    let found = output.extension();
    let stem = if found.is_some_and(|found| found.eq_ignore_ascii_case(ending)) {
        output.file_stem()
    } else {
        output.file_name()
    };
    let mut name = stem.unwrap_or_default().to_os_string();
    name.push(format!("-{number}.{ending}"));
    output.with_file_name(name)
}
