//! Time of whole plans against the number of faces: Miura sheets from flat to 170 degrees, certified and free of
//! crossings over the whole motion (at their knots where there are too many faces for that), without reading
//! and writing.
//!
//! `cargo bench -p foldpath --bench scaling` goes to 160,000 faces; `-- large` to a million. Prints a
//! table and the exponent, and with `-- plot FILE.svg` draws both.

use core::fmt::Write;

use foldpath::generate::Miura;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, Outcome, Plan, PlanOptions, plan};

/// Faces and seconds.
type Point = (f64, f64);

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if !arguments.iter().any(|argument| argument == "--bench") {
        return;
    }
    println!("medians of whole plans without reading and writing, seconds\n");
    println!(
        "| faces | free of crossings | symmetry | solve | place | fold | collision | total | certified deformation | runs |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let mut sizes = vec![(50, 15), (100, 9), (200, 5), (400, 3)];
    if arguments.iter().any(|argument| argument == "large") {
        sizes.push((1000, 1));
    }
    let points: Vec<Point> = sizes.into_iter().map(|(n, runs)| run(n, runs)).collect();
    let (slope, height) = fit(&points);
    println!("\ntime grows as faces^{slope:.2}");
    let file = arguments
        .iter()
        .skip_while(|argument| *argument != "plot")
        .nth(1);
    if let Some(file) = file {
        std::fs::write(file, picture(&points, slope, height)).expect("a file to write");
        println!("plot written to {file}");
    }
}

/// Plans a sheet so many times.
fn run(size: usize, runs: usize) -> Point {
    let miura = Miura {
        rows: size,
        columns: size,
        sector_angle: 60_f64.to_radians(),
        fold: 170.0 / 180.0,
    };
    let pattern = CreasePattern::new(miura.drawing().expect("a sheet")).expect("a pattern");
    let goal = Goal::of_pattern(&pattern).expect("a goal");
    let options = PlanOptions {
        keep_vertices: false,
        ..PlanOptions::default()
    };
    let plans: Vec<Plan> = (0..runs).map(|_| plan(&pattern, &goal, &options)).collect();
    assert!(plans.iter().all(|plan| plan.outcome == Outcome::Planned));
    let median = |stage: fn(&Plan) -> core::time::Duration| {
        let mut times: Vec<_> = plans.iter().map(stage).collect();
        times.sort_unstable();
        times[runs / 2].as_secs_f64()
    };
    let total = median(|p| {
        let times = p.times;
        times.symmetry + times.solve + times.place + times.fold + times.collision
    });
    println!(
        "| {} | {} | {:.4} | {:.5} | {:.4} | {:.4} | {:.4} | {total:.4} | {:.1e} | {runs} |",
        pattern.faces().len(),
        plans[0].clearance.map_or("at knots", |_| "everywhere"),
        median(|p| p.times.symmetry),
        median(|p| p.times.solve),
        median(|p| p.times.place),
        median(|p| p.times.fold),
        median(|p| p.times.collision),
        plans[0].certified_deformation.unwrap_or(f64::NAN),
    );
    #[allow(clippy::cast_precision_loss, reason = "a million faces")]
    let faces = pattern.faces().len() as f64;
    (faces, total)
}

/// Least-squares line of ln y over ln x: slope and height at 0.
fn fit(points: &[Point]) -> (f64, f64) {
    let sum = |term: fn(f64, f64) -> f64| -> f64 {
        let terms = points.iter().map(|(x, y)| term(x.ln(), y.ln()));
        terms.sum()
    };
    let n = sum(|_, _| 1.0);
    let (x, y) = (sum(|x, _| x), sum(|_, y| y));
    let slope = (n * sum(|x, y| x * y) - x * y) / (n * sum(|x, _| x * x) - x * x);
    (slope, (y - slope * x) / n)
}

/// Both logarithmic, with the line fitted.
fn picture(points: &[Point], slope: f64, height: f64) -> String {
    let place = |(faces, seconds): Point| {
        let (x, y) = (faces.log10() - 3.0, seconds.log10() + 3.0);
        (70.0 + 150.0 * x, 330.0 - 60.0 * y)
    };
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 560 390\" font-family=\"sans-serif\" \
         font-size=\"13\">\n<rect width=\"560\" height=\"390\" fill=\"white\"/>\n",
    );
    let mut line = |from: (f64, f64), to: (f64, f64), colour: &str| {
        let _infallible = writeln!(
            svg,
            "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"{colour}\"/>",
            from.0, from.1, to.0, to.1
        );
    };
    for decade in 0..6 {
        let y = 330.0 - 60.0 * f64::from(decade);
        line((70.0, y), (520.0, y), "#ddd");
    }
    for decade in 0..4 {
        let x = 70.0 + 150.0 * f64::from(decade);
        line((x, 30.0), (x, 330.0), "#ddd");
    }
    let on_line = |faces: f64| place((faces, (height + slope * faces.ln()).exp()));
    let ends = [points.first(), points.last()].map(|p| p.map_or(1.0, |p| p.0));
    line(on_line(ends[0]), on_line(ends[1]), "#c33");
    let mut text = |x: f64, y: f64, words: &str| {
        let _infallible = writeln!(
            svg,
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"middle\">{words}</text>"
        );
    };
    for (decade, words) in ["1,000", "10,000", "100,000", "1,000,000"]
        .into_iter()
        .enumerate()
    {
        text(70.0 + 150.0 * decade as f64, 350.0, words);
    }
    for (decade, words) in ["1 ms", "10 ms", "0.1 s", "1 s", "10 s", "100 s"]
        .into_iter()
        .enumerate()
    {
        text(40.0, 334.0 - 60.0 * decade as f64, words);
    }
    text(295.0, 375.0, "faces");
    text(
        295.0,
        20.0,
        &format!("whole plan of a Miura sheet: faces^{slope:.2}"),
    );
    for point in points {
        let (x, y) = place(*point);
        let _infallible = writeln!(
            svg,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"#246\"/>"
        );
    }
    svg + "</svg>\n"
}
