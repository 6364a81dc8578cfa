//! Runs the `foldpath` command in a folder of its own.
#![allow(dead_code, reason = "each test file uses its part")]

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// The patterns of the repository.
pub(crate) const PATTERNS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../patterns");

/// What a command answered.
#[derive(Debug, PartialEq)]
pub(crate) struct Answer {
    pub(crate) status: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Answer {
    /// The one JSON object that stdout holds.
    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        let value = serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {self:?}"));
        assert!(matches!(value, Value::Object(_)), "{self:?}");
        value
    }

    /// Whether the error told is this, its line and column left out or not.
    pub(crate) fn tells(&self, message: &str) -> bool {
        self.told().iter().any(|told| told == message)
    }

    /// Whether the error told begins like this, its line and column left out or not.
    pub(crate) fn begins(&self, message: &str) -> bool {
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
    pub(crate) fn with_status(self, status: i32) -> Self {
        assert_eq!(self.status, Some(status), "{self:?}");
        self
    }
}

/// An empty folder in which commands run.
pub(crate) struct Folder(TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// A folder with `miura.fold`, 3x3, and the path `path.fold` planned for it.
    pub(crate) fn with_path() -> Self {
        let folder = Self::new();
        folder.done("generate miura --rows 3 --cols 3 -o miura.fold");
        folder.done("plan miura.fold -o path.fold");
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    pub(crate) fn read_json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Names of all files, in order.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name();
        let names = entries.map(|entry| name(entry).into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    /// The command, not yet started, with arguments separated by blanks.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_foldpath"));
        command.args(arguments.split_whitespace());
        command.current_dir(self.0.path()).stdin(Stdio::null());
        command
    }

    /// Runs the command to its end.
    pub(crate) fn run(&self, arguments: &str) -> Answer {
        let output = self.command(arguments).output().unwrap();
        Answer {
            status: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs a command that must succeed.
    #[track_caller]
    pub(crate) fn done(&self, arguments: &str) -> Answer {
        self.run(arguments).with_status(0)
    }
}

/// The 3x3 Miura fold of `foldpath generate`, with its faces written out.
pub(crate) fn pattern() -> Value {
    let folder = Folder::with_path();
    let mut pattern = folder.read_json("miura.fold");
    pattern["faces_vertices"] = folder.read_json("path.fold")["faces_vertices"].take();
    pattern
}

/// The numbers of a JSON list, in which nothing else may be.
#[track_caller]
pub(crate) fn numbers(list: &Value) -> Vec<f64> {
    let entries = list.as_array().unwrap().iter();
    entries.map(|entry| entry.as_f64().unwrap()).collect()
}

/// The document with some places changed. An edit is `/pointer = value`, several have `; ` between;
/// without a value the place is removed, and one past the end of a list adds to it.
#[track_caller]
pub(crate) fn edited(document: &Value, edits: &str) -> Value {
    let mut document = document.clone();
    for edit in edits.split("; ") {
        let (pointer, text) = edit.split_once(" =").unwrap();
        let text = text.trim();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        let value = (!text.is_empty()).then(|| serde_json::from_str(text).unwrap());
        match (document.pointer_mut(parent), value) {
            (Some(Value::Object(map)), Some(value)) => drop(map.insert(key.into(), value)),
            (Some(Value::Object(map)), None) => drop(map.remove(key).unwrap()),
            (Some(Value::Array(list)), Some(value)) => {
                let index: usize = key.parse().unwrap();
                list.splice(index..list.len().min(index + 1), [value]);
            }
            (place, _) => panic!("{pointer}: {place:?}"),
        }
    }
    document
}
