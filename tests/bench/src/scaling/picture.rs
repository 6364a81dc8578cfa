//! Plot of time and memory against hinges, both logarithmic.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::measure::Measured;

type Problem = DrawingAreaErrorKind<std::io::Error>;
type Points = Vec<(f64, f64)>;

/// Returns two panels, one for time and one for memory, each with both series, as SVG.
#[must_use]
pub(super) fn picture(groups: &[Measured], each: &[Measured]) -> String {
    let mut svg = String::new();
    draw(&mut svg, groups, each).expect("room for a picture");
    svg
}

fn draw(svg: &mut String, groups: &[Measured], each: &[Measured]) -> Result<(), Problem> {
    let area = SVGBackend::with_string(svg, (1400, 640)).into_drawing_area();
    area.fill(&WHITE)?;
    let (left, right) = area.split_horizontally(700);
    let series = |y: fn(&Measured) -> f64| {
        [groups, each]
            .map(|points| -> Points { points.iter().map(|p| (p.number("hinges"), y(p))).collect() })
    };
    panel(
        &left,
        "time of a plan",
        "seconds",
        series(|p| p.number("total")),
    )?;
    let mebibytes = series(|p| p.memory() / f64::from(1 << 20));
    panel(&right, "peak of memory", "MiB", mebibytes)?;
    area.present()
}

fn panel(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    title: &str,
    unit: &str,
    series: [Points; 2],
) -> Result<(), Problem> {
    const FONT: &str = "sans-serif";
    let range = |value: fn(&(f64, f64)) -> f64| {
        let values = || series.iter().flatten().map(value).filter(|y| *y > 0.0);
        let low = values().fold(f64::INFINITY, f64::min).log10().floor();
        let high = values().fold(0.0, f64::max).log10().ceil();
        10_f64.powf(low)..10_f64.powf(high)
    };
    let mut chart = ChartBuilder::on(area)
        .caption(title, (FONT, 26))
        .margin(20)
        .margin_right(40)
        .x_label_area_size(60)
        .y_label_area_size(90)
        .build_cartesian_2d(range(|p| p.0).log_scale(), range(|p| p.1).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc("hinges")
        .x_label_formatter(&|hinges| format!("{hinges:.0}"))
        .y_desc(unit)
        .label_style((FONT, 20))
        .axis_desc_style((FONT, 22))
        .draw()?;
    let named = [("crease groups", BLUE), ("every crease on its own", RED)];
    for ((name, colour), points) in named.into_iter().zip(&series) {
        chart
            .draw_series(LineSeries::new(
                points.iter().copied(),
                colour.stroke_width(2),
            ))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], colour.stroke_width(2)));
        chart.draw_series(points.iter().map(|p| Circle::new(*p, 5, colour.filled())))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .label_font((FONT, 20))
        .border_style(BLACK)
        .background_style(WHITE)
        .draw()?;
    Ok(())
}
