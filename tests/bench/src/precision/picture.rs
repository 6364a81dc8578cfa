//! Plots of run time against error, both logarithmic, with one line a method.

use plotters::prelude::*;

/// One line: pairs of error and seconds.
pub(super) struct Line {
    pub(super) name: String,
    pub(super) thick: bool,
    pub(super) points: Vec<(f64, f64)>,
}

const FONT: &str = "sans-serif";
/// Smaller errors, which are rounding, are drawn at this value.
const LEAST_ERROR: f64 = 1e-16;

/// Returns the plot as SVG, without empty lines.
pub(super) fn svg(title: &str, error: &str, lines: &[Line]) -> String {
    let mut text = String::new();
    draw(&mut text, title, error, lines).expect("room for a picture");
    text
}

fn draw(
    text: &mut String,
    title: &str,
    error: &str,
    lines: &[Line],
) -> Result<(), DrawingAreaErrorKind<std::io::Error>> {
    let seconds = lines
        .iter()
        .flat_map(|line| line.points.iter().map(|p| p.1));
    let (low, high) = seconds.fold((f64::MAX, f64::MIN_POSITIVE), |(low, high), s| {
        (low.min(s), high.max(s))
    });
    let area = SVGBackend::with_string(text, (1000, 640)).into_drawing_area();
    area.fill(&WHITE)?;
    let (plot, legend) = area.split_horizontally(740);
    let mut chart = ChartBuilder::on(&plot)
        .caption(title, (FONT, 22))
        .margin(15)
        .x_label_area_size(55)
        .y_label_area_size(80)
        .build_cartesian_2d(
            (LEAST_ERROR..1.0).log_scale(),
            (0.7 * low.min(high)..1.5 * high).log_scale(),
        )?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc(error)
        .y_desc("seconds")
        .x_labels(9)
        .x_label_formatter(&|x| format!("{x:.0e}"))
        .y_label_formatter(&|y| format!("{y:.0e}"))
        .label_style((FONT, 16))
        .axis_desc_style((FONT, 18))
        .draw()?;
    for (index, line) in lines
        .iter()
        .enumerate()
        .filter(|(_, l)| !l.points.is_empty())
    {
        let colour = Palette99::pick(index);
        let width = if line.thick { 4 } else { 2 };
        let points = line
            .points
            .iter()
            .map(|&(x, y)| (x.clamp(LEAST_ERROR, 1.0), y));
        let style = colour.stroke_width(width);
        chart.draw_series(LineSeries::new(points.clone(), style))?;
        chart.draw_series(points.map(|p| Circle::new(p, width, colour.filled())))?;
        let y = 60 + 26 * i32::try_from(index).unwrap_or(0);
        legend.draw(&PathElement::new(vec![(5, y), (35, y)], style))?;
        let name = line.name.clone();
        legend.draw(&Text::new(name, (42, y - 8), (FONT, 16).into_font()))?;
    }
    area.present()
}
