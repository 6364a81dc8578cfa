//! Loose coloured line segments, as drawing programs leave them, made into a planar drawing.
//!
//! Ends that nearly meet become one vertex, lines are split where they cross, where others end on them
//! and where they overlap, what is drawn twice is kept once, and lines are left out that end in the open
//! or lie within a panel. Whatever was done is said, with counts. Expected cost: n log n, a uniform grid finding what is
//! near.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::Vector2;
use robust::{Coord, orient2d};

use super::FileError;
use super::fold::PatternFile;
use crate::pattern::{CreasePattern, Drawing, DrawnEdge, LARGEST, Letter, PatternError};
use crate::ragged::{Ragged, group_by_key};

/// What is nearer than this fraction of the median line counts as one place. Drawing programs write about
/// seven digits and people snap to a grid, while the closest true vertices of a tessellation are a tenth
/// of a line apart.
const OF_MEDIAN: f64 = 1e-3;

/// The same as a fraction of the sheet's diagonal, which holds where lines run right across the sheet.
const OF_DIAGONAL: f64 = 1e-4;

/// How far, as a fraction of its line, an end may be from the one vertex that it was meant to meet.
const OF_LINE: f64 = 0.05;

/// The same as a fraction of the diagonal. Origami Simulator joins what is within 3 pixels, in drawings of
/// about a thousand.
const OPEN: f64 = 1.0 / 300.0;

/// Below this fraction of the diagonal, places differ by rounding alone.
const ROUNDING: f64 = 1e-9;

/// Lines and crossings at most: a hatched sheet has quadratically many crossings, and memory is finite.
pub(super) const MOST: usize = 1 << 22;

/// Looks at most from lines at what is near them, for each line and in all: where all lines are in one place,
/// each is near all others. In tessellations there are some hundreds for each.
const LOOKS: [usize; 2] = [1 << 11, 1 << 28];

/// Splitting moves lines by up to the tolerance, and may so make them cross anew.
const ROUNDS: usize = 8;

/// A straight line as drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// Where it ends, y pointing up.
    pub(super) ends: [Vector2<f64>; 2],
    /// What it is for.
    pub(super) letter: Letter,
    /// Goal fold angle in radians, valley positive.
    pub(super) goal: Option<f64>,
}

/// Makes a crease pattern of segments, titled by the name of the file, with notes of what was assumed.
/// `rounding` is how far their ends may be from where they were drawn.
///
/// # Errors
/// If the lines enclose no faces, are too many, or make no crease pattern even when repaired.
pub(super) fn pattern_file(
    path: &Path,
    segments: Vec<Segment>,
    rounding: f64,
    notes: Vec<String>,
) -> Result<PatternFile, FileError> {
    let expected = |expected: String, found: String| FileError::Expected {
        path: path.to_path_buf(),
        place: "the drawing".into(),
        expected,
        found,
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
        let most = format!("at most {MOST} lines and crossings, and not too many near each other");
        expected(most, found)
    };
    let (drawing, mut repairs) = planar(segments, rounding).ok_or_else(too_many)?;
    if drawing.edges.len() < 3 {
        let found = format!("{drawn} lines, none of which does");
        return Err(expected("lines that enclose faces".into(), found));
    }
    let mut pattern = checked(path, drawing.clone())?;
    let (drawing, left_out) = without_islands(&pattern, drawing).ok_or_else(too_many)?;
    if left_out > 0 {
        pattern = checked(path, drawing)?;
        repairs.push(format!(
            "lines inside a panel and joined to nothing, which could not fold, left out with what they \
             enclose: {left_out}"
        ));
    }
    notes.into_iter().for_each(|note| pattern.assume(note));
    for repair in repairs {
        pattern.repaired(repair);
    }
    let title = path.file_stem().unwrap_or_default();
    Ok(PatternFile {
        title: title.to_string_lossy().into_owned(),
        pattern,
    })
}

