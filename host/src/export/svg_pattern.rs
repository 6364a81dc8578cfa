//! Writes SVG: the crease pattern, coloured by its letters (FOLD assignments), by crease groups or by deformation.
//!
//! Coloured by letters, the file is a crease pattern that Origami Simulator and [`read_pattern`](crate::read::read_pattern)
//! read: the colour of a line is its letter, the opacity is its goal fold angle over 180 degrees. Unassigned hinges
//! have a colour but no angle. Drawings are to scale and about a thousand units wide, because such programs join points
//! that are a few units apart; the file states the length of a unit of the sheet.

use core::f64::consts::PI;
use core::fmt::Write;

use foldpath_core::Membership;
use nalgebra::Vector2;

use super::cut_sheet::CutSheet;
use super::{Export, Made, Needs, Sink, Source, escaped, single};
use crate::colours::{hex, of_group, ramp};
use crate::folding::{STEP, deformation_of_faces};
use crate::motion::{GroupNaming, Motion};
use crate::pattern::{CreasePattern, Edge, EdgeId, Letter, Unit};
use crate::read::FileError;
use crate::symmetry::CreaseGroups;
use crate::util::nan_max::bounding_box;

/// Largest width or height of the drawn sheet without its margin, in units of the drawing.
const MAX_SHEET_UNITS: f64 = 1000.0;
const MARGIN_UNITS: f64 = 20.0;
/// Width of a legend and height of its rows, in units of the drawing.
const LEGEND_UNITS: f64 = 260.0;
const ROW_UNITS: f64 = 20.0;
/// Largest number of groups that a legend names.
const MAX_NAMED_GROUPS: usize = 40;
/// Largest height of the number of an edge, in units of the drawing, and as a fraction of the edge.
const NUMBER_UNITS: f64 = 13.0;
const NUMBER_RATIO: f64 = 0.3;
/// Number of steps of a colour bar.
const COLOUR_STEPS: u32 = 50;

/// Meaning of the colours of a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Colour {
    /// Letters, with the goal angles as opacity.
    #[default]
    Letters,
    /// Crease groups, each with the range of its angles.
    Groups,
    /// Largest deformation of each face along the path.
    Deformation,
    /// Layers of what is cut from a board: the outlines of plates, fold lines, holes and numbers.
    Plates,
}

impl Colour {
    /// Returns what the drawing is made of.
    pub(super) const fn needs(self) -> Needs {
        match self {
            Self::Letters => Needs::Pattern,
            Self::Groups => Needs::PathOrPattern,
            Self::Deformation | Self::Plates => Needs::Path,
        }
    }
}

/// Makes the drawing. Groups are those of a path that names some, and are looked for otherwise.
pub(super) fn made(export: &Export<'_>, sink: &mut Sink<'_>) -> Result<Made, FileError> {
    let title = export.source.title();
    let pattern = export.source.pattern();
    if export.options.colour == Colour::Plates {
        let cut = CutSheet::of(export)?;
        let unit = pattern.unit().map_or("", |unit| match unit {
            Unit::Millimetre => "mm",
            Unit::Centimetre => "cm",
            Unit::Inch => "in",
            Unit::Point => "pt",
            _ => "",
        });
        sink(
            "",
            cut.svg(title, (unit, pattern.median_edge())).into_bytes(),
        )?;
        let told = format!("outlines of {} plates by layers", cut.outlines.len());
        return Ok(Made {
            told,
            notes: cut.notes,
        });
    }
    let (mut sheet, told) = match (export.options.colour, export.source) {
        (Colour::Letters, _) => {
            let told = format!("{} edges by letters", pattern.edges().len());
            (lettered(title, pattern), told)
        }
        (Colour::Groups, Source::Motion(motion)) if motion.naming != GroupNaming::Unnamed => {
            let ranges = ranges(motion);
            let sheet = by_groups(title, pattern, motion.named_members(), &ranges);
            (sheet, format!("{} crease groups of the path", ranges.len()))
        }
        (Colour::Groups, _) => {
            let (members, ranges) = found_groups(pattern);
            let sheet = by_groups(title, pattern, &members, &ranges);
            (
                sheet,
                format!("{} crease groups of the pattern", ranges.len()),
            )
        }
        (Colour::Deformation | Colour::Plates, _) => {
            let faces = deformation_of_faces(export.motion()?);
            let sheet = by_deformation(title, pattern, &faces);
            (sheet, format!("{} faces by deformation", faces.len()))
        }
    };
    if export.options.numbers {
        sheet.number_edges();
    }
    sink("", sheet.end().into_bytes())?;
    Ok(Made::told(told))
}

