//! The parts of the check's sentences for which a format is not enough.

use super::finding::{GroupQuantity, Moment, RateLimit, WrongTurn};
use crate::pattern::Letter;

/// Says which values differ in a group.
pub(super) fn differing(quantity: GroupQuantity, values: [f64; 2]) -> String {
    let (verb, unit) = match quantity {
        GroupQuantity::Angle => ("turn to", " degrees"),
        GroupQuantity::Rate => ("turn at", " degrees a second"),
        GroupQuantity::Weight => ("have weights of", ""),
        GroupQuantity::WeightGrowth => ("have weights that grow by", " a second"),
    };
    let [a, b] = values.map(|value| match quantity {
        GroupQuantity::Angle | GroupQuantity::Rate => value.to_degrees(),
        GroupQuantity::Weight | GroupQuantity::WeightGrowth => value,
    });
    format!("{verb} {a} and {b}{unit}, signs applied")
}

/// Says what is claimed and what is found of a limit.
pub(super) fn rate(limit: RateLimit, claimed: f64, found: f64) -> String {
    let (what, unit) = match limit {
        RateLimit::Speed => ("speed", "degrees per second"),
        RateLimit::Acceleration => ("acceleration", "degrees per second squared"),
    };
    let but = if found.is_finite() {
        format!("it is {:.3e}", found.to_degrees())
    } else {
        "hinges change their speed at once".into()
    };
    format!("{what} of {:.3e} {unit}, but {but}", claimed.to_degrees())
}

/// Says what is wrong with the turn of a hinge.
pub(super) fn turns(at: Moment, letter: Letter, wrong: WrongTurn, value: f64) -> String {
    let (code, degrees) = (letter.code(), value.to_degrees());
    let at_knot = matches!(at, Moment::Knot(_));
    match wrong {
        WrongTurn::BeyondHalfTurn if at_knot => {
            format!("is at {degrees} degrees, beyond half a turn")
        }
        WrongTurn::BeyondHalfTurn => format!("turns beyond half a turn, to {degrees} degrees"),
        WrongTurn::AgainstLetter if at_knot => {
            format!("is lettered {code}, but is at {degrees} degrees: wrong sign")
        }
        WrongTurn::AgainstLetter => format!("is lettered {code}, but turns to {degrees} degrees"),
        WrongTurn::BeyondBend => {
            format!("bends its panel by {degrees} degrees, more than its bound or the file allows")
        }
        WrongTurn::NotFlat => {
            format!("is lettered {code} and must stay flat, but is at {degrees} degrees")
        }
        WrongTurn::FlatButTurns => {
            format!(
                "is lettered {code} and must stay flat, but turns by {degrees} degrees a second"
            )
        }
        WrongTurn::NotANumber => format!("turns to {degrees} degrees"),
    }
}

/// Says something, if it is known.
pub(super) fn known<T>(it: Option<T>, say: impl FnOnce(T) -> String) -> String {
    it.map_or_else(String::new, say)
}
