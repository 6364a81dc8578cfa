//! Sheets that grow more extreme step by step, through the real command: which step breaks first, and what does the
//! user learn of it?

use core::fmt::Write;
use std::path::Path;

use foldpath::export::fold::pattern_text;
use foldpath::pattern::Drawing;
use foldpath::read::fold::parse_motion;

use super::command::{Answer, run};
use super::patterns::{Mesh, disc};
use super::reference::Folded;

/// Faces along a side of the sheets.
const SIZE: usize = 8;
/// Number of faces above which the reference is not used: it takes a kilobyte and a tenth of a millisecond for each
/// face.
const REFERENCE: usize = 2_000;
/// Largest number of knots of a path that the reference folds, evenly spaced, with the last one among them.
const KNOTS: usize = 40;
/// Seconds that a command may take.
const PATIENCE: u64 = 180;

/// One step of a ladder.
pub struct Rung {
    label: String,
    /// `true` if the step is in the range that was asked for.
    asked: bool,
    drawing: Drawing,
    /// Further arguments of `plan`.
    options: &'static [&'static str],
}

/// A direction in which sheets become more extreme.
pub struct Ladder {
    name: &'static str,
    asked: &'static str,
    rungs: Vec<Rung>,
}

impl Ladder {
    fn new<V: Copy + core::fmt::LowerExp>(
        name: &'static str,
        asked: &'static str,
        values: &[V],
        is_asked: impl Fn(V) -> bool,
        drawing: impl Fn(V) -> Drawing,
    ) -> Self {
        let rung = |&value: &V| Rung {
            label: format!("{value:e}"),
            asked: is_asked(value),
            drawing: drawing(value),
            options: &[],
        };
        Self {
            name,
            asked,
            rungs: values.iter().map(rung).collect(),
        }
    }
}

/// Returns the ladders, with sheets of these sizes; if `short`, with fewer steps.
#[must_use]
pub fn ladders(sizes: &[usize], short: bool) -> Vec<Ladder> {
    let even = || Mesh::even(SIZE);
    let powers = |from: i32, to: i32, step: usize| {
        let exponents = (from.min(to)..=from.max(to)).step_by(step);
        let mut powers: Vec<f64> = exponents.map(|k| 10_f64.powi(k)).collect();
        if from > to {
            powers.reverse();
        }
        powers
    };
    let zigzag = |degrees: f64| Mesh {
        zigzag: degrees.to_radians(),
        ..even()
    };
    let sector = |degrees: f64| Mesh {
        sector: degrees.to_radians(),
        ..even()
    };
    let mut discs = Ladder::new(
        "creases at a vertex",
        "64",
        if short {
            &[6.0, 16.0, 64.0]
        } else {
            &[6.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0]
        },
        |degree| degree <= 64.0,
        |degree: f64| disc(whole(degree)),
    );
    for rung in &mut discs.rungs {
        rung.options = &["--fold", "0.3"];
    }
    #[allow(clippy::cast_precision_loss, reason = "small")]
    let sizes: Vec<f64> = sizes.iter().map(|&size| size as f64).collect();
    vec![
        Ladder::new(
            "goal's fold angle towards 0, degrees",
            "1e-9",
            &powers(0, -16, 1),
            |degrees| degrees > 0.99e-9,
            |degrees| zigzag(degrees).drawing(),
        ),
        Ladder::new(
            "goal's fold angle towards 180, degrees below it",
            "1e-9",
            &powers(0, -15, 1),
            |degrees| degrees > 0.99e-9,
            |degrees| zigzag(180.0 - degrees).drawing(),
        ),
        Ladder::new(
            "sector angle towards 0, degrees",
            "1",
            &powers(1, -12, 1),
            |degrees| degrees > 0.99,
            |degrees| sector(degrees).drawing(),
        ),
        Ladder::new(
            "sector angle towards 90, degrees below it",
            "1",
            &powers(1, -12, 1),
            |degrees| degrees > 0.99,
            |degrees| sector(90.0 - degrees).drawing(),
        ),
        discs,
        Ladder::new(
            "ratio of edge lengths",
            "1e9",
            &powers(1, 17, if short { 2 } else { 1 }),
            |ratio| ratio < 1.01e9,
            |ratio| even().with_ratio(ratio).drawing(),
        ),
        Ladder::new(
            "coordinates scaled down to",
            "1e-9",
            &[1e-3, 1e-6, 1e-9, 1e-20, 1e-40, 1e-49, 1e-51, 1e-160, 1e-310],
            |scale| scale > 0.99e-9,
            |scale| Mesh { scale, ..even() }.drawing(),
        ),
        Ladder::new(
            "coordinates scaled up to",
            "1e9",
            &[1e3, 1e6, 1e9, 1e20, 1e40, 1e49, 1e51, 1e160, 1e308],
            |scale| scale < 1.01e9,
            |scale| Mesh { scale, ..even() }.drawing(),
        ),
        Ladder::new(
            "coordinates shifted by, in edges",
            "1e9",
            &powers(3, 17, 1),
            |shift| shift < 1.01e9,
            |shift| Mesh { shift, ..even() }.drawing(),
        ),
        Ladder::new(
            "faces along each side",
            "1000",
            &sizes,
            |_| true,
            |size: f64| Mesh::even(whole(size)).drawing(),
        ),
    ]
}

