//! Keys of an authenticated link: SipHash-2-4 ([AumassonBernstein2012](crate#references)) over each frame.
//!
//! Host and controller share a [`Key`], from which every session has two keys of its own, one for each direction: see
//! [`Key::of`]. A frame carries a counter and a tag. A [`Channel`] is one end of a session: it takes no counter twice.
//!
//! A counter refuses what was taken before, but not what was kept back. The controller therefore counts [epochs](epoch) of
//! its clock and tells them, the host repeats the newest one in each frame of a session, and a frame is
//! [fresh](is_fresh) for at most two epochs.

use core::fmt;

use siphasher::sip::SipHasher24;

use crate::wire::sequence::low_bits;

/// Number of bytes of a counter and a tag.
pub const TRAILER: usize = 12;

/// Returns the epoch at `now`, microseconds on the controller's clock: an epoch lasts 2²¹ of them, 2.1 s. Only the lowest 8
/// bits are told.
#[must_use]
pub fn epoch(now: u64) -> u32 {
    low_bits(now >> 21)
}

/// Returns the lowest 8 bits of an epoch.
#[must_use]
pub fn low_byte(epoch: u32) -> u8 {
    let [low_byte, ..] = epoch.to_le_bytes();
    low_byte
}

/// Returns `true` if a frame with these lowest bits of an epoch is fresh in the epoch `now`, in a session of which a frame
/// was last taken, or which was offered, in the epoch `last`.
///
/// The bits come again after 256 epochs. A session of which nothing was taken for 128 epochs is over, because a frame that
/// was kept back in it might seem fresh.
#[must_use]
pub fn is_fresh(bits: u8, now: u32, last: u32) -> bool {
    low_byte(now).wrapping_sub(bits) <= 1 && now.wrapping_sub(last) < 128
}

/// A key of 128 bits.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Key([u8; Key::SIZE]);

/// Direction of a frame. Each direction has a key of its own, so that a frame that is sent back is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From the host to the controller.
    ToDevice = 1,
    /// From the controller to the host.
    ToHost = 2,
}

/// Numbers that their owners never use twice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Nonces {
    /// Nonce of the host, which differs in each of its sessions.
    pub host: u64,
    /// Nonce of the controller, which differs in each of its runs.
    pub device: u64,
}

impl Key {
    /// Number of bytes of a key.
    pub const SIZE: usize = 16;

    /// Makes a key of its bytes.
    #[must_use]
    pub const fn new(bytes: [u8; Self::SIZE]) -> Self {
        Self(bytes)
    }

    /// Returns the bytes of the key.
    #[must_use]
    pub const fn bytes(&self) -> &[u8; Self::SIZE] {
        &self.0
    }

    /// Returns the SipHash-2-4 of some bytes. Cost: proportional to their number.
    // Not inlined, so that an image has it once.
    #[inline(never)]
    #[must_use]
    pub fn tag(&self, bytes: &[u8]) -> u64 {
        SipHasher24::new_with_key(&self.0).hash(bytes)
    }

    /// Returns the key for one direction of a session: the tags of direction, half (0 or 1), both nonces and the session,
    /// little endian. Greetings are of session 0 and have nonces of 0.
    // Not inlined, so that an image has it once.
    #[inline(never)]
    #[must_use]
    pub fn of(&self, direction: Direction, nonces: Nonces, session: u32) -> Self {
        let mut input = [0; 22];
        let [way, _, places @ ..] = &mut input;
        *way = direction as u8;
        let (host, rest) = places.split_at_mut(8);
        let (device, number) = rest.split_at_mut(8);
        host.copy_from_slice(&nonces.host.to_le_bytes());
        device.copy_from_slice(&nonces.device.to_le_bytes());
        number.copy_from_slice(&session.to_le_bytes());
        let [low, high] = [0, 1].map(|number| {
            let [_, half, ..] = &mut input;
            *half = number;
            self.tag(&input)
        });
        Self((u128::from(high) << 64 | u128::from(low)).to_le_bytes())
    }

