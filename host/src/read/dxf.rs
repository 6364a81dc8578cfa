//! Reads DXF drawings: lines, polylines with bulges, arcs, circles, ellipses, splines, and blocks that hold them.
//!
//! Source: Autodesk, "DXF Reference". The crate `dxf` parses the file; this reader places what blocks hold, makes cubic
//! curves of everything that is round, and gives each line a letter: that of its layer, if the user gives the layer one or
//! its name says it, and else that of its colour, as in SVG drawings.

mod layers;
mod outlines;
mod reduced;

use core::panic::AssertUnwindSafe;
use std::collections::{BTreeMap, HashMap};
use std::panic::catch_unwind;
use std::path::Path;

use ::dxf::entities::{Entity, EntityType, Insert};
use ::dxf::enums::Units;
use ::dxf::{Block, Drawing, DxfError};

use self::layers::{Layers, Meaning, Style};
use self::outlines::{Outline, Placement, outline};
use self::reduced::{MAX_LISTED, Reduced, reduced, too_long};
use super::curves::{Chords, Piece, STRAIGHT_CREASE};
use super::error::Wrong;
use super::format::BINARY_DXF;
use super::segments::{LineNames, LooseLines, MAX_LINES, Segment, pattern_file};
use super::{FileError, ReadOptions};
use crate::pattern::Unit;
use crate::progress::Watch;
use crate::read::fold::PatternFile;
use crate::util::nan_max::diagonal;

/// Largest depth of blocks in blocks.
const MAX_DEPTH: usize = 32;
/// Largest number of things drawn, each place of a block counted.
const MAX_ENTITIES: usize = 1 << 22;
/// Largest distance of a curve from the line between its ends at which it is that line, and of heights from each other in a
/// flat drawing, as fractions of the drawing's diagonal.
const STRAIGHT_RATIO: f64 = 1e-9;
const FLAT_RATIO: f64 = 1e-6;

/// Parses a crease pattern from the bytes of a file.
///
/// # Errors
/// If the bytes are no DXF, ask for too much work, are not flat, have a curved crease, or their lines form no crease pattern.
pub(super) fn parse_pattern(
    path: &Path,
    bytes: &[u8],
    options: &ReadOptions,
    watch: Watch<'_>,
) -> Result<PatternFile, FileError> {
    let wrong = FileError::wrong(path);
    let (drawing, left_out) = parsed(bytes).map_err(&wrong)?;
    let mut reader = Reader::new(&drawing, left_out, options);
    reader.read(&drawing).map_err(&wrong)?;
    let lines = reader.into_lines(&drawing, options).map_err(&wrong)?;
    pattern_file(path, lines, options, watch)
}

fn no_drawing(place: impl Into<String>, found: impl Into<String>) -> Wrong {
    (place.into(), "a DXF drawing".into(), found.into())
}

/// Parses the structure of the file. Returns the numbers of things left out as well, by what they are.
fn parsed(bytes: &[u8]) -> Result<(Drawing, BTreeMap<&'static str, usize>), Wrong> {
    if bytes.starts_with(b"AutoCAD DXB") {
        return Err(no_drawing("the file", "a DXB file"));
    }
    if bytes.starts_with(BINARY_DXF.as_bytes()) {
        let pairs = bytes.windows(2);
        let starts = pairs.filter(|pair| pair[0] == 0 && pair[1].is_ascii_uppercase());
        if starts.count() > MAX_LISTED {
            return Err(too_long());
        }
        let loaded = load(bytes, encoding_rs::WINDOWS_1252);
        let drawing = loaded.map_err(|error| no_drawing("the file", error.to_string()))?;
        return Ok((drawing, BTreeMap::new()));
    }
    if !bytes.trim_ascii_end().ends_with(b"EOF") {
        let end = bytes.split(|byte| *byte == b'\n').count();
        let found = "the end of the file";
        let expected = "EOF, after the last section";
        return Err((format!("line {end}"), expected.into(), found.into()));
    }
    let is_utf8 = str::from_utf8(bytes).is_ok();
    let encoding = if is_utf8 {
        encoding_rs::UTF_8
    } else {
        encoding_rs::WINDOWS_1252
    };
    let Reduced {
        bytes,
        lines,
        left_out,
    } = reduced(bytes)?;
    let drawing = load(&bytes, encoding).map_err(|error| {
        let place = match &error {
            DxfError::ParseFloatError(_, line)
            | DxfError::ParseIntError(_, line)
            | DxfError::ParseError(line)
            | DxfError::UnexpectedCode(_, line)
            | DxfError::UnexpectedByte(_, line)
            | DxfError::UnexpectedEnumValue(line)
            | DxfError::ExpectedTableType(line)
            | DxfError::WrongValueType(line) => lines.get(line.saturating_sub(1)),
            _ => None,
        };
        match place {
            Some(line) => no_drawing(format!("line {line}"), "a value that is none there"),
            None => no_drawing("the file", error.to_string()),
        }
    })?;
    Ok((drawing, left_out))
}

