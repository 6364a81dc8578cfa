//! The checksum of files and frames: CRC-32 ISO-HDLC.

use crc::{CRC_32_ISO_HDLC, Crc};

pub(crate) static CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
