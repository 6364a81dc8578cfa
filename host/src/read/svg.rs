//! Reads SVG crease patterns with the colours of Origami Simulator.
//!
//! Source: A. Ghassaei, E. Demaine, N. Gershenfeld, "Fast, Interactive Origami Simulation using GPU
//! Computation", 2018, and the simulator's own page on designing patterns.
//!
//! The colour of a stroke is its letter: red mountain, blue valley, black border, green cut, yellow a mark that stays
//! flat, magenta a hinge that may turn either way. The opacity is the goal fold angle over 180 degrees; if all
//! mountains and valleys are opaque, the drawing names no angles. Fills are ignored. In SVG y points down: this reader
//! negates y, so that the sheet is seen as it is on the screen and a mountain rises towards the viewer, as it does in
//! the simulator. Coordinates have the seven digits of single precision, in which usvg resolves shapes; drawing
//! programs write as many.

mod alpha;
mod hidden;
mod limits;
mod numbers;
mod viewport;

use core::f64::consts::PI;
use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use nalgebra::Vector2;
use usvg::tiny_skia_path::PathSegment;
use usvg::{Group, ImageHrefResolver, Node, Options, Paint, Tree, roxmltree};

use self::alpha::Codes;
use self::viewport::{Affine, Viewport};
use super::colour::Kind;
use super::curves::{Chords, Curve, Piece, STRAIGHT_CREASE};
use super::error::Wrong;
use super::options::{ColourLetter, ColourLetters};
use super::segments::{LineNames, LooseLines, MAX_LINES, Segment, Written, pattern_file};
use super::{FileError, ReadOptions};
use crate::colours::hex;
use crate::pattern::Letter;
use crate::progress::Watch;
use crate::read::fold::PatternFile;

/// Largest number of nodes of the document, as a file may consist of nothing else.
const MAX_NODES: u32 = 1 << 21;

