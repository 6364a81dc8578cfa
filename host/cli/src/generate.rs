//! Runs `foldpath generate`, which writes a crease pattern of a known family.

use crate::Answer;
use crate::options::FamilyArgs;
use crate::output::write_whole_with;
use crate::standard::{print_summary, shown};
use foldpath::export::fold::write_pattern;
use foldpath::pattern::Precision;
use foldpath::request::generate;

pub(crate) fn run(FamilyArgs { family, output }: &FamilyArgs, quiet: bool) -> Answer {
    let (title, drawing) = generate(family)?;
    write_whole_with(output, |mut out| {
        write_pattern(&title, &drawing, Precision::default(), None, &mut out)
    })?;
    let text = format!(
        "{title}: {} vertices, {} edges, written to {}\n",
        drawing.vertices.len(),
        drawing.edges.len(),
        shown(output)
    );
    print_summary(Some(output), quiet, &text)?;
    Ok(true)
}
