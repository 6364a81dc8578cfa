//! `foldpath view`.

use super::args::View;
use super::{Answer, check_output, print};
use crate::formats::fold::read_path;
use crate::formats::write_whole;
use crate::view::{Scene, page};

pub(super) fn run(args: &View) -> Answer {
    check_output("-o", &args.output, [&args.path])?;
    let path = read_path(&args.path)?;
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