/// The crease pattern of a drawing; an error says where in the file it is.
fn checked(path: &Path, drawing: Drawing) -> Result<CreasePattern, FileError> {
    let vertices = drawing.vertices.clone();
    let edges: Vec<[usize; 2]> = drawing.edges.iter().map(|edge| edge.ends).collect();
    // As the file has it, y pointing down.
    let written = |at: Vector2<f64>| format!("({}, {})", at.x, 0.0 - at.y);
    CreasePattern::new(drawing).map_err(|source| {
        if let Some(bridge) = bridge(vertices.len(), &edges) {
            let [from, to] = edges[bridge].map(|end| written(vertices[end]));
            return FileError::Expected {
                path: path.to_path_buf(),
                place: format!("the line from {from} to {to}"),
                expected: "different faces on its sides".into(),
                found: "one face all round what it leads to".into(),
            };
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

/// The drawing without the sheets that lie inside a face of another, and how many lines those have; `None`
/// if there are too many to tell.
fn without_islands(pattern: &CreasePattern, mut drawing: Drawing) -> Option<(Drawing, usize)> {
    if pattern.sheets() < 2 {
        return Some((drawing, 0));
    }
    let points = pattern.vertices();
    let mut corners = vec![None; pattern.sheets()];
    let mut faces = Vec::new();
    for (face, &sheet) in pattern.faces().iter().zip(pattern.sheet_of_faces()) {
        let polygon = || face.iter().map(|vertex| points[vertex.index()]);
        corners[sheet as usize].get_or_insert(points[face[0].index()]);
        let [low, high] = polygon().fold([points[face[0].index()]; 2], |[low, high], p| {
            [low.inf(&p), high.sup(&p)]
        });
        faces.push((low, high, sheet as usize, face));
    }
    let corners = corners.into_iter().enumerate();
    let mut corners: Vec<_> = corners
        .filter_map(|(sheet, at)| Some((at?, sheet)))
        .collect();
    corners.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
    // What is in an island is in what the island is in: the widest first, most need not be looked at.
    faces.sort_by(|a, b| (b.1.x - b.0.x).total_cmp(&(a.1.x - a.0.x)));
    let mut island = vec![false; pattern.sheets()];
    let mut looks = Looks::for_lines(drawing.edges.len());
    for (low, high, around, face) in faces {
        if island[around] {
            continue;
        }
        let from = corners.partition_point(|(at, _)| at.x <= low.x);
        let within = corners[from..].iter().take_while(|(at, _)| at.x < high.x);
        for &(at, sheet) in within {
            looks.take(1);
            if sheet == around || island[sheet] || at.y <= low.y || at.y >= high.y {
                continue;
            }
            looks.take(face.len());
            let polygon = face.iter().map(|vertex| points[vertex.index()]);
            let next = polygon.clone().cycle().skip(1);
            let above = polygon.zip(next).filter(|(a, b)| {
                let part = (at.x - a.x) / (b.x - a.x);
                (a.x > at.x) != (b.x > at.x) && a.y + part * (b.y - a.y) > at.y
            });
            island[sheet] = above.count() % 2 == 1;
        }
        if looks.are_used_up() {
            return None;
        }
    }
    let on_island = |edge: &crate::pattern::Edge| {
        let mut faces = edge.faces.iter().flatten();
        faces.any(|face| island[pattern.sheet_of_faces()[face.index()] as usize])
    };
    let before = drawing.edges.len();
    let mut edges = pattern.edges().iter();
    drawing
        .edges
        .retain(|_| !edges.next().is_some_and(on_island));
    let left_out = before - drawing.edges.len();
    let pieces = drawing.edges.iter().map(|edge| Piece {
        ends: edge.ends,
        letter: edge.letter,
        goal: edge.goal,
    });
    let pieces: Vec<Piece> = pieces.collect();
    Some((self::drawing(&drawing.vertices, &pieces), left_out))
}

/// A vertex at which the error is.
fn place(error: &PatternError, edges: &[[usize; 2]]) -> Option<usize> {
    match error {
        PatternError::NotFinite { vertex }
        | PatternError::BrokenStar { vertex }
        | PatternError::OnEdge { vertex, .. } => Some(*vertex),
        PatternError::NoLength { edge }
        | PatternError::Duplicate { edge, .. }
        | PatternError::Crossing { edge, .. }
        | PatternError::Overlap { edge, .. } => edges.get(*edge).map(|ends| ends[0]),
        _ => None,
    }
}

/// An edge without which its ends are not joined, so that it has the same face on both sides.
///
/// Source: R. Tarjan, "A note on finding the bridges of a graph", 1974.
fn bridge(vertices: usize, edges: &[[usize; 2]]) -> Option<usize> {
    let numbered = edges.iter().enumerate();
    let pairs: Vec<_> = numbered
        .flat_map(|(edge, &[a, b])| [(a, (b, edge)), (b, (a, edge))])
        .collect();
    let stars = group_by_key(vertices, &pairs);
    let none = usize::MAX;
    // When a vertex was first met, and the earliest vertex that its branch leads back to.
    let (mut met, mut back) = (vec![none; vertices], vec![none; vertices]);
    let mut time = 0;
    for start in 0..vertices {
        // Vertices on the way, the edge that led there and how far their stars are done.
        let mut way = Vec::new();
        if met[start] == none {
            way.push((start, none, 0));
        }
        while let Some((vertex, through, done)) = way.last_mut() {
            let (at, came) = (*vertex, *through);
            if *done == 0 {
                (met[at], back[at]) = (time, time);
                time += 1;
            }
            let Some(&(next, edge)) = stars[at].get(*done) else {
                way.pop();
                if let Some(&(before, ..)) = way.last() {
                    back[before] = back[before].min(back[at]);
                    if back[at] > met[before] {
                        return Some(came);
                    }
                }
                continue;
            };
            *done += 1;
            if met[next] == none {
                way.push((next, edge, 0));
            } else if edge != came {
                back[at] = back[at].min(met[next]);
            }
        }
    }
    None
}

/// A line between vertices.
#[derive(Clone, Copy, Debug)]
struct Piece {
    ends: [usize; 2],
    letter: Letter,
    goal: Option<f64>,
}

/// How much a letter says, where lines lie on each other. A border says nothing that the faces do not
/// say themselves where it is outside; within, what was drawn to be cut or folded was meant.
fn weight(letter: Letter) -> u8 {
    match letter {
        Letter::Cut => 4,
        Letter::Mountain | Letter::Valley => 3,
        Letter::Unassigned => 2,
        Letter::Boundary => 1,
        Letter::Flat | Letter::Join => 0,
    }
}

/// What was repaired.
#[derive(Default)]
struct Repairs {
    short: usize,
    moved: usize,
    farthest: f64,
    crossings: usize,
    passed: usize,
    twice: usize,
    both_ways: usize,
    joined: usize,
    far_joined: f64,
    open: usize,
}

impl Repairs {
    fn in_words(&self, tolerance: f64) -> Vec<String> {
        let &Self {
            short,
            moved,
            farthest,
            crossings,
            passed,
            twice,
            both_ways,
            joined,
            far_joined,
            open,
        } = self;
        let said = [
            (
                short,
                format!("lines shorter than the tolerance {tolerance:.3e} left out: {short}"),
            ),
            (
                moved,
                format!(
                    "ends of lines within the tolerance {tolerance:.3e} of each other joined: {moved}, \
                     moved by {farthest:.1e} at most"
                ),
            ),
            (
                crossings,
                format!("crossings without a vertex, both lines split there: {crossings}"),
            ),
            (
                passed,
                format!(
                    "lines that pass a vertex within the tolerance {tolerance:.3e} split there: {passed} \
                     places"
                ),
            ),
            (
                twice,
                format!(
                    "lines that lie on another left out: {twice} (kept is a cut before M or V, before \
                     U, before a border, before F)"
                ),
            ),
            (
                both_ways,
                format!("of them lettered M and V at one place, the first drawn kept: {both_ways}"),
            ),
            (
                joined,
                format!(
                    "open ends joined to the one vertex near them: {joined}, moved by {far_joined:.1e} at \
                     most"
                ),
            ),
            (
                open,
                format!("lines that end in the open, without faces between, left out: {open}"),
            ),
        ];
        let said = said.into_iter().filter(|(count, _)| *count > 0);
        said.map(|(_, words)| words).collect()
    }
}

/// The planar drawing of the segments and what was repaired; `None` if there is too much of it.
fn planar(segments: Vec<Segment>, rounding: f64) -> Option<(Drawing, Vec<String>)> {
    if segments.len() > MOST {
        return None;
    }
    let [low, high] = bounds(&segments);
    let diagonal = (high - low).norm();
    let tolerance = tolerance(&segments).max(4.0 * rounding);
    let mut repairs = Repairs::default();
    let mut places = Places::new(tolerance, low);
    let mut pieces: Vec<Piece> = segments
        .iter()
        .map(|segment| Piece {
            ends: segment.ends.map(|end| places.at(end)),
            letter: segment.letter,
            goal: segment.goal,
        })
        .collect();
    places.centre();
    for (segment, piece) in segments.iter().zip(&pieces) {
        for (end, vertex) in segment.ends.iter().zip(piece.ends) {
            let moved = (places.points[vertex] - end).norm();
            repairs.moved += usize::from(moved > 0.0);
            repairs.farthest = repairs.farthest.max(moved);
        }
    }
    pieces.retain(|piece| piece.ends[0] != piece.ends[1]);
    repairs.short = segments.len() - pieces.len();
    drop(segments);
    deduplicate(&mut pieces, &mut repairs);
    let mut looks = Looks::for_lines(pieces.len());
    cut_up(&mut places, &mut pieces, &mut repairs, &mut looks)?;
    if join_open(
        &places.points,
        &mut pieces,
        diagonal,
        &mut repairs,
        &mut looks,
    )? {
        deduplicate(&mut pieces, &mut repairs);
        cut_up(&mut places, &mut pieces, &mut repairs, &mut looks)?;
    }
    // Each crossing has split two lines at least.
    repairs.passed = repairs.passed.saturating_sub(2 * repairs.crossings);
    repairs.open = remove_open(&mut pieces, places.points.len());
    let drawing = drawing(&places.points, &pieces);
    Some((drawing, repairs.in_words(tolerance)))
}

/// How often something near may still be looked at.
struct Looks(usize);

impl Looks {
    /// As often as so many lines need.
    fn for_lines(lines: usize) -> Self {
        Self(LOOKS[1].max(LOOKS[0] * lines))
    }

    fn take(&mut self, count: usize) {
        self.0 = self.0.saturating_sub(count);
    }

    fn are_used_up(&self) -> bool {
        self.0 == 0
    }
}

/// Splits lines where they cross and where they pass vertices, until none does; `None` if that makes too
/// many.
fn cut_up(
    places: &mut Places,
    pieces: &mut Vec<Piece>,
    repairs: &mut Repairs,
    looks: &mut Looks,
) -> Option<()> {
    let tolerance = places.tolerance;
    for _ in 0..ROUNDS {
        let before = places.points.len();
        for crossing in crossings(&places.points, pieces, tolerance, looks)? {
            places.at(crossing);
        }
        repairs.crossings += places.points.len() - before;
        let count = pieces.len();
        *pieces = split(&places.points, pieces, tolerance, looks)?;
        let splits = pieces.len() - count;
        if splits == 0 && places.points.len() == before {
            break;
        }
        repairs.passed += splits;
        deduplicate(pieces, repairs);
    }
    Some(())
}

/// Joins each open end to the vertex that it can only have been meant to meet, and says whether there were
/// any, or `None` if there is too much near them: within a twentieth of its line and [`OPEN`] of the diagonal, the next vertex twice as far at least.
/// A line that goes too far past another has a short open end, which stays, to be left out.
fn join_open(
    points: &[Vector2<f64>],
    pieces: &mut [Piece],
    diagonal: f64,
    repairs: &mut Repairs,
    looks: &mut Looks,
) -> Option<bool> {
    let mut degrees = vec![0_usize; points.len()];
    for end in pieces.iter().flat_map(|piece| piece.ends) {
        degrees[end] += 1;
    }
    let (grid, cells) = Grid::of_points(points, OPEN * diagonal);
    let before = repairs.joined;
    for piece in pieces {
        let [a, b] = line(points, piece);
        let reach = (OF_LINE * (b - a).norm()).min(OPEN * diagonal);
        for side in 0..2 {
            let (end, other) = (piece.ends[side], piece.ends[1 - side]);
            if degrees[end] != 1 {
                continue;
            }
            let at = points[end];
            let mut near = [(f64::INFINITY, end); 2];
            grid.along([at; 2], 2.0 * reach, |cell| {
                looks.take(1 + cells[cell].len());
                for &vertex in &cells[cell] {
                    let distance = (points[vertex] - at).norm();
                    if degrees[vertex] < 2 || vertex == other || distance >= near[1].0 {
                        continue;
                    }
                    near[1] = (distance, vertex);
                    near.sort_by(|a, b| a.0.total_cmp(&b.0));
                }
            });
            let [(distance, vertex), (second, _)] = near;
            if distance <= reach && second >= 2.0 * distance {
                piece.ends[side] = vertex;
                repairs.joined += 1;
                repairs.far_joined = repairs.far_joined.max(distance);
            }
        }
        if looks.are_used_up() {
            return None;
        }
    }
    Some(repairs.joined > before)
}

fn bounds(segments: &[Segment]) -> [Vector2<f64>; 2] {
    let mut ends = segments.iter().flat_map(|segment| segment.ends);
    let first = ends.next().unwrap_or_default();
    ends.fold([first; 2], |[low, high], end| {
        [low.inf(&end), high.sup(&end)]
    })
}

fn tolerance(segments: &[Segment]) -> f64 {
    let [low, high] = bounds(segments);
    let diagonal = (high - low).norm();
    let lengths = segments.iter().map(|s| (s.ends[1] - s.ends[0]).norm());
    let mut lengths: Vec<f64> = lengths.filter(|length| *length > 0.0).collect();
    if lengths.is_empty() {
        return 0.0;
    }
    let middle = lengths.len() / 2;
    let median = *lengths.select_nth_unstable_by(middle, f64::total_cmp).1;
    (OF_MEDIAN * median)
        .min(OF_DIAGONAL * diagonal)
        .max(ROUNDING * diagonal)
}

/// Distinct places: points within the tolerance of each other are one.
struct Places {
    points: Vec<Vector2<f64>>,
    /// Sum of what was put at each place, relative to the place, and how often.
    offsets: Vec<(Vector2<f64>, f64)>,
    cells: HashMap<[i64; 2], Vec<usize>>,
    origin: Vector2<f64>,
    tolerance: f64,
}

impl Places {
    fn new(tolerance: f64, origin: Vector2<f64>) -> Self {
        Self {
            points: Vec::new(),
            offsets: Vec::new(),
            cells: HashMap::new(),
            origin,
            tolerance,
        }
    }

    fn cell(&self, point: &Vector2<f64>) -> [i64; 2] {
        let scaled = (point - self.origin) / self.tolerance;
        #[allow(
            clippy::cast_possible_truncation,
            reason = "the tolerance keeps cells below 1e9 a side"
        )]
        let cell = |c: f64| c.floor() as i64;
        [cell(scaled.x), cell(scaled.y)]
    }

    /// The place of the point, a new one if there is none within the tolerance.
    fn at(&mut self, point: Vector2<f64>) -> usize {
        let [x, y] = self.cell(&point);
        let mut nearest = (self.tolerance, None);
        for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
            let cell = [x.saturating_add(dx), y.saturating_add(dy)];
            for &other in self.cells.get(&cell).into_iter().flatten() {
                let distance = (self.points[other] - point).norm();
                let first = nearest.1.is_none();
                if distance < nearest.0 || (first && distance <= nearest.0) {
                    nearest = (distance, Some(other));
                }
            }
        }
        if let Some(other) = nearest.1 {
            let offset = point - self.points[other];
            self.offsets[other].0 += offset;
            self.offsets[other].1 += 1.0;
            return other;
        }
        let new = self.points.len();
        self.points.push(point);
        self.offsets.push((Vector2::zeros(), 1.0));
        self.cells.entry([x, y]).or_default().push(new);
        new
    }

    /// Moves each place to the mean of what was put there, which is at most one tolerance away.
    fn centre(&mut self) {
        for (point, (sum, count)) in self.points.iter_mut().zip(&self.offsets) {
            *point += sum / *count;
        }
        self.cells.clear();
        for index in 0..self.points.len() {
            let cell = self.cell(&self.points[index]);
            self.cells.entry(cell).or_default().push(index);
        }
    }
}

/// Keeps one of all lines between the same vertices: the weightiest, or else the first.
fn deduplicate(pieces: &mut Vec<Piece>, repairs: &mut Repairs) {
    let mut kept: Vec<Piece> = Vec::with_capacity(pieces.len());
    let mut at: HashMap<[usize; 2], usize> = HashMap::with_capacity(pieces.len());
    for piece in pieces.iter() {
        let [a, b] = piece.ends;
        let index = *at.entry([a.min(b), a.max(b)]).or_insert(kept.len());
        let Some(before) = kept.get_mut(index) else {
            kept.push(*piece);
            continue;
        };
        repairs.twice += 1;
        repairs.both_ways += usize::from(before.letter.sign() * piece.letter.sign() < 0.0);
        if weight(piece.letter) > weight(before.letter) {
            *before = *piece;
        }
    }
    *pieces = kept;
}

/// Square cells over the sheet, of which a line covers few.
struct Grid {
    origin: Vector2<f64>,
    cell: f64,
    columns: usize,
    rows: usize,
}

impl Grid {
    /// A grid over the points with about as many cells as `count`, at least `least` wide.
    #[allow(clippy::cast_precision_loss, reason = "a bound on work, not a result")]
    fn new(points: &[Vector2<f64>], count: usize, least: f64) -> Self {
        let first = points.first().copied().unwrap_or_default();
        let low = points.iter().fold(first, |low, p| low.inf(p));
        let size = points.iter().fold(first, |high, p| high.sup(p)) - low;
        let count = count.max(1) as f64;
        // Roots one by one: a product of sizes might overflow.
        let cell = ((size.x / count).sqrt() * size.y.sqrt())
            .max((size.x + size.y) / count)
            .max(least)
            .max(1.0 / LARGEST);
        let mut grid = Self {
            origin: low,
            cell,
            columns: usize::MAX,
            rows: usize::MAX,
        };
        grid.columns = grid.step(size.x, usize::MAX) + 1;
        grid.rows = grid.step(size.y, usize::MAX) + 1;
        grid
    }

    /// A grid with about a point a cell, at least `least` wide, and the points in each.
    fn of_points(points: &[Vector2<f64>], least: f64) -> (Self, Ragged<usize>) {
        let grid = Self::new(points, points.len(), least);
        let cell_of = |point: &Vector2<f64>| {
            let from = point - grid.origin;
            grid.step(from.y, grid.rows) * grid.columns + grid.step(from.x, grid.columns)
        };
        let cells: Vec<_> = points.iter().map(cell_of).zip(0..).collect();
        let cells = group_by_key(grid.columns * grid.rows, &cells);
        (grid, cells)
    }

    fn step(&self, along: f64, cells: usize) -> usize {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saturates, and is held to the grid"
        )]
        let step = (along / self.cell) as usize;
        step.min(cells - 1)
    }

    /// Calls `visit` once with each cell within `margin` of the line.
    fn along(&self, [a, b]: [Vector2<f64>; 2], margin: f64, mut visit: impl FnMut(usize)) {
        let (a, b) = (a - self.origin, b - self.origin);
        let along = b - a;
        let row = |y: f64| self.step(y, self.rows);
        let column = |x: f64| self.step(x, self.columns);
        for row in row(a.y.min(b.y) - margin)..=row(a.y.max(b.y) + margin) {
            #[allow(clippy::cast_precision_loss, reason = "rows are few")]
            let low = row as f64 * self.cell - margin;
            // The part of the line in this row.
            let part = if along.y.abs() > 0.0 {
                [low, low + self.cell + 2.0 * margin].map(|y| ((y - a.y) / along.y).clamp(0.0, 1.0))
            } else {
                [0.0, 1.0]
            };
            let [p, q] = part.map(|t| a.x + t * along.x);
            // Rounding of the part is far below a hundredth of a cell.
            let margin = margin + 0.01 * self.cell;
            for column in column(p.min(q) - margin)..=column(p.max(q) + margin) {
                visit(row * self.columns + column);
            }
        }
    }
}

