//! The report's tables, foldpath beside the report's method.

use core::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

use foldpath::motion::Motion;
use foldpath::planner::Outcome;

use super::cases::{self, Case, Extent, Kind, LIMIT, SHORT_LIMIT};
use super::measure::{Deviation, between_knots, motion_between, straight_between};
use super::ours::{Ours, ours};
use super::search::{End, Run};
use super::sheet::Sheet;
use super::tune::{Trial, Tuned, tune};

/// The measurements of a row.
struct Row {
    case: Case,
    unknowns: usize,
    tuned: Tuned,
    /// Deviation at the knots of the report's path, and between them.
    theirs: Option<[Deviation; 2]>,
    ours: Ours,
    /// Deviation at the knots of foldpath's path, and between them.
    ours_measured: [Deviation; 2],
}

/// Measures all rows and writes them.
pub(super) fn print(extent: Extent, out: &mut impl Write, folder: &Path) -> io::Result<()> {
    let mut all = Vec::new();
    writeln!(
        out,
        "The report's method, an adaptive randomised search with NLopt {}, beside foldpath, in one run on one core. \
         **Of the report's method**: the fastest of COBYLA, Nelder-Mead, BOBYQA, SLSQP and L-BFGS (the last two by \
         differences), with the fastest maximum of evaluations (MI), among those with which at least 90 % of 10 seeds \
         reach the goal (3 seeds where a run takes more than 5 s). It is given crease groups and essential vertices, \
         bounds the deformation at its knots, and looks for crossings at its knots, by bounding boxes. **Of \
         foldpath**: the whole of `plan`, from pattern and goal to the answer. It finds the groups, bounds \
         deformation *and* gap over the whole motion, rounding included, and looks for crossings over the whole \
         motion. Times \
         are medians, in milliseconds; a ratio is the report's time over foldpath's. A run of the report's method has \
         {LIMIT} s in Table 2 and {SHORT_LIMIT} s elsewhere; where none reaches the goal, the table says how far the best came.\n",
        version()
    )?;
    for (title, cases) in [
        (
            "Table 1: bounds on deformation, every crease on its own",
            cases::table_1(extent),
        ),
        (
            "Table 2: symmetry and essential vertices (SYM/EV), bound 5 %",
            cases::table_2(extent),
        ),
        ("Bound 1e-9", cases::accurate(extent)),
    ] {
        let rows: Vec<Row> = cases.iter().map(|case| measure(case, extent)).collect();
        writeln!(out, "### {title}\n")?;
        times(&rows, out)?;
        errors(&rows, out)?;
        if rows.iter().any(|row| row.case.kind == Kind::Quad) {
            writeln!(
                out,
                "The report does not say what its Quad is. foldpath's, which behaves like it in Figure 8, turns no crease \
                 by more than a single step of the search, and does not close: edges keep their lengths, but the sheet \
                 tears, and of 4x4 torn faces cross.\n"
            )?;
        }
        all.extend(rows);
    }
    std::fs::write(folder.join("report-tables.csv"), csv(&all))?;
    std::fs::write(folder.join("report-tuning.csv"), trials(&all))?;
    writeln!(
        out,
        "All rows: [report-tables.csv](tests/bench/results/report-tables.csv); every algorithm and maximum of \
         evaluations that was tried: [report-tuning.csv](tests/bench/results/report-tuning.csv).\n"
    )
}

fn version() -> String {
    let (major, minor, patch) =
        nlopt::Nlopt::<fn(&[f64], Option<&mut [f64]>, &mut ()) -> f64, ()>::version();
    format!("{major}.{minor}.{patch}")
}

fn measure(case: &Case, extent: Extent) -> Row {
    let sheet = case.sheet();
    eprint!(
        "{} {} {}: ",
        case.name(),
        case.freedom.marks(),
        percent(case.bound)
    );
    let tuned = tune(&sheet, case.accept(), true, &case.tuning(extent));
    let best = tuned.best.as_ref().and_then(Trial::median);
    eprintln!("{}", tuned.best.as_ref().map_or("none".into(), named));
    let theirs = best.map(|run| deviations(&sheet, run));
    let ours = ours(&sheet, case.bound);
    let motion = ours.plan.motion.as_ref();
    let memberships = motion.map(Motion::memberships).unwrap_or_default();
    let knots: Vec<_> = ours
        .plan
        .knots()
        .iter()
        .map(|knot| knot.angles.clone())
        .collect();
    let ours_measured = [knots, motion.map(motion_between).unwrap_or_default()]
        .map(|places| between_knots(&sheet.pattern, sheet.pattern.tree(), &memberships, &places));
    Row {
        case: *case,
        unknowns: sheet.groups.len(),
        tuned,
        theirs,
        ours,
        ours_measured,
    }
}

