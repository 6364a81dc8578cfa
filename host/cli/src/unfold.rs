//! Runs `foldpath unfold`, which makes a crease pattern of a folded shape.

use crate::args::Unfold;
use crate::hints;
use crate::output::write_whole;
use crate::standard::{Input, print_summary, shown};
use crate::{Answer, CliError, check_output, print_json, print_notes};
use foldpath::export::fold::write_pattern;
use foldpath::read::{FileError, check_unit};
use foldpath::request::{Request, UnfoldJson, UnfoldRequest};
use foldpath::unfold::{Outcome, Unfolding, unfold};

/// A shape that was unfolded.
pub struct Unfolded {
    /// Title of the shape.
    title: String,
    unfolding: Unfolding,
    /// The object of `foldpath unfold --json`.
    pub json: UnfoldJson,
    /// The text of the crease pattern, a FOLD file, if one was found.
    pub pattern: Option<Vec<u8>>,
    /// Notes on the shape and its pattern, in sentences.
    pub notes: Vec<String>,
}

/// Unfolds a shape.
///
/// # Errors
/// If it cannot be read, is no surface, has another unit than the request, or an option is out of its range.
pub fn unfolded(input: &Input, request: &UnfoldRequest) -> Result<Unfolded, CliError> {
    let options = request.options()?;
    let file = input.shape(request.frame)?;
    if let Some(told) = request.unit {
        check_unit(&input.name, file.unit, told)?;
    }
    let unfolding = unfold(&file.shape, &options).map_err(|source| FileError::Shape {
        path: input.name.clone(),
        source,
    })?;
    let pattern = unfolding.drawing.as_ref().map(|drawing| {
        let (unit, mut text) = (request.unit.or(file.unit), Vec::new());
        // Memory takes whatever is written.
        let _infallible = write_pattern(&file.title, drawing, unfolding.precision, unit, &mut text);
        text
    });
    let mut notes = file.notes;
    notes.extend(unfolding.notes.iter().map(ToString::to_string));
    Ok(Unfolded {
        title: file.title,
        json: UnfoldJson::of(&unfolding, reason(&unfolding)),
        unfolding,
        pattern,
        notes,
    })
}

pub(crate) fn run(args: &Unfold, quiet: bool) -> Answer {
    let request = args.request.get()?;
    check_output("-o", &args.output, [&args.shape])?;
    let unfolded = unfolded(&Input::of(&args.shape)?, request)?;
    if let Some(pattern) = &unfolded.pattern {
        write_whole(&args.output, pattern)?;
    }
    print_notes(quiet, &unfolded.notes);
    if args.report.json {
        print_json(&unfolded.json)?;
    } else {
        let text = summary(args, &unfolded);
        print_summary(Some(&args.output), quiet, &text)?;
    }
    Ok(unfolded.unfolding.outcome == Outcome::Unfolded)
}

/// Returns the reason why there is no pattern, with the option that would help if there is one.
fn reason(unfolding: &Unfolding) -> Option<String> {
    let reason = unfolding.reason.as_ref()?;
    Some(match hints::of_unfolding(reason) {
        Some(hint) => format!("{reason}; {hint}"),
        None => reason.to_string(),
    })
}

fn summary(args: &Unfold, unfolded: &Unfolded) -> String {
    let Unfolded {
        title,
        unfolding,
        json,
        ..
    } = unfolded;
    let mut text = format!("{title}: {}\n", unfolding.outcome.name().replace('_', " "));
    if let Some(reason) = &json.reason {
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
