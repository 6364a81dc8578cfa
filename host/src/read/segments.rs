//! Repairs loose coloured line segments, as drawing programs leave them, into a planar drawing.
//!
//! Ends that nearly meet become one vertex. Lines are split where they cross, where other lines end on them and where
//! they overlap. Creases drawn in pieces become one line. Lines drawn twice are kept once. Lines that end in the open are left out. Every
//! repair is reported with a count. Expected cost: O(n log n), as a uniform grid finds the neighbours of each line.

mod grid;
mod missing_border;
mod names;
mod near_lines;
mod open_ends;
mod perforation;
mod places;
mod planar;
mod repairs;

use std::path::Path;

use nalgebra::Vector2;

pub(super) use self::names::LineNames;
use self::names::edges_of_names;
use self::near_lines::Misses;
pub(super) use self::planar::weight;
use self::planar::{Looks, planar};
use self::repairs::Repairs;
use super::fold::PatternFile;
use super::{FileError, ReadOptions, stem};
use crate::pattern::{
    CreasePattern, Digits, Drawing, LARGEST, Letter, LostLines, NearLines, PatternError, Unit,
};
use crate::progress::Watch;

/// Largest number of lines and of crossings. A hatched sheet has quadratically many crossings, and memory is finite.
pub(super) const MAX_LINES: usize = 1 << 22;

/// A straight line as drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// End points, y pointing up.
    pub(super) ends: [Vector2<f64>; 2],
    /// The letter (FOLD assignment) of the line.
    pub(super) letter: Letter,
    /// Goal fold angle in radians, valley positive.
    pub(super) goal: Option<f64>,
}

/// The ends of lines as they were written, before a transform in single precision.
#[derive(Clone, Debug)]
pub(super) struct Written {
    pub(super) points: Vec<[f64; 2]>,
    /// Factor by which the transform scales lengths.
    pub(super) scale: f64,
    /// `true` if the transform turns.
    pub(super) turned: bool,
}

impl Written {
    /// Returns the ends of lines that are drawn as they were written.
    fn as_drawn(segments: &[Segment]) -> Self {
        let ends = segments.iter().flat_map(|segment| segment.ends);
        Self {
            points: ends.map(Into::into).collect(),
            scale: 1.0,
            turned: false,
        }
    }

    /// Returns the precision of the coordinates of a pattern made of these lines, whose ends the transform may have moved by
    /// `rounding`.
    fn precision(self, pattern: &CreasePattern, rounding: f64) -> Digits {
        let scale = self.scale;
        let rounded = |unit: f64| pattern.looks_rounded(unit * scale);
        match Digits::of_coordinates(self.points.into_iter(), rounded).scaled(scale) {
            Digits::Exact if !self.turned => Digits::Exact,
            digits => digits.coarser(Digits::Single(rounding)),
        }
    }
}

/// The loose lines of a drawing.
#[derive(Clone, Debug, Default)]
pub(super) struct LooseLines {
    pub(super) segments: Vec<Segment>,
    /// Largest distance of an end from the place where it was drawn.
    pub(super) rounding: f64,
    /// The ends as they were written; `None` if they are drawn so.
    pub(super) written: Option<Written>,
    /// `true` if y points down in the drawing. The segments have y pointing up.
    pub(super) y_down: bool,
    /// Unit of lengths, if the drawing has one.
    pub(super) unit: Option<Unit>,
    /// Assumptions made while reading.
    pub(super) notes: Vec<String>,
    /// Names of lines.
    pub(super) names: LineNames,
}

/// A crease pattern made of loose lines.
struct RepairedDrawing {
    pattern: CreasePattern,
    repairs: Repairs,
}

