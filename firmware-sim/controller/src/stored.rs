//! A key in memory that keeps it without power, as whole or not at all.
//!
//! Such memory is written word by word, and the power may go between any two words. The last word, a checksum of the others,
//! says that all are there.

use foldpath_core::checksum;
use foldpath_core::wire::key::{Key, StoredKey};

/// Number of words of a stored key.
pub const WORDS: usize = Key::SIZE / 4 + 1;

/// Returns the words of a key, to be written in this order into memory that was erased before.
#[must_use]
pub fn words(key: &Key) -> [u32; WORDS] {
    let (parts, _) = key.bytes().as_chunks::<4>();
    let mut words = [checksum(key.bytes()); WORDS];
    for (word, part) in words.iter_mut().zip(parts) {
        *word = u32::from_le_bytes(*part);
    }
    words
}

/// Returns the key in memory whose words are `erased` before they are written: 2³² - 1 in flash.
///
/// Without its last word there is no key, whatever the others are: the controller had not taken it when its power went.
/// With a last word that does not fit the others, the key is damaged.
#[must_use]
pub fn open(words: &[u32; WORDS], erased: u32) -> StoredKey {
    let (parts, end) = (words.iter(), words.last());
    if end == Some(&erased) {
        return StoredKey::None;
    }
    let mut bytes = [0; Key::SIZE];
    let (places, _) = bytes.as_chunks_mut::<4>();
    for (place, word) in places.iter_mut().zip(parts) {
        *place = word.to_le_bytes();
    }
    if end == Some(&checksum(&bytes)) {
        StoredKey::Key(Key::new(bytes))
    } else {
        StoredKey::Damaged
    }
}
