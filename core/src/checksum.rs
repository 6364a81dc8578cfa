//! The checksum of files and frames: CRC-32 ISO-HDLC.

use crc::{CRC_32_ISO_HDLC, Crc};

pub(crate) static CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// CRC-32 ISO-HDLC of some bytes. Cost: proportional to their number.
// Once in an image: its loop is as long as some files.
#[inline(never)]
#[must_use]
pub fn checksum(bytes: &[u8]) -> u32 {
    CHECKSUM.checksum(bytes)
}
