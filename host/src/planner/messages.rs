//! Sentences of the planner: reasons and notes in words.

use core::fmt::{Display, Formatter, Result};

use super::reason::{
    FirstSteps, GroupsDropped, HingeAtLimit, Note, ProofOrder, Reason, Stop, TimeoutAt, Undecided,
    WorstClosure,
};
use crate::collision::{Crossing, Thickest, TooThick};
use crate::pattern::EdgeId;

/// Largest number of edges or faces that a sentence names.
const MAX_NAMED: usize = 12;
/// Largest distance of a goal from where it was asked, radians, with which it counts as not moved.
const UNMOVED_RAD: f64 = 1e-12;

impl Display for WorstClosure {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let Self { site, residual, .. } = self;
        let edges = Edges(&self.edges);
        write!(
            f,
            "{site} (creases: {edges}) does not close: residual {residual:.1e}"
        )
    }
}

/// A list of edges, of which the first are named.
struct Edges<'a>(&'a [EdgeId]);

impl Display for Edges<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "edges {}", first_of(self.0, MAX_NAMED))
    }
}

/// Lists the first ids, at most this number, and counts the others.
pub(super) fn first_of(ids: &[impl Display], most: usize) -> String {
    let first = ids.iter().take(most);
    let first: Vec<String> = first.map(ToString::to_string).collect();
    let first = first.join(", ");
    match ids.len().saturating_sub(most) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

impl Display for TimeoutAt {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::ClosingGoal => f.write_str("closing the goal"),
            Self::Following => f.write_str("following the path"),
            Self::PlacingKnots => f.write_str("placing knots"),
            Self::JudgingKnot(knot) => write!(f, "judging knot {knot}"),
            Self::LookingForCrossings => f.write_str("looking for crossings"),
            Self::LookingForOtherWays => f.write_str("looking for other ways to the goal"),
        }
    }
}

impl Display for Undecided {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::OutOfTime(at) => write!(
                f,
                "the path was not judged to its end: time ran out while {at}"
            ),
            Self::Crossings { faces, segment } => {
                f.write_str("crossings are not decided: the search gave up")?;
                if let Some([a, b]) = faces {
                    write!(f, " at the pair of faces {a} and {b}")?;
                }
                write!(f, " between knots {segment} and {}", segment + 1)
            }
            Self::Plates { faces, segment } => {
                f.write_str("crossings of plates are not decided: the search gave up")?;
                if let Some([a, b]) = faces {
                    write!(f, " at panels {a} and {b}")?;
                }
                write!(f, " between knots {segment} and {}", segment + 1)
            }
            Self::CrossingsAtKnots { faces } => write!(
                f,
                "crossings were looked for at knots alone: the search over the motion of {faces} faces gave up"
            ),
        }
    }
}

