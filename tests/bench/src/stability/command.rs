//! The `foldpath` command as a user runs it: as a program of its own.

use core::time::Duration;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

/// First word of the command's error messages.
const NAME: &str = "foldpath:";

/// Answer of the command.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// Exit status; `None` if the command was stopped.
    pub status: Option<i32>,
    /// The JSON object on stdout, if there is one.
    pub json: Option<serde_json::Value>,
    /// The error message on stderr.
    pub complaint: String,
    /// Notes on stderr.
    pub notes: Vec<String>,
}

impl Answer {
    /// Returns a number of the answer.
    #[must_use]
    pub fn number(&self, key: &str) -> Option<f64> {
        self.json.as_ref()?.get(key)?.as_f64()
    }

    /// Returns a text of the answer.
    #[must_use]
    pub fn text(&self, key: &str) -> Option<&str> {
        self.json.as_ref()?.get(key)?.as_str()
    }

    /// Returns outcome and reason, or the error message.
    #[must_use]
    pub fn told(&self) -> String {
        match (self.text("outcome"), self.text("reason")) {
            (Some(outcome), Some(reason)) => format!("{outcome}: {reason}"),
            (Some(outcome), None) => outcome.into(),
            _ if self.status.is_none() => "no answer in time".into(),
            _ => self.complaint.clone(),
        }
    }
}

/// Runs `program`, which is the command, in a folder, for at most `seconds`.
///
/// # Panics
/// If the program cannot be started.
#[must_use]
pub fn run(program: &Path, folder: &Path, arguments: &[&str], seconds: u64) -> Answer {
    let [out, err] = ["stdout", "stderr"].map(|name| folder.join(name));
    let file = |path: &Path| std::fs::File::create(path).expect("a file to write");
    let mut child = Command::new(program)
        .current_dir(folder)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(file(&out))
        .stderr(file(&err))
        .spawn()
        .expect("the command starts");
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child of ours") {
            break status.code();
        }
        if start.elapsed() > Duration::from_secs(seconds) {
            let _gone = child.kill();
            let _gone = child.wait();
            break None;
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let read = |path: &Path| std::fs::read(path).unwrap_or_default();
    let complaints = String::from_utf8_lossy(&read(&err)).into_owned();
    let wrong = |line: &&str| line.starts_with(NAME) || line.contains("panicked");
    let complaint = complaints.lines().find(wrong).unwrap_or_default();
    let notes = complaints
        .lines()
        .filter_map(|line| line.strip_prefix("note: "));
    Answer {
        status,
        json: serde_json::from_slice(&read(&out)).ok(),
        complaint: complaint.trim_start_matches(NAME).trim().into(),
        notes: notes.map(String::from).collect(),
    }
}
