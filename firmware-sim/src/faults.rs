//! A simulated line between host and controller with faults, drawn from a seed, in virtual time.

use std::collections::{BTreeMap, VecDeque};
use std::vec::Vec;

use rand_core::Rng;

/// Faults of one direction of a line. Bytes that are written at once are one piece, and faults befall whole pieces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Faults {
    /// Fraction of the pieces that get lost.
    pub drop: f64,
    /// Fraction of the pieces of which one bit is changed.
    pub flip: f64,
    /// Fraction of the pieces that come twice.
    pub double: f64,
    /// Fraction of the pieces that are overtaken by others.
    pub reorder: f64,
    /// Time that a piece takes, microseconds.
    pub delay: u64,
    /// Largest additional delay of a piece that is overtaken, microseconds.
    pub late: u64,
    /// Bytes per second; infinite for no limit.
    pub speed: f64,
    /// Number of bytes that the near end takes before they are sent: the buffer of an adapter, for one.
    pub buffer: u32,
    /// Number of bytes that may wait at the far end to be taken. Further bytes of a piece get lost.
    pub capacity: usize,
}

impl Default for Faults {
    /// A line without faults.
    fn default() -> Self {
        Self {
            drop: 0.0,
            flip: 0.0,
            double: 0.0,
            reorder: 0.0,
            delay: 0,
            late: 0,
            speed: f64::INFINITY,
            buffer: 0,
            capacity: usize::MAX,
        }
    }
}

/// Numbers of pieces and bytes, and of the faults that befell them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Pieces written.
    pub pieces: u64,
    /// Bytes written.
    pub bytes: u64,
    /// Pieces lost.
    pub dropped: u64,
    /// Pieces with a changed bit.
    pub flipped: u64,
    /// Pieces doubled.
    pub doubled: u64,
    /// Pieces that were overtaken, or could have been.
    pub reordered: u64,
    /// Bytes that found no room at the far end.
    pub overrun: u64,
}

/// One direction of a line. Times are microseconds.
#[derive(Clone, Debug)]
pub struct Line<R> {
    faults: Faults,
    rng: R,
    counts: Counts,
    /// Pieces under way, by their time of arrival and the order in which they were written.
    under_way: BTreeMap<(u64, u64), Vec<u8>>,
    order: u64,
    arrived: VecDeque<u8>,
    /// Time when the line has sent everything that was written.
    free: f64,
    /// Time before which nothing arrives.
    stalled: u64,
}

impl<R: Rng> Line<R> {
    /// Creates a line with these faults, which are drawn from `rng`.
    pub fn new(faults: Faults, rng: R) -> Self {
        Self {
            faults,
            rng,
            counts: Counts::default(),
            under_way: BTreeMap::new(),
            order: 0,
            arrived: VecDeque::new(),
            free: 0.0,
            stalled: 0,
        }
    }

    /// Returns the counts so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Replaces the faults from now on.
    pub fn set(&mut self, faults: Faults) {
        self.faults = faults;
    }

    /// Stalls the line until that time: nothing arrives, and everything waits.
    pub fn stall(&mut self, until: u64) {
        self.stalled = until;
    }

    /// Returns `true` if the line has sent everything that was written before, but for what fits into its buffer.
    #[must_use]
    pub fn is_free(&self, now: u64) -> bool {
        self.waiting(now) <= f64::from(self.faults.buffer)
    }

    /// Returns the number of bytes that were written and not sent.
    #[must_use]
    pub fn waiting(&self, now: u64) -> f64 {
        let time = (self.free - micros(now)).max(0.0);
        if time > 0.0 {
            time * self.faults.speed / 1e6
        } else {
            0.0
        }
    }

    /// Writes a piece at `now`.
    pub fn write(&mut self, bytes: &[u8], now: u64) {
        self.counts.pieces += 1;
        self.counts.bytes += bytes.len() as u64;
        let length = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
        self.free = self.free.max(micros(now)) + f64::from(length) / self.faults.speed * 1e6;
        if self.happens(self.faults.drop) {
            self.counts.dropped += 1;
            return;
        }
        let copies = if self.happens(self.faults.double) {
            2
        } else {
            1
        };
        self.counts.doubled += copies - 1;
        for _ in 0..copies {
            self.copy(bytes);
        }
    }

    /// Puts one copy of a piece on its way.
    fn copy(&mut self, bytes: &[u8]) {
        let mut bytes = bytes.to_vec();
        if !bytes.is_empty() && self.happens(self.faults.flip) {
            self.counts.flipped += 1;
            let place = self.below(bytes.len() as u64 * 8);
            let byte = usize::try_from(place / 8).unwrap_or(0);
            if let Some(byte) = bytes.get_mut(byte) {
                *byte ^= 1 << (place % 8);
            }
        }
        let mut late = self.faults.delay;
        if self.happens(self.faults.reorder) {
            self.counts.reordered += 1;
            late += self.below(self.faults.late + 1);
        }
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a time in microseconds, not negative"
        )]
        let at = self.free.ceil() as u64 + late;
        self.order += 1;
        self.under_way.insert((at, self.order), bytes);
    }

    /// Takes the next byte that has arrived by `now`.
    pub fn read(&mut self, now: u64) -> Option<u8> {
        while now >= self.stalled
            && let Some(entry) = self.under_way.first_entry()
            && entry.key().0 <= now
        {
            for byte in entry.remove() {
                if self.arrived.len() < self.faults.capacity {
                    self.arrived.push_back(byte);
                } else {
                    self.counts.overrun += 1;
                }
            }
        }
        self.arrived.pop_front()
    }

    fn happens(&mut self, part: f64) -> bool {
        f64::from(self.rng.next_u32()) < part * 4_294_967_296.0
    }

    fn below(&mut self, count: u64) -> u64 {
        self.rng.next_u64() % count.max(1)
    }
}

#[allow(clippy::cast_precision_loss, reason = "below 2⁵³ microseconds")]
fn micros(time: u64) -> f64 {
    time as f64
}
