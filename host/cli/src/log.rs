//! Writes the log of a session row by row, so that it holds all rows up to whatever ends the process.

use std::fs::File;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use crate::CliError;
use crate::output::failed;
use crate::standard::is_standard;

/// A file or stdout that gets rows, each as a whole.
pub(crate) struct Log {
    path: PathBuf,
    out: Out,
}

enum Out {
    /// A file, and the number of bytes of its whole rows.
    File(File, u64),
    Stdout,
    /// A reader has closed its end of a pipe, which is no error.
    Gone,
}

impl Log {
    /// Makes the file, or empties it.
    ///
    /// # Errors
    /// If the system refuses.
    pub(crate) fn create(path: &Path) -> Result<Self, CliError> {
        let out = if is_standard(path) {
            Out::Stdout
        } else {
            Out::File(File::create(path).map_err(|error| failed(path, &error))?, 0)
        };
        let path = path.to_path_buf();
        Ok(Self { path, out })
    }

    /// Writes a row, which ends with a line break. No part of a row stays that finds no room.
    ///
    /// # Errors
    /// If the system refuses.
    pub(crate) fn row(&mut self, row: &str) -> io::Result<()> {
        match &mut self.out {
            Out::File(file, whole) => {
                // Without a buffer of this process, so that the row is the system's when this returns.
                let written = file.write_all(row.as_bytes());
                if written.is_err() {
                    // A pipe or a device cannot be cut.
                    let _ = file.set_len(*whole);
                }
                *whole += row.len() as u64;
                written
            }
            Out::Stdout => {
                let mut out = io::stdout().lock();
                match out.write_all(row.as_bytes()).and_then(|()| out.flush()) {
                    Err(error) if error.kind() == ErrorKind::BrokenPipe => {
                        self.out = Out::Gone;
                        Ok(())
                    }
                    written => written,
                }
            }
            Out::Gone => Ok(()),
        }
    }

    /// Returns the error of a log that could not be written.
    pub(crate) fn failed(&self, error: io::Error) -> CliError {
        match self.out {
            Out::File(..) => failed(&self.path, &error).into(),
            Out::Stdout | Out::Gone => CliError::Output(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row that finds no room is cut off, so that a reader never meets half a row.
    #[test]
    #[cfg(target_os = "linux")]
    fn rows_are_there_at_once_and_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        let mut log = Log::create(&path).unwrap();
        for rows in 1..4 {
            log.row("1,Idle\n").unwrap();
            assert_eq!(
                std::fs::read_to_string(&path).unwrap(),
                "1,Idle\n".repeat(rows)
            );
        }
        let mut full = Log::create(Path::new("/dev/full")).unwrap();
        let error = full.row("1,Idle\n").unwrap_err();
        assert_eq!(
            full.failed(error).to_string(),
            "/dev/full: no storage space"
        );
    }
}