/// Makes a crease pattern of loose lines, titled by the name of the file.
///
/// # Errors
/// If the lines enclose no faces, are too many, or form no crease pattern even when repaired.
pub(super) fn pattern_file(
    path: &Path,
    lines: LooseLines,
    options: &ReadOptions,
    watch: Watch<'_>,
) -> Result<PatternFile, FileError> {
    let LooseLines {
        segments,
        rounding,
        written,
        y_down,
        unit,
        notes,
        names,
    } = lines;
    let written = written.unwrap_or_else(|| Written::as_drawn(&segments));
    let kept = (segments.len() <= MAX_SEARCHED_LINES).then(|| segments.clone());
    let reader = Reader {
        path,
        rounding,
        y_down,
        watch,
    };
    let sheet = reader.sheet(segments, options.tolerance)?;
    let (mut kept_by, mut joined_by) = (None, None);
    if let Some(segments) = kept {
        if sheet.repairs.removed.is_some() {
            let twice = sheet.repairs.twice;
            let keeps_all = |new: &Repairs| new.removed.is_none() && new.twice <= twice;
            kept_by = reader.tolerance_that(&segments, &sheet, 1.0, keeps_all);
        }
        if let Some(misses) = sheet.repairs.misses {
            let joins_all = |new: &Repairs| {
                let is_apart = |left: Misses| left.apart > misses.within;
                new.misses.is_none_or(is_apart)
                    && (new.removed.is_none() || sheet.repairs.removed.is_some())
            };
            joined_by = reader.tolerance_that(&segments, &sheet, ROOM_TO_JOIN, joins_all);
        }
    }
    let length = written.precision(&sheet.pattern, rounding);
    let RepairedDrawing {
        mut pattern,
        repairs,
    } = sheet;
    pattern.lengths_written_with(length);
    pattern.straighten_within(Some(repairs.usual_tolerance));
    pattern.measured_in(unit);
    let mut looks = Looks::for_lines(pattern.edges().len(), watch);
    match edges_of_names(&pattern, names, 2.0 * repairs.tolerance, &mut looks) {
        Some(names) => pattern.name_edges(names),
        None => pattern.assume("names of lines left out: too many lines near each other".into()),
    }
    notes.into_iter().for_each(|note| pattern.assume(note));
    for repair in repairs.in_words(|at| reader.drawn(at)) {
        pattern.repaired(repair);
    }
    if let Some(removed) = &repairs.removed {
        pattern.lose(LostLines {
            count: removed.count,
            longest: removed.longest,
            open_end: reader.drawn(removed.open_end),
            kept_by,
        });
    }
    if let Some(misses) = repairs.misses {
        pattern.leave_apart(NearLines {
            count: misses.count,
            apart: misses.apart,
            at: reader.drawn(misses.at),
            joined_by,
        });
    }
    if y_down {
        pattern.drawn_with_y_down();
    }
    Ok(PatternFile {
        title: stem(path),
        pattern,
    })
}

/// Largest number of lines of a drawing for which a tolerance is looked for that keeps or joins lines.
const MAX_SEARCHED_LINES: usize = 1 << 17;

/// Ratio of the tolerance that is told to join lines to the smallest that does: other ends are off by a little more than
/// those that are found.
const ROOM_TO_JOIN: f64 = 2.0;

/// Largest number of doublings of the tolerance in this search, and of steps in all. Drawings of many lines get fewer.
const MAX_DOUBLINGS: usize = 8;
const MAX_SEARCH_STEPS: usize = 10;

/// Makes sheets of the lines of one drawing.
struct Reader<'a> {
    path: &'a Path,
    rounding: f64,
    y_down: bool,
    watch: Watch<'a>,
}

