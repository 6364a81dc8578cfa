//! Random paths: valid ones, spoilt in a few numbers or in their structure. None of them may make `check` or an export
//! panic. The oracle must accept every path that `check` accepts, and the follower must command nothing that it may
//! not.

use core::fmt;
use core::panic::AssertUnwindSafe;
use std::panic::catch_unwind;
use std::path::Path;
use std::sync::LazyLock;

use foldpath::check::{CheckOptions, check};
use foldpath::export::csv;
use foldpath::export::glb;
use foldpath::export::traj::TrajFile;
use foldpath::motion::Motion;
use foldpath::planner::PlanOptions;
use foldpath::read::fold::parse_motion;
use foldpath_core::Interpolation;
use serde_json::{Value, json};

use super::follow::follow;
use crate::{Animation, HandKnot, HandMade, Planned, Random, exceeds, worst};

/// One in this many executions is also checked for crossings between its knots.
const SWEPT: u64 = 8;
/// Number of shapes that are checked between two knots.
const PLACES: u32 = 7;
/// A sheet that is torn by no more than this, over the median edge, must not cross by the oracle.
const CLOSED: f64 = 1e-9;

/// Results for the paths.
#[derive(Debug, Default)]
pub struct Paths {
    /// Number of paths made.
    pub executions: u64,
    /// Number of paths that were read as paths.
    pub read: u64,
    /// Number of paths that hold.
    pub hold: u64,
    /// Number of paths of which a controller's file was made.
    pub exported: u64,
    /// Number of paths that a follower went along to their end.
    pub followed: u64,
    /// Failures, with seeds.
    pub failures: Vec<(u64, String)>,
}

/// Valid paths of small sheets, in all kinds of interpolation.
static GOOD: LazyLock<Vec<Value>> = LazyLock::new(|| {
    let mut paths = Vec::new();
    for name in [
        "miura-3x3",
        "waterbomb-4x6",
        "square-twist-1x1",
        "kresling-2x6",
    ] {
        for kind in [
            Interpolation::HalfAngle,
            Interpolation::Hermite,
            Interpolation::Homogeneous,
            Interpolation::Linear,
        ] {
            let options = PlanOptions::default().with(|it| {
                it.interpolation = Some(kind);
                it.bound = 0.02;
            });
            let text = Planned::new(name, &options).text();
            paths.push(serde_json::from_str(&text).expect("JSON"));
        }
    }
    let knots = |angles: [f64; 3]| {
        let knot = |(time, angle): (f64, f64)| HandKnot {
            time,
            angles: vec![angle; 2],
            rates: vec![0.0; 2],
        };
        [0.0, 1.0, 3.0].into_iter().zip(angles).map(knot).collect()
    };
    for kind in ["linear", "hermite", "half-angle"] {
        let knots: Vec<HandKnot> = knots([0.0, 40.0, 100.0]);
        paths.push(HandMade::strip().path(kind, &knots));
        paths.push(HandMade::fan().path(kind, &knots));
    }
    paths
});

/// Makes and judges `count` paths, with the seeds from `seed` on.
#[must_use]
pub fn run(seed: u64, count: u64) -> Paths {
    let mut tally = Paths::default();
    for seed in seed..seed + count {
        let mut random = Random::new(seed);
        let path = spoilt(&mut random);
        let judged = catch_unwind(AssertUnwindSafe(|| {
            tally.judge(&path, seed.is_multiple_of(SWEPT))
        }));
        tally.executions += 1;
        match judged {
            Ok(found) => tally
                .failures
                .extend(found.into_iter().map(|words| (seed, words))),
            Err(_) => tally.failures.push((seed, "panicked".into())),
        }
    }
    tally
}

/// Returns the path of a seed, as the content of its file.
#[must_use]
pub fn path_of(seed: u64) -> Value {
    spoilt(&mut Random::new(seed))
}

/// Returns a valid path, spoilt up to three times; one path in ten stays as it is.
fn spoilt(random: &mut Random) -> Value {
    let good = &GOOD[random.whole(0, GOOD.len() - 1)];
    let mut path = good.clone();
    if random.chance(0.9) {
        for _ in 0..random.whole(1, 3) {
            spoil(&mut path, random);
        }
    }
    path
}

