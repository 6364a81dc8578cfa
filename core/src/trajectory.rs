//! Trajectories: group angles and their rates at knots, and the interpolated motion between the knots.

use crate::Scalar;
use crate::curve::{Curve, Flaw, Interpolation, Node};
use crate::follower::FollowerPosition;

/// One stored configuration of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot<'a, T> {
    /// Seconds since the knot before; 0 at the first knot.
    pub span: T,
    /// Fold angle of each group, radians.
    pub angles: &'a [T],
    /// Rate of each group, radians per second.
    pub rates: &'a [T],
    /// Weight of each group's homogeneous half angle, and the weight's rate per second; empty unless the interpolation
    /// is [`Interpolation::Homogeneous`].
    pub weights: &'a [[T; 2]],
}

impl<T: Scalar> Knot<'_, T> {
    /// Returns the values of one group, from which its curves are made; with weight 1 if there are no weights.
    pub(crate) fn node(&self, group: usize) -> Option<Node<T>> {
        let weight = self.weights.get(group).copied();
        Some(Node {
            angle: *self.angles.get(group)?,
            rate: *self.rates.get(group)?,
            weight: weight.unwrap_or([T::one(), T::zero()]),
        })
    }
}

/// Checks the knot of number `index`: its nodes, then its span.
pub(crate) fn check_knot<T: Scalar>(
    kind: Interpolation,
    index: usize,
    span: T,
    mut nodes: impl Iterator<Item = Node<T>>,
) -> Result<(), TrajectoryError> {
    match nodes.find_map(|node| node.flaw(kind)) {
        Some(Flaw::NotFinite) => Err(TrajectoryError::NotFinite(index)),
        Some(Flaw::HalfTurn) => Err(TrajectoryError::HalfTurn(index)),
        Some(Flaw::Weight) => Err(TrajectoryError::Weight(index)),
        None if !span.is_finite() => Err(TrajectoryError::NotFinite(index)),
        None if span < T::zero() || span.is_zero() != (index == 0) => {
            Err(TrajectoryError::Order(index))
        }
        None => Ok(()),
    }
}

/// Reason why a trajectory cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TrajectoryError {
    /// The knot of this number does not have one angle and one rate for each group, or lacks its weights.
    Width(usize),
    /// The knot of this number is not later than the one before, or the first knot has a span.
    Order(usize),
    /// The knot of this number holds an infinity or a NaN.
    NotFinite(usize),
    /// The knot of this number holds half a turn, where tan ρ/2 is infinite.
    HalfTurn(usize),
    /// The knot of this number holds a weight that is not a number above 0.
    Weight(usize),
}

impl core::fmt::Display for TrajectoryError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Width(knot) => write!(
                f,
                "knot {knot}: expected an angle and a rate per group, and a weight where the \
                 interpolation has weights"
            ),
            Self::Order(0) => write!(f, "knot 0: expected a span of 0"),
            Self::Order(knot) => write!(f, "knot {knot}: expected a later time than before"),
            Self::NotFinite(knot) => write!(f, "knot {knot}: expected finite numbers"),
            Self::HalfTurn(knot) => write!(f, "knot {knot}: expected angles below half a turn"),
            Self::Weight(knot) => write!(f, "knot {knot}: expected weights above 0"),
        }
    }
}

impl core::error::Error for TrajectoryError {}

/// A trajectory in borrowed arrays: the angles and rates of knot k lie at k·n .. (k+1)·n, for n groups.
///
/// A knot has the seconds since the knot before, its *span*, because the seconds since the start lose digits on a long path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrajectoryView<'a, T> {
    interpolation: Interpolation,
    groups: usize,
    spans: &'a [T],
    angles: &'a [T],
    rates: &'a [T],
    weights: &'a [[T; 2]],
}

