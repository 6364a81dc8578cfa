//! Campaigns: do all answers hold on many seeded inputs? Sheets of the [`meshes`] are planned, then judged by `check`
//! and by the oracle. Random [`stars`], random [`paths`] and motions of [`torn`] sheets are judged as well.

pub mod drawn;
mod follow;
pub mod paths;
pub mod stars;
pub mod torn;

use core::fmt;
use core::panic::AssertUnwindSafe;
use core::time::Duration;
use std::collections::BTreeMap;
use std::panic::catch_unwind;
use std::sync::Arc;
use std::time::Instant;

use foldpath::check::check;
use foldpath::collision::faces_without_order;
use foldpath::export::fold::motion_text;
use foldpath::motion::{GroupNaming, Motion};
use foldpath::pattern::{CreasePattern, Drawing, FaceId};
use foldpath::planner::{Goal, Outcome, Plan, PlanOptions, plan};
use foldpath_core::Interpolation;

use crate::{Animation, CONTACT, Random, Sheet, Verdict, meshes, path_file};

/// Largest number of disputes of a family that are shown.
const SHOWN: usize = 20;
/// Time that a plan may run beyond its deadline before it counts as late.
const GRACE: Duration = Duration::from_secs(1);

/// A family of sheets.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// Name of the family.
    pub name: &'static str,
    draw: fn(&mut Random) -> Drawing,
    /// `true` if every sheet is also planned as another drawing of it, with which it must have the same outcome.
    varied: bool,
    /// `true` if some sheets cannot be folded and some close only nearly, as patterns of files do.
    pub real: bool,
    /// `true` if the sheets are too large for the oracle, so that `check` alone judges their plans.
    pub large: bool,
    /// `true` if faces touch along seams at the goal, where rounded coordinates let them overlap: the oracle then takes
    /// for contact what is less than twice the tolerance of the plan.
    pub seams: bool,
}

impl Family {
    /// All families.
    pub const ALL: &'static [Self] = &[
        Self::plain("strips", meshes::strips),
        Self::plain("flat-foldable", meshes::flat_foldable),
        Self::plain("vertex", meshes::vertex),
        Self::plain("slender", meshes::slender),
        Self::plain("map", meshes::map),
        Self::plain("roll", meshes::roll),
        Self::plain("simple-folds", meshes::simple_folds),
        Self::plain("chain", meshes::chain),
        Self::plain("tree", meshes::tree),
        Self::plain("moved-waterbomb", meshes::moved_waterbomb),
        Self::plain("moved-yoshimura", meshes::moved_yoshimura),
        Self {
            name: "variants",
            draw: any,
            varied: true,
            real: false,
            large: false,
            seams: false,
        },
        Self {
            name: "fan",
            draw: meshes::fan,
            varied: false,
            real: true,
            large: false,
            seams: false,
        },
        Self {
            name: "rounded",
            draw: rounded,
            varied: false,
            real: true,
            large: false,
            seams: false,
        },
        Self {
            name: "wide",
            draw: wide,
            varied: false,
            real: true,
            large: false,
            seams: false,
        },
        Self {
            name: "net",
            draw: meshes::net,
            varied: false,
            real: true,
            large: false,
            seams: true,
        },
        Self {
            name: "lattice",
            draw: meshes::lattice,
            varied: false,
            real: true,
            large: true,
            seams: false,
        },
        Self {
            name: "files",
            draw: meshes::file,
            varied: false,
            real: true,
            large: false,
            seams: false,
        },
        Self {
            name: "measured",
            draw: measured,
            varied: false,
            real: true,
            large: false,
            seams: false,
        },
        Self {
            name: "windows",
            draw: meshes::windows,
            varied: false,
            real: true,
            large: false,
            seams: false,
        },
    ];

    const fn plain(name: &'static str, draw: fn(&mut Random) -> Drawing) -> Self {
        Self {
            name,
            draw,
            varied: false,
            real: false,
            large: false,
            seams: false,
        }
    }

    /// Returns the sheet of this seed.
    #[must_use]
    pub fn sheet(&self, seed: u64) -> Drawing {
        (self.draw)(&mut Random::new(seed))
    }

    /// Returns the sheet of this seed, and the other drawing of it if the family has one.
    pub fn sheets(&self, seed: u64) -> impl Iterator<Item = Drawing> {
        let sheet = self.sheet(seed);
        let other = || meshes::variant(&sheet, &mut Random::new(seed));
        let other = self.varied.then(other);
        core::iter::once(sheet).chain(other)
    }
}

