//! Commands in a folder of their own, and what they answer.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// What a command answered.
#[derive(Debug, PartialEq)]
pub struct Answer {
    pub status: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Answer {
    /// The one JSON object that stdout holds.
    #[track_caller]
    pub fn json(&self) -> Value {
        let value = serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {self:?}"));
        assert!(matches!(value, Value::Object(_)), "{self:?}");
        value
    }

    /// Whether the error told is this, its line and column left out or not.
    pub fn tells(&self, message: &str) -> bool {
        self.told().iter().any(|told| told == message)
    }

    /// Whether the error told begins like this, its line and column left out or not.
    pub fn begins(&self, message: &str) -> bool {
        self.told().iter().any(|told| told.starts_with(message))
    }

    /// The error told, without the line of the file and the hint: as it is, and without line and column.
    fn told(&self) -> [String; 2] {
        let first = self.stderr.lines().next().unwrap_or_default();
        let told = first.strip_prefix("foldpath: ").unwrap_or_default();
        let parts: Vec<&str> = told.splitn(4, ':').collect();
        let placeless = match parts[..] {
            [file, line, column, rest]
                if [line, column].iter().all(|n| n.parse::<u32>().is_ok()) =>
            {
                format!("{file}:{rest}")
            }
            _ => told.into(),
        };
        [told.into(), placeless]
    }

    /// The same answer, which must have this status.
    #[track_caller]
    pub fn with_status(self, status: i32) -> Self {
        assert_eq!(self.status, Some(status), "{self:?}");
        self
    }
}

/// An empty folder in which commands run.
pub struct Folder {
    folder: TempDir,
    program: PathBuf,
}

impl Folder {
    /// A folder in which `program` runs: `env!("CARGO_BIN_EXE_foldpath")`.
    pub fn of(program: &str) -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
            program: program.into(),
        }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    pub fn read_json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Names of all files, in order.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name();
        let names = entries.map(|entry| name(entry).into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    /// The command, not yet started, with arguments separated by blanks.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(&self.program);
        command.args(arguments.split_whitespace());
        command.current_dir(self.folder.path()).stdin(Stdio::null());
        command
    }

    /// Runs the command to its end.
    pub fn run(&self, arguments: &str) -> Answer {
        let output = self.command(arguments).output().unwrap();
        Answer {
            status: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs a command that must succeed.
    #[track_caller]
    pub fn done(&self, arguments: &str) -> Answer {
        self.run(arguments).with_status(0)
    }
}
