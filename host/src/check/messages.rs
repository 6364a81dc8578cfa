//! Sentences of the check: what it finds against a path, in words.

use core::fmt::{Display, Formatter, Result};

use super::finding::{Failure, GroupQuantity, Moment, RateLimit, SheetError, Undecided, WrongTurn};
use crate::pattern::{ClosureSite, EdgeId, Letter};

impl Display for Moment {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match *self {
            Self::Knot(knot) => write!(f, "knot {knot}"),
            Self::Between { segment, s } => {
                write!(f, "between knots {segment} and {}, at {s:.3}", segment + 1)
            }
        }
    }
}

impl Display for SheetError {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str(match self {
            Self::Deformation => "deformation",
            Self::Gap => "gap",
            Self::Closure => "closure",
        })
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::BoundIsNotANumber => {
                f.write_str("bound: expected a number, found NaN, which nothing exceeds")
            }
            Self::Turns {
                at,
                edge,
                letter,
                wrong,
                value,
            } => turns(f, *at, *edge, *letter, *wrong, *value),
            Self::GroupDiffers {
                knot,
                edges: [leader, edge],
                group,
                quantity,
                values,
            } => {
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
                let group = group.0;
                write!(
                    f,
                    "knot {knot}: edges {leader} and {edge} are in group {group}, but {verb} {a} and {b}{unit}, \
                     signs applied"
                )
            }
            Self::FalseClaim {
                knot,
                error,
                claimed,
                found,
            } => write!(
                f,
                "knot {knot}: the file claims a {error} of {claimed:.3e}, but it is {found:.3e}"
            ),
            Self::FalseRate {
                limit,
                claimed,
                found,
            } => {
                let (what, unit) = match limit {
                    RateLimit::Speed => ("speed", "degrees per second"),
                    RateLimit::Acceleration => ("acceleration", "degrees per second squared"),
                };
                let claimed = claimed.to_degrees();
                write!(
                    f,
                    "the file claims a largest {what} of {claimed:.3e} {unit}, but "
                )?;
                if found.is_finite() {
                    write!(f, "it is {:.3e}", found.to_degrees())
                } else {
                    f.write_str("hinges change their speed at once")
                }
            }
            Self::FalseClearance {
                knot,
                claimed,
                found,
            } => write!(
                f,
                "knot {knot}: the file claims a clearance of {claimed:.3e}, but it is {found:.3e}"
            ),
            Self::FalseBound { claimed, found } => write!(
                f,
                "the file says that it was planned within the bound {claimed:.3e}, but has errors of {found:.3e}"
            ),
            Self::OverBound {
                at,
                error,
                value,
                bound,
                open,
            } => {
                write!(f, "{at}: {error} {value:.3e} over the bound {bound:.3e}")?;
                match open {
                    Some((vertex, residual)) => {
                        write!(f, "; vertex {vertex} fails to close by {residual:.3e}")
                    }
                    None => Ok(()),
                }
            }
            Self::FailsToClose {
                at,
                site,
                residual,
                bound,
            } => write!(
                f,
                "{at}: {} fails to close by {residual:.3e}, over the bound {bound:.3e}",
                Site(*site)
            ),
            Self::Crosses {
                at,
                crossing,
                depth_edges,
            } => {
                let [a, b] = crossing.faces;
                write!(
                    f,
                    "{at}: faces {a} and {b} pass through each other, {depth_edges:.3e} median edges deep"
                )
            }
        }
    }
}

/// Writes what is wrong with the turn of a hinge.
fn turns(
    f: &mut Formatter<'_>,
    at: Moment,
    edge: EdgeId,
    letter: Letter,
    wrong: WrongTurn,
    value: f64,
) -> Result {
    let (code, degrees) = (letter.code(), value.to_degrees());
    let at_knot = matches!(at, Moment::Knot(_));
    write!(f, "{at}: edge {edge} ")?;
    match wrong {
        WrongTurn::BeyondHalfTurn if at_knot => {
            write!(f, "is at {degrees} degrees, beyond half a turn")
        }
        WrongTurn::BeyondHalfTurn => write!(f, "turns beyond half a turn, to {degrees} degrees"),
        WrongTurn::AgainstLetter if at_knot => {
            write!(
                f,
                "is lettered {code}, but is at {degrees} degrees: wrong sign"
            )
        }
        WrongTurn::AgainstLetter => {
            write!(f, "is lettered {code}, but turns to {degrees} degrees")
        }
        WrongTurn::BeyondBend => write!(
            f,
            "bends its panel by {degrees} degrees, more than its bound or the file allows"
        ),
        WrongTurn::NotFlat => write!(
            f,
            "is lettered {code} and must stay flat, but is at {degrees} degrees"
        ),
        WrongTurn::FlatButTurns => write!(
            f,
            "is lettered {code} and must stay flat, but turns by {degrees} degrees a second"
        ),
        WrongTurn::NotANumber => write!(f, "turns to {degrees} degrees"),
    }
}

impl Display for Undecided {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Errors {
                segment,
                site,
                closure,
                error,
                bound,
            } => write!(
                f,
                "not certified: between knots {segment} and {}, {} fails to close by up to {closure:.3e}, and the \
                 sheet may deform or tear by {error:.3e}, over the bound {bound:.3e}",
                segment + 1,
                Site(*site)
            ),
            Self::Angle { at, edge } => write!(
                f,
                "not certified: {at}, the fold angle of edge {edge} is not known, as its weights vanish"
            ),
            Self::Clearance { knot, claimed } => write!(
                f,
                "knot {knot}: the file claims a clearance of {claimed:.3e}, and measuring it would take too long"
            ),
            Self::Crossings { at, faces } => {
                write!(
                    f,
                    "not certified: {at}, whether faces pass through each other takes too long to tell"
                )?;
                match faces {
                    Some([a, b]) => write!(f, ": faces {a} and {b}"),
                    None => Ok(()),
                }
            }
            Self::Cancelled => f.write_str("cancelled before it was judged to its end"),
        }
    }
}

/// A vertex or hole that may be unknown.
struct Site(Option<ClosureSite>);

impl Display for Site {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        self.0.map_or(Ok(()), |site| site.fmt(f))
    }
}
