//! Files of keys, and numbers that are used once.

use std::fs;
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;

use foldpath_core::wire::key::Key;

use crate::standard::is_standard;
use crate::{CliError, say};

/// Largest number of bytes that are read; a key has 32 digits.
const MAX_BYTES: u64 = 1024;

/// Returns a random number of the operating system.
///
/// # Errors
/// If the operating system has none.
pub(crate) fn nonce() -> io::Result<u64> {
    getrandom::u64().map_err(io::Error::other)
}

/// Reads the key in a file, or from stdin: 32 hexadecimal digits and white space.
///
/// # Errors
/// If the file cannot be read or holds something else.
pub(crate) fn read(path: &Path, quiet: bool) -> Result<Key, CliError> {
    if is_standard(path) {
        return parse(path, limited(io::stdin().lock()));
    }
    let key = parse(path, stored(path))?;
    if !quiet {
        warn(path);
    }
    Ok(key)
}

/// Reads the bytes of a file.
fn stored(path: &Path) -> io::Result<Vec<u8>> {
    limited(fs::File::open(path)?)
}

/// Says so if others can read the file of a key.
fn warn(path: &Path) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let data = fs::metadata(path);
        if data.is_ok_and(|data| data.is_file() && data.permissions().mode() & 0o044 != 0) {
            say(&format!(
                "note: --key: others can read {}; whoever has the key moves the sheet",
                path.display()
            ));
        }
    }
    #[cfg(not(unix))]
    let _ = path;
}

fn limited(from: impl Read) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(MAX_BYTES).read_to_end(&mut bytes)?;
    Ok(bytes)
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
    match stored(path) {
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
        Ok(0) if digits => {
            let path = path.display();
            let text = format!("--key: {path}: expected a key that is not 0");
            Err(CliError::Usage(text))
        }
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
    // Otherwise a loss of power may take the name of the file.
    #[cfg(unix)]
    fs::File::open(folder)?.sync_all()?;
    Ok(Key::new(bytes))
}

fn unusable(path: &Path, error: &io::Error) -> CliError {
    CliError::Usage(format!("--key: {}: {error}", path.display()))
}