/// Draws a sheet of any family that is neither varied nor real.
fn any(random: &mut Random) -> Drawing {
    let others = |family: &&Family| !family.varied && !family.real;
    let plain = Family::ALL.iter().filter(others).count();
    (Family::ALL[random.whole(0, plain - 1)].draw)(random)
}

/// Draws a sheet as [`any`] does, and rounds its coordinates to 4 to 9 decimals.
fn rounded(random: &mut Random) -> Drawing {
    let units = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];
    let drawing = any(random);
    meshes::rounded(drawing, units[random.whole(0, units.len() - 1)])
}

/// Draws many strips without symmetry and rounds their coordinates to 3 to 6 decimals. The rounding errors of a hundred
/// vertices and more add up.
fn wide(random: &mut Random) -> Drawing {
    let units = [1e-3, 1e-4, 1e-5, 1e-6];
    let drawing = meshes::wide_strips(random);
    meshes::rounded(drawing, units[random.whole(0, units.len() - 1)])
}

/// Draws a sheet as [`any`] does, or a pattern of a file, and moves its vertices a little.
fn measured(random: &mut Random) -> Drawing {
    let drawing = if random.chance(0.5) {
        meshes::file(random)
    } else {
        any(random)
    };
    meshes::measured(drawing, random)
}

/// Results for the sheets of a family.
#[derive(Debug, Default)]
pub struct Tally {
    /// Number of creases of each sheet.
    pub creases: Vec<usize>,
    /// Number of sheets that were planned.
    pub planned: usize,
    /// Seeds of the planned sheets whose path does not close to rounding, or does not end at its goal although the goal
    /// closes.
    pub inexact: Vec<u64>,
    /// Number of sheets that were not planned and whose goal itself crosses.
    pub crossed_goals: usize,
    /// Seeds of the sheets that were not planned, by outcome and reason. Numbers in the reason are replaced by #.
    pub others: BTreeMap<String, Vec<u64>>,
    /// Disagreements of the oracle with the planner, or of the planner with itself, with seeds.
    pub disagreements: Vec<(u64, String)>,
    /// Panics, with seeds.
    pub panics: Vec<(u64, String)>,
    /// Seeds of outcomes other than planned that give no reason.
    pub silent: Vec<u64>,
    /// Seeds of plans that overran their deadline.
    pub late: Vec<u64>,
    /// Wall times of planning.
    pub times: Vec<Duration>,
}

/// Plans and judges `count` sheets of `family`, with the seeds from `seed` on.
#[must_use]
pub fn run(family: Family, seed: u64, count: u64, options: &PlanOptions) -> Tally {
    let mut tally = Tally::default();
    for seed in seed..seed + count {
        let sheets = family.sheets(seed);
        let names: Vec<_> = sheets
            .map(|sheet| tally.one(seed, &sheet, options, family))
            .collect();
        if let [first, second] = names[..]
            && first != second
        {
            let difference = format!("drawn otherwise {second:?}, at first {first:?}");
            tally.disagreements.push((seed, difference));
        }
    }
    tally
}