impl<'a, T: Scalar> TrajectoryView<'a, T> {
    /// Creates a checked view of the angles and rates of `groups` groups at knots with these `spans`: the seconds since the
    /// knot before, 0 at the first.
    ///
    /// `weights` is empty unless the interpolation is [`Interpolation::Homogeneous`].
    ///
    /// # Errors
    /// If a knot has too few or too many numbers, has a number that is not finite or not in its range, or is not later
    /// than the knot before, or if the first span is not 0.
    pub fn new(
        interpolation: Interpolation,
        groups: usize,
        spans: &'a [T],
        angles: &'a [T],
        rates: &'a [T],
        weights: &'a [[T; 2]],
    ) -> Result<Self, TrajectoryError> {
        let view = Self {
            interpolation,
            groups,
            spans,
            angles,
            rates,
            weights,
        };
        let values = spans.len().checked_mul(groups);
        let weighted = if interpolation == Interpolation::Homogeneous {
            values
        } else {
            Some(0)
        };
        if values != Some(angles.len())
            || values != Some(rates.len())
            || weighted != Some(weights.len())
        {
            let whole = angles.len().min(rates.len()) / groups.max(1);
            return Err(TrajectoryError::Width(whole.min(spans.len())));
        }
        for (index, &span) in spans.iter().enumerate() {
            let knot = view.knot(index).ok_or(TrajectoryError::Width(index))?;
            let nodes = (0..groups).filter_map(|group| knot.node(group));
            check_knot(interpolation, index, span, nodes)?;
        }
        Ok(view)
    }

    /// Returns the kind of motion between knots.
    #[must_use]
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// Returns the number of group angles in a knot.
    #[must_use]
    pub fn groups(&self) -> usize {
        self.groups
    }

    /// Returns the number of knots.
    #[must_use]
    pub fn len(&self) -> usize {
        self.spans.len()
    }

    /// Returns `true` if there is no knot.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// Returns knot number `index`, or `None` behind the last knot.
    #[must_use]
    pub fn knot(&self, index: usize) -> Option<Knot<'a, T>> {
        let start = index.checked_mul(self.groups)?;
        let range = start..start.checked_add(self.groups)?;
        Some(Knot {
            span: *self.spans.get(index)?,
            angles: self.angles.get(range.clone())?,
            rates: self.rates.get(range.clone())?,
            weights: self.weights.get(range).unwrap_or(&[]),
        })
    }

    /// Returns the motion of a group from knot number `segment` to the next knot. Its parameter runs from 0 to 1 in
    /// proportion to time.
    #[must_use]
    pub fn curve(&self, segment: usize, group: usize) -> Option<Curve<T>> {
        let from = self.knot(segment)?;
        let to = self.knot(segment.checked_add(1)?)?;
        let nodes = (from.node(group)?, to.node(group)?);
        Some(Curve::between(
            self.interpolation,
            to.span,
            nodes.0,
            nodes.1,
        ))
    }

    /// Writes the group angles (radians) at a place to `angles`. Its seconds may reach beyond the next knots, so that a place
    /// behind knot 0 is a time.
    ///
    /// Outside the trajectory these are the angles of the first or last knot; an empty trajectory writes nothing. Cost:
    /// a subtraction for each knot between, and for each group a cubic, with sine, cosine and arc tangent for half angles.
    pub fn sample(&self, place: FollowerPosition<T>, angles: &mut [T]) {
        let last = self.len().saturating_sub(1);
        let knot = usize::try_from(place.knot).unwrap_or(last);
        let (mut segment, mut into) = (knot.min(last), place.into);
        while let Some(&span) = self.spans.get(segment + 1)
            && into >= span
        {
            (segment, into) = (segment + 1, into - span);
        }
        let next = self.spans.get(segment + 1);
        if let Some(&span) = next.filter(|_| into > T::zero()) {
            for (group, angle) in angles.iter_mut().enumerate() {
                if let Some(curve) = self.curve(segment, group) {
                    *angle = curve.angle(into / span);
                }
            }
        } else if let Some(knot) = self.knot(segment) {
            for (from, to) in knot.angles.iter().zip(angles) {
                *to = *from;
            }
        }
    }
}
