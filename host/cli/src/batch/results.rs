//! The file of results: written line by line, and gone on with after an interruption.

use std::collections::{BTreeMap, HashSet};
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Seek, Write};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::CliError;
use crate::output::write_whole_with;
use crate::standard::is_standard;
use foldpath::read::FileError;

/// A file of results, or stdout.
pub(super) struct Results {
    path: PathBuf,
    /// `None` for stdout.
    file: Option<File>,
    ids: HashSet<String>,
    known: usize,
}

/// The parts of a result that a run needs.
#[derive(Deserialize)]
pub(super) struct Head {
    pub(super) id: String,
    outcome: Option<String>,
    error: Option<IgnoredAny>,
}

impl Results {
    /// Creates the file, or with `resume` opens it and reads which designs have results. Bytes after the last whole
    /// line, which a run that was killed has left, are cut off. With `retry_errors`, results that are errors are removed.
    ///
    /// # Errors
    /// If the system reports one, or a line is no result.
    pub(super) fn open(path: &Path, resume: bool, retry_errors: bool) -> Result<Self, CliError> {
        let mut this = Self {
            path: path.to_path_buf(),
            file: None,
            ids: HashSet::new(),
            known: 0,
        };
        if is_standard(path) {
            return Ok(this);
        }
        let mut options = OpenOptions::new();
        let options = options
            .create(true)
            .read(resume)
            .append(resume)
            .write(true)
            .truncate(!resume);
        let mut file = options.open(path).map_err(FileError::io(path))?;
        if resume {
            let (whole, errors) = this.read(&file, retry_errors)?;
            file.set_len(whole).map_err(FileError::io(path))?;
            if !errors.is_empty() {
                write_whole_with(path, |out| copy_without(&file, &errors, out))?;
                file = options.open(path).map_err(FileError::io(path))?;
            }
        }
        this.known = this.ids.len();
        this.file = Some(file);
        Ok(this)
    }

    /// Reads the names of the results. Returns the number of bytes in whole lines, and with `retry_errors` the numbers of the
    /// lines that are errors, from 1, whose names are left out.
    fn read(&mut self, file: &File, retry_errors: bool) -> Result<(u64, HashSet<usize>), CliError> {
        let mut lines = BufReader::new(file);
        let (mut whole, mut bytes, mut errors) = (0, Vec::new(), HashSet::new());
        for number in 1.. {
            bytes.clear();
            let read = lines
                .read_until(b'\n', &mut bytes)
                .map_err(FileError::io(&self.path))?;
            if !bytes.ends_with(b"\n") {
                break;
            }
            let head: Head = serde_json::from_slice(&bytes).map_err(|_| FileError::Expected {
                path: self.path.clone(),
                place: format!("line {number}"),
                expected: "a result of batch, to go on after it".into(),
                found: format!(
                    "{:?}",
                    String::from_utf8_lossy(&bytes[..bytes.len().min(40)]).trim()
                ),
            })?;
            if retry_errors && head.error.is_some() {
                errors.insert(number);
            } else {
                self.ids.insert(head.id);
            }
            whole += read as u64;
        }
        Ok((whole, errors))
    }

    /// Takes the names of the results that were there.
    pub(super) fn take_ids(&mut self) -> HashSet<String> {
        core::mem::take(&mut self.ids)
    }

    /// Number of results that were there.
    pub(super) fn known(&self) -> usize {
        self.known
    }

    /// Writes a result. The system has it when this function returns, so that only a failure of the machine loses it.
    ///
    /// # Errors
    /// If the system reports one.
    pub(super) fn write(&mut self, result: &str) -> Result<(), CliError> {
        let line = format!("{result}\n");
        match &mut self.file {
            None => {
                let mut out = io::stdout().lock();
                out.write_all(line.as_bytes())
                    .and_then(|()| out.flush())
                    .map_err(CliError::Output)
            }
            Some(file) => Ok(file
                .write_all(line.as_bytes())
                .map_err(FileError::io(&self.path))?),
        }
    }
}

/// Copies a file but for the lines of these numbers, from 1.
fn copy_without(file: &File, left_out: &HashSet<usize>, out: &mut dyn Write) -> io::Result<()> {
    let mut file = file;
    file.rewind()?;
    for (number, line) in (1..).zip(BufReader::new(file).split(b'\n')) {
        let line = line?;
        if !left_out.contains(&number) {
            out.write_all(&line)?;
            out.write_all(b"\n")?;
        }
    }
    Ok(())
}

/// Number of results by outcome.
#[derive(Default)]
pub(super) struct Counts {
    of: BTreeMap<String, u64>,
}

impl Counts {
    /// Counts a result.
    pub(super) fn add(&mut self, result: &str) {
        let head = serde_json::from_str::<Head>(result);
        let outcome = head.ok().and_then(|head| head.outcome);
        *self
            .of
            .entry(outcome.unwrap_or_else(|| "error".into()))
            .or_default() += 1;
    }

    pub(super) fn total(&self) -> u64 {
        self.of.values().sum()
    }

    pub(super) fn by_outcome(&self) -> impl Iterator<Item = (&String, &u64)> {
        self.of.iter()
    }
}
