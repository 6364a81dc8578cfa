//! Runs `foldpath export`, which writes a path, or its pattern, in other formats.

use std::path::Path;

use foldpath_core::Membership;

use crate::args::{Colour, Export, ExportFormat, Per};
use crate::output::{write_each_whole, write_whole};
use crate::standard::{Input, is_standard, print_summary, shown};
use crate::{Answer, CliError, check_output, print, print_notes};
use foldpath::export::joint_trajectory::JointTrajectory;
use foldpath::export::traj::TrajFile;
use foldpath::export::{csv, glb, mjcf, obj_sequence, rust, svg_pattern};
use foldpath::folding::{STEP, deformation_of_faces};
use foldpath::motion::{GroupNaming, Motion};
use foldpath::pattern::{CreasePattern, EdgeId};
use foldpath::read::FileError;
use foldpath::symmetry::CreaseGroups;

pub(crate) fn run(args: &Export, quiet: bool) -> Answer {
    check(args)?;
    check_output("-o", &args.output, [&args.path])?;
    let input = Input::of(&args.path)?;
    let text = match args.to {
        ExportFormat::Svg => written(args, drawing(args, &input)?)?,
        _ => export(args, &input.motion()?, &input.name, quiet)?,
    };
    match args.to {
        ExportFormat::Obj | ExportFormat::Mjcf => print(&text)?,
        _ => print_summary(Some(&args.output), quiet, &text)?,
    }
    Ok(true)
}

/// Exports a motion that was never written. `name` stands for it in messages.
///
/// # Errors
/// As the command refuses.
pub(crate) fn motion(args: &Export, motion: &Motion, name: &Path) -> Result<(), CliError> {
    check(args)?;
    if is_standard(&args.output) {
        return Err(CliError::Usage("-o: expected a file, found -".into()));
    }
    export(args, motion, name, true).map(drop)
}

/// Checks that the options have a meaning for the format.
fn check(args: &Export) -> Result<(), CliError> {
    let has_frames = matches!(args.to, ExportFormat::Obj | ExportFormat::Glb);
    let usage = |text: &str| Err(CliError::Usage(text.into()));
    if args.frames.is_some() && !has_frames {
        return usage("--frames: expected --to obj or --to glb, which have frames");
    }
    if args.rate.is_some() && args.to != ExportFormat::Csv {
        return usage("--rate: expected --to csv, which has rows");
    }
    if let Some(rate) = args.rate.filter(|rate| !(*rate > 0.0 && rate.is_finite())) {
        return usage(&format!(
            "--rate: expected a frequency above 0 Hz, found {rate}"
        ));
    }
    if args.colour.is_some() && args.to != ExportFormat::Svg {
        return usage("--colour: expected --to svg, which has colours");
    }
    let reads_drawing = args.to == ExportFormat::Svg && args.colour != Some(Colour::Deformation);
    if args.reading.is_given() && !reads_drawing {
        let text = "--tolerance, --straighten and --colors: expected --to svg with colours by letters or groups, which reads drawings";
        return usage(text);
    }
    let several = matches!(args.to, ExportFormat::Obj | ExportFormat::Mjcf);
    if several && is_standard(&args.output) {
        return usage(
            "-o: expected a folder, as --to obj and --to mjcf write several files, found -",
        );
    }
    Ok(())
}

/// Exports a motion and returns a summary.
fn export(args: &Export, path: &Motion, name: &Path, quiet: bool) -> Result<String, CliError> {
    match args.to {
        ExportFormat::Obj => sequence(args, path),
        ExportFormat::Mjcf => model(args, path, name),
        ExportFormat::Svg => written(args, drawing_of_path(args, path)),
        _ => written(args, path_file(args, path, name, quiet)?),
    }
}

/// Writes the content and returns a summary.
fn written(args: &Export, (title, bytes, content): Content) -> Result<String, CliError> {
    write_whole(&args.output, &bytes)?;
    Ok(format!(
        "{title}: {content}, {} bytes written to {}\n",
        bytes.len(),
        shown(&args.output)
    ))
}

/// Title, bytes, and a description of the bytes.
type Content = (String, Vec<u8>, String);

