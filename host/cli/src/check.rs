//! Runs `foldpath check`, which judges a path.

use serde::Serialize;

use crate::args::Check;
use crate::progress::watched;
use crate::report::outcome;
use crate::standard::Input;
use crate::{Answer, CliError, print, print_json, print_notes};
use foldpath::check::{CheckOptions, check_watched};
use foldpath::folding::SpanningTree;
use foldpath::pattern::CreasePattern;

#[derive(Serialize)]
struct CheckJson {
    outcome: &'static str,
    reason: Option<String>,
    start: &'static str,
    undecided: Vec<String>,
    knots: usize,
    max_deformation: f64,
    max_gap: f64,
    max_closure: f64,
    max_bend: f64,
    certified_deformation: Option<f64>,
    certified_of: String,
    crossings: Vec<CrossingJson>,
    min_clearance: Option<f64>,
    contact_tolerance: f64,
    max_speed: f64,
    max_acceleration: Option<f64>,
}

#[derive(Serialize)]
struct CrossingJson {
    faces: [u32; 2],
    between_knots: [usize; 2],
    at: f64,
}

/// Says which folding of a sheet is certified: on a sheet that does not quite close, others are torn elsewhere.
fn certified_of(pattern: &CreasePattern) -> String {
    let tree = SpanningTree::from_central_face(pattern);
    let roots: Vec<_> = tree.roots().iter().map(ToString::to_string).collect();
    match &roots[..] {
        [root] => format!("the sheet folded from face {root} outwards"),
        _ => format!("the sheets folded from faces {} outwards", roots.join(", ")),
    }
}

fn sentences(findings: &[impl ToString]) -> Vec<String> {
    findings.iter().map(ToString::to_string).collect()
}

pub(crate) fn run(args: &Check, quiet: bool) -> Answer {
    let bound = args.bound;
    if bound > 1.0 && bound.is_finite() {
        let text = format!("--bound: expected a fraction of at most 1, found {bound}");
        return Err(CliError::Usage(text));
    }
    if !(bound > 0.0 && bound.is_finite()) {
        return Err(CliError::Usage(format!(
            "--bound: expected a number above 0, found {bound}"
        )));
    }
    if let Some(found) = args
        .contact
        .filter(|contact| !(0.0..=1e-3).contains(contact))
    {
        let text = format!("--contact: expected median edges from 0 to 0.001, found {found}");
        return Err(CliError::Usage(text));
    }
    if !(0.0..=180.0).contains(&args.bend) {
        let text = format!(
            "--bend: expected degrees from 0 to 180, found {}",
            args.bend
        );
        return Err(CliError::Usage(text));
    }
    let (path, verdict) = watched(&args.report, quiet, |progress| {
        let path = Input::of(&args.path)?.motion()?;
        let options = CheckOptions {
            bound,
            contact: args.contact,
            bend: args.bend.to_radians(),
            ..CheckOptions::default()
        };
        let verdict = check_watched(&path, &options, progress);
        Ok::<_, CliError>((path, verdict))
    })?;
    let holds = verdict.holds();
    let [failures, undecided] = [sentences(&verdict.failures), sentences(&verdict.undecided)];
    let reasons = if failures.is_empty() {
        &undecided
    } else {
        &failures
    };
    let rigidity = verdict.rigidity();
    let crossings = verdict.crossings.iter().map(|found| CrossingJson {
        faces: found.crossing.faces.map(|face| face.0),
        between_knots: found.between_knots,
        at: found.at,
    });
    let json = CheckJson {
        outcome: verdict.outcome().name(),
        reason: (!holds).then(|| reasons.join("; ")),
        start: if path.begins_flat() { "flat" } else { "folded" },
        undecided: undecided.clone(),
        knots: path.knots.len(),
        max_deformation: rigidity.deformation,
        max_gap: rigidity.gap,
        max_closure: verdict.closure(),
        max_bend: verdict.max_bend.to_degrees(),
        certified_deformation: verdict.certified().map(|most| most.deformation),
        certified_of: certified_of(&path.pattern),
        crossings: crossings.collect(),
        min_clearance: verdict.min_clearance,
        contact_tolerance: verdict.contact_tolerance,
        max_speed: verdict.rates.speed.to_degrees(),
        max_acceleration: verdict.rates.acceleration.map(f64::to_degrees),
    };
    if args.report.json {
        print_json(&json)?;
        return Ok(holds);
    }
    print_notes(quiet, path.pattern.assumptions());
    let outcome = outcome(holds, json.outcome);
    let mut text = format!("{}: {outcome}\n", path.title);
    for failure in &failures {
        text += &format!("  fails: {failure}\n");
    }
    for question in &undecided {
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
    text += &format!(
        "  certified for the whole motion: closure {:.1e}, deformation {} of {}\n",
        verdict.closure_bound(),
        (json.certified_deformation).map_or("unknown".into(), |most| format!("{most:.1e}")),
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