/// Returns for each crease group of a path its smallest and largest fold angle, radians.
fn ranges(path: &Motion) -> Vec<[f64; 2]> {
    let steps = path.with_steps(STEP);
    let leaders = path.leaders().into_iter();
    let range = |leader: Option<(EdgeId, Membership)>| {
        let angles = (0..steps.knots.len()).filter_map(|knot| {
            let (edge, member) = leader?;
            Some(member.apply(steps.node(knot, edge).angle))
        });
        extent(angles)
    };
    leaders.map(range).collect()
}

/// Finds the crease groups of a pattern. Returns the membership of each edge, and for each group the range of fold
/// angles (radians) from flat to its goal.
fn found_groups(pattern: &CreasePattern) -> (Vec<Option<Membership>>, Vec<[f64; 2]>) {
    let groups = CreaseGroups::find(pattern);
    let edges = pattern.edges().iter();
    let members = edges.map(|edge| edge.crease.map(|crease| groups.of(crease)));
    let creases = pattern.creases().iter();
    let goals: Vec<_> = creases.map(|&edge| pattern.edge(edge).goal).collect();
    let goals = groups.reduce(&goals).into_iter();
    let ranges = goals.map(|goal| extent([0.0].into_iter().chain(goal)));
    (members.collect(), ranges.collect())
}

/// Returns the smallest and the largest number; zeros if there are no numbers.
fn extent(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    let ends = numbers
        .map(|x| [x; 2])
        .reduce(|[low, high], [x, _]| [low.min(x), high.max(x)]);
    ends.unwrap_or_default()
}

/// Returns a drawing of the pattern coloured by its letters, with the numbers of its edges.
#[must_use]
pub fn numbered(title: &str, pattern: &CreasePattern) -> String {
    let mut sheet = lettered(title, pattern);
    sheet.number_edges();
    sheet.end()
}

/// Returns a drawing of the pattern coloured by its letters, with its goal angles as opacity.
#[must_use]
pub fn by_letters(title: &str, pattern: &CreasePattern) -> String {
    lettered(title, pattern).end()
}

/// Draws the pattern coloured by its letters, with its goal angles as opacity.
fn lettered<'a>(title: &str, pattern: &'a CreasePattern) -> Sheet<'a> {
    let mut sheet = Sheet::new(title, pattern, 0.0);
    for edge in pattern.edges() {
        let colour = match edge.letter {
            Letter::Mountain => "#ff0000",
            Letter::Valley => "#0000ff",
            Letter::Boundary => "#000000",
            Letter::Cut => "#00ff00",
            Letter::Flat | Letter::Join | Letter::Bend => "#ffff00",
            Letter::Unassigned => "#ff00ff",
        };
        let folds = edge.letter.sign().abs() > 0.0;
        let goal = edge.goal.filter(|_| folds).map(|goal| goal.abs() / PI);
        let opacity = goal.map_or_else(String::new, |part| {
            format!(" stroke-opacity=\"{}\"", single(part))
        });
        sheet.line(edge, colour, &opacity);
    }
    sheet
}

