//! Motions of sheets that are torn by less than the bound. `check` must not say that a motion holds if faces pass through
//! each other when the sheet is folded along the tree that it certifies.

mod make;
mod oracle;

use core::fmt;
use core::panic::AssertUnwindSafe;
use core::time::Duration;
use std::panic::catch_unwind;
use std::time::Instant;

use foldpath::check::{self, Failure, Undecided, check};
use serde_json::Value;

pub use make::Kind;
use oracle::Oracle;
pub use oracle::{Crossing, Found};

use crate::path_file;

/// Largest number of motions of a kind that are shown.
const SHOWN: usize = 40;
/// Depth, over the median edge, below which a crossing is one of thin faces only.
const SHALLOW: f64 = 1e-6;
/// Number of tears that a program might allow for.
const SEVERAL: f64 = 10.0;
/// Clearance, over the median edge, below which nothing counts as clear.
const CLEAR: f64 = 1e-9;

/// A motion, by the oracle and by `check`.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Seed of the motion.
    pub seed: u64,
    /// Number of faces.
    pub faces: usize,
    /// Findings of the oracle.
    pub found: Found,
    /// The answer of `check`.
    pub answer: Answer,
    /// The first finding of `check`.
    pub finding: String,
}

/// Answer of `check`, by what it is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The motion holds.
    Holds,
    /// Faces pass through each other.
    Crosses,
    /// The search for crossings did not decide.
    NotDecided,
    /// Something else is wrong or not known.
    Other,
}

impl Judged {
    /// Returns `true` if faces cross and `check` says that the motion holds.
    #[must_use]
    pub fn is_false(&self) -> bool {
        self.found.crossing.is_some() && self.answer == Answer::Holds
    }

    /// Returns `true` if faces stay clear of each other by more than this many tears.
    #[must_use]
    pub fn is_clear(&self, tears: f64) -> bool {
        let Found { clearance, .. } = self.found;
        self.found.crossing.is_none() && clearance > CLEAR.max(tears * self.found.tear())
    }

    /// Returns `true` if the motion is refused because of crossings.
    #[must_use]
    pub fn is_refused(&self) -> bool {
        matches!(self.answer, Answer::Crosses | Answer::NotDecided)
    }
}

/// Results for the motions.
#[derive(Debug, Default)]
pub struct Torn {
    /// The motions that were judged, by kind.
    pub judged: Vec<(Kind, Judged)>,
    /// Motions that were not read, and panics, with seeds.
    pub failures: Vec<(Kind, u64, String)>,
    /// Time that making, checking and judging took.
    pub times: [Duration; 3],
}

/// Returns the motion of a seed, as the content of its file.
#[must_use]
pub fn motion_of(kind: Kind, seed: u64) -> Value {
    make::make(kind, seed)
}

/// Makes and judges `count` motions of each of these kinds, with the seeds from `seed` on.
#[must_use]
pub fn run(kinds: &[Kind], seed: u64, count: u64) -> Torn {
    let mut torn = Torn::default();
    for &kind in kinds {
        for seed in seed..seed + count {
            let judged = catch_unwind(AssertUnwindSafe(|| torn.one(kind, seed)));
            let words = match judged {
                Ok(Ok(())) => continue,
                Ok(Err(words)) => words,
                Err(_) => "panicked".into(),
            };
            torn.failures.push((kind, seed, words));
        }
    }
    torn
}

impl Torn {
    fn one(&mut self, kind: Kind, seed: u64) -> Result<(), String> {
        let begun = Instant::now();
        let file = make::make(kind, seed);
        let made = begun.elapsed();
        let (judged, [check, oracle]) = judge(seed, &file)?;
        self.judged.push((kind, judged));
        for (sum, time) in self.times.iter_mut().zip([made, check, oracle]) {
            *sum += time;
        }
        Ok(())
    }

    /// Returns the motions that cross and are said to hold.
    pub fn false_holds(&self) -> impl Iterator<Item = &(Kind, Judged)> {
        self.judged.iter().filter(|(_, judged)| judged.is_false())
    }

    /// Returns `true` if no motion that crosses is said to hold, and all were read.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.false_holds().next().is_none() && self.failures.is_empty()
    }
}

/// Checks the motion of a file and judges it by the oracle. Returns the times that both took, too.
///
/// # Errors
/// If the file is no path, or lacks a key.
pub fn judge(seed: u64, file: &Value) -> Result<(Judged, [Duration; 2]), String> {
    let path = path_file(&file.to_string()).map_err(|error| error.to_string())?;
    let tree = path.pattern.tree();
    let read = Instant::now();
    let verdict = check(&path, &crate::strict());
    let checked = Instant::now();
    let oracle = Oracle::of(file, tree).map_err(|error| error.to_string())?;
    let found = oracle.judge();
    let times = [checked - read, checked.elapsed()];
    let judged = Judged {
        seed,
        faces: oracle.sheet.faces.len(),
        found,
        answer: answer(&verdict),
        finding: verdict.findings().into_iter().next().unwrap_or_default(),
    };
    Ok((judged, times))
}

