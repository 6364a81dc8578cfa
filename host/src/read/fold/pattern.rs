//! Reads the flat crease pattern of a FOLD file and its goal fold angles.

use core::f64::consts::PI;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use nalgebra::Vector3;

use super::document::{Document, Frame, Frames, Located};
use super::keys;
use super::measured::measured;
use super::plane::{FLAT_PATTERN, NOT_FLAT, lay};
use crate::pattern::{
    CreasePattern, Digits, Drawing, DrawnEdge, EdgeId, LARGEST, Letter, PatternError, Precision,
    Unit, check_goal,
};
use crate::progress::Watch;
use crate::read::curves::{Chords, Curve, STRAIGHT_CREASE};
use crate::read::error::quoted;
use crate::read::segments::{self, LooseLines, MAX_LINES, Segment, Written};
use crate::read::{FileError, ReadOptions, stem};

/// A crease pattern read from a file.
#[derive(Clone, Debug)]
pub struct PatternFile {
    /// The file's title, or else its name.
    pub title: String,
    /// The pattern, with the goal angles that the file names.
    pub pattern: CreasePattern,
}

/// Parses a crease pattern. Its goal angles are those of the last folded frame that names angles, or else those of the
/// pattern's own frame, or else the angles measured on the last folded frame that has positions. A goal in which all
/// angles are 0 is the flat sheet, and counts as no goal. With a tolerance, its edges are
/// repaired like the lines of a drawing.
///
/// # Errors
/// If the bytes hold no flat crease pattern.
pub(in crate::read) fn parse_within(
    path: &Path,
    bytes: &[u8],
    options: &ReadOptions,
    watch: Watch<'_>,
) -> Result<PatternFile, FileError> {
    let document = &Document::parse(path, bytes)?;
    let frames = document.frames()?;
    let flat = flat_frame(document, &frames, options.frame)?;
    let frame = frames.get(flat);
    let angles = goal_angles(&frames, &frame, options.frame)?;
    let mut file = with_repairs(document, &frames, flat, angles.as_ref(), options, watch)?;
    if let Some(note) = angles.as_ref().and_then(Goals::looks_like_radians) {
        file.pattern.assume(note);
    }
    if let Some(note) = other_patterns(&frames, flat) {
        file.pattern.assume(note);
    }
    Ok(file)
}

/// Parses the pattern of frame number `flat`, and repairs its edges if they form no crease pattern.
fn with_repairs(
    document: &Document,
    frames: &Frames<'_>,
    flat: usize,
    angles: Option<&Goals>,
    options: &ReadOptions,
    watch: Watch<'_>,
) -> Result<PatternFile, FileError> {
    let frame = frames.get(flat);
    if options.tolerance.is_some() {
        return repaired(document, &frame, angles, options, watch);
    }
    let mut file = match pattern_of(document, &frame, angles, watch) {
        Ok(file) => file,
        Err(error) => {
            let repairable = matches!(
                &error,
                FileError::Pattern {
                    source: PatternError::Duplicate { .. }
                        | PatternError::Crossing { .. }
                        | PatternError::OnEdge { .. }
                        | PatternError::Overlap { .. }
                        | PatternError::DeadEnd { .. },
                    ..
                }
            );
            if !repairable {
                return Err(error);
            }
            // A crease that ends in a panel may be a piece of one; left out, it would be better named.
            let repaired = repaired(document, &frame, angles, options, watch);
            let is_whole = |file: &PatternFile| {
                let source = match &error {
                    FileError::Pattern { source, .. } => Some(source),
                    _ => None,
                };
                !matches!(source, Some(PatternError::DeadEnd { .. }))
                    || file.pattern.lost_lines().is_none()
            };
            return repaired.ok().filter(is_whole).ok_or(error);
        }
    };
    if angles.is_none() {
        match measured(frames, Some(flat), &file.pattern) {
            Ok(Some(goals)) if goals.leads_away() => {
                file = pattern_of(document, &frame, Some(&goals), watch)?;
                let note = format!("the goal is measured on {}vertices_coords", goals.frame);
                file.pattern.assume(note);
            }
            Ok(_) => {}
            Err(error) => {
                let note = format!("the folded frame is no goal: {error}");
                file.pattern.assume(note);
            }
        }
    }
    Ok(file)
}

