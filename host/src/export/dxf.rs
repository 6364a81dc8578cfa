//! Writes DXF: the flat sheet as lines on the layers CUT, MOUNTAIN, VALLEY, FLAT and UNASSIGNED, for laser cutters and CAD
//! programs.
//!
//! The bytes are the same at any time and in any place: dates and identifiers in the header are fixed. Coordinates have 12
//! decimals.

use ::dxf::entities::{Entity, EntityType, Line};
use ::dxf::enums::{AcadVersion, Units};
use ::dxf::tables::Layer;
use ::dxf::{Color, Drawing, Point};

use super::{Export, Made, Sink};
use crate::pattern::{CreasePattern, Letter, Unit};
use crate::read::FileError;

/// Layers with their colours in the AutoCAD Color Index: white or black, red, blue, yellow and magenta.
const LAYERS: [(&str, u8); 5] = [
    ("CUT", 7),
    ("MOUNTAIN", 1),
    ("VALLEY", 5),
    ("FLAT", 2),
    ("UNASSIGNED", 6),
];

/// Makes the drawing.
pub(super) fn made(export: &Export<'_>, sink: &mut Sink<'_>) -> Result<Made, FileError> {
    let pattern = export.source.pattern();
    let mut bytes = Vec::new();
    drawing(pattern).save(&mut bytes).map_err(|error| {
        let expected = "a sheet that DXF can hold";
        FileError::expected(export.name, "the file", expected, error.to_string())
    })?;
    sink("", bytes)?;
    let mut made = Made::told(format!("{} edges by layers", pattern.edges().len()));
    if pattern.edges().iter().any(|edge| edge.goal.is_some()) {
        let note = "goal angles left out: a DXF drawing has none";
        made.notes.push(note.into());
    }
    Ok(made)
}

fn drawing(pattern: &CreasePattern) -> Drawing {
    let mut drawing = Drawing::new();
    let header = &mut drawing.header;
    header.version = AcadVersion::R2000;
    header.default_drawing_units = units(pattern.unit());
    header.fingerprint_guid = Default::default();
    header.version_guid = Default::default();
    let midnight = Default::default();
    (header.creation_date_universal, header.update_date_universal) = (midnight, midnight);
    // The crate writes local times as a clock on the wall shows them.
    header.creation_date = midnight.into();
    header.creation_date -= header.creation_date.naive_local() - midnight.naive_utc();
    header.update_date = header.creation_date;
    for (name, colour) in LAYERS {
        drawing.add_layer(Layer {
            name: name.into(),
            color: Color::from_index(colour),
            ..Layer::default()
        });
    }
    for edge in pattern.edges() {
        let ends = edge.ends.map(|end| pattern.vertices()[end.index()]);
        let [from, to] = ends.map(|at| Point::new(at.x, at.y, 0.0));
        let mut line = Entity::new(EntityType::Line(Line::new(from, to)));
        line.common.layer = layer(edge.letter).into();
        drawing.add_entity(line);
    }
    drawing
}

fn layer(letter: Letter) -> &'static str {
    match letter {
        Letter::Boundary | Letter::Cut => "CUT",
        Letter::Mountain => "MOUNTAIN",
        Letter::Valley => "VALLEY",
        Letter::Unassigned => "UNASSIGNED",
        _ => "FLAT",
    }
}

fn units(unit: Option<Unit>) -> Units {
    match unit {
        Some(Unit::Inch) => Units::Inches,
        Some(Unit::Millimetre) => Units::Millimeters,
        Some(Unit::Centimetre) => Units::Centimeters,
        Some(Unit::Metre) => Units::Meters,
        Some(Unit::Nanometre) => Units::Nanometers,
        Some(Unit::Micrometre) => Units::Microns,
        Some(Unit::Point) | None => Units::Unitless,
    }
}
