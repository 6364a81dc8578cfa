//! A line of designs, and the plan that it asks for.

use std::collections::HashSet;
use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::{Map, Value};

use crate::CliError;
use crate::plan::Job;
use crate::standard::{Input, is_standard};
use crate::values::Shard;
use foldpath::request::{PlanRequest, Request};

/// Longest line that is read, bytes. A pattern that stands in it has some 100 bytes an edge.
const MAX_LINE_BYTES: u64 = 1 << 26;

/// A line that some worker has to plan.
pub(super) struct Task {
    /// Position among the lines of this run, from 0, in which results are written.
    pub(super) place: u64,
    /// Name of the result.
    pub(super) id: String,
    /// The line, or the reason why it is no design.
    pub(super) line: Result<String, String>,
    /// The design as it was given, if the line has one.
    pub(super) design: Option<Map<String, Value>>,
    /// Time that the design may take, seconds, if the line names one.
    pub(super) timeout: Option<f64>,
}

/// The lines of a file that belong to this run.
pub(super) struct Designs<R> {
    lines: R,
    shard: Option<Shard>,
    /// Results that are there already.
    done: HashSet<String>,
    /// Hashes of the names that were read.
    seen: HashSet<u128>,
    /// Hashes of the files that are written, and of that of the designs.
    taken: HashSet<u128>,
    /// Number of the last line that was read, from 1.
    number: u64,
    place: u64,
}

/// The parts of a line that the pool needs.
#[derive(Deserialize)]
struct Head {
    id: String,
    #[serde(default)]
    plan: Value,
    #[serde(default)]
    path: Value,
}

impl Head {
    /// Returns the time that the design may take, seconds, if it is a number or the text of one.
    fn timeout(&self) -> Option<f64> {
        let value = self.plan.get("timeout")?;
        // A list stands for an option that is repeated.
        match value
            .as_array()
            .and_then(|list| list.last())
            .unwrap_or(value)
        {
            Value::String(text) => text.parse().ok(),
            value => value.as_f64(),
        }
    }
}

impl<R: BufRead> Designs<R> {
    /// Goes through lines of designs, but for those that are `done`. No design may write to the files that are `taken`.
    pub(super) fn new(
        lines: R,
        shard: Option<Shard>,
        done: HashSet<String>,
        taken: [&Path; 2],
    ) -> Self {
        Self {
            taken: taken.into_iter().map(hash_of_path).collect(),
            lines,
            shard,
            done,
            seen: HashSet::new(),
            number: 0,
            place: 0,
        }
    }

    /// Reads the next line of this shard that has no result yet.
    ///
    /// # Errors
    /// If the system reports one.
    pub(super) fn next_task(&mut self) -> io::Result<Option<Task>> {
        loop {
            let Some(line) = next_line(&mut self.lines)? else {
                return Ok(None);
            };
            self.number += 1;
            if line.as_ref().is_ok_and(|line| line.trim().is_empty()) {
                continue;
            }
            let number = self.number;
            let design = line.as_deref().map_or(None, given);
            let head = line.as_ref().map_err(Clone::clone).and_then(|line| {
                let head = serde_json::from_str::<Head>(line);
                head.map_err(|error| in_line(&error))
            });
            let (mut id, mut line, mut timeout) = match (head, line) {
                (Ok(head), line) => {
                    let timeout = head.timeout();
                    // Every shard sees which files are taken, as it reads all lines.
                    let is_taken = (head.path.as_str())
                        .is_some_and(|path| !self.taken.insert(hash_of_path(Path::new(path))));
                    let line = if is_taken {
                        Err(
                            "path: expected a file that nothing else of the run writes or reads"
                                .into(),
                        )
                    } else {
                        line
                    };
                    (head.id, line, timeout)
                }
                (Err(error), _) => (format!("line {number}"), Err(error), None),
            };
            // Lines of the same name belong to the same shard, so that each shard sees which names are taken.
            let hash = hash(&id);
            if self
                .shard
                .is_some_and(|shard| hash % u128::from(shard.of) != u128::from(shard.index))
            {
                continue;
            }
            if !self.seen.insert(hash) {
                line = Err(format!(
                    "expected an id that no line before has, found {id:?}"
                ));
                id = format!("line {number}");
                timeout = None;
            }
            if self.done.contains(&id) {
                continue;
            }
            self.place += 1;
            return Ok(Some(Task {
                place: self.place - 1,
                id,
                line,
                design,
                timeout,
            }));
        }
    }
}

