//! The report's two objectives, which measure how far a configuration is from closing.
//!
//! Implements Eq. (2) of [XiLien2015](crate#references), F(C) = max ‖L(v) − I‖, and the older sum form of FROCC.
//! Differs from the source in that L is taken with its vertex at the origin, so that the value does not change when the
//! sheet is moved.

use nalgebra::Vector3;

use crate::closure;
use crate::{HalfAngle, Scalar, StarsView};

/// The report's two objectives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Objective {
    /// Largest ‖L(v) − I‖ over the stars, Eq. (2).
    #[default]
    Max,
    /// Sum of ‖L(v) − I‖ over the stars, as in FROCC.
    Sum,
}

impl Objective {
    /// Returns the objective at the configuration `unknowns` (radians), with the Frobenius norm.
    ///
    /// `scratch` needs one entry for each unknown. Returns `None` if it has fewer, or if the number of `unknowns` is
    /// not that of the stars.
    pub fn value<T: Scalar>(
        self,
        stars: StarsView<'_, T>,
        unknowns: &[T],
        scratch: &mut [HalfAngle<T>],
    ) -> Option<T> {
        let half = scratch.get_mut(..stars.unknowns())?;
        if unknowns.len() != half.len() {
            return None;
        }
        closure::half_angles(unknowns, half);
        let half = &*half;
        let norms = stars
            .iter()
            .map(|star| norm(&closure::residual(star, half)) * T::TWO.sqrt());
        Some(match self {
            Self::Max => norms.fold(T::zero(), larger),
            Self::Sum => norms.sum(),
        })
    }
}

/// Returns the Euclidean norm.
#[inline]
#[must_use]
pub fn norm<T: Scalar>(vector: &Vector3<T>) -> T {
    vector.dot(vector).sqrt()
}

/// Returns the larger number, or NaN if either is NaN: an undefined residual must not hide behind a small one.
#[inline]
pub(crate) fn larger<T: Scalar>(a: T, b: T) -> T {
    if a >= b || !a.is_finite() { a } else { b }
}