fn path_file(args: &Export, path: &Motion, name: &Path, quiet: bool) -> Result<Content, CliError> {
    let (bytes, content) = match args.to {
        ExportFormat::Traj | ExportFormat::Rust => {
            let file = TrajFile::of(path, name)?;
            let content = format!(
                "{} knots of {} groups, {} hinges, {:.3} s",
                file.knots, file.groups, file.hinges, file.duration
            );
            if args.to == ExportFormat::Traj {
                let TrajFile {
                    groups,
                    hinges,
                    spokes,
                    ..
                } = file;
                print_notes(
                    quiet,
                    &[format!(
                        "a controller needs room for {groups} groups, {hinges} hinges and {spokes} spokes"
                    )],
                );
            }
            if args.to == ExportFormat::Rust {
                let text = rust::source(&file, &path.title, name)?;
                (text.into_bytes(), content)
            } else {
                (file.bytes, content)
            }
        }
        ExportFormat::Glb => {
            // A viewer moves vertices on straight lines between frames, so that hinges may turn only a little from one
            // frame to the next.
            let frames = resampled(args, path).unwrap_or_else(|| path.with_steps(STEP));
            let content = format!(
                "{} frames, {} faces",
                frames.knots.len(),
                path.pattern.faces().len()
            );
            (glb::content(&frames, name)?, content)
        }
        ExportFormat::JointTrajectory => {
            let trajectory = JointTrajectory::of(path, name)?;
            let (points, joints) = (trajectory.points.len(), trajectory.joints.len());
            let error = trajectory.resampling_error;
            let made = if error > 0.0 {
                format!("resampled to {error:.1e} radians")
            } else {
                "exact".into()
            };
            (
                trajectory.text().into_bytes(),
                format!("{points} points of {joints} joints, {made}"),
            )
        }
        ExportFormat::Csv if args.rate.is_some() => {
            let column = match args.per {
                Some(Per::Group) => csv::Column::Group,
                Some(Per::Hinge) | None => csv::Column::Hinge,
            };
            let rate = args.rate.unwrap_or_default();
            let text = csv::sampled(path, name, rate, column)?;
            let rows = text.lines().count() - 1;
            (text.into_bytes(), format!("{rows} rows at {rate} Hz"))
        }
        _ => {
            let text = csv::text(path, name)?;
            (text.into_bytes(), format!("{} knots", path.knots.len()))
        }
    };
    Ok((path.title.clone(), bytes, content))
}

/// Returns the path in the number of frames asked for; `None` if no number is given.
fn resampled(args: &Export, path: &Motion) -> Option<Motion> {
    Some(path.resampled(args.frames?.into()))
}

/// Writes one OBJ file for each frame.
fn sequence(args: &Export, path: &Motion) -> Result<String, CliError> {
    let frames = resampled(args, path);
    let path = frames.as_ref().unwrap_or(path);
    let output = &args.output;
    let named_folder = output
        .as_os_str()
        .to_string_lossy()
        .ends_with(std::path::MAIN_SEPARATOR);
    let folder = named_folder || output.is_dir();
    if folder {
        std::fs::create_dir_all(output).map_err(|source| FileError::Io {
            path: output.clone(),
            source,
        })?;
    }
    let names = [0, path.knots.len() - 1].map(|k| obj_sequence::frame_path(output, folder, k));
    for index in 0..path.knots.len() {
        let frame = obj_sequence::frame_path(output, folder, index);
        check_output("-o", &frame, [&args.path])?;
    }
    write_each_whole(obj_sequence::files(path, output, folder))?;
    Ok(format!(
        "{}: {} frames, {} faces, written to {} to {}\n",
        path.title,
        path.knots.len(),
        path.pattern.faces().len(),
        names[0].display(),
        names[1].display()
    ))
}

/// Writes a model of MuJoCo into a folder.
fn model(args: &Export, path: &Motion, name: &Path) -> Result<String, CliError> {
    let model = mjcf::model(path, name)?;
    let output = &args.output;
    if output.is_file() {
        let output = output.display();
        let text = format!("-o: --to mjcf expected a folder, found the file {output}");
        return Err(CliError::Usage(text));
    }
    std::fs::create_dir_all(output).map_err(|source| FileError::Io {
        path: output.clone(),
        source,
    })?;
    let files = model.files.into_iter();
    write_each_whole(files.map(|(name, content)| (output.join(name), content)))?;
    let driven = if model.drivers_known {
        "that drive the sheet near flat"
    } else {
        "of the tree, as it is not known which drive the sheet"
    };
    Ok(format!(
        "{}: {} panels, {} hinge joints, {} loops, actuators on {} hinges {driven}, written to {}\n",
        path.title,
        model.panels,
        model.joints,
        model.loops,
        model.actuators.len(),
        output.join("scene.xml").display()
    ))
}