/// Makes a crease pattern of edges by the repairs for loose lines.
///
/// # Errors
/// If the repaired lines form no crease pattern, or if the file names faces, which already determine the sheet.
fn repaired(
    document: &Document,
    frame: &Frame<'_>,
    goals: Option<&Goals>,
    options: &ReadOptions,
    watch: Watch<'_>,
) -> Result<PatternFile, FileError> {
    let mut notes = Vec::from_iter(keys::not_known(document));
    let unit = unit(frame, &mut notes)?;
    let drawn = drawing(document, frame, goals, &mut notes)?;
    let coordinates = drawn.coordinates();
    let FrameDrawing {
        drawing, written, ..
    } = drawn;
    let wrong =
        |expected: &str, found: &str| document.expected("the tolerance".into(), expected, found);
    if drawing.faces.is_some() {
        let found = "faces_vertices, which say what meets";
        return Err(wrong("a drawing of lines without faces", found));
    }
    notes.push("edges are counted anew, as lines were repaired".into());
    let segments = drawing.edges.iter().map(|edge| {
        let [from, to] = edge.ends.map(|end| drawing.vertices.get(end).copied());
        Some(Segment {
            ends: [from?, to?],
            letter: edge.letter,
            goal: edge.goal,
        })
    });
    let lines = LooseLines {
        segments: segments
            .collect::<Option<_>>()
            .ok_or_else(|| wrong("edges between vertices", "an edge to none"))?,
        notes,
        written: coordinates.map(|points| Written {
            points,
            scale: 1.0,
            turned: false,
        }),
        ..LooseLines::default()
    };
    let mut file = segments::pattern_file(&document.path, lines, options, watch)?;
    take_precision(&mut file.pattern, frame, written)?;
    file.pattern.measured_in(unit);
    let title = title(document, frame)?;
    Ok(PatternFile { title, ..file })
}

/// Frames of a file whose fold angles are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalFrames {
    /// The frame that has the goal. If the file names no angles at all, they are measured on its folded frame.
    Last,
    /// Each frame beside the key frame that has fold angles, in their order.
    Each,
}

/// Parses the goal fold angles (radians) of another file of the same sheet. Returns for each frame that is asked for one angle
/// for each crease of `pattern`; `None` where the file names no angle. `path` names the file in errors.
///
/// # Errors
/// If the bytes hold neither angles nor the folded sheet, or not one angle for each edge of the pattern.
pub fn parse_goals(
    path: &Path,
    bytes: &[u8],
    pattern: &CreasePattern,
    which: GoalFrames,
) -> Result<Vec<Vec<Option<f64>>>, FileError> {
    let document = &Document::parse(path, bytes)?;
    let frames = document.frames()?;
    if which == GoalFrames::Each {
        let found = (1..=frames.len()).filter_map(|number| goals(&frames.own(number)).transpose());
        let angles = found.map(|goals| angles_of_creases(&goals?, document, pattern));
        let angles: Vec<_> = angles.collect::<Result<_, FileError>>()?;
        if angles.is_empty() {
            let expected = "frames with edges_foldAngle";
            return Err(document.expected("file_frames".into(), expected, "none"));
        }
        return Ok(angles);
    }
    let goals = match goal_angles(&frames, &document.key_frame(), None)? {
        None => measured(&frames, None, pattern)?,
        goals => goals,
    };
    let Some(goals) = goals.filter(Goals::leads_away) else {
        let place = "edges_foldAngle".into();
        return Err(document.expected(place, "goal angles other than 0", "none"));
    };
    Ok(vec![angles_of_creases(&goals, document, pattern)?])
}

/// Returns the angle of each crease of a pattern.
///
/// # Errors
/// If there is not one angle for each edge, or an angle is beyond its range.
fn angles_of_creases(
    goals: &Goals,
    document: &Document,
    pattern: &CreasePattern,
) -> Result<Vec<Option<f64>>, FileError> {
    // A file of the drawing lacks the second sides of cuts; a file written by this program has them.
    if goals.angles.len() != pattern.edges().len() {
        goals.check_count(document, pattern.drawn_edges())?;
    }
    for (index, (edge, &angle)) in pattern.edges().iter().zip(&goals.angles).enumerate() {
        check_goal(index, edge.letter, angle).map_err(|error| goals.place_of(document, error))?;
    }
    let creases = pattern.creases().iter();
    let goal =
        |edge: &EdgeId| goals.angles[edge.index()].filter(|_| !pattern.slits().contains(edge));
    Ok(creases.map(goal).collect())
}

