//! The controller's end of a link with or without a key: decides which frames are taken, and writes the checksum or the tag
//! behind each message.

use core::fmt;

use crate::wire::frame;
use crate::wire::key::{Channel, Direction, Key, Nonces};

/// Protection of the frames of a [`Receiver`](crate::wire::receiver::Receiver). Without a key it is [`Unkeyed`].
pub trait Protection: Clone + fmt::Debug {
    /// `true` if there is room for a key.
    const KEYED: bool;

    /// Creates the end of a link with this key. Without a key, or without room for one, it takes frames of any host.
    fn with_key(key: Option<Key>) -> Self;

    /// Returns the bytes of node, session and message of a frame of this session, if the frame may be taken.
    fn take<'b>(&mut self, session: u32, frame: &'b [u8]) -> Option<&'b [u8]>;

    /// Returns `true` if this session was offered to the host that has greeted last. The caller compares the ids.
    fn knows(&self, session: u32) -> bool;

    /// Makes the keys of a session that is offered to the host `id` that has greeted last, by a controller of this
    /// `nonce`. Returns `false` if no session can be offered any more.
    fn offer(&mut self, id: u32, nonce: u64, session: u32) -> bool;

    /// Notes that the session that was offered last has begun.
    fn begin(&mut self);

    /// Writes a checksum, or a counter and a tag, behind the first `length` bytes of a frame of this session. Returns the length of the
    /// whole; `None` if there is no room, or if the session can send no more.
    fn close(&self, session: u32, buffer: &mut [u8], length: usize) -> Option<usize>;

    /// Notes that a closed frame of this session is on its way.
    fn advance(&mut self, session: u32);

    /// Takes a key, if there is room for one and none is there yet. Returns `true` if it was taken; all sessions are over
    /// then.
    fn pair(&mut self, key: Key) -> bool;

    /// Returns the key that was taken since the last call.
    fn new_key(&mut self) -> Option<Key>;
}

/// Frames with a checksum: anybody may send them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unkeyed;

impl Protection for Unkeyed {
    const KEYED: bool = false;

    fn with_key(_: Option<Key>) -> Self {
        Self
    }

    fn take<'b>(&mut self, _: u32, frame: &'b [u8]) -> Option<&'b [u8]> {
        frame::checked(frame)
    }

    fn knows(&self, _: u32) -> bool {
        true
    }

    fn offer(&mut self, _: u32, _: u64, _: u32) -> bool {
        true
    }

    fn begin(&mut self) {}

    fn close(&self, _: u32, buffer: &mut [u8], length: usize) -> Option<usize> {
        frame::close(buffer, length)
    }

    fn advance(&mut self, _: u32) {}

    fn pair(&mut self, _: Key) -> bool {
        false
    }

    fn new_key(&mut self) -> Option<Key> {
        None
    }
}

/// Frames with a tag, once there is a key; before, frames with a checksum.
#[derive(Clone, Debug, Default)]
pub struct Keyed {
    key: Option<Key>,
    /// The key, until it was asked for.
    new: Option<Key>,
    /// Upper half of the nonce of the host that has greeted last; its lower half is the host's id.
    greeted: u32,
    /// Number of sessions that were offered. The 2³²-nd offer is the last: after it the numbers of sessions would repeat,
    /// and a number that repeats would give a host with the same nonce the same keys.
    offers: u32,
    offered: Option<Offer>,
    open: Option<Offer>,
}

/// A session that was offered.
#[derive(Clone, Copy, Debug)]
struct Offer {
    /// Upper half of the nonce of the host.
    greeted: u32,
    channel: Channel,
}

impl Protection for Keyed {
    const KEYED: bool = true;

    fn with_key(key: Option<Key>) -> Self {
        Self {
            key,
            ..Self::default()
        }
    }

    fn take<'b>(&mut self, session: u32, frame: &'b [u8]) -> Option<&'b [u8]> {
        let Some(key) = &self.key else {
            return frame::checked(frame);
        };
        if session == 0 {
            let key = key.of(Direction::ToDevice, Nonces::default(), 0);
            let (upper, covered) = key.check(frame)?;
            self.greeted = upper;
            return Some(covered);
        }
        let offers = [&mut self.open, &mut self.offered].into_iter().flatten();
        let offer = { offers }.find(|offer| offer.channel.session() == session);
        offer?.channel.take(frame)
    }

    fn knows(&self, session: u32) -> bool {
        let offers = [&self.open, &self.offered].into_iter().flatten();
        let offer = { offers }.find(|offer| offer.channel.session() == session);
        self.key.is_none() || offer.is_some_and(|offer| offer.greeted == self.greeted)
    }

    fn offer(&mut self, id: u32, nonce: u64, session: u32) -> bool {
        let Some(key) = &self.key else {
            return true;
        };
        let Some(offers) = self.offers.checked_add(1) else {
            return false;
        };
        let nonces = Nonces {
            host: u64::from(self.greeted) << 32 | u64::from(id),
            device: nonce,
        };
        self.offers = offers;
        self.offered = Some(Offer {
            greeted: self.greeted,
            channel: Channel::new(key, Direction::ToHost, nonces, session, 0),
        });
        true
    }

    fn begin(&mut self) {
        self.open = self.offered.take();
    }

    fn close(&self, session: u32, buffer: &mut [u8], length: usize) -> Option<usize> {
        let Some(key) = &self.key else {
            return frame::close(buffer, length);
        };
        if session == 0 {
            let key = key.of(Direction::ToHost, Nonces::default(), 0);
            return key.close(self.greeted, buffer, length);
        }
        let open = self.open.as_ref().map(|offer| &offer.channel);
        let open = open.filter(|open| open.session() == session);
        open?.close(buffer, length)
    }

    fn advance(&mut self, session: u32) {
        if let Some(Offer { channel, .. }) = &mut self.open
            && channel.session() == session
        {
            channel.advance();
        }
    }

    fn pair(&mut self, key: Key) -> bool {
        let new = self.key.is_none();
        if new {
            *self = Self {
                new: Some(key),
                ..Self::with_key(Some(key))
            };
        }
        new
    }

    fn new_key(&mut self) -> Option<Key> {
        self.new.take()
    }
}
