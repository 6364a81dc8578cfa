//! Trajectories: group angles and their rates at knots, and the interpolated motion between the knots.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::Scalar;
use crate::curve::{Curve, Interpolation, Node};

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
    /// Returns the values of one group, from which its curves are made.
    fn node(&self, group: usize) -> Option<Node<T>> {
        Some(Node {
            angle: *self.angles.get(group)?,
            rate: *self.rates.get(group)?,
            weight: self.weights.get(group).copied().unwrap_or_default(),
        })
    }

    /// Returns why this knot, number `index`, cannot be part of a trajectory.
    fn problem(&self, index: usize, kind: Interpolation, groups: usize) -> Option<TrajectoryError> {
        let homogeneous = kind == Interpolation::Homogeneous;
        let weights = if homogeneous { groups } else { 0 };
        let widths = [self.angles.len(), self.rates.len(), self.weights.len()];
        let finite = |values: &[T]| values.iter().all(|v| v.is_finite());
        let finite = self.time.is_finite() && finite(self.angles) && finite(self.rates);
        let pole = |angle: &T| angle.abs() >= T::PI;
        let sound = |[w, rate]: &[T; 2]| *w > T::zero() && w.is_finite() && rate.is_finite();
        if widths != [groups, groups, weights] {
            Some(TrajectoryError::Width(index))
        } else if !finite {
            Some(TrajectoryError::NotFinite(index))
        } else if kind == Interpolation::HalfAngle && self.angles.iter().any(pole) {
            Some(TrajectoryError::HalfTurn(index))
        } else if !self.weights.iter().all(sound) {
            Some(TrajectoryError::Weight(index))
        } else {
            None
        }
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
    /// The storage is full at the knot of this number.
    Capacity(usize),
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
            Self::Capacity(knot) => write!(f, "knot {knot}: the trajectory's storage is full"),
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
        for (index, &time) in times.iter().enumerate() {
            let knot = view.knot(index).ok_or(TrajectoryError::Width(index))?;
            if let Some(problem) = knot.problem(index, interpolation, groups) {
                return Err(problem);
            }
            let earlier = index.checked_sub(1).and_then(|i| times.get(i));
            if earlier.is_some_and(|&earlier| earlier >= time) {
                return Err(TrajectoryError::Order(index));
            }
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
        let angle = |curve: Curve<T>, s, _| curve.angle(s);
        self.at(time, angles, |knot| knot.angles, angle);
    }

    /// Writes the group rates (radians per second) at `time` (seconds) to `rates`.
    ///
    /// At a knot the rates are those of the segment behind it; outside the trajectory they are those of the first or
    /// last knot.
    pub fn sample_rates(&self, time: T, rates: &mut [T]) {
        let rate = |curve: Curve<T>, s, span| {
            let [rate, _] = curve.derivatives(s);
            rate / span
        };
        self.at(time, rates, |knot| knot.rates, rate);
    }

    /// Writes a number for each group: within the trajectory that of `inside`, which gets the group's curve, the
    /// parameter on it and the segment's duration; before the trajectory and from its end on that of `outside`, which
    /// gets the nearest knot.
    fn at(
        &self,
        time: T,
        values: &mut [T],
        outside: impl Fn(Knot<'a, T>) -> &'a [T],
        inside: impl Fn(Curve<T>, T, T) -> T,
    ) {
        let after = self.times.partition_point(|&knot| knot <= time);
        let before = after.checked_sub(1).and_then(|i| self.knot(i));
        match (before, self.knot(after)) {
            (Some(from), Some(to)) => {
                let span = to.time - from.time;
                let s = (time - from.time) / span;
                for (group, value) in values.iter_mut().enumerate() {
                    let (Some(from), Some(to)) = (from.node(group), to.node(group)) else {
                        break;
                    };
                    let curve = Curve::between(self.interpolation, span, from, to);
                    *value = inside(curve, s, span);
                }
            }
            (Some(knot), None) | (None, Some(knot)) => {
                for (from, to) in outside(knot).iter().zip(values) {
                    *to = *from;
                }
            }
            (None, None) => {}
        }
    }
}

/// A trajectory that owns its memory, for at most `KNOTS` knots with `VALUES` angles in all.
///
/// Decoding applies the checks of [`TrajectoryView::new`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "", try_from = "Parts<T, KNOTS, VALUES>")]
pub struct Trajectory<T: Scalar, const KNOTS: usize, const VALUES: usize>(Parts<T, KNOTS, VALUES>);

/// The arrays of a trajectory, before they are checked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub(crate) struct Parts<T: Scalar, const KNOTS: usize, const VALUES: usize> {
    interpolation: Interpolation,
    groups: u16,
    pub(crate) times: Vec<T, KNOTS>,
    pub(crate) angles: Vec<T, VALUES>,
    pub(crate) rates: Vec<T, VALUES>,
    pub(crate) weights: Vec<[T; 2], VALUES>,
}

impl<T: Scalar, const KNOTS: usize, const VALUES: usize> Parts<T, KNOTS, VALUES> {
    pub(crate) const fn new(interpolation: Interpolation, groups: u16) -> Self {
        Self {
            interpolation,
            groups,
            times: Vec::new(),
            angles: Vec::new(),
            rates: Vec::new(),
            weights: Vec::new(),
        }
    }
}

impl<T: Scalar, const KNOTS: usize, const VALUES: usize> TryFrom<Parts<T, KNOTS, VALUES>>
    for Trajectory<T, KNOTS, VALUES>
{
    type Error = TrajectoryError;

    fn try_from(parts: Parts<T, KNOTS, VALUES>) -> Result<Self, TrajectoryError> {
        TrajectoryView::new(
            parts.interpolation,
            usize::from(parts.groups),
            &parts.times,
            &parts.angles,
            &parts.rates,
            &parts.weights,
        )?;
        Ok(Self(parts))
    }
}

impl<T: Scalar, const KNOTS: usize, const VALUES: usize> Trajectory<T, KNOTS, VALUES> {
    /// Creates an empty trajectory of `groups` group angles.
    #[must_use]
    pub const fn new(interpolation: Interpolation, groups: u16) -> Self {
        Self(Parts::new(interpolation, groups))
    }

    /// Adds a knot at the end.
    ///
    /// # Errors
    /// If the knot is not valid, or the storage is full; the trajectory is unchanged then.
    pub fn push(&mut self, knot: Knot<'_, T>) -> Result<(), TrajectoryError> {
        let index = self.0.times.len();
        let width = usize::from(self.0.groups);
        if let Some(problem) = knot.problem(index, self.0.interpolation, width) {
            return Err(problem);
        }
        if self.0.times.last().is_some_and(|&last| last >= knot.time) {
            return Err(TrajectoryError::Order(index));
        }
        let room = self.0.angles.capacity() - self.0.angles.len();
        if room < width || self.0.times.push(knot.time).is_err() {
            return Err(TrajectoryError::Capacity(index));
        }
        let full = |_| TrajectoryError::Capacity(index);
        self.0.angles.extend_from_slice(knot.angles).map_err(full)?;
        self.0.rates.extend_from_slice(knot.rates).map_err(full)?;
        self.0.weights.extend_from_slice(knot.weights).map_err(full)
    }

    /// Returns the trajectory as a view.
    #[must_use]
    pub fn view(&self) -> TrajectoryView<'_, T> {
        TrajectoryView {
            interpolation: self.0.interpolation,
            groups: usize::from(self.0.groups),
            times: &self.0.times,
            angles: &self.0.angles,
            rates: &self.0.rates,
            weights: &self.0.weights,
        }
    }
}