pub(super) fn pattern_of(
    document: &Document,
    frame: &Frame<'_>,
    goals: Option<&Goals>,
    watch: Watch<'_>,
) -> Result<PatternFile, FileError> {
    let mut notes = Vec::from_iter(keys::not_known(document));
    let unit = unit(frame, &mut notes)?;
    let drawn = drawing(document, frame, goals, &mut notes)?;
    let coordinates = drawn.coordinates();
    // The numbers of chords are those of all edges.
    let doubles = without_doubles(&drawn.drawing).filter(|_| coordinates.is_none());
    let repaired = doubles.and_then(|(drawing, note)| {
        let pattern = CreasePattern::watched(drawing, watch).ok()?;
        notes.push(note);
        Some(pattern)
    });
    let pattern = repaired.map_or_else(|| CreasePattern::watched(drawn.drawing, watch), Ok);
    let mut pattern = pattern.map_err(|source| match (&source, goals) {
        (PatternError::GoalRange { .. } | PatternError::GoalSign { .. }, Some(goals)) => {
            goals.place_of(document, source)
        }
        _ => FileError::Pattern {
            path: document.path.clone(),
            frame: frame.prefix_of(&source.to_string()),
            source,
        },
    })?;
    for note in notes {
        pattern.assume(note);
    }
    if let Some(coordinates) = coordinates {
        pattern.add_chords(drawn.edges);
        let rounded = |unit: f64| pattern.looks_rounded(unit);
        let length = Digits::of_coordinates(coordinates.into_iter(), rounded);
        pattern.lengths_written_with(length);
    }
    take_precision(&mut pattern, frame, drawn.written)?;
    pattern.measured_in(unit);
    Ok(PatternFile {
        title: title(document, frame)?,
        pattern,
    })
}

/// Returns the title of a frame, or of its file, or else the file's name.
pub(super) fn title(document: &Document, frame: &Frame<'_>) -> Result<String, FileError> {
    let title = ["frame_title", "file_title"]
        .iter()
        .find_map(|key| frame.get(key));
    match title {
        Some(title) => Ok(title.text()?.to_string()),
        None => Ok(stem(&document.path)),
    }
}

/// Returns a drawing with faces without the edges that join the same vertices as an edge before them, and a note; `None` if
/// there are none. Of such edges the one stays whose letter has the highest precedence, as of lines that lie on each other.
/// Without faces they are repaired as the lines of a drawing.
fn without_doubles(drawing: &Drawing) -> Option<(Drawing, String)> {
    let faces = drawing.faces.clone()?;
    let (mut first_at, mut first_double) = (HashMap::new(), None);
    let mut kept: Vec<DrawnEdge> = Vec::with_capacity(drawing.edges.len());
    for (index, edge) in drawing.edges.iter().enumerate() {
        let [a, b] = edge.ends;
        let at = *first_at.entry([a.min(b), a.max(b)]).or_insert(kept.len());
        match kept.get_mut(at) {
            None => kept.push(*edge),
            Some(first) => {
                first_double.get_or_insert(index);
                if segments::weight(edge.letter) > segments::weight(first.letter) {
                    *first = *edge;
                }
            }
        }
    }
    let first = first_double?;
    let left_out = drawing.edges.len() - kept.len();
    let note = format!(
        "edges that join the same vertices as an edge before, left out: {left_out} (first: edge {first}); edges are \
         counted anew"
    );
    let kept = Drawing {
        vertices: drawing.vertices.clone(),
        edges: kept,
        faces: Some(faces),
    };
    Some((kept, note))
}

/// Returns the number of the frame with the flat sheet: the `chosen` one, or else the first frame of class
/// `creasePattern`, or else the key frame.
fn flat_frame(
    document: &Document,
    frames: &Frames<'_>,
    chosen: Option<usize>,
) -> Result<usize, FileError> {
    match chosen {
        Some(number) if number > frames.len() => {
            let place = format!("file_frames[{}]", number - 1);
            Err(document.expected(place, "a frame", "none"))
        }
        Some(number) => Ok(number),
        None => {
            let first = frames.classes.iter().position(|it| it.crease_pattern);
            Ok(first.unwrap_or(0))
        }
    }
}

