//! The record that a controller keeps over a reset: where it stands and on which path, the stop line, and a fault.
//!
//! A record is a head of fixed length and an angle for each group. Two records are written in turn, so that a reset
//! between any two bytes leaves one of them whole.

use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

use foldpath_core::checksum_on;
use foldpath_core::follower::{Fault, FollowerPosition};

/// Bytes of the head of a record, its checksum included.
pub const HEAD: usize = 44;

/// Returns the bytes of a record of this number of groups.
#[must_use]
pub const fn size(groups: usize) -> usize {
    HEAD + 4 * groups
}

/// The two records of a board in RAM, of `SIZE` bytes each.
///
/// They belong in a section that the start of a program leaves as it is: then a reset leaves them as they are, and the zeros
/// of [`new`](Self::new) are never written. All bytes are valid, so that memory may hold anything when the power comes.
///
/// ```
/// # use foldpath_controller::retained::{self, Records};
/// // On a board: #[unsafe(link_section = ".uninit.records")]
/// static RECORDS: Records<{ retained::size(2) }> = Records::new();
/// ```
///
/// Bytes beyond `SIZE`, and of records other than 0 and 1, are neither written nor read.
#[derive(Debug)]
pub struct Records<const SIZE: usize>([[AtomicU8; SIZE]; 2]);

impl<const SIZE: usize> Default for Records<SIZE> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const SIZE: usize> Records<SIZE> {
    /// Creates records of zeros.
    #[must_use]
    pub const fn new() -> Self {
        Self([const { [const { AtomicU8::new(0) }; SIZE] }; 2])
    }

    /// Writes bytes from byte `at` on into a record, as [`Board::keep`](crate::Board::keep) does.
    #[inline(never)]
    pub fn keep(&self, record: usize, at: usize, bytes: &[u8]) {
        for (place, byte) in self.places(record, at).iter().zip(bytes) {
            place.store(*byte, Relaxed);
        }
    }

    /// Reads bytes from byte `at` on of a record, as [`Board::kept`](crate::Board::kept) does.
    #[inline(never)]
    pub fn kept(&self, record: usize, at: usize, bytes: &mut [u8]) {
        for (place, byte) in self.places(record, at).iter().zip(bytes) {
            *byte = place.load(Relaxed);
        }
    }

    fn places(&self, record: usize, at: usize) -> &[AtomicU8] {
        let record = self.0.get(record).and_then(|record| record.get(at..));
        record.unwrap_or(&[])
    }
}

/// State of a controller of at most `GROUPS` groups at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record<const GROUPS: usize> {
    /// Number of starts of the controller, resets included, modulo 2³².
    pub starts: u32,
    /// Number of records written, modulo 2³².
    pub count: u32,
    /// Sum of the flags below that are set.
    pub flags: u32,
    /// Failure of the motion, if it has failed.
    pub fault: Option<Fault>,
    /// Position on the path.
    pub place: FollowerPosition<f32>,
    /// Numbers that tell this path and its sheet from others; 0 if there was none.
    pub path: u32,
    /// See `path`.
    pub sheet: u32,
    /// Number of groups; 0 if it is not known where they stand.
    groups: u32,
    angles: [f32; GROUPS],
}

/// Flag of a [`Record`]: the stop line holds the motion.
pub const STOPPED: u32 = 1;
/// Flag of a [`Record`]: the groups stand beside the path, because an approach has not ended.
pub const OFF_PATH: u32 = 2;
/// Flag of a [`Record`]: hinges were measured.
pub const MEASURED: u32 = 4;
/// Flag of a [`Record`]: the drives were to hold the hinges.
pub const HOLDS: u32 = 8;

impl<const GROUPS: usize> Default for Record<GROUPS> {
    fn default() -> Self {
        Self {
            starts: 0,
            count: 0,
            flags: 0,
            fault: None,
            place: FollowerPosition::default(),
            path: 0,
            sheet: 0,
            groups: 0,
            angles: [0.0; GROUPS],
        }
    }
}

/// Memory of a record: its head, and its angles of 4 bytes each.
pub type Bytes<const GROUPS: usize> = ([u8; HEAD], [[u8; 4]; GROUPS]);

impl<const GROUPS: usize> Record<GROUPS> {
    /// Puts the angle of each group into the record, radians; none if it is not known where they stand.
    pub fn stand(&mut self, angles: &[f32]) {
        self.groups = 0;
        for (place, angle) in self.angles.iter_mut().zip(angles) {
            *place = *angle;
            self.groups += 1;
        }
    }

    /// Returns `true` if this flag is set.
    #[must_use]
    pub fn has(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }

    /// Returns the angle of each group, radians; none if it is not known where they stand.
    #[must_use]
    pub fn angles(&self) -> &[f32] {
        self.angles.get(..self.groups as usize).unwrap_or(&[])
    }

    /// Encodes the record of an image: numbers of 4 bytes, little endian. The first is the checksum of all others behind the
    /// number of the image. Returns the number of angles.
    #[inline(never)]
    pub fn seal(&self, image: u32, (head, angles): &mut Bytes<GROUPS>) -> usize {
        let (fault, of) = match self.fault {
            None => (0, 0),
            Some(Fault::Stalled(hinge)) => (1, hinge),
            Some(Fault::Leap(group)) => (2, group.into()),
            Some(Fault::Torn(star)) => (3, star.into()),
        };
        let numbers = [
            self.starts,
            self.count,
            self.flags,
            fault,
            of,
            self.place.knot,
            self.place.into.to_bits(),
            self.path,
            self.sheet,
            self.groups,
        ];
        for (bytes, angle) in angles.iter_mut().zip(self.angles()) {
            *bytes = angle.to_le_bytes();
        }
        let (words, _) = head.as_chunks_mut();
        if let [sum, words @ ..] = words {
            for (word, number) in words.iter_mut().zip(numbers) {
                *word = number.to_le_bytes();
            }
            let used = angles.get(..self.angles().len()).unwrap_or(&[]);
            let behind_head = checksum_on(image, words.as_flattened());
            *sum = checksum_on(behind_head, used.as_flattened()).to_le_bytes();
        }
        self.angles().len()
    }

