//! Links with a key: what does somebody achieve who reads, changes, keeps back and writes every byte of the line, but does
//! not have the key?

mod frames;
mod line;
mod pairing;

use foldpath_core::wire::key::Key;

/// A key, and another one that differs in a bit.
const KEY: Key = Key::new([0x5a; Key::SIZE]);
const OTHER: Key = Key::new([
    0x5a, 0x5a, 0x5a, 0x5a, 0x5a, 0x5a, 0x5a, 0x5a, 0x5a, 0x5a, 0x5a, 0x5a, 0x5a, 0x5a, 0x5a, 0x5b,
]);