impl Display for Reason {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Undecided(question) => question.fmt(f),
            Self::OutOfTime(at) => write!(f, "out of time while {at}"),
            Self::GoalNotClosed {
                goal,
                nearest,
                worst,
            } => {
                write!(f, "no closed configuration was found near {goal}")?;
                if let Some(nearest) = nearest {
                    let degrees = nearest.to_degrees();
                    write!(
                        f,
                        ": the nearest found turns a crease {degrees:.1} degrees from its goal"
                    )?;
                }
                match worst {
                    Some(worst) => write!(f, "; there {worst}"),
                    None => Ok(()),
                }
            }
            Self::NearGoal {
                goal,
                farthest,
                flat,
            } => {
                write!(f, "the path ends near {goal}, not there")?;
                if let Some((edge, short)) = farthest {
                    let degrees = short.to_degrees();
                    write!(f, ": edge {edge} is {degrees:.1} degrees off")?;
                }
                match flat.len() {
                    0 => Ok(()),
                    1 => write!(f, "; 1 lettered crease stays flat: {}", Edges(flat)),
                    n => write!(f, "; {n} lettered creases stay flat: {}", Edges(flat)),
                }
            }
            Self::PathStops {
                reached,
                stop,
                at_flat,
                limited,
                worst,
            } => {
                write!(f, "{}: ", of_the_goal(*reached))?;
                match at_flat {
                    Some(steps) if *stop == Stop::Singular => steps.fmt(f)?,
                    _ => f.write_str(stop_in_words(*stop))?,
                }
                match (limited, worst) {
                    (Some(HingeAtLimit { edges, angle }), _) => {
                        let degrees = angle.to_degrees();
                        write!(f, " of {degrees:.1} degrees: {}", Edges(edges))
                    }
                    (_, Some(worst)) => write!(f, "; going on straight, {worst}"),
                    (_, None) => Ok(()),
                }
            }
            Self::ProofStops {
                reached,
                certified,
                bound,
            } => write!(
                f,
                "{}: the motion found beyond closes where it was looked at, but between is certified only to \
                 {certified:.1e}, over the bound of {bound:.1e}",
                of_the_goal(*reached)
            ),
            Self::NotCertified { certified, bound } => write!(
                f,
                "the sheet keeps the bound at the knots, but between them it is certified only to {certified:.1e}, \
                 over the bound of {bound:.1e}"
            ),
            Self::Deforms {
                whole,
                closure,
                essential,
                bound,
            } => write!(
                f,
                "measured at its knots, the whole sheet deforms by {:.3e} with gaps of {:.3e} and closure {closure:.3e}, over the bound \
                 {bound:.3e}; its essential crease pattern by {:.3e} with gaps of {:.3e}",
                whole.deformation, whole.gap, essential.deformation, essential.gap
            ),
            Self::DeformsFromRim { rigidity, bound } => write!(
                f,
                "measured at its knots and folded from a face at its rim, the sheet deforms by {:.3e} with gaps of {:.3e}, over the bound \
                 {bound:.3e}",
                rigidity.deformation, rigidity.gap
            ),
            Self::TooManyKnots { budget } => write!(
                f,
                "the bound needs more than {budget} knots with this interpolation"
            ),
            Self::Crosses {
                faces: [a, b],
                reached,
                free,
                segment,
                depth,
            } => write!(
                f,
                "faces {a} and {b} pass through each other beyond {:.2} % of the path (between knots {segment} and \
                 {}: {depth:.1e} median edges deep)",
                100.0 * reached * free,
                segment + 1
            ),
            Self::CrossesAtKnot {
                faces: [a, b],
                knot,
            } => write!(
                f,
                "faces {a} and {b} pass through each other at knot {knot}"
            ),
            Self::GoalCrosses {
                faces: [a, b],
                path,
            } => write!(
                f,
                "at the goal faces {a} and {b} pass through each other; {path}"
            ),
            Self::NoFoldSequence => {
                f.write_str("no sequence of folds was found that is free of crossings")
            }
            Self::PlatesCross {
                faces: [a, b],
                thickness,
                segment,
            } => write!(
                f,
                "panels {a} and {b} pass through each other between knots {segment} and {} if they are plates {thickness} \
                 thick",
                segment + 1
            ),
            Self::PlatesNotMade(error) => error.fmt(f),
            Self::NoWayRound => f.write_str("no way round the crossing was found"),
        }
    }
}

/// Returns a fraction of the way to the goal as a percentage for people: below 100 for a path that ends before its goal.
pub(super) fn percent(reached: f64, is_end: bool) -> f64 {
    (100.0 * reached).min(if is_end { 100.0 } else { 99.9 })
}

/// Says how far a path leads that ends before the goal.
fn of_the_goal(reached: f64) -> String {
    let percent = percent(reached, false);
    format!("as far as {percent:.1} % of the goal's angles")
}

