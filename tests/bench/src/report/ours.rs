//! foldpath's answer to a row.

use std::time::Instant;

use foldpath::planner::{Judged, Path, Plan, PlanOptions, plan};

use super::search::STEP;
use super::sheet::Sheet;

/// A plan, and how long it takes.
pub(super) struct Ours {
    pub(super) plan: Plan,
    /// Seconds, median of all runs, from pattern and goal to the answer.
    pub(super) seconds: f64,
    /// Part of it that is looking for crossings.
    pub(super) collision: f64,
    /// Seconds of it that are finding tree, groups and stars, which the report's method is given.
    pub(super) given: f64,
    /// Seconds of a plan that is judged at its knots alone, as the report's method judges, with steps as long as
    /// its, less those of what that is given.
    pub(super) at_knots: f64,
    /// How many knots that plan has.
    pub(super) alone: usize,
}

/// Seconds that runs are repeated for, how often at least and at most, and from when on not at all.
const REPEATED: f64 = 0.5;
const REPEATS: [usize; 2] = [3, 1001];
const LONG: f64 = 2.0;

/// Plans within the bound.
pub(super) fn ours(sheet: &Sheet, bound: f64) -> Ours {
    let options = PlanOptions {
        bound,
        ..sheet.freedom.options()
    };
    let timed = || {
        let start = Instant::now();
        let found = plan(&sheet.pattern, &sheet.goal, &options);
        (start.elapsed().as_secs_f64(), found)
    };
    let (seconds, last, whole) = repeated(timed);
    let alone = PlanOptions {
        judged: Judged::Knots,
        max_step: STEP,
        ..options.clone()
    };
    let (at_knots, _, first_look) = repeated(|| {
        let start = Instant::now();
        let plan = plan(&sheet.pattern, &sheet.goal, &alone);
        let seconds = start.elapsed().saturating_sub(plan.times.symmetry);
        (seconds.as_secs_f64(), plan)
    });
    assert_eq!(
        whole.outcome.name(),
        first_look.outcome.name(),
        "judged at knots alone"
    );
    Ours {
        given: whole.times.symmetry.as_secs_f64(),
        collision: whole.times.collision.as_secs_f64() / last,
        plan: whole,
        seconds,
        at_knots,
        alone: first_look.path.knots.len(),
    }
}

/// Runs as often as makes sense: the median of the seconds, those of the last run, and what that found.
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

/// So many configurations of a path, evenly over its segments' parameters, ends included.
pub(super) fn places(path: &Path, count: usize) -> Vec<Vec<f64>> {
    let curves = path.curves();
    if curves.is_empty() {
        return Vec::new();
    }
    let last = count.max(2) - 1;
    let place = |k: usize| {
        #[allow(clippy::cast_precision_loss, reason = "small counts")]
        let (segment, s) = {
            let segment = (k * curves.len() / last).min(curves.len() - 1);
            let along = (k * curves.len()) as f64 / last as f64;
            (segment, along - segment as f64)
        };
        curves[segment].iter().map(|c| c.angle(s)).collect()
    };
    (0..=last).map(place).collect()
}
