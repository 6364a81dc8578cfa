//! Changes of an option that may turn a no into a yes: the command prints them, and a page offers them as buttons.

use core::fmt;

use serde::Serialize;

use super::error::RequestError;
use crate::pattern::{CreasePattern, LostLines, NearLines};
use crate::planner::{CHOSEN_REACH, GoalError, Note, Outcome, Plan, Reason};

/// A change of one option that may turn a no into a yes. It displays as a sentence that names the argument of the command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Suggestion {
    /// Name of the option, with `_` between its words.
    pub option: &'static str,
    /// Value that it would have.
    pub value: String,
    /// The sentence about the change: what stands before the option with its value, and what stands after it.
    pub sentence: [String; 2],
}

impl fmt::Display for Suggestion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            option,
            value,
            sentence: [before, after],
        } = self;
        write!(f, "{before}`--{} {value}`{after}", option.replace('_', "-"))
    }
}

impl Suggestion {
    /// A sentence that begins with the option.
    fn new(option: &'static str, value: impl fmt::Display, effect: &str) -> Self {
        Self {
            option,
            value: value.to_string(),
            sentence: [String::new(), format!(" {effect}")],
        }
    }

    /// Returns what may help a plan, in the order of its notes, then what its reason and, if the answer is no, the drawing say.
    #[must_use]
    pub fn of_plan(plan: &Plan, pattern: &CreasePattern) -> Vec<Self> {
        let notes = plan.notes.iter().filter_map(Self::of_note);
        let near = (pattern.near_lines()).filter(|_| plan.outcome != Outcome::Planned);
        notes
            .chain(plan.reason.as_ref().and_then(Self::of_reason))
            .chain(near.and_then(Self::of_near_lines))
            .collect()
    }

    /// Returns what may help a request that cannot be met.
    #[must_use]
    pub fn of_error(error: &RequestError) -> Option<Self> {
        match error {
            RequestError::Goal {
                lost:
                    Some(LostLines {
                        kept_by: Some(tolerance),
                        ..
                    }),
                ..
            } => Some(Self::new("tolerance", tolerance, "keeps all lines")),
            RequestError::Goal {
                source: GoalError::Flat,
                ..
            } => Some(Self::new("fold", 0.5, "folds along the letters")),
            _ => None,
        }
    }

    fn of_note(note: &Note) -> Option<Self> {
        match note {
            Note::WouldBend(most) => Some(Self::new(
                "bend",
                most.to_degrees().ceil(),
                "lets panels bend so far",
            )),
            Note::NotStraightened(how) => {
                let effect = format!(
                    "moves {} vertices by {:.1e} at most, and plans that sheet alone",
                    how.moved, how.farthest
                );
                Some(Self::new("straighten", "on", &effect))
            }
            Note::OverlapsAtGoal(most) => Some(Self::new(
                "contact",
                format_args!("{most:.1e}"),
                "takes that for contact",
            )),
            Note::PartWay(fraction) => Some(Self::new(
                "fold",
                fraction,
                "asks for no more than that, and may do",
            )),
            Note::NoAngles => Some(Self::new(
                "fold",
                0.5,
                "folds every hinge by a right angle, as those of a box",
            )),
            _ => None,
        }
    }

    fn of_reason(reason: &Reason) -> Option<Self> {
        match reason {
            Reason::NearGoal {
                farthest: Some((_, short)),
                flat,
                ..
            } if flat.is_empty() && *short <= CHOSEN_REACH => Some(Self::new(
                "goal_tolerance",
                two_digits_above(short.to_degrees()),
                "takes the configuration that was found",
            )),
            Reason::Deforms { whole, closure, .. } => {
                let most = two_digits_above(whole.deformation.max(whole.gap).max(*closure));
                (most <= 1.0).then(|| Self {
                    option: "bound",
                    value: most.to_string(),
                    sentence: ["it takes ".into(), " at least".into()],
                })
            }
            Reason::NotCertified { certified, .. } => {
                let most = two_digits_above(*certified);
                let effect = "asks for no more than is certified";
                (most <= 1.0).then(|| Self::new("bound", most, effect))
            }
            _ => None,
        }
    }

    /// Returns what joins lines that pass near each other, if something does.
    fn of_near_lines(near: &NearLines) -> Option<Self> {
        let effect = format!("joins lines {:.1e} apart", near.apart);
        Some(Self::new("tolerance", near.joined_by?, &effect))
    }
}

/// Returns the least number of two digits above a positive one.
#[must_use]
pub fn two_digits_above(number: f64) -> f64 {
    let unit = 10_f64.powf(number.log10().floor() - 1.0);
    let enough = (number / unit).floor() + 1.0;
    // Written and read again, as `enough * unit` may have many digits.
    format!("{:.1e}", enough * unit).parse().unwrap_or(number)
}