/// Reads a line without its end; `None` at the end of the file. A line that is too long, or not in UTF-8, is an inner
/// error.
fn next_line(lines: &mut impl BufRead) -> io::Result<Option<Result<String, String>>> {
    let mut bytes = Vec::new();
    let read = lines
        .by_ref()
        .take(MAX_LINE_BYTES)
        .read_until(b'\n', &mut bytes)?;
    if read == 0 {
        return Ok(None);
    }
    if read as u64 == MAX_LINE_BYTES && !bytes.ends_with(b"\n") {
        lines.skip_until(b'\n')?;
        return Ok(Some(Err(format!(
            "expected a line of at most {} MiB, found more",
            MAX_LINE_BYTES >> 20
        ))));
    }
    while bytes.ends_with(b"\n") || bytes.ends_with(b"\r") {
        bytes.pop();
    }
    Ok(Some(String::from_utf8(bytes).map_err(|_| {
        "expected text in UTF-8, found other bytes".into()
    })))
}

/// Returns 128 bits of the digest of a name, which no other name among billions has.
fn hash(id: &str) -> u128 {
    let digest = hmac_sha256::Hash::hash(id.as_bytes());
    u128::from_be_bytes(digest.first_chunk().copied().unwrap_or_default())
}

/// Returns a hash of the absolute path of a file.
fn hash_of_path(path: &Path) -> u128 {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    hash(&path.to_string_lossy())
}

/// Returns `true` for devices, such as the process's own stdin and stdout, which have its designs and results.
fn is_device(path: &Path) -> bool {
    path.starts_with("/dev") || path.starts_with("/proc")
}

/// A design: a crease pattern and how to plan it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Design {
    pub(super) id: String,
    pattern: Option<Value>,
    generate: Option<Map<String, Value>>,
    #[serde(default)]
    plan: Option<Map<String, Value>>,
    /// File to write the path to.
    path: Option<PathBuf>,
}

/// Options that say where the answer goes or who works on it, which a design does not choose.
const NOT_CHOSEN: [&str; 6] = ["output", "json", "quiet", "jobs", "help", "version"];

impl Design {
    /// Parses a line.
    ///
    /// # Errors
    /// If the line is no design.
    pub(super) fn parse(line: &str) -> Result<Self, CliError> {
        serde_json::from_str(line).map_err(|error| CliError::Usage(in_line(&error)))
    }

    /// Returns the input and what is to be planned for this design. `timeout` (seconds) holds for designs that name none.
    ///
    /// # Errors
    /// If the design has not one pattern, or its options are none of `plan`.
    pub(super) fn job(&self, timeout: f64) -> Result<(Input, Job), CliError> {
        let usage = |text: String| CliError::Usage(text);
        let input = match (&self.pattern, &self.generate) {
            (Some(Value::String(file)), None) => Input::of_file(Path::new(file)),
            (Some(pattern @ Value::Object(_)), None) => {
                let name = format!("pattern of {}", self.id);
                Input::of_stream(&name, pattern.to_string().as_bytes())?
            }
            (Some(_), None) => {
                let text = "pattern: expected the name of a file, or an object in the form of FOLD";
                return Err(usage(text.into()));
            }
            (None, Some(family)) => Input::of_family(family)?,
            _ => return Err(usage("expected either pattern or generate".into())),
        };
        let request = self.request(timeout)?;
        let files = [Some(&input.name), self.path.as_ref()];
        for file in files.into_iter().flatten().chain(request.goal_files()) {
            if is_standard(file) {
                return Err(usage(
                    "expected a file, found -: batch has no standard streams for its designs"
                        .into(),
                ));
            }
            if is_device(file) {
                let found = file.display();
                return Err(usage(format!("expected a file, found the device {found}")));
            }
        }
        let job = Job {
            request,
            pattern: input.name.clone(),
            output: self.path.clone(),
            json: true,
        };
        Ok((input, job))
    }

    /// Returns the options of planning.
    fn request(&self, timeout: f64) -> Result<PlanRequest, CliError> {
        let mut request = PlanRequest::default();
        for (name, value) in self.plan.iter().flatten() {
            if NOT_CHOSEN.contains(&name.as_str()) {
                return Err(CliError::Usage(format!(
                    "plan: {name}: expected an option of planning"
                )));
            }
            request.set(name, value)?;
        }
        if request.keep && self.path.is_none() {
            return Err(CliError::Usage(
                "--keep: expected with a path to write, as with --output".into(),
            ));
        }
        request.check.timeout.get_or_insert(timeout);
        Ok(request)
    }
}

/// Returns the design of a line as it was given, without its id; `None` if the line is no object.
pub(super) fn given(line: &str) -> Option<Map<String, Value>> {
    let mut design: Map<String, Value> = serde_json::from_str(line).ok()?;
    design.remove("id");
    Some(design)
}

/// Returns the name in a line that is no design otherwise.
pub(super) fn id_of(line: &str) -> String {
    serde_json::from_str::<Head>(line).map_or_else(|_| String::new(), |head| head.id)
}

/// Returns the message of an error in a text of one line.
pub(super) fn in_line(error: &serde_json::Error) -> String {
    error
        .to_string()
        .replace(" at line 1 column ", " at column ")
}