fn line(points: &[Vector2<f64>], piece: &Piece) -> [Vector2<f64>; 2] {
    piece.ends.map(|end| points[end])
}

/// Where along the line (0 to its length) the point's foot is, and how far from the line the point is.
fn foot([a, b]: [Vector2<f64>; 2], point: Vector2<f64>) -> (f64, f64, f64) {
    let length = (b - a).norm();
    let unit = (b - a) / length;
    (
        (point - a).dot(&unit),
        (point - a).perp(&unit).abs(),
        length,
    )
}

/// Whether the point is on the line to within the tolerance, and between its ends.
fn passes(line: [Vector2<f64>; 2], point: Vector2<f64>, tolerance: f64) -> bool {
    let (along, aside, length) = foot(line, point);
    aside <= tolerance && along >= -tolerance && along <= length + tolerance
}

/// Where lines cross and neither has an end on the other; `None` if that is too often.
fn crossings(
    points: &[Vector2<f64>],
    pieces: &[Piece],
    tolerance: f64,
    looks: &mut Looks,
) -> Option<Vec<Vector2<f64>>> {
    let lengths = pieces.iter().map(|piece| {
        let [a, b] = line(points, piece);
        (b - a).norm()
    });
    #[allow(clippy::cast_precision_loss, reason = "a bound on work, not a result")]
    let least = lengths.sum::<f64>() / (8.0 * pieces.len().max(1) as f64);
    let grid = Grid::new(points, pieces.len(), least);
    let mut covered = Vec::new();
    for (index, piece) in pieces.iter().enumerate() {
        grid.along(line(points, piece), 0.0, |cell| covered.push((cell, index)));
    }
    let covered: Ragged<usize> = group_by_key(grid.columns * grid.rows, &covered);
    let mut seen = vec![usize::MAX; pieces.len()];
    let mut found = Vec::new();
    for (index, piece) in pieces.iter().enumerate() {
        let one = line(points, piece);
        let mut too_many = false;
        grid.along(one, 0.0, |cell| {
            looks.take(1);
            for &other in covered[cell].iter().take_while(|&&other| other < index) {
                looks.take(1);
                if seen[other] == index {
                    continue;
                }
                seen[other] = index;
                if pieces[other]
                    .ends
                    .iter()
                    .any(|end| piece.ends.contains(end))
                {
                    continue;
                }
                found.extend(crossing(one, line(points, &pieces[other]), tolerance));
            }
            too_many |= found.len() > MOST || looks.are_used_up();
        });
        if too_many {
            return None;
        }
    }
    Some(found)
}

