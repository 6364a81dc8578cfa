//! Runs `foldpath plot`, which draws curves of a path as an SVG or PNG picture.

use crate::args::Plot;
use crate::fonts::Font;
use crate::output::write_whole;
use crate::png::png;
use crate::{Answer, CliError, check_output, print};
use foldpath::plot::{Curves, svg};
use foldpath::read::fold::read_motion;

pub(crate) fn run(args: &Plot) -> Answer {
    let output = args.output.display();
    let ending = args.output.extension().unwrap_or_default();
    let pixels = ending.eq_ignore_ascii_case("png");
    if !pixels && !ending.eq_ignore_ascii_case("svg") {
        return Err(CliError::Usage(format!(
            "-o: expected a name that ends in .svg or .png, found {output}"
        )));
    }
    check_output("-o", &args.output, [&args.path])?;
    let path = read_motion(&args.path)?;
    let curves = Curves::of_path(&path);
    let text = svg(&curves);
    let picture = if pixels {
        let pixels = png(&text, Font::of_system().as_ref());
        pixels.map_err(|error| CliError::Usage(format!("-o: {error}")))?
    } else {
        text.into_bytes()
    };
    write_whole(&args.output, &picture)?;
    print(&format!(
        "{}: {} curves of angles, {} knots, picture written to {output}\n",
        path.title,
        curves.count,
        curves.knots.len(),
    ))?;
    Ok(true)
}
