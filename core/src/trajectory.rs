//! Trajectories: group angles and their rates at knots, and the motion between them.
//!
//! Between knots the motion is the cubic Hermite curve through angles and rates, fourth order in
//! the distance of the knots.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::Scalar;

/// One stored configuration of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot<'a, T> {
    /// Seconds since the start.
    pub time: T,
    /// Fold angle of each group, radians.
    pub angles: &'a [T],
    /// Rate of each group, radians per second.
    pub rates: &'a [T],
}

/// Why a trajectory cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrajectoryError {
    /// The knot of this number has not one angle and one rate for each group.
    Width(usize),
    /// The knot of this number is not later than the one before.
    Order(usize),
    /// The knot of this number holds an infinity or a NaN.
    NotFinite(usize),
    /// The storage is full at the knot of this number.
    Capacity(usize),
}

impl core::fmt::Display for TrajectoryError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Width(knot) => write!(f, "knot {knot}: expected an angle and a rate per group"),
            Self::Order(knot) => write!(f, "knot {knot}: expected a later time than before"),
            Self::NotFinite(knot) => write!(f, "knot {knot}: expected finite numbers"),
            Self::Capacity(knot) => write!(f, "knot {knot}: the trajectory's storage is full"),
        }
    }
}

impl core::error::Error for TrajectoryError {}

/// A trajectory in borrowed arrays: knot k of n groups has angles and rates k·n .. (k+1)·n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrajectoryView<'a, T> {
    groups: usize,
    times: &'a [T],
    angles: &'a [T],
    rates: &'a [T],
}

impl<'a, T: Scalar> TrajectoryView<'a, T> {
    /// A view of `groups` group angles and rates at each of `times`, checked.
    ///
    /// # Errors
    /// If a knot has not its numbers, holds one that is not finite, or is not later than the last.
    pub fn new(
        groups: usize,
        times: &'a [T],
        angles: &'a [T],
        rates: &'a [T],
    ) -> Result<Self, TrajectoryError> {
        let view = Self {
            groups,
            times,
            angles,
            rates,
        };
        let values = times.len().checked_mul(groups);
        if values != Some(angles.len()) || values != Some(rates.len()) {
            let whole = angles.len().min(rates.len()) / groups.max(1);
            return Err(TrajectoryError::Width(whole.min(times.len())));
        }
        for (index, &time) in times.iter().enumerate() {
            let knot = view.knot(index).ok_or(TrajectoryError::Width(index))?;
            let finite = |values: &[T]| values.iter().all(|v| v.is_finite());
            if !(time.is_finite() && finite(knot.angles) && finite(knot.rates)) {
                return Err(TrajectoryError::NotFinite(index));
            }
            let earlier = index.checked_sub(1).and_then(|i| times.get(i));
            if earlier.is_some_and(|&earlier| earlier >= time) {
                return Err(TrajectoryError::Order(index));
            }
        }
        Ok(view)
    }

    /// Number of group angles in a knot.
    #[must_use]
    pub fn groups(&self) -> usize {
        self.groups
    }

    /// Number of knots.
    #[must_use]
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether there is no knot.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// Knot number `index`.
    #[must_use]
    pub fn knot(&self, index: usize) -> Option<Knot<'a, T>> {
        let start = index.checked_mul(self.groups)?;
        let range = start..start.checked_add(self.groups)?;
        Some(Knot {
            time: *self.times.get(index)?,
            angles: self.angles.get(range.clone())?,
            rates: self.rates.get(range)?,
        })
    }

    /// Group angles (radians) at `time` (seconds): those of the first or last knot outside the
    /// trajectory, nothing for an empty one.
    ///
    /// Cost: a binary search and 8 multiplications a group.
    pub fn sample(&self, time: T, angles: &mut [T]) {
        let after = self.times.partition_point(|&knot| knot <= time);
        let Some(to) = self.knot(after) else {
            if let Some(last) = after.checked_sub(1).and_then(|i| self.knot(i)) {
                copy(last.angles, angles);
            }
            return;
        };
        let Some(from) = after.checked_sub(1).and_then(|i| self.knot(i)) else {
            copy(to.angles, angles);
            return;
        };
        let span = to.time - from.time;
        let basis = HermiteBasis::at((time - from.time) / span, span);
        let ends = from.angles.iter().zip(from.rates);
        let ends = ends.zip(to.angles.iter().zip(to.rates));
        for (((p0, m0), (p1, m1)), angle) in ends.zip(angles) {
            *angle = basis.combine([*p0, *m0, *p1, *m1]);
        }
    }
}

