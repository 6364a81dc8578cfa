//! Writes files whole or not at all: under a temporary name first, and then renamed. The content for stdout is written
//! once it is complete.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use foldpath::read::FileError;
use tempfile::TempPath;

use crate::standard::is_standard;
use crate::{CliError, print_to};

/// Size of the buffer for writing, bytes.
const BUFFER_BYTES: usize = 1 << 18;

/// Writes `content` to `path`, so that `path` never holds a part of it; `-` stands for stdout.
///
/// # Errors
/// If the system refuses.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), CliError> {
    write_whole_with(path, |out| out.write_all(content))
}

/// Writes the output of `content` to `path`, so that `path` never holds a part of it. The file is written in the same
/// folder under another name and then renamed. If `path` is a symbolic link, its target is replaced and the link stays.
/// A pipe or a device is written to directly, and `-` stands for stdout.
///
/// # Errors
/// If the system refuses, or `content` fails.
pub(crate) fn write_whole_with(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), CliError> {
    if is_standard(path) {
        let mut bytes = Vec::new();
        content(&mut bytes).map_err(CliError::Output)?;
        return print_to(io::stdout().lock(), &bytes);
    }
    let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    if std::fs::metadata(&target).is_ok_and(|found| !found.is_file()) {
        let write = || fill(&File::create(&target)?, content);
        return Ok(write().map_err(|error| failed(path, &error))?);
    }
    let write = || Ok(beside(&target, content)?.persist(&target)?);
    Ok(write().map_err(|error| failed(path, &error))?)
}

/// Several files that are written, each whole. None is put in its place before all have been written.
#[derive(Default)]
pub(crate) struct Pending(Vec<(TempPath, PathBuf)>);

impl Pending {
    /// Writes a file under another name.
    ///
    /// # Errors
    /// If the system refuses, or `content` fails.
    pub(crate) fn add(
        &mut self,
        path: PathBuf,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), FileError> {
        let file = beside(&path, content).map_err(|error| failed(&path, &error))?;
        self.0.push((file, path));
        Ok(())
    }

    /// Returns the names that the files will have.
    pub(crate) fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        self.0.iter().map(|(_, path)| path)
    }

    /// Puts the files in their places.
    ///
    /// # Errors
    /// If the system refuses.
    pub(crate) fn persist(self) -> Result<(), FileError> {
        for (file, path) in self.0 {
            let placed = file.persist(&path);
            placed.map_err(|error| failed(&path, &error.error))?;
        }
        Ok(())
    }
}

/// Returns the error of a file that the system refuses to write.
pub(crate) fn failed(path: &Path, error: &io::Error) -> FileError {
    FileError::Io {
        path: path.to_path_buf(),
        // Only the kind is kept, because the error itself names the temporary file.
        source: error.kind().into(),
    }
}

/// Writes a file with this content in the folder of `target`, under another name. The file is removed when the returned
/// path is dropped.
fn beside(
    target: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<TempPath> {
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let file = tempfile::Builder::new()
        .prefix(".foldpath-")
        .tempfile_in(folder)?;
    fill(file.as_file(), content)?;
    #[cfg(unix)]
    {
        // A temporary file is private to its owner, but a result is as readable as any other file.
        use std::os::unix::fs::PermissionsExt;
        let public = std::fs::Permissions::from_mode(0o644);
        file.as_file().set_permissions(public)?;
    }
    Ok(file.into_temp_path())
}

fn fill(file: &File, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(BUFFER_BYTES, file);
    content(&mut out)?;
    out.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_several_files_all_are_written_or_none() {
        let folder = tempfile::tempdir().unwrap();
        let [first, missing] = ["a.obj", "none/b.obj"].map(|name| folder.path().join(name));
        let write = |second: &Path| {
            let mut pending = Pending::default();
            for path in [&*first, second] {
                pending.add(path.into(), |out| out.write_all(b"a"))?;
            }
            pending.persist()
        };
        let refused = write(&missing).unwrap_err().to_string();
        let expected = format!("{}: entity not found", missing.display());
        assert_eq!(refused, expected);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        write(&folder.path().join("b.obj")).unwrap();
        assert_eq!(std::fs::read(&first).unwrap(), b"a");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn content_that_fails_on_the_way_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sheet.fold");
        write_whole(&path, b"before").unwrap();
        let refused = write_whole_with(&path, |out| {
            out.write_all(&vec![b'x'; 2 * BUFFER_BYTES])?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert!(
            matches!(refused, Err(CliError::File(FileError::Io { path: at, .. })) if at == path)
        );
        assert_eq!(std::fs::read(&path).unwrap(), b"before");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
