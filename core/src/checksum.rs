//! The checksum of files and frames, CRC-32 ISO-HDLC: was a byte changed on the way?

/// Polynomial of the checksum, with its bits reversed.
const POLYNOMIAL: u32 = 0xedb8_8320;

/// The checksum that each value of a byte leaves behind it.
static TABLE: [u32; 256] = table();

#[allow(
    clippy::indexing_slicing,
    reason = "evaluated by the compiler, with a place for each value"
)]
const fn table() -> [u32; 256] {
    let mut rest = [0; 256];
    let mut place = 0;
    let mut of = 0;
    while place < rest.len() {
        let (mut value, mut bit): (u32, usize) = (of, 0);
        while bit < 8 {
            let odd = value & 1 == 1;
            value >>= 1;
            if odd {
                value ^= POLYNOMIAL;
            }
            bit += 1;
        }
        rest[place] = value;
        place += 1;
        of += 1;
    }
    rest
}

/// Returns the CRC-32 ISO-HDLC of some bytes and more bytes behind them, given the CRC-32 `before` of the bytes before
/// them; 0 stands for no bytes before. Cost: proportional to the number of bytes.
// Not inlined, so that an image has it once.
#[inline(never)]
#[must_use]
pub fn checksum_on(before: u32, bytes: &[u8]) -> u32 {
    let mut sum = !before;
    for byte in bytes {
        sum ^= u32::from(*byte);
        let [low, ..] = sum.to_le_bytes();
        // Every value has its place in the table.
        let rest = TABLE.get(usize::from(low));
        sum = sum >> 8 ^ rest.copied().unwrap_or(0);
    }
    !sum
}

/// Returns the CRC-32 ISO-HDLC of some bytes. Cost: proportional to their number.
#[must_use]
pub fn checksum(bytes: &[u8]) -> u32 {
    checksum_on(0, bytes)
}
