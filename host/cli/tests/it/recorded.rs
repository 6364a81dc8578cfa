//! Compares the answers of the command with recorded ones: a guard for changes that must change no answer.
//!
//! Each line of `tests/recorded/answers.tsv` names a file or a folder and a command. It has the exit status, the verdict
//! and the figures of the answer, and a hash of everything that the command writes: its stdout and stderr without times,
//! and the bytes of the files that it makes. The hash is compared on x86-64 Linux. The mathematical functions of other
//! systems may round differently, so that there the verdicts are compared, and the figures to 1e-9.
//!
//! `FOLDPATH_RECORD=1` writes the list anew. `FOLDPATH_ANSWERS=FOLDER` writes the answers themselves as files, so that `diff
//! -r` shows what has changed between two versions:
//!
//! ```text
//! FOLDPATH_ANSWERS=/tmp/answers cargo nextest run --release -p foldpath-cli recorded
//! ```

use core::fmt::Write as _;
use core::sync::atomic::{AtomicUsize, Ordering};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use foldpath_test_support::{Answer, Folder};
use serde_json::Value;

use crate::common::{PATTERNS, folder};

/// Folder of the list, and of files that only these commands read.
const RECORDED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/recorded");

/// Options of `plan` for every pattern, with a name that the path's file gets. Commands on paths use the first.
const PLANS: [&str; 10] = [
    "",
    "--symmetry off",
    "--bound 1e-3",
    "--bound 1e-1",
    "--fold 0.5",
    "--interpolation linear --fold 0.3",
    "--interpolation hermite",
    "--interpolation half-angle",
    "--interpolation homogeneous",
    "--seed 7",
];

/// Patterns and options that are left out, because together they would take longer than all others. The `.fold` file has
/// most of those of the same drawing as `.svg`.
const SLOW: [(&str, &str); 8] = [
    ("quad-24x24.fold", "--bound 1e-1"),
    ("quad-24x24.svg", "--bound 1e-1"),
    ("quad-24x24.svg", "--symmetry off"),
    ("quad-24x24.svg", "--interpolation linear --fold 0.3"),
    ("quad-24x24.svg", "--interpolation hermite"),
    ("quad-24x24.svg", "--interpolation half-angle"),
    ("quad-24x24.svg", "--interpolation homogeneous"),
    ("quad-24x24.svg", "--seed 7"),
];

/// Commands on the path of every pattern.
const ON_PATHS: [&str; 10] = [
    "check path0.fold --json",
    "export path0.fold --to csv -o out.csv",
    "export path0.fold --to traj -o out",
    "export path0.fold --to glb -o out",
    "export path0.fold --to rust -o out",
    "export path0.fold --to svg -o out",
    "plot path0.fold -o out.svg",
    "view path0.fold -o out.html",
    "check path0.fold --bound 1e-6 --json",
    "unfold path0.fold -o unfolded.fold --json",
];

/// Largest difference of a figure on another system, relative to the figure if that is above 1. Smaller figures count as 0.
const SAME: f64 = 1e-9;

/// `true` where the bytes of answers are compared.
const COMPARES_BYTES: bool = cfg!(all(target_arch = "x86_64", target_os = "linux"));

/// An answer as the list has it.
#[derive(Clone, Debug, PartialEq)]
struct Record {
    hash: u64,
    /// Exit status; `None` after a signal.
    status: Option<i32>,
    /// The value of `outcome` or `verdict`; empty if the answer has none.
    verdict: String,
    /// The numbers of the answer, by their keys, that are not next to 0.
    figures: BTreeMap<String, f64>,
}

/// The answers by their commands.
type Answers = BTreeMap<String, Record>;

#[test]
fn answers_are_the_recorded_ones() {
    let list = Path::new(RECORDED).join("answers.tsv");
    let jobs = jobs();
    let next = AtomicUsize::new(0);
    let found = Mutex::new(Answers::new());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let answers = job.run();
                    found.lock().unwrap().extend(answers);
                }
            });
        }
    });
    let found = found.into_inner().unwrap();
    if std::env::var_os("FOLDPATH_RECORD").is_some() {
        fs::write(list, text(&found)).unwrap();
        return;
    }
    let recorded = parsed(&fs::read_to_string(list).unwrap());
    assert!(recorded.len() > 1000, "{} answers", recorded.len());
    let different = differences(&recorded, &found, COMPARES_BYTES);
    assert!(different.is_empty(), "other answers: {different:#?}");
}

