//! Runs `foldpath view`, which writes a page that shows a path or a crease pattern.

use crate::args::{Report, View};
use crate::loads::{measured, torques};
use crate::output::write_whole;
use crate::progress::watched;
use crate::standard::{Input, print_summary, shown, source};
use crate::tolerance::error_of;
use crate::{Answer, CliError, check_output, print_notes};
use foldpath::progress::Watch;
use foldpath::request::Request;
use foldpath::sensitivity::Tolerance;
use foldpath::view::{Scene, page, pattern_page};

pub(crate) fn run(args: &View, quiet: bool) -> Answer {
    check_output("-o", &args.output, [&args.path])?;
    let input = Input::of(&args.path)?;
    let reading = args.torques.load.reading.get()?;
    let has_play = args.scale.error.or(args.scale.play).is_some();
    let needs_path = has_play || args.torques.areal_density.is_some();
    let mut path = match input.motion_for("view") {
        Ok(path) => path,
        Err(error) if needs_path || !input.has_no_path(&error) => return Err(error),
        Err(_) => {
            let file = input.pattern(&input.bytes()?, &reading.options()?)?;
            let (title, pattern) = (&file.title, &file.pattern);
            write_whole(
                &args.output,
                pattern_page(title, pattern, Watch::default()).as_bytes(),
            )?;
            print_notes(quiet, pattern.repairs());
            print_notes(quiet, pattern.assumptions());
            let text = format!(
                "{title}: crease pattern of {} edges, page written to {}\n",
                pattern.edges().len(),
                shown(&args.output)
            );
            print_summary(Some(&args.output), quiet, &text)?;
            return Ok(true);
        }
    };
    measured(reading, &args.path, &mut path)?;
    let tolerance = has_play.then(|| {
        let found = watched(&Report { json: false }, quiet, |progress| {
            Tolerance::of(&path, Watch::new(progress))
        });
        found.map_err(|no| CliError::Usage(format!("{}: {no}", source(&args.path))))
    });
    let tolerance = tolerance.transpose()?;
    let loads = torques(&args.torques, &args.path, &path, quiet)?;
    let mut scene = Scene::of_path(&path);
    if let Some(tolerance) = &tolerance {
        scene = scene.with_tolerance(&path, tolerance, error_of(&args.scale, tolerance));
    }
    if let Some(loads) = &loads {
        scene = scene.with_torques(&path, loads);
    }
    write_whole(&args.output, page(&scene).as_bytes())?;
    let text = format!(
        "{}: {} faces, {} knots, page written to {}\n",
        scene.title,
        scene.faces.len(),
        scene.motion.times.len(),
        shown(&args.output)
    );
    print_summary(Some(&args.output), quiet, &text)?;
    Ok(true)
}