impl Tally {
    /// Plans and judges a sheet, and returns the name of its outcome.
    fn one(
        &mut self,
        seed: u64,
        drawing: &Drawing,
        options: &PlanOptions,
        family: Family,
    ) -> Option<&'static str> {
        let start = Instant::now();
        let planned = catch_unwind(AssertUnwindSafe(|| {
            let pattern = CreasePattern::new(drawing.clone()).expect("a pattern");
            let goal = Goal::of_pattern(&pattern).expect("a goal");
            let plan = plan(&pattern, &goal, options);
            (pattern, plan)
        }));
        let time = start.elapsed();
        self.times.push(time);
        if options
            .timeout
            .is_some_and(|timeout| time > timeout + GRACE)
        {
            self.late.push(seed);
        }
        let (pattern, plan) = match planned {
            Ok(planned) => planned,
            Err(panic) => {
                let words = panic.downcast_ref::<String>().cloned();
                self.panics.push((seed, words.unwrap_or_default()));
                return None;
            }
        };
        self.creases.push(pattern.creases().len());
        let judged = catch_unwind(AssertUnwindSafe(|| {
            judge(drawing, &pattern, &plan, options, family)
        }));
        match judged {
            Ok((crosses, verdict)) => {
                self.crossed_goals += usize::from(crosses);
                match plan.outcome {
                    Outcome::Planned => self.planned += 1,
                    _ => self.note(seed, &plan, crosses),
                }
                let found = verdict.disagreements.into_iter();
                self.disagreements.extend(found.map(|found| (seed, found)));
                if plan.outcome == Outcome::Planned && !verdict.exact {
                    self.inexact.push(seed);
                }
            }
            Err(_) => self.panics.push((seed, "while judging".into())),
        }
        Some(plan.outcome.name())
    }

    fn note(&mut self, seed: u64, plan: &Plan, crosses: bool) {
        let reason = plan.reason.as_ref().map(ToString::to_string);
        let reason = reason.unwrap_or_default();
        if reason.is_empty() {
            self.silent.push(seed);
        }
        let numberless = |word: &str| {
            let number = word.contains(|c: char| c.is_ascii_digit());
            if number {
                "#".to_string()
            } else {
                word.to_string()
            }
        };
        let words: Vec<String> = reason.split(' ').map(numberless).collect();
        let goal = if crosses { " (goal crosses)" } else { "" };
        let key = format!("{}{goal}: {}", plan.outcome.name(), words.join(" "));
        self.others.entry(key).or_default().push(seed);
    }

    /// Returns the median of the planning times.
    #[must_use]
    pub fn median(&self) -> Duration {
        let mut times = self.times.clone();
        times.sort_unstable();
        times.get(times.len() / 2).copied().unwrap_or_default()
    }
}

/// Returns faces that cannot be stacked at the goal that the pattern names.
fn without_order(pattern: &CreasePattern) -> Vec<FaceId> {
    let creases = pattern.creases().iter();
    let goal: Option<Vec<f64>> = creases.map(|&crease| pattern.edge(crease).goal).collect();
    goal.map_or_else(Vec::new, |goal| {
        faces_without_order(pattern, &goal, CONTACT)
    })
}

/// Returns the motion of a sheet of which no configuration is known.
fn without_knots(pattern: &CreasePattern) -> Motion {
    Motion {
        title: String::new(),
        pattern: Arc::new(pattern.clone()),
        members: vec![None; pattern.edges().len()],
        naming: GroupNaming::Unnamed,
        interpolation: Interpolation::Linear,
        max_speed: None,
        max_acceleration: None,
        seed: None,
        answer: None,
        knots: Vec::new(),
        phases: Vec::new(),
        plates: None,
    }
}

/// Returns `true` if the plan does not reach its goal and the goal crosses or its faces cannot be stacked, and the oracle's
/// verdict on the path.
fn judge(
    drawing: &Drawing,
    pattern: &CreasePattern,
    plan: &Plan,
    options: &PlanOptions,
    family: Family,
) -> (bool, Verdict) {
    let motion = plan
        .motion
        .clone()
        .unwrap_or_else(|| without_knots(pattern));
    let text = motion_text(&motion);
    let goal: Vec<Option<f64>> = drawing.edges.iter().map(|edge| edge.goal).collect();
    let planned = plan.outcome == Outcome::Planned;
    // A path that ends at a crossing ends where the overlap reaches the tolerance of contact.
    let contact = if family.seams || !planned {
        2.0 * plan.crossings.contact_tolerance
    } else {
        CONTACT
    };
    if family.large {
        let mut verdict = Verdict {
            exact: true,
            ..Verdict::default()
        };
        if planned {
            verdict.disagreements = findings(&text, options.bound);
        }
        return (false, verdict);
    }
    // A plan that ran out of time may have knots at which the sheet was never folded.
    let unfolded = plan.knots().iter().all(|knot| knot.vertices.is_empty());
    if !planned && unfolded {
        let sheet = serde_json::from_str(&text).and_then(|file| Sheet::of(&file));
        let crosses = crosses(&sheet.expect("a sheet"), &goal, contact);
        return (crosses, Verdict::default());
    }
    let path = Animation::parse(&text).expect("a path");
    let mut verdict = crate::judge(&path, &goal, plan, options.bound, contact);
    if planned {
        let found = &mut verdict.disagreements;
        // A sheet drawn by hand closes no better than it is drawn, so that `check` gets the bound of its plan.
        let strict = crate::strict().bound;
        let bound = if family.real { options.bound } else { strict };
        found.extend(findings(&text, bound));
        if path.frames.is_empty() {
            found.push("planned, but no knots".into());
        }
    }
    let unordered = without_order(pattern);
    if planned && !unordered.is_empty() {
        let difference = format!("planned, but {unordered:?} cannot be stacked at the goal");
        verdict.disagreements.push(difference);
    }
    let no_way = !unordered.is_empty() || crosses(&path.sheet, &goal, contact);
    (!planned && no_way, verdict)
}