/// Commands that run in one folder, one after the other.
enum Job {
    /// The commands that every pattern gets.
    Pattern(PathBuf),
    /// A paragraph of `commands.txt`, with its number.
    Paragraph(usize, Vec<String>),
}

/// Returns the jobs: the patterns of the repository, then the paragraphs of `commands.txt`.
fn jobs() -> Vec<Job> {
    let commands = fs::read_to_string(Path::new(RECORDED).join("commands.txt")).unwrap();
    let paragraphs = commands.split("\n\n").map(|paragraph| {
        let lines = paragraph.lines().filter(|line| !line.starts_with('#'));
        lines.map(String::from).collect::<Vec<_>>()
    });
    let paragraphs = paragraphs.filter(|commands| !commands.is_empty());
    let paragraphs = paragraphs
        .enumerate()
        .map(|(number, commands)| Job::Paragraph(number + 1, commands));
    let patterns = patterns(Path::new(PATTERNS)).into_iter().map(Job::Pattern);
    patterns.chain(paragraphs).collect()
}

/// Returns the crease patterns in a folder and the folders in it, sorted.
fn patterns(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let ending = path.extension().unwrap_or_default();
        if path.is_dir() {
            found.extend(patterns(&path));
        } else if ["fold", "svg"].iter().any(|known| ending == *known) {
            found.push(path);
        }
    }
    found.sort();
    found
}

impl Job {
    /// Runs the commands and returns their answers.
    fn run(&self) -> Answers {
        let folder = folder();
        let mut answers = Answers::new();
        let mut run = |place: &str, command: &str| {
            let answer = folder.run(command);
            let written = written(&folder, command);
            let record = Record::of(&answer, &written);
            let name = format!("{place}: {command}");
            dump(&name, &answer, &written);
            answers.insert(name, record);
        };
        match self {
            Self::Pattern(file) => {
                let name = &*file.file_name().unwrap().to_string_lossy();
                fs::copy(file, folder.path(name)).unwrap();
                run(name, &format!("info {name} --json"));
                run(name, &format!("info {name}"));
                for (number, options) in PLANS.iter().enumerate() {
                    if SLOW.contains(&(name, options)) {
                        continue;
                    }
                    let output = format!("--json -o path{number}.fold");
                    run(name, &format!("plan {name} {options} {output}"));
                }
                for number in 0..PLANS.len() {
                    let path = format!("path{number}.fold");
                    if !folder.path(&path).exists() {
                        continue;
                    }
                    run(name, &format!("check {path} --json"));
                    spoil(&folder, &path);
                    run(name, &format!("check spoilt-{path} --json"));
                }
                if folder.path("path0.fold").exists() {
                    for command in ON_PATHS {
                        run(name, command);
                    }
                }
            }
            Self::Paragraph(number, commands) => {
                for source in [RECORDED, PATTERNS] {
                    for entry in fs::read_dir(source).unwrap() {
                        let file = entry.unwrap().path();
                        if file.is_file() {
                            let name = file.file_name().unwrap().to_string_lossy().into_owned();
                            fs::copy(&file, folder.path(&name)).unwrap();
                        }
                    }
                }
                for command in commands {
                    run(&format!("paragraph {number}"), command);
                }
            }
        }
        answers
    }
}

/// Writes the path once more with the fold angles of its middle knot turned by a hundredth, and its last positions of
/// vertices exchanged.
fn spoil(folder: &Folder, path: &str) {
    let mut value = folder.read_json(path);
    let frames = value["file_frames"].as_array_mut().unwrap();
    let middle = frames.len() / 2;
    if let Some(angles) = frames[middle]["edges_foldAngle"].as_array_mut() {
        for angle in angles.iter_mut().step_by(3) {
            *angle = Value::from(angle.as_f64().unwrap_or(0.0) * 0.99);
        }
    }
    if let Some(vertices) = frames.last_mut().unwrap()["vertices_coords"].as_array_mut() {
        let last = vertices.len() - 1;
        vertices.swap(0, last);
    }
    folder.write(&format!("spoilt-{path}"), &value.to_string());
}

