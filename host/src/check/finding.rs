//! The findings of a check as data: faults and open questions, each with its place. `messages.rs` makes sentences of
//! them.

use foldpath_core::GroupId;

use crate::collision::Crossing;
use crate::pattern::{ClosureSite, EdgeId, FaceId, Letter, VertexId};

/// A place on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moment {
    /// At the knot of this number.
    Knot(usize),
    /// Between the knot of number `segment` and the next, at `s` from 0 to 1.
    Between {
        /// Number of the knot before.
        segment: usize,
        /// Parameter in the segment.
        s: f64,
    },
}

/// A fault in the turn of a hinge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WrongTurn {
    /// Its fold angle is beyond half a turn.
    BeyondHalfTurn,
    /// Its fold angle has the sign that its letter excludes.
    AgainstLetter,
    /// A panel bends about it by more than is allowed, or than the file says.
    BeyondBend,
    /// Its letter says that it stays flat, but its fold angle is not 0.
    NotFlat,
    /// Its letter says that it stays flat, but it turns at this rate, radians per second.
    FlatButTurns,
    /// Its fold angle is no number.
    NotANumber,
}

/// A quantity that all hinges of a crease group have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroupQuantity {
    /// Fold angle, radians.
    Angle,
    /// Rate of the fold angle, radians per second.
    Rate,
    /// Weight of the homogeneous half angle.
    Weight,
    /// Growth of this weight, per second.
    WeightGrowth,
}

/// An error of the folded sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SheetError {
    /// Largest relative change of length of an edge.
    Deformation,
    /// Largest gap, in median edges.
    Gap,
    /// Largest closure residual.
    Closure,
}

/// A limit on the motion of hinges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RateLimit {
    /// Largest speed, radians per second.
    Speed,
    /// Largest acceleration, radians per second squared.
    Acceleration,
}

/// A fault of a path. `Display` makes a sentence of it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Failure {
    /// The bound is no number, so that nothing exceeds it.
    BoundIsNotANumber,
    /// A hinge turns as it must not.
    Turns {
        /// Place on the path.
        at: Moment,
        /// The hinge.
        edge: EdgeId,
        /// Letter of the hinge.
        letter: Letter,
        /// The fault.
        wrong: WrongTurn,
        /// Fold angle in radians; a rate for [`WrongTurn::FlatButTurns`].
        value: f64,
    },
    /// Two hinges are in one group, but do not turn alike.
    GroupDiffers {
        /// Number of the knot.
        knot: usize,
        /// The first hinge of the group, and the hinge that differs from it.
        edges: [EdgeId; 2],
        /// The group.
        group: GroupId,
        /// The quantity that differs.
        quantity: GroupQuantity,
        /// Values of the two hinges, with the signs of the group applied.
        values: [f64; 2],
    },
    /// The file claims less than is measured.
    FalseClaim {
        /// Number of the knot.
        knot: usize,
        /// The error of which the file claims a value.
        error: SheetError,
        /// Value in the file.
        claimed: f64,
        /// Value measured.
        found: f64,
    },
    /// A hinge exceeds the speed or the acceleration that the file claims.
    FalseRate {
        /// The limit that the file claims.
        limit: RateLimit,
        /// Value in the file.
        claimed: f64,
        /// Value measured; infinite if a hinge changes its speed at once.
        found: f64,
    },
    /// Faces are nearer to each other at a knot than the file claims.
    FalseClearance {
        /// Number of the knot.
        knot: usize,
        /// Distance in the file, units of the sheet.
        claimed: f64,
        /// Distance measured; 0 if faces cross.
        found: f64,
    },
    /// The file says that the motion was planned within a bound that it does not keep.
    FalseBound {
        /// Bound in the file.
        claimed: f64,
        /// Largest error found.
        found: f64,
    },
    /// The sheet breaks the bound.
    OverBound {
        /// Place on the path.
        at: Moment,
        /// The error that is too large.
        error: SheetError,
        /// Its value.
        value: f64,
        /// Bound that it has to keep.
        bound: f64,
        /// Vertex that fails to close by most, and its residual.
        open: Option<(VertexId, f64)>,
    },
    /// The faces round a vertex or a hole do not meet.
    FailsToClose {
        /// Place on the path.
        at: Moment,
        /// The vertex or hole.
        site: Option<ClosureSite>,
        /// Its closure residual.
        residual: f64,
        /// Bound that it has to keep.
        bound: f64,
    },
    /// Faces pass through each other.
    Crosses {
        /// Place on the path.
        at: Moment,
        /// The faces, and the depth in units of the sheet.
        crossing: Crossing,
        /// The depth in median edges.
        depth_edges: f64,
    },
}

/// A question that a check leaves open. `Display` makes a sentence of it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Undecided {
    /// The bound on the errors between two knots is above the bound that they have to keep, though no value found is.
    Errors {
        /// Number of the knot before.
        segment: usize,
        /// The vertex or hole that is known least well.
        site: Option<ClosureSite>,
        /// Upper bound of its closure residual.
        closure: f64,
        /// Upper bound of all errors of the sheet.
        error: f64,
        /// Bound that they have to keep.
        bound: f64,
    },
    /// The fold angle of a hinge is not known at a place where the weights of its curve vanish.
    Angle {
        /// Place on the path.
        at: Moment,
        /// The hinge.
        edge: EdgeId,
    },
    /// The file claims a distance of faces at a knot of which nothing is known, as measuring it would take too long.
    Clearance {
        /// Number of the knot.
        knot: usize,
        /// Distance in the file, units of the sheet.
        claimed: f64,
    },
    /// The search for crossings did not decide within its budget.
    Crossings {
        /// Place up to which no faces do.
        at: Moment,
        /// The faces that were looked at last, if they were two.
        faces: Option<[FaceId; 2]>,
    },
    /// The check was cancelled, or its time ended.
    Cancelled,
}
