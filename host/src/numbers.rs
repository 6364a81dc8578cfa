//! Numbers measured on the whole sheet.

/// The largest of numbers that are not negative, 0 for none; NaN if one is, so that a broken map never
/// passes for a good one. Their bits are in the same order, those of NaN last.
pub(crate) fn largest(numbers: impl IntoIterator<Item = f64>) -> f64 {
    let bits = numbers.into_iter().map(f64::to_bits);
    f64::from_bits(bits.fold(0, u64::max))
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
