//! Runs `foldpath view`, which writes a page that shows a path or a crease pattern.

use crate::args::Shown;
use crate::output::write_whole;
use crate::standard::{Input, print_summary, shown};
use crate::{Answer, check_output, print_notes};
use foldpath::progress::Watch;
use foldpath::read::ReadOptions;
use foldpath::view::{Scene, page, pattern_page};

pub(crate) fn run(args: &Shown, quiet: bool) -> Answer {
    check_output("-o", &args.output, [&args.path])?;
    let input = Input::of(&args.path)?;
    let path = match input.motion_for("view") {
        Ok(path) => path,
        Err(error) if !input.has_no_path(&error) => return Err(error),
        Err(_) => {
            let file = input.pattern(&input.bytes()?, &ReadOptions::default())?;
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
    let scene = Scene::of_path(&path);
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
