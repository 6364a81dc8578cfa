//! Finds the algorithm, and the largest number of evaluations for a configuration, that are fastest for a sheet and a
//! bound.
//!
//! The report takes the least number of evaluations with which more than 90 % of its runs succeed. This tuning takes
//! the fastest number of a short ladder with which at least 90 % succeed, which can only favour the report's method.

use core::time::Duration;

use super::search::{Accept, Algorithm, End, Run, Settings, search};
use super::sheet::Sheet;

/// Options of tuning.
#[derive(Clone, Copy, Debug)]
pub struct Tuning {
    /// Numbers of evaluations to try: MI.
    pub ladder: &'static [u32],
    /// Number of runs over which success is counted.
    pub seeds: u64,
    /// Time after which a run has failed.
    pub limit: Duration,
}

/// An algorithm with a number of evaluations, and its runs.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The algorithm.
    pub algorithm: Algorithm,
    /// Largest number of evaluations for a configuration.
    pub max_evaluations: u32,
    /// Runs, one for each seed; fewer if the trial could not become the best.
    pub runs: Vec<Run>,
}

/// Result of tuning.
#[derive(Clone, Debug)]
pub struct Tuned {
    /// The best trial, with all its runs. If every trial fails too often, the one that fails least. `None` if no run
    /// succeeded.
    pub best: Option<Trial>,
    /// All trials.
    pub trials: Vec<Trial>,
}

/// Fraction of the runs that has to succeed.
const SUCCESS: f64 = 0.9;
/// Seconds of the first run of each trial, and of longer runs of the trials that came farthest.
const LOOKS: [f64; 3] = [0.25, 1.0, 5.0];
/// One in this many trials gets a longer run.
const KEPT: usize = 3;
/// Multiple of a run's time limit beyond which an algorithm is not tried again. NLopt reads the clock only between
/// evaluations, and the linear algebra of one step in 1104 unknowns may take that long.
const TOO_SLOW: u32 = 8;
/// Largest time of a trial's first run, over the fastest, with which the trial is compared in full.
const SLOWER: f64 = 5.0;
/// A trial replaces the best so far, which has fewer evaluations, if its time is below this multiple, so that noise
/// does not decide.
const SURELY: f64 = 0.95;
/// Multiple of the best median after which a run has failed.
const PATIENCE: f64 = 20.0;
/// Seconds of the fastest run (`SLOW`) above which fewer seeds are taken, and their number.
const SLOW: f64 = 5.0;
const FEW_SEEDS: u64 = 3;
/// Seconds for which shorter runs are repeated, and largest number of runs; the median counts.
const REPEATED: f64 = 0.02;
const MOST_REPEATS: usize = 51;

impl Trial {
    /// Returns the fraction of the runs that reached the goal.
    #[must_use]
    #[allow(clippy::cast_precision_loss, reason = "small counts")]
    pub fn success(&self) -> f64 {
        let reached = self.runs.iter().filter(|run| run.end == End::Reached);
        reached.count() as f64 / self.runs.len().max(1) as f64
    }

    /// Returns the successful run of median time.
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

/// Finds the best trial. Every trial gets a short run, then those that came farthest get longer ones, until one
/// succeeds. Trials not much slower than the fastest are compared in full.
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
    // Algorithms of which one step takes far longer than the time limit.
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
            // One failure in ten is allowed, and it may be the first run.
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
    // Fewer evaluations come first: an algorithm that stops before the maximum does the same with any larger one.
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

/// Runs a search. Repeats a short run until its median time is reliable, and returns the run of median time.
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
