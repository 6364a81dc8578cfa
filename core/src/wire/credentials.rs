//! The host's end of a link with a key.

use crate::wire::key::{Channel, Direction, Key, Nonces};

/// The key that a host shares with a controller, the host's nonce, and the session that the controller has offered.
#[derive(Clone, Debug)]
pub(crate) struct Credentials {
    key: Key,
    /// Nonce of the host; its lower half is the host's id.
    nonce: u64,
    /// The session that was offered, and the nonce of the controller.
    offer: Option<(u64, Channel)>,
}

impl Credentials {
    pub(crate) fn new(key: Key, nonce: u64) -> Self {
        Self {
            key,
            nonce,
            offer: None,
        }
    }

    /// Returns the upper half of the nonce. It stands in the place of the counter in greetings.
    fn upper(&self) -> u32 {
        let [.., a, b, c, d] = self.nonce.to_le_bytes();
        u32::from_le_bytes([a, b, c, d])
    }

    /// Makes the keys of a session that a controller of this nonce offers. An offer that comes again changes nothing.
    pub(crate) fn welcome(&mut self, device: u64, session: u32) {
        let nonces = Nonces {
            host: self.nonce,
            device,
        };
        let known =
            |(old, channel): &(u64, Channel)| (*old, channel.session()) == (device, session);
        if !self.offer.as_ref().is_some_and(known) {
            // Counters go on, so that even an offer that somebody plays back leads to no counter that was used.
            let sent = self.offer.map_or(0, |(_, channel)| channel.sent());
            let channel = Channel::new(&self.key, Direction::ToDevice, nonces, session, sent);
            self.offer = Some((device, channel));
        }
    }

    /// Returns the bytes before the counter of a frame of this session, if the frame may be taken. A greeting has to answer
    /// the one with this host's nonce.
    pub(crate) fn take<'b>(&mut self, session: u32, frame: &'b [u8]) -> Option<&'b [u8]> {
        if session == 0 {
            let key = self.key.of(Direction::ToHost, Nonces::default(), 0);
            let (upper, covered) = key.check(frame)?;
            return (upper == self.upper()).then_some(covered);
        }
        let (_, channel) = self.offer.as_mut()?;
        (channel.session() == session).then_some(())?;
        channel.take(frame)
    }

    /// Closes a frame of this session, of which `epoch` is the newest that was told, and uses its counter up; `None` if
    /// there is no room or no counter left.
    pub(crate) fn close(
        &mut self,
        session: u32,
        epoch: u8,
        buffer: &mut [u8],
        length: usize,
    ) -> Option<usize> {
        if session == 0 {
            let key = self.key.of(Direction::ToDevice, Nonces::default(), 0);
            return key.close(self.upper(), buffer, length);
        }
        let (_, channel) = self.offer.as_mut()?;
        *buffer.get_mut(length)? = epoch;
        let length = channel.close(buffer, length + 1)?;
        channel.advance();
        Some(length)
    }
}
