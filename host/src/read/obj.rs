//! Reads OBJ files: surfaces in space, with the creases that Freeform Origami writes into comments.
//!
//! A backslash at the end of a line continues it in the next. The reader takes `v` and `f`, and lines `#e a b type angle 0`, of which T. Tachi's Freeform Origami writes one for
//! each side of a face. The types are 0 boundary, 1 diagonal inside a face, 2 valley and 3 mountain. The angle is in
//! degrees, valley positive, seen from where faces run counter-clockwise. All other lines are ignored.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::Vector3;

use super::error::quoted;
use super::fold::{FLAT_PATTERN, NOT_FLAT, PatternFile, lay};
use super::merge::{Vertices, tidied};
use super::{FileError, ShapeFile, stem};
use crate::pattern::{CreasePattern, Drawing, DrawnEdge, LARGEST, Letter};
use crate::progress::Watch;
use crate::unfold::{FoldedShape, ShapeEdge};

/// Parses a folded shape. Vertices of parts that no face joins are merged if they are at the same place, and so are all of
/// them if no two faces share a vertex.
///
/// # Errors
/// If a line is not what its keyword requires, or the file has no faces.
pub(super) fn parse_shape(path: &Path, text: &str) -> Result<ShapeFile, FileError> {
    let Parsed {
        shape,
        lines,
        mut notes,
    } = parse(path, text)?;
    let place = |face: usize| format!("line {}", lines[face] + 1);
    Ok(ShapeFile {
        unit: None,
        title: stem(path),
        shape: tidied(path, shape, Vertices::OfParts, place, &mut notes)?,
        notes,
    })
}

/// Parses a flat crease pattern. Edges without a crease comment are free hinges.
///
/// # Errors
/// Those of [`parse_shape`], or if the vertices lie in no plane or form no crease pattern.
pub(super) fn parse_pattern(
    path: &Path,
    text: &str,
    watch: Watch<'_>,
) -> Result<PatternFile, FileError> {
    let Parsed {
        shape, mut notes, ..
    } = parse(path, text)?;
    let Some((vertices, written)) = lay(&shape.vertices, Some(&shape.faces), &mut notes) else {
        let place = "the vertices";
        return Err(FileError::expected(path, place, FLAT_PATTERN, NOT_FLAT));
    };
    let key = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
    let named = shape.edges.iter().map(|edge| (key(edge.ends), *edge));
    let mut named: HashMap<[usize; 2], ShapeEdge> = named.collect();
    let lettered = !named.is_empty();
    let mut edges = Vec::new();
    for cycle in &shape.faces {
        for (corner, &a) in cycle.iter().enumerate() {
            let ends = [a, cycle[(corner + 1) % cycle.len()]];
            let edge = named.entry(key(ends)).or_insert(ShapeEdge {
                ends,
                letter: Some(Letter::Unassigned),
                angle: None,
            });
            // Taking the letter ensures that an edge shared by two faces is added once.
            if let Some(letter) = edge.letter.take() {
                edges.push(DrawnEdge {
                    ends,
                    letter,
                    goal: edge.angle.filter(|_| letter.is_hinge()),
                });
            }
        }
    }
    if !lettered {
        notes.push("no crease comments (#e): all inner edges taken as free hinges (U)".into());
    }
    let flat = edges.iter().all(|e| e.goal.is_none_or(|g| g.abs() <= 0.0));
    if flat {
        // A goal in which all angles are 0 is the flat sheet, and counts as no goal.
        edges.iter_mut().for_each(|edge| edge.goal = None);
    }
    let drawing = Drawing {
        vertices,
        edges,
        faces: Some(shape.faces),
    };
    let mut pattern =
        CreasePattern::watched(drawing, watch).map_err(|source| FileError::Pattern {
            path: path.to_path_buf(),
            frame: String::new(),
            source,
        })?;
    notes.into_iter().for_each(|note| pattern.assume(note));
    if let Some(length) = written {
        pattern.lengths_written_with(length);
    }
    Ok(PatternFile {
        title: stem(path),
        pattern,
    })
}

/// A problem of a line: the kind that its keyword announces, and the words that stand there.
type Wrong = (String, String);

fn wrong(expected: &str, found: &str) -> Wrong {
    (expected.into(), quoted(found))
}

/// A surface under construction.
#[derive(Default)]
struct Reader {
    shape: FoldedShape,
    /// Index of the line of each face, for errors: the vertices of a face may follow later.
    lines: Vec<usize>,
    /// Letters of the edges that have a crease comment.
    known: HashMap<[usize; 2], Letter>,
    /// Number of crease comments that contradict an earlier comment for the same edge.
    doubtful: usize,
}

/// The content of a file.
struct Parsed {
    shape: FoldedShape,
    /// Index of the line of each face.
    lines: Vec<usize>,
    notes: Vec<String>,
}

