//! Reads names of joints, one a line, for the hinges in the order of their edges. Empty lines and text after a `#` are skipped.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::FileError;

/// Names of the joints of a robot, one for each hinge, with the lines of the file in which they stand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JointNames {
    file: PathBuf,
    names: Vec<(usize, String)>,
}

impl JointNames {
    /// Parses names; `file` names it in errors.
    ///
    /// # Errors
    /// If a line has something other than one name of letters, digits and `_ - . /`, or a name stands in two lines.
    pub fn parse(file: &Path, text: &str) -> Result<Self, FileError> {
        let mut names = Vec::new();
        let mut lines = BTreeMap::new();
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.is_empty() {
                continue;
            }
            let place = format!("line {number}");
            let is_known = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
            if !line.chars().all(is_known) {
                let expected = "a name of letters, digits and _ - . /";
                return Err(FileError::expected(file, place, expected, line));
            }
            if let Some(first) = lines.insert(line, number) {
                let found = format!("{line}, as in line {first}");
                return Err(FileError::expected(file, place, "another name", found));
            }
            names.push((number, line.to_string()));
        }
        let file = file.to_path_buf();
        Ok(Self { file, names })
    }

    /// Returns the names of this number of hinges.
    ///
    /// # Errors
    /// If there are more or fewer names.
    pub fn of_hinges(&self, hinges: usize) -> Result<impl Iterator<Item = &str>, FileError> {
        let expected = format!("{hinges} names, one for each hinge");
        if let Some((line, name)) = self.names.get(hinges) {
            let place = format!("line {line}");
            let found = format!("one more, {name}");
            return Err(FileError::expected(&self.file, place, expected, found));
        }
        let found = self.names.len();
        if found < hinges {
            let found = found.to_string();
            return Err(FileError::expected(&self.file, "the file", expected, found));
        }
        Ok(self.names.iter().map(|(_, name)| name.as_str()))
    }
}
