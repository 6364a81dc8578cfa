//! foldpath's answer to a row.

use std::time::Instant;

use foldpath::collision::CollisionScene;
use foldpath::folding::{FoldingMap, SpanningTree};
use foldpath::planner::{Path, Plan, PlanOptions, plan};

use super::sheet::Sheet;

/// A plan, and how long it takes.
pub(super) struct Ours {
    pub(super) plan: Plan,
    /// Seconds, median of all runs, from pattern and goal to the answer.
    pub(super) seconds: f64,
    /// Part of it that is looking for crossings.
    pub(super) collision: f64,
    /// Seconds without the search of the whole motion, but with as many configurations looked at as the
    /// report's path has.
    pub(super) at_knots: f64,
}

/// Seconds that runs are repeated for, and how often at least and at most.
const REPEATED: f64 = 0.5;
const REPEATS: [usize; 2] = [3, 101];

/// Plans within the bound; `knots` configurations are looked at where the whole motion is not.
pub(super) fn ours(sheet: &Sheet, bound: f64, knots: usize) -> Ours {
    let options = PlanOptions {
        bound,
        ..sheet.freedom.options()
    };
    let (seconds, first) = median(|| plan(&sheet.pattern, &sheet.goal, &options));
    let without = PlanOptions {
        collision: false,
        ..options
    };
    let (at_knots, _) = median(|| {
        let plan = plan(&sheet.pattern, &sheet.goal, &without);
        crossing_at(sheet, &plan.path, knots)
    });
    Ours {
        collision: first.times.collision.as_secs_f64() / total(&first),
        plan: first,
        seconds,
        at_knots,
    }
}

fn total(plan: &Plan) -> f64 {
    let times = plan.times;
    let total = times.symmetry + times.solve + times.place + times.fold + times.collision;
    total.as_secs_f64()
}

/// Median of the seconds of some runs, and what the first gave.
fn median<T>(mut run: impl FnMut() -> T) -> (f64, T) {
    let whole = Instant::now();
    let mut times = Vec::new();
    let mut first = None;
    while times.len() < REPEATS[0]
        || times.len() < REPEATS[1] && whole.elapsed().as_secs_f64() < REPEATED
    {
        let start = Instant::now();
        let found = run();
        times.push(start.elapsed());
        first.get_or_insert(found);
    }
    times.sort_unstable();
    let first = first.expect("at least one run");
    (times[times.len() / 2].as_secs_f64(), first)
}

/// Whether faces cross at one of so many configurations along the path.
fn crossing_at(sheet: &Sheet, path: &Path, count: usize) -> bool {
    let pattern = &sheet.pattern;
    let tree = SpanningTree::from_central_face(pattern);
    let mut map = FoldingMap::flat(pattern);
    let mut scene = CollisionScene::new(pattern);
    let places = places(path, count);
    places.iter().any(|angles| {
        map.fold_groups(pattern, &tree, &path.memberships, angles);
        let gap = map.rigidity(pattern, &tree).gap;
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