fn answer(verdict: &check::Verdict) -> Answer {
    let crosses = |failure: &Failure| matches!(failure, Failure::Crosses { .. });
    let open = |question: &Undecided| matches!(question, Undecided::Crossings { .. });
    if verdict.holds() {
        Answer::Holds
    } else if verdict.failures.iter().any(|failure| !crosses(failure)) {
        Answer::Other
    } else if !verdict.failures.is_empty() {
        Answer::Crosses
    } else if verdict.undecided.iter().all(open) {
        Answer::NotDecided
    } else {
        Answer::Other
    }
}

impl fmt::Display for Torn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "| kind | motions | faces | cross | of these hold (FALSE) | below 1e-6 edges | within the tear | \
             within 10 tears | deeper | refused for them | for others | clear by more than the tear | hold | said to cross | not decided | \
             clear by more than 10 tears | refused | neither | hold | refused | refused for others |"
        )?;
        writeln!(
            f,
            "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
        )?;
        for kind in Kind::ALL {
            let of_kind = || {
                let judged = self.judged.iter().filter(move |(other, _)| *other == kind);
                judged.map(|(_, judged)| judged)
            };
            if of_kind().next().is_none() {
                continue;
            }
            let count = |test: &dyn Fn(&&Judged) -> bool| of_kind().filter(test).count();
            let crosses = |judged: &&Judged| judged.found.crossing.is_some();
            // False answers whose depth is from the first of these to the second.
            let between = |low: fn(&Found) -> f64, high: fn(&Found) -> f64| {
                let within = |judged: &&Judged| {
                    let (found, low) = (&judged.found, low(&judged.found));
                    let depth = found.crossing.map_or(0.0, |crossing| crossing.depth);
                    judged.is_false() && depth > low && depth <= high(found).max(low)
                };
                of_kind().filter(within).count()
            };
            let neither = |judged: &&Judged| !crosses(judged) && !judged.is_clear(1.0);
            let faces = of_kind().map(|judged| judged.faces);
            writeln!(
                f,
                "| {} | {} | {} to {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
                kind.name(),
                of_kind().count(),
                faces.clone().min().unwrap_or(0),
                faces.max().unwrap_or(0),
                count(&crosses),
                count(&|j| j.is_false()),
                between(|_| 0.0, |_| SHALLOW),
                between(|_| SHALLOW, Found::tear),
                between(
                    |found| SHALLOW.max(found.tear()),
                    |found| SEVERAL * found.tear(),
                ),
                between(
                    |found| SHALLOW.max(SEVERAL * found.tear()),
                    |_| f64::INFINITY,
                ),
                count(&|j| crosses(j) && j.is_refused()),
                count(&|j| crosses(j) && j.answer == Answer::Other),
                count(&|j| j.is_clear(1.0)),
                count(&|j| j.is_clear(1.0) && j.answer == Answer::Holds),
                count(&|j| j.is_clear(1.0) && j.answer == Answer::Crosses),
                count(&|j| j.is_clear(1.0) && j.answer == Answer::NotDecided),
                count(&|j| j.is_clear(SEVERAL)),
                count(&|j| j.is_clear(SEVERAL) && j.is_refused()),
                count(&neither),
                count(&|j| neither(j) && j.answer == Answer::Holds),
                count(&|j| neither(j) && j.is_refused()),
                count(&|j| !crosses(j) && j.answer == Answer::Other),
            )?;
        }
        for kind in Kind::ALL {
            let of_kind = |(other, _): &&(Kind, Judged)| *other == kind;
            for (_, judged) in self.false_holds().filter(of_kind).take(SHOWN) {
                if let Some(crossing) = judged.found.crossing {
                    writeln!(
                        f,
                        "FALSE HOLDS: {}, seed {}, {} faces: faces {:?}{} cross {:.2e} edges deep at {:.4} after knot \
                         {}; gap {:.1e}, twist {:.1e}",
                        kind.name(),
                        judged.seed,
                        judged.faces,
                        crossing.faces,
                        if crossing.share {
                            ", which share a vertex,"
                        } else {
                            ""
                        },
                        crossing.depth,
                        crossing.at,
                        crossing.segment,
                        judged.found.gap,
                        judged.found.twist,
                    )?;
                }
            }
            let clear = self.judged.iter().filter(of_kind);
            let clear = clear.filter(|(_, judged)| judged.is_clear(1.0) && judged.is_refused());
            for (_, judged) in clear.take(SHOWN / 4) {
                writeln!(
                    f,
                    "refused although clear: {}, seed {}, {} faces: clearance {:.2e}, gap {:.1e}, twist {:.1e}: {}",
                    kind.name(),
                    judged.seed,
                    judged.faces,
                    judged.found.clearance,
                    judged.found.gap,
                    judged.found.twist,
                    judged.finding,
                )?;
            }
            let others = self.judged.iter().filter(of_kind);
            let others = others.filter(|(_, judged)| judged.answer == Answer::Other);
            for (_, judged) in others.take(SHOWN / 10) {
                writeln!(
                    f,
                    "refused for others: {}, seed {}: {}",
                    kind.name(),
                    judged.seed,
                    judged.finding
                )?;
            }
        }
        for (kind, seed, words) in self.failures.iter().take(SHOWN) {
            writeln!(f, "{}, seed {seed}: {words}", kind.name())?;
        }
        writeln!(f, "Made, checked and judged in {:.1?}.", self.times)
    }
}
