//! Numbers in the precision in which a test runs.

use foldpath_core::Scalar;

/// Converts numbers to another precision.
#[must_use]
pub fn cast<T: Scalar, const N: usize>(values: [f64; N]) -> [T; N] {
    values.map(T::lit)
}
