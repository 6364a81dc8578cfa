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

mod effort;
mod numbers;

use core::f64::consts::PI;
use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Vector2;
use usvg::tiny_skia_path::PathSegment;
use usvg::{Group, ImageHrefResolver, Node, Options, Paint, Tree, roxmltree};

use super::error::Wrong;
use super::options::{ColourLetter, ColourLetters};
use super::segments::{LooseLines, MOST, Segment, pattern_file};
use super::{FileError, ReadOptions};
use crate::colours::hex;
use crate::pattern::Letter;
use crate::progress::Watch;
use crate::read::fold::PatternFile;

/// Largest number of nodes of the document, as a file may consist of nothing else.
const NODES: u32 = 1 << 21;

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
    let told = |(place, expected, found)| FileError::expected(path, place, expected, found);
    let (tree, mut notes) = check_text(text).and_then(|()| tree(text)).map_err(told)?;
    let strokes = strokes(tree.root(), &options.colours).map_err(told)?;

    for chosen in options.colours.iter() {
        let is_it = |stroke: &Stroke| match stroke.kind {
            Kind::Chosen(_) => stroke.colour == hex(chosen.colour),
            Kind::NearChosen(colour, _) => colour == chosen.colour,
            _ => false,
        };
        if !strokes.iter().any(is_it) {
            notes.push(format!(
                "the colour {} was given the letter {}, but no line has it",
                chosen.name,
                chosen.letter.code()
            ));
        }
    }
    let mut colours: BTreeMap<String, (Kind, usize)> = BTreeMap::new();
    // Opacity is the goal angle of a mountain or valley, unless all of them are opaque or all are transparent.
    let says = |stroke: &Stroke| stroke.kind.letter().sign().abs() > 0.0;
    let angles = strokes.iter().any(|s| says(s) && s.opacity < 1.0)
        && strokes.iter().any(|s| says(s) && s.opacity > 0.0);
    let mut segments = Vec::new();
    for stroke in &strokes {
        let letter = stroke.kind.letter();
        let (_, count) = colours
            .entry(stroke.colour.clone())
            .or_insert((stroke.kind, 0));
        *count += stroke.lines.ends.len();
        let goal = (angles && says(stroke)).then(|| letter.sign() * stroke.opacity * PI);
        segments.extend(
            stroke
                .lines
                .ends
                .iter()
                .map(|&ends| Segment { ends, letter, goal }),
        );
    }
    let straightened: usize = strokes.iter().map(|stroke| stroke.lines.straightened).sum();
    if straightened > 0 {
        notes.push(format!(
            "curves that run straight taken as lines: {straightened}"
        ));
    }
    for (colour, (kind, count)) in colours {
        match kind {
            // Noted, because other programs use green for other purposes than cuts.
            Kind::Exact(Letter::Cut) => {
                notes.push(format!("lines of colour {colour} (green) taken as cuts (C): {count}"));
            }
            Kind::Exact(_) => {}
            Kind::Chosen(letter) => notes.push(format!(
                "lines of colour {colour} taken as {}, the letter that the colour was given: {count}",
                letter.code()
            )),
            Kind::NearChosen(chosen, letter) => notes.push(format!(
                "lines of colour {colour} taken as {} ({}), the nearest of the colours that were given \
                 letters: {count}",
                hex(chosen),
                letter.code()
            )),
            Kind::Near(name, letter) => notes.push(format!(
                "lines of colour {colour} taken as {name} ({}), the nearest hue: {count}",
                letter.code()
            )),
            Kind::Unknown => notes.push(format!(
                "lines of colour {colour}, which is none of red, blue, black, green, yellow and magenta, \
                 taken as U: {count}"
            )),
        }
    }
    if angles {
        notes.push("goal angles from the opacity of strokes, 180 degrees where opaque".into());
    }
    let rounding = strokes.iter().map(|stroke| stroke.lines.rounding);
    let lines = LooseLines {
        segments,
        rounding: rounding.fold(0.0, f64::max),
        y_down: true,
        notes,
    };
    pattern_file(path, lines, options, watch)
}

/// Checks that the text of an XML file asks for a bounded amount of work.
pub(super) fn check_text(text: &str) -> Result<(), Wrong> {
    let wrong = |found| ("the drawing".into(), "less of it".into(), found);
    effort::of_text(text).map_err(wrong)
}

/// Style sheet that spares usvg needless work: only the course of strokes is read.
const UNUSED: &str = "* { fill: none !important; marker: none !important; filter: none !important; \
                      clip-path: none !important; mask: none !important }";