/// Lists that a knot may have, with one number an edge.
const LISTS: [&str; 4] = [
    "edges_foldAngle",
    "foldpath:edges_foldAngleRate",
    "foldpath:edges_weight",
    "foldpath:edges_weightRate",
];
/// Numbers that are hard to handle.
const HARD: [f64; 14] = [
    0.0,
    -0.0,
    1e-320,
    -1e-300,
    1e-12,
    90.0,
    180.0,
    -180.0,
    180.000_000_1,
    360.0,
    1e9,
    -1e20,
    1e200,
    1.7e308,
];

fn spoil(path: &mut Value, random: &mut Random) {
    let frames = path["file_frames"].as_array().map_or(0, Vec::len);
    if frames == 0 {
        return;
    }
    let at = random.whole(0, frames - 1);
    let list = LISTS[random.whole(0, LISTS.len() - 1)];
    match random.whole(0, 11) {
        // Changes a number of an edge by a small or large amount.
        0..=3 => {
            if let Some(values) = path["file_frames"][at][list].as_array_mut() {
                let edge = random.whole(0, values.len().max(1) - 1);
                let off = random.sign() * random.log_uniform(1e-12, 100.0);
                if let Some(value) = values.get_mut(edge) {
                    *value = json!(value.as_f64().unwrap_or(0.0) + off);
                }
            }
        }
        // Scales all numbers of one list of a knot.
        4 => {
            let factor = 1.0 + random.sign() * random.log_uniform(1e-9, 1.0);
            if let Some(values) = path["file_frames"][at][list].as_array_mut() {
                for value in values.iter_mut() {
                    *value = json!(value.as_f64().unwrap_or(0.0) * factor);
                }
            }
        }
        5 => {
            if let Some(values) = path["file_frames"][at][list].as_array_mut() {
                let edge = random.whole(0, values.len().max(1) - 1);
                let hard = HARD[random.whole(0, HARD.len() - 1)];
                if let Some(value) = values.get_mut(edge) {
                    *value = if random.chance(0.1) {
                        Value::Null
                    } else {
                        json!(hard)
                    };
                }
            }
        }
        6 => {
            let time = path["file_frames"][at]["foldpath:time"].as_f64();
            let time = time.unwrap_or(0.0);
            let hard = HARD[random.whole(0, HARD.len() - 1)];
            let other = [time * random.uniform(0.5, 2.0), -time, hard];
            path["file_frames"][at]["foldpath:time"] = json!(other[random.whole(0, 2)]);
        }
        7 => {
            let other = random.whole(0, frames - 1);
            if let Some(frames) = path["file_frames"].as_array_mut() {
                match random.whole(0, 3) {
                    0 => frames.swap(at, other),
                    1 => drop(frames.remove(at)),
                    2 => frames.insert(at, frames[other].clone()),
                    _ => frames.reverse(),
                }
            }
        }
        8 => {
            let kinds = ["linear", "hermite", "half-angle", "homogeneous", "none"];
            path["foldpath:interpolation"] = json!(kinds[random.whole(0, kinds.len() - 1)]);
        }
        9 => {
            let off = random.sign() * random.log_uniform(1e-12, 1.0);
            if let Some(values) = path["file_frames"][at]["vertices_coords"].as_array_mut() {
                let vertex = random.whole(0, values.len().max(1) - 1);
                if let Some(value) = values.get_mut(vertex).and_then(|v| v.get_mut(2)) {
                    *value = json!(value.as_f64().unwrap_or(0.0) + off);
                }
            }
        }
        10 => {
            let keys: Vec<String> = path["file_frames"][at]
                .as_object()
                .map(|frame| frame.keys().cloned().collect())
                .unwrap_or_default();
            let key = keys.get(random.whole(0, keys.len().max(1) - 1));
            if let (Some(key), Some(frame)) = (key, path["file_frames"][at].as_object_mut()) {
                frame.remove(key);
            }
        }
        _ => {
            let keys = ["foldpath:maxSpeed", "foldpath:maxAcceleration"];
            let hard = random.log_uniform(1e-3, 1e6);
            path[keys[random.whole(0, 1)]] = json!(hard);
        }
    }
}

