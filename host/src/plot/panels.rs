//! Draws the panels of a plot with plotters.

use core::ops::Range;
use std::collections::HashSet;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::curves::{Curves, Point};
use crate::colours;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<'b, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// Returns the colour of a crease group.
fn of_group(index: usize) -> RGBColor {
    let [red, green, blue] = colours::of_group(index);
    RGBColor(red, green, blue)
}

/// Width of the picture and height of a panel, pixels. plotters rounds coordinates to pixels, so a large picture is
/// finer.
const WIDTH: u32 = 1600;
const HEIGHT: u32 = 560;
const FONT: &str = "sans-serif";
/// Largest number of curves named in the legend, and of knots marked.
const NAMED: usize = 12;
const MOST_KNOTS: usize = 200;
/// Smallest power of ten that is drawn for errors: smaller errors are rounding.
const LEAST_POWER: f64 = -17.0;
/// Largest number that is drawn; larger numbers are drawn at the border, as a file may contain any number.
const LARGEST: f64 = 1e9;

/// Draws the curves of a path as an SVG picture.
#[must_use]
pub fn svg(curves: &Curves) -> String {
    let mut text = String::new();
    // Writing to memory cannot fail.
    let _complete = draw(curves, &mut text);
    text
}

fn draw(curves: &Curves, text: &mut String) -> Drawn {
    let usual = [angles, measured, errors, clearance].into_iter();
    let more = (!curves.torques.is_empty()).then_some(torques as fn(&Curves, &Area<'_>) -> Drawn);
    let draw: Vec<_> = usual.chain(more).collect();
    #[allow(clippy::cast_possible_truncation, reason = "four or five panels")]
    let height = draw.len() as u32 * HEIGHT;
    let root = SVGBackend::with_string(text, (WIDTH, height)).into_drawing_area();
    root.fill(&WHITE)?;
    let panels = root.split_evenly((draw.len(), 1));
    for (panel, draw) in panels.iter().zip(draw) {
        draw(curves, panel)?;
    }
    root.present()
}

/// Draws the fold angles of the groups.
fn angles(curves: &Curves, area: &Area<'_>) -> Drawn {
    let [drawn, count] = [curves.angles.len(), curves.count];
    let what = if curves.grouped {
        "crease groups"
    } else {
        "creases"
    };
    let title = curves.title.replace(char::is_control, " ");
    let caption = if drawn < count {
        format!("{title}: fold angles of {drawn} of {count} {what}")
    } else {
        format!("{title}: fold angles of {count} {what}")
    };
    let degrees = range(curves.angles.iter().flatten().map(|p| p.1));
    let mut chart = against_time(curves, area, &caption, "fold angle, degrees", degrees)?;
    for (index, curve) in curves.angles.iter().enumerate() {
        let name = (count > 1 && index < NAMED).then(|| index.to_string());
        line(&mut chart, curve, of_group(index), name)?;
    }
    legend(&mut chart, SeriesLabelPosition::UpperLeft)
}

/// Draws the measured against the assigned fold angles.
fn measured(curves: &Curves, area: &Area<'_>) -> Drawn {
    let differences = curves.measured.iter().map(|(a, b)| (a - b).abs());
    let most = differences.fold(0.0, f64::max);
    let caption = format!(
        "fold angles at the knots, virtual edges among them: measured and assigned differ by {most:.1e} degrees \
         at most"
    );
    let degrees = || range(curves.measured.iter().flat_map(|&(a, b)| [a, b]));
    let assigned = "fold angle assigned, degrees";
    let labels = [assigned, "fold angle measured, degrees"];
    let mut chart = chart(area, &caption, labels, [degrees(), degrees()], None)?;
    let Range { start, end } = degrees();
    let equal = LineSeries::new([(start, start), (end, end)], BLACK.mix(0.3));
    chart.draw_series(equal)?;
    // Points that the eye cannot distinguish are drawn once.
    let half_degrees = |angle: f64| (2.0 * angle).round().to_bits();
    let mut drawn = HashSet::new();
    let points = drawable(&curves.measured);
    let points = points.filter(|(a, b)| drawn.insert([*a, *b].map(half_degrees)));
    let points: Vec<_> = points.collect();
    let colour = of_group(0).filled();
    chart.draw_series(points.into_iter().map(|p| Circle::new(p, 5, colour)))?;
    Ok(())
}

/// Draws deformation and gap, and the bound on both.
fn errors(curves: &Curves, area: &Area<'_>) -> Drawn {
    let power = |value: f64| {
        if value > 0.0 {
            value.log10().max(LEAST_POWER)
        } else {
            LEAST_POWER
        }
    };
    let powers = |curve: &[Point]| curve.iter().map(|p| (p.0, power(p.1))).collect::<Vec<_>>();
    let (deformation, gap) = (powers(&curves.deformation), powers(&curves.gap));
    let bounds = curves.certified.iter().flat_map(|&(from, to, most)| {
        let most = power(most);
        [(from, most), (to, most)]
    });
    let bounds: Vec<Point> = bounds.collect();
    let all = [&deformation, &gap, &bounds].into_iter().flatten();
    let top = all.map(|p| p.1.ceil()).fold(LEAST_POWER + 1.0, f64::max);
    let caption = "deformation and gap, those below 1e-17 drawn there";
    let labels = [TIME, "part of length, of median edge"];
    let powers = LEAST_POWER..top.min(LARGEST);
    let mut chart = chart(
        area,
        caption,
        labels,
        [times(curves), powers],
        Some(&power_of_ten),
    )?;
    mark_knots(&mut chart, curves)?;
    line(
        &mut chart,
        &deformation,
        of_group(0),
        Some("deformation".into()),
    )?;
    line(&mut chart, &gap, of_group(1), Some("gap".into()))?;
    if !bounds.is_empty() {
        line(
            &mut chart,
            &bounds,
            BLACK,
            Some("certified between knots".into()),
        )?;
    }
    legend(&mut chart, SeriesLabelPosition::LowerRight)
}

/// Formats a whole power of ten, and nothing for positions between whole powers.
fn power_of_ten(power: &f64) -> String {
    if (power - power.round()).abs() < 1e-9 {
        format!("1e{power:.0}")
    } else {
        String::new()
    }
}

/// Draws the clearance between faces.
fn clearance(curves: &Curves, area: &Area<'_>) -> Drawn {
    let known = curves.min_clearance.map_or_else(String::new, |least| {
        format!("; smallest met on the whole motion {least:.3e}")
    });
    let caption = if curves.clearance.is_empty() {
        format!("clearance: not measured of so many faces, or all of them share vertices{known}")
    } else {
        format!("clearance between faces that share no vertex{known}")
    };
    let zero = [0.0].into_iter();
    let distances = range(zero.chain(curves.clearance.iter().map(|p| p.1)));
    let mut chart = against_time(
        curves,
        area,
        &caption,
        "distance, units of the sheet",
        distances,
    )?;
    line(&mut chart, &curves.clearance, of_group(0), None)
}

/// Draws the torques of the drivers.
fn torques(curves: &Curves, area: &Area<'_>) -> Drawn {
    let values = curves.torques.iter().flat_map(|(_, curve)| curve);
    let most = values.clone().map(|p| p.1.abs()).fold(0.0, f64::max);
    let drivers = curves.torques.len();
    let caption = format!("torques of the drivers, {drivers} of them: {most:.3e} Nm at most");
    let values = range([0.0].into_iter().chain(values.map(|p| p.1)));
    let mut chart = against_time(curves, area, &caption, "torque, Nm", values)?;
    for (index, (edge, curve)) in curves.torques.iter().enumerate() {
        let name = (index < NAMED).then(|| format!("hinge {edge}"));
        line(&mut chart, curve, of_group(index), name)?;
    }
    legend(&mut chart, SeriesLabelPosition::UpperLeft)
}

const TIME: &str = "time along the path, seconds (upright lines: knots)";

fn times(curves: &Curves) -> Range<f64> {
    range(curves.knots.iter().copied())
}

/// Makes an empty panel with time from left to right and marks at the knots.
fn against_time<'a, 'b>(
    curves: &Curves,
    area: &'b Area<'a>,
    caption: &str,
    label: &str,
    values: Range<f64>,
) -> Result<Chart<'a, 'b>, DrawingAreaErrorKind<std::io::Error>> {
    let ranges = [times(curves), values];
    let mut chart = chart(area, caption, [TIME, label], ranges, None)?;
    mark_knots(&mut chart, curves)?;
    Ok(chart)
}

fn chart<'a, 'b>(
    area: &'b Area<'a>,
    caption: &str,
    [across, up]: [&str; 2],
    [x, y]: [Range<f64>; 2],
    numbers: Option<&dyn Fn(&f64) -> String>,
) -> Result<Chart<'a, 'b>, DrawingAreaErrorKind<std::io::Error>> {
    let mut chart = ChartBuilder::on(area)
        .caption(caption, (FONT, 30))
        .margin(20)
        .margin_right(50)
        .x_label_area_size(70)
        .y_label_area_size(130)
        .build_cartesian_2d(x, y)?;
    let mut mesh = chart.configure_mesh();
    if let Some(numbers) = numbers {
        mesh.y_label_formatter(numbers);
    }
    mesh.disable_x_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc(across)
        .y_desc(up)
        .label_style((FONT, 24))
        .axis_desc_style((FONT, 24))
        .draw()?;
    Ok(chart)
}

fn mark_knots(chart: &mut Chart<'_, '_>, curves: &Curves) -> Drawn {
    let y = chart.y_range();
    let knots = drawable_times(curves).take(MOST_KNOTS);
    let mark = |time| PathElement::new([(time, y.start), (time, y.end)], BLACK.mix(0.25));
    chart.draw_series(knots.map(mark))?;
    Ok(())
}

fn drawable_times(curves: &Curves) -> impl Iterator<Item = f64> {
    let times = curves
        .knots
        .iter()
        .map(|time| time.clamp(-LARGEST, LARGEST));
    times.filter(|time| time.is_finite())
}

/// Draws a curve. A curve with a name has an entry in the legend.
fn line(
    chart: &mut Chart<'_, '_>,
    curve: &[Point],
    colour: RGBColor,
    name: Option<String>,
) -> Drawn {
    let style = colour.stroke_width(3);
    let drawn = chart.draw_series(LineSeries::new(drawable(curve), style))?;
    if let Some(name) = name {
        let mark = move |(x, y)| PathElement::new([(x, y), (x + 24, y)], style);
        drawn.label(name).legend(mark);
    }
    Ok(())
}

fn legend<'a: 'b, 'b>(chart: &mut Chart<'a, 'b>, position: SeriesLabelPosition) -> Drawn {
    chart
        .configure_series_labels()
        .position(position)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .label_font((FONT, 22))
        .draw()
}

/// Returns the points that can be drawn.
fn drawable(curve: &[Point]) -> impl Iterator<Item = Point> {
    let points = curve.iter().filter(|p| !p.0.is_nan() && !p.1.is_nan());
    points.map(|p| (p.0.clamp(-LARGEST, LARGEST), p.1.clamp(-LARGEST, LARGEST)))
}

/// Returns a range that contains all numbers. It is never empty, and wide enough for its ends to differ when written.
fn range(numbers: impl Iterator<Item = f64>) -> Range<f64> {
    let numbers = numbers
        .filter(|x| !x.is_nan())
        .map(|x| x.clamp(-LARGEST, LARGEST));
    let ends = numbers
        .map(|x| [x; 2])
        .reduce(|[low, high], [x, _]| [low.min(x), high.max(x)]);
    let [low, high] = ends.unwrap_or_default();
    let least = 1e-6 * low.abs().max(high.abs()).max(1e-6);
    let margin = 0.5 * (least - (high - low)).max(0.0);
    low - margin..high + margin
}
