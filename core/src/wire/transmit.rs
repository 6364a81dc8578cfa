//! A ring buffer of bytes that wait for the line.

use heapless::Deque;

use crate::wire::cobs;

/// A ring buffer of `N` bytes between the program, which adds frames, and the line, which takes bytes. Adding never
/// waits: a frame without room is not added.
#[derive(Debug, Default)]
pub struct Ring<const N: usize> {
    bytes: Deque<u8, N>,
}

impl<const N: usize> Ring<N> {
    /// Adds a frame if it leaves `reserve` bytes free; returns `true` if it did.
    pub fn add(&mut self, frame: &[u8], reserve: usize) -> bool {
        let free = N.saturating_sub(self.bytes.len());
        let fits = cobs::longest(frame.len()).saturating_add(reserve) <= free;
        if fits {
            cobs::encode(frame, |byte| {
                let _ = self.bytes.push_back(byte);
            });
        }
        fits
    }

    /// Takes the next byte for the line.
    pub fn take(&mut self) -> Option<u8> {
        self.bytes.pop_front()
    }

    /// Returns `true` if there is nothing to send.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }
}
