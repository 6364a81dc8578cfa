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

mod colour;
mod limits;
mod numbers;
mod viewport;

use core::f64::consts::PI;
use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Vector2;
use usvg::tiny_skia_path::PathSegment;
use usvg::{Group, ImageHrefResolver, Node, Options, Paint, Tree, roxmltree};

use self::colour::Kind;
use self::viewport::{Affine, Viewport};
use super::error::Wrong;
use super::options::{ColourLetter, ColourLetters};
use super::segments::{LooseLines, MAX_LINES, Segment, Written, pattern_file};
use super::{FileError, ReadOptions};
use crate::colours::hex;
use crate::progress::Watch;
use crate::read::fold::PatternFile;

/// Largest number of nodes of the document, as a file may consist of nothing else.
const MAX_NODES: u32 = 1 << 21;

/// Parses a crease pattern from the text of a file.
///
/// # Errors
/// If the text is no SVG, asks for too much work, strokes a curve, or its lines form no crease pattern.
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
        mut notes,
    } = check_text(text)
        .and_then(|()| drawn(text))
        .map_err(&wrong)?;
    let (root, place) = viewport.content(tree.root());
    let strokes = strokes(root, place, &options.colours).map_err(&wrong)?;
    notes.extend(colours_without_lines(&strokes, &options.colours));
    let mut colours: BTreeMap<&str, (Kind, usize)> = BTreeMap::new();
    for Stroke {
        colour,
        kind,
        lines,
        ..
    } in &strokes
    {
        let (_, count) = colours.entry(colour).or_insert((*kind, 0));
        *count += lines.ends.len();
    }
    let straightened: usize = strokes.iter().map(|stroke| stroke.lines.straightened).sum();
    if straightened > 0 {
        notes.push(format!(
            "curves that run straight taken as lines: {straightened}"
        ));
    }
    let colours = colours.into_iter();
    notes.extend(colours.filter_map(|(colour, (kind, count))| kind.note(colour, count)));
    // Opacity is the goal angle of a mountain or valley, unless all of them are opaque or all are transparent.
    let is_folded = |stroke: &Stroke| stroke.kind.letter().sign().abs() > 0.0;
    let has_angles = strokes.iter().any(|s| is_folded(s) && s.opacity < 1.0)
        && strokes.iter().any(|s| is_folded(s) && s.opacity > 0.0);
    if has_angles {
        notes.push("goal angles from the opacity of strokes, 180 degrees where opaque".into());
    }
    let segments = strokes.iter().flat_map(|stroke| {
        let letter = stroke.kind.letter();
        let is_angle = has_angles && is_folded(stroke);
        let goal = is_angle.then(|| letter.sign() * stroke.opacity * PI);
        let ends = stroke.lines.ends.iter();
        ends.map(move |&ends| Segment { ends, letter, goal })
    });
    let rounding = strokes.iter().map(|stroke| stroke.lines.rounding);
    let written = strokes.iter().flat_map(|stroke| &stroke.lines.written);
    let scales = strokes.iter().map(|stroke| stroke.lines.scale);
    let lines = LooseLines {
        segments: segments.collect(),
        rounding: rounding.fold(0.0, f64::max),
        written: Some(Written {
            points: written.copied().collect(),
            scale: scales.fold(0.0, f64::max),
            turned: strokes.iter().any(|stroke| stroke.lines.turned),
        }),
        y_down: true,
        unit: viewport.unit,
        notes,
    };
    pattern_file(path, lines, options, watch)
}

/// Notes the colours that were given letters although no line has them.
fn colours_without_lines(strokes: &[Stroke], chosen: &ColourLetters) -> Vec<String> {
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
    /// Notes of the elements that are left out.
    notes: Vec<String>,
}

/// Resolves styles, transforms and shapes.
fn drawn(text: &str) -> Result<Drawn, Wrong> {
    let no_drawing = |place: String, found: String| (place, "an SVG drawing".into(), found);
    let options = roxmltree::ParsingOptions {
        // Illustrator writes a DTD.
        allow_dtd: true,
        nodes_limit: MAX_NODES,
        ..Default::default()
    };
    let document = roxmltree::Document::parse_with_options(text, options).map_err(|error| {
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
    let options = Options {
        // No other file is opened.
        image_href_resolver: ImageHrefResolver {
            resolve_data: Box::new(|_, _, _| None),
            resolve_string: Box::new(|_, _| None),
        },
        style_sheet: Some(UNUSED.into()),
        ..Default::default()
    };
    let tree = Tree::from_xmltree(&document, &options);
    let tree = tree.map_err(|error| no_drawing(place(root), error.to_string()))?;
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
        notes: notes.collect(),
    })
}

