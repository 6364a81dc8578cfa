//! The controller's end of a link with or without a key: decides which frames are taken, and writes the checksum or the tag
//! behind each message.

use core::fmt;

use crate::wire::frame;
use crate::wire::key::{Channel, Direction, Key, Nonces, StoredKey, is_fresh};

/// Largest number of sessions that a controller with a key offers in a run. The number of a session is the sum of the
/// host's id and a count that passes over at most two numbers for each offer. So it does not come again for that host, which
/// would then have the same keys again.
const MAX_OFFERS: u32 = 1 << 30;

/// Protection of the frames of a [`Receiver`](crate::wire::receiver::Receiver). Without a key it is [`Unkeyed`].
pub trait Protection: Clone + fmt::Debug {
    /// `true` if there is room for a key.
    const KEYED: bool;
    /// The protection of a session that was offered or is open.
    type Session: Copy + fmt::Debug;

    /// Creates the end of a link with this key. Without a key, or without room for one, it takes frames of any host.
    fn with_key(key: StoredKey) -> Self;

    /// Returns the bytes of node, session and message of a frame that may be taken without a key.
    fn plain<'b>(&self, frame: &'b [u8]) -> Option<&'b [u8]>;

    /// Returns the bytes of node, session and message of a frame of session 0 that may be taken, and the upper half of its
    /// host's nonce.
    fn greeting<'b>(&self, frame: &'b [u8]) -> Option<(u32, &'b [u8])>;

    /// Writes a checksum, or the upper half of the host's nonce and a tag, behind the first `length` bytes of an answer to a
    /// greeting. Returns the length of the whole; `None` if there is no room.
    fn close_greeting(&self, upper: u32, buffer: &mut [u8], length: usize) -> Option<usize>;

    /// Makes the protection of a session that is offered in this epoch; `None` if no session can be offered any more.
    fn offer(&mut self, nonces: Nonces, session: u32, epoch: u32) -> Option<Self::Session>;

    /// Returns the bytes of node, session and message of a frame of a session, if the frame may be taken in this epoch.
    fn take<'b>(session: &mut Self::Session, frame: &'b [u8], epoch: u32) -> Option<&'b [u8]>;

    /// Writes a checksum, or a counter and a tag, behind the first `length` bytes of a frame of a session. Returns the length
    /// of the whole; `None` if there is no room, or if the session can send no more.
    fn close(session: &Self::Session, buffer: &mut [u8], length: usize) -> Option<usize>;

    /// Notes that a closed frame of a session is on its way.
    fn advance(session: &mut Self::Session);

    /// Keeps a key until it is stored, if there is room for one and none is there yet.
    fn propose(&mut self, key: Key);

    /// Returns the key that was proposed since the last call.
    fn proposed(&mut self) -> Option<Key>;

    /// Takes a key, if there is room for one and none is there yet. Returns `true` if it was taken; all sessions are over
    /// then.
    fn pair(&mut self, key: Key) -> bool;
}

/// Frames with a checksum: anybody may send them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unkeyed;

impl Protection for Unkeyed {
    const KEYED: bool = false;
    type Session = ();

    fn with_key(_: StoredKey) -> Self {
        Self
    }

    fn plain<'b>(&self, frame: &'b [u8]) -> Option<&'b [u8]> {
        frame::checked(frame)
    }

    fn greeting<'b>(&self, frame: &'b [u8]) -> Option<(u32, &'b [u8])> {
        Some((0, frame::checked(frame)?))
    }

    fn close_greeting(&self, _: u32, buffer: &mut [u8], length: usize) -> Option<usize> {
        frame::close(buffer, length)
    }

    fn offer(&mut self, _: Nonces, _: u32, _: u32) -> Option<()> {
        Some(())
    }

    fn take<'b>((): &mut (), frame: &'b [u8], _: u32) -> Option<&'b [u8]> {
        frame::checked(frame)
    }

    fn close((): &(), buffer: &mut [u8], length: usize) -> Option<usize> {
        frame::close(buffer, length)
    }

    fn advance((): &mut ()) {}

    fn propose(&mut self, _: Key) {}

    fn proposed(&mut self) -> Option<Key> {
        None
    }

    fn pair(&mut self, _: Key) -> bool {
        false
    }
}