fn crossing(
    one: [Vector2<f64>; 2],
    other: [Vector2<f64>; 2],
    tolerance: f64,
) -> Option<Vector2<f64>> {
    let turn = |[a, b]: [Vector2<f64>; 2], c: Vector2<f64>| {
        let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
        orient2d(a, b, c)
    };
    let opposite = |line, [c, d]: [Vector2<f64>; 2]| {
        let (c, d) = (turn(line, c), turn(line, d));
        (c > 0.0 && d < 0.0) || (c < 0.0 && d > 0.0)
    };
    if !opposite(one, other) || !opposite(other, one) {
        return None;
    }
    // Where an end is on the other line, the line is split there instead.
    let ends = other.iter().any(|&end| passes(one, end, tolerance))
        || one.iter().any(|&end| passes(other, end, tolerance));
    if ends {
        return None;
    }
    let (along, across) = (one[1] - one[0], other[1] - other[0]);
    let part = (other[0] - one[0]).perp(&across) / along.perp(&across);
    Some(one[0] + along * part.clamp(0.0, 1.0))
}

/// Splits each line at the vertices that it passes; `None` if that makes too many.
fn split(
    points: &[Vector2<f64>],
    pieces: &[Piece],
    tolerance: f64,
    looks: &mut Looks,
) -> Option<Vec<Piece>> {
    let (grid, cells) = Grid::of_points(points, 4.0 * tolerance);
    let mut result = Vec::with_capacity(pieces.len());
    let mut stops: Vec<(f64, usize)> = Vec::new();
    for piece in pieces {
        let line = line(points, piece);
        stops.clear();
        grid.along(line, tolerance, |cell| {
            looks.take(1 + cells[cell].len());
            for &vertex in cells[cell].iter().filter(|v| !piece.ends.contains(v)) {
                let (along, aside, length) = foot(line, points[vertex]);
                if aside <= tolerance && along > 0.0 && along < length {
                    stops.push((along, vertex));
                }
            }
        });
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut from = piece.ends[0];
        for to in stops.iter().map(|(_, stop)| *stop).chain([piece.ends[1]]) {
            result.push(Piece {
                ends: [from, to],
                ..*piece
            });
            from = to;
        }
        if result.len() > MOST || looks.are_used_up() {
            return None;
        }
    }
    Some(result)
}