/// Returns a coloured drawing of the crease pattern of a path, or of any file with a crease pattern.
fn drawing(args: &Export, input: &Input) -> Result<Content, CliError> {
    let options = args.reading.request().options()?;
    let read = || input.pattern(&input.pattern_bytes()?, &options);
    match args.colour.unwrap_or_default() {
        Colour::Letters => {
            let file = read()?;
            Ok(by_letters(&file.title, &file.pattern))
        }
        Colour::Groups => match input.motion() {
            Ok(path) if path.naming != GroupNaming::Unnamed => Ok(drawing_of_path(args, &path)),
            _ => {
                let file = read()?;
                Ok(by_found_groups(&file.title, &file.pattern))
            }
        },
        Colour::Deformation => Ok(drawing_of_path(args, &input.motion()?)),
    }
}

/// Returns a coloured drawing of the crease pattern of a path.
fn drawing_of_path(args: &Export, path: &Motion) -> Content {
    let (text, content) = match args.colour.unwrap_or_default() {
        Colour::Letters => return by_letters(&path.title, &path.pattern),
        Colour::Groups if path.naming == GroupNaming::Unnamed => {
            return by_found_groups(&path.title, &path.pattern);
        }
        Colour::Groups => {
            let ranges = ranges(path);
            let members = path.named_members();
            (
                svg_pattern::by_groups(&path.title, &path.pattern, members, &ranges),
                format!("{} crease groups of the path", ranges.len()),
            )
        }
        Colour::Deformation => {
            let faces = deformation_of_faces(path);
            (
                svg_pattern::by_deformation(&path.title, &path.pattern, &faces),
                format!("{} faces by deformation", faces.len()),
            )
        }
    };
    (path.title.clone(), text.into_bytes(), content)
}

fn by_letters(title: &str, pattern: &CreasePattern) -> Content {
    let text = svg_pattern::by_letters(title, pattern);
    let content = format!("{} edges by letters", pattern.edges().len());
    (title.into(), text.into_bytes(), content)
}

fn by_found_groups(title: &str, pattern: &CreasePattern) -> Content {
    let (members, ranges) = found_groups(pattern);
    let text = svg_pattern::by_groups(title, pattern, &members, &ranges);
    let content = format!("{} crease groups of the pattern", ranges.len());
    (title.into(), text.into_bytes(), content)
}

/// Returns for each crease group of a path its smallest and largest fold angle, radians.
fn ranges(path: &Motion) -> Vec<[f64; 2]> {
    let steps = path.with_steps(STEP);
    let leaders = path.leaders().into_iter();
    let range = |leader: Option<(EdgeId, Membership)>| {
        let angles = (0..steps.knots.len()).filter_map(|knot| {
            let (edge, member) = leader?;
            Some(member.apply(steps.node(knot, edge).angle))
        });
        extent(angles)
    };
    leaders.map(range).collect()
}

/// Finds the crease groups of a pattern. Returns the membership of each edge, and for each group the range of fold
/// angles (radians) from flat to its goal.
fn found_groups(pattern: &CreasePattern) -> (Vec<Option<Membership>>, Vec<[f64; 2]>) {
    let groups = CreaseGroups::find(pattern);
    let edges = pattern.edges().iter();
    let members = edges.map(|edge| edge.crease.map(|crease| groups.of(crease)));
    let creases = pattern.creases().iter();
    let goals: Vec<_> = creases.map(|&edge| pattern.edge(edge).goal).collect();
    let goals = groups.reduce(&goals).into_iter();
    let ranges = goals.map(|goal| extent([0.0].into_iter().chain(goal)));
    (members.collect(), ranges.collect())
}

/// Returns the smallest and the largest number; zeros if there are no numbers.
fn extent(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    let ends = numbers
        .map(|x| [x; 2])
        .reduce(|[low, high], [x, _]| [low.min(x), high.max(x)]);
    ends.unwrap_or_default()
}
