//! Plots of curves in panels.

use core::ops::Range;

use plotters::prelude::*;

/// A pair of coordinates.
pub(super) type Point = (f64, f64);

/// A curve of a panel.
pub(super) struct Curve {
    /// Name in the legend; a curve without a name is not in the legend.
    pub(super) name: Option<String>,
    /// Index of the colour.
    pub(super) colour: usize,
    pub(super) points: Vec<Point>,
}

/// A panel of a plot.
pub(super) struct Panel {
    pub(super) title: String,
    /// Labels of the horizontal and of the vertical axis.
    pub(super) labels: [&'static str; 2],
    pub(super) curves: Vec<Curve>,
    /// `true` if the vertical axis is logarithmic.
    pub(super) powers: bool,
}

const SIZE: (u32, u32) = (640, 400);
const FONT: &str = "sans-serif";
const COLOURS: [RGBColor; 4] = [
    RGBColor(0x1f, 0x55, 0xb4),
    RGBColor(0xd9, 0x5f, 0x02),
    RGBColor(0x1b, 0x8a, 0x5a),
    RGBColor(0x8a, 0x3f, 0xa0),
];
/// On a logarithmic axis smaller numbers are drawn at this value.
const LEAST: f64 = 1e-17;

type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// Returns the panels in rows of `columns`, as SVG.
pub(super) fn svg(panels: &[Panel], columns: usize) -> String {
    let mut text = String::new();
    let rows = panels.len().div_ceil(columns);
    // Writing to memory cannot fail.
    let _complete = draw(panels, [rows, columns], &mut text);
    text
}

fn draw(panels: &[Panel], [rows, columns]: [usize; 2], text: &mut String) -> Drawn {
    let [width, height] = [(SIZE.0, columns), (SIZE.1, rows)]
        .map(|(size, count)| size * u32::try_from(count).unwrap_or(1));
    let root = SVGBackend::with_string(text, (width, height)).into_drawing_area();
    root.fill(&WHITE)?;
    for (area, panel) in root.split_evenly((rows, columns)).iter().zip(panels) {
        let up = |y: f64| {
            if panel.powers {
                y.max(LEAST).log10()
            } else {
                y
            }
        };
        let points = || panel.curves.iter().flat_map(|curve| &curve.points);
        let mut chart = ChartBuilder::on(area)
            .caption(&panel.title, (FONT, 18))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(70)
            .build_cartesian_2d(
                range(points().map(|p| p.0)),
                range(points().map(|p| up(p.1))),
            )?;
        let power = |y: &f64| {
            if (y - y.round()).abs() < 1e-9 {
                format!("1e{y:.0}")
            } else {
                String::new()
            }
        };
        let plain = |y: &f64| format!("{y}");
        let mut mesh = chart.configure_mesh();
        if panel.powers {
            mesh.y_label_formatter(&power);
        } else if points().all(|p| p.1.abs() < 1e4) {
            mesh.y_label_formatter(&plain);
        }
        mesh.light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc(panel.labels[0])
            .y_desc(panel.labels[1])
            .label_style((FONT, 13))
            .axis_desc_style((FONT, 14))
            .draw()?;
        for curve in &panel.curves {
            let colour = COLOURS[curve.colour % COLOURS.len()];
            let points = curve.points.iter().map(|&(x, y)| (x, up(y)));
            let drawn = chart.draw_series(LineSeries::new(points, colour.stroke_width(2)))?;
            if let Some(name) = &curve.name {
                let mark =
                    move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2));
                drawn.label(name).legend(mark);
            }
        }
        if panel.curves.iter().any(|curve| curve.name.is_some()) {
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperLeft)
                .background_style(WHITE.mix(0.85))
                .border_style(BLACK.mix(0.3))
                .label_font((FONT, 13))
                .draw()?;
        }
    }
    root.present()
}

/// Returns a range that holds all finite numbers and is never empty.
fn range(numbers: impl Iterator<Item = f64>) -> Range<f64> {
    let finite = numbers.filter(|x| x.is_finite());
    let [low, high] = finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
        [low.min(x), high.max(x)]
    });
    if low > high {
        return 0.0..1.0;
    }
    let margin = if high > low { 0.02 * (high - low) } else { 0.5 };
    low - margin..high + margin
}
