//! Replaces the labels of an SVG picture by outlines from a font of the system.
//!
//! Characters are set one after the other by their advance widths: no kerning, no ligatures, no right-to-left scripts.

use core::fmt::Write;
use std::path::{Path, PathBuf};

use resvg::usvg::roxmltree::{Document, Node};
use ttf_parser::{Face, OutlineBuilder};

/// Folders in which Linux, macOS and Windows keep fonts; folders that begin with `~` are in the user's own folder.
const FOLDERS: [&str; 8] = [
    "/usr/share/fonts",
    "/usr/local/share/fonts",
    "~/.local/share/fonts",
    "~/.fonts",
    "/System/Library/Fonts",
    "/Library/Fonts",
    "~/Library/Fonts",
    "C:\\Windows\\Fonts",
];
/// Number of levels of subfolders that are searched.
const MAX_DEPTH: usize = 5;
/// File name endings of font files that can be read.
const ENDINGS: [&str; 3] = ["ttf", "otf", "ttc"];
/// Words in the names of fonts that are not meant for plain text.
const SPECIAL: [&str; 8] = [
    "bold",
    "oblique",
    "italic",
    "mono",
    "condensed",
    "light",
    "emoji",
    "symbol",
];
/// Height of a lower-case letter over the size of the font, used if the font does not state it. CSS falls back to this
/// value.
const X_HEIGHT_RATIO: f64 = 0.5;

/// Bytes of a font file.
pub(crate) struct Font(Vec<u8>);

impl Font {
    /// Reads a font of this system: a plain sans-serif font if there is one, or else the first font that can be read.
    pub(crate) fn of_system() -> Option<Self> {
        let mut files = Vec::new();
        for folder in FOLDERS {
            let folder = match folder.strip_prefix("~/") {
                Some(rest) => std::env::home_dir().map(|home| home.join(rest)),
                None => Some(PathBuf::from(folder)),
            };
            if let Some(folder) = folder {
                find(&folder, MAX_DEPTH, &mut files);
            }
        }
        files.sort_by_cached_key(|file| (rank(file), file.clone()));
        files.iter().find_map(|file| {
            let bytes = std::fs::read(file).ok()?;
            let face = Face::parse(&bytes, 0).ok()?;
            face.glyph_index('0')?;
            Some(Self(bytes))
        })
    }
}

/// Collects the font files in a folder and in `depth` levels of subfolders.
fn find(folder: &Path, depth: usize, files: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let path = entry.path();
        if path.is_dir() {
            if depth > 0 {
                find(&path, depth - 1, files);
            }
        } else if path.extension().is_some_and(|ending| {
            let fits = |known: &str| ending.eq_ignore_ascii_case(known);
            ENDINGS.iter().any(|known| fits(known))
        }) {
            files.push(path);
        }
    }
}

/// Returns how far a font file is from plain sans-serif, by its name: less is better.
fn rank(file: &Path) -> usize {
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let name = name.to_lowercase();
    let special = SPECIAL.iter().filter(|word| name.contains(*word)).count();
    let sans = ["sans", "arial", "helvetica"];
    let serif = !sans.iter().any(|word| name.contains(word));
    2 * special + usize::from(serif)
}

/// Returns the picture with every `<text>` replaced by its outline; `None` if the picture is no SVG.
pub(crate) fn outlined(svg: &str, font: &Font) -> Option<String> {
    let document = Document::parse(svg).ok()?;
    let face = Face::parse(&font.0, 0).ok()?;
    let mut outlined = String::with_capacity(svg.len());
    let mut rest = 0;
    let texts = document.descendants().filter(|n| n.has_tag_name("text"));
    for node in texts {
        let range = node.range();
        outlined += &svg[rest..range.start];
        outline(&node, &face, &mut outlined);
        rest = range.end;
    }
    outlined += &svg[rest..];
    Some(outlined)
}

