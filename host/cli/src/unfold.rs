//! Runs `foldpath unfold`, which makes a crease pattern of a folded shape.

use serde::Serialize;

use crate::args::{Cut, Unfold};
use crate::hints;
use crate::output::write_whole_with;
use crate::standard::{Input, print_summary, shown};
use crate::{Answer, CliError, check_output, print_json, print_notes};
use foldpath::export::fold::write_pattern;
use foldpath::read::FileError;
use foldpath::unfold::{self, Outcome, UnfoldOptions, Unfolding, unfold};

#[derive(Serialize)]
struct UnfoldJson {
    outcome: &'static str,
    reason: Option<String>,
    vertices: usize,
    faces: usize,
    creases: usize,
    cuts: usize,
    pieces: usize,
    max_angle_defect: f64,
    max_closure: Option<f64>,
}

pub(crate) fn run(args: &Unfold, quiet: bool) -> Answer {
    let degrees = args.max_defect;
    if !(degrees > 0.0 && degrees <= 10.0) {
        return Err(CliError::Usage(format!(
            "--max-defect: expected degrees above 0 and at most 10, found {degrees}"
        )));
    }
    check_output("-o", &args.output, [&args.shape])?;
    let input = Input::of(&args.shape)?;
    let file = input.shape(args.frame)?;
    let options = UnfoldOptions::default().with(|it| {
        it.max_defect = degrees.to_radians();
        it.cut = match args.cut {
            Cut::Auto => unfold::Cut::Auto,
            Cut::None => unfold::Cut::None,
        };
    });
    let unfolding = unfold(&file.shape, &options).map_err(|source| FileError::Shape {
        path: input.name.clone(),
        source,
    })?;
    if let Some(drawing) = &unfolding.drawing {
        write_whole_with(&args.output, |mut out| {
            write_pattern(
                &file.title,
                drawing,
                unfolding.precision,
                file.unit,
                &mut out,
            )
        })?;
    }
    print_notes(quiet, &file.notes);
    print_notes(quiet, &unfolding.notes);
    if args.report.json {
        print_json(&UnfoldJson {
            outcome: unfolding.outcome.name(),
            reason: reason(&unfolding),
            vertices: unfolding.vertices,
            faces: unfolding.faces,
            creases: unfolding.creases,
            cuts: unfolding.cuts,
            pieces: unfolding.pieces,
            max_angle_defect: unfolding.max_angle_defect.to_degrees(),
            max_closure: unfolding.max_closure,
        })?;
    } else {
        let text = summary(args, &file.title, &unfolding);
        print_summary(Some(&args.output), quiet, &text)?;
    }
    Ok(unfolding.outcome == Outcome::Unfolded)
}

/// Returns the reason why there is no pattern, with the option that would help if there is one.
fn reason(unfolding: &Unfolding) -> Option<String> {
    let reason = unfolding.reason.as_ref()?;
    Some(match hints::of_unfolding(reason) {
        Some(hint) => format!("{reason}; {hint}"),
        None => reason.to_string(),
    })
}

fn summary(args: &Unfold, title: &str, unfolding: &Unfolding) -> String {
    let mut text = format!("{title}: {}\n", unfolding.outcome.name().replace('_', " "));
    if let Some(reason) = reason(unfolding) {
        text += &format!("  reason       {reason}\n");
    }
    text += &format!(
        "  sheet        {} faces, {} vertices, {} creases, cut along {} edges\n  \
         angle defect {:.1e} degrees at most\n",
        unfolding.faces,
        unfolding.vertices,
        unfolding.creases,
        unfolding.cuts,
        unfolding.max_angle_defect.to_degrees(),
    );
    if let Some(closure) = unfolding.max_closure {
        text += &format!("  closure      {closure:.1e} at the measured angles\n");
    }
    if let Some(deviation) = unfolding.deviation {
        text += &format!(
            "  folded back  {deviation:.1e} of its size from the shape, where it is farthest\n"
        );
    }
    text + &match unfolding.outcome {
        Outcome::Unfolded => format!("  written to   {}\n", shown(&args.output)),
        _ => "  nothing written\n".into(),
    }
}