impl Display for FirstSteps {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let (locked, free) = match self {
            Self::NoneProved(order) => {
                let order = match order {
                    ProofOrder::First => "first",
                    ProofOrder::Second => "second",
                };
                let says = "no motion leaves the flat sheet with these signs";
                return write!(f, "{says} (proved to {order} order)");
            }
            Self::NotKnown => {
                return f
                    .write_str("no motion was found that leaves the flat sheet with these signs");
            }
            Self::Some { locked, free } => (locked, free),
        };
        f.write_str("not all creases can turn with these signs")?;
        if !locked.is_empty() {
            write!(f, "; locked: {}", Edges(locked))?;
        }
        if !free.is_empty() {
            write!(f, "; free, as lines that turn alone: {}", Edges(free))?;
        }
        Ok(())
    }
}

/// Says why a path stops that has left flat.
fn stop_in_words(stop: Stop) -> &'static str {
    match stop {
        Stop::Singular => "no motion was found that leads on (singular)",
        Stop::Closure => "no closed configuration was found that follows (closure)",
        Stop::Nearest => "the motion leads no nearer to the goal (closure)",
        Stop::Limit(_) => "a hinge is at its limit",
        Stop::TooLong => "the motion goes on without coming nearer to the goal (closure)",
        Stop::Timeout => "out of time",
    }
}

impl Display for GroupsDropped {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str(match self {
            Self::GoalNotClosed => "the goal does not close under them",
            Self::FoldsFarther => "the sheet folds farther without them",
            Self::LessDeformation => "without them less deformation is proved",
        })
    }
}

