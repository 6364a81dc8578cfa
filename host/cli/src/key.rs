//! Files of keys, and numbers that are used once.

use core::hash::{BuildHasher, Hasher};
use std::fs;
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;

use foldpath_core::wire::key::Key;

use crate::CliError;
use crate::standard::is_standard;

/// Largest number of bytes that are read from stdin; a key has 32 digits.
const MAX_BYTES: u64 = 1024;

/// Returns a number that other runs are unlikely to have had.
pub(crate) fn nonce() -> u64 {
    // The standard library keys its hashes at random.
    let hasher = std::collections::hash_map::RandomState::new().build_hasher();
    hasher.finish()
}

/// Reads the key in a file, or from stdin: 32 hexadecimal digits and white space.
///
/// # Errors
/// If the file cannot be read or holds something else.
pub(crate) fn read(path: &Path) -> Result<Key, CliError> {
    if is_standard(path) {
        let mut bytes = Vec::new();
        let read = io::stdin().lock().take(MAX_BYTES).read_to_end(&mut bytes);
        return parse(path, read.map(|_| bytes));
    }
    parse(path, fs::read(path))
}

/// Reads the key in a file, or makes the file with a random key. Returns `true` if the file was made.
///
/// # Errors
/// If the file cannot be read or written, or holds something else.
pub(crate) fn read_or_make(path: &Path) -> Result<(Key, bool), CliError> {
    if is_standard(path) {
        let text = "--key: expected the name of a file that keeps the key, found -";
        return Err(CliError::Usage(text.into()));
    }
    match fs::read(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            // The text of the error would name a temporary file.
            let key = make(path).map_err(|error| unusable(path, &error.kind().into()))?;
            Ok((key, true))
        }
        bytes => Ok((parse(path, bytes)?, false)),
    }
}

fn parse(path: &Path, bytes: io::Result<Vec<u8>>) -> Result<Key, CliError> {
    let bytes = bytes.map_err(|error| unusable(path, &error))?;
    let text = String::from_utf8_lossy(&bytes);
    let text = text.trim();
    // Digits alone: a sign would be read as part of a number.
    let digits = text.len() == 2 * Key::SIZE && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    match u128::from_str_radix(text, 16) {
        Ok(number) if digits => Ok(Key::new(number.to_be_bytes())),
        _ => {
            let path = path.display();
            let text = format!("--key: {path}: expected 32 hexadecimal digits");
            Err(CliError::Usage(text))
        }
    }
}

/// Writes a new key to a file that only its owner can read. The file is there as a whole or not at all.
fn make(path: &Path) -> io::Result<Key> {
    let mut bytes = [0; Key::SIZE];
    getrandom::fill(&mut bytes).map_err(io::Error::other)?;
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    // A temporary file is private to its owner.
    let mut file = tempfile::Builder::new()
        .prefix(".foldpath-")
        .tempfile_in(folder)?;
    writeln!(file, "{:032x}", u128::from_be_bytes(bytes))?;
    file.as_file().sync_all()?;
    file.persist_noclobber(path)?;
    Ok(Key::new(bytes))
}

fn unusable(path: &Path, error: &io::Error) -> CliError {
    CliError::Usage(format!("--key: {}: {error}", path.display()))
}