/// Returns what `check` finds on a path with this bound.
fn findings(path: &str, bound: f64) -> Vec<String> {
    let options = crate::strict().with(|it| it.bound = bound);
    match path_file(path) {
        Ok(file) => check(&file, &options).findings(),
        Err(error) => vec![error.to_string()],
    }
}

/// Returns `true` if the sheet passes through itself at these fold angles of the edges; edges without an angle are
/// flat. An overlap up to `contact`, over the median edge, is contact.
fn crosses(sheet: &Sheet, goal: &[Option<f64>], contact: f64) -> bool {
    let mut angles = vec![0.0; sheet.edges.len()];
    let known = angles.iter_mut().zip(goal);
    known.for_each(|(angle, goal)| *angle = goal.unwrap_or(0.0));
    let angles = &angles;
    let poses = sheet.fold(angles);
    let (positions, tear) = (sheet.positions(&poses), sheet.gap(&poses));
    let crossings = sheet.crossings_beyond_tears(angles, &positions, [tear, contact]);
    !crossings.is_empty()
}

/// The report of a campaign: a table with one row a family, and remarks below it.
pub struct Report(pub Vec<(Family, Tally)>);

impl Report {
    /// Returns `true` if nothing panicked, every answer was in time and gave a reason, and no path is in dispute.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.0.iter().all(|(_, tally)| {
            let faults = tally.disagreements.len() + tally.panics.len();
            faults + tally.silent.len() + tally.late.len() == 0
        })
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "| family | creases | plans | planned | of goals that do not cross | inexact | disagreements | \
             panics | late | median | slowest |"
        )?;
        writeln!(f, "|---|---|---|---|---|---|---|---|---|---|---|")?;
        for (family, tally) in &self.0 {
            let plans = tally.times.len();
            let slowest = tally.times.iter().max().copied().unwrap_or_default();
            #[allow(clippy::cast_precision_loss, reason = "small counts")]
            let share = |of: usize| 100.0 * tally.planned as f64 / of.max(1) as f64;
            writeln!(
                f,
                "| {} | {} to {} | {plans} | {} | {:.1} % | {} | {} | {} | {} | {:.2} ms | {:.2} s |",
                family.name,
                tally.creases.iter().min().unwrap_or(&0),
                tally.creases.iter().max().unwrap_or(&0),
                tally.planned,
                share(plans - tally.crossed_goals),
                tally.inexact.len(),
                tally.disagreements.len(),
                tally.panics.len(),
                tally.late.len(),
                1e3 * tally.median().as_secs_f64(),
                slowest.as_secs_f64(),
            )?;
        }
        for (family, tally) in &self.0 {
            for (reason, seeds) in &tally.others {
                let some = &seeds[..seeds.len().min(8)];
                writeln!(
                    f,
                    "{}: {} {reason}; seeds {some:?}",
                    family.name,
                    seeds.len()
                )?;
            }
            let faults = tally.disagreements.iter().chain(&tally.panics);
            for (seed, words) in faults.take(SHOWN) {
                writeln!(f, "{}, seed {seed}: {words}", family.name)?;
            }
            for (what, seeds) in [("inexact", &tally.inexact), ("late", &tally.late)] {
                if !seeds.is_empty() {
                    let some = &seeds[..seeds.len().min(8)];
                    writeln!(f, "{}: {} {what}; seeds {some:?}", family.name, seeds.len())?;
                }
            }
        }
        Ok(())
    }
}