/// Writes the outline of one `<text>`, with the position, anchor, size, colour and rotation that the element has.
fn outline(text: &Node<'_, '_>, face: &Face<'_>, out: &mut String) {
    let number = |name| text.attribute(name).and_then(|n| n.parse::<f64>().ok());
    let size = number("font-size").unwrap_or(16.0);
    let em = f64::from(face.units_per_em());
    let scale = size / em;
    let x_height = face.x_height().map_or(X_HEIGHT_RATIO * em, f64::from);
    let label = text.text().unwrap_or_default().trim();
    let glyphs: Vec<_> = label
        .chars()
        .map(|letter| face.glyph_index(letter).unwrap_or_default())
        .collect();
    let advance = |glyph| f64::from(face.glyph_hor_advance(glyph).unwrap_or_default());
    let width: f64 = glyphs.iter().map(|&glyph| advance(glyph)).sum();
    let anchor = match text.attribute("text-anchor") {
        Some("middle") => 0.5,
        Some("end") => 1.0,
        _ => 0.0,
    };
    let shift = text.attribute("dy").map_or(0.0, |shift| {
        let unit =
            |ending, length: f64| Some(shift.strip_suffix(ending)?.parse::<f64>().ok()? * length);
        let plain = shift.parse().ok();
        (unit("em", size).or_else(|| unit("ex", x_height * scale)))
            .or(plain)
            .unwrap_or(0.0)
    });
    let mut path = Outline {
        data: String::new(),
        scale,
        x: number("x").unwrap_or(0.0) - anchor * width * scale,
        y: number("y").unwrap_or(0.0) + shift,
    };
    for glyph in glyphs {
        face.outline_glyph(glyph, &mut path);
        path.x += advance(glyph) * scale;
    }
    let attribute = |name, usual| text.attribute(name).unwrap_or(usual);
    // Writing to a `String` does not fail.
    let _written = write!(
        out,
        r#"<path d="{}" fill="{}" opacity="{}" transform="{}"/>"#,
        path.data,
        attribute("fill", "black"),
        attribute("opacity", "1"),
        attribute("transform", "translate(0)"),
    );
}

/// SVG path data of glyphs. Each glyph is scaled from font units, turned from y upwards to y downwards, and set at (x,
/// y).
struct Outline {
    data: String,
    scale: f64,
    x: f64,
    y: f64,
}

impl Outline {
    fn push(&mut self, command: char, points: &[[f32; 2]]) {
        self.data.push(command);
        for [x, y] in points.iter().map(|point| point.map(f64::from)) {
            let (x, y) = (self.x + self.scale * x, self.y - self.scale * y);
            let _written = write!(self.data, " {x:.3} {y:.3}");
        }
    }
}

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        self.push('M', &[[x, y]]);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.push('L', &[[x, y]]);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.push('Q', &[[x1, y1], [x, y]]);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.push('C', &[[x1, y1], [x2, y2], [x, y]]);
    }

    fn close(&mut self) {
        self.data.push('Z');
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_sans_serif_comes_first() {
        let mut files: Vec<_> = [
            "Serif.ttf",
            "Sans-Bold.ttf",
            "EmojiSans.ttf",
            "DejaVuSans.ttf",
        ]
        .map(PathBuf::from)
        .into();
        files.sort_by_cached_key(|file| (rank(file), file.clone()));
        assert_eq!(files[0], Path::new("DejaVuSans.ttf"));
        assert_eq!(files[1], Path::new("Serif.ttf"));
    }

    #[test]
    fn labels_stand_where_the_text_is_anchored() {
        let font = Font::of_system().expect("tests/run installs one");
        // Left and right ends of the path of the label "0".
        let ends = |anchor: &str| {
            let svg = format!(
                r#"<svg><text x="100" y="50" text-anchor="{anchor}" font-size="20">0</text><g/></svg>"#
            );
            let outlined = outlined(&svg, &font).unwrap();
            assert!(
                outlined.ends_with("<g/></svg>") && !outlined.contains("text"),
                "{outlined}"
            );
            let data = outlined
                .split("d=\"")
                .nth(1)
                .unwrap()
                .split('"')
                .next()
                .unwrap();
            let numbers = data.split(|c: char| c.is_ascii_alphabetic() || c == ' ');
            let numbers: Vec<f64> = numbers.filter_map(|n| n.parse().ok()).collect();
            let across = numbers.iter().step_by(2).copied();
            let up: Vec<f64> = numbers.iter().skip(1).step_by(2).copied().collect();
            assert!(up.iter().all(|y| (30.0..55.0).contains(y)), "{up:?}");
            [
                across.clone().fold(f64::INFINITY, f64::min),
                across.fold(0.0, f64::max),
            ]
        };
        let [start, middle, end] = ["start", "middle", "end"].map(ends);
        assert!(100.0 <= start[0] && start[1] < 120.0, "{start:?}");
        assert!((middle[0] + middle[1] - 200.0).abs() < 4.0, "{middle:?}");
        assert!(80.0 < end[0] && end[1] <= 100.0, "{end:?}");
    }
}