/// Parses a crease pattern from the text of a file.
///
/// # Errors
/// If the text is no SVG, asks for too much work, has a curved crease, or its lines form no crease pattern.
pub(super) fn parse_pattern(
    path: &Path,
    text: &str,
    options: &ReadOptions,
    watch: Watch<'_>,
) -> Result<PatternFile, FileError> {
    let wrong = FileError::wrong(path);
    let Drawn {
        tree,
        viewport,
        codes,
        hidden,
        mut notes,
    } = check_text(text)
        .and_then(|()| drawn(text))
        .map_err(&wrong)?;
    let (root, place) = viewport.content(tree.root());
    let strokes = strokes(root, place, &codes, options).map_err(&wrong)?;
    if let Some(hidden) = hidden {
        if strokes.is_empty() {
            let expected = "lines that are shown".into();
            let found = format!("hidden shapes alone: {hidden}");
            return Err(wrong(("the drawing".into(), expected, found)));
        }
        notes.push(format!("hidden shapes left out: {hidden}"));
    }
    notes.extend(colours_without_lines(&strokes, &options.colours));
    notes.extend(dashes_noted(&strokes, options.dashes));
    let mut colours: BTreeMap<(&str, bool), (Kind, usize)> = BTreeMap::new();
    for Stroke {
        colour,
        kind,
        lines,
        ..
    } in &strokes
    {
        let is_dashed = matches!(kind, Kind::Dashed(_));
        let (_, count) = colours.entry((colour, is_dashed)).or_insert((*kind, 0));
        *count += lines.pieces.len();
    }
    let straightened: usize = strokes.iter().map(|stroke| stroke.lines.straightened).sum();
    if straightened > 0 {
        notes.push(format!(
            "curves that run straight taken as lines: {straightened}"
        ));
    }
    let colours = colours.into_iter();
    notes.extend(colours.filter_map(|((colour, _), (kind, count))| kind.note(colour, count)));
    // Opacity is the goal angle of a mountain or valley, unless all of them are opaque or all are transparent.
    let is_folded = |stroke: &Stroke<'_>| stroke.kind.letter().sign().abs() > 0.0;
    let has_angles = strokes.iter().any(|s| is_folded(s) && s.opacity < 1.0)
        && strokes.iter().any(|s| is_folded(s) && s.opacity > 0.0);
    if has_angles {
        notes.push("goal angles from the opacity of strokes, 180 degrees where opaque".into());
    }
    let mut chords = Chords::of_pieces(strokes.iter().flat_map(|stroke| &stroke.lines.pieces));
    let mut segments = Vec::new();
    let mut names = LineNames::new();
    for stroke in &strokes {
        let before = segments.len();
        let letter = stroke.kind.letter();
        let is_angle = has_angles && is_folded(stroke);
        let goal = is_angle.then(|| letter.sign() * stroke.opacity * PI);
        for piece in &stroke.lines.pieces {
            let too_many = || {
                let most = format!("at most {MAX_LINES} lines");
                wrong(("the curves of the drawing".into(), most, "more".into()))
            };
            let lines = chords.lines_of(piece).ok_or_else(too_many)?.into_iter();
            segments.extend(lines.map(|ends| Segment { ends, letter, goal }));
        }
        for name in stroke.names.into_iter().filter(|name| !name.is_empty()) {
            let lines = segments[before..].iter().map(|segment| segment.ends);
            names.entry(name.into()).or_default().extend(lines);
        }
    }
    notes.extend(chords.note());
    let rounding = strokes.iter().map(|stroke| stroke.lines.rounding);
    let written = strokes.iter().flat_map(|stroke| &stroke.lines.written);
    let scales = strokes.iter().map(|stroke| stroke.lines.scale);
    let lines = LooseLines {
        segments,
        rounding: rounding.fold(0.0, f64::max),
        written: Some(Written {
            points: written.copied().collect(),
            scale: scales.fold(0.0, f64::max),
            turned: strokes.iter().any(|stroke| stroke.lines.turned),
        }),
        y_down: true,
        unit: viewport.unit,
        notes,
        names,
    };
    pattern_file(path, lines, options, watch)
}