impl Reader<'_> {
    /// Returns a place in the drawing's own coordinates.
    fn drawn(&self, at: Vector2<f64>) -> [f64; 2] {
        // Subtracting from 0 gives 0 rather than -0.
        [at.x, if self.y_down { 0.0 - at.y } else { at.y }]
    }

    /// Makes a crease pattern of the lines and counts the repairs.
    fn sheet(
        &self,
        segments: Vec<Segment>,
        tolerance: Option<f64>,
    ) -> Result<RepairedDrawing, FileError> {
        let expected = |expected: String, found: String| {
            FileError::expected(self.path, "the drawing", expected, found)
        };
        let finite = |segment: &Segment| {
            let coordinates = segment.ends.iter().flat_map(|end| end.iter());
            coordinates.into_iter().all(|c| c.abs() <= LARGEST)
        };
        if !segments.iter().all(finite) {
            let found = "a larger one".into();
            return Err(expected("coordinates from -1e50 to 1e50".into(), found));
        }
        let drawn = segments.len();
        let too_many = || {
            let found = "more (are lines hatched or drawn many times over?)".into();
            let most = format!(
                "at most {MAX_LINES} lines and crossings, and not too many near each other"
            );
            expected(most, found)
        };
        let planar = planar(segments, self.rounding, tolerance, self.watch);
        let (drawing, repairs) = planar.ok_or_else(too_many)?;
        if drawing.edges.len() < 3 {
            let mut found = format!("{drawn} lines, none of which does");
            for border in repairs.borders_in_words(|at| self.drawn(at)) {
                found = format!("{found}; {border}");
            }
            return Err(expected("lines that enclose faces".into(), found));
        }
        let pattern = self.checked(drawing)?;
        Ok(RepairedDrawing { pattern, repairs })
    }

    /// Looks for the smallest tolerance with which the repairs are as `wanted` and no line becomes too short: doubles the
    /// tolerance until one does, and then halves the interval (of logarithms) that is left. Returns `room` times this
    /// tolerance, if the same holds of that.
    fn tolerance_that(
        &self,
        segments: &[Segment],
        found: &RepairedDrawing,
        room: f64,
        wanted: impl Fn(&Repairs) -> bool,
    ) -> Option<f64> {
        let keeps = |tolerance| {
            let sheet = self.sheet(segments.to_vec(), Some(tolerance));
            sheet.is_ok_and(|sheet| {
                wanted(&sheet.repairs) && sheet.repairs.short <= found.repairs.short
            })
        };
        // Lines that cross many others take longer.
        let pieces = found.pattern.edges().len().max(segments.len());
        let steps = MAX_SEARCH_STEPS.min(MAX_SEARCHED_LINES / pieces.max(1));
        let (mut low, mut high): (f64, Option<f64>) = (found.repairs.tolerance, None);
        for step in 0..steps {
            let next = match high {
                None if step >= MAX_DOUBLINGS => break,
                None => two_digits(2.0 * low),
                Some(high) => two_digits((low * high).sqrt()),
            };
            let is_new = next > low && high.is_none_or(|high| next < high);
            if !is_new || self.watch.is_over() {
                break;
            }
            if keeps(next) {
                high = Some(next);
            } else {
                low = next;
            }
        }
        let smallest = high?;
        let roomy = two_digits(room * smallest);
        Some(if keeps(roomy) { roomy } else { smallest })
    }

    /// Makes the crease pattern of a drawing; an error names its place in the file.
    fn checked(&self, drawing: Drawing) -> Result<CreasePattern, FileError> {
        let path = self.path;
        let vertices = drawing.vertices.clone();
        let edges: Vec<[usize; 2]> = drawing.edges.iter().map(|edge| edge.ends).collect();
        let written = |at: Vector2<f64>| {
            let [x, y] = self.drawn(at);
            format!("({x}, {y})")
        };
        CreasePattern::watched(drawing, self.watch).map_err(|source| {
            if let PatternError::DeadEnd { edge, .. } | PatternError::OneFace { edge } = source {
                let [from, to] = edges[edge].map(|end| written(vertices[end]));
                let place = format!("the line from {from} to {to}");
                let found = "one face all round what it leads to";
                return FileError::expected(path, place, "different faces on its sides", found);
            }
            let frame = match place(&source, &edges).and_then(|vertex| vertices.get(vertex)) {
                Some(at) => format!("near {}, once repaired: ", written(*at)),
                None => "once repaired: ".into(),
            };
            FileError::Pattern {
                path: path.to_path_buf(),
                frame,
                source,
            }
        })
    }
}

/// Rounds a length to two digits, so that it is short to write.
fn two_digits(length: f64) -> f64 {
    format!("{length:.1e}").parse().unwrap_or(length)
}

/// Returns a vertex at which the error lies, if the error has a place.
fn place(error: &PatternError, edges: &[[usize; 2]]) -> Option<usize> {
    match error {
        PatternError::NotFinite { vertex }
        | PatternError::BrokenStar { vertex }
        | PatternError::NoArea { vertex, .. }
        | PatternError::OnEdge { vertex, .. } => Some(*vertex),
        PatternError::NoLength { edge }
        | PatternError::Duplicate { edge, .. }
        | PatternError::Crossing { edge, .. }
        | PatternError::Overlap { edge, .. } => edges.get(*edge).map(|ends| ends[0]),
        _ => None,
    }
}
