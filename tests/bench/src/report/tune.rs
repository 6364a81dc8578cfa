//! The best algorithm, and the number of evaluations it may take, for a sheet and a bound.
//!
//! The report sets the number to the least with which more than 90 % of its runs succeed. Here it is the
//! fastest of a short ladder with which at least 90 % do, which can only be better for the report's method.

use core::time::Duration;

use super::search::{Accept, Algorithm, End, Run, Settings, search};
use super::sheet::Sheet;

/// How to tune.
#[derive(Clone, Copy, Debug)]
pub struct Tuning {
    /// Numbers of evaluations to try: MI.
    pub ladder: &'static [u32],
    /// Runs that success is counted over.
    pub seeds: u64,
    /// Time after which a run has failed.
    pub limit: Duration,
}

/// An algorithm with a number of evaluations, and how it did.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The algorithm.
    pub algorithm: Algorithm,
    /// Evaluations it may take for a configuration.
    pub max_evaluations: u32,
    /// Its runs, one for each seed. Fewer than asked for where it could not become the best.
    pub runs: Vec<Run>,
}

/// What tuning found.
#[derive(Clone, Debug)]
pub struct Tuned {
    /// The best, with all its runs; of those that fail too often the one that fails least. `None` if no
    /// run succeeded.
    pub best: Option<Trial>,
    /// All that were tried.
    pub trials: Vec<Trial>,
}

/// Part of the runs that has to succeed.
const SUCCESS: f64 = 0.9;
/// Seconds of the first look at each, and of longer ones at those that came farthest.
const LOOKS: [f64; 3] = [0.25, 1.0, 5.0];
/// Part of them that is looked at longer.
const KEPT: usize = 3;
/// NLopt looks at the clock between evaluations only. An algorithm that took so many times a look's time, as the
/// linear algebra of a step in 1104 unknowns does, is not looked at again.
const TOO_SLOW: u32 = 8;
/// The first run of what is compared in full may take this much longer than the fastest.
const SLOWER: f64 = 5.0;
/// Time over that of the best so far, with fewer evaluations, below which another is better: noise aside.
const SURELY: f64 = 0.95;
/// A run has failed after this many times the best median.
const PATIENCE: f64 = 20.0;
/// Seconds: slower than this, fewer seeds are taken.
const SLOW: f64 = 5.0;
const FEW_SEEDS: u64 = 3;
/// Seconds: runs shorter than this are repeated for so long, at most so often, and their median taken.
const REPEATED: f64 = 0.02;
const MOST_REPEATS: usize = 51;

impl Trial {
    /// Part of the runs that reached the goal.
    #[must_use]
    #[allow(clippy::cast_precision_loss, reason = "small counts")]
    pub fn success(&self) -> f64 {
        let reached = self.runs.iter().filter(|run| run.end == End::Reached);
        reached.count() as f64 / self.runs.len().max(1) as f64
    }

    /// The successful run of median time.
    #[must_use]
    pub fn median(&self) -> Option<&Run> {
        let reached = self.runs.iter().filter(|run| run.end == End::Reached);
        let mut reached: Vec<_> = reached.collect();
        reached.sort_by_key(|run| run.time);
        reached.get(reached.len() / 2).copied()
    }

    fn seconds(&self) -> f64 {
        let median = self.median();
        median.map_or(f64::INFINITY, |run| run.time.as_secs_f64())
    }

    fn reached(&self) -> f64 {
        self.runs.iter().map(|run| run.reached).fold(0.0, f64::max)
    }
}

