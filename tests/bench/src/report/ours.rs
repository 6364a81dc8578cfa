//! foldpath's answer to a row of the report's tables.

use std::time::Instant;

use foldpath::motion::Motion;
use foldpath::planner::{Plan, plan};

use super::sheet::Sheet;

/// A plan, and its time.
pub(super) struct Ours {
    pub(super) plan: Plan,
    /// Median of the seconds of all runs, from pattern and goal to the answer.
    pub(super) seconds: f64,
    /// Fraction of that time in the search for crossings.
    pub(super) collision: f64,
    /// Seconds in finding tree, groups and stars, which are given to the report's method.
    pub(super) given: f64,
}

/// Seconds for which runs are repeated, least and largest number of runs, and seconds of a run from which on there is
/// no repetition.
const REPEATED: f64 = 0.5;
const REPEATS: [usize; 2] = [3, 1001];
const LONG: f64 = 2.0;

/// Plans within the bound, several times.
pub(super) fn ours(sheet: &Sheet, bound: f64) -> Ours {
    let options = sheet.freedom.options().with(|it| it.bound = bound);
    let timed = || {
        let start = Instant::now();
        let found = plan(&sheet.pattern, &sheet.goal, &options);
        (start.elapsed().as_secs_f64(), found)
    };
    let (seconds, last, whole) = repeated(timed);
    Ours {
        given: whole.effort.times.symmetry.as_secs_f64(),
        collision: whole.effort.times.collision.as_secs_f64() / last,
        plan: whole,
        seconds,
    }
}

/// Repeats a run. Returns the median of the seconds, the seconds of the last run, and the result of the last run.
fn repeated<T>(mut run: impl FnMut() -> (f64, T)) -> (f64, f64, T) {
    let whole = Instant::now();
    let mut all = Vec::new();
    loop {
        let (seconds, found) = run();
        all.push(seconds);
        let elapsed = whole.elapsed().as_secs_f64();
        let enough = all.len() >= REPEATS[0] && elapsed >= REPEATED;
        if enough || elapsed >= LONG || all.len() >= REPEATS[1] {
            all.sort_by(f64::total_cmp);
            return (all[all.len() / 2], seconds, found);
        }
    }
}

/// Returns `count` configurations of a path, evenly spaced over the parameters of its segments, ends included.
pub(super) fn places(motion: &Motion, count: usize) -> Vec<Vec<f64>> {
    let segments = motion.segments();
    if segments == 0 {
        return Vec::new();
    }
    let last = count.max(2) - 1;
    let place = |k: usize| {
        #[allow(clippy::cast_precision_loss, reason = "small counts")]
        let (segment, s) = {
            let segment = (k * segments / last).min(segments - 1);
            let along = (k * segments) as f64 / last as f64;
            (segment, along - segment as f64)
        };
        motion.curves(segment).map(|c| c.angle(s)).collect()
    };
    (0..=last).map(place).collect()
}
