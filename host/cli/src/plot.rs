//! Runs `foldpath plot`, which draws curves of a path as an SVG or PNG picture.

use crate::args::Plot;
use crate::fonts::Font;
use crate::loads::{measured, torques};
use crate::output::write_whole;
use crate::png::png;
use crate::standard::{Input, is_standard, print_summary, shown};
use crate::{Answer, CliError, check_output};
use foldpath::plot::{Curves, svg};

pub(crate) fn run(args: &Plot, quiet: bool) -> Answer {
    let output = shown(&args.output);
    let ending = args.output.extension().unwrap_or_default();
    let pixels = ending.eq_ignore_ascii_case("png");
    if !pixels && !ending.eq_ignore_ascii_case("svg") && !is_standard(&args.output) {
        return Err(CliError::Usage(format!(
            "-o: expected a name that ends in .svg or .png, found {output}"
        )));
    }
    check_output("-o", &args.output, [&args.path])?;
    let mut path = Input::of(&args.path)?.motion_for("plot")?;
    measured(args.torques.load.reading.get()?, &args.path, &mut path)?;
    let loads = torques(&args.torques, &args.path, &path, quiet)?;
    let curves = Curves::of_path(&path);
    let curves = match &loads {
        Some(loads) => curves.with_torques(&path, loads),
        None => curves,
    };
    let text = svg(&curves);
    let picture = if pixels {
        let pixels = png(&text, Font::of_system().as_ref());
        pixels.map_err(|error| CliError::Usage(format!("-o: {error}")))?
    } else {
        text.into_bytes()
    };
    write_whole(&args.output, &picture)?;
    let text = format!(
        "{}: {} curves of angles, {} knots, picture written to {output}\n",
        path.title,
        curves.count,
        curves.knots.len(),
    );
    print_summary(Some(&args.output), quiet, &text)?;
    Ok(true)
}