/// Looks for the best. Each is looked at shortly, then those that came farthest for longer, until one
/// succeeds; those not much slower than it are compared in full.
#[must_use]
pub fn tune(sheet: &Sheet, accept: Accept, collision: bool, tuning: &Tuning) -> Tuned {
    let settings = |algorithm, max_evaluations, seed, limit| Settings {
        algorithm,
        max_evaluations,
        accept,
        collision,
        seed,
        limit,
    };
    let mut trials: Vec<Trial> = Vec::new();
    for &max_evaluations in tuning.ladder {
        trials.extend(Algorithm::ALL.map(|algorithm| Trial {
            algorithm,
            max_evaluations,
            runs: Vec::new(),
        }));
    }
    let whole = tuning.limit.as_secs_f64();
    let mut open: Vec<usize> = (0..trials.len()).collect();
    // Algorithms of which one step takes far longer than a look.
    let mut too_slow = Vec::new();
    for look in LOOKS.into_iter().chain([whole]) {
        let limit = Duration::from_secs_f64(look.min(whole));
        for &index in &open {
            let trial = &mut trials[index];
            if too_slow.contains(&trial.algorithm.name()) {
                continue;
            }
            let run = |seed| {
                let settings = settings(trial.algorithm, trial.max_evaluations, seed, limit);
                search(sheet, &settings)
            };
            let first = run(0);
            if first.end == End::Timeout && first.time > TOO_SLOW * limit {
                too_slow.push(trial.algorithm.name());
            }
            // One failure in ten is allowed, and may be the first.
            trial.runs = if first.end == End::Stuck && first.time < limit / 2 {
                vec![first, run(1)]
            } else {
                vec![first]
            };
        }
        let timed_out = |&index: &usize| trials[index].runs.iter().any(|r| r.end == End::Timeout);
        if trials.iter().any(|trial| trial.median().is_some()) || look >= whole {
            break;
        }
        open.retain(timed_out);
        open.sort_by(|&a, &b| trials[b].reached().total_cmp(&trials[a].reached()));
        let kept = if look >= LOOKS[LOOKS.len() - 1] {
            1
        } else {
            open.len().div_ceil(KEPT)
        };
        open.truncate(kept);
    }

    let mut order: Vec<usize> = (0..trials.len()).collect();
    order.sort_by(|&a, &b| trials[a].seconds().total_cmp(&trials[b].seconds()));
    let fastest = trials[order[0]].seconds();
    if fastest.is_infinite() {
        return Tuned { best: None, trials };
    }
    order.retain(|&index| trials[index].seconds() <= SLOWER * fastest);
    let seeds = if fastest > SLOW {
        tuning.seeds.min(FEW_SEEDS)
    } else {
        tuning.seeds
    };
    // Fewer evaluations first: what stops before the maximum does the same with any.
    order.sort_unstable();
    let mut best: Option<usize> = None;
    for index in order {
        let beaten = best.map(|best| trials[best].seconds());
        let limit = beaten.unwrap_or(fastest) * PATIENCE;
        let limit = Duration::from_secs_f64(limit.clamp(REPEATED, whole));
        let trial = &mut trials[index];
        trial.runs.clear();
        for seed in 0..seeds {
            let settings = settings(trial.algorithm, trial.max_evaluations, seed, limit);
            trial.runs.push(repeated(sheet, &settings));
            let failed = trial.runs.iter().filter(|run| run.end != End::Reached);
            let slower = beaten.map_or(0, |best| {
                let slower = |run: &&Run| run.time.as_secs_f64() > best;
                trial.runs.iter().filter(slower).count()
            });
            let hopeless = failed.count() > 1 || 2 * slower as u64 > seeds;
            if beaten.is_some() && hopeless {
                break;
            }
        }
        let whole = trial.runs.len() as u64 == seeds;
        let better = best.is_none_or(|best| {
            let (before, now) = (&trials[best], &trials[index]);
            let good = [before, now].map(|trial| trial.success() >= SUCCESS);
            match good {
                [false, true] => true,
                [true, false] => false,
                [true, true] => now.seconds() < SURELY * before.seconds(),
                [false, false] => now.success() > before.success(),
            }
        });
        if whole && better && trials[index].median().is_some() {
            best = Some(index);
        }
    }
    Tuned {
        best: best.map(|best| trials[best].clone()),
        trials,
    }
}

/// A run; a short one as often as needed for its median time to be sure.
fn repeated(sheet: &Sheet, settings: &Settings) -> Run {
    let first = search(sheet, settings);
    let often = REPEATED / first.time.as_secs_f64().max(1e-9);
    let repeats = (1..MOST_REPEATS).find(|&n| often < f64::from(u32::try_from(n).unwrap_or(1)));
    let mut runs = vec![first];
    for _ in 1..repeats.unwrap_or(MOST_REPEATS) {
        runs.push(search(sheet, settings));
    }
    runs.sort_by_key(|run| run.time);
    runs.swap_remove(runs.len() / 2)
}
