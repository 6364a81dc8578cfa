//! Runs `foldpath view`, which writes a page that shows a path.

use crate::args::View;
use crate::output::write_whole;
use crate::{Answer, check_output, print};
use foldpath::read::fold::read_motion;
use foldpath::view::{Scene, page};

pub(crate) fn run(args: &View) -> Answer {
    check_output("-o", &args.output, [&args.path])?;
    let path = read_motion(&args.path)?;
    let scene = Scene::of_path(&path);
    write_whole(&args.output, page(&scene).as_bytes())?;
    print(&format!(
        "{}: {} faces, {} knots, page written to {}\n",
        scene.title,
        scene.faces.len(),
        scene.motion.times.len(),
        args.output.display()
    ))?;
    Ok(true)
}
