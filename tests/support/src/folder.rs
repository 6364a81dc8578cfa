//! Commands in a folder of their own, and their answers.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// The answer of a command that has ended.
#[derive(Debug, PartialEq)]
pub struct Answer {
    /// The exit status; a signal that ends the command leaves none.
    pub status: Option<i32>,
    /// Everything written to stdout.
    pub stdout: String,
    /// Everything written to stderr.
    pub stderr: String,
}

impl Answer {
    /// Reads the one JSON object that stdout holds.
    ///
    /// # Panics
    /// If stdout holds anything else.
    #[must_use]
    #[track_caller]
    pub fn json(&self) -> Value {
        let value = serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {self:?}"));
        assert!(matches!(value, Value::Object(_)), "{self:?}");
        value
    }

    /// Returns `true` if the error told is `message`, with or without its line and column.
    #[must_use]
    pub fn tells(&self, message: &str) -> bool {
        self.told().iter().any(|told| told == message)
    }

    /// Returns `true` if the error told begins with `message`, with or without its line and column.
    #[must_use]
    pub fn begins(&self, message: &str) -> bool {
        self.told().iter().any(|told| told.starts_with(message))
    }

    /// Returns the error told, without the line of the file and the hint: first in full, then without line and column.
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

    /// Returns this answer, which must have the given status.
    ///
    /// # Panics
    /// If the status is another.
    #[track_caller]
    pub fn with_status(self, status: i32) -> Self {
        assert_eq!(self.status, Some(status), "{self:?}");
        self
    }
}

/// A temporary folder, empty at first, in which one program runs. It is removed with its files when it is dropped.
pub struct Folder {
    folder: TempDir,
    program: PathBuf,
}

impl Folder {
    /// Creates a folder in which `program` runs, such as `env!("CARGO_BIN_EXE_foldpath")`.
    ///
    /// # Panics
    /// If the folder cannot be created.
    #[must_use]
    pub fn of(program: &str) -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
            program: program.into(),
        }
    }

    /// Returns the path of a file in the folder, which need not exist.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Reads a text file.
    ///
    /// # Panics
    /// If there is no such file, or if it is not text.
    #[must_use]
    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// Reads a JSON document.
    ///
    /// # Panics
    /// If there is no such file, or if it is not JSON.
    #[must_use]
    pub fn read_json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    /// Writes a text file, replacing any file of this name.
    ///
    /// # Panics
    /// If the file cannot be written.
    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Returns the names of all files, sorted.
    ///
    /// # Panics
    /// If the folder cannot be read, or if a name is not text.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name();
        let names = entries.map(|entry| name(entry).into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    /// Returns the command with arguments separated by blanks, not yet started. Its stdin is empty.
    #[must_use]
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(&self.program);
        command.args(arguments.split_whitespace());
        command.current_dir(self.folder.path()).stdin(Stdio::null());
        command
    }

    /// Runs the command with arguments separated by blanks and waits for its end.
    ///
    /// # Panics
    /// If the command cannot be started, or if its output is not text.
    pub fn run(&self, arguments: &str) -> Answer {
        let output = self.command(arguments).output().unwrap();
        Answer {
            status: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs the command as [`run`](Self::run) does, with these bytes on its stdin.
    ///
    /// # Panics
    /// If the command cannot be started, or if its output is not text.
    pub fn run_with(&self, arguments: &str, stdin: &[u8]) -> Answer {
        let mut command = self.command(arguments);
        command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut pipe = child.stdin.take().unwrap();
        let output = std::thread::scope(|scope| {
            // A command that refuses its arguments does not read.
            scope.spawn(move || drop(pipe.write_all(stdin)));
            child.wait_with_output().unwrap()
        });
        Answer {
            status: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs a command that must succeed.
    ///
    /// # Panics
    /// As [`run`](Self::run) does, and if the exit status is not 0.
    #[track_caller]
    pub fn done(&self, arguments: &str) -> Answer {
        self.run(arguments).with_status(0)
    }
}