/// Draws the pattern with a colour for each crease group. Creases that turn against their group are dashed, and a
/// legend lists the range of fold angles (radians) of each group in `ranges`. `members` has the group and sign of each
/// edge.
fn by_groups<'a>(
    title: &str,
    pattern: &'a CreasePattern,
    members: &[Option<Membership>],
    ranges: &[[f64; 2]],
) -> Sheet<'a> {
    let mut sheet = Sheet::new(title, pattern, LEGEND_UNITS);
    let dashes = " stroke-dasharray=\"6 4\"";
    for (edge, member) in pattern.edges().iter().zip(members) {
        match member {
            Some(of) => {
                let dashed = if of.negative { dashes } else { "" };
                sheet.line(edge, &hex(of_group(of.group.index())), dashed);
            }
            None => sheet.line(edge, "#999999", ""),
        }
    }
    sheet.say("crease groups, fold angles in degrees");
    sheet.say("dashed: turns against its group");
    for (group, range) in ranges.iter().enumerate().take(MAX_NAMED_GROUPS) {
        let [low, high] = range.map(|angle| angle.to_degrees() + 0.0);
        sheet.swatch(&hex(of_group(group)));
        sheet.say(&format!("      {group}: {low:.1} to {high:.1}"));
    }
    if ranges.len() > MAX_NAMED_GROUPS {
        sheet.say(&format!("and {} more", ranges.len() - MAX_NAMED_GROUPS));
    }
    sheet
}

/// Draws the pattern with each face coloured by its deformation in `of_faces` (0 or more), and a colour bar.
fn by_deformation<'a>(title: &str, pattern: &'a CreasePattern, of_faces: &[f64]) -> Sheet<'a> {
    let mut sheet = Sheet::new(title, pattern, LEGEND_UNITS);
    let most = of_faces.iter().copied().fold(0.0, f64::max);
    let part = |value: f64| if most > 0.0 { value / most } else { 0.0 };
    for (face, &value) in pattern.faces().iter().zip(of_faces) {
        let corners = face
            .iter()
            .map(|v| sheet.place(pattern.vertices()[v.index()]));
        let corners = corners.collect::<Vec<_>>().join(" ");
        let colour = hex(ramp(part(value)));
        sheet.add(&format!(
            "<polygon points=\"{corners}\" fill=\"{colour}\"/>"
        ));
    }
    for edge in pattern.edges() {
        sheet.line(edge, "#ffffff", "");
    }
    sheet.say("largest deformation of an edge or");
    sheet.say("diagonal: change of length over length");
    sheet.bar();
    sheet.say(&format!("from 0 to {most:.2e}"));
    sheet
}

/// An SVG drawing under construction.
struct Sheet<'a> {
    pattern: &'a CreasePattern,
    /// Upper left corner of the bounding box of all vertices, in units of the sheet.
    corner: Vector2<f64>,
    /// Units of the drawing per unit of the sheet.
    scale: f64,
    /// Width and height of the drawn sheet, and below the width of the legend beside it.
    size: Vector2<f64>,
    legend: f64,
    /// Height of the next row of the legend, in units of the drawing.
    row: f64,
    /// Elements that are lines or areas, and elements that are texts.
    shapes: String,
    texts: String,
    title: String,
}

impl<'a> Sheet<'a> {
    fn new(title: &str, pattern: &'a CreasePattern, legend: f64) -> Self {
        let vertices = pattern.vertices();
        let (low, high) = bounding_box(vertices.iter().copied()).unwrap_or_default();
        let scale = round_scale(MAX_SHEET_UNITS / (high - low).max());
        Self {
            pattern,
            corner: Vector2::new(low.x, high.y),
            scale,
            size: scale * (high - low),
            legend,
            row: 0.0,
            shapes: String::new(),
            texts: String::new(),
            title: escaped(title),
        }
    }

    /// Formats the position of a point of the sheet in the drawing, where y points down.
    fn place(&self, point: Vector2<f64>) -> String {
        let at = self.scale * (point - self.corner);
        format!("{},{}", single(at.x), single(0.0 - at.y))
    }

    fn add(&mut self, element: &str) {
        self.shapes += element;
        self.shapes.push('\n');
    }

    fn line(&mut self, edge: &Edge, colour: &str, more: &str) {
        let ends = edge
            .ends
            .map(|end| self.place(self.pattern.vertices()[end.index()]));
        let [from, to] = ends;
        self.add(&format!(
            "<path d=\"M{from}L{to}\" stroke=\"{colour}\"{more}/>"
        ));
    }