    /// Decodes a record of an image; `None` if its checksum differs, or if it has more groups.
    #[inline(never)]
    #[must_use]
    pub fn open(image: u32, (head, angles): &Bytes<GROUPS>) -> Option<Self> {
        let (words, _) = head.as_chunks();
        let [sum, words @ ..] = words else {
            return None;
        };
        let [
            starts,
            count,
            flags,
            fault,
            of,
            knot,
            into,
            path,
            on,
            groups,
        ] = *words
        else {
            return None;
        };
        let number = u32::from_le_bytes;
        let used = angles.get(..usize::try_from(number(groups)).ok()?)?;
        let behind_head = checksum_on(image, words.as_flattened());
        if checksum_on(behind_head, used.as_flattened()).to_le_bytes() != *sum {
            return None;
        }
        let mut record = Self {
            starts: number(starts),
            count: number(count),
            flags: number(flags),
            fault: match number(fault) {
                0 => None,
                1 => Some(Fault::Stalled(number(of))),
                2 => Some(Fault::Leap(u16::try_from(number(of)).ok()?)),
                _ => Some(Fault::Torn(u16::try_from(number(of)).ok()?)),
            },
            place: FollowerPosition {
                knot: number(knot),
                into: f32::from_le_bytes(into),
            },
            path: number(path),
            sheet: number(on),
            groups: number(groups),
            angles: [0.0; GROUPS],
        };
        for (angle, bytes) in record.angles.iter_mut().zip(used) {
            *angle = f32::from_le_bytes(*bytes);
        }
        Some(record)
    }

    /// Returns the one of two records that was written last, among those that are whole.
    #[must_use]
    pub fn latest(a: Option<Self>, b: Option<Self>) -> Option<Self> {
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
    use foldpath_core::follower::Fault;

    use super::{Bytes, HEAD, Record, size};

    const IMAGE: u32 = 0x8001_7ffe;

    fn blank<const G: usize>() -> Bytes<G> {
        ([0; HEAD], [[0; 4]; G])
    }

    fn record<const G: usize>(count: u32) -> Bytes<G> {
        let mut record = Record::<G> {
            starts: 7,
            count,
            ..Record::default()
        };
        record.stand(&[f32::from_bits(count); G]);
        let mut bytes = blank();
        assert_eq!(record.seal(IMAGE, &mut bytes), G);
        bytes
    }

    /// Returns `new` up to byte `cut`, and `old` from there on, as if a reset had come in between.
    fn torn<const G: usize>(old: &Bytes<G>, new: &Bytes<G>, cut: usize) -> Bytes<G> {
        let mut torn = *old;
        let head = cut.min(HEAD);
        torn.0[..head].copy_from_slice(&new.0[..head]);
        let angles = cut - head;
        torn.1.as_flattened_mut()[..angles].copy_from_slice(&new.1.as_flattened()[..angles]);
        torn
    }

    /// A reset may come between any two bytes of a record; the record before it is found then.
    fn is_not_taken_if_torn<const G: usize>() {
        for count in [5, u32::MAX] {
            let next = count.wrapping_add(1);
            let (before, old, new) = (record(count.wrapping_sub(1)), record(count), record(next));
            for cut in 0..=size(G) {
                let torn = torn::<G>(&before, &new, cut);
                let found = [[old, torn], [torn, old]].map(|records| {
                    let [a, b] = records.each_ref().map(|bytes| Record::open(IMAGE, bytes));
                    let kept = Record::latest(a, b).unwrap();
                    assert_eq!(kept.starts, 7);
                    assert_eq!(kept.angles().len(), G);
                    kept.count
                });
                let expected = if torn == new { next } else { count };
                assert_eq!(found, [expected; 2], "{cut}");
            }
        }
    }

    #[test]
    fn a_torn_record_is_not_taken() {
        is_not_taken_if_torn::<2>();
        is_not_taken_if_torn::<11>();
        is_not_taken_if_torn::<94>();
    }

    #[test]
    fn what_lies_in_memory_at_power_on_is_nothing() {
        for byte in 0..=u8::MAX {
            assert_eq!(
                Record::<3>::open(IMAGE, &([byte; HEAD], [[byte; 4]; 3])),
                None
            );
        }
    }

    #[test]
    fn what_is_kept_is_found() {
        let faults = [
            None,
            Some(Fault::Stalled(70_000)),
            Some(Fault::Leap(9)),
            Some(Fault::Torn(5)),
        ];
        for (flags, fault) in (0..16).flat_map(|flags| faults.map(|fault| (flags, fault))) {
            let mut kept = Record::<94> {
                starts: 3,
                count: 9,
                flags,
                fault,
                path: 17,
                sheet: u32::MAX,
                ..Record::default()
            };
            (kept.place.knot, kept.place.into) = (11, 0.125);
            let mut bytes = blank();
            assert_eq!(kept.seal(IMAGE, &mut bytes), 0);
            assert_eq!(Record::open(IMAGE, &bytes), Some(kept));
            kept.stand(&[0.5, -1.25]);
            kept.seal(IMAGE, &mut bytes);
            assert_eq!(Record::open(IMAGE, &bytes), Some(kept));
            assert_eq!(kept.angles(), [0.5, -1.25]);
        }
    }
}
