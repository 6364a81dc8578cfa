//! foldpath's answer to a row.

use std::time::Instant;

use foldpath::collision::CollisionScene;
use foldpath::folding::FoldingMap;
use foldpath::planner::{Path, Plan, PlanOptions, plan};
use foldpath_core::Membership;

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
    /// Seconds of what the report's method does too: following the path, and judging its configurations, as
    /// many as were closed on the way, by deformation and crossings there. The rest is knots that keep the
    /// bound between them, and crossings between.
    pub(super) at_knots: f64,
}

/// Seconds that runs are repeated for, how often at least and at most, and from when on not at all.
const REPEATED: f64 = 0.5;
const REPEATS: [usize; 2] = [3, 101];
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
    let whole = repeated(timed);
    let without = PlanOptions {
        collision: false,
        ..options.clone()
    };
    let knots = repeated(|| {
        let plan = plan(&sheet.pattern, &sheet.goal, &without);
        let places = places(&plan.path, plan.waypoints);
        let start = Instant::now();
        let crossing = crossing_at(sheet, &plan.path.memberships, &places);
        let seconds = (plan.times.solve + start.elapsed()).as_secs_f64();
        (seconds, (crossing, plan.times.symmetry.as_secs_f64()))
    });
    let (seconds, plan) = median(whole);
    let (at_knots, (_, given)) = median(knots);
    Ours {
        collision: plan.times.collision.as_secs_f64() / seconds,
        plan,
        seconds,
        given,
        at_knots,
    }
}

/// Runs as often as makes sense, each with its seconds.
fn repeated<T>(mut run: impl FnMut() -> (f64, T)) -> Vec<(f64, T)> {
    let whole = Instant::now();
    let mut runs = Vec::new();
    loop {
        runs.push(run());
        let elapsed = whole.elapsed().as_secs_f64();
        let enough = runs.len() >= REPEATS[0] && elapsed >= REPEATED;
        if enough || elapsed >= LONG || runs.len() >= REPEATS[1] {
            return runs;
        }
    }
}

/// The run of median seconds.
fn median<T>(mut runs: Vec<(f64, T)>) -> (f64, T) {
    runs.sort_by(|a, b| a.0.total_cmp(&b.0));
    runs.swap_remove(runs.len() / 2)
}

/// Whether faces cross at one of the configurations. Measures deformation and gap there, too.
fn crossing_at(sheet: &Sheet, memberships: &[Membership], places: &[Vec<f64>]) -> bool {
    let pattern = &sheet.pattern;
    let mut map = FoldingMap::flat(pattern);
    let mut scene = CollisionScene::new(pattern);
    places.iter().any(|angles| {
        map.fold_groups(pattern, &sheet.tree, memberships, angles);
        let gap = map.rigidity(pattern, &sheet.tree).gap;
        scene.deepest_crossing(&map, gap).is_some()
    })
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
