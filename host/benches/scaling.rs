//! Time of whole plans against the number of faces: Miura sheets from flat to 170 degrees, certified and free of
//! crossings over the whole motion (at their knots where there are too many faces for that), without reading
//! and writing.
//!
//! `cargo bench -p foldpath --bench scaling` goes to 160,000 faces; `-- large` to a million. Prints a
//! table and the exponent, and with `-- plot FILE.svg` draws both.

use foldpath::generate::Miura;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, Outcome, Plan, PlanOptions, plan};
use plotters::prelude::*;

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
    let mut svg = String::new();
    draw(&mut svg, points, slope, height).expect("room for a picture");
    svg
}

fn draw(
    svg: &mut String,
    points: &[Point],
    slope: f64,
    height: f64,
) -> Result<(), DrawingAreaErrorKind<std::io::Error>> {
    const FONT: &str = "sans-serif";
    let area = SVGBackend::with_string(svg, (1120, 780)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(
            format!("whole plan of a Miura sheet: faces^{slope:.2}"),
            (FONT, 28),
        )
        .margin(20)
        .margin_right(80)
        .x_label_area_size(70)
        .y_label_area_size(110)
        .build_cartesian_2d((1e3..1e6).log_scale(), (1e-3..100.0).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc("faces")
        .x_label_formatter(&|faces| format!("{faces:.0}"))
        .y_desc("seconds")
        .label_style((FONT, 24))
        .axis_desc_style((FONT, 26))
        .draw()?;
    let ends = [points.first(), points.last()].into_iter().flatten();
    let fitted = ends.map(|(faces, _)| (*faces, (height + slope * faces.ln()).exp()));
    chart.draw_series(LineSeries::new(fitted, RED.stroke_width(3)))?;
    chart.draw_series(
        points
            .iter()
            .map(|point| Circle::new(*point, 8, BLUE.filled())),
    )?;
    area.present()
}