/// Removes lines at whose one end there is no other line, one after the other, and counts them.
fn remove_open(pieces: &mut Vec<Piece>, vertices: usize) -> usize {
    let pairs: Vec<(usize, usize)> = pieces
        .iter()
        .enumerate()
        .flat_map(|(index, piece)| piece.ends.map(|end| (end, index)))
        .collect();
    let stars = group_by_key(vertices, &pairs);
    let mut degrees: Vec<usize> = stars.iter().map(<[usize]>::len).collect();
    let mut open: Vec<usize> = (0..vertices).filter(|&v| degrees[v] == 1).collect();
    let mut removed = vec![false; pieces.len()];
    while let Some(vertex) = open.pop() {
        for &index in stars[vertex].iter().filter(|_| degrees[vertex] == 1) {
            if removed[index] {
                continue;
            }
            removed[index] = true;
            for end in pieces[index].ends {
                degrees[end] -= 1;
                if degrees[end] == 1 && end != vertex {
                    open.push(end);
                }
            }
            break;
        }
    }
    let before = pieces.len();
    let mut removed = removed.into_iter();
    pieces.retain(|_| !removed.next().unwrap_or_default());
    before - pieces.len()
}

/// The drawing, with the vertices that lines end at, in the order in which lines first do.
fn drawing(points: &[Vector2<f64>], pieces: &[Piece]) -> Drawing {
    let mut names = vec![None; points.len()];
    let mut vertices = Vec::new();
    let edges = pieces.iter().map(|piece| DrawnEdge {
        ends: piece.ends.map(|end| {
            *names[end].get_or_insert_with(|| {
                vertices.push(points[end]);
                vertices.len() - 1
            })
        }),
        letter: piece.letter,
        goal: piece.goal,
    });
    let edges = edges.collect();
    Drawing {
        vertices,
        edges,
        faces: None,
    }
}
