//! `docs/benchmarks/work-precision.md`: measures everything, writes CSV files and plots, and returns the
//! Markdown.

use core::fmt::Write as _;
use core::time::Duration;
use std::fs;
use std::io;
use std::path::Path;

use super::picture::{Line, svg};
use super::{
    Cell, Effort, Family, Method, PathCell, PathEffort, Problem, Route, measure, measure_paths,
    tables, tolerances,
};

/// Amount of work of the section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Small sheets in seconds, so that a test can run the benchmark.
    Short,
    /// All sheets, in minutes.
    Full,
}

use Family::{Miura, Quad, Resch, Waterbomb, Yoshimura};

/// Sheets of the full form. The first sheet of each family is also measured with its crease groups.
const SHEETS: [(Family, usize, usize); 15] = [
    (Miura, 3, 3),
    (Miura, 11, 11),
    (Miura, 24, 24),
    (Waterbomb, 4, 6),
    (Waterbomb, 8, 10),
    (Waterbomb, 12, 22),
    (Yoshimura, 3, 3),
    (Yoshimura, 11, 11),
    (Yoshimura, 24, 24),
    (Resch, 1, 1),
    (Resch, 3, 3),
    (Resch, 6, 6),
    (Quad, 3, 3),
    (Quad, 11, 11),
    (Quad, 24, 24),
];
const SHORT_SHEETS: [(Family, usize, usize); 2] = [(Miura, 3, 3), (Waterbomb, 4, 6)];

impl Form {
    fn problems(self) -> Vec<Problem> {
        let sheets: &[_] = match self {
            Self::Short => &SHORT_SHEETS,
            Self::Full => &SHEETS,
        };
        let mut families = Vec::new();
        let problems = sheets.iter().flat_map(|&(family, rows, columns)| {
            let first = !families.contains(&family);
            families.push(family);
            let kinds: &[bool] = if first { &[true, false] } else { &[false] };
            let problem = move |&symmetric| Problem::new(family, rows, columns, symmetric);
            kinds.iter().map(problem)
        });
        let round_flat = (self == Self::Full).then(|| Problem::round_flat(Quad, 24, 24));
        problems.chain(round_flat).collect()
    }

    fn effort(self) -> Effort {
        match self {
            Self::Short => Effort {
                starts: 3,
                rounds: 1,
                budget: Duration::from_millis(5),
                limit: Duration::from_millis(20),
            },
            Self::Full => Effort {
                starts: 15,
                rounds: 5,
                // Enough for one run of every start on the largest sheet, so that tolerances are compared over the same
                // starts.
                budget: Duration::from_millis(250),
                limit: Duration::from_secs(1),
            },
        }
    }

    fn paths(self) -> (&'static [(Family, usize, usize)], PathEffort) {
        match self {
            Self::Short => (
                &[(Miura, 3, 3)],
                PathEffort {
                    plans: 1,
                    budget: Duration::ZERO,
                    limit: Duration::from_millis(100),
                },
            ),
            Self::Full => (
                &[
                    (Miura, 11, 11),
                    (Waterbomb, 8, 10),
                    (Yoshimura, 11, 11),
                    (Resch, 3, 3),
                    (Quad, 3, 3),
                ],
                PathEffort {
                    plans: 11,
                    budget: Duration::from_millis(100),
                    limit: Duration::from_secs(2),
                },
            ),
        }
    }
}

