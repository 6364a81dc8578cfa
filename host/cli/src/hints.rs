//! Finds hints for common mistakes, such as a file of another format.

use std::io::Read;
use std::path::Path;

use crate::CliError;
use crate::standard::{argument, is_stdin};
use foldpath::pattern::{CreasePattern, PatternError};
use foldpath::planner::{GoalError, Note, Plan, Reason};
use foldpath::read::{FileError, Mistaken};
use foldpath::request::{PlanRequest, RequestError, Suggestion, two_digits_above};
use foldpath::unfold::{Reason as UnfoldReason, ShapeError};

/// Returns a hint on how to correct an error, if there is one.
pub(crate) fn hint(error: &CliError) -> Option<String> {
    match error {
        CliError::File(error) => of_file(error, &head(error.path())),
        // The content of bytes said their format, not the ending of a name.
        CliError::Piped { error, bytes } if error.mistaken(bytes) == Some(Mistaken::Unknown) => {
            None
        }
        CliError::Piped { error, bytes } => of_file(error, bytes),
        CliError::Request(error @ RequestError::Goal { source, file, .. }) => {
            Some(match Suggestion::of_error(error) {
                Some(change) if change.option == "fold" => {
                    format!("{change}; `--goal FILE` and `--crease I=DEG` name other goals")
                }
                Some(change) => change.to_string(),
                None => of_goal(source, file)?,
            })
        }
        CliError::Request(RequestError::Option { hint, .. }) => hint.clone(),
        _ => None,
    }
}

/// Returns hints on what to do about a plan: changes of an option, then others.
pub(crate) fn of_plan(plan: &Plan, request: &PlanRequest, pattern: &CreasePattern) -> Vec<String> {
    let suggestions = Suggestion::of_plan(plan, pattern);
    let limit = plan.reason.iter().filter_map(|it| of_limit(it, request));
    let together = plan
        .notes
        .iter()
        .any(|it| matches!(it, Note::TurnTogether { .. }));
    let together = together
        .then(|| "`--via FILE` or `--order STEPS` turns some of them before the others".to_owned());
    let changes = suggestions.iter().map(ToString::to_string);
    changes.chain(together).chain(limit).collect()
}

/// Returns a hint on the limit that stops a path, if one does.
fn of_limit(reason: &Reason, request: &PlanRequest) -> Option<String> {
    let Reason::PathStops {
        limited: Some(hinge),
        ..
    } = reason
    else {
        return None;
    };
    let limits = request.limit.iter();
    let mut limits = limits.map(|limit| (limit.edge, limit.degrees));
    let (edge, [lower, upper]) =
        limits.find(|(edge, _)| hinge.edges.iter().any(|member| member.index() == *edge))?;
    Some(format!(
        "`--limit {edge}={lower}..{upper}` holds it; a wider limit lets it turn on"
    ))
}

/// Returns a hint on which option unfolds a shape, if there is one.
pub(crate) fn of_unfolding(reason: &UnfoldReason) -> Option<String> {
    match *reason {
        UnfoldReason::AngleDefect { defect, .. } if defect.abs() <= MAX_NOISE_RAD => {
            Some(max_defect_for(defect))
        }
        UnfoldReason::AngleDefect { .. } | UnfoldReason::RingStaysOpen { .. } => {
            Some("`--cut auto` cuts it".into())
        }
        _ => None,
    }
}

/// Largest error of a shape (radians) for which a hint names `--max-defect`: 1 degree. Larger errors are no noise.
const MAX_NOISE_RAD: f64 = core::f64::consts::PI / 180.0;

/// Returns the hint that names the least `--max-defect` that takes an error (radians) for noise, to two digits.
fn max_defect_for(error: f64) -> String {
    let most = two_digits_above(error.abs().to_degrees());
    format!("`--max-defect {most}` takes that for noise")
}

/// Returns a hint on an error of a file. `head` has the bytes at its beginning.
fn of_file(error: &FileError, head: &[u8]) -> Option<String> {
    if let Some(mistaken) = error.mistaken(head) {
        return Some(match mistaken {
            Mistaken::Shape(format) => format!(
                "it seems to be {}, a folded shape: `foldpath unfold` makes a crease pattern of one",
                format.described()
            ),
            Mistaken::Trajectory => format!("{mistaken}: `foldpath stream` sends it"),
            _ => mistaken.to_string(),
        });
    }
    let path = error.path();
    let text = match error {
        FileError::Io { .. } => {
            let folder = path
                .parent()
                .filter(|folder| !folder.as_os_str().is_empty())?;
            return (!folder.exists()).then(|| format!("there is no folder {}", folder.display()));
        }
        FileError::Trajectory { .. } if head.trim_ascii_start().starts_with(b"{") => {
            "it seems to be a FOLD file: `foldpath export PATH --to traj` makes what a controller follows of a path"
        }
        FileError::Expected { expected, .. } if expected.starts_with("a path, which") => {
            let path = argument(path).display();
            return Some(format!(
                "`foldpath plan {path} -o path.fold` makes one of a crease pattern"
            ));
        }
        FileError::Expected { place, found, .. } if place == "file_frames" && found == "none" => {
            let path = argument(path).display();
            return Some(format!(
                "`foldpath plan {path} -o path.fold` makes a path of it, to use here"
            ));
        }
        FileError::Expected { expected, .. } if expected.starts_with("a flat crease pattern") => {
            "`foldpath unfold` makes a crease pattern of a folded shape"
        }
        FileError::Expected { expected, .. } if expected.ends_with("the 4 GiB of .glb") => {
            "`--frames N` takes fewer frames"
        }
        FileError::Pattern { source, .. } => of_pattern(source)?,
        FileError::Shape {
            source: ShapeError::NotFlat { slope, .. },
            ..
        } if *slope <= MAX_NOISE_RAD => return Some(max_defect_for(*slope)),
        _ => return None,
    };
    Some(text.into())
}

fn of_pattern(error: &PatternError) -> Option<&'static str> {
    match error {
        PatternError::Crossing { .. }
        | PatternError::OnEdge { .. }
        | PatternError::Duplicate { .. } => Some(
            "where a FOLD file names faces it is taken as it is; such places are repaired in lines without, as in SVG, CP and OPX",
        ),
        PatternError::GoalRange { .. } => {
            Some("fold angles are degrees: 0 is flat, 180 folded flat on itself")
        }
        PatternError::GoalSign { .. } => {
            Some("correct the angle or the letter; U lets a hinge turn either way")
        }
        _ => None,
    }
}

fn of_goal(error: &GoalError, file: &str) -> Option<String> {
    let text = match error {
        GoalError::NoDirection if file.to_lowercase().ends_with(".svg") => {
            "draw creases in the colours of M and V, or take dashed lines for them (`--dashes V`); or say where to go: \
             `--goal FILE`, or `--crease I=DEG` for one crease"
        }
        GoalError::NoDirection => {
            "letter creases M or V, or say where to go: `--goal FILE`, or `--crease I=DEG` for one crease"
        }
        _ => return None,
    };
    Some(text.into())
}

/// Number of bytes at the beginning of a file by which its format is recognised.
const HEAD_BYTES: u64 = 512;

/// Returns the first bytes of a file. Pipes and devices are not read: for these there are none, as for stdin.
fn head(path: &Path) -> Vec<u8> {
    let mut head = Vec::new();
    if !is_stdin(path)
        && std::fs::metadata(path).is_ok_and(|found| found.is_file())
        && let Ok(file) = std::fs::File::open(path)
    {
        // A hint is no reason for another error.
        let _unread = file.take(HEAD_BYTES).read_to_end(&mut head);
    }
    head
}
