//! Frames: the node, the session, a message as postcard encodes it, and the CRC-32 of all.

use serde::{Deserialize, Serialize};

use crate::checksum::checksum;

/// Number of bytes of a frame besides its message.
pub const OVERHEAD: usize = 9;

/// Writes a frame for the only controller of a line, node 0, into `buffer` and returns it; `None` if there is no room.
pub fn seal<'b>(session: u32, message: &impl Serialize, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
    seal_for(0, session, message, buffer)
}

/// Writes a frame from or for the controller `node` into `buffer` and returns it; `None` if there is no room.
pub fn seal_for<'b>(
    node: u8,
    session: u32,
    message: &impl Serialize,
    buffer: &'b mut [u8],
) -> Option<&'b [u8]> {
    let (head, body) = buffer.split_first_chunk_mut::<5>()?;
    let [a, b, c, d] = session.to_le_bytes();
    *head = [node, a, b, c, d];
    let message = postcard::to_slice(message, body).ok()?.len();
    let (covered, rest) = buffer.split_at_mut_checked(5 + message)?;
    *rest.first_chunk_mut::<4>()? = checksum(covered).to_le_bytes();
    buffer.get(..message + OVERHEAD)
}

/// Returns session and message of a frame of node 0; see [`open_for`].
pub fn open<'b, M: Deserialize<'b>>(frame: &'b [u8]) -> Option<(u32, M)> {
    open_for(0, frame)
}

/// Returns session and message of a frame of `node`; `None` if the frame is that of another node, if the checksum
/// differs, or if the bytes are not those of exactly one message.
pub fn open_for<'b, M: Deserialize<'b>>(node: u8, frame: &'b [u8]) -> Option<(u32, M)> {
    let (covered, sum) = frame.split_last_chunk::<4>()?;
    let ([to, session @ ..], body) = covered.split_first_chunk::<5>()?;
    if *to != node || checksum(covered).to_le_bytes() != *sum {
        return None;
    }
    let (message, rest) = postcard::take_from_bytes(body).ok()?;
    rest.is_empty()
        .then_some((u32::from_le_bytes(*session), message))
}