/// Returns the files at the places where a command writes, sorted by name: what follows `-o`, `--log` and `--map`.
fn written(folder: &Folder, command: &str) -> Vec<(String, Vec<u8>)> {
    let words: Vec<&str> = command.split(' ').collect();
    let outputs = words
        .windows(2)
        .filter(|pair| ["-o", "--log", "--map"].contains(&pair[0]));
    let mut files = Vec::new();
    for name in outputs.map(|pair| pair[1]) {
        let path = folder.path(name);
        if path.is_dir() {
            files.extend(
                fs::read_dir(&path)
                    .unwrap()
                    .map(|entry| entry.unwrap().path()),
            );
        } else {
            files.push(path);
        }
    }
    files.sort();
    let content = |file: PathBuf| {
        let name = file.file_name()?.to_string_lossy().into_owned();
        Some((name, fs::read(&file).ok()?))
    };
    files.into_iter().filter_map(content).collect()
}

impl Record {
    fn of(answer: &Answer, written: &[(String, Vec<u8>)]) -> Self {
        let mut bytes = told(answer).into_bytes();
        for (_, content) in written {
            bytes.extend(content);
        }
        let value: Value = serde_json::from_str(&answer.stdout).unwrap_or_default();
        let verdict = ["outcome", "verdict"]
            .iter()
            .find_map(|key| value[key].as_str());
        let figures = value.as_object().into_iter().flatten();
        let figures = figures.filter_map(|(key, value)| Some((key.clone(), value.as_f64()?)));
        Self {
            hash: hash(&bytes),
            status: answer.status,
            verdict: verdict.unwrap_or_default().into(),
            figures: figures.filter(|(_, figure)| figure.abs() > SAME).collect(),
        }
    }
}

/// Returns status, stdout and stderr without times.
fn told(answer: &Answer) -> String {
    let stdout = match serde_json::from_str::<Value>(&answer.stdout) {
        Ok(mut value) => {
            if let Value::Object(object) = &mut value {
                object.remove("time");
            }
            for attempt in value["attempts"].as_array_mut().into_iter().flatten() {
                attempt.as_object_mut().unwrap().remove("seconds");
            }
            format!("{value:#}")
        }
        Err(_) => {
            let lines = answer.stdout.lines();
            let timeless = lines.filter(|line| !line.starts_with("  time  "));
            timeless.collect::<Vec<_>>().join("\n")
        }
    };
    let (status, stderr) = (answer.status, &answer.stderr);
    format!("{status:?}\n{stdout}\n{stderr}\n")
}

/// Writes an answer and its files for a comparison by hand, if somebody asks for it.
fn dump(command: &str, answer: &Answer, written: &[(String, Vec<u8>)]) {
    let Some(folder) = std::env::var_os("FOLDPATH_ANSWERS") else {
        return;
    };
    let folder = Path::new(&folder).join(command.replace(['/', ' '], "_"));
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("answer"), told(answer)).unwrap();
    for (name, content) in written {
        fs::write(folder.join(name), content).unwrap();
    }
}

/// Returns 64-bit FNV-1a.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Returns the list as text.
fn text(answers: &Answers) -> String {
    let mut text = String::new();
    for (command, record) in answers {
        let Record {
            hash,
            status,
            verdict,
            figures,
        } = record;
        let status = status.map_or("signal".into(), |status| status.to_string());
        let figures = figures.iter().map(|(key, figure)| {
            let figure = format!("{figure:.10}");
            let figure = figure.trim_end_matches('0').trim_end_matches('.');
            format!("{key}={figure}")
        });
        let figures = figures.collect::<Vec<_>>().join(" ");
        writeln!(
            text,
            "{hash:016x}\t{status}\t{verdict}\t{figures}\t{command}"
        )
        .unwrap();
    }
    text
}