    /// Writes the number of each edge at its middle.
    fn number_edges(&mut self) {
        for (index, edge) in self.pattern.edges().iter().enumerate() {
            let [from, to] = edge.ends.map(|end| self.pattern.vertices()[end.index()]);
            let place = self.place((from + to) / 2.0);
            let (x, y) = place.split_once(',').unwrap_or_default();
            let height = single((NUMBER_RATIO * self.scale * (to - from).norm()).min(NUMBER_UNITS));
            // Writing to memory cannot fail.
            let _complete = writeln!(
                self.texts,
                "<text x=\"{x}\" y=\"{y}\" font-size=\"{height}\" text-anchor=\"middle\" \
                 dominant-baseline=\"central\">{index}</text>"
            );
        }
    }

    /// Adds a row of text to the legend.
    fn say(&mut self, text: &str) {
        self.row += ROW_UNITS;
        let (x, y) = (self.size.x + MARGIN_UNITS, self.row - 5.0);
        // Writing to memory cannot fail.
        let _complete = writeln!(
            self.texts,
            "<text x=\"{x}\" y=\"{y}\" xml:space=\"preserve\">{text}</text>"
        );
    }

    /// Begins the next row of the legend with a line of this colour.
    fn swatch(&mut self, colour: &str) {
        let (from, to, y) = (
            self.size.x + MARGIN_UNITS,
            self.size.x + MARGIN_UNITS + 20.0,
            self.row + 10.0,
        );
        self.add(&format!(
            "<path d=\"M{from},{y}L{to},{y}\" stroke=\"{colour}\" stroke-width=\"4\"/>"
        ));
    }

    /// Adds the colour bar as a row of the legend.
    fn bar(&mut self) {
        let width = (LEGEND_UNITS - 3.0 * MARGIN_UNITS) / f64::from(COLOUR_STEPS);
        for step in 0..COLOUR_STEPS {
            let colour = hex(ramp(f64::from(step) / f64::from(COLOUR_STEPS - 1)));
            let (x, y) = (
                self.size.x + MARGIN_UNITS + width * f64::from(step),
                self.row,
            );
            // Each step is a little wider than its share, so that no gap shows.
            let width = width + 0.5;
            self.add(&format!(
                "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{ROW_UNITS}\" fill=\"{colour}\"/>"
            ));
        }
        self.row += ROW_UNITS;
    }

    fn end(self) -> String {
        let width = self.size.x + 2.0 * MARGIN_UNITS + self.legend;
        let height = self.size.y.max(self.row) + 2.0 * MARGIN_UNITS;
        // Lines are 2 units wide, or a tenth of a median edge on fine sheets.
        let stroke = single((0.1 * self.scale * self.pattern.median_edge()).min(2.0));
        // A sheet whose unit is known is drawn as large as it is.
        let [shown_width, shown_height] = [width, height].map(|length| match self.pattern.unit() {
            // SVG has no larger and no smaller units than these.
            Some(unit @ (Unit::Millimetre | Unit::Centimetre | Unit::Inch | Unit::Point)) => {
                format!("{}{}", length / self.scale, unit.name())
            }
            Some(unit) => {
                let millimetres = unit.metres() / Unit::Millimetre.metres();
                format!("{}mm", length / self.scale * millimetres)
            }
            None => length.to_string(),
        });
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{shown_width}\" height=\"{shown_height}\" \
             viewBox=\"{left} {left} {width} {height}\">\n<title>{title}</title>\n\
             <desc>A unit of the sheet is {scale} units long.</desc>\n\
             <g fill=\"none\" stroke-width=\"{stroke}\" stroke-linecap=\"round\">\n{shapes}</g>\n\
             <g font-family=\"sans-serif\" font-size=\"13\" fill=\"#333333\">\n{texts}</g>\n</svg>\n",
            left = -MARGIN_UNITS,
            title = self.title,
            scale = self.scale,
            shapes = self.shapes,
            texts = self.texts,
        )
    }
}

/// Returns the largest of 1, 2 and 5 times a power of ten that is not above `scale`.
fn round_scale(scale: f64) -> f64 {
    let power = 10_f64.powf(scale.log10().floor());
    let digits = [5.0, 2.0, 1.0].into_iter();
    let digit = digits
        .map(|digit| digit * power)
        .find(|round| *round <= scale);
    digit.unwrap_or(power)
}