/// Frames with a tag, once there is a key; before, frames with a checksum.
#[derive(Clone, Debug, Default)]
pub struct Keyed {
    key: StoredKey,
    /// A key that is not stored yet.
    proposed: Option<Key>,
    /// Number of sessions that were offered.
    offers: u32,
}

/// A session with a key.
#[derive(Clone, Copy, Debug)]
pub struct Tagged {
    channel: Channel,
    /// Epoch in which a frame was last taken; before the first one, that of the offer.
    last: u32,
}

impl Keyed {
    /// Creates the end of a link with this key, if there is one.
    #[must_use]
    pub fn new(key: Option<Key>) -> Self {
        Self::with_key(key.into())
    }
}

impl Protection for Keyed {
    const KEYED: bool = true;
    type Session = Option<Tagged>;

    fn with_key(key: StoredKey) -> Self {
        Self {
            key,
            ..Self::default()
        }
    }

    fn plain<'b>(&self, frame: &'b [u8]) -> Option<&'b [u8]> {
        (self.key == StoredKey::None).then(|| frame::checked(frame))?
    }

    fn greeting<'b>(&self, frame: &'b [u8]) -> Option<(u32, &'b [u8])> {
        let StoredKey::Key(key) = &self.key else {
            return Some((0, self.plain(frame)?));
        };
        let key = key.of(Direction::ToDevice, Nonces::default(), 0);
        key.check(frame)
    }

    fn close_greeting(&self, upper: u32, buffer: &mut [u8], length: usize) -> Option<usize> {
        let StoredKey::Key(key) = &self.key else {
            return frame::close(buffer, length);
        };
        let key = key.of(Direction::ToHost, Nonces::default(), 0);
        key.close(upper, buffer, length)
    }

    fn offer(&mut self, nonces: Nonces, session: u32, epoch: u32) -> Option<Option<Tagged>> {
        let StoredKey::Key(key) = &self.key else {
            return Some(None);
        };
        (self.offers < MAX_OFFERS).then_some(())?;
        self.offers += 1;
        Some(Some(Tagged {
            channel: Channel::new(key, Direction::ToHost, nonces, session, 0),
            last: epoch,
        }))
    }

    fn take<'b>(session: &mut Option<Tagged>, frame: &'b [u8], epoch: u32) -> Option<&'b [u8]> {
        let Some(Tagged { channel, last }) = session else {
            return frame::checked(frame);
        };
        let fresh = |covered: &[u8]| {
            let bits = covered.last();
            bits.is_some_and(|bits| is_fresh(*bits, epoch, *last))
        };
        let (_, covered) = channel.take_if(frame, fresh)?.split_last()?;
        *last = epoch;
        Some(covered)
    }

    fn close(session: &Option<Tagged>, buffer: &mut [u8], length: usize) -> Option<usize> {
        match session {
            None => frame::close(buffer, length),
            Some(tagged) => tagged.channel.close(buffer, length),
        }
    }

    fn advance(session: &mut Option<Tagged>) {
        if let Some(tagged) = session {
            tagged.channel.advance();
        }
    }

    fn propose(&mut self, key: Key) {
        self.proposed = Some(key).filter(|_| self.key == StoredKey::None);
    }

    fn proposed(&mut self) -> Option<Key> {
        self.proposed.take()
    }

    fn pair(&mut self, key: Key) -> bool {
        let new = self.key == StoredKey::None;
        if new {
            *self = Self::with_key(StoredKey::Key(key));
        }
        new
    }
}
