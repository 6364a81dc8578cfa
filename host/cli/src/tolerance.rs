//! Runs `foldpath tolerance`, which tells how exactly a sheet has to be made.

use crate::args::{Scale, Tolerance as Args};
use crate::progress::watched;
use crate::report::out_of_time;
use crate::standard::{Input, source};
use crate::{Answer, CliError, print, print_json, print_notes};
use foldpath::progress::Watch;
use foldpath::request::ToleranceJson;
use foldpath::sensitivity::{FROM_DEG, NoTolerance, Tolerance};

/// Number of hinges and vertices that the summary lists.
const LISTED: usize = 8;

pub(crate) fn run(args: &Args, quiet: bool) -> Answer {
    let deadline = args.until.deadline()?;
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
    let mut text = match error.zip(tolerance.worst()) {
        None => format!("{}: no error needs play\n", motion.title),
        Some((error, worst)) => format!(
            "{}: errors of up to {} in each coordinate of each vertex need play of up to {}\n  \
             at {:.3} s, hinge {}: {}; from the moment that a hinge is folded by {FROM_DEG} degrees\n",
            motion.title,
            length(error, unit),
            length(json.max_play, unit),
            worst.at,
            motion.pattern.creases()[worst.crease.index()],
            worst.kind.name(),
        ),
    };
    if json.max_play > FROM_DEG.to_radians() * motion.pattern.median_edge() {
        text += "  so much play is beyond first order: read it as too much, not as a figure\n";
    }
    let hinges = json.hinges.iter().take_while(|hinge| hinge.worst > 0.0);
    let hinges: Vec<String> = (hinges.take(LISTED))
        .map(|it| {
            format!(
                "    {:>5}  {:<12.4e}  {:.4e}\n",
                it.edge, it.worst, it.expected
            )
        })
        .collect();
    let vertices = json.vertices.iter().take_while(|vertex| vertex.cost > 0.0);
    let vertices: Vec<String> = (vertices.take(LISTED))
        .map(|it| format!("    {:>5}  {:.4e}\n", it.vertex, it.cost))
        .collect();
    let lists = [
        ("hinges by their play: edge, worst case, expected", hinges),
        (
            "vertices by the play that their error alone needs",
            vertices,
        ),
    ];
    for (title, lines) in lists.iter().filter(|(_, lines)| !lines.is_empty()) {
        text += &format!("  {title}\n{}", lines.concat());
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