/// Notes the colours that were given letters although no line has them.
fn colours_without_lines(strokes: &[Stroke<'_>], chosen: &ColourLetters) -> Vec<String> {
    let is_drawn = |chosen: &&ColourLetter| {
        strokes.iter().any(|stroke| match stroke.kind {
            Kind::Chosen(_) => stroke.colour == hex(chosen.colour),
            Kind::NearChosen(colour, _) => colour == chosen.colour,
            _ => false,
        })
    };
    let unused = chosen.iter().filter(|chosen| !is_drawn(chosen));
    let notes = unused.map(|ColourLetter { name, letter, .. }| {
        let code = letter.code();
        format!("the colour {name} was given the letter {code}, but no line has it")
    });
    notes.collect()
}

/// Notes dashed lines that are no creases by their colour and were given no letter, or that a letter of dashes has no use.
fn dashes_noted(strokes: &[Stroke<'_>], chosen: Option<Letter>) -> Option<String> {
    let dashed = strokes.iter().filter(|stroke| stroke.dashed);
    let count = |stroke: &Stroke<'_>| stroke.lines.pieces.len();
    match chosen {
        Some(letter) if dashed.clone().next().is_none() => Some(format!(
            "dashes were given the letter {}, but no line is dashed",
            letter.code()
        )),
        Some(_) => None,
        None => {
            let flat = dashed.filter(|stroke| !stroke.kind.letter().is_hinge());
            let count: usize = flat.map(count).sum();
            (count > 0).then(|| {
                format!(
                    "dashed lines that are no creases by their colour, where dashes were given no letter: {count}"
                )
            })
        }
    }
}

/// Checks that the text of an XML file asks for a bounded amount of work.
pub(super) fn check_text(text: &str) -> Result<(), Wrong> {
    let wrong = |found| ("the drawing".into(), "less of it".into(), found);
    limits::of_text(text).map_err(wrong)
}

/// Style sheet that spares usvg needless work: only the course of strokes is read.
const UNUSED: &str = "* { fill: none !important; marker: none !important; filter: none !important; \
                      clip-path: none !important; mask: none !important }";

/// A drawing whose styles, transforms and shapes are resolved.
struct Drawn {
    tree: Tree,
    viewport: Viewport,
    /// Colours that stand for colours with alpha.
    codes: Codes,
    /// Number of the shapes that are hidden and what hides them, if there are any.
    hidden: Option<String>,
    /// Notes of the elements that are left out.
    notes: Vec<String>,
}

/// Resolves styles, transforms and shapes.
fn drawn(text: &str) -> Result<Drawn, Wrong> {
    let no_drawing = |place: String, found: String| (place, "an SVG drawing".into(), found);
    let document = roxmltree::Document::parse_with_options(text, parsing()).map_err(|error| {
        let place = format!("line {}, column {}", error.pos().row, error.pos().col);
        no_drawing(place, format!("no XML ({error})"))
    })?;
    let root = document.root_element();
    let place = |node: roxmltree::Node<'_, '_>| {
        format!("line {}", document.text_pos_at(node.range().start).row)
    };
    if root.tag_name().name() != "svg" {
        let found = format!("<{}>", root.tag_name().name());
        return Err(no_drawing(place(root), found));
    }
    numbers::check(&document)?;
    limits::of_document(&document).map_err(|found| no_drawing(place(root), found))?;
    let resolved = |document: &roxmltree::Document<'_>, style: &str| {
        let tree = Tree::from_xmltree(document, &resolving(style));
        tree.map_err(|error| no_drawing(place(root), error.to_string()))
    };
    let mut tree = resolved(&document, UNUSED)?;
    let mut hidden = None;
    if hidden::may_hide(text) {
        let all = resolved(&document, &format!("{UNUSED} {}", hidden::SHOWN))?;
        let [all, shown] = [&all, &tree].map(|tree| shown_strokes(tree.root()).len());
        hidden = (all > shown).then(|| hidden::in_words(&document, all - shown));
    }
    let mut codes = Codes::default();
    if alpha::has_alpha(text) {
        let (encoded, found) = alpha::encoded(text, &colours(&shown_strokes(tree.root())));
        let document = roxmltree::Document::parse_with_options(&encoded, parsing());
        if let Ok(document) = document {
            tree = resolved(&document, UNUSED)?;
            codes = found;
        }
    }
    let count = |names: [&str; 3]| {
        let elements = document.descendants();
        elements
            .filter(|node| names.contains(&node.tag_name().name()))
            .count()
    };
    let said = [
        (
            "text, images and markers left out",
            count(["text", "image", "marker"]),
        ),
        (
            "clip paths and masks not applied: what they hide counts",
            count(["clipPath", "mask", "mask"]),
        ),
    ];
    let said = said.into_iter().filter(|(_, count)| *count > 0);
    let notes = said.map(|(what, count)| format!("{what}: {count}"));
    Ok(Drawn {
        viewport: Viewport::of(root, tree.size()),
        tree,
        codes,
        hidden,
        notes: notes.collect(),
    })
}

fn parsing<'a>() -> roxmltree::ParsingOptions<'a> {
    roxmltree::ParsingOptions {
        // Illustrator writes a DTD.
        allow_dtd: true,
        nodes_limit: MAX_NODES,
        ..Default::default()
    }
}

/// Returns options of usvg with a style sheet.
fn resolving<'a>(style: &str) -> Options<'a> {
    Options {
        // No other file is opened.
        image_href_resolver: ImageHrefResolver {
            resolve_data: Box::new(|_, _, _| None),
            resolve_string: Box::new(|_, _| None),
        },
        style_sheet: Some(style.into()),
        ..Default::default()
    }
}

/// Returns the strokes of all shapes that are shown, in any order.
fn shown_strokes(root: &Group) -> Vec<&usvg::Stroke> {
    let (mut strokes, mut open) = (Vec::new(), vec![root]);
    while let Some(group) = open.pop() {
        for node in group.children() {
            match node {
                Node::Group(group) => open.push(group),
                Node::Path(path) if path.is_visible() => strokes.extend(path.stroke()),
                _ => {}
            }
        }
    }
    strokes
}

/// Returns the colours of some strokes.
fn colours(strokes: &[&usvg::Stroke]) -> HashSet<[u8; 3]> {
    let colour = |stroke: &&usvg::Stroke| match stroke.paint() {
        Paint::Color(c) => Some([c.red, c.green, c.blue]),
        _ => None,
    };
    strokes.iter().filter_map(colour).collect()
}

/// The lines of one stroked path.
struct Stroke<'a> {
    kind: Kind,
    /// The ids of the shape and of the innermost group that has one; empty if there is none.
    names: [&'a str; 2],
    /// The colour as #rrggbb, or a description of another paint.
    colour: String,
    /// 0 to 1.
    opacity: f64,
    dashed: bool,
    lines: Lines,
}

/// The lines of a path on the sheet, y pointing up.
struct Lines {
    pieces: Vec<Piece>,
    /// Number of lines that were written as curves.
    straightened: usize,
    /// Largest distance by which single precision may have moved an end.
    rounding: f64,
    /// The ends before the transform, as they were written, the factor by which the transform scales lengths, and `true` if
    /// it turns.
    written: Vec<[f64; 2]>,
    scale: f64,
    turned: bool,
}

/// Returns all strokes in the order in which they are painted. `place` takes the coordinates of the root's children to those
/// of the sheet, y pointing down.
fn strokes<'a>(
    root: &'a Group,
    place: Affine,
    codes: &Codes,
    options: &ReadOptions,
) -> Result<Vec<Stroke<'a>>, Wrong> {
    let mut strokes = Vec::new();
    let mut total = 0;
    let mut open: Vec<(&'a Node, f64, Affine, &'a str)> = Vec::new();
    let children = root.children().iter().rev();
    open.extend(children.map(|node| (node, 1.0, place, "")));
    let mut number = 0_usize;
    while let Some((node, opacity, place, outer)) = open.pop() {
        match node {
            Node::Group(group) => {
                let opacity = opacity * decimal(group.opacity().get());
                let place = place.after(group.transform());
                let children = group.children().iter().rev();
                let within = Some(group.id()).filter(|id| !id.is_empty());
                let within = within.unwrap_or(outer);
                open.extend(children.map(|node| (node, opacity, place, within)));
            }
            Node::Path(path) if path.is_visible() => {
                let Some(stroke) = path.stroke() else {
                    continue;
                };
                number += 1;
                let (kind, colour, alpha) = match stroke.paint() {
                    Paint::Color(c) => {
                        let (colour, alpha) = codes.decode([c.red, c.green, c.blue]);
                        (Kind::of(colour, &options.colours), hex(colour), alpha)
                    }
                    _ => (Kind::Unknown, "gradient or pattern".into(), 1.0),
                };
                let dashed = stroke.dasharray().is_some();
                let of_dashes = options.dashes.filter(|_| dashed).map(Kind::Dashed);
                let kind = of_dashes.unwrap_or(kind);
                let named = || {
                    let name = match path.id() {
                        "" => String::new(),
                        id => format!(" id=\"{}\"", id.chars().take(40).collect::<String>()),
                    };
                    format!("stroked shape {number}{name}, stroke {colour}")
                };
                let lines = lines(path, place);
                let mut curves = lines.pieces.iter().filter_map(|piece| match piece {
                    Piece::Curve(curve) => Some(curve),
                    Piece::Line(_) => None,
                });
                if let Some(curve) = curves.next().filter(|_| kind.letter().is_hinge()) {
                    let found = curve.in_words(|at| [at.x, 0.0 - at.y]);
                    return Err((named(), STRAIGHT_CREASE.into(), found));
                }
                total += lines.pieces.len();
                if total > MAX_LINES {
                    return Err((named(), format!("at most {MAX_LINES} lines"), "more".into()));
                }
                strokes.push(Stroke {
                    kind,
                    names: [path.id(), outer],
                    colour,
                    opacity: opacity * alpha * decimal(stroke.opacity().get()),
                    dashed,
                    lines,
                });
            }
            _ => {}
        }
    }
    Ok(strokes)
}