/// Returns a note of the frames that have crease patterns of their own, other than the one that is read.
fn other_patterns(frames: &Frames<'_>, flat: usize) -> Option<String> {
    let is_pattern = |number: &usize| {
        let frame = frames.own(*number);
        let drawn = ["vertices_coords", "edges_vertices", "faces_vertices"];
        !frames.inherits(flat, *number)
            && !frames.classes[*number].folded_form
            && drawn[1..].iter().any(|key| frame.own(key).is_some())
            && frame.own(drawn[0]).is_some()
    };
    let others: Vec<String> = (0..=frames.len())
        .filter(is_pattern)
        .map(|number| number.to_string())
        .collect();
    (!others.is_empty()).then(|| {
        format!(
            "frame {flat} is read; the file has other crease patterns, frames counted from 0, the key frame: {}",
            others.join(", ")
        )
    })
}

/// Goal angles of all edges.
pub(super) struct Goals {
    /// Radians; `None` for null.
    pub(super) angles: Vec<Option<f64>>,
    /// Prefix that names the frame of the angles in places.
    pub(super) frame: String,
}

impl Goals {
    /// Returns `true` if any angle differs from 0. A goal without such an angle is the flat sheet.
    pub(super) fn leads_away(&self) -> bool {
        self.angles.iter().flatten().any(|angle| angle.abs() > 0.0)
    }

    pub(super) fn check_count(&self, document: &Document, edges: usize) -> Result<(), FileError> {
        if self.angles.len() == edges {
            return Ok(());
        }
        let place = format!("{}edges_foldAngle", self.frame);
        let expected = format!("{edges} entries, one for each edge");
        Err(document.expected(place, &expected, &self.angles.len().to_string()))
    }

    /// Returns a note if the angles look as if they were radians: all are within half a turn in radians, and one is a
    /// twelfth of it or a multiple.
    fn looks_like_radians(&self) -> Option<String> {
        let angles = self.angles.iter().flatten().map(|angle| angle.to_degrees());
        let largest = angles.clone().map(f64::abs).fold(0.0, f64::max);
        let is_fraction = |angle: f64| {
            let twelfths = 12.0 * angle / PI;
            twelfths.abs() > 0.5 && (twelfths - twelfths.round()).abs() < 1e-3
        };
        (largest <= PI + 1e-3 && angles.clone().any(is_fraction)).then(|| {
            format!(
                "fold angles up to {largest:.6} look like radians: FOLD has degrees, 180 for a fold onto itself, and they \
                 are read as degrees"
            )
        })
    }

    fn place_of(&self, document: &Document, source: PatternError) -> FileError {
        FileError::Pattern {
            path: document.path.clone(),
            frame: self.frame.clone(),
            source,
        }
    }
}

/// Returns the goal of the last folded frame that names a goal other than zeros, or else the goal of the flat frame. If
/// all of these goals are zeros, returns the first of them found. If the flat frame was `chosen`, only frames that inherit
/// from it count.
fn goal_angles(
    frames: &Frames<'_>,
    flat: &Frame<'_>,
    chosen: Option<usize>,
) -> Result<Option<Goals>, FileError> {
    let latest_first = (1..=frames.len()).rev().chain([0]);
    let folded = latest_first.filter(|&number| {
        let of_sheet = chosen.is_none_or(|chosen| frames.inherits(number, chosen));
        frames.classes[number].folded_form && of_sheet
    });
    let folded = folded.map(|number| goals(&frames.own(number)));
    let mut zeros = None;
    for found in folded.chain(core::iter::once_with(|| goals(flat))) {
        match found? {
            Some(goals) if goals.leads_away() => return Ok(Some(goals)),
            found => zeros = zeros.or(found),
        }
    }
    Ok(zeros)
}

