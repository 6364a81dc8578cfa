//! Reasons of an answer and remarks on it, as data: what happened, where, and by how much. The sentences are made of
//! them in `messages.rs`.

use crate::collision::{PlateError, Thickest};
use crate::folding::Rigidity;
use crate::pattern::{ClosureSite, EdgeId, FaceId};
use crate::straighten::Straightened;

/// Reason why path following stops before its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// No motion leads on.
    Singular,
    /// The corrector finds no closed configuration within the smallest step.
    Closure,
    /// The motion leads no nearer to the target, but has not reached it.
    Nearest,
    /// This unknown is at its limit.
    Limit(usize),
    /// Out of time.
    Timeout,
    /// The motion goes on without coming nearer to the target.
    TooLong,
}

/// The vertex or hole that closes worst.
#[derive(Clone, Debug, PartialEq)]
pub struct WorstClosure {
    /// The vertex or hole.
    pub site: ClosureSite,
    /// Edges of its hinges.
    pub edges: Vec<EdgeId>,
    /// Its closure residual.
    pub residual: f64,
}

/// A hinge at its limit: that of the option, or flat, or half a turn.
#[derive(Clone, Debug, PartialEq)]
pub struct HingeAtLimit {
    /// Its edge, and those of all hinges that turn as it does.
    pub edges: Vec<EdgeId>,
    /// Fold angle of the first edge at the limit, radians.
    pub angle: f64,
}

/// Work of the planner during which time ran out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeoutAt {
    /// Closing the goal.
    ClosingGoal,
    /// Following the path.
    Following,
    /// Placing knots.
    PlacingKnots,
    /// Judging the knot of this number.
    JudgingKnot(usize),
    /// Looking for crossings.
    LookingForCrossings,
    /// Looking for other ways to a goal on whose straight way faces cross.
    LookingForOtherWays,
}

/// A question that a plan leaves open. `Display` makes a sentence of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Undecided {
    /// Time ran out before the path was judged to its end.
    OutOfTime(TimeoutAt),
    /// The search for crossings gave up.
    Crossings {
        /// The two faces that are not decided, if they are known.
        faces: Option<[FaceId; 2]>,
        /// Number of the knot after which they are not decided.
        segment: usize,
    },
    /// Crossings were looked for at knots alone, as the search over the motion gave up.
    CrossingsAtKnots {
        /// Number of faces.
        faces: usize,
    },
    /// The search for crossings of plates gave up.
    Plates {
        /// Faces of the two panels that are not decided, if they are known.
        faces: Option<[FaceId; 2]>,
        /// Number of the knot after which they are not decided.
        segment: usize,
    },
}

/// Order, in the rates of creases, of the conditions of a proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProofOrder {
    /// The sheet closes to first order only if no crease turns.
    First,
    /// Creases could turn to first order, but then the sheet would not close to second order.
    Second,
}

/// Knowledge of the first steps from flat in the directions asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum FirstSteps {
    /// It is proved that no motion leaves flat, for every sheet whose coordinates are written with these digits.
    NoneProved(ProofOrder),
    /// It is proved that some creases cannot turn, or that some can while all others rest.
    Some {
        /// Edges that cannot turn in a first step.
        locked: Vec<EdgeId>,
        /// Edges of lines that turn alone.
        free: Vec<EdgeId>,
    },
    /// None was found, and nothing is proved.
    #[default]
    NotKnown,
}