/// Parses the list.
fn parsed(text: &str) -> Answers {
    let record = |line: &str| {
        let [hash, status, verdict, figures, command] =
            line.split('\t').collect::<Vec<_>>().try_into().unwrap();
        let figures = figures.split_whitespace().map(|figure| {
            let (key, figure) = figure.split_once('=').unwrap();
            (String::from(key), figure.parse().unwrap())
        });
        let record = Record {
            hash: u64::from_str_radix(hash, 16).unwrap(),
            status: status.parse().ok(),
            verdict: verdict.into(),
            figures: figures.collect(),
        };
        (String::from(command), record)
    };
    text.lines().map(record).collect()
}

/// Tells for each command that answers differently what differs. A command that is recorded and was not run, because its
/// path is missing, differs as well.
fn differences(recorded: &Answers, found: &Answers, compares_bytes: bool) -> Vec<String> {
    let commands: BTreeSet<&String> = recorded.keys().chain(found.keys()).collect();
    let difference = |command: &&String| {
        let (Some(old), Some(new)) = (recorded.get(*command), found.get(*command)) else {
            return Some("run in one of both only".into());
        };
        if (old.status, &old.verdict) != (new.status, &new.verdict) {
            let of = |record: &Record| format!("{:?} {}", record.status, record.verdict);
            return Some(format!("{} instead of {}", of(new), of(old)));
        }
        let keys: BTreeSet<&String> = old.figures.keys().chain(new.figures.keys()).collect();
        let figures = keys.into_iter().filter_map(|key| {
            let [old, new] = [old, new].map(|record| record.figures.get(key).copied());
            let [old, new] = [old, new].map(Option::unwrap_or_default);
            let same = (old - new).abs() <= SAME * old.abs().max(1.0);
            (!same).then(|| format!("{key} {new:e} instead of {old:e}"))
        });
        let figures: Vec<String> = figures.collect();
        if !figures.is_empty() {
            return Some(figures.join(", "));
        }
        (compares_bytes && old.hash != new.hash).then(|| "other bytes".into())
    };
    let told = |command: &String| Some(format!("{command}: {}", difference(&command)?));
    commands.into_iter().filter_map(told).collect()
}

#[test]
fn each_kind_of_difference_is_told() {
    let record = Record {
        hash: 7,
        status: Some(0),
        verdict: "planned".into(),
        figures: BTreeMap::from([("reached".into(), 1.0), ("knots".into(), 4e3)]),
    };
    let answers = |record: &Record| Answers::from([("a: plan a".to_string(), record.clone())]);
    let recorded = answers(&record);
    assert_eq!(parsed(&text(&recorded)), recorded);
    let told = |change: fn(&mut Record), bytes| {
        let mut other = record.clone();
        change(&mut other);
        differences(&recorded, &answers(&other), bytes)
    };
    assert_eq!(told(|_| {}, true), [""; 0]);
    assert_eq!(
        told(|other| other.hash = 8, true),
        ["a: plan a: other bytes"]
    );
    assert_eq!(told(|other| other.hash = 8, false), [""; 0]);
    let change: fn(&mut Record) = |other| other.verdict = "partial".into();
    let expected = "a: plan a: Some(0) partial instead of Some(0) planned";
    assert_eq!(told(change, false), [expected]);
    let change: fn(&mut Record) = |other| other.status = Some(1);
    let expected = "a: plan a: Some(1) planned instead of Some(0) planned";
    assert_eq!(told(change, false), [expected]);
    let change: fn(&mut Record) = |other| {
        other.figures.insert("knots".into(), 4e3 + 1e-5);
        other.figures.insert("goal_error".into(), 1e-8);
    };
    let expected = "a: plan a: goal_error 1e-8 instead of 0e0, knots 4.00000001e3 instead of 4e3";
    assert_eq!(told(change, false), [expected]);
    let change: fn(&mut Record) = |other| {
        other.figures.insert("knots".into(), 4e3 + 1e-7);
        other.figures.insert("goal_error".into(), 1e-10);
    };
    assert_eq!(told(change, false), [""; 0]);
    let missing = "a: plan a: run in one of both only";
    assert_eq!(differences(&recorded, &Answers::new(), false), [missing]);
    assert_eq!(differences(&Answers::new(), &recorded, false), [missing]);
}