/// Returns the angles that a frame itself names; `None` if it names none.
pub(super) fn goals(frame: &Frame<'_>) -> Result<Option<Goals>, FileError> {
    // Before FOLD 1.1 the key ended in an s.
    let list = ["edges_foldAngle", "edges_foldAngles"]
        .into_iter()
        .find_map(|key| frame.own(key));
    let Some(list) = list else {
        return Ok(None);
    };
    let radians = list.entries()?.map(|entry| {
        if entry.is_null() {
            return Ok(None);
        }
        Ok(Some(entry.number()?.to_radians()))
    });
    let angles: Vec<Option<f64>> = radians.collect::<Result<_, FileError>>()?;
    let frame = frame.prefix();
    Ok(Some(Goals { angles, frame }))
}

/// Takes the precision that a frame tells of its numbers, or else that of its coordinates if they had to be turned into a
/// plane.
fn take_precision(
    pattern: &mut CreasePattern,
    frame: &Frame<'_>,
    written: Option<Digits>,
) -> Result<(), FileError> {
    if let Some(length) = written {
        pattern.lengths_written_with(length);
    }
    let Some(list) = frame.own("foldpath:precision") else {
        return Ok(());
    };
    let units = list.entries()?.map(|entry| match entry.number()? {
        unit if (0.0..LARGEST).contains(&unit) => Ok(Digits::of_unit(unit)),
        _ => Err(entry.expected("a unit of at least 0")),
    });
    let [length, degrees] = units.collect::<Result<Vec<_>, FileError>>()?[..] else {
        return Err(list.expected("two units: of lengths, and of angles in degrees"));
    };
    pattern.written_with(Precision {
        length,
        angle: degrees.scaled(1_f64.to_radians()),
    });
    Ok(())
}

/// Returns the unit of lengths that a frame names; a name that is none of FOLD's is noted.
pub(super) fn unit(frame: &Frame<'_>, notes: &mut Vec<String>) -> Result<Option<Unit>, FileError> {
    let Some(name) = frame.get("frame_unit").filter(|name| !name.is_null()) else {
        return Ok(None);
    };
    let name = name.text()?;
    let unit = Unit::from_name(name);
    if unit.is_none() && name != NO_UNIT {
        let shown = quoted(name);
        notes.push(format!(
            "frame_unit: {shown} is none of FOLD's units, lengths are taken to have none"
        ));
    }
    Ok(unit)
}

/// Largest distance of the control points of a straight curve from the line between its ends, over the largest coordinate.
const STRAIGHT_RATIO: f64 = 1e-9;

/// FOLD's name of lengths without a unit.
const NO_UNIT: &str = "unit";

/// The drawing of a frame.
struct FrameDrawing {
    drawing: Drawing,
    /// The precision of the coordinates, if they had to be turned into a plane.
    written: Option<Digits>,
    /// Numbers of vertices and edges of the frame; those behind them are of the chords of curves.
    vertices: usize,
    edges: usize,
}

impl FrameDrawing {
    /// Returns the coordinates of the file if the drawing has others as well.
    fn coordinates(&self) -> Option<Vec<[f64; 2]>> {
        let vertices = &self.drawing.vertices;
        let own = vertices[..self.vertices].iter().map(|&at| at.into());
        (vertices.len() > self.vertices).then(|| own.collect())
    }
}

/// Returns the drawing of a frame.
fn drawing(
    document: &Document,
    frame: &Frame<'_>,
    goals: Option<&Goals>,
    notes: &mut Vec<String>,
) -> Result<FrameDrawing, FileError> {
    let points = points(frame)?;
    let faces = faces(frame)?;
    let Some((vertices, written)) = lay(&points, faces.as_deref(), notes) else {
        return Err(document.expected("vertices_coords".into(), FLAT_PATTERN, NOT_FLAT));
    };
    let DrawnEnds { ends, curves } = edges(document, frame, faces.as_deref(), notes)?;
    if let Some(goals) = goals {
        goals.check_count(document, ends.len())?;
    }
    let goals = goals.filter(|goals| goals.leads_away());
    let letters = letters(frame, ends.len(), notes)?;
    let drawn = ends
        .into_iter()
        .zip(letters)
        .enumerate()
        .map(|(index, (ends, letter))| DrawnEdge {
            ends,
            letter,
            goal: goals.and_then(|goals| goals.angles[index]),
        });
    let mut drawing = Drawing {
        vertices,
        edges: drawn.collect(),
        faces,
    };
    let [vertices, edges] = [drawing.vertices.len(), drawing.edges.len()];
    if !curves.is_empty() {
        draw_chords(document, frame, &mut drawing, &curves, notes)?;
    }
    Ok(FrameDrawing {
        drawing,
        written,
        vertices,
        edges,
    })
}

