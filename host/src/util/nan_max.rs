//! Maxima that never lose a NaN, and the diagonal of a bounding box.

use nalgebra::SVector;

/// Returns the largest of numbers that are not negative, 0 for none, and NaN if any is NaN, so that a broken folding
/// map never passes for a good one. Compares the bits, which have the order of the numbers, with NaN last.
pub(crate) fn largest(numbers: impl IntoIterator<Item = f64>) -> f64 {
    let bits = numbers.into_iter().map(f64::to_bits);
    f64::from_bits(bits.fold(0, u64::max))
}

/// Returns the diagonal of the bounding box of the points, 0 for none.
pub(crate) fn diagonal<const D: usize>(points: &[SVector<f64, D>]) -> f64 {
    let Some(&first) = points.first() else {
        return 0.0;
    };
    let grow = |(low, high): (SVector<f64, D>, SVector<f64, D>), p| (low.inf(p), high.sup(p));
    let (low, high) = points.iter().fold((first, first), grow);
    (high - low).norm()
}

/// Returns the larger number, and NaN if either is NaN, so that a broken value never passes for a good one.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_is_none_is_never_passed_over() {
        let bits = |numbers: &[f64]| largest(numbers.iter().copied()).to_bits();
        assert_eq!(bits(&[]), 0.0_f64.to_bits());
        assert_eq!(bits(&[0.5, 3.0, 1e-300]), 3.0_f64.to_bits());
        assert_eq!(bits(&[1.0, f64::INFINITY]), f64::INFINITY.to_bits());
        for nan in [f64::NAN, -f64::NAN] {
            assert!(largest([1.0, nan, f64::INFINITY]).is_nan());
        }
    }
}
