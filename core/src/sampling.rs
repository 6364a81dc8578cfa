//! Random configurations for randomised search, from a generator that the caller seeds.

use rand_core::Rng;

use crate::Scalar;
use crate::least_squares::Limits;

/// Writes a random configuration near `center` to `out`: the report's C_rand round C_τ.
///
/// Each angle moves by a uniformly distributed amount of at most `radius` (radians) and is then clamped to its limits.
/// One seed gives one result on every machine: each angle takes one `u32` of the generator.
pub fn random_near<T: Scalar>(
    rng: &mut impl Rng,
    center: &[T],
    radius: T,
    limits: Limits<'_, T>,
    out: &mut [T],
) {
    for (index, (&angle, out)) in center.iter().zip(out).enumerate() {
        let uniform = f64::from(rng.next_u32()) / f64::from(u32::MAX);
        *out = limits.clamp(index, angle + radius * T::lit(2.0 * uniform - 1.0));
    }
}
