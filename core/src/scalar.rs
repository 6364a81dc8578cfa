//! The one numeric bound of this crate: [`Scalar`], over `f32` and `f64`.
//!
//! `Scalar` is deliberately not nalgebra's `RealField`: that trait's trigonometry changes with the features that other
//! crates switch on, and then the same program would no longer give the same bits on the host and on the controller.
//! All transcendental functions here are libm's, except sine and cosine of `f32`, which are this crate's own: libm's
//! are slow where `f64` is computed in software.

use core::fmt::Display;
use core::ops::Neg;

use num_traits::NumAssign;

use crate::{HalfAngle, half_angles};

mod sealed {
    pub trait Sealed {}
}

/// A floating-point number: `f32` on the controller, `f64` on the host.
///
/// Tolerances belong to the type, not to the algorithms: generic code never writes one.
pub trait Scalar:
    sealed::Sealed
    + nalgebra::Scalar
    + Copy
    + Default
    + PartialOrd
    + NumAssign
    + Neg<Output = Self>
    + core::iter::Sum
    + Display
    + Send
    + Sync
{
    /// One half.
    const HALF: Self;
    /// Two.
    const TWO: Self;
    /// Half a turn, the largest fold angle, in radians.
    const PI: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;
    /// The largest finite number.
    const MAX: Self;
    /// Largest closure residual (dimensionless, about radians) that counts as closed.
    ///
    /// About 45 rounding errors, which is what the product of a dozen unit quaternions can promise.
    const CLOSURE_TOLERANCE: Self;

    /// Returns the number nearest to `value`.
    fn lit(value: f64) -> Self;
    /// Returns the number nearest to a whole number.
    fn whole(value: u32) -> Self;
    /// Returns this number as `f64`, exactly.
    fn to_f64(self) -> f64;
    /// Returns the absolute value.
    #[must_use]
    fn abs(self) -> Self;
    /// Returns the square root, correctly rounded.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Returns sine and cosine of an angle in radians. For `f32` the error is at most 8e-8, and the result is NaN
    /// beyond 12,866 radians.
    #[must_use]
    fn sin_cos(self) -> (Self, Self);
    /// Writes the half angles of `angles` (radians) to `out`, up to the end of the shorter slice. Each has the same
    /// bits as [`HalfAngle::of`] gives.
    fn half_angles(angles: &[Self], out: &mut [HalfAngle<Self>]);
    /// Returns the angle of the point (`x`, `self`) in radians.
    #[must_use]
    fn atan2(self, x: Self) -> Self;
    /// Returns `true` if this number is neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// Returns the smaller of two numbers, or the other one if one is NaN. For two zeros returns `other`, on any
    /// processor.
    #[must_use]
    fn min(self, other: Self) -> Self;
    /// Returns the larger of two numbers, or the other one if one is NaN. For two zeros returns `other`, on any
    /// processor.
    #[must_use]
    fn max(self, other: Self) -> Self;
}

macro_rules! scalar {
    ($type:ident, $sqrt:ident, $sincos:path, $half_angles:path, $atan2:ident, $closure:literal) => {
        impl sealed::Sealed for $type {}

        impl Scalar for $type {
            const HALF: Self = 0.5;
            const TWO: Self = 2.0;
            const PI: Self = core::$type::consts::PI;
            const EPSILON: Self = $type::EPSILON;
            const MAX: Self = $type::MAX;
            const CLOSURE_TOLERANCE: Self = $closure;

            #[inline]
            #[allow(
                clippy::cast_possible_truncation,
                reason = "rounding to the nearest number of the type is what is asked for"
            )]
            fn lit(value: f64) -> Self {
                value as $type
            }
            #[inline]
            #[allow(
                clippy::cast_precision_loss,
                clippy::cast_lossless,
                reason = "rounding to the nearest number of the type is what is asked for"
            )]
            fn whole(value: u32) -> Self {
                value as $type
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline]
            fn abs(self) -> Self {
                $type::abs(self)
            }
            #[inline]
            fn sqrt(self) -> Self {
                libm::$sqrt(self)
            }
            #[inline]
            fn sin_cos(self) -> (Self, Self) {
                $sincos(self)
            }
            #[inline]
            fn half_angles(angles: &[Self], out: &mut [HalfAngle<Self>]) {
                $half_angles(angles, out);
            }
            #[inline]
            fn atan2(self, x: Self) -> Self {
                libm::$atan2(self, x)
            }
            #[inline]
            fn is_finite(self) -> bool {
                // Two instructions, where the bits would take a dozen.
                $type::abs(self) <= $type::MAX
            }
            #[inline]
            fn min(self, other: Self) -> Self {
                if self < other || other.is_nan() {
                    self
                } else {
                    other
                }
            }
            #[inline]
            fn max(self, other: Self) -> Self {
                if self > other || other.is_nan() {
                    self
                } else {
                    other
                }
            }
        }
    };
}

scalar!(
    f32,
    sqrtf,
    crate::sine::sine_cosine,
    half_angles::one_by_one,
    atan2f,
    5e-6
);
scalar!(f64, sqrt, libm::sincos, half_angles::of_f64, atan2, 1e-14);
