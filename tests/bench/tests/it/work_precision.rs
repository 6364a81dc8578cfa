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