/// Parses a file with the crate `dxf`, which asserts some of what a file has to keep to.
fn load(mut bytes: &[u8], encoding: &'static encoding_rs::Encoding) -> Result<Drawing, DxfError> {
    let load = AssertUnwindSafe(|| Drawing::load_with_encoding(&mut bytes, encoding));
    catch_unwind(load).unwrap_or(Err(DxfError::MalformedString))
}

/// A line or a curve of the drawing, with what gives it its letter.
struct Stroke {
    pieces: Vec<Piece>,
    meaning: Meaning,
    layer: String,
    dashed: bool,
    /// Number of the entity, from 1, and its kind.
    number: usize,
    kind: &'static str,
}

/// Gathers the lines of a drawing.
struct Reader<'a> {
    layers: Layers<'a>,
    blocks: HashMap<String, &'a Block>,
    strokes: Vec<Stroke>,
    /// Numbers of things left out, by what they are.
    left_out: BTreeMap<&'static str, usize>,
    heights: [f64; 2],
    entities: usize,
    pieces: usize,
}

impl<'a> Reader<'a> {
    fn new(
        drawing: &'a Drawing,
        left_out: BTreeMap<&'static str, usize>,
        options: &'a ReadOptions,
    ) -> Self {
        let blocks = drawing.blocks();
        Self {
            layers: Layers::new(drawing, options),
            blocks: blocks
                .map(|block| (block.name.to_uppercase(), block))
                .collect(),
            strokes: Vec::new(),
            left_out,
            heights: [f64::INFINITY, f64::NEG_INFINITY],
            entities: 0,
            pieces: 0,
        }
    }

    /// Reads everything in model space.
    fn read(&mut self, drawing: &'a Drawing) -> Result<(), Wrong> {
        let in_model = drawing
            .entities()
            .filter(|entity| !entity.common.is_in_paper_space);
        for (number, entity) in (1..).zip(in_model) {
            self.read_entity(entity, number, &Placement::default(), &Style::default(), 0)?;
        }
        let paper = drawing
            .entities()
            .filter(|entity| entity.common.is_in_paper_space);
        self.leave_out("things on a layout of paper", paper.count());
        Ok(())
    }

    fn leave_out(&mut self, what: &'static str, count: usize) {
        if count > 0 {
            *self.left_out.entry(what).or_default() += count;
        }
    }

    fn read_entity(
        &mut self,
        entity: &'a Entity,
        number: usize,
        placement: &Placement,
        within: &Style,
        depth: usize,
    ) -> Result<(), Wrong> {
        let too_many = |most: usize| {
            let place = format!("entity {number}");
            (
                place,
                format!("at most {most} things drawn, each place of a block counted"),
                "more".into(),
            )
        };
        self.entities += 1;
        if self.entities > MAX_ENTITIES {
            return Err(too_many(MAX_ENTITIES));
        }
        let style = self.layers.style(&entity.common, within);
        if !entity.common.is_visible || self.layers.is_off(&style) {
            self.leave_out("things that are hidden or on layers that are off", 1);
            return Ok(());
        }
        if let EntityType::Insert(insert) = &entity.specific {
            return self.read_block(insert, number, placement, &style, depth);
        }
        let wrong = |(expected, found)| {
            let place = format!("entity {number} ({}), layer {}", kind(entity), style.layer);
            (place, expected, found)
        };
        let Some(Outline { pieces, heights }) = outline(entity, placement).map_err(wrong)? else {
            self.leave_out(kind(entity), 1);
            return Ok(());
        };
        let Some(meaning) = self.layers.meaning(&style) else {
            self.leave_out("lines on layers of notes", 1);
            return Ok(());
        };
        for height in heights {
            self.heights = [self.heights[0].min(height), self.heights[1].max(height)];
        }
        self.pieces += pieces.len();
        if self.pieces > MAX_LINES {
            return Err(too_many(MAX_LINES));
        }
        self.strokes.push(Stroke {
            pieces,
            meaning,
            dashed: self.layers.is_dashed(&style),
            layer: style.layer,
            number,
            kind: kind(entity),
        });
        Ok(())
    }