/// Resolves styles, transforms and shapes. Returns the drawing and notes of the elements that are left out.
fn tree(text: &str) -> Result<(Tree, Vec<String>), Wrong> {
    let no_drawing = |place: String, found: String| (place, "an SVG drawing".into(), found);
    let options = roxmltree::ParsingOptions {
        // Illustrator writes a DTD.
        allow_dtd: true,
        nodes_limit: NODES,
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
    effort::of_document(&document).map_err(|found| no_drawing(place(root), found))?;
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
    Ok((tree, notes.collect()))
}

/// Interpretation of a colour.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Exactly one of the simulator's colours.
    Exact(Letter),
    /// Near the colour of that name.
    Near(&'static str, Letter),
    /// Near none of the simulator's colours.
    Unknown,
    /// A colour that the caller gave a letter.
    Chosen(Letter),
    /// A colour with the hue of this one, which the caller gave a letter.
    NearChosen([u8; 3], Letter),
}

/// Index of black among the hues.
const BLACK: usize = 6;

/// Returns the nearest of the six full hues, which are 60 degrees apart, from red: a number below 6. Returns [`BLACK`]
/// for a colour without a channel above 64, and `None` for a colour with less than half of full brightness or half of
/// full saturation.
fn hue([red, green, blue]: [u8; 3]) -> Option<usize> {
    let most = red.max(green).max(blue);
    let chroma = most - red.min(green).min(blue);
    if most <= 64 {
        return Some(BLACK);
    }
    if most < 128 || chroma < most.div_ceil(2) {
        return None;
    }
    let [red, green, blue, full] = [red, green, blue, chroma].map(f64::from);
    // Hue in sixths of a turn from red.
    let hue = if red >= green && red >= blue {
        (green - blue) / full
    } else if green >= blue {
        2.0 + (blue - red) / full
    } else {
        4.0 + (red - green) / full
    };
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 0 to 6"
    )]
    let nearest = (hue + 6.5) as usize % 6;
    Some(nearest)
}

impl Kind {
    fn letter(self) -> Letter {
        match self {
            Self::Exact(letter)
            | Self::Near(_, letter)
            | Self::Chosen(letter)
            | Self::NearChosen(_, letter) => letter,
            Self::Unknown => Letter::Unassigned,
        }
    }

    /// Classifies a colour (0 to 255 for each channel). A colour that was given a letter has it. A colour whose hue is
    /// that of colours that were given letters counts as the nearest of them. Every other colour counts as the nearest of
    /// the simulator's colours; if it has no clear hue, or the hue of cyan, it is unknown.
    fn of(colour: [u8; 3], chosen: &ColourLetters) -> Self {
        if let Some(it) = chosen.iter().find(|it| it.colour == colour) {
            return Self::Chosen(it.letter);
        }
        let Some(nearest) = hue(colour) else {
            return Self::Unknown;
        };
        let far = |it: &ColourLetter| -> u32 {
            let channels = it.colour.iter().zip(colour);
            channels.map(|(a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
        };
        let alike = chosen.iter().filter(|it| hue(it.colour) == Some(nearest));
        if let Some(it) = alike.min_by_key(|it| far(it)) {
            return Self::NearChosen(it.colour, it.letter);
        }
        // In the order of the hues.
        let (name, letter) = match nearest {
            0 => ("red", Letter::Mountain),
            1 => ("yellow", Letter::Flat),
            2 => ("green", Letter::Cut),
            4 => ("blue", Letter::Valley),
            5 => ("magenta", Letter::Unassigned),
            BLACK => ("black", Letter::Boundary),
            _ => return Self::Unknown,
        };
        let full = match nearest {
            BLACK => colour == [0; 3],
            _ => colour.iter().all(|channel| [0, 255].contains(channel)),
        };
        if full {
            Self::Exact(letter)
        } else {
            Self::Near(name, letter)
        }
    }
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
}

/// Returns all strokes in the order in which they are painted.
fn strokes(root: &Group, chosen: &ColourLetters) -> Result<Vec<Stroke>, Wrong> {
    let mut strokes = Vec::new();
    let mut total = 0;
    let mut open: Vec<(&Node, f64)> = Vec::new();
    open.extend(root.children().iter().rev().map(|node| (node, 1.0)));
    let mut number = 0_usize;
    while let Some((node, opacity)) = open.pop() {
        match node {
            Node::Group(group) => {
                let opacity = opacity * decimal(group.opacity().get());
                open.extend(group.children().iter().rev().map(|node| (node, opacity)));
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
                let place = || {
                    let name = match path.id() {
                        "" => String::new(),
                        id => format!(" id=\"{}\"", id.chars().take(40).collect::<String>()),
                    };
                    format!("stroked shape {number}{name}, stroke {colour}")
                };
                let Some(lines) = lines(path) else {
                    return Err((place(), "straight lines alone".into(), "a curve".into()));
                };
                total += lines.ends.len();
                if total > MOST {
                    return Err((place(), format!("at most {MOST} lines"), "more".into()));
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
fn lines(path: &usvg::Path) -> Option<Lines> {
    let t = path.abs_transform();
    let [sx, kx, tx, ky, sy, ty] = [t.sx, t.kx, t.tx, t.ky, t.sy, t.ty].map(decimal);
    let point = |p: usvg::tiny_skia_path::Point| {
        let [x, y] = [p.x, p.y].map(decimal);
        Vector2::new(sx * x + kx * y + tx, -(ky * x + sy * y + ty))
    };
    let (mut ends, mut straightened) = (Vec::new(), 0);
    let (mut start, mut at) = (Vector2::zeros(), Vector2::zeros());
    for segment in path.data().segments() {
        let (to, between) = match segment {
            PathSegment::MoveTo(p) => {
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

/// Returns the shortest decimal that rounds to a single-precision number, which is the number in the file. A plain
/// conversion would turn 0.3333 into 0.33329999446868896.
fn decimal(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::from(number))
}
