//! Writes DXF: the flat sheet as lines on the layers CUT, MOUNTAIN, VALLEY, FLAT and UNASSIGNED, for laser cutters and CAD
//! programs. If the panels of a path are plates, it has their outlines ([`CutSheet`]).
//!
//! The bytes are the same at any time and in any place: dates and identifiers in the header are fixed. Coordinates have 12
//! decimals.

use ::dxf::entities::{Circle, Entity, EntityType, Line, LwPolyline, Text};
use ::dxf::enums::{AcadVersion, Units};
use ::dxf::tables::Layer;
use ::dxf::{Color, Drawing, DxfError, DxfResult, Handle, LwPolylineVertex, Point};
use nalgebra::Vector2;

use super::cut_sheet::{self, CutSheet};
use super::{Export, Made, Sink, Source};
use crate::motion::Motion;
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

/// Colours of the layers of plates to be cut: white or black, red, blue, green and grey.
const CUT_COLOURS: [u8; 5] = [7, 1, 5, 3, 8];

/// Tables of a drawing.
const TABLES: [&str; 9] = [
    "VPORT",
    "LTYPE",
    "LAYER",
    "STYLE",
    "VIEW",
    "UCS",
    "APPID",
    "DIMSTYLE",
    "BLOCK_RECORD",
];

/// Makes the drawing.
pub(super) fn made(export: &Export<'_>, sink: &mut Sink<'_>) -> Result<Made, FileError> {
    let pattern = export.source.pattern();
    let save = |drawing: Drawing| {
        saved(drawing).map_err(|error| {
            let expected = "a sheet that DXF can hold";
            FileError::expected(export.name, "the file", expected, error.to_string())
        })
    };
    if let Source::Motion(Motion {
        plates: Some(_), ..
    }) = export.source
    {
        let sheet = CutSheet::of(export)?;
        sink("", save(cut_drawing(&sheet, pattern.unit()))?)?;
        let told = format!("outlines of {} plates by layers", sheet.outlines.len());
        return Ok(Made {
            told,
            notes: sheet.notes,
        });
    }
    if export.options.kerf > 0.0 {
        let (expected, found) = ("a path with plates, for a kerf", "none");
        return Err(FileError::expected(
            export.name,
            "foldpath:thickness",
            expected,
            found,
        ));
    }
    sink("", save(drawing(pattern))?)?;
    let mut made = Made::told(format!("{} edges by layers", pattern.edges().len()));
    if pattern.edges().iter().any(|edge| edge.goal.is_some()) {
        let note = "goal angles left out: a DXF drawing has none";
        made.notes.push(note.into());
    }
    Ok(made)
}

/// Returns the bytes of a drawing. The crate writes tables without their handles, which strict readers miss: they are put in.
fn saved(mut drawing: Drawing) -> DxfResult<Vec<u8>> {
    let next = &mut drawing.header.next_available_handle;
    let handles = TABLES.map(|_| core::mem::replace(next, Handle(next.0 + 1)));
    let mut bytes = Vec::new();
    drawing.save(&mut bytes)?;
    let Ok(mut text) = String::from_utf8(bytes) else {
        return Err(DxfError::MalformedString);
    };
    for (table, Handle(handle)) in TABLES.into_iter().zip(handles) {
        let head = format!("TABLE\r\n  2\r\n{table}\r\n");
        text = text.replacen(&head, &format!("{head}  5\r\n{handle:X}\r\n"), 1);
    }
    Ok(text.into_bytes())
}

/// Returns the drawing of plates to be cut.
fn cut_drawing(sheet: &CutSheet, unit: Option<Unit>) -> Drawing {
    let layers: Vec<_> = cut_sheet::LAYERS.into_iter().zip(CUT_COLOURS).collect();
    let mut drawing = empty(&layers, unit);
    let point = |at: &Vector2<f64>| Point::new(at.x, at.y, 0.0);
    let mut add = |layer: &str, kind: EntityType| {
        let mut entity = Entity::new(kind);
        entity.common.layer = layer.into();
        drawing.add_entity(entity);
    };
    for outline in &sheet.outlines {
        let vertices = outline.iter().map(|at| LwPolylineVertex {
            x: at.x,
            y: at.y,
            ..LwPolylineVertex::default()
        });
        let mut closed = LwPolyline {
            vertices: vertices.collect(),
            ..LwPolyline::default()
        };
        closed.set_is_closed(true);
        add(cut_sheet::CUT, EntityType::LwPolyline(closed));
    }
    for ([from, to], is_valley) in &sheet.folds {
        let layer = if *is_valley {
            cut_sheet::VALLEY
        } else {
            cut_sheet::MOUNTAIN
        };
        add(layer, EntityType::Line(Line::new(point(from), point(to))));
    }
    for (middle, radius) in &sheet.holes {
        add(
            cut_sheet::HOLE,
            EntityType::Circle(Circle::new(point(middle), *radius)),
        );
    }
    for number in &sheet.numbers {
        // The middle of the digits, for which about two thirds of their height are their width.
        #[allow(clippy::cast_precision_loss, reason = "a few digits")]
        let half = Vector2::new(number.text.len() as f64 / 3.0, 0.5) * number.height;
        let text = Text {
            location: point(&(number.at - half)),
            text_height: number.height,
            value: number.text.clone(),
            ..Text::default()
        };
        add(cut_sheet::TEXT, EntityType::Text(text));
    }
    drawing
}

/// Returns an empty drawing with these layers and their colours.
fn empty(layers: &[(&str, u8)], unit: Option<Unit>) -> Drawing {
    let mut drawing = Drawing::new();
    let header = &mut drawing.header;
    header.version = AcadVersion::R2000;
    header.default_drawing_units = units(unit);
    header.fingerprint_guid = Default::default();
    header.version_guid = Default::default();
    let midnight = Default::default();
    (header.creation_date_universal, header.update_date_universal) = (midnight, midnight);
    // The crate writes local times as a clock on the wall shows them.
    header.creation_date = midnight.into();
    header.creation_date -= header.creation_date.naive_local() - midnight.naive_utc();
    header.update_date = header.creation_date;
    for &(name, colour) in layers {
        drawing.add_layer(Layer {
            name: name.into(),
            color: Color::from_index(colour),
            ..Layer::default()
        });
    }
    drawing
}

fn drawing(pattern: &CreasePattern) -> Drawing {
    let mut drawing = empty(&LAYERS, pattern.unit());
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