/// Returns the lines of a path.
fn lines(path: &usvg::Path, place: Affine) -> Lines {
    let Affine([[sx, kx, tx], [ky, sy, ty]]) = place;
    let point = |p: usvg::tiny_skia_path::Point| {
        let [x, y] = [p.x, p.y].map(decimal);
        Vector2::new(sx * x + kx * y + tx, -(ky * x + sy * y + ty))
    };
    let (mut pieces, mut straightened, mut written) = (Vec::new(), 0, Vec::new());
    let (mut start, mut at) = (Vector2::zeros(), Vector2::zeros());
    for segment in path.data().segments() {
        let (to, between) = match segment {
            PathSegment::MoveTo(p) => {
                written.push([p.x, p.y].map(as_written));
                start = point(p);
                at = start;
                continue;
            }
            PathSegment::LineTo(p) => (point(p), None),
            PathSegment::Close => (start, None),
            PathSegment::QuadTo(a, p) => {
                // The cubic with the same course.
                let [a, p] = [a, p].map(point);
                (p, Some([at, p].map(|end| end + (a - end) * (2.0 / 3.0))))
            }
            PathSegment::CubicTo(a, b, p) => (point(p), Some([a, b].map(point))),
        };
        let curve = between.map(|[a, b]| Curve([at, a, b, to]));
        // Within the rounding of single precision.
        let is_straight = |curve: &Curve| curve.is_straight(1e-6 * at.amax().max(to.amax()));
        straightened += usize::from(curve.as_ref().is_some_and(is_straight));
        match curve.filter(|curve| !is_straight(curve)) {
            Some(curve) => pieces.push(Piece::Curve(curve)),
            None if at != to => pieces.push(Piece::Line([at, to])),
            None => {}
        }
        if let PathSegment::LineTo(p) | PathSegment::QuadTo(_, p) | PathSegment::CubicTo(_, _, p) =
            segment
        {
            written.push([p.x, p.y].map(as_written));
        }
        at = to;
    }
    // The rounding error of a coordinate is that of the largest of its summands.
    let bounds = path.data().bounds();
    let [x, y] = [
        [bounds.left(), bounds.right()],
        [bounds.top(), bounds.bottom()],
    ]
    .map(|[low, high]| decimal(low).abs().max(decimal(high).abs()));
    let parts = [sx * x, kx * y, tx, ky * x, sy * y, ty];
    let largest = parts
        .into_iter()
        .fold(0.0, |most, part: f64| part.abs().max(most));
    Lines {
        pieces,
        straightened,
        rounding: largest * f64::from(f32::EPSILON),
        written,
        scale: (sx * sy - kx * ky).abs().sqrt(),
        turned: kx.abs().max(ky.abs()) > 0.0,
    }
}

/// Returns the number with six digits from which a number in single precision may have come by a few sums, as of relative
/// commands, or else the number itself.
fn as_written(number: f32) -> f64 {
    let exact = f64::from(number);
    let short: f64 = format!("{exact:.5e}").parse().unwrap_or(exact);
    if (short - exact).abs() <= 2.0 * f64::from(f32::EPSILON) * exact.abs() {
        short
    } else {
        decimal(number)
    }
}

/// Returns the shortest decimal that rounds to a single-precision number, which is the number in the file. A plain
/// conversion would turn 0.3333 into 0.33329999446868896.
fn decimal(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::from(number))
}
