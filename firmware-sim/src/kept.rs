//! The record that a controller keeps over a reset: its commanded angles, its place on the path, and the stop line.

use foldpath_core::checksum;
use foldpath_core::follower::FollowerPosition;

use crate::application::RECORD;

/// Largest number of groups for which a record has room.
const GROUPS: usize = RECORD / 4 - 6;

/// The angles that were commanded last, and their place on the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kept {
    /// Number of starts (`starts`) and of records written (`count`), modulo 2³².
    pub(crate) starts: u32,
    pub(crate) count: u32,
    /// `true` if the stop line holds the motion.
    pub(crate) stopped: bool,
    pub(crate) place: FollowerPosition<f32>,
    groups: u32,
    angles: [f32; GROUPS],
}

impl Kept {
    /// Creates a record with these angles; `None` if there are too many.
    pub(crate) fn new(starts: u32, count: u32, angles: &[f32]) -> Option<Self> {
        let mut kept = [0.0; GROUPS];
        kept.get_mut(..angles.len())?.copy_from_slice(angles);
        Some(Self {
            starts,
            count,
            stopped: false,
            place: FollowerPosition::default(),
            groups: u32::try_from(angles.len()).ok()?,
            angles: kept,
        })
    }

    /// Returns the angle of each group, radians.
    pub(crate) fn angles(&self) -> &[f32] {
        let groups = usize::try_from(self.groups).unwrap_or(usize::MAX);
        self.angles.get(..groups).unwrap_or(&[])
    }

    /// Encodes the record: its numbers, 4 bytes each, little endian, behind the checksum of their bytes.
    pub(crate) fn seal(&self) -> [u8; RECORD] {
        let mut record = [0; RECORD];
        let head = [
            self.starts,
            self.count,
            u32::from(self.stopped),
            self.groups,
        ];
        let place = [self.place.knot, self.place.into.to_bits()];
        let angles = self.angles.iter().map(|angle| angle.to_bits());
        let (words, _) = record.as_chunks_mut();
        if let [checked, words @ ..] = words {
            let numbers = head.into_iter().chain(place).chain(angles);
            for (word, number) in words.iter_mut().zip(numbers) {
                *word = number.to_le_bytes();
            }
            *checked = checksum(words.as_flattened()).to_le_bytes();
        }
        record
    }

    /// Decodes a record; `None` if its checksum differs.
    #[inline(never)]
    pub(crate) fn open(record: &[u8; RECORD]) -> Option<Self> {
        let (words, _) = record.as_chunks();
        let [checked, words @ ..] = words else {
            return None;
        };
        if checksum(words.as_flattened()).to_le_bytes() != *checked {
            return None;
        }
        let mut numbers = words.iter().map(|word| u32::from_le_bytes(*word));
        let [starts, count, stopped] = [numbers.next()?, numbers.next()?, numbers.next()?];
        let groups = numbers.next()?;
        let place = FollowerPosition {
            knot: numbers.next()?,
            into: f32::from_bits(numbers.next()?),
        };
        let mut angles = [0.0; GROUPS];
        for (angle, bits) in angles.iter_mut().zip(numbers) {
            *angle = f32::from_bits(bits);
        }
        Some(Self {
            starts,
            count,
            stopped: stopped != 0,
            place,
            groups,
            angles,
        })
    }

    /// Returns the one of two records that was written last, among those that are whole.
    pub(crate) fn latest(records: &[[u8; RECORD]; 2]) -> Option<Self> {
        let [a, b] = records.each_ref().map(Self::open);
        let (Some(a), Some(b)) = (a, b) else {
            return a.or(b);
        };
        let later = b.count.wrapping_sub(a.count).cast_signed() > 0;
        Some(if later { b } else { a })
    }
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test may panic"
)]
mod tests {
    use super::Kept;
    use crate::application::RECORD;

    fn record(count: u32) -> [u8; RECORD] {
        let angle = f32::from_bits(count);
        Kept::new(7, count, &[angle; 4]).unwrap().seal()
    }

    /// A reset may come between any two bytes of a record; the record before it is found then.
    #[test]
    fn a_torn_record_is_not_taken() {
        for count in [5, u32::MAX] {
            let next = count.wrapping_add(1);
            let (before, old, new) = (record(count.wrapping_sub(1)), record(count), record(next));
            for cut in 0..=RECORD {
                let mut torn = before;
                torn[..cut].copy_from_slice(&new[..cut]);
                let found = [[old, torn], [torn, old]].map(|records| {
                    let kept = Kept::latest(&records).unwrap();
                    assert_eq!(kept.starts, 7);
                    assert_eq!(kept.angles().len(), 4);
                    kept.count
                });
                let expected = if torn == new { next } else { count };
                assert_eq!(found, [expected; 2], "{cut}");
            }
        }
    }

    #[test]
    fn what_lies_in_memory_at_power_on_is_nothing() {
        for byte in 0..=u8::MAX {
            assert_eq!(Kept::latest(&[[byte; RECORD]; 2]), None);
        }
    }

    #[test]
    fn what_is_kept_is_found() {
        let mut kept = Kept::new(3, 9, &[0.5, -1.25]).unwrap();
        (kept.stopped, kept.place.knot, kept.place.into) = (true, 11, 0.125);
        assert_eq!(Kept::open(&kept.seal()), Some(kept));
        assert_eq!(kept.angles(), [0.5, -1.25]);
        assert_eq!(Kept::new(0, 0, &[0.0; 11]), None);
    }
}
