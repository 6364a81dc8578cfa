//! The tables of section `work-precision`, as Markdown.

use super::{Cell, Method, PathCell, Problem, Route, measure::median, residuals_by_iteration};

/// Exponents of the tolerances in the tables; the CSV file has all tolerances.
const SHOWN: [i32; 6] = [1, 2, 4, 6, 9, 12];
/// Number of iterations in the table.
const ITERATIONS: usize = 10;

fn find(cells: &[Cell], problem: usize, method: Method, tolerance: f64) -> Option<&Cell> {
    let same = |c: &&Cell| {
        c.problem == problem && c.method == method && c.tolerance.total_cmp(&tolerance).is_eq()
    };
    cells.iter().find(same)
}

fn seconds(cells: &[Cell], problem: usize, method: Method, tolerance: f64) -> Option<f64> {
    find(cells, problem, method, tolerance)?.seconds
}

/// Returns the fastest peer that reaches the tolerance, and its seconds.
fn best_peer(cells: &[Cell], problem: usize, tolerance: f64) -> Option<(Method, f64)> {
    let peers = Method::ALL.into_iter().filter(|method| !method.is_ours());
    let times = peers.filter_map(|m| Some((m, seconds(cells, problem, m, tolerance)?)));
    times.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Formats seconds with a unit.
pub(super) fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1e-4 => format!("{:.2} µs", 1e6 * s),
        s if s < 1e-1 => format!("{:.2} ms", 1e3 * s),
        s => format!("{s:.2} s"),
    }
}

fn or_dash(value: Option<String>) -> String {
    value.unwrap_or_else(|| "-".into())
}

fn row(cells: impl IntoIterator<Item = String>) -> String {
    let cells: Vec<String> = cells.into_iter().collect();
    format!("| {} |\n", cells.join(" | "))
}

fn head(cells: impl IntoIterator<Item = String>) -> String {
    let cells: Vec<String> = cells.into_iter().collect();
    let rule = cells.iter().map(|_| "---".to_owned()).collect::<Vec<_>>();
    row(cells) + &row(rule)
}

/// The method of foldpath that peers are compared with.
const OURS: Method = Method::LmF64;

/// Returns the table of a method's times, the closure that it reaches, and the growth of its time with precision.
pub(super) fn times(problems: &[Problem], cells: &[Cell], method: Method) -> String {
    let times = SHOWN.map(|power| format!("to 1e-{power}"));
    let mut table = head(
        ["problem", "unknowns", "folded by, rad"]
            .map(String::from)
            .into_iter()
            .chain(times)
            .chain(["closure at 1e-12", "1e-12 over 1e-2", "failures"].map(String::from)),
    );
    for (index, problem) in problems.iter().enumerate() {
        let at = |power: i32| find(cells, index, method, 10_f64.powi(-power));
        let seconds = |power: i32| at(power)?.seconds;
        let growth = seconds(12)
            .zip(seconds(2))
            .map(|(fine, coarse)| fine / coarse);
        let of_problem = cells
            .iter()
            .filter(|c| c.problem == index && c.method == method);
        let (failures, runs) = of_problem.fold((0, 0), |(f, r), c| (f + c.failures, r + c.runs));
        let name = [
            problem.name(),
            problem.unknowns().to_string(),
            format!("{:.2}", problem.folded()),
        ];
        let times = SHOWN.map(|power| or_dash(seconds(power).map(time)));
        let rest = [
            or_dash(at(12).map(|cell| format!("{:.1e}", cell.closure))),
            or_dash(growth.map(|growth| format!("{growth:.2}"))),
            format!("{failures} of {runs}"),
        ];
        table += &row(name.into_iter().chain(times).chain(rest));
    }
    table
}

/// Returns the table of the fastest peer's time over foldpath's.
pub(super) fn ratios(problems: &[Problem], cells: &[Cell], tolerances: &[f64]) -> String {
    let columns = tolerances
        .iter()
        .map(|tolerance| format!("{tolerance:.0e}"));
    let ends = ["problem"].map(String::from).into_iter();
    let mut table = head(ends.chain(columns).chain(["fastest peers".into()]));
    for (index, problem) in problems.iter().enumerate() {
        let mut peers: Vec<&str> = Vec::new();
        let ratios: Vec<String> = tolerances
            .iter()
            .map(|&tolerance| {
                let best = best_peer(cells, index, tolerance);
                if let Some((peer, _)) = best.filter(|(peer, _)| !peers.contains(&peer.name())) {
                    peers.push(peer.name());
                }
                match (seconds(cells, index, OURS, tolerance), best) {
                    (Some(ours), Some((_, theirs))) => format!("{:.3}", theirs / ours)
                        .chars()
                        .take(5)
                        .collect::<String>()
                        .trim_end_matches('.')
                        .into(),
                    (Some(_), None) => "alone".into(),
                    (None, Some(_)) => "theirs".into(),
                    (None, None) => "-".into(),
                }
            })
            .collect();
        let name = [problem.name()].into_iter();
        table += &row(name.chain(ratios).chain([peers.join(", ")]));
    }
    table
}

