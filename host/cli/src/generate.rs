//! Runs `foldpath generate`, which writes a crease pattern of a known family.

use crate::Answer;
use crate::args::Generate;
use crate::options::FamilyArgs;
use crate::output::write_whole_with;
use crate::standard::{print_summary, shown};
use foldpath::export::fold::write_pattern;

pub(crate) fn run(args: &Generate, quiet: bool) -> Answer {
    let FamilyArgs { family, output } = &args.family;
    let family = family.clone()?;
    let (title, drawing) = (family.title(), family.drawing()?);
    write_whole_with(output, |out| write_pattern(&title, &drawing, out))?;
    let text = format!(
        "{title}: {} vertices, {} edges, written to {}\n",
        drawing.vertices.len(),
        drawing.edges.len(),
        shown(output)
    );
    print_summary(Some(output), quiet, &text)?;
    Ok(true)
}
