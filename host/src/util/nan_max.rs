//! Maxima that never lose a NaN, medians and bounding boxes.

use nalgebra::SVector;

/// Returns the largest of numbers that are not negative, 0 for none, and NaN if any is NaN, so that a broken folding
/// map never passes for a good one. Compares the bits, which have the order of the numbers, with NaN last.
pub(crate) fn largest(numbers: impl IntoIterator<Item = f64>) -> f64 {
    let bits = numbers.into_iter().map(f64::to_bits);
    f64::from_bits(bits.fold(0, u64::max))
}

/// Returns the median of the numbers, the upper one of two; `None` for none.
pub(crate) fn median(numbers: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut numbers: Vec<f64> = numbers.into_iter().collect();
    let middle = numbers.len() / 2;
    (!numbers.is_empty()).then(|| *numbers.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Returns the diagonal of the bounding box of the points, 0 for none.
pub(crate) fn diagonal<const D: usize>(points: &[SVector<f64, D>]) -> f64 {
    let corners = bounding_box(points.iter().copied());
    corners.map_or(0.0, |(low, high)| (high - low).norm())
}

/// Returns the lower and the upper corner of the bounding box of the points, `None` for none.
pub(crate) fn bounding_box<const D: usize>(
    points: impl IntoIterator<Item = SVector<f64, D>>,
) -> Option<(SVector<f64, D>, SVector<f64, D>)> {
    let corners = points.into_iter().map(|point| (point, point));
    corners.reduce(|(low, high), (p, _)| (low.inf(&p), high.sup(&p)))
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
