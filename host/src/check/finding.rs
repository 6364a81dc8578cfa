//! The findings of a check as data and as sentences: faults and open questions, each with its place.

use foldpath_core::GroupId;
use thiserror::Error;

use super::messages::{differing, known, rate, turns};
use crate::collision::{Crossing, PlateError};
use crate::pattern::{ClosureSite, EdgeId, FaceId, Letter, VertexId};

/// A place on a path.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Moment {
    /// At the knot of this number.
    #[error("knot {0}")]
    Knot(usize),
    /// Between the knot of number `segment` and the next, at `s` from 0 to 1.
    #[error("between knots {segment} and {}, at {s:.3}", segment + 1)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SheetError {
    /// Largest relative change of length of an edge.
    #[error("deformation")]
    Deformation,
    /// Largest gap, in median edges.
    #[error("gap")]
    Gap,
    /// Largest closure residual.
    #[error("closure")]
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
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Failure {
    /// The bound is no number, so that nothing exceeds it.
    #[error("bound: expected a number, found NaN, which nothing exceeds")]
    BoundIsNotANumber,
    /// A hinge turns as it must not.
    #[error("{at}: edge {edge} {}", turns(*at, *letter, *wrong, *value))]
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
    #[error(
        "knot {knot}: edges {} and {} are in group {}, but {}",
        edges[0], edges[1], group.0, differing(*quantity, *values)
    )]
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
    #[error("knot {knot}: the file claims a {error} of {claimed:.3e}, but it is {found:.3e}")]
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
    #[error("the file claims a largest {}", rate(*limit, *claimed, *found))]
    FalseRate {
        /// The limit that the file claims.
        limit: RateLimit,
        /// Value in the file.
        claimed: f64,
        /// Value measured; infinite if a hinge changes its speed at once.
        found: f64,
    },
    /// Faces are nearer to each other at a knot than the file claims.
    #[error("knot {knot}: the file claims a clearance of {claimed:.3e}, but it is {found:.3e}")]
    FalseClearance {
        /// Number of the knot.
        knot: usize,
        /// Distance in the file, units of the sheet.
        claimed: f64,
        /// Distance measured; 0 if faces cross.
        found: f64,
    },
    /// The file says that the motion was planned within a bound that it does not keep.
    #[error(
        "the file says that it was planned within the bound {claimed:.3e}, but has errors of {found:.3e}"
    )]
    FalseBound {
        /// Bound in the file.
        claimed: f64,
        /// Largest error found.
        found: f64,
    },
    /// The sheet breaks the bound.
    #[error(
        "{at}: {error} {value:.3e} over the bound {bound:.3e}{}",
        known(*open, |(vertex, off)| format!("; vertex {vertex} fails to close by {off:.3e}"))
    )]
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
    #[error(
        "{at}: {} fails to close by {residual:.3e}, over the bound {bound:.3e}",
        known(*site, |site| site.to_string())
    )]
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
    #[error(
        "{at}: faces {} and {} pass through each other, {depth_edges:.3e} median edges deep",
        crossing.faces[0], crossing.faces[1]
    )]
    Crosses {
        /// Place on the path.
        at: Moment,
        /// The faces, and the depth in units of the sheet.
        crossing: Crossing,
        /// The depth in median edges.
        depth_edges: f64,
    },
    /// Plates pass through each other.
    #[error(
        "{at}: panels {} and {}, plates {thickness} thick, pass through each other, {:.3e} deep",
        crossing.faces[0], crossing.faces[1], crossing.depth
    )]
    PlatesCross {
        /// Place on the path.
        at: Moment,
        /// Faces of the panels, and the depth in units of the sheet.
        crossing: Crossing,
        /// Thickness of the plates, units of the sheet.
        thickness: f64,
    },
    /// The panels cannot be the plates that the file names.
    #[error("{0}")]
    PlatesNotMade(PlateError),
}

/// A question that a check leaves open. `Display` makes a sentence of it.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Undecided {
    /// The bound on the errors between two knots is above the bound that they have to keep, though no value found is.
    #[error(
        "not certified: between knots {segment} and {}, {} fails to close by up to {closure:.3e}, and the sheet may \
         deform or tear by {error:.3e}, over the bound {bound:.3e}",
        segment + 1, known(*site, |site| site.to_string())
    )]
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
    #[error(
        "not certified: {at}, the fold angle of edge {edge} is not known, as its weights vanish"
    )]
    Angle {
        /// Place on the path.
        at: Moment,
        /// The hinge.
        edge: EdgeId,
    },
    /// The file claims a distance of faces at a knot of which nothing is known, as measuring it would take too long.
    #[error(
        "knot {knot}: the file claims a clearance of {claimed:.3e}, and measuring it would take too long"
    )]
    Clearance {
        /// Number of the knot.
        knot: usize,
        /// Distance in the file, units of the sheet.
        claimed: f64,
    },
    /// The search for crossings did not decide within its budget.
    #[error(
        "not certified: {at}, whether faces pass through each other takes too long to tell{}",
        known(*faces, |[a, b]| format!(": faces {a} and {b}"))
    )]
    Crossings {
        /// Place up to which no faces do.
        at: Moment,
        /// The faces that were looked at last, if they were two.
        faces: Option<[FaceId; 2]>,
    },
    /// The search for crossings of plates did not decide within its budget.
    #[error(
        "not certified: {at}, whether plates pass through each other takes too long to tell{}",
        known(*faces, |[a, b]| format!(": panels {a} and {b}"))
    )]
    Plates {
        /// Place up to which no plates do.
        at: Moment,
        /// Faces of the panels that were looked at last, if they were two.
        faces: Option<[FaceId; 2]>,
    },
    /// The check was cancelled, or its time ended.
    #[error("out of time before all was judged: closure is on {judged} of {segments} segments")]
    Unfinished {
        /// Number of segments over which closure was judged.
        judged: usize,
        /// Number of segments of the path.
        segments: usize,
    },
}