    /// Reads what a block holds, at each place of an array.
    fn read_block(
        &mut self,
        insert: &'a Insert,
        number: usize,
        placement: &Placement,
        style: &Style,
        depth: usize,
    ) -> Result<(), Wrong> {
        let place = || format!("entity {number} (INSERT of {})", insert.name);
        if depth >= MAX_DEPTH {
            let expected = format!("at most {MAX_DEPTH} levels of blocks in blocks");
            return Err((
                place(),
                expected,
                "more (a block that holds itself?)".into(),
            ));
        }
        let Some(&block) = self.blocks.get(&insert.name.to_uppercase()) else {
            let found = "no block of this name".to_string();
            return Err((place(), "a block of the file".into(), found));
        };
        let count = |n: i16| n.max(1);
        for row in 0..count(insert.row_count) {
            for column in 0..count(insert.column_count) {
                let cell = [column, row].map(f64::from);
                let inner = placement.of_insert(insert, &block.base_point, cell);
                let inner = inner.map_err(|(expected, found)| (place(), expected, found))?;
                for entity in &block.entities {
                    self.read_entity(entity, number, &inner, style, depth + 1)?;
                }
            }
        }
        Ok(())
    }

    /// Returns the lines with their letters.
    fn into_lines(self, drawing: &Drawing, options: &ReadOptions) -> Result<LooseLines, Wrong> {
        let pieces = self.strokes.iter().flat_map(|stroke| &stroke.pieces);
        let points: Vec<_> = pieces.clone().flat_map(Piece::hull).copied().collect();
        let size = diagonal(&points);
        let [low, high] = self.heights;
        if high - low > FLAT_RATIO * size {
            let found = format!("lines at heights from {low} to {high}");
            return Err((
                "the drawing".into(),
                "a flat drawing, in one plane".into(),
                found,
            ));
        }
        let mut notes = Vec::new();
        let left_out = self.left_out.iter();
        notes.extend(left_out.map(|(what, count)| format!("{what} left out: {count}")));
        notes.extend(
            self.layers
                .unused(self.strokes.iter().map(|stroke| &*stroke.layer)),
        );
        let (unit, note) = unit(drawing.header.default_drawing_units);
        notes.extend(note);
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        let mut chords = Chords::of_pieces(pieces);
        let mut segments = Vec::new();
        let mut names = LineNames::new();
        for stroke in &self.strokes {
            let of_dashes = options.dashes.filter(|_| stroke.dashed);
            let meaning = of_dashes.map_or_else(|| stroke.meaning.clone(), Meaning::Dashed);
            let letter = meaning.letter();
            let named = || {
                let Stroke {
                    number,
                    kind,
                    layer,
                    ..
                } = stroke;
                format!("entity {number} ({kind}), layer {layer}")
            };
            let before = segments.len();
            for piece in &stroke.pieces {
                let piece = piece.straight(STRAIGHT_RATIO * size);
                if let Piece::Curve(curve) = &piece
                    && letter.is_hinge()
                {
                    let found = curve.in_words(Into::into);
                    return Err((named(), STRAIGHT_CREASE.into(), found));
                }
                let lines = chords.lines_of(&piece).ok_or_else(|| {
                    (named(), format!("at most {MAX_LINES} lines"), "more".into())
                })?;
                segments.extend(lines.into_iter().map(|ends| Segment {
                    ends,
                    letter,
                    goal: None,
                }));
            }
            if segments.len() > before {
                let lines = segments[before..].iter().map(|segment| segment.ends);
                names.entry(stroke.layer.clone()).or_default().extend(lines);
                *counts.entry(meaning.key(&stroke.layer)).or_default() += segments.len() - before;
            }
        }
        notes.extend(counts.iter().map(|(key, count)| format!("{key}: {count}")));
        notes.extend(chords.note());
        Ok(LooseLines {
            segments,
            unit,
            notes,
            names,
            ..LooseLines::default()
        })
    }
}

/// Returns the name of a kind of entity, as the format has it; words for those that are no lines.
fn kind(entity: &Entity) -> &'static str {
    match entity.specific {
        EntityType::Line(_) => "LINE",
        EntityType::LwPolyline(_) => "LWPOLYLINE",
        EntityType::Polyline(_) => "POLYLINE",
        EntityType::Arc(_) => "ARC",
        EntityType::Circle(_) => "CIRCLE",
        EntityType::Ellipse(_) => "ELLIPSE",
        EntityType::Spline(_) => "SPLINE",
        EntityType::Text(_) | EntityType::MText(_) | EntityType::Attribute(_) => "texts",
        EntityType::ModelPoint(_) => "points",
        _ => "dimensions, fills and other things that are no lines",
    }
}

/// Returns the unit of lengths, and a note if the file has one without a name here.
fn unit(units: Units) -> (Option<Unit>, Option<String>) {
    let unit = match units {
        Units::Unitless => return (None, None),
        Units::Inches | Units::USSurveyInch => Unit::Inch,
        Units::Millimeters => Unit::Millimetre,
        Units::Centimeters => Unit::Centimetre,
        Units::Meters => Unit::Metre,
        Units::Nanometers => Unit::Nanometre,
        Units::Microns => Unit::Micrometre,
        other => {
            let units = Unit::ALL.map(Unit::name).join(", ");
            let note =
                format!("lengths are without a unit: the file is in {other:?}, not in {units}");
            return (None, Some(note));
        }
    };
    (Some(unit), None)
}