/// Measures, writes `work-precision*.csv` and `.svg` files into `results`, and returns the Markdown, whose links to
/// these files begin with `link`.
///
/// # Errors
/// If a file cannot be written.
pub fn write(form: Form, results: &Path, link: &str) -> io::Result<String> {
    fs::create_dir_all(results)?;
    let problems = form.problems();
    let effort = form.effort();
    let cells = measure(&problems, &effort);
    fs::write(results.join("work-precision.csv"), csv(&problems, &cells))?;
    let mut pictures = Vec::new();
    for (index, problem) in problems.iter().enumerate() {
        let file = format!(
            "work-precision-{}.svg",
            problem.name().replace(", ", "-").replace(' ', "-")
        );
        let lines = lines(index, &cells);
        let title = format!(
            "{}, {} unknowns: projection to closure",
            problem.name(),
            problem.unknowns()
        );
        fs::write(results.join(&file), svg(&title, "closure reached", &lines))?;
        pictures.push(format!("[{}]({link}/{file})", problem.name()));
    }
    let (sheets, path_effort) = form.paths();
    let paths = measure_paths(sheets, &path_effort);
    fs::write(results.join("work-precision-paths.csv"), paths_csv(&paths))?;
    let file = "work-precision-paths.svg";
    fs::write(
        results.join(file),
        svg("whole paths", "certified deformation", &path_lines(&paths)),
    )?;
    let pictures = pictures.join(", ");
    let tolerances = tolerances();
    Ok(format!(
        "**Projection.** Each start is a closed configuration with every unknown moved by a seeded amount of up to \
         {step} rad, or a multiple where that opens nothing by more than {open}; *round flat* it is the flat sheet, where every \
         condition loses rank. Every method minimises ½‖r‖² over the same stars from the same starts and is stopped at the first \
         configuration whose largest ‖r(v)‖ is within the tolerance, judged afterwards in f64; memory and settings are \
         made before the clock starts. Time is the median over up to {runs} runs, a failure counting as longest; a \
         method has {limit:.1} s a run, and is not asked for a finer tolerance once half of its runs fail. Peers \
         evaluate with foldpath's kernels. Those that know no limits of the angles are let off them. Dense methods are \
         left out where one of their iterations would take minutes.\n\n\
         foldpath's Levenberg-Marquardt in f64, with more than 40 unknowns by sparse factors that are used again \
         (`FactorReuse::Chord`):\n\n{repeated}\n\
         Time of the fastest peer over that, by tolerance (alone: no peer reaches it):\n\n{ratios}\n{behind}\n\
         In how many problems each method reaches a tolerance, and its time over that of foldpath's \
         Levenberg-Marquardt in the median of these:\n\n{reach}\n\
         Time against closure, one line a method: {pictures}.\n\n\
         **Convergence.** Largest residual of Levenberg-Marquardt in f64 after each iteration with a factor of its own \
         (`FactorReuse::None`), from the first start, to 1e-14. Near the end each iteration doubles the digits or better, which is why precision costs so little \
         time:\n\n{iterations}\n\
         **Whole paths** from flat to the goal at bounds on deformation and gap, without the search for crossings \
         (medians of up to {plans} plans). The planner always closes to rounding where it can, so that a bound costs \
         knots alone:\n\n{path_table}\n\
         The finest bound that each route plans within, the time there, and over its time at 1e-2:\n\n{routes}\n\
         ![Time against certified deformation]({link}/{file})\n\n\
         All numbers: [projections]({link}/work-precision.csv), [paths]({link}/work-precision-paths.csv).\n",
        step = super::STEP,
        open = super::OPEN,
        runs = effort.starts * effort.rounds,
        limit = effort.limit.as_secs_f64(),
        repeated = tables::times(&problems, &cells, Method::LmF64),
        ratios = tables::ratios(&problems, &cells, &tolerances),
        behind = tables::behind(&problems, &cells, &tolerances),
        reach = tables::reach(&problems, &cells),
        iterations = tables::iterations(&problems),
        plans = path_effort.plans,
        path_table = tables::paths(&paths),
        routes = tables::routes(&paths),
    ))
}

fn csv(problems: &[Problem], cells: &[Cell]) -> String {
    let mut text = String::from(
        "sheet,symmetric,unknowns,method,tolerance,runs,failures,median_seconds,median_closure,\
         median_values,median_derivatives\n",
    );
    for cell in cells {
        let problem = &problems[cell.problem];
        let _complete = writeln!(
            text,
            "{},{},{},{},{:e},{},{},{},{:e},{},{}",
            problem.sheet,
            problem.symmetric,
            problem.unknowns(),
            cell.method.name().replace(',', ""),
            cell.tolerance,
            cell.runs,
            cell.failures,
            cell.seconds
                .map_or(String::new(), |seconds| format!("{seconds:e}")),
            cell.closure,
            cell.values,
            cell.derivatives,
        );
    }
    text
}

fn paths_csv(cells: &[PathCell]) -> String {
    let mut text = String::from(
        "sheet,symmetric,route,bound,plans,median_seconds,outcome,knots,closure,deformation,gap,certified_deformation,\
         goal_error_degrees,unknowns,iterations,evaluations\n",
    );
    for cell in cells {
        let plan = &cell.plan;
        let _complete = writeln!(
            text,
            "{},{},{},{:e},{},{:e},{},{},{:e},{:e},{:e},{},{:e},{},{},{}",
            cell.sheet,
            cell.symmetric,
            cell.route.name().replace(',', ""),
            cell.bound,
            cell.plans,
            cell.seconds,
            plan.outcome.name(),
            plan.knots().len(),
            plan.errors.closure,
            plan.errors.rigidity.deformation,
            plan.errors.rigidity.gap,
            plan.certified_deformation()
                .map_or(String::new(), |c| format!("{c:e}")),
            plan.arrival.error.to_degrees(),
            plan.reduced.groups,
            plan.effort.iterations,
            plan.effort.evaluations,
        );
    }
    text
}

fn lines(problem: usize, cells: &[Cell]) -> Vec<Line> {
    let line = |method: Method| {
        let of_line = cells
            .iter()
            .filter(|c| c.problem == problem && c.method == method);
        Line {
            name: method.name().into(),
            thick: method.is_ours(),
            points: of_line
                .filter_map(|c| Some((c.closure, c.seconds?)))
                .collect(),
        }
    };
    Method::ALL.into_iter().map(line).collect()
}

fn path_lines(cells: &[PathCell]) -> Vec<Line> {
    let mut names: Vec<String> = cells.iter().map(PathCell::name).collect();
    names.dedup();
    let line = |name: &String| {
        let of_line = cells
            .iter()
            .filter(|c| &c.name() == name && c.route == Route::Motion && c.is_planned());
        Line {
            name: name.clone(),
            thick: name.ends_with("groups"),
            points: of_line
                .filter_map(|c| Some((c.plan.certified_deformation()?, c.seconds)))
                .collect(),
        }
    };
    names.iter().map(line).collect()
}
