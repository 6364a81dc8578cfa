//! Runs `foldpath check`, which judges a path.

use core::time::Duration;
use std::time::Instant;

use crate::args::Check;
use crate::progress::watched;
use crate::report::outcome;
use crate::standard::Input;
use crate::{Answer, CliError, print, print_json, print_notes};
use foldpath::check::check_watched;
use foldpath::request::{CheckJson, Request};

pub(crate) fn run(args: &Check, quiet: bool) -> Answer {
    let begun = Instant::now();
    let mut options = args.request.get()?.options()?;
    let (path, verdict) = watched(&args.report, quiet, |progress| {
        let path = Input::of(&args.path)?.motion_for("check")?;
        let left = |time: Duration| time.saturating_sub(begun.elapsed());
        options.timeout = options.timeout.map(left);
        let verdict = check_watched(&path, &options, progress);
        Ok::<_, CliError>((path, verdict))
    })?;
    let holds = verdict.holds();
    let json = CheckJson::of(&path, &verdict);
    if args.report.json {
        print_json(&json)?;
        return Ok(holds);
    }
    print_notes(quiet, path.pattern.assumptions());
    let outcome = outcome(holds, json.outcome);
    let mut text = format!("{}: {outcome}\n", path.title);
    for failure in &verdict.failures {
        text += &format!("  fails: {failure}\n");
    }
    for question in &json.undecided {
        text += &format!("  undecided: {question}\n");
    }
    text += &format!(
        "  {} knots, deformation {:.1e}, gap {:.1e}, closure {:.1e}, {} segments with crossings\n",
        json.knots,
        json.max_deformation,
        json.max_gap,
        json.max_closure,
        json.crossings.len()
    );
    let known = |bound: Option<f64>| bound.map_or("unknown".into(), |it| format!("{it:.1e}"));
    let closure = Some(verdict.closure_bound()).filter(|bound| bound.is_finite());
    text += &format!(
        "  certified for the whole motion: closure {}, deformation {} of {}\n",
        known(closure),
        known(json.certified_deformation),
        json.certified_of
    );
    if json.max_bend > 0.0 {
        text += &format!("  panels bend by up to {:.2} degrees\n", json.max_bend);
    }
    if json.knots == 1 {
        text += "  one knot: a shape, not a motion\n";
    }
    if json.start == "folded" {
        text += "  begins folded: which of two layers lies above the other is taken from the first knot\n";
    }
    print(&text)?;
    Ok(holds)
}
