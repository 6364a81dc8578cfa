//! Tests mutated files: they lead to an answer or an error, never to a panic.
//!
//! Mutations are drawn from seeds, so that a failure can be repeated. Its message has the seed and the file.

use std::fs;
use std::panic::catch_unwind;
use std::path::Path;

use crate::common::path_text;
use foldpath::check::{CheckOptions, check};
use foldpath::export::fold::pattern_text;
use foldpath::generate::Miura;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, Outcome, PlanOptions, plan};
use foldpath::read::fold::{GoalFrames, parse_goals, parse_motion, read_motion};
use foldpath::read::read_pattern;
use foldpath::read::{FileError, parse_pattern, parse_shape};
use foldpath::unfold::{UnfoldOptions, unfold};
use foldpath::view::{Scene, page};
use serde_json::{Value, json};

/// Generator SplitMix64: G. Steele, D. Lea, C. Flood, "Fast splittable pseudorandom number generators", 2014.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        usize::try_from(self.next() % u64::try_from(count).unwrap()).unwrap()
    }

    fn of<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.below(list.len())]
    }
}

/// Changes, adds or removes a byte.
fn mutate_bytes(random: &mut Random, text: &str) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    let place = random.below(bytes.len());
    let byte = *random.of(b"0123456789-.,:eE[]{}\"BMVx\xff");
    match random.below(3) {
        0 => bytes[place] = byte,
        1 => bytes.insert(place, byte),
        _ => drop(bytes.remove(place)),
    }
    bytes
}

/// Makes up to three changes: a value becomes a hard value or a copy of another value, or is multiplied by a factor; a
/// list gets another entry; or a value is removed.
fn mutate_values(random: &mut Random, document: &Value) -> Vec<u8> {
    let mut document = document.clone();
    for _ in 0..=random.below(3) {
        let places = places(&document);
        let (place, other) = (random.of(&places), random.of(&places));
        let other = document.pointer(other).unwrap().clone();
        let (parent, key) = place.rsplit_once('/').unwrap_or(("", ""));
        let kind = random.below(10);
        let target = if kind < 8 { place } else { parent };
        match (kind, document.pointer_mut(target).unwrap()) {
            (0, value) => *value = random.of(&hard_values()).clone(),
            (1, value) => *value = other,
            (2..8, value) => {
                let factor = random.of(&[-1.0, 0.0, 0.5, 0.9, 1.1, 1e200]);
                if value.is_f64() {
                    *value = json!(value.as_f64().unwrap() * factor);
                }
            }
            (8, Value::Array(list)) => list.push(other),
            (_, Value::Array(list)) => drop(key.parse().map(|k: usize| list.remove(k))),
            (_, Value::Object(map)) => drop(map.remove(key)),
            _ => {}
        }
    }
    document.to_string().into_bytes()
}

fn hard_values() -> Vec<Value> {
    let texts = [
        "",
        "NaN",
        "\u{0}",
        "hermite",
        "linear",
        "foldedForm",
        "creasePattern",
    ];
    let letters = ["B", "M", "V", "F", "U", "J", "C", "\u{1f426}"];
    let numbers = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        3.0,
        15.0,
        16.0,
        23.0,
        24.0,
        90.0,
        180.0,
        -180.0,
        181.0,
        5e-324,
        1e-300,
        1e-160,
        1e-9,
        1e9,
        1e19,
        1e154,
        1e160,
        1e300,
        f64::MAX,
        f64::MIN,
    ];
    let mut values = vec![
        json!(null),
        json!(true),
        json!([]),
        json!({}),
        json!([[]]),
        json!([0, 0]),
    ];
    values.extend(texts.into_iter().chain(letters).map(Value::from));
    values.extend(numbers.map(Value::from));
    values.extend(
        [
            0,
            1,
            2,
            16,
            24,
            -1,
            65_536,
            4_294_967_295,
            i64::MAX,
            i64::MIN,
        ]
        .map(Value::from),
    );
    values
}

/// Returns JSON pointers to all values.
fn places(value: &Value) -> Vec<String> {
    let children: Vec<(String, &Value)> = match value {
        Value::Array(list) => list
            .iter()
            .enumerate()
            .map(|(k, v)| (k.to_string(), v))
            .collect(),
        Value::Object(map) => map
            .iter()
            .map(|(key, value)| (key.clone(), value))
            .collect(),
        _ => Vec::new(),
    };
    let below = children.into_iter().flat_map(|(key, value)| {
        let below = places(value).into_iter();
        below.map(move |place| format!("/{key}{place}"))
    });
    core::iter::once(String::new()).chain(below).collect()
}

/// Mutates `text` with every seed, and calls `read` with each mutated file. At least a tenth of the files must be good
/// enough to be read, so that the code behind the reader is tested too.
fn for_mutations(text: &str, read: fn(&Path) -> Option<()>) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mutated.fold");
    let document: Value = serde_json::from_str(text).unwrap();
    let mut good = 0;
    for seed in 0..SEEDS {
        let mut random = Random(seed);
        let bytes = if seed % 4 == 0 {
            mutate_bytes(&mut random, text)
        } else {
            mutate_values(&mut random, &document)
        };
        fs::write(&file, &bytes).unwrap();
        let Ok(answer) = catch_unwind(|| read(&file)) else {
            panic!("seed {seed}: {}", String::from_utf8_lossy(&bytes));
        };
        good += u64::from(answer.is_some());
    }
    assert!(good > SEEDS / 10, "{good}");
}

const SEEDS: u64 = 2000;