impl Display for Note {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::GroupsDropped { groups, why } => {
                write!(f, "{groups} crease groups dropped: {why}")
            }
            Self::RoughGroups { groups, tolerance } => write!(
                f,
                "{groups} crease groups: the sheet is symmetric only to {tolerance:.0e} of its median edge"
            ),
            Self::Branches(branches) => write!(
                f,
                "{branches} first steps found that leave the flat sheet with these signs; the path takes that which \
                 leads farthest"
            ),
            Self::OtherCompletions(others) => {
                let [s, their] = if *others == 1 { ["", "has"] } else { ["s", "have"] };
                write!(
                    f,
                    "{others} other closed configuration{s} found {their} the driven creases at their angles; letters or \
                     more driven creases choose between them"
                )
            }
            Self::Straightened(how) => {
                write!(f, "{how}, as the sheet was not planned as it is drawn")
            }
            Self::NotStraightened(how) => {
                write!(f, "time ran out before the sheet was planned {how}")
            }
            Self::PlatesNotJudged => {
                f.write_str("plates were not judged: they are judged along a path that reaches its goal")
            }
            Self::Thickest(found) => thickest_in_words(found, f),
            Self::CornersCut(count) => write!(
                f,
                "{count} corners of panels are cut off: panels that share a vertex and no hinge at it would pass through \
                 each other there"
            ),
            Self::FoundAtRandom => f.write_str("the path was found by the randomised search"),
            Self::Snapped { turned } => write!(
                f,
                "creases turned by up to {:.1e} degrees are folded as if the sheet folded flat exactly: its \
                 coordinates are rounded",
                turned.to_degrees()
            ),
            Self::GoalMoved {
                goal,
                residual,
                moved,
            } => {
                write!(f, "not closed: {goal} (residual {residual:.1e}); ")?;
                if *moved <= UNMOVED_RAD {
                    return f.write_str(
                        "taken as it is, since the sheet closes there as nearly as its bound allows",
                    );
                }
                write!(
                    f,
                    "moved to the nearest configuration found that is, {:.2e} degrees away",
                    moved.to_degrees()
                )
            }
            Self::Deforming => f.write_str(
                "no exact motion leads to the goal; the sheet is taken there straight, deforming",
            ),
            Self::NearlyClosed => f.write_str(
                "no exact motion leads to the goal, as coordinates are rounded; on the way the sheet nearly closes, within \
                 its bound",
            ),
            Self::EndsBeforeCrossing {
                residual,
                crossing,
                short,
            } => write!(
                f,
                "the goal itself does not close (residual {residual:.1e}), and near it {crossing}: the path ends \
                 {:.3} degrees before",
                short.to_degrees()
            ),
            Self::Phases(phases) => write!(
                f,
                "folded in {phases} phases: all creases cannot turn at once"
            ),
            Self::RingsFirst(edges) => write!(f, "{} close a ring before the others fold", Edges(edges)),
            Self::TurnsPast { edges, by } => write!(
                f,
                "{} turn up to {:.1} degrees past their goals and return, so that what is on them clears the rest",
                Edges(edges),
                by.to_degrees()
            ),
            Self::OverlapsAtGoal(most) => write!(
                f,
                "at the goal faces are in each other by less than {most:.1e} median edges"
            ),
            Self::WouldBend(most) => write!(
                f,
                "the sheet would fold if its panels might bend by {:.1} degrees",
                most.to_degrees()
            ),
            Self::PartWay(fraction) => write!(
                f,
                "the way found leads along the letters to {fraction} of a half turn"
            ),
            Self::NoAngles => f.write_str(
                "no goal angles are named, and folded flat by its letters the sheet was not planned",
            ),
            Self::TurnTogether {
                faces: [a, b],
                edges,
            } => write!(
                f,
                "faces {a} and {b} meet as these hinges turn: {}; in another order they may pass",
                Edges(edges)
            ),
            Self::NoLayerOrder(faces) => write!(
                f,
                "at the goal, which lies flat, faces {} pass through each other in whatever order they are stacked: with \
                 these letters no order of folds leads there",
                first_of(faces, MAX_NAMED)
            ),
            Self::GoalItselfCrosses {
                faces: [a, b],
                depth,
            } => write!(
                f,
                "at the goal itself faces {a} and {b} are {depth:.1e} median edges in each other: no order of folds leads \
                 there"
            ),
            Self::PlatesCrossAtGoal {
                faces: [a, b],
                depth,
                thickness,
            } => write!(
                f,
                "at the goal itself panels {a} and {b}, {thickness} thick, are {depth:.3} in each other, so that no other order \
                 of folds was tried; panels that lie on each other have to be drawn a thickness apart"
            ),
            Self::TurnedFreely { mountains, valleys } => {
                f.write_str(
                    "hinges that have neither goal nor letter turned as the sheet closes first",
                )?;
                let sides = [("mountains", mountains), ("valleys", valleys)];
                for (what, edges) in sides.into_iter().filter(|(_, edges)| !edges.is_empty()) {
                    write!(f, ", as {what} {}", Edges(edges))?;
                }
                f.write_str("; letters choose another way, if there is one")
            }
            Self::ErrorsAddedUp { closure } => write!(
                f,
                "vertices fail to close by up to {closure:.1e}: at worst that adds up to more than the bound; what it \
                 does add up to is certified of the sheet folded from its middle and from its rim alone"
            ),
        }
    }
}

/// Says how thick plates may be, and what is in the way of thicker ones.
fn thickest_in_words(found: &Thickest, f: &mut Formatter<'_>) -> Result {
    if found.proved > 0.0 {
        let proved = found.proved;
        write!(f, "plates up to {proved:.6} thick are proved to fold")?;
    } else {
        f.write_str("plates of no thickness are proved to fold")?;
    }
    match found.refuted {
        None => f.write_str("; none is too thick, up to the width of the sheet")?,
        Some((thickness, TooThick::NotMade(error))) => write!(f, "; at {thickness:.6}, {error}")?,
        Some((thickness, TooThick::Cross(Crossing { faces: [a, b], .. }, at))) => write!(
            f,
            "; at {thickness:.6}, panels {a} and {b} pass through each other between knots {} and {}",
            at.segment,
            at.segment + 1
        )?,
    }
    if found.is_open {
        f.write_str("; between the two the search gave up")?;
    }
    Ok(())
}