fn copy<T: Copy>(from: &[T], to: &mut [T]) {
    for (from, to) in from.iter().zip(to) {
        *to = *from;
    }
}

/// Weights of the two angles and two rates of a cubic Hermite segment.
struct HermiteBasis<T>([T; 4]);

impl<T: Scalar> HermiteBasis<T> {
    /// At the fraction `s` in 0..1 of a segment of `span` seconds.
    fn at(s: T, span: T) -> Self {
        let rest = T::one() - s;
        let double = T::TWO * s;
        Self([
            (T::one() + double) * rest * rest,
            s * rest * rest * span,
            s * s * (T::TWO + T::one() - double),
            -s * s * rest * span,
        ])
    }

    fn combine(&self, [p0, m0, p1, m1]: [T; 4]) -> T {
        let [a, b, c, d] = self.0;
        a * p0 + b * m0 + c * p1 + d * m1
    }
}

/// A trajectory that owns its memory: at most `KNOTS` knots with `VALUES` angles in all.
///
/// Decoding checks a trajectory as [`TrajectoryView::new`] does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "", try_from = "Unchecked<T, KNOTS, VALUES>")]
pub struct Trajectory<T: Scalar, const KNOTS: usize, const VALUES: usize> {
    groups: u16,
    times: Vec<T, KNOTS>,
    angles: Vec<T, VALUES>,
    rates: Vec<T, VALUES>,
}

impl<T: Scalar, const KNOTS: usize, const VALUES: usize> Trajectory<T, KNOTS, VALUES> {
    /// An empty trajectory of `groups` group angles.
    #[must_use]
    pub const fn new(groups: u16) -> Self {
        Self {
            groups,
            times: Vec::new(),
            angles: Vec::new(),
            rates: Vec::new(),
        }
    }

    /// Adds a knot at the end.
    ///
    /// # Errors
    /// If the knot is not fit to follow, or the storage is full; the trajectory is unchanged then.
    pub fn push(&mut self, knot: Knot<'_, T>) -> Result<(), TrajectoryError> {
        let index = self.times.len();
        let width = usize::from(self.groups);
        if knot.angles.len() != width || knot.rates.len() != width {
            return Err(TrajectoryError::Width(index));
        }
        let finite = |values: &[T]| values.iter().all(|v| v.is_finite());
        if !(knot.time.is_finite() && finite(knot.angles) && finite(knot.rates)) {
            return Err(TrajectoryError::NotFinite(index));
        }
        if self.times.last().is_some_and(|&last| last >= knot.time) {
            return Err(TrajectoryError::Order(index));
        }
        let room = self.angles.capacity() - self.angles.len();
        if room < width || self.times.push(knot.time).is_err() {
            return Err(TrajectoryError::Capacity(index));
        }
        let full = |_| TrajectoryError::Capacity(index);
        self.angles.extend_from_slice(knot.angles).map_err(full)?;
        self.rates.extend_from_slice(knot.rates).map_err(full)
    }

    /// The trajectory as a view.
    #[must_use]
    pub fn view(&self) -> TrajectoryView<'_, T> {
        TrajectoryView {
            groups: usize::from(self.groups),
            times: &self.times,
            angles: &self.angles,
            rates: &self.rates,
        }
    }
}

/// A trajectory as it arrives.
#[derive(Deserialize)]
#[serde(bound = "")]
struct Unchecked<T: Scalar, const KNOTS: usize, const VALUES: usize> {
    groups: u16,
    times: Vec<T, KNOTS>,
    angles: Vec<T, VALUES>,
    rates: Vec<T, VALUES>,
}

impl<T: Scalar, const KNOTS: usize, const VALUES: usize> TryFrom<Unchecked<T, KNOTS, VALUES>>
    for Trajectory<T, KNOTS, VALUES>
{
    type Error = TrajectoryError;

    fn try_from(arrived: Unchecked<T, KNOTS, VALUES>) -> Result<Self, TrajectoryError> {
        let Unchecked {
            groups,
            times,
            angles,
            rates,
        } = arrived;
        TrajectoryView::new(usize::from(groups), &times, &angles, &rates)?;
        Ok(Self {
            groups,
            times,
            angles,
            rates,
        })
    }
}