fn whole(value: f64) -> usize {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "small whole numbers"
    )]
    let whole = value as usize;
    whole
}

/// Result of a rung.
pub struct Result {
    /// Label of the rung.
    pub label: String,
    /// `true` if the rung is in the range that was asked for.
    pub asked: bool,
    /// Answer of `plan`.
    pub plan: Answer,
    /// Answer of `check` on the path, if there is a path.
    pub check: Option<Answer>,
    /// Deformation and gap of the knots by the reference.
    pub truth: Option<[f64; 2]>,
}

impl Result {
    /// Returns the bound on deformation and gap that `plan` certified.
    #[must_use]
    pub fn certified(&self) -> Option<f64> {
        self.plan.number("certified_deformation")
    }

    /// Returns `true` if `plan` and `check` both answered yes.
    #[must_use]
    pub fn holds(&self) -> bool {
        let yes = |answer: &Answer| answer.status == Some(0);
        yes(&self.plan) && self.check.as_ref().is_none_or(yes)
    }

    /// Returns `true` for a wrong answer: a certified bound that the reference finds broken, a yes beyond the bound, or
    /// a panic.
    #[must_use]
    pub fn is_wrong(&self) -> bool {
        let lies = self.truth.is_some_and(|truth| {
            let worst = truth[0].max(truth[1]);
            let bound = self.certified().unwrap_or(PLAN_BOUND);
            self.holds() && (worst > bound || worst.is_nan())
        });
        let fine = |status: Option<i32>| matches!(status, None | Some(0..=2));
        lies || !fine(self.plan.status) || self.check.as_ref().is_some_and(|c| !fine(c.status))
    }

    /// Returns what a user is told.
    #[must_use]
    pub fn told(&self) -> String {
        match &self.check {
            Some(check) if self.plan.status == Some(0) && check.status != Some(0) => {
                format!("`plan`: {}; `check`: {}", self.plan.told(), check.told())
            }
            _ => self.plan.told(),
        }
    }
}

/// Bound of `plan` if none is given.
const PLAN_BOUND: f64 = 0.01;

/// Plans and checks a rung by `command` in a folder.
///
/// # Panics
/// If the folder cannot be written to, or the command cannot be started.
#[must_use]
pub fn climb(command: &Path, rung: &Rung, folder: &Path) -> Result {
    let [pattern, path] = ["pattern.fold", "path.fold"];
    let text = pattern_text("a sheet", &rung.drawing);
    std::fs::write(folder.join(pattern), text).expect("a file to write");
    let _none = std::fs::remove_file(folder.join(path));
    let mut arguments = vec!["plan", pattern, "-o", path, "--json", "--frames", "angles"];
    arguments.extend(rung.options);
    let plan = run(command, folder, &arguments, PATIENCE);
    let written = folder.join(path).exists();
    let check = written.then(|| run(command, folder, &["check", path, "--json"], PATIENCE));
    let small = rung.drawing.vertices.len() < REFERENCE;
    let truth = (written && small).then(|| truth(&folder.join(path)));
    Result {
        label: rung.label.clone(),
        asked: rung.asked,
        plan,
        check,
        truth: truth.flatten(),
    }
}