fn parse(path: &Path, text: &str) -> Result<Parsed, FileError> {
    let mut reader = Reader::default();
    let at = |line: usize, (expected, found): Wrong| {
        FileError::expected(path, format!("line {}", line + 1), expected, found)
    };
    let mut lines = text.lines().enumerate();
    while let Some((index, line)) = lines.next() {
        let Some(start) = line.trim_end().strip_suffix(CONTINUED) else {
            reader.line(index, line).map_err(|error| at(index, error))?;
            continue;
        };
        let mut parts = vec![start];
        for (_, part) in lines.by_ref() {
            let more = part.trim_end().strip_suffix(CONTINUED);
            parts.push(more.unwrap_or(part));
            if more.is_none() {
                break;
            }
        }
        reader.line(index, &parts.join(" ")).map_err(|error| {
            // The line with the words that were found, of those that are continued.
            let has = |part: &str| part.contains(error.1.trim_matches('"'));
            let part = parts.iter().position(|part| has(part)).unwrap_or(0);
            at(index + part, error)
        })?;
    }
    let Reader {
        shape,
        lines,
        doubtful,
        ..
    } = reader;
    let count = shape.vertices.len();
    for (cycle, &line) in shape.faces.iter().zip(&lines) {
        if let Some(vertex) = cycle.iter().find(|vertex| **vertex >= count) {
            let expected = format!("vertices from 1 to {count}");
            return Err(at(line, wrong(&expected, &(vertex + 1).to_string())));
        }
    }
    if shape.faces.is_empty() {
        let expected = "an OBJ file with faces (f A B C ...)";
        return Err(FileError::expected(path, "the file", expected, "none"));
    }
    let doubt =
        "crease comments (#e) that say otherwise than one before for the same edge, left out";
    let notes = (doubtful > 0).then(|| format!("{doubt}: {doubtful}"));
    Ok(Parsed {
        shape,
        lines,
        notes: notes.into_iter().collect(),
    })
}

/// Sign at the end of a line that goes on in the next.
const CONTINUED: char = '\\';

impl Reader {
    fn line(&mut self, index: usize, line: &str) -> Result<(), Wrong> {
        let mut fields = line.split_whitespace();
        match fields.next() {
            Some("v") => {
                let vertex = vertex(line, fields)?;
                self.shape.vertices.push(vertex);
            }
            Some("f") => {
                let cycle = fields.map(|field| self.reference(field));
                let cycle = cycle.collect::<Result<Vec<_>, _>>()?;
                if cycle.len() < 3 {
                    return Err(wrong("a face, f and at least 3 vertices", line.trim()));
                }
                self.shape.faces.push(cycle);
                self.lines.push(index);
            }
            Some("#e") => self.crease(line)?,
            _ => {}
        }
        Ok(())
    }

    /// Returns the vertex that `A`, `A/T`, `A//N` or `A/T/N` refers to. `A` counts from 1, or from -1 backwards from
    /// the last vertex.
    fn reference(&self, field: &str) -> Result<usize, Wrong> {
        let name = field.split('/').next().unwrap_or_default();
        let count = self.shape.vertices.len();
        let vertex = match name.parse::<i64>() {
            Ok(back) if back < 0 => usize::try_from(back.unsigned_abs())
                .ok()
                .and_then(|back| count.checked_sub(back)),
            Ok(number) => usize::try_from(number).ok().and_then(|n| n.checked_sub(1)),
            Err(_) => None,
        };
        vertex.ok_or_else(|| {
            let expected = format!("a vertex, counted from 1, or from -1 to -{count} backwards");
            wrong(&expected, field)
        })
    }

    /// Reads a crease comment. Comments of another form belong to other programs and are skipped.
    fn crease(&mut self, line: &str) -> Result<(), Wrong> {
        let fields: Vec<&str> = line.split_whitespace().skip(1).take(5).collect();
        let [a, b, kind, angle, ..] = fields.as_slice() else {
            return Ok(());
        };
        let (Ok(a), Ok(b)) = (a.parse::<usize>(), b.parse::<usize>()) else {
            return Ok(());
        };
        let count = self.shape.vertices.len();
        if let Some(vertex) = [a, b].into_iter().find(|v| !(1..=count).contains(v)) {
            return Err(wrong(
                &format!("vertices from 1 to {count}"),
                &vertex.to_string(),
            ));
        }
        let letter = match *kind {
            "0" => Letter::Boundary,
            "1" => return Ok(()),
            "2" => Letter::Valley,
            "3" => Letter::Mountain,
            _ => {
                let types = "a type, 0 boundary, 1 diagonal, 2 valley or 3 mountain";
                return Err(wrong(types, kind));
            }
        };
        let degrees = angle.parse().ok().filter(|angle: &f64| angle.is_finite());
        let degrees = degrees.ok_or_else(|| wrong("an angle in degrees", angle))?;
        let ends = [a - 1, b - 1];
        match self.known.insert([a.min(b), a.max(b)], letter) {
            None => self.shape.edges.push(ShapeEdge {
                ends,
                letter: Some(letter),
                angle: letter.is_hinge().then(|| degrees.to_radians()),
            }),
            Some(before) => self.doubtful += usize::from(before != letter),
        }
        Ok(())
    }
}

/// Parses the coordinates after a `v`; a weight or colour may follow them.
fn vertex<'a>(line: &str, fields: impl Iterator<Item = &'a str>) -> Result<Vector3<f64>, Wrong> {
    let mut coordinates = [0.0; 3];
    let mut count = 0;
    for (coordinate, field) in coordinates.iter_mut().zip(fields) {
        let number = field.parse().ok().filter(|n: &f64| n.abs() <= LARGEST);
        *coordinate = number.ok_or_else(|| wrong("a coordinate from -1e50 to 1e50", field))?;
        count += 1;
    }
    match count {
        3 => Ok(coordinates.into()),
        _ => Err(wrong("a vertex, v and 3 coordinates", line.trim())),
    }
}
