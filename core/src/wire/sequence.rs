//! Sequence numbers modulo 2¹⁶: which of two comes first?

/// Returns how far `number` is ahead of `other`, modulo 2¹⁶; negative if it lies less than half a round behind.
#[inline]
pub(crate) fn ahead(number: u16, other: u16) -> i16 {
    number.wrapping_sub(other).cast_signed()
}

/// Returns the lowest 32 bits, as of a time that is told.
#[inline]
#[must_use]
pub fn low_bits(number: u64) -> u32 {
    let [a, b, c, d, ..] = number.to_le_bytes();
    u32::from_le_bytes([a, b, c, d])
}

/// Returns the lowest 16 bits.
#[inline]
pub(crate) fn wrapped(number: u64) -> u16 {
    let [a, b, ..] = number.to_le_bytes();
    u16::from_le_bytes([a, b])
}
