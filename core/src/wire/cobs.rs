//! Consistent overhead byte stuffing (S. Cheshire, M. Baker, 1999): frames without zeros, ended by one.
//!
//! A block is a code c and c − 1 bytes that are not 0; behind it the frame has a 0, unless c is 255 or the
//! frame ends.

/// The longest run without a zero in one block.
const RUN: usize = 254;

/// Length of a frame of `length` bytes on the line, at the most, with the zero that ends it.
#[must_use]
pub const fn longest(length: usize) -> usize {
    length + length / RUN + 2
}

/// Hands the bytes of a frame to `sink`, with the zero that ends it. Cost: proportional to its length.
pub fn encode(payload: &[u8], mut sink: impl FnMut(u8)) {
    for run in payload.split(|&byte| byte == 0) {
        let mut rest = run;
        loop {
            let (block, more) = rest.split_at_checked(RUN).unwrap_or((rest, &[]));
            let [code, ..] = (block.len() + 1).to_le_bytes();
            sink(code);
            block.iter().for_each(|&byte| sink(byte));
            if block.len() < RUN {
                break;
            }
            rest = more;
        }
    }
    sink(0);
}

/// Finds frames of at most `N` bytes in a stream of bytes.
#[derive(Clone, Debug)]
pub struct Deframer<const N: usize> {
    buffer: [u8; N],
    length: usize,
    /// Bytes of the block that are still to come.
    left: u8,
    /// Whether a zero lies between the block and the next.
    zero: bool,
    /// Whether the frame is longer than there is room for.
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
    /// Takes a byte; returns the frame that it ends, if that is whole and not empty. Whatever came before the
    /// last zero is forgotten.
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
