//! Runs `foldpath tolerance`, which tells how exactly a sheet has to be made.

use std::time::Instant;

use crate::args::{Scale, Tolerance as Args};
use crate::progress::watched;
use crate::report::out_of_time;
use crate::standard::{Input, source};
use crate::{Answer, CliError, print, print_json, print_notes};
use foldpath::progress::Watch;
use foldpath::request::{ToleranceJson, timeout};
use foldpath::sensitivity::{FROM_DEG, NoTolerance, Tolerance};

/// Number of hinges and vertices that the summary lists.
const LISTED: usize = 8;

pub(crate) fn run(args: &Args, quiet: bool) -> Answer {
    let deadline = timeout(args.timeout)?.and_then(|time| Instant::now().checked_add(time));
    let motion = Input::of(&args.path)?.motion_for("tolerance")?;
    let tolerance = watched(&args.report, quiet, |progress| {
        Tolerance::of(&motion, Watch::new(progress).until(deadline))
    });
    let tolerance = match tolerance {
        Err(no @ NoTolerance::Cancelled) => return out_of_time(&args.path, no, &args.report),
        found => found.map_err(|no| CliError::Usage(format!("{}: {no}", source(&args.path))))?,
    };
    let error = error_of(&args.scale, &tolerance);
    let json = ToleranceJson::of(&motion, &tolerance, error);
    if args.report.json {
        print_json(&json)?;
        return Ok(true);
    }
    print_notes(quiet, motion.pattern.assumptions());
    let unit = json.unit;
    let Some((error, worst)) = error.zip(tolerance.worst()) else {
        print(&format!("{}: no error needs play\n", motion.title))?;
        return Ok(true);
    };
    let mut text = format!(
        "{}: errors of up to {} in each coordinate of each vertex need play of up to {}\n  \
         at {:.3} s, hinge {}: {}; from the moment that a hinge is folded by {FROM_DEG} degrees\n",
        motion.title,
        length(error, unit),
        length(json.max_play, unit),
        worst.at,
        motion.pattern.creases()[worst.crease.index()],
        worst.kind.name(),
    );
    text += "  hinges by their play: edge, worst case, expected\n";
    for hinge in json.hinges.iter().take(LISTED) {
        text += &format!(
            "    {:>5}  {:<12.4e}  {:.4e}\n",
            hinge.edge, hinge.worst, hinge.expected
        );
    }
    text += "  vertices by the play that their error alone needs\n";
    for vertex in json.vertices.iter().take(LISTED) {
        text += &format!("    {:>5}  {:.4e}\n", vertex.vertex, vertex.cost);
    }
    text += &match json.redundant.len() {
        0 => "  no hinge may be cut: the rest would have another motion\n".to_string(),
        count => {
            let named: Vec<String> = json
                .redundant
                .iter()
                .take(24)
                .map(ToString::to_string)
                .collect();
            let more = if count > named.len() { ", ..." } else { "" };
            format!(
                "  {count} hinges of which each may be cut, or given any play, without another motion: {}{more}\n",
                named.join(", ")
            )
        }
    };
    print(&text)?;
    Ok(true)
}

/// Returns the error that is named, or that a play allows; `None` if no error needs play.
pub(crate) fn error_of(scale: &Scale, tolerance: &Tolerance) -> Option<f64> {
    (scale.error).or_else(|| tolerance.error_for(scale.play?))
}

/// Returns a length with its unit.
fn length(length: f64, unit: Option<&str>) -> String {
    format!("{length:.4e} {}", unit.unwrap_or("units of the file"))
}