/// Replaces curves by chords: the first chord keeps the number of the edge, the others come behind all edges. `curves` has
/// the number of each edge and its control points.
fn draw_chords(
    document: &Document,
    frame: &Frame<'_>,
    drawing: &mut Drawing,
    curves: &[(usize, [usize; 2])],
    notes: &mut Vec<String>,
) -> Result<(), FileError> {
    let place = |edge: usize| format!("{}edges_vertices[{edge}]", frame.prefix());
    let mut chords = Chords::new(&drawing.vertices, Vec::new());
    // The places between the ends of each curve, by its ends.
    let mut between: HashMap<[usize; 2], Vec<usize>> = HashMap::new();
    for &(edge, controls) in curves {
        let [from, to] = drawing.edges[edge].ends;
        let hull = [from, controls[0], controls[1], to];
        let known = hull.map(|vertex| drawing.vertices.get(vertex).copied());
        let [Some(a), Some(b), Some(c), Some(d)] = known else {
            let expected = format!(
                "vertices from 0 to {}",
                drawing.vertices.len().saturating_sub(1)
            );
            return Err(document.expected(place(edge), &expected, &format!("{hull:?}")));
        };
        let curve = Curve([a, b, c, d]);
        if curve.is_straight(STRAIGHT_RATIO * a.amax().max(d.amax())) {
            continue;
        }
        if drawing.edges[edge].letter.is_hinge() {
            let found = curve.in_words(|at| [at.x, at.y]);
            return Err(document.expected(place(edge), STRAIGHT_CREASE, &found));
        }
        let Some(places) = chords.of(&curve) else {
            let expected = format!("curves of at most {MAX_LINES} chords in all");
            return Err(document.expected(place(edge), &expected, "more"));
        };
        let first = drawing.vertices.len();
        drawing.vertices.extend(&places[1..places.len() - 1]);
        let inner: Vec<usize> = (first..drawing.vertices.len()).collect();
        let way = [&[from], &inner[..], &[to]].concat();
        drawing.edges[edge].ends = [way[0], way[1]];
        let others = way[1..].windows(2).map(|pair| DrawnEdge {
            ends: [pair[0], pair[1]],
            ..drawing.edges[edge]
        });
        let others: Vec<DrawnEdge> = others.collect();
        drawing.edges.extend(others);
        between.insert([to, from], inner.iter().rev().copied().collect());
        between.insert([from, to], inner);
    }
    for face in drawing.faces.iter_mut().flatten() {
        let corners = core::mem::take(face);
        for (&a, &b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            face.push(a);
            face.extend(between.get(&[a, b]).into_iter().flatten());
        }
    }
    notes.extend(chords.note());
    Ok(())
}

pub(super) fn points(frame: &Frame<'_>) -> Result<Vec<Vector3<f64>>, FileError> {
    let point = |entry: Located<'_>| {
        let mut coordinates = entry.entries()?;
        let count = coordinates.len();
        if !(2..=3).contains(&count) {
            return Err(entry.expected("2 or 3 coordinates"));
        }
        let mut next = || coordinates.next().map_or(Ok(0.0), coordinate);
        Ok(Vector3::new(next()?, next()?, next()?))
    };
    frame
        .require("vertices_coords")?
        .entries()?
        .map(point)
        .collect()
}

/// Returns a coordinate. Its bound guarantees that its square does not overflow.
fn coordinate(entry: Located<'_>) -> Result<f64, FileError> {
    let number = entry.number()?;
    if number.abs() > LARGEST {
        return Err(entry.expected("a coordinate from -1e50 to 1e50"));
    }
    Ok(number)
}

fn indices(entry: &Located<'_>) -> Result<Vec<usize>, FileError> {
    entry.entries()?.map(|index| index.index()).collect()
}