/// Reason why an outcome is not [`Planned`](super::Outcome::Planned). `Display` makes a sentence of it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Reason {
    /// A path was found, but this question is open.
    Undecided(Undecided),
    /// Time ran out.
    OutOfTime(TimeoutAt),
    /// No closed configuration was found near a goal.
    GoalNotClosed {
        /// Source of the goal's angles, in words.
        goal: String,
        /// Distance (radians) of the nearest closed configuration that was found, if any was.
        nearest: Option<f64>,
        /// Vertex or hole that is farthest from closing at the goal, if one fails to close.
        worst: Option<WorstClosure>,
    },
    /// The path ends at a closed configuration that is not the goal.
    NearGoal {
        /// Source of the goal's angles, in words.
        goal: String,
        /// The crease that is farthest from its goal and its distance, radians, if that is over the tolerance. If
        /// letters ask for a fraction of a half turn, this is the crease that turns most, and the angle it lacks.
        farthest: Option<(EdgeId, f64)>,
        /// Creases lettered M or V that stay flat.
        flat: Vec<EdgeId>,
    },
    /// The path ends before the goal.
    PathStops {
        /// Fraction of the goal's angles that is reached.
        reached: f64,
        /// Reason why the path ends.
        stop: Stop,
        /// Knowledge of the first steps, if the path does not even leave flat.
        at_flat: Option<FirstSteps>,
        /// The hinge that is at its limit, if one is.
        limited: Option<HingeAtLimit>,
        /// Vertex or hole that a small step straight to the goal would tear most.
        worst: Option<WorstClosure>,
    },
    /// The motion is not proved to keep the bound beyond this fraction of the goal's angles.
    ProofStops {
        /// Fraction of the goal's angles that is reached.
        reached: f64,
        /// Deformation that is certified beyond.
        certified: f64,
        /// Bound that the sheet has to keep.
        bound: f64,
    },
    /// The sheet keeps the bound at its knots, but is not proved to keep it between them.
    NotCertified {
        /// Deformation that is certified.
        certified: f64,
        /// Bound that the sheet has to keep.
        bound: f64,
    },
    /// The sheet breaks the bound at a knot.
    Deforms {
        /// Largest errors of the whole sheet.
        whole: Rigidity,
        /// Largest closure residual.
        closure: f64,
        /// Largest errors of the essential crease pattern.
        essential: Rigidity,
        /// Bound that the sheet has to keep.
        bound: f64,
    },
    /// The sheet breaks the bound when it is folded from a face at its rim.
    DeformsFromRim {
        /// Largest errors of the sheet folded from there.
        rigidity: Rigidity,
        /// Bound that the sheet has to keep.
        bound: f64,
    },
    /// The bound needs more knots than allowed.
    TooManyKnots {
        /// Largest number of knots.
        budget: usize,
    },
    /// Faces pass through each other on the way.
    Crosses {
        /// The two faces.
        faces: [FaceId; 2],
        /// Fraction of the goal's angles that the path has at its end.
        reached: f64,
        /// Fraction of the path that is free of crossings.
        free: f64,
        /// Number of the knot after which they cross.
        segment: usize,
        /// Depth of the crossing, in median edges.
        depth: f64,
    },
    /// Faces pass through each other at a knot.
    CrossesAtKnot {
        /// The two faces.
        faces: [FaceId; 2],
        /// Number of the knot.
        knot: usize,
    },
    /// Faces pass through each other at the goal, which the path does not reach in any case.
    GoalCrosses {
        /// The two faces.
        faces: [FaceId; 2],
        /// Reason why the path does not reach the goal.
        path: Box<Reason>,
    },
    /// No sequence of folds was found that is free of crossings.
    NoFoldSequence,
    /// The faces that cross could not be led round each other.
    NoWayRound,
    /// Plates pass through each other on the path of the sheet without a thickness.
    PlatesCross {
        /// Faces of the two panels.
        faces: [FaceId; 2],
        /// Thickness of the plates, units of the sheet.
        thickness: f64,
        /// Number of the knot after which they cross.
        segment: usize,
    },
    /// The panels cannot be plates.
    PlatesNotMade(PlateError),
}

/// Reason why crease groups were dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroupsDropped {
    /// The goal does not close under them.
    GoalNotClosed,
    /// The sheet folds farther without them.
    FoldsFarther,
    /// Less deformation is proved without them.
    LessDeformation,
}

