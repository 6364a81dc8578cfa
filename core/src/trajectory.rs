//! Trajectories: group angles and their rates at knots, and the interpolated motion between the knots.

use crate::Scalar;
use crate::curve::{Curve, Flaw, Interpolation, Node};

/// One stored configuration of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot<'a, T> {
    /// Seconds since the start.
    pub time: T,
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

/// Checks the knot of number `index`, which follows one at the time `before`: its nodes, then its time.
pub(crate) fn check_knot<T: Scalar>(
    kind: Interpolation,
    index: usize,
    before: Option<T>,
    time: T,
    mut nodes: impl Iterator<Item = Node<T>>,
) -> Result<(), TrajectoryError> {
    match nodes.find_map(|node| node.flaw(kind)) {
        Some(Flaw::NotFinite) => Err(TrajectoryError::NotFinite(index)),
        Some(Flaw::HalfTurn) => Err(TrajectoryError::HalfTurn(index)),
        Some(Flaw::Weight) => Err(TrajectoryError::Weight(index)),
        None if !time.is_finite() => Err(TrajectoryError::NotFinite(index)),
        None if before.is_some_and(|before| before >= time) => Err(TrajectoryError::Order(index)),
        None => Ok(()),
    }
}

/// Reason why a trajectory cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TrajectoryError {
    /// The knot of this number does not have one angle and one rate for each group, or lacks its weights.
    Width(usize),
    /// The knot of this number is not later than the one before.
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
            Self::Order(knot) => write!(f, "knot {knot}: expected a later time than before"),
            Self::NotFinite(knot) => write!(f, "knot {knot}: expected finite numbers"),
            Self::HalfTurn(knot) => write!(f, "knot {knot}: expected angles below half a turn"),
            Self::Weight(knot) => write!(f, "knot {knot}: expected weights above 0"),
        }
    }
}

impl core::error::Error for TrajectoryError {}

/// A trajectory in borrowed arrays: the angles and rates of knot k lie at k·n .. (k+1)·n, for n groups.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrajectoryView<'a, T> {
    interpolation: Interpolation,
    groups: usize,
    times: &'a [T],
    angles: &'a [T],
    rates: &'a [T],
    weights: &'a [[T; 2]],
}

impl<'a, T: Scalar> TrajectoryView<'a, T> {
    /// Creates a checked view of the angles and rates of `groups` groups at each of `times`.
    ///
    /// `weights` is empty unless the interpolation is [`Interpolation::Homogeneous`].
    ///
    /// # Errors
    /// If a knot has too few or too many numbers, has a number that is not finite or not in its range, or is not later
    /// than the knot before.
    pub fn new(
        interpolation: Interpolation,
        groups: usize,
        times: &'a [T],
        angles: &'a [T],
        rates: &'a [T],
        weights: &'a [[T; 2]],
    ) -> Result<Self, TrajectoryError> {
        let view = Self {
            interpolation,
            groups,
            times,
            angles,
            rates,
            weights,
        };
        let values = times.len().checked_mul(groups);
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
            return Err(TrajectoryError::Width(whole.min(times.len())));
        }
        let mut before = None;
        for (index, &time) in times.iter().enumerate() {
            let knot = view.knot(index).ok_or(TrajectoryError::Width(index))?;
            let nodes = (0..groups).filter_map(|group| knot.node(group));
            check_knot(interpolation, index, before, time, nodes)?;
            before = Some(time);
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
        self.times.len()
    }

    /// Returns `true` if there is no knot.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// Returns knot number `index`, or `None` behind the last knot.
    #[must_use]
    pub fn knot(&self, index: usize) -> Option<Knot<'a, T>> {
        let start = index.checked_mul(self.groups)?;
        let range = start..start.checked_add(self.groups)?;
        Some(Knot {
            time: *self.times.get(index)?,
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
        let span = to.time - from.time;
        Some(Curve::between(self.interpolation, span, nodes.0, nodes.1))
    }

    /// Writes the group angles (radians) at `time` (seconds) to `angles`.
    ///
    /// Outside the trajectory these are the angles of the first or last knot; an empty trajectory writes nothing. Cost:
    /// a binary search, and for each group a cubic, with sine, cosine and arc tangent for half angles.
    pub fn sample(&self, time: T, angles: &mut [T]) {
        let after = self.times.partition_point(|&knot| knot <= time);
        let before = after.checked_sub(1).and_then(|i| self.knot(i));
        match (before, self.knot(after)) {
            (Some(from), Some(to)) => {
                let span = to.time - from.time;
                let s = (time - from.time) / span;
                for (group, angle) in angles.iter_mut().enumerate() {
                    let (Some(from), Some(to)) = (from.node(group), to.node(group)) else {
                        break;
                    };
                    *angle = Curve::between(self.interpolation, span, from, to).angle(s);
                }
            }
            (Some(knot), None) | (None, Some(knot)) => {
                for (from, to) in knot.angles.iter().zip(angles) {
                    *to = *from;
                }
            }
            (None, None) => {}
        }
    }
}