pub(super) fn faces(frame: &Frame<'_>) -> Result<Option<Vec<Vec<usize>>>, FileError> {
    let Some(faces) = frame.get("faces_vertices") else {
        return Ok(None);
    };
    let faces: Vec<_> = faces
        .entries()?
        .map(|f| indices(&f))
        .collect::<Result<_, _>>()?;
    Ok((!faces.is_empty()).then_some(faces))
}

/// The edges of a frame.
#[derive(Default)]
pub(super) struct DrawnEnds {
    /// The ends of each edge.
    pub(super) ends: Vec<[usize; 2]>,
    /// The edges that are cubic Bézier curves, with their control points.
    pub(super) curves: Vec<(usize, [usize; 2])>,
}

/// Returns the edges of a frame. An edge of two vertices is a line; two more vertices are the control points of a curve.
pub(super) fn edges(
    document: &Document,
    frame: &Frame<'_>,
    faces: Option<&[Vec<usize>]>,
    notes: &mut Vec<String>,
) -> Result<DrawnEnds, FileError> {
    if let Some(edges) = frame.get("edges_vertices") {
        let mut drawn = DrawnEnds::default();
        for (edge, entry) in edges.entries()?.enumerate() {
            match indices(&entry)?[..] {
                [a, b] => drawn.ends.push([a, b]),
                [a, b, first, second] => {
                    drawn.ends.push([a, b]);
                    drawn.curves.push((edge, [first, second]));
                }
                _ => return Err(entry.expected("2 vertices, or 4 of a curve")),
            }
        }
        return Ok(drawn);
    }
    let of_edges = ["edges_assignment", "edges_foldAngle", "edges_foldAngles"];
    if let Some(key) = of_edges.into_iter().find(|key| frame.get(key).is_some()) {
        let expected = format!("a list, as {key} speaks of edges");
        return Err(frame.missing("edges_vertices", &expected));
    }
    let mut edges = BTreeMap::new();
    let mut add = |a: usize, b: usize| {
        let next = edges.len();
        edges.entry([a.min(b), a.max(b)]).or_insert(next);
    };
    if let Some(faces) = faces {
        notes.push("edges_vertices is missing: edges taken from the faces".into());
        for face in faces {
            let next = face.iter().cycle().skip(1);
            face.iter().zip(next).for_each(|(&a, &b)| add(a, b));
        }
    } else if let Some(neighbours) = frame.get("vertices_vertices") {
        notes.push("edges_vertices is missing: edges taken from vertices_vertices".into());
        for (vertex, list) in neighbours.entries()?.enumerate() {
            indices(&list)?
                .into_iter()
                .for_each(|other| add(vertex, other));
        }
    } else {
        let place = "edges_vertices".into();
        let expected = "a list (or faces_vertices, or vertices_vertices)";
        return Err(document.expected(place, expected, "nothing"));
    }
    let mut edges: Vec<_> = edges.into_iter().collect();
    edges.sort_by_key(|(_, order)| *order);
    Ok(DrawnEnds {
        ends: edges.into_iter().map(|(ends, _)| ends).collect(),
        curves: Vec::new(),
    })
}

pub(super) fn letters(
    frame: &Frame<'_>,
    edges: usize,
    notes: &mut Vec<String>,
) -> Result<Vec<Letter>, FileError> {
    let Some(list) = frame.get("edges_assignment") else {
        notes.push("edges_assignment is missing: all inner edges taken as free hinges (U)".into());
        return Ok(vec![Letter::Unassigned; edges]);
    };
    let mut unknown: BTreeMap<String, usize> = BTreeMap::new();
    let mut small = 0_usize;
    let mut letters = Vec::with_capacity(edges);
    for entry in list.entries_of(edges, "edge")? {
        let code = entry.text()?;
        let letter = Letter::from_code(code);
        small += usize::from(letter.is_some_and(|letter| !code.starts_with(letter.code())));
        letters.push(letter.unwrap_or_else(|| {
            *unknown.entry(code.chars().take(20).collect()).or_default() += 1;
            Letter::Unassigned
        }));
    }
    if small > 0 {
        notes.push(format!(
            "letters in edges_assignment that are written small, taken as capitals: {small}"
        ));
    }
    for (code, count) in unknown {
        notes.push(format!(
            "{count} edges lettered \"{code}\", which FOLD does not know, taken as U"
        ));
    }
    Ok(letters)
}