/// Lists the problems and tolerances at which a peer is not slower.
pub(super) fn behind(problems: &[Problem], cells: &[Cell], tolerances: &[f64]) -> String {
    let mut places = Vec::new();
    for (index, problem) in problems.iter().enumerate() {
        for &tolerance in tolerances {
            let Some((peer, theirs)) = best_peer(cells, index, tolerance) else {
                continue;
            };
            let ours = seconds(cells, index, OURS, tolerance);
            if ours.is_none_or(|ours| ours >= theirs) {
                let words = |ours: Option<f64>| ours.map_or("does not reach it".into(), time);
                let gradient = seconds(cells, index, Method::GradientF64, tolerance);
                places.push(format!(
                    "- {} at {tolerance:.0e}: {} {}, foldpath {}, its gradient solver {}",
                    problem.name(),
                    peer.name(),
                    time(theirs),
                    words(ours),
                    words(gradient),
                ));
            }
        }
    }
    let all = problems.len() * tolerances.len();
    if places.is_empty() {
        return format!(
            "{} is ahead of every peer in all {all} cells.\n",
            OURS.name()
        );
    }
    let behind = places.len();
    format!(
        "{} is not ahead in {behind} of {all} cells:\n\n{}\n",
        OURS.name(),
        places.join("\n")
    )
}

/// Returns the table of the number of problems on which each method reaches a tolerance, among those on which it was
/// tried, and of its median time over foldpath's.
pub(super) fn reach(problems: &[Problem], cells: &[Cell]) -> String {
    let columns = SHOWN.map(|power| format!("1e-{power}"));
    let mut table = head(["method".into()].into_iter().chain(columns));
    for method in Method::ALL {
        let tried = (0..problems.len()).filter(|&p| find(cells, p, method, 1e-1).is_some());
        let tried: Vec<usize> = tried.collect();
        let columns = SHOWN.map(|power| {
            let tolerance = 10_f64.powi(-power);
            let ratio = |&p: &usize| {
                let theirs = seconds(cells, p, method, tolerance)?;
                let ours = seconds(cells, p, OURS, tolerance);
                Some(theirs / ours.unwrap_or(f64::NAN))
            };
            let ratios: Vec<f64> = tried.iter().filter_map(ratio).collect();
            let reached = format!("{} of {}", ratios.len(), tried.len());
            if ratios.is_empty() {
                reached
            } else {
                format!("{reached}, {:.1}x", median(ratios))
            }
        });
        table += &row([method.name().into()].into_iter().chain(columns));
    }
    table
}

/// Returns the table of residuals after each iteration, from the first start of each problem.
pub(super) fn iterations(problems: &[Problem]) -> String {
    let columns = (0..=ITERATIONS).map(|k| {
        if k == 0 {
            "start".into()
        } else {
            k.to_string()
        }
    });
    let mut table = head(["problem".into()].into_iter().chain(columns));
    for problem in problems {
        let starts = problem.starts(1);
        let residuals = residuals_by_iteration(problem.stars(), &starts[0]);
        let shown = (0..=ITERATIONS).map(|k| {
            let residual = residuals.get(k).map(|residual| format!("{residual:.0e}"));
            residual.unwrap_or_default()
        });
        table += &row([problem.name()].into_iter().chain(shown));
    }
    table
}

/// Returns the table of paths along the motion at some bounds.
pub(super) fn paths(cells: &[PathCell]) -> String {
    let mut table = head(
        [
            "sheet",
            "bound",
            "time",
            "knots",
            "closure",
            "deformation",
            "certified",
            "goal error, degrees",
            "answer",
        ]
        .map(String::from),
    );
    let shown = |cell: &&PathCell| {
        let powers = [1, 2, 4, 6, 8, 10, 12];
        let bound = |power: &i32| 10_f64.powi(-power).total_cmp(&cell.bound).is_eq();
        cell.route == Route::Motion && powers.iter().any(bound)
    };
    for cell in cells.iter().filter(shown) {
        let plan = &cell.plan;
        let certified = plan.certified_deformation().map(|c| format!("{c:.1e}"));
        table += &row([
            cell.name(),
            format!("{:.0e}", cell.bound),
            time(cell.seconds),
            plan.knots().len().to_string(),
            format!("{:.1e}", plan.errors.closure),
            format!("{:.1e}", plan.errors.rigidity.deformation),
            or_dash(certified),
            format!("{:.1e}", plan.arrival.error.to_degrees()),
            plan.outcome.name().into(),
        ]);
    }
    table
}

/// Returns the table of the finest bound planned for each sheet and route, and of the time at that bound over the time
/// at 1e-2.
pub(super) fn routes(cells: &[PathCell]) -> String {
    let mut table = head(
        [
            "sheet",
            "route",
            "finest bound planned",
            "time there",
            "over the time at 1e-2",
        ]
        .map(String::from),
    );
    let mut names: Vec<String> = cells.iter().map(PathCell::name).collect();
    names.dedup();
    for name in names {
        for route in Route::ALL {
            let mut of_route = cells
                .iter()
                .filter(|c| c.name() == name && c.route == route && c.is_planned());
            let coarse = of_route.clone().find(|c| c.bound.total_cmp(&1e-2).is_eq());
            let finest = of_route.by_ref().min_by(|a, b| a.bound.total_cmp(&b.bound));
            let ratio = finest
                .zip(coarse)
                .map(|(f, c)| format!("{:.2}", f.seconds / c.seconds));
            table += &row([
                name.clone(),
                route.name().into(),
                or_dash(finest.map(|cell| format!("{:.0e}", cell.bound))),
                or_dash(finest.map(|cell| time(cell.seconds))),
                or_dash(ratio),
            ]);
        }
    }
    table
}