fn miura() -> (String, CreasePattern) {
    let miura = Miura {
        rows: 3,
        columns: 3,
        sector_angle: 1.0,
        fold: 0.25,
    };
    let drawing = miura.drawing().unwrap();
    (
        pattern_text("Miura", &drawing),
        CreasePattern::new(drawing).unwrap(),
    )
}

/// Plans a pattern, reads its path back and judges the path.
fn plan_and_check(file: &Path) -> Option<()> {
    let read = read_pattern(file).ok()?;
    let goal = Goal::of_pattern(&read.pattern).ok()?;
    let plan = plan(&read.pattern, &goal, &PlanOptions::default());
    let text = path_text(&read.title, &plan);
    fs::write(file, text).unwrap();
    // If one edge is thousands of times as long as the others, rounding alone opens gaps.
    let coordinates = read.pattern.vertices().iter().flatten();
    let moderate = coordinates.clone().all(|c| c.abs() < 1e3);
    if plan.outcome == Outcome::Planned && moderate {
        let path = read_motion(file).expect("a planned path can be read");
        let verdict = check(&path, &CheckOptions::default().with(|it| it.bound = 0.01));
        assert_eq!(verdict.findings(), [""; 0], "a planned path holds");
    }
    Some(())
}

fn check_and_view(file: &Path) -> Option<()> {
    let path = read_motion(file).ok()?;
    let _verdict = check(&path, &CheckOptions::default());
    let _page = page(&Scene::of_path(&path));
    Some(())
}

#[test]
fn mutated_patterns_are_planned_or_refused() {
    for_mutations(&miura().0, plan_and_check);
}

#[test]
fn mutated_paths_are_judged_or_refused() {
    let (_, pattern) = miura();
    let goal = Goal::of_pattern(&pattern).unwrap();
    let plan = plan(&pattern, &goal, &PlanOptions::default());
    let text = path_text("Miura", &plan);
    for_mutations(&text, check_and_view);
}

/// Seeds of `tests/fuzz`, which starts its search from these files.
const SEEDS_OF_READERS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/fuzz/seeds");

/// Mutates the seeds of a reader, byte by byte or with a piece of another seed, and calls the reader with the results.
/// The reader must accept all seeds, and at least a fiftieth of the mutated files.
fn for_mutated_seeds<T>(folder: &str, read: impl Fn(&Path, &[u8]) -> Result<T, FileError>) {
    let seeds = fs::read_dir(Path::new(SEEDS_OF_READERS).join(folder)).unwrap();
    let mut seeds: Vec<_> = seeds.map(|entry| entry.unwrap().path()).collect();
    seeds.sort();
    let texts: Vec<Vec<u8>> = seeds.iter().map(|seed| fs::read(seed).unwrap()).collect();
    for (seed, text) in seeds.iter().zip(&texts) {
        read(seed, text).unwrap_or_else(|error| panic!("{error}"));
    }
    let mut good = 0;
    for round in 0..SEEDS {
        let mut random = Random(round);
        let path = &seeds[random.below(seeds.len())];
        let mut bytes = random.of(&texts).clone();
        for _ in 0..=random.below(3) {
            let (from, to) = (random.below(bytes.len()), random.below(bytes.len()));
            let other = random.of(&texts);
            let (start, end) = (random.below(other.len()), random.below(other.len()));
            match random.below(6) {
                0 => drop(bytes.splice(from.min(to)..from.max(to), [])),
                1 => drop(bytes.splice(from..from, other[start.min(end)..start.max(end)].to_vec())),
                2 => drop(bytes.splice(from..from, random.of(&PIECES).bytes())),
                3 => bytes.swap(from, to),
                _ => bytes[from] = *random.of(b"0123456789-.,:eE[]{}<>#/\"\n \xffBMV"),
            }
            bytes.push(b' ');
        }
        let Ok(answer) = catch_unwind(core::panic::AssertUnwindSafe(|| {
            read(path, &bytes).map_err(|error| error.to_string())
        })) else {
            panic!("round {round}: {}", String::from_utf8_lossy(&bytes));
        };
        good += u64::from(answer.is_ok());
    }
    assert!(good > SEEDS / 50, "{folder}: {good}");
}

/// Pieces of text that are hard for some reader.
const PIECES: [&str; 16] = [
    "1e300",
    "-1e-300",
    "null",
    "[]",
    "{}",
    "[[0,1]]",
    "<g>",
    "</g>",
    "<use href=\"#s\"/>",
    "scale(0)",
    "url(#s)",
    "c1 1 2 2 3 3",
    "&r;",
    "\n2 0 0 4 4\n",
    "NaN",
    "4294967296",
];

#[test]
fn mutated_seeds_are_read_or_refused() {
    for folder in ["fold", "svg", "cp"] {
        for_mutated_seeds(folder, parse_pattern);
    }
    for folder in ["obj", "stl", "shape"] {
        for_mutated_seeds(folder, |path, bytes| {
            let file = parse_shape(path, bytes, None, None)?;
            drop(unfold(&file.shape, &UnfoldOptions::default()).map_err(|error| error.to_string()));
            Ok(())
        });
    }
    for_mutated_seeds("path", parse_motion);
    let square = Path::new(SEEDS_OF_READERS).join("fold/square.fold");
    let sheet = read_pattern(&square).unwrap().pattern;
    for (folder, frames) in [("goal", GoalFrames::Last), ("keyframes", GoalFrames::Each)] {
        for_mutated_seeds(folder, |path, bytes| {
            parse_goals(path, bytes, &sheet, frames)
        });
    }
}
