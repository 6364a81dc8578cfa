//! One measurement in a process of its own, because peak memory is measured for a whole process.

use core::time::Duration;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use foldpath::generate::{Miura, Waterbomb};
use foldpath::pattern::{CreasePattern, Drawing};
use foldpath::planner::{Goal, Outcome, Plan, PlanOptions, Symmetry, plan};
use serde_json::{Value, json};

/// First argument of a process that measures.
const MEASURE: &str = "measure";

/// The plan that is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// A Miura sheet with this many faces along each side, from flat to 170 degrees, certified and free of crossings
    /// over the whole motion.
    Symmetric(usize),
    /// A Miura sheet to 150 degrees with every crease an unknown of its own, without collision.
    Full(usize),
    /// The 12x22 waterbomb with every crease an unknown of its own, without collision.
    FullWaterbomb,
}

impl Work {
    /// Returns the name of the sheet.
    #[must_use]
    pub fn sheet(self) -> String {
        match self {
            Self::Symmetric(size) | Self::Full(size) => format!("miura {size}x{size}"),
            Self::FullWaterbomb => "waterbomb 12x22".into(),
        }
    }

    fn arguments(self) -> [String; 2] {
        let (name, size) = match self {
            Self::Symmetric(size) => ("symmetric", size),
            Self::Full(size) => ("full", size),
            Self::FullWaterbomb => ("full-waterbomb", 0),
        };
        [name.into(), size.to_string()]
    }

    fn of(name: &str, size: &str) -> Option<Self> {
        let size = size.parse().ok()?;
        Some(match name {
            "symmetric" => Self::Symmetric(size),
            "full" => Self::Full(size),
            "full-waterbomb" => Self::FullWaterbomb,
            _ => return None,
        })
    }

    fn drawing(self) -> Drawing {
        let miura = |size, degrees: f64| Miura {
            rows: size,
            columns: size,
            sector_angle: 60_f64.to_radians(),
            fold: degrees / 180.0,
        };
        let drawing = match self {
            Self::Symmetric(size) => miura(size, 170.0).drawing(),
            Self::Full(size) => miura(size, 150.0).drawing(),
            Self::FullWaterbomb => Waterbomb {
                rows: 12,
                columns: 22,
                fold: 0.522_504_840_831_969,
            }
            .drawing(),
        };
        drawing.expect("a good sheet")
    }

    fn options(self) -> PlanOptions {
        let symmetric = matches!(self, Self::Symmetric(_));
        let defaults = PlanOptions::default().with(|it| it.keep_vertices = false);
        if symmetric {
            return defaults;
        }
        defaults.with(|it| {
            it.symmetry = Symmetry::Off;
            it.collision = false;
            it.max_step = 6.3_f64.to_radians();
        })
    }
}

/// Result of a measurement. Times are in seconds, of plans without reading and writing.
#[derive(Clone, Debug)]
pub struct Measured(Value);

impl Measured {
    /// Returns one of its numbers.
    ///
    /// # Panics
    /// If there is no number of this name.
    #[must_use]
    pub fn number(&self, key: &str) -> f64 {
        let number = self.0.get(key).and_then(Value::as_f64);
        number.unwrap_or_else(|| panic!("no number {key}"))
    }

    /// Returns the growth of peak memory during the measurement, bytes; NaN if the system does not tell it.
    #[must_use]
    pub fn memory(&self) -> f64 {
        self.0
            .get("memory")
            .and_then(Value::as_f64)
            .unwrap_or(f64::NAN)
    }
}

/// Measures in a new process. `runs`: number of plans, of which medians are taken.
///
/// # Panics
/// If this program cannot be started again, or does not plan the sheet.
#[must_use]
pub fn measure(work: Work, runs: usize) -> Measured {
    eprintln!("{work:?}, {runs} runs");
    let program = std::env::current_exe().expect("the path of this program");
    let output = Command::new(program)
        .arg(MEASURE)
        .args(work.arguments())
        .arg(runs.to_string())
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .expect("this program once more");
    assert!(output.status.success(), "{work:?} failed");
    Measured(serde_json::from_slice(&output.stdout).expect("a measurement"))
}

/// Measures if this process was started for a measurement, and returns its exit status.
#[must_use]
pub fn as_measurement() -> Option<ExitCode> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, command, name, size, runs] = arguments.as_slice() else {
        return None;
    };
    if command != MEASURE {
        return None;
    }
    let (work, runs) = (Work::of(name, size)?, runs.parse().ok()?);
    println!("{}", here(work, runs));
    Some(ExitCode::SUCCESS)
}

fn here(work: Work, runs: usize) -> Value {
    let before = peak();
    let options = work.options();
    let mut memory = None;
    let mut plans: Vec<Plan> = Vec::new();
    let mut drawn = Vec::new();
    let mut counts = [0; 2];
    for _ in 0..runs {
        let drawing = work.drawing();
        let start = Instant::now();
        let pattern = CreasePattern::new(drawing).expect("a good pattern");
        drawn.push(start.elapsed());
        let goal = Goal::of_pattern(&pattern).expect("a goal");
        let plan = plan(&pattern, &goal, &options);
        assert_eq!(plan.outcome, Outcome::Planned, "{:?}", plan.reason);
        memory = memory.or(peak().zip(before).map(|(peak, before)| peak - before));
        counts = [pattern.faces().len(), pattern.creases().len()];
        plans.push(plan);
    }
    let middle = |mut times: Vec<Duration>| {
        times.sort_unstable();
        times[times.len() / 2].as_secs_f64()
    };
    let median = |stage: fn(&Plan) -> Duration| middle(plans.iter().map(stage).collect());
    let plan = &plans[0];
    json!({
        "faces": counts[0],
        "hinges": counts[1],
        "unknowns": plan.reduced.groups,
        "configurations": plan.reduced.waypoints,
        "knots": plan.knots().len(),
        "pattern": middle(drawn),
        "symmetry": median(|p| p.effort.times.symmetry),
        "solve": median(|p| p.effort.times.solve),
        "place": median(|p| p.effort.times.place),
        "fold": median(|p| p.effort.times.fold),
        "collision": median(|p| p.effort.times.collision),
        "total": median(|p| {
            let times = p.effort.times;
            times.symmetry + times.solve + times.place + times.fold + times.collision
        }),
        "certified": plan.certified_deformation(),
        "closure": plan.errors.closure,
        "everywhere": u8::from(plan.crossings.clearance.is_some()),
        "memory": memory,
    })
}

/// Returns the peak memory of this process so far, bytes, as Linux tells it.
fn peak() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024.0 * kilobytes)
}
