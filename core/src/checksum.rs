//! The checksum of files and frames, CRC-32 ISO-HDLC: was a byte changed on the way?

use crc::{CRC_32_ISO_HDLC, Crc};

pub(crate) static CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Returns the CRC-32 ISO-HDLC of some bytes and more bytes behind them, given the CRC-32 `before` of the bytes before
/// them; 0 stands for no bytes before. Cost: proportional to the number of bytes.
#[must_use]
pub fn checksum_on(before: u32, bytes: &[u8]) -> u32 {
    // The initial value is given with its bits reversed.
    let mut digest = CHECKSUM.digest_with_initial((!before).reverse_bits());
    digest.update(bytes);
    digest.finalize()
}

/// Returns the CRC-32 ISO-HDLC of some bytes. Cost: proportional to their number.
// Not inlined, so that an image has it once: its loop runs over as many bytes as a file has.
#[inline(never)]
#[must_use]
pub fn checksum(bytes: &[u8]) -> u32 {
    CHECKSUM.checksum(bytes)
}