/// Remark on a plan for the user. `Display` makes a sentence of it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// Crease groups were found, but are not used.
    GroupsDropped {
        /// Number of groups.
        groups: usize,
        /// Reason why they are not used.
        why: GroupsDropped,
    },
    /// The sheet has the symmetry of its crease groups only nearly.
    RoughGroups {
        /// Number of groups.
        groups: usize,
        /// Largest deviation from the symmetry, in median edges.
        tolerance: f64,
    },
    /// There are several ways to leave the flat sheet.
    Branches(usize),
    /// The driven creases leave other creases a choice: this number of other closed configurations was found in which the
    /// driven creases have their angles.
    OtherCompletions(usize),
    /// The sheet was not planned as it is drawn; the path is that of the straightened one.
    Straightened(Straightened),
    /// Time ran out before the straightened sheet was planned.
    NotStraightened(Straightened),
    /// The path was found by the randomised search.
    FoundAtRandom,
    /// Plates were asked for, but there is no path to the goal on which to judge them.
    PlatesNotJudged,
    /// The largest thickness of the plates.
    Thickest(Thickest),
    /// This number of corners of plates is cut off, as they would pass through each other.
    CornersCut(usize),
    /// Creases count as turned, so that the sheet folds flat exactly.
    Snapped {
        /// Largest angle by which a crease is turned, radians.
        turned: f64,
    },
    /// The goal does not close, and was moved to a configuration that does.
    GoalMoved {
        /// Source of the goal's angles, in words.
        goal: String,
        /// Closure residual of the goal as asked.
        residual: f64,
        /// Largest difference of a crease from its goal angle, radians.
        moved: f64,
    },
    /// The sheet deforms on its way to the goal.
    Deforming,
    /// The sheet nearly closes on its way to the goal.
    NearlyClosed,
    /// The path ends a little before a goal that does not close, as faces cross there.
    EndsBeforeCrossing {
        /// Closure residual of the goal as asked.
        residual: f64,
        /// The crossing.
        crossing: Reason,
        /// Distance from the goal at which the path ends, radians.
        short: f64,
    },
    /// Creases turn one after the other, in this number of phases.
    Phases(usize),
    /// These creases close rings before the others fold.
    RingsFirst(Vec<EdgeId>),
    /// Creases turn past their goals and return, so that what is on them clears the rest of the sheet.
    TurnsPast {
        /// Edges of the creases.
        edges: Vec<EdgeId>,
        /// The largest angle by which one turns past its goal, radians.
        by: f64,
    },
    /// The sheet would fold to the goal if panels bent by this angle, radians.
    WouldBend(f64),
    /// Faces are in each other by less than this depth at the goal, which the path nearly reaches, in median edges.
    OverlapsAtGoal(f64),
    /// A path along the letters ends where its creases turn by up to this fraction of a half turn, rounded down.
    PartWay(f64),
    /// A net, whose hinges turn freely, names no goal angles and was not planned folded flat.
    NoAngles,
    /// Faces cross that several hinges move against each other, which might turn one after the other.
    TurnTogether {
        /// The two faces.
        faces: [FaceId; 2],
        /// Edges of the hinges between them that turn.
        edges: Vec<EdgeId>,
    },
    /// The goal lies flat, and these faces cannot be stacked there in any order that the letters allow.
    NoLayerOrder(Vec<FaceId>),
    /// Faces are in each other at the goal, deeper than contact can be.
    GoalItselfCrosses {
        /// The two faces.
        faces: [FaceId; 2],
        /// Depth of the crossing, in median edges.
        depth: f64,
    },
    /// Plates are in each other at the goal, in whatever order they fold.
    PlatesCrossAtGoal {
        /// The two panels.
        faces: [FaceId; 2],
        /// Depth to which they are in each other at least, units of the sheet.
        depth: f64,
        /// Their thickness, units of the sheet.
        thickness: f64,
    },
    /// Hinges turned that have neither a goal nor a letter; another choice of their directions might close as well.
    TurnedFreely {
        /// Edges of those that turned as mountains.
        mountains: Vec<EdgeId>,
        /// Edges of those that turned as valleys.
        valleys: Vec<EdgeId>,
    },
    /// The errors of vertices that do not close are added up as they are, not in the worst case.
    ErrorsAddedUp {
        /// Largest closure residual of a vertex.
        closure: f64,
    },
}