fn deviations(sheet: &Sheet, run: &Run) -> [Deviation; 2] {
    [&run.knots, &straight_between(&run.knots)].map(|places| {
        between_knots(
            &sheet.pattern,
            sheet.pattern.tree(),
            sheet.groups.memberships(),
            places,
        )
    })
}

fn named(trial: &Trial) -> String {
    format!("{}, MI {}", trial.algorithm.name(), trial.max_evaluations)
}

impl Row {
    fn their_seconds(&self) -> Option<f64> {
        Some(self.tuned.best.as_ref()?.median()?.time.as_secs_f64())
    }

    /// Returns the fraction of the report's time in the search for crossings.
    fn their_collision(&self) -> Option<f64> {
        let run = self.tuned.best.as_ref()?.median()?;
        Some(run.collision.as_secs_f64() / run.time.as_secs_f64())
    }

    /// Describes how far the report's method came if it failed, and the reason.
    fn failure(&self) -> String {
        let runs = self.tuned.trials.iter();
        let runs = runs.flat_map(|trial| trial.runs.iter().map(move |run| (trial, run)));
        let best = runs.max_by(|a, b| a.1.reached.total_cmp(&b.1.reached));
        let Some((trial, run)) = best else {
            return "none".into();
        };
        let why = match run.end {
            End::GoalDeforms => "the goal itself deforms more",
            End::GoalCrosses => "the goal, one step away, is refused: torn faces cross there",
            End::Stuck => "then no sample is accepted",
            End::Timeout | End::Reached => "then out of time",
        };
        format!(
            "none: {:.0} % of the way ({}), {why}",
            100.0 * run.reached,
            named(trial)
        )
    }

    fn outcome(&self) -> &'static str {
        self.ours.plan.outcome.name()
    }

    fn is_planned(&self) -> bool {
        self.ours.plan.outcome == Outcome::Planned
    }

    /// Returns the report's time over foldpath's, as text.
    fn ratio(&self, ours: f64) -> String {
        match self.their_seconds() {
            _ if !self.is_planned() => "".into(),
            Some(theirs) => format!("{:.1}", theirs / ours),
            None => "only foldpath".into(),
        }
    }

    fn sheet(&self) -> String {
        let bound = percent(self.case.bound);
        let marks = self.case.freedom.marks();
        format!(
            "| {} | {marks} | {} | {bound} |",
            self.case.name(),
            self.unknowns
        )
    }
}

fn times(rows: &[Row], out: &mut impl Write) -> io::Result<()> {
    writeln!(
        out,
        "| sheet | SYM/EV | unknowns | bound | report: best | success | time | collision | foldpath | time | \
         collision | ratio |\n|---|---|---|---|---|---|---|---|---|---|---|---|"
    )?;
    for row in rows {
        let theirs = match (&row.tuned.best, row.their_seconds(), row.their_collision()) {
            (Some(best), Some(seconds), Some(collision)) => format!(
                "{} | {:.0} % of {} | {} | {:.0} %",
                named(best),
                100.0 * best.success(),
                best.runs.len(),
                milliseconds(seconds),
                100.0 * collision
            ),
            _ => format!("{} | | | ", row.failure()),
        };
        let ours = &row.ours;
        writeln!(
            out,
            "{} {theirs} | {} | {} | {:.0} % | {} |",
            row.sheet(),
            row.outcome(),
            milliseconds(ours.seconds),
            100.0 * ours.collision,
            row.ratio(ours.seconds),
        )?;
    }
    writeln!(out)
}

