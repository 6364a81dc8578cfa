//! The sheet as a workshop cuts it from a board: outlines of the plates, fold lines, holes at vertices and numbers.
//!
//! Plates with upright sides are cut along their outlines, which stay back from the hinges; a film or tape joins them along the
//! fold lines. Tapered plates meet at the hinges; their slanted sides have to be milled.

use core::fmt::Write;

use nalgebra::Vector2;

use super::stl::{UNKNOWN_UNIT, plates_of};
use super::{Export, escaped};
use crate::collision::Plates;
use crate::motion::PlateSides;
use crate::pattern::{CreasePattern, VertexId};
use crate::read::FileError;
use crate::util::nan_max::bounding_box;

/// Height of the number of a plate, over the square root of its area, and largest, over the median edge.
const NUMBER_RATIO: f64 = 0.25;
const NUMBER_EDGES: f64 = 0.25;
/// Margin of a drawing in SVG, median edges, and width of its lines.
const MARGIN_EDGES: f64 = 0.25;
const LINE_EDGES: f64 = 0.01;

/// The layers.
pub(super) const CUT: &str = "CUT";
pub(super) const MOUNTAIN: &str = "MOUNTAIN";
pub(super) const VALLEY: &str = "VALLEY";
pub(super) const HOLE: &str = "HOLE";
pub(super) const TEXT: &str = "TEXT";
pub(super) const LAYERS: [&str; 5] = [CUT, MOUNTAIN, VALLEY, HOLE, TEXT];
/// Their colours in SVG.
const COLOURS: [&str; 5] = ["#000000", "#ff0000", "#0000ff", "#008000", "#808080"];

/// A number to be written on a plate.
pub(super) struct Number {
    pub(super) text: String,
    /// Its middle, and the height of its digits.
    pub(super) at: Vector2<f64>,
    pub(super) height: f64,
}

/// The lines, holes and numbers of a drawing, in units of the sheet.
pub(super) struct CutSheet {
    /// Closed outlines.
    pub(super) outlines: Vec<Vec<Vector2<f64>>>,
    /// Fold lines, with `true` for valleys.
    pub(super) folds: Vec<([Vector2<f64>; 2], bool)>,
    /// Middle and radius of each hole.
    pub(super) holes: Vec<(Vector2<f64>, f64)>,
    pub(super) numbers: Vec<Number>,
    /// Remarks for the user.
    pub(super) notes: Vec<String>,
}

impl CutSheet {
    /// Draws the plates of a path. Outlines are larger by half the width of the cut.
    pub(super) fn of(export: &Export<'_>) -> Result<Self, FileError> {
        let motion = export.motion()?;
        let plates = plates_of(motion, export.name)?;
        let pattern = &motion.pattern;
        let layer = plates.hinge_layer();
        let grown = export.options.kerf / 2.0;
        let outlines = (0..plates.list.len()).map(|plate| {
            plates.grown(plate, layer, grown).ok_or_else(|| {
                let expected = format!(
                    "a kerf that leaves panel {} its sides",
                    plates.list[plate].faces[0]
                );
                FileError::expected(
                    export.name,
                    "kerf",
                    expected,
                    export.options.kerf.to_string(),
                )
            })
        });
        let outlines: Vec<_> = outlines.collect::<Result<_, _>>()?;
        // The cut takes half its width of the room.
        let radii = radii(&plates, layer, pattern).into_iter();
        let radii: Vec<f64> = radii.map(|radius| (radius - grown).max(0.0)).collect();
        let ranges = motion.angle_ranges();
        let folds = pattern
            .creases()
            .iter()
            .zip(ranges)
            .filter_map(|(&edge, [low, high])| {
                let line = between_holes(pattern.edge(edge).ends, &radii, pattern.vertices())?;
                (high - low > 0.0).then_some((line, high > -low))
            });
        let folds = folds.collect();
        let holes = pattern.vertices().iter().zip(&radii);
        let holes = holes.filter(|(_, radius)| **radius > 0.0);
        let holes = holes.map(|(&at, &radius)| (at, radius)).collect();
        let numbers = outlines.iter().zip(&plates.list).map(|(outline, plate)| {
            let (area, at) = middle(outline);
            Number {
                text: plate.faces[0].to_string(),
                at,
                height: (NUMBER_RATIO * area.sqrt()).min(NUMBER_EDGES * pattern.median_edge()),
            }
        });
        let numbers = numbers.collect();
        let mut notes = Vec::new();
        if plates.options.sides == PlateSides::Taper {
            notes.push("the sides of the plates are slanted at hinges: they have to be milled, outlines are those at the hinges".into());
        }
        if pattern.unit().is_none() {
            notes.push(UNKNOWN_UNIT.into());
        }
        Ok(Self {
            outlines,
            folds,
            holes,
            numbers,
            notes,
        })
    }

