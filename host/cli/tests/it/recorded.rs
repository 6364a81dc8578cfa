//! Compares the answers of the command with recorded ones, byte by byte: a guard for changes that must change no answer.
//!
//! Each line of `recorded.csv` names a file and a command, and has the hash of everything that the command writes: its
//! exit status, its JSON or text without times, and the bytes of the file that it makes. The test is run by hand, because
//! the mathematical functions of other systems may round differently:
//!
//! ```text
//! cargo nextest run --release -p foldpath-cli recorded --run-ignored only
//! ```
//!
//! `FOLDPATH_RECORD=1` writes the list anew.

use core::fmt::Write as _;
use core::sync::atomic::{AtomicUsize, Ordering};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use foldpath_test_support::{Answer, Folder};
use serde_json::Value;

/// Options of `plan`, with a name that the path's file gets. Commands on paths use the first.
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

/// Commands on a path; each names the file that it writes behind `-o`.
const ON_PATHS: [&str; 9] = [
    "check {} --json",
    "export {} --to csv -o out.csv",
    "export {} --to traj -o out",
    "export {} --to glb -o out",
    "export {} --to rust -o out",
    "export {} --to svg -o out",
    "plot {} -o out.svg",
    "view {} -o out.html",
    "check {} --bound 1e-6 --json",
];

/// Every file's answers, in the order of the commands.
type Answers = BTreeMap<String, u64>;

#[test]
#[ignore = "answers of other systems may differ in the last digits"]
fn answers_are_the_recorded_ones() {
    let list = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recorded.csv");
    let files = patterns(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../patterns"));
    let next = AtomicUsize::new(0);
    let found = Mutex::new(Answers::new());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(file) = files.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let answers = answers(file);
                    found.lock().unwrap().extend(answers);
                }
            });
        }
    });
    let found = found.into_inner().unwrap();
    if std::env::var_os("FOLDPATH_RECORD").is_some() {
        let mut text = String::new();
        for (command, hash) in &found {
            writeln!(text, "{hash:016x},{command}").unwrap();
        }
        fs::write(list, text).unwrap();
        return;
    }
    let recorded = fs::read_to_string(list).unwrap();
    let recorded: Answers = recorded
        .lines()
        .filter_map(|line| line.split_once(','))
        .map(|(hash, command)| (command.into(), u64::from_str_radix(hash, 16).unwrap()))
        .collect();
    assert!(recorded.len() > 100, "{} answers", recorded.len());
    // A command that is no longer run, because its path is missing, differs as well.
    let commands: BTreeSet<&String> = recorded.keys().chain(found.keys()).collect();
    let differs = |command: &&&String| recorded.get(**command) != found.get(**command);
    let different: Vec<_> = commands.iter().filter(differs).collect();
    assert!(different.is_empty(), "other answers: {different:#?}");
}

/// Returns the crease patterns in a folder and the folders in it, sorted.
fn patterns(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let ending = path.extension().unwrap_or_default();
        if path.is_dir() {
            found.extend(patterns(&path));
        } else if ["fold", "svg", "cp", "obj"]
            .iter()
            .any(|known| ending == *known)
        {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Runs every command on a pattern and returns the hashes of the answers.
fn answers(file: &Path) -> Answers {
    let name = file.file_name().unwrap().to_string_lossy().into_owned();
    let folder = Folder::of(env!("CARGO_BIN_EXE_foldpath"));
    fs::copy(file, folder.path(&name)).unwrap();
    let mut answers = Answers::new();
    let mut run = |command: &str, output: &str| {
        let hash = hash(&folder.run(command), &folder.path(output));
        answers.insert(format!("{name}: {command}"), hash);
    };
    run(&format!("info {name} --json"), "");
    run(&format!("info {name}"), "");
    for (number, options) in PLANS.iter().enumerate() {
        let path = format!("path{number}.fold");
        run(&format!("plan {name} {options} --json -o {path}"), &path);
    }
    for number in 0..PLANS.len() {
        let path = format!("path{number}.fold");
        if !folder.path(&path).exists() {
            continue;
        }
        run(&format!("check {path} --json"), "");
        spoil(&folder, &path);
        run(&format!("check spoilt-{path} --json"), "");
    }
    if folder.path("path0.fold").exists() {
        for command in ON_PATHS {
            run(&command.replace("{}", "path0.fold"), output(command));
        }
        run("unfold path0.fold -o unfolded.fold --json", "unfolded.fold");
    }
    answers
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

/// Returns the name of the file that a command writes, which follows `-o`; empty if it writes none.
fn output(command: &str) -> &str {
    let mut words = command.split(' ').skip_while(|word| *word != "-o");
    words.nth(1).unwrap_or_default()
}

/// Returns the hash of an answer and of the file that the command wrote: 64-bit FNV-1a.
fn hash(answer: &Answer, output: &Path) -> u64 {
    let stdout = match serde_json::from_str::<Value>(&answer.stdout) {
        Ok(mut value) => {
            if let Value::Object(object) = &mut value {
                object.remove("time");
                // Has times as well.
                object.remove("attempts");
            }
            value.to_string()
        }
        Err(_) => answer.stdout.clone(),
    };
    let mut bytes = format!("{:?}\n{stdout}\n", answer.status).into_bytes();
    bytes.extend(fs::read(output).unwrap_or_default());
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
