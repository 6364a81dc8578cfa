//! Consistent overhead byte stuffing (S. Cheshire, M. Baker, 1999): frames that hold no zero and end with one.
//!
//! A block is a code c and c − 1 bytes that are not 0. A block stands for its bytes and a 0 behind them, unless c is
//! 255 or the frame ends.

/// Longest run of bytes without a zero in one block.
const MAX_RUN_BYTES: usize = 254;

/// Returns the largest length on the line of a frame of `length` bytes, with the zero that ends it.
#[must_use]
pub const fn longest(length: usize) -> usize {
    length + length / MAX_RUN_BYTES + 2
}

/// Hands the encoded bytes of a frame to `sink`, with the zero that ends it. Cost: proportional to its length.
pub fn encode(payload: &[u8], mut sink: impl FnMut(u8)) {
    for run in payload.split(|&byte| byte == 0) {
        let mut rest = run;
        loop {
            let (block, more) = rest.split_at_checked(MAX_RUN_BYTES).unwrap_or((rest, &[]));
            let [code, ..] = (block.len() + 1).to_le_bytes();
            sink(code);
            block.iter().for_each(|&byte| sink(byte));
            if block.len() < MAX_RUN_BYTES {
                break;
            }
            rest = more;
        }
    }
    sink(0);
}

/// Decodes frames of at most `N` bytes from a stream of bytes.
#[derive(Clone, Debug)]
pub struct Deframer<const N: usize> {
    buffer: [u8; N],
    length: usize,
    /// Number of bytes of the current block that are still to come.
    left: u8,
    /// `true` if a zero lies between the current block and the next.
    zero: bool,
    /// `true` if the frame is longer than `N` bytes.
    overlong: bool,
}

impl<const N: usize> Default for Deframer<N> {
    fn default() -> Self {
        Self {
            buffer: [0; N],
            length: 0,
            left: 0,
            zero: false,
            overlong: false,
        }
    }
}

impl<const N: usize> Deframer<N> {
    /// Takes a byte; returns the frame that it ends, if the frame is whole and not empty. Forgets whatever came before
    /// the last zero.
    pub fn push(&mut self, byte: u8) -> Option<&[u8]> {
        if byte == 0 {
            let whole = self.left == 0 && !self.overlong;
            let length = if whole { self.length } else { 0 };
            (self.length, self.left) = (0, 0);
            (self.zero, self.overlong) = (false, false);
            return self.buffer.get(..length).filter(|frame| !frame.is_empty());
        }
        if self.left > 0 {
            self.left -= 1;
            self.keep(byte);
        } else {
            if self.zero {
                self.keep(0);
            }
            self.left = byte - 1;
            self.zero = byte < u8::MAX;
        }
        None
    }

    fn keep(&mut self, byte: u8) {
        match self.buffer.get_mut(self.length) {
            Some(place) => {
                *place = byte;
                self.length += 1;
            }
            None => self.overlong = true,
        }
    }
}