/// The lines of one stroked path.
struct Stroke {
    kind: Kind,
    /// The colour as #rrggbb, or a description of another paint.
    colour: String,
    /// 0 to 1.
    opacity: f64,
    lines: Lines,
}

/// The straight lines of a path on the sheet, y pointing up.
struct Lines {
    ends: Vec<[Vector2<f64>; 2]>,
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
fn strokes(root: &Group, place: Affine, chosen: &ColourLetters) -> Result<Vec<Stroke>, Wrong> {
    let mut strokes = Vec::new();
    let mut total = 0;
    let mut open: Vec<(&Node, f64, Affine)> = Vec::new();
    open.extend(root.children().iter().rev().map(|node| (node, 1.0, place)));
    let mut number = 0_usize;
    while let Some((node, opacity, place)) = open.pop() {
        match node {
            Node::Group(group) => {
                let opacity = opacity * decimal(group.opacity().get());
                let place = place.after(group.transform());
                let children = group.children().iter().rev();
                open.extend(children.map(|node| (node, opacity, place)));
            }
            Node::Path(path) if path.is_visible() => {
                let Some(stroke) = path.stroke() else {
                    continue;
                };
                number += 1;
                let (kind, colour) = match stroke.paint() {
                    Paint::Color(c) => (
                        Kind::of([c.red, c.green, c.blue], chosen),
                        hex([c.red, c.green, c.blue]),
                    ),
                    _ => (Kind::Unknown, "gradient or pattern".into()),
                };
                let named = || {
                    let name = match path.id() {
                        "" => String::new(),
                        id => format!(" id=\"{}\"", id.chars().take(40).collect::<String>()),
                    };
                    format!("stroked shape {number}{name}, stroke {colour}")
                };
                let Some(lines) = lines(path, place) else {
                    return Err((named(), "straight lines alone".into(), "a curve".into()));
                };
                total += lines.ends.len();
                if total > MAX_LINES {
                    return Err((named(), format!("at most {MAX_LINES} lines"), "more".into()));
                }
                strokes.push(Stroke {
                    kind,
                    colour,
                    opacity: opacity * decimal(stroke.opacity().get()),
                    lines,
                });
            }
            _ => {}
        }
    }
    Ok(strokes)
}

/// Returns the lines of a path, or `None` if a curve of the path is not straight.
fn lines(path: &usvg::Path, place: Affine) -> Option<Lines> {
    let Affine([[sx, kx, tx], [ky, sy, ty]]) = place;
    let point = |p: usvg::tiny_skia_path::Point| {
        let [x, y] = [p.x, p.y].map(decimal);
        Vector2::new(sx * x + kx * y + tx, -(ky * x + sy * y + ty))
    };
    let (mut ends, mut straightened, mut written) = (Vec::new(), 0, Vec::new());
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
            PathSegment::QuadTo(a, p) => (point(p), Some([a, a])),
            PathSegment::CubicTo(a, b, p) => (point(p), Some([a, b])),
        };
        if let Some(controls) = between {
            if !is_straight([at, to], controls.map(point)) {
                return None;
            }
            straightened += 1;
        }
        if at != to {
            ends.push([at, to]);
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
    Some(Lines {
        ends,
        straightened,
        rounding: largest * f64::from(f32::EPSILON),
        written,
        scale: (sx * sy - kx * ky).abs().sqrt(),
        turned: kx.abs().max(ky.abs()) > 0.0,
    })
}

/// Returns `true` if a curve with these control points is the line between its ends, within the rounding of single
/// precision.
fn is_straight([from, to]: [Vector2<f64>; 2], controls: [Vector2<f64>; 2]) -> bool {
    let rounding = 1e-6 * from.amax().max(to.amax());
    let length = (to - from).norm();
    let along = (to - from) / length.max(f64::MIN_POSITIVE);
    controls.iter().all(|control| {
        let offset = control - from;
        let part = offset.dot(&along);
        offset.perp(&along).abs() <= rounding
            && (offset - along * part).norm() <= rounding
            && part >= -rounding
            && part <= length + rounding
    })
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