    /// Writes a counter and the tag of all bytes before it behind the first `length` bytes of a frame. Returns the length
    /// of the whole; `None` if there is no room.
    pub(crate) fn close(&self, counter: u32, buffer: &mut [u8], length: usize) -> Option<usize> {
        let (_, rest) = buffer.split_at_mut_checked(length)?;
        *rest.first_chunk_mut::<4>()? = counter.to_le_bytes();
        let (covered, rest) = buffer.split_at_mut_checked(length + 4)?;
        *rest.first_chunk_mut::<8>()? = self.tag(covered).to_le_bytes();
        Some(length + TRAILER)
    }

    /// Returns the counter of a frame and the bytes before it; `None` if the tag differs.
    pub(crate) fn check<'b>(&self, frame: &'b [u8]) -> Option<(u32, &'b [u8])> {
        let (covered, tag) = frame.split_last_chunk::<8>()?;
        let (rest, counter) = covered.split_last_chunk::<4>()?;
        // One comparison of all bits: its duration tells nothing of the tag.
        (self.tag(covered) == u64::from_le_bytes(*tag))
            .then_some((u32::from_le_bytes(*counter), rest))
    }
}

/// The key that a board has stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StoredKey {
    /// There is none: no key was ever stored as a whole.
    #[default]
    None,
    /// The key.
    Key(Key),
    /// A key was stored and cannot be read any more. A controller takes no frames then: otherwise damage would open it to
    /// everybody.
    Damaged,
}

impl From<Option<Key>> for StoredKey {
    fn from(key: Option<Key>) -> Self {
        key.map_or(Self::None, Self::Key)
    }
}

/// Hides the bytes, so that no log tells them.
impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key")
    }
}

/// One end of a session: the keys of both directions, and the counters that were used.
#[derive(Clone, Copy, Debug)]
pub struct Channel {
    session: u32,
    incoming: Key,
    outgoing: Key,
    /// Counter of the last frame that was taken; the next one is larger.
    taken: u32,
    /// Counter of the last frame that was sent.
    sent: u32,
}

impl Channel {
    /// Opens the end of a session that sends in this direction. Its first frame has the counter behind `sent`.
    #[must_use]
    pub fn new(key: &Key, outgoing: Direction, nonces: Nonces, session: u32, sent: u32) -> Self {
        let incoming = match outgoing {
            Direction::ToDevice => Direction::ToHost,
            Direction::ToHost => Direction::ToDevice,
        };
        Self {
            session,
            incoming: key.of(incoming, nonces, session),
            outgoing: key.of(outgoing, nonces, session),
            taken: 0,
            sent,
        }
    }

    /// Returns the number of the session.
    #[must_use]
    pub fn session(&self) -> u32 {
        self.session
    }

    /// Returns the counter of the last frame that was sent.
    #[must_use]
    pub fn sent(&self) -> u32 {
        self.sent
    }

    /// Returns the bytes before the counter of a frame that is taken: its tag is right, its counter is larger than all
    /// before, and the bytes are `good`.
    pub fn take_if<'b>(
        &mut self,
        frame: &'b [u8],
        good: impl FnOnce(&'b [u8]) -> bool,
    ) -> Option<&'b [u8]> {
        let (counter, covered) = self.incoming.check(frame)?;
        (counter > self.taken && good(covered)).then_some(())?;
        self.taken = counter;
        Some(covered)
    }

    /// Returns the bytes before the counter of a frame that is taken: its tag is right, and its counter is larger than all
    /// before.
    pub fn take<'b>(&mut self, frame: &'b [u8]) -> Option<&'b [u8]> {
        self.take_if(frame, |_| true)
    }

    /// Writes the next counter and a tag behind the first `length` bytes of a frame, [`TRAILER`] bytes. Returns the length of
    /// the whole; `None` if there is no room, or if no counter is left. The counter is used up by [`advance`](Self::advance).
    #[must_use]
    pub fn close(&self, buffer: &mut [u8], length: usize) -> Option<usize> {
        let counter = self.sent.checked_add(1)?;
        self.outgoing.close(counter, buffer, length)
    }

    /// Notes that a closed frame is on its way.
    pub fn advance(&mut self) {
        self.sent = self.sent.saturating_add(1);
    }
}