fn errors(rows: &[Row], out: &mut impl Write) -> io::Result<()> {
    writeln!(
        out,
        "What the paths are worth: largest deformation at knots and, as each interpolates, between them, and largest gap \
         (over the median edge) anywhere.\n"
    )?;
    writeln!(
        out,
        "| sheet | SYM/EV | unknowns | bound | report: knots | deformation | between | gap | foldpath: knots | \
         deformation | between | gap | certified |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    )?;
    for row in rows {
        let theirs = match (row.theirs, row.tuned.best.as_ref().and_then(Trial::median)) {
            (Some(measured), Some(run)) => deviation(run.knots.len(), measured),
            _ => " | | | ".into(),
        };
        let plan = &row.ours.plan;
        let ours = if row.is_planned() {
            deviation(plan.knots().len(), row.ours_measured)
        } else {
            " | | | ".into()
        };
        let certified = plan
            .certified_deformation()
            .map(percent)
            .unwrap_or_default();
        writeln!(out, "{} {theirs} | {ours} | {certified} |", row.sheet())?;
    }
    writeln!(out)
}

fn deviation(knots: usize, [at, between]: [Deviation; 2]) -> String {
    format!(
        "{knots} | {} | {} | {}",
        percent(at.deformation),
        percent(between.deformation),
        percent(at.gap.max(between.gap))
    )
}

/// Formats per cent, or a power of ten for small numbers.
pub(super) fn percent(part: f64) -> String {
    if part >= 9.5e-4 {
        let digits = usize::from(part < 0.0995);
        format!("{:.digits$} %", 100.0 * part)
    } else {
        format!("{part:.0e}")
    }
}

fn milliseconds(seconds: f64) -> String {
    let ms = 1e3 * seconds;
    let digits = match ms {
        ms if ms < 1.0 => 3,
        ms if ms < 10.0 => 2,
        ms if ms < 100.0 => 1,
        _ => 0,
    };
    format!("{ms:.digits$}")
}

fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "sheet,sym_ev,unknowns,bound,report_algorithm,report_mi,report_runs,report_success,report_seconds,\
         report_collision,report_knots,report_deformation,report_deformation_between,report_gap,foldpath_outcome,\
         foldpath_seconds,foldpath_collision,foldpath_given_seconds,foldpath_knots,foldpath_deformation,\
         foldpath_deformation_between,foldpath_gap,foldpath_certified,ratio\n",
    );
    for row in rows {
        let best = row.tuned.best.as_ref();
        let theirs = match (best, best.and_then(Trial::median), row.theirs) {
            (Some(best), Some(run), Some([at, between])) => format!(
                "{},{},{},{:.2},{:.6e},{:.4},{},{:.3e},{:.3e},{:.3e}",
                best.algorithm.name(),
                best.max_evaluations,
                best.runs.len(),
                best.success(),
                run.time.as_secs_f64(),
                row.their_collision().unwrap_or_default(),
                run.knots.len(),
                at.deformation,
                between.deformation,
                at.gap.max(between.gap)
            ),
            _ => ",,,,,,,,,".into(),
        };
        let (ours, [at, between]) = (&row.ours, row.ours_measured);
        let ratio = row.their_seconds().map(|theirs| theirs / ours.seconds);
        let _ = writeln!(
            text,
            "{},{},{},{:e},{theirs},{},{:.6e},{:.4},{:.6e},{},{:.3e},{:.3e},{:.3e},{},{}",
            row.case.name(),
            row.case.freedom.marks(),
            row.unknowns,
            row.case.bound,
            row.outcome(),
            ours.seconds,
            ours.collision,
            ours.given,
            ours.plan.knots().len(),
            at.deformation,
            between.deformation,
            at.gap.max(between.gap),
            number(ours.plan.certified_deformation()),
            number(ratio),
        );
    }
    text
}

fn number(value: Option<f64>) -> String {
    value
        .map(|value| format!("{value:.3e}"))
        .unwrap_or_default()
}

fn trials(rows: &[Row]) -> String {
    let mut text =
        String::from("sheet,sym_ev,bound,algorithm,mi,runs,success,median_seconds,reached\n");
    for row in rows {
        for trial in &row.tuned.trials {
            let seconds = trial.median().map(|run| run.time.as_secs_f64());
            let reached = trial.runs.iter().map(|run| run.reached);
            let _ = writeln!(
                text,
                "{},{},{:e},{},{},{},{:.2},{},{:.3}",
                row.case.name(),
                row.case.freedom.marks(),
                row.case.bound,
                trial.algorithm.name(),
                trial.max_evaluations,
                trial.runs.len(),
                trial.success(),
                number(seconds),
                reached.fold(0.0, f64::max),
            );
        }
    }
    text
}
