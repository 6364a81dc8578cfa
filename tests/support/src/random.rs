//! Random numbers from a seed, equal on every machine.

use core::convert::Infallible;
use core::f64::consts::{PI, TAU};

use foldpath_core::Scalar;
use rand_core::{Rng, TryRng};
use rand_pcg::Pcg64;

/// A seeded generator.
///
/// It also implements [`Rng`], so that code under test can draw from it.
#[derive(Clone, Debug)]
pub struct Random(Pcg64);

impl Random {
    /// Creates the generator of this seed, with stream 0.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self::stream(seed, 0)
    }

    /// Creates the generator of this seed. Each `stream` gives another sequence of numbers; the stream of
    /// [`Random::new`] is 0.
    #[must_use]
    pub fn stream(seed: u64, stream: u64) -> Self {
        Self(Pcg64::new(u128::from(seed), u128::from(stream)))
    }

    /// Returns a number from `low` to `high`, both possible.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.0.next_u32()) / f64::from(u32::MAX)
    }

    /// Returns a number from `low` to `high` whose logarithm is uniform; both must be above 0.
    pub fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        self.uniform(low.ln(), high.ln()).exp()
    }

    /// Returns a whole number from 0 to `count - 1`.
    ///
    /// # Panics
    ///
    /// Panics if `count` is 0.
    pub fn below(&mut self, count: usize) -> usize {
        self.0.next_u32() as usize % count
    }

    /// Returns a whole number from `low` to `high`, both possible.
    ///
    /// # Panics
    ///
    /// Panics if `high` is less than `low`.
    pub fn whole(&mut self, low: usize, high: usize) -> usize {
        low + self.below(high - low + 1)
    }

    /// Returns `true` with the probability `part`, from 0 to 1.
    pub fn chance(&mut self, part: f64) -> bool {
        self.uniform(0.0, 1.0) < part
    }

    /// Returns 1 or -1.
    pub fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// Returns a normally distributed number of mean 0 and standard deviation 1 (G. Box, M. Muller).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.uniform(f64::MIN_POSITIVE, 1.0).ln()).sqrt();
        radius * self.uniform(0.0, TAU).cos()
    }

    /// Returns the numbers from 0 to `count - 1` in random order (R. Fisher, F. Yates).
    pub fn permutation(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            order.swap(last, self.whole(0, last));
        }
        order
    }

    /// Returns `count` fold angles, uniform over a full turn, radians.
    pub fn angles<T: Scalar>(&mut self, count: usize) -> Vec<T> {
        (0..count).map(|_| T::lit(self.uniform(-PI, PI))).collect()
    }
}

impl TryRng for Random {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        self.0.try_next_u32()
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        self.0.try_next_u64()
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        self.0.try_fill_bytes(bytes)
    }
}
