//! Does the short form of the benchmark run, and do its claims hold?

use std::fs;

use foldpath_bench::precision::{
    Family, Form, Method, Problem, residuals_by_iteration, tolerances, write,
};

#[test]
fn the_short_form_writes_its_section_and_files() {
    let results = tempfile::tempdir().unwrap();
    let markdown = write(Form::Short, results.path(), "results").unwrap();
    for method in Method::ALL {
        assert!(
            markdown.contains(&format!("| {} |", method.name())),
            "{}",
            method.name()
        );
    }
    // Every linked file exists.
    let links = markdown.split("](results/").skip(1);
    let files: Vec<&str> = links.filter_map(|link| link.split(')').next()).collect();
    assert!(files.len() >= 6, "{files:?}");
    for file in files {
        assert!(results.path().join(file).is_file(), "{file}");
    }
    let csv = fs::read_to_string(results.path().join("work-precision.csv")).unwrap();
    let ours = csv
        .lines()
        .filter(|line| line.contains(Method::LmF64.name()));
    let ours: Vec<Vec<&str>> = ours.map(|line| line.split(',').collect()).collect();
    // Four problems, all tolerances, no failure, and a time.
    assert_eq!(ours.len(), 4 * tolerances().len());
    for cells in ours {
        assert_eq!(cells[6], "0", "{cells:?}");
        assert!(cells[7].parse::<f64>().unwrap() > 0.0);
        let [asked, reached] = [4, 8].map(|cell| cells[cell].parse::<f64>().unwrap());
        assert!(reached <= asked, "{cells:?}");
    }
}

/// From a residual of 1e-2 on, each iteration gains at least half as many digits again, and three iterations suffice
/// for 1e-14. A method of first order would take ten times as many.
#[test]
fn levenberg_marquardt_converges_quadratically() {
    for (family, rows, columns, symmetric) in [
        (Family::Miura, 3, 3, true),
        (Family::Miura, 3, 3, false),
        (Family::Miura, 11, 11, false),
        (Family::Waterbomb, 4, 6, true),
    ] {
        let problem = Problem::new(family, rows, columns, symmetric);
        for start in problem.starts(10) {
            let residuals = residuals_by_iteration(problem.stars(), &start);
            assert!(residuals.last().unwrap() <= &1e-14, "{residuals:?}");
            let near = residuals.iter().position(|&r| r <= 1e-2).unwrap();
            assert!(residuals.len() - 1 - near <= 3, "{residuals:?}");
            for pair in residuals[near..].windows(2) {
                let enough = pair[0].powf(1.5).max(1e-14);
                assert!(pair[1] <= enough, "{residuals:?}");
            }
        }
    }
}

/// A large sheet comes near closure in hardly more iterations than a small one: the damping does not grow with the
/// sheet.
#[test]
fn large_sheets_take_no_more_iterations() {
    for family in [Family::Miura, Family::Yoshimura] {
        let [small, large] = [3, 24].map(|size| {
            let problem = Problem::new(family, size, size, false);
            let near = problem.starts(5).into_iter().map(|start| {
                let residuals = residuals_by_iteration(problem.stars(), &start);
                residuals.iter().position(|&r| r <= 1e-2).unwrap()
            });
            near.max().unwrap()
        });
        assert!(large <= small + 1, "{}: {small}, {large}", family.name());
    }
}

/// A hinge that its limit stops at half a turn costs hardly an iteration, because the step of the other hinges takes
/// the stop into account.
#[test]
fn hinges_at_their_limits_cost_no_iterations() {
    let problem = Problem::new(Family::Quad, 11, 11, false);
    assert!(problem.folded() >= core::f64::consts::PI - 1e-9);
    for start in problem.starts(10) {
        let residuals = residuals_by_iteration(problem.stars(), &start);
        assert!(residuals.len() - 1 <= 9, "{residuals:?}");
    }
}

/// Random angles lead to no folded configuration of a large quad sheet. Folding a configuration near flat further does,
/// and sheets near it close.
#[test]
fn the_large_quad_sheet_folds() {
    let problem = Problem::new(Family::Quad, 24, 24, false);
    assert!(problem.folded() >= 1.0, "{}", problem.folded());
    for start in problem.starts(3) {
        let residuals = residuals_by_iteration(problem.stars(), &start);
        assert!(residuals.last().unwrap() <= &1e-14, "{residuals:?}");
    }
}

/// Peers and foldpath's solvers minimise the same objective. One closure function judges all results, and the returned
/// configurations close as reported.
#[test]
fn what_a_method_returns_closes() {
    let problem = Problem::new(Family::Miura, 3, 3, false);
    let limit = core::time::Duration::from_millis(500);
    let start = &problem.starts(1)[0];
    assert!(problem.closure(start) > 0.05);
    let mut reached = 0;
    for method in Method::ALL {
        let run = method.solver(&problem).run(start, 1e-1, limit);
        assert!(run.values + run.derivatives > 0, "{}", method.name());
        assert!(run.x.len() == problem.unknowns());
        reached += usize::from(problem.closure(&run.x) <= 1e-1);
    }
    assert!(reached >= 12, "{reached} of {}", Method::ALL.len());
}
