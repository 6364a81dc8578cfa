//! Writing files whole or not at all.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::FileError;

/// Bytes handed to the system at once.
const BUFFER: usize = 1 << 18;

/// Writes `content` to `path`, as [`write_whole_with`] does.
///
/// # Errors
/// If the system refuses.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), FileError> {
    write_whole_with(path, |out| out.write_all(content))
}

/// Writes what `content` says to `path`, which never holds a part of it: the file is written beside it
/// under another name and then renamed. What stands behind a link is replaced, not the link; a pipe or
/// a device is written to.
///
/// # Errors
/// If the system refuses, or `content` fails.
pub fn write_whole_with(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> Result<(), FileError> {
    let failed = |error: io::Error| FileError::Io {
        path: path.to_path_buf(),
        // The kind alone: the error itself names the temporary file.
        source: error.kind().into(),
    };
    let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    if std::fs::metadata(&target).is_ok_and(|found| !found.is_file()) {
        let write = || fill(&File::create(&target)?, content);
        return write().map_err(failed);
    }
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let write = || {
        let file = tempfile::Builder::new()
            .prefix(".foldpath-")
            .tempfile_in(folder)?;
        fill(file.as_file(), content)?;
        #[cfg(unix)]
        {
            // A temporary file is private to its owner; a result is as public as any other file.
            use std::os::unix::fs::PermissionsExt;
            let public = std::fs::Permissions::from_mode(0o644);
            file.as_file().set_permissions(public)?;
        }
        file.persist(&target)?;
        Ok(())
    };
    write().map_err(failed)
}

fn fill(
    file: &File,
    content: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(BUFFER, file);
    content(&mut out)?;
    out.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_that_fails_on_the_way_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sheet.fold");
        write_whole(&path, b"before").unwrap();
        let refused = write_whole_with(&path, |out| {
            out.write_all(&vec![b'x'; 2 * BUFFER])?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert!(matches!(refused, Err(FileError::Io { path: at, .. }) if at == path));
        assert_eq!(std::fs::read(&path).unwrap(), b"before");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
