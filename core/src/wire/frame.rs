//! Frames: the node, the session, a message as postcard encodes it, and the CRC-32 of all. On a link with a key a counter
//! and a tag stand in the place of the CRC-32: see [`key`](crate::wire::key).

use postcard::{Deserializer, Error, de_flavors, ser_flavors};
use serde::{Deserialize, Serialize};

use crate::checksum::checksum;

/// Writes a frame for the only controller of a line, node 0, into `buffer` and returns it; `None` if there is no room.
pub fn seal<'b>(session: u32, message: &impl Serialize, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
    let length = write(0, session, message, buffer)?;
    let length = close(buffer, length)?;
    buffer.get(..length)
}

/// Writes node, session and message to `buffer` and returns their length; `None` if there is no room.
pub(crate) fn write(
    node: u8,
    session: u32,
    message: &impl Serialize,
    buffer: &mut [u8],
) -> Option<usize> {
    let (head, body) = buffer.split_first_chunk_mut::<5>()?;
    let [a, b, c, d] = session.to_le_bytes();
    *head = [node, a, b, c, d];
    let bytes = Written { body, length: 0 };
    let message = postcard::serialize_with_flavor(message, bytes).ok()?;
    Some(5 + message)
}

/// Writes the checksum of the first `length` bytes of a frame behind them. Returns the length of the whole; `None` if
/// there is no room.
pub(crate) fn close(buffer: &mut [u8], length: usize) -> Option<usize> {
    let (covered, rest) = buffer.split_at_mut_checked(length)?;
    *rest.first_chunk_mut::<4>()? = checksum(covered).to_le_bytes();
    Some(length + 4)
}

/// Returns session and message of a frame of node 0; `None` if the frame is that of another node, if the checksum
/// differs, or if the bytes are not those of exactly one message.
pub fn open<'b, M: Deserialize<'b>>(frame: &'b [u8]) -> Option<(u32, M)> {
    Some((session(0, frame)?, message(checked(frame)?)?))
}

/// Returns the session of a frame of `node`; `None` if the frame is that of another node or too short.
pub(crate) fn session(node: u8, frame: &[u8]) -> Option<u32> {
    let ([to, session @ ..], _) = frame.split_first_chunk::<5>()?;
    (*to == node).then_some(u32::from_le_bytes(*session))
}

/// Returns the bytes before the checksum of a frame; `None` if the checksum differs.
pub(crate) fn checked(frame: &[u8]) -> Option<&[u8]> {
    let (covered, sum) = frame.split_last_chunk::<4>()?;
    (checksum(covered).to_le_bytes() == *sum).then_some(covered)
}

/// Returns the message behind node and session; `None` if the bytes are not those of exactly one message.
pub(crate) fn message<'b, M: Deserialize<'b>>(covered: &'b [u8]) -> Option<M> {
    let (_, body) = covered.split_first_chunk::<5>()?;
    let mut bytes = Deserializer::from_flavor(Unread(body));
    let message = M::deserialize(&mut bytes).ok()?;
    let rest = bytes.finalize().ok()?;
    rest.is_empty().then_some(message)
}

/// The bytes of a message that is encoded. Its functions are not inlined, nor are those of [`Unread`]: inlined once for
/// each field of each message, they would be a tenth of a controller's image.
struct Written<'b> {
    body: &'b mut [u8],
    length: usize,
}

impl ser_flavors::Flavor for Written<'_> {
    type Output = usize;

    #[inline(never)]
    fn try_push(&mut self, byte: u8) -> Result<(), Error> {
        let place = self.body.get_mut(self.length);
        *place.ok_or(Error::SerializeBufferFull)? = byte;
        self.length += 1;
        Ok(())
    }

    #[inline(never)]
    fn try_extend(&mut self, bytes: &[u8]) -> Result<(), Error> {
        bytes.iter().try_for_each(|byte| self.try_push(*byte))
    }

    fn finalize(self) -> Result<usize, Error> {
        Ok(self.length)
    }
}

/// The bytes of a message that are not decoded yet.
struct Unread<'b>(&'b [u8]);

impl<'b> de_flavors::Flavor<'b> for Unread<'b> {
    type Remainder = &'b [u8];
    type Source = &'b [u8];

    #[inline(never)]
    fn pop(&mut self) -> Result<u8, Error> {
        let (byte, rest) = self
            .0
            .split_first()
            .ok_or(Error::DeserializeUnexpectedEnd)?;
        self.0 = rest;
        Ok(*byte)
    }

    #[inline]
    fn try_take_n(&mut self, count: usize) -> Result<&'b [u8], Error> {
        let parts = self.0.split_at_checked(count);
        let (taken, rest) = parts.ok_or(Error::DeserializeUnexpectedEnd)?;
        self.0 = rest;
        Ok(taken)
    }

    fn finalize(self) -> Result<&'b [u8], Error> {
        Ok(self.0)
    }
}