impl Paths {
    fn judge(&mut self, path: &Value, sweep: bool) -> Vec<String> {
        let mut found = Vec::new();
        let text = path.to_string();
        let name = Path::new("a.fold");
        let file = match parse_motion(name, text.as_bytes()) {
            Ok(file) => file,
            Err(error) => {
                if error.to_string().is_empty() {
                    found.push("refused without a word".into());
                }
                return found;
            }
        };
        self.read += 1;
        let options = crate::strict().with(|it| {
            it.samples = 4;
            it.sweep = sweep;
        });
        let verdict = check(&file, &options);
        let holds = verdict.holds();
        if holds {
            self.hold += 1;
            // `check` accepts paths without some keys that the oracle needs.
            if let Ok(path) = Animation::parse(&text) {
                judge(&path, &options, verdict.closure_bound(), &mut found);
            }
        }
        self.export(&file, holds, &mut found);
        found
    }

    /// Exports a path in every format, and has the controller's file followed.
    fn export(&mut self, file: &Motion, holds: bool, found: &mut Vec<String>) {
        let name = Path::new("a.fold");
        drop(csv::text(file, name).map_err(|error| error.to_string()));
        drop(glb::content(file, name).map_err(|error| error.to_string()));
        let Ok(traj) = TrajFile::of(file, name) else {
            return;
        };
        self.exported += 1;
        match follow(&traj.bytes) {
            Ok(true) => self.followed += 1,
            Ok(false) if holds && file.knots.len() > 1 => {
                found.push("holds and is exported, but not followed to its end".into());
            }
            Ok(false) => {}
            Err(words) => found.push(words),
        }
    }
}

/// Adds to `found` whatever the oracle has against a path that holds.
fn judge(path: &Animation, options: &CheckOptions, closure_bound: f64, found: &mut Vec<String>) {
    let sheet = &path.sheet;
    let stars = sheet.stars();
    let mut look = |place: String, angles: &[f64], closure_bound: f64| {
        let closure = sheet.closure_round(&stars, angles);
        let poses = sheet.fold(angles);
        let (gap, placed) = (sheet.gap(&poses), sheet.positions(&poses));
        let deformation = sheet.deformation(&placed);
        let other = sheet.positions_by_matrices(0, angles);
        let apart = placed.iter().zip(&other).map(|(a, b)| (a - b).norm());
        let apart = worst(apart) / sheet.median_edge();
        let most = sheet.other_tree(&stars) * options.bound;
        for (what, value, most) in [
            ("closure", closure, closure_bound + CLOSED),
            ("gap", gap, most),
            ("deformation", deformation, most),
            ("gap between two trees", apart, most),
        ] {
            if exceeds(value, most) {
                found.push(format!(
                    "holds, but {place}: {what} {value:e}, at most {most:e}"
                ));
            }
        }
        if gap <= CLOSED {
            let crossings = sheet.crossings(&placed);
            if !crossings.is_empty() {
                found.push(format!("holds, but {place}: crossings {crossings:?}"));
            }
        }
    };
    for (knot, frame) in path.frames.iter().enumerate() {
        look(format!("knot {knot}"), &frame.angles, closure_bound);
    }
    if options.sweep {
        for segment in 0..path.motion.segments() {
            for k in 1..=PLACES {
                let s = f64::from(k) / f64::from(PLACES + 1);
                let angles = path.motion.angles(segment, s);
                look(
                    format!("after knot {segment} at {s}"),
                    &angles,
                    closure_bound,
                );
            }
        }
    }
}

impl fmt::Display for Paths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} random paths: {} read, {} of these hold, {} exported for a controller, {} followed to their end; \
             {} failures.",
            self.executions,
            self.read,
            self.hold,
            self.exported,
            self.followed,
            self.failures.len()
        )?;
        for (seed, words) in self.failures.iter().take(20) {
            writeln!(f, "paths, seed {seed}: {words}")?;
        }
        Ok(())
    }
}
