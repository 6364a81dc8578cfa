//! Runs `foldpath view`, which writes a page that shows a path.

use crate::args::Shown;
use crate::output::write_whole;
use crate::standard::{Input, print_summary, shown};
use crate::{Answer, check_output};
use foldpath::view::{Scene, page};

pub(crate) fn run(args: &Shown, quiet: bool) -> Answer {
    check_output("-o", &args.output, [&args.path])?;
    let path = Input::of(&args.path)?.motion_for("view")?;
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