/// Returns deformation and gap at the knots of a path, by the reference.
fn truth(path: &Path) -> Option<[f64; 2]> {
    let bytes = std::fs::read(path).ok()?;
    let file = parse_motion(path, &bytes).ok()?;
    let pattern = &file.pattern;
    let step = file.knots.len().div_ceil(KNOTS);
    let each = (0..file.knots.len()).rev().step_by(step).map(|knot| {
        let folded = Folded::new(pattern, &file.crease_angles(knot));
        folded.map_or([f64::INFINITY; 2], |folded| folded.rigidity(pattern))
    });
    each.reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])])
}

/// Climbs all ladders by `command`; if `short`, only as far as they hold. Returns the table and the wrong answers, and
/// writes each rung as a line of CSV.
///
/// # Panics
/// If there is no folder for files, or the command cannot be started.
#[must_use]
pub fn table(
    command: &Path,
    ladders: &[Ladder],
    short: bool,
    csv: &mut String,
) -> (String, Vec<String>) {
    let folder = tempfile::tempdir().expect("a folder for files");
    let mut table = String::from(
        "| direction | asked for | true deformation, gap there | certified there | first to break | at | told as |\n\
         |---|---|---|---|---|---|---|\n",
    );
    csv.push_str(
        "direction,at,asked,status,certified,true_deformation,true_gap,check,told,notes\n",
    );
    let mut wrong = Vec::new();
    for ladder in ladders {
        let mut results = Vec::new();
        for rung in &ladder.rungs {
            let result = climb(command, rung, folder.path());
            eprintln!("{}: {}: {}", ladder.name, result.label, result.told());
            line(csv, ladder, &result);
            if result.is_wrong() {
                wrong.push(format!(
                    "{} at {}: {}",
                    ladder.name,
                    result.label,
                    result.told()
                ));
            }
            let broken = !result.holds();
            results.push(result);
            if short && broken {
                break;
            }
        }
        let within = || results.iter().filter(|r| r.asked);
        let most =
            |value: &dyn Fn(&Result) -> Option<f64>| within().filter_map(value).fold(0.0, f64::max);
        let truth = [0, 1].map(|k| most(&|r| Some(r.truth?[k])));
        let certified = most(&Result::certified);
        let broken = results.iter().find(|r| !r.holds());
        let [what, at, told] = match broken {
            Some(r) => {
                let what = if r.plan.status == Some(0) {
                    "`check`"
                } else {
                    "`plan`"
                };
                [what.into(), r.label.clone(), r.told().replace('|', "\\|")]
            }
            None => {
                let last = results.last().map_or(String::new(), |r| r.label.clone());
                ["nothing".into(), format!("as far as {last}"), String::new()]
            }
        };
        let _ok = writeln!(
            table,
            "| {} | {} | {:.1e}, {:.1e} | {certified:.1e} | {what} | {at} | {told} |",
            ladder.name, ladder.asked, truth[0], truth[1],
        );
    }
    (table, wrong)
}

fn line(csv: &mut String, ladder: &Ladder, result: &Result) {
    let number = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:e}"));
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "'"));
    let [deformation, gap] = [0, 1].map(|k| number(result.truth.map(|truth| truth[k])));
    let check = result.check.as_ref().map_or(String::new(), Answer::told);
    let _ok = writeln!(
        csv,
        "{},{},{},{},{},{deformation},{gap},{},{},{}",
        quoted(ladder.name),
        result.label,
        result.asked,
        result.plan.status.map_or(String::new(), |s| s.to_string()),
        number(result.certified()),
        quoted(&check),
        quoted(&result.plan.told()),
        quoted(&result.plan.notes.join("; ")),
    );
}