    /// Returns the drawing as SVG, with a group for each layer.
    pub(super) fn svg(&self, title: &str, (unit, edge): (&str, f64)) -> String {
        let points = self.outlines.iter().flatten().copied();
        let (low, high) = bounding_box(points).unwrap_or_default();
        let margin = MARGIN_EDGES * edge;
        let [width, height] = [high.x - low.x + 2.0 * margin, high.y - low.y + 2.0 * margin];
        // y points down in SVG.
        let at = |point: &Vector2<f64>| {
            format!("{} {}", point.x - low.x + margin, high.y - point.y + margin)
        };
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}{unit}\" height=\"{height}{unit}\" \
             viewBox=\"0 0 {width} {height}\">\n<title>{}</title>\n",
            escaped(title)
        );
        let line = LINE_EDGES * edge;
        for (name, colour) in LAYERS.into_iter().zip(COLOURS) {
            // Writing to memory cannot fail.
            let _complete = writeln!(
                text,
                "<g id=\"{name}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{line}\">"
            );
            match name {
                CUT => {
                    for outline in &self.outlines {
                        let places: Vec<String> = outline.iter().map(at).collect();
                        let _complete = writeln!(text, "<path d=\"M {} Z\"/>", places.join(" L "));
                    }
                }
                HOLE => {
                    for (middle, radius) in &self.holes {
                        let [x, y] = [middle.x - low.x + margin, high.y - middle.y + margin];
                        let _complete =
                            writeln!(text, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"/>");
                    }
                }
                TEXT => {
                    for number in &self.numbers {
                        let [x, y] = [number.at.x - low.x + margin, high.y - number.at.y + margin];
                        let (size, shown) = (number.height, &number.text);
                        let _complete = writeln!(
                            text,
                            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" text-anchor=\"middle\" \
                             dominant-baseline=\"central\" stroke=\"none\" fill=\"{colour}\">{shown}</text>"
                        );
                    }
                }
                _ => {
                    let dashes = 0.1 * edge;
                    for ([from, to], _) in self
                        .folds
                        .iter()
                        .filter(|(_, valley)| *valley == (name == VALLEY))
                    {
                        let _complete = writeln!(
                            text,
                            "<path d=\"M {} L {}\" stroke-dasharray=\"{dashes}\"/>",
                            at(from),
                            at(to)
                        );
                    }
                }
            }
            text.push_str("</g>\n");
        }
        text + "</svg>\n"
    }
}

/// Returns for each vertex inside the sheet the distance to the nearest plate that has a corner there; 0 for the others.
fn radii(plates: &Plates, layer: usize, pattern: &CreasePattern) -> Vec<f64> {
    let mut radii: Vec<f64> = (0..pattern.vertices().len())
        .map(|vertex| {
            if pattern.is_real(VertexId::new(vertex)) {
                f64::INFINITY
            } else {
                0.0
            }
        })
        .collect();
    for plate in &plates.list {
        let outline: Vec<Vector2<f64>> = plate.outlines[layer].iter().flatten().copied().collect();
        for corner in &plate.corners {
            let at = pattern.vertices()[corner.index()];
            let sides = outline.iter().zip(outline.iter().cycle().skip(1));
            let away = sides.map(|(from, to)| {
                let along = to - from;
                let s = along.dot(&(at - from)) / along.norm_squared().max(f64::MIN_POSITIVE);
                (from + along * s.clamp(0.0, 1.0) - at).norm()
            });
            let radius = &mut radii[corner.index()];
            *radius = away.fold(*radius, f64::min);
        }
    }
    radii
}

/// Returns the part of a line between the holes at its ends; `None` if nothing is left of it.
fn between_holes(
    ends: [VertexId; 2],
    radii: &[f64],
    vertices: &[Vector2<f64>],
) -> Option<[Vector2<f64>; 2]> {
    let [from, to] = ends.map(|end| vertices[end.index()]);
    let [start, end] = ends.map(|end| radii[end.index()]);
    let (length, along) = ((to - from).norm(), (to - from).normalize());
    (start + end < length).then(|| [from + along * start, to - along * end])
}

/// Returns the area of a closed outline and its centroid.
fn middle(outline: &[Vector2<f64>]) -> (f64, Vector2<f64>) {
    let origin = outline[0];
    let next = outline.iter().cycle().skip(1);
    let parts = outline.iter().zip(next).map(|(a, b)| {
        let area = (a - origin).perp(&(b - origin)) / 2.0;
        (area, (a + b + origin) * (area / 3.0))
    });
    let (area, moment) = parts.fold(
        (0.0, Vector2::zeros()),
        |(area, moment), (part, of_part)| (area + part, moment + of_part),
    );
    (area, moment / area)
}
