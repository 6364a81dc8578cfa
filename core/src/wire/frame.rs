//! Frames: the session, a message as postcard encodes it, and the CRC-32 of both.

use serde::{Deserialize, Serialize};

use crate::checksum::checksum;

/// Number of bytes of a frame besides its message.
pub const OVERHEAD: usize = 8;

/// Writes a frame into `buffer` and returns it; `None` if there is no room.
pub fn seal<'b>(session: u32, message: &impl Serialize, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
    let (head, body) = buffer.split_first_chunk_mut::<4>()?;
    *head = session.to_le_bytes();
    let message = postcard::to_slice(message, body).ok()?.len();
    let (covered, rest) = buffer.split_at_mut_checked(4 + message)?;
    *rest.first_chunk_mut::<4>()? = checksum(covered).to_le_bytes();
    buffer.get(..message + OVERHEAD)
}

/// Returns session and message of a frame; `None` if the checksum differs, or if the bytes are not those of exactly one
/// message.
pub fn open<'b, M: Deserialize<'b>>(frame: &'b [u8]) -> Option<(u32, M)> {
    let (covered, sum) = frame.split_last_chunk::<4>()?;
    if checksum(covered).to_le_bytes() != *sum {
        return None;
    }
    let (session, body) = covered.split_first_chunk::<4>()?;
    let (message, rest) = postcard::take_from_bytes(body).ok()?;
    rest.is_empty()
        .then_some((u32::from_le_bytes(*session), message))
}
